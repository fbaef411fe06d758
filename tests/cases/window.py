#!/usr/bin/python3
"""The window that follows a body, in whole runs: the same bits, an endless ocean, a start that is refused.

Scenes are put together here, at a spacing of 0.05 m; each solver makes its own rest state.
"""

import csv

import h5py
import numpy as np

import case as c

METHODS = {"dfsph": (), "pcisph": ("solver.method=pcisph", "fluid.viscosity.model=artificial"),
           "wcsph": ("solver.method=wcsph", "fluid.viscosity.model=artificial", "time_step.control=global")}
SHAPES = {"cylinder": "cylinder: {base: [0, 0, 0], axis: [0, 0, 1], radius: 0.8, length: %g}",
          "box": "box: {min: [-0.8, -0.8, 0], max: [0.8, 0.8, %g]}",
          "revolution": "revolution: {profile: [[0, 0], [0.8, 0], [%g, %g], [0, %g]]}"}


def tile(case, method):
    """A rest state of that solver, whose damped steps have no control."""
    return case.rest_state(method, [setting for setting in METHODS[method] if "time_step" not in setting])


def sea(case, method="dfsph", shape="cylinder", force="[12, 5, 0]"):
    """A box that is pushed over water 0.3 m deep, in a window that absorbs."""
    forms = {"cylinder": (SHAPES["cylinder"] % 0.3, SHAPES["cylinder"] % 0.7, "top"), "box": (SHAPES["box"] % 0.3, SHAPES["box"] % 0.7, "+z"),
             "revolution": (SHAPES["revolution"] % (0.95, 0.3, 0.3), SHAPES["revolution"] % (1.15, 0.7, 0.7), None)}
    water, wall, top = forms[shape]
    return case.write(f"sea_{method}_{shape}", f"""
particle_spacing: 0.05
end_time: 3
fluid: {{blocks: [{{{water}, rest_state: {tile(case, method)}, rest_offset: [0.01, 0.02, 0.03]}}]}}
boundary: {{walls: [{{name: sea, {wall}, inside: fluid{f', open: ["{top}"]' if top else ''}}}]}}
bodies:
  - name: raft
    box: {{min: [-0.15, -0.1, 0.25], max: [0.15, 0.1, 0.37]}}
    density: 500
    locked: [yaw]
    forces: [{{force: {force}, at: [0, 0, 0.3]}}]
window: {{follow: raft, wall: sea, trigger: 0.6, new_distance: 1}}
absorption: [{{wall: sea, ocean_height: 0.3}}]
output: {{snapshots: {{every: 1}}, gauges_every: 0.05, gauges: [{{name: raft, type: body, body: raft}}, {{name: H, type: height, at: [0.4, 0]}}]}}
""")


def windows(output):
    """The steps in which it went along."""
    return [int(row["step"]) for row in c.steps(output) if "window" in row["event"].split("+")]


def bits(case, steps):
    """Ranks, rebalances and the place in the world change nothing, with any solver and shape, nor does a window that is taken back."""
    told = []
    for method, shape in (("dfsph", "cylinder"), ("pcisph", "box"), ("wcsph", "revolution")):
        scene = sea(case, method, shape)
        settings = (*METHODS[method], f"end_time={2.2 if method == 'dfsph' else 0.9}")
        plain = case.same_everywhere(scene, method, settings, (2, 3, 4, 7) if method == "dfsph" else (3,), 29)
        gone = windows(plain)
        c.expect(len(gone) >= (10 if method == "dfsph" else 2), f"{method}: the window went along in steps {gone}")
        if method == "pcisph":  # the step in which it goes along is taken back
            shock = (*settings, f"faults.shock_at={gone[1] - 1}")
            options = ["--steps", gone[1] + 20]
            runs = [case.run(scene, f"shock_{ranks}", ranks, shock, options) for ranks in (1, 3)]
            case.same(*runs)
            c.expect(any("rollback" in row["event"] for row in c.steps(runs[0])), "no step was taken back")
        told.append(f"{method}, a {shape}, {len(gone)} times")
    return "; ".join(told)


def restart(case, steps):
    """Stopped before, as and behind the window goes along, and gone on with on other ranks: the same bytes."""
    told = []
    for method, shape in (("dfsph", "cylinder"), ("pcisph", "box")):
        scene, settings = sea(case, method, shape), (*METHODS[method], f"end_time={1.4 if method == 'dfsph' else 0.7}")
        whole = case.run(scene, f"{method}_whole", 2, settings)
        gone = windows(whole)
        for ranks, stop in ((3, gone[1] - 1), (1, gone[1]), (4, (gone[1] + gone[2]) // 2)):
            case.goes_on(scene, whole, method, stop, ranks, settings)
        told.append(f"{method}: around step {gone[1]} and between {gone[1]} and {gone[2]}")
    return "; ".join(told)


def endless(case, steps):
    """The water neither grows nor shrinks, its level stays, and the raft goes on steadily."""
    told = []
    for shape in SHAPES:
        output = case.run(sea(case, shape=shape, force="[14, 0, 0]"), f"endless_{shape}", 1, ("end_time=6", "output.snapshots.every=6"))
        rows = c.steps(output)
        count = [int(row["fluid_particles"]) for row in rows]
        late, before = (np.mean(part) for part in (count[-300:], count[-600:-300]))
        # water comes in half a spacing below the ocean's height, a twelfth of this depth
        c.expect(abs(late / count[0] - 1) < 0.06, f"{shape}: {count[0]} particles, at last {late:.0f}")
        c.expect(abs(late / before - 1) < 0.01, f"{shape}: {before:.0f} particles, then {late:.0f}")
        c.expect(len(windows(output)) > 20, f"{shape}: the window went along {len(windows(output))} times")
        with open(output / "gauges.csv", encoding="utf-8", newline="") as file:
            speed = np.array([float(row["raft_vx"]) for row in csv.DictReader(file)])
        late, before = speed[-20:].mean(), speed[-60:-40].mean()
        c.expect(abs(late / before - 1) < 0.2, f"{shape}: {before} and {late} m/s")
        with h5py.File(c.snapshots(output)[-1]) as file:
            at, ids = file["VTKHDF/Points"][:], file["VTKHDF/PointData/id"][:]
        water = at[ids.astype(np.uint64) >> 60 == 0]
        top = [np.percentile(water[np.abs(np.hypot(*(water[:, :2] - water[:, :2].mean(axis=0)).T) - r) < 0.1][:, 2], 98) for r in (0.3, 0.65)]
        c.expect(0.24 < min(top) and max(top) < 0.34, f"{shape}: the water stands at {top} m")
        told.append(f"{shape}: {len(windows(output))} times, {count[0]} to {count[-1]} particles, {late:.3f} m/s")
    return "; ".join(told)


def refused(case, steps):
    """What cannot work is said, with its place."""
    scene = sea(case)
    for settings, said in ((("window.follow=nobody",), "window.follow must be the name of a body"),
                                 (("window.wall=nobody",), "window.wall must be the name of the scene's only wall"),
                                 (("window.trigger=9",), "must be farther than"),
                                 (("gravity=[0, -7, -7]",), "unless gravity acts along one axis"),
                                 (("fluid.blocks=[{box: {min: [-0.3, -0.3, 0], max: [0.3, 0.3, 0.2]}}]",), "unless a rest_state fills every block"),
                                 (("boundary.walls[0].inside=solid",), "must be a container"),
                                 (("particle_spacing=0.04",), "spacing")):
        answer = case.call(["run", scene, "-o", case.folder / "refused", "--quiet", "--force", *c.words(settings)], 2, expected=2)
        c.expect(said in answer, f"{settings} is answered by: {answer}")
    return "seven settings"


if __name__ == "__main__":
    c.main(__doc__, {"bits": bits, "restart": restart, "endless": endless, "refused": refused})
