#!/usr/bin/python3
"""Rigid bodies in whole runs: the same bits, Archimedes, momentum, contact, what is refused.

Scenes are put together here; bodies.yaml has something of everything.
"""

import csv
import math

import case as c

SCENE = "tests/cases/bodies.yaml"


def compare(case, one, other):
    for name in ("steps.csv", "gauges.csv"):
        c.expect_same_text(one / name, other / name)
    ours, theirs = c.snapshots(one), c.snapshots(other)
    c.expect([p.name for p in ours] == [p.name for p in theirs], f"snapshots {ours} and {theirs}")
    for left, right in zip(ours, theirs):
        case.diff(left, right)


def gauges(output):
    with open(output / "gauges.csv", encoding="utf-8", newline="") as file:
        return [{name: float(value) for name, value in row.items()} for row in csv.DictReader(file)]


METHODS = {"dfsph": (), "pcisph": ("solver.method=pcisph", "fluid.viscosity.model=artificial"),
           "wcsph": ("solver.method=wcsph", "fluid.viscosity.model=artificial")}


def bits(case, steps):
    """Ranks, rebalances and the place in the world change nothing, with any solver."""
    for name, method in METHODS.items():
        options = ["--steps", steps or (150 if name == "wcsph" else 60)]
        plain = case.run(SCENE, f"{name}_plain", 1, (*method, "parallel.rebalance=none"), options)
        for ranks in (2, 3, 4, 7) if name == "dfsph" else (3,):
            settings = (*method, f"parallel.rebalance_every={ranks + 4}",
                        f"parallel.decomposition={'metis' if ranks % 2 else 'slabs'}")
            forced = case.run(SCENE, f"{name}_{ranks}", ranks, settings, options)
            c.expect("rebalance" in (forced / "load.csv").read_text(encoding="utf-8"), f"{forced}: no rebalance")
            compare(case, plain, forced)
        far = case.run(SCENE, f"{name}_far", 2, (*method, "origin_cells=[1000000,0,-1000000]"), options)
        for text in ("steps.csv", "gauges.csv"):
            c.expect_same_text(plain / text, far / text)
    shock = [case.run(SCENE, f"shock_{ranks}", ranks, (*METHODS["pcisph"], "faults.shock_at=20"), ["--steps", 40]) for ranks in (1, 3)]
    compare(case, *shock)
    c.expect(any("rollback" in row["event"] for row in c.steps(shock[0])), "no step was taken back")
    return f"{', '.join(METHODS)}: the same on 1 to 7 ranks, with rebalances, a rollback, and far away"


def restart(case, steps):
    """Stopped in the midst of falls and contacts, on other ranks."""
    for name, method in METHODS.items():
        whole = case.run(SCENE, f"{name}_whole", 2, (*method, "end_time=0.3"))
        output = case.folder / f"{name}_stopped"
        start = ["run", c.SOURCE / SCENE, "-o", output, "--quiet", "--set", "end_time=0.3"]
        for setting in method:
            start += ["--set", setting]
        half = len(c.steps(whole)) // 2
        case.call([*start, "--steps", half], 3)
        case.call([*start, "--restart"], 1)
        compare(case, whole, output)
    return f"{', '.join(METHODS)}: stopped half-way on 3 ranks, gone on with on 1: the same bytes"


def write(case, name, text):
    path = case.folder / f"{name}.yaml"
    path.write_text(text, encoding="utf-8")
    return path


def momentum(case, steps):
    """A body thrown through a block of water in empty space: what the one loses the other gains."""
    scene = write(case, "momentum", """
particle_spacing: 0.03
gravity: [0, 0, 0]
end_time: 0.3
fluid: {blocks: [{box: {min: [0, 0, 0], max: [0.6, 0.6, 0.6]}}]}
bodies: [{name: ball, sphere: {center: [0.3, 0.3, 0.9], radius: 0.12}, density: 500, velocity: [0.4, 0, -3], angular_velocity: [5, 0, 0]}]
output: {gauges_every: 0.01, gauges: [{name: ball, type: body, body: ball}], snapshots: {every: 0.1, fields: [velocity]}}
""")
    told = []
    for name, method, bound in (("dfsph", (), 1e-5), ("pcisph", ("solver.method=pcisph",), 1e-5),
                                ("wcsph", ("solver.method=wcsph", "fluid.viscosity={model: artificial, coefficient: 0.1}",
                                           "solver.sound_speed=40"), 1e-5)):
        output = case.run(scene, f"momentum_{name}", 2, method)
        import h5py
        import numpy as np
        ends = []
        rows = gauges(output)
        for path, row in ((c.snapshots(output)[0], rows[0]), (c.snapshots(output)[-1], rows[-1])):
            with h5py.File(path, "r") as file:
                velocity = file["VTKHDF/PointData/velocity"][:][file["VTKHDF/PointData/kind"][:] == 0]
                mass = float(file["Halocline"].attrs["particle_mass"])
            ball = 500 * 4 / 3 * math.pi * 0.12**3
            ends.append(mass * velocity.astype(float).sum(axis=0) + ball * np.array([row[f"ball_v{a}"] for a in "xyz"]))
        scale = ball * 3
        error = float(np.abs(ends[1] - ends[0]).max() / scale)
        stopped = 1 - rows[-1]["ball_vz"] / -3
        c.expect(stopped > 0.2, f"{name}: the ball kept {1 - stopped} of its speed")
        c.expect(error < bound, f"{name}: momentum is off by {error} of the ball's")
        told.append(f"{name} {error:.1e}")
    return "total momentum changes by, of the ball's: " + ", ".join(told)


CASES = {"bits": bits, "restart": restart, "momentum": momentum}

if __name__ == "__main__":
    c.main(__doc__, CASES)
