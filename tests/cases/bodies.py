#!/usr/bin/python3
"""Rigid bodies in whole runs: the same bits, Archimedes, momentum, contact, what is refused.

Scenes are put together here; bodies.yaml has something of everything.
"""

import csv
import math
import shutil
import subprocess

import h5py
import numpy as np
from PIL import Image

import case as c

SCENE = "tests/cases/bodies.yaml"


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
            case.same(plain, forced)
        far = case.run(SCENE, f"{name}_far", 2, (*method, "origin_cells=[1000000,0,-1000000]"), options)
        for text in ("steps.csv", "gauges.csv"):
            c.expect_same_text(plain / text, far / text)
    shock = [case.run(SCENE, f"shock_{ranks}", ranks, (*METHODS["pcisph"], "faults.shock_at=20"), ["--steps", 40]) for ranks in (1, 3)]
    case.same(*shock)
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
        case.same(whole, output)
    return f"{', '.join(METHODS)}: stopped half-way on 3 ranks, gone on with on 1: the same bytes"


def momentum(case, steps):
    """A body thrown through a block of water in empty space: what the one loses the other gains."""
    scene = case.write("momentum", """
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


def draft(case, steps):
    """A flat box floats as deep as Archimedes says, and a lighter one does not blow up."""
    told = []
    for ratio, method in ((0.5, "dfsph"), (0.1, "dfsph"), (0.8, "pcisph"), (0.5, "wcsph"), (0.1, "wcsph"), (0.2, "pcisph")):
        spacing, height, bottom = 0.025, 0.1, 0.2 - ratio * 0.1
        scene = case.write(f"draft_{ratio}_{method}", f"""
particle_spacing: {spacing}
gravity: [0, 0, -9.81]
end_time: 1.5
fluid: {{viscosity: {{model: artificial, coefficient: 0.1}}, blocks: [{{box: {{min: [0, 0, 0], max: [0.6, 0.6, 0.2]}}}}]}}
boundary: {{walls: [{{box: {{min: [0, 0, 0], max: [0.6, 0.6, 0.5]}}, inside: fluid, open: [+z]}}]}}
bodies: [{{name: box, box: {{min: [0.15, 0.15, {bottom}], max: [0.45, 0.45, {bottom + height}]}}, density: {1000 * ratio}}}]
solver: {{method: {method}}}
output:
  gauges_every: 0.02
  gauges: [{{name: box, type: body, body: box}}, {{name: H, type: height, at: [0.08, 0.3]}}, {{name: G, type: height, at: [0.52, 0.3]}}]
""")
        rows = [row for row in gauges(case.run(scene, f"draft_{ratio}_{method}", 2)) if row["time"] > 1]
        mean = {name: sum(row[name] for row in rows) / len(rows) for name in rows[0]}
        deep = (mean["H"] + mean["G"]) / 2 - mean["box_z"] + height / 2
        weight = 1000 * ratio * 0.3 * 0.3 * height * 9.81
        off = (deep - ratio * height) / spacing
        c.expect(abs(off) < 0.25 + 0.01 * height / spacing, f"{method}, {ratio}: {deep} m deep, {off} spacings off")
        c.expect(abs(mean["box_fz"] / weight - 1) < 0.02, f"{method}, {ratio}: the water bears {mean['box_fz']} of {weight} N")
        c.expect(max(abs(row["box_roll"]) + abs(row["box_pitch"]) for row in rows) < 3, f"{method}, {ratio}: it lists")
        told.append(f"{ratio} {method} {off:+.2f}")
    return "drafts off by, in spacings: " + ", ".join(told)


def tiny(case, steps):
    """Bodies of a sample or a few float, with any solver."""
    scene = case.write("tiny", """
particle_spacing: 0.02
gravity: [0, 0, -9.81]
end_time: 0.6
fluid: {viscosity: {model: artificial, coefficient: 0.1}, blocks: [{box: {min: [0, 0, 0], max: [0.4, 0.2, 0.1]}}]}
boundary: {walls: [{box: {min: [0, 0, 0], max: [0.4, 0.2, 0.4]}, inside: fluid, open: [+z]}]}
bodies:
  - {name: a, sphere: {center: [0.1, 0.1, 0.15], radius: 0.0095}, density: 500}
  - {name: b, sphere: {center: [0.2, 0.1, 0.15], radius: 0.015}, density: 300}
  - {name: c, box: {min: [0.29, 0.09, 0.14], max: [0.31, 0.11, 0.16]}, density: 500}
  - {name: d, cylinder: {base: [0.25, 0.15, 0.15], axis: [1, 0, 0], radius: 0.01, length: 0.1}, density: 700}
output: {gauges_every: 0.05, gauges: [{name: a, type: body, body: a}, {name: b, type: body, body: b}, {name: c, type: body, body: c}, {name: d, type: body, body: d}]}
""")
    for name in METHODS:
        last = gauges(case.run(scene, f"tiny_{name}", 2, (f"solver.method={name}",)))[-1]
        for body in "abcd":
            c.expect(0.085 < last[f"{body}_z"] < 0.12, f"{name}: {body} is at {last[f'{body}_z']} m, the water is 0.1 m deep")
    return "four bodies of 1 to 20 samples float"


CUP = """
gravity: [0, 0, -9.81]
fluid: {blocks: [{box: {min: [0, 0, 0], max: [0.1, 0.1, 0.05]}}]}
"""


def stack(case, steps):
    """Three boxes on top of each other stand; one on a slope slides if it is steeper than its friction."""
    scene = case.write("stack", CUP + """
particle_spacing: 0.025
end_time: 1
boundary:
  walls:
    - {box: {min: [0, 0, 0], max: [0.1, 0.1, 0.2]}, inside: fluid, open: [+z]}
    - {plane: {point: [0.8, 0, 0], normal: [0, 0, 1], size: [1, 1]}}
    - {plane: {point: [-1, 0, 0], normal: [0.4, 0, 1], size: [1.5, 1.5]}}
bodies:
  - {name: a, box: {min: [0.6, -0.15, 0], max: [0.9, 0.15, 0.2]}, density: 500}
  - {name: b, box: {min: [0.62, -0.12, 0.2], max: [0.88, 0.12, 0.4]}, density: 800}
  - {name: c, box: {min: [0.65, -0.13, 0.4], max: [0.9, 0.1, 0.55]}, density: 1200}
  - {name: rests, box: {min: [-1.1, 0.1, -0.05], max: [-0.9, 0.3, 0.05]}, position: [-1, 0.2, 0.0539], density: 500, friction: 0.6,
     rotation: {axis: [0, 1, 0], angle: 21.8014}}
  - {name: slides, box: {min: [-1.1, -0.3, -0.05], max: [-0.9, -0.1, 0.05]}, position: [-1, -0.2, 0.0539], density: 500, friction: 0.2,
     rotation: {axis: [0, 1, 0], angle: 21.8014}}
output:
  gauges_every: 0.05
  gauges: [{name: a, type: body, body: a}, {name: b, type: body, body: b}, {name: c, type: body, body: c},
           {name: rests, type: body, body: rests}, {name: slides, type: body, body: slides}]
""")
    rows = gauges(case.run(scene, "stack", 2))
    spacing, told = 0.025, []
    for name in "abc":
        drift = math.dist(*([row[f"{name}_{x}"] for x in "xyz"] for row in (rows[0], rows[-1])))
        speed = max(abs(row[f"{name}_v{x}"]) for row in rows if row["time"] > 0.8 for x in "xyz")
        c.expect(drift < 0.1 * spacing and speed < 1e-3, f"{name} drifts by {drift} m, at {speed} m/s at the end")
        told.append(f"{1e6 * drift:.0f}")
    drift = abs(rows[-1]["rests_x"] - rows[0]["rests_x"])
    c.expect(drift < 0.1 * spacing, f"on a slope of 0.4 a box with a friction of 0.6 goes {drift} m")
    at = next(row for row in rows if row["time"] > 0.3)
    slope = math.atan(0.4)
    pull = 9.81 * (math.sin(slope) - 0.2 * math.cos(slope))
    found = at["slides_vx"] / math.cos(slope) / at["time"]
    c.expect(abs(found / pull - 1) < 0.05, f"with 0.2 it slides at {found} m/s2, not {pull}")
    return f"three boxes drift by {', '.join(told)} um; on a slope one rests, one slides at {found:.3f} m/s2 ({pull:.3f})"


def walls(case, steps):
    """Nothing goes through walls or each other at 10 m/s; a ball bounces as its restitution says."""
    scene = case.write("walls", CUP + """
particle_spacing: 0.025
end_time: 0.5
boundary:
  walls:
    - {box: {min: [0, 0, 0], max: [0.1, 0.1, 0.2]}, inside: fluid, open: [+z]}
    - {box: {min: [-1, -1, -0.5], max: [1, 1, 1]}, inside: fluid}
bodies:
  - {name: a, box: {min: [0.3, 0.3, 0.2], max: [0.5, 0.5, 0.3]}, density: 500, velocity: [10, 3, -4], angular_velocity: [20, 10, 0], restitution: 0.5}
  - {name: b, sphere: {center: [-0.5, -0.7, 0.5], radius: 0.1}, density: 500, velocity: [-10, 0, 0], restitution: 0.8}
  - {name: c, sphere: {center: [-0.5, 0.5, 0], radius: 0.08}, density: 5000, velocity: [0, -10, 0]}
  - {name: d, box: {min: [-0.6, -0.6, -0.2], max: [-0.4, -0.55, 0.2]}, density: 800, velocity: [0, 8, 0]}
  - {name: e, sphere: {center: [0.6, 0, 0.1], radius: 0.08}, density: 500, velocity: [-10, 0, 0]}
output:
  gauges_every: 0.005
  gauges: [{name: a, type: body, body: a}, {name: b, type: body, body: b}, {name: c, type: body, body: c}, {name: d, type: body, body: d}, {name: e, type: body, body: e}]
""")
    rows = gauges(case.run(scene, "walls", 3))
    low, high, slack = (-1, -1, -0.5), (1, 1, 1), 0.005
    for name, reach in (("a", 0.05), ("b", 0.1), ("c", 0.08), ("d", 0.025), ("e", 0.08)):
        for row in rows:
            inside = all(low[k] + reach - slack < row[f"{name}_{x}"] < high[k] - reach + slack for k, x in enumerate("xyz"))
            c.expect(inside, f"{name} is at {[row[f'{name}_{x}'] for x in 'xyz']} at {row['time']} s")
            speed = math.hypot(*(row[f"{name}_v{x}"] for x in "xyz"))
            c.expect(speed < 16, f"{name} has {speed} m/s at {row['time']} s")
    back = max(row["b_vx"] for row in rows if row["time"] < 0.08)
    c.expect(abs(back - 8) < 0.3, f"a ball with a restitution of 0.8 comes back at {back} of 10 m/s")
    behind = next(row for row in rows if row["e_vx"] > -5)
    c.expect(behind["e_x"] > 0.17, f"a ball goes into the cup from behind: {behind['e_x']}")
    return f"five bodies stay in the room; a ball bounces at {back:.2f} of 8 m/s"


BAD = (("  - {name: x, box: {min: [0.1, 0.1, 0.3], max: [0.2, 0.2, 0.4]}}", "must have a density or a mass"),
       ("  - {name: x, box: {min: [0.1, 0.1, 0.3], max: [0.2, 0.2, 0.4]}, density: 500, mass: 1}", "mass must not be given beside density"),
       ("  - {name: x, box: {min: [0.1, 0.1, 0.3], max: [0.2, 0.2, 0.4]}, density: -5}", "density must be > 0"),
       ("  - {name: x, box: {min: [0.1, 0.1, 0.3], max: [0.2, 0.1, 0.4]}, density: 5}", "box.max must be > "),
       ("  - {name: x, sphere: {center: [0.2, 0.2, 0.3], radius: 0.001}, density: 5}", "must have a volume and be about particle_spacing"),
       ("  - {name: x, box: {min: [0.3, 0.1, 0.3], max: [0.5, 0.2, 0.4]}, density: 5}", "must start within the containers"),
       ("  - {name: x, box: {min: [1.3, 0.1, 0.3], max: [1.5, 0.2, 0.4]}, density: 5}", "must start within the containers"),
       ("  - {name: x, box: {min: [0.1, 0.1, 0.3], max: [0.2, 0.2, 0.4]}, density: 5}\n"
        "  - {name: y, box: {min: [0.15, 0.1, 0.3], max: [0.25, 0.2, 0.4]}, density: 5}", 'must not overlap bodies[0] "x"'),
       ("  - {name: x, box: {min: [0.1, 0.1, 0.3], max: [0.2, 0.2, 0.4]}, density: 5}\n"
        "  - {name: x, box: {min: [0.25, 0.1, 0.3], max: [0.35, 0.2, 0.4]}, density: 5}", "name must be the body's own"),
       ("  - {name: tank, box: {min: [0.1, 0.1, 0.3], max: [0.2, 0.2, 0.4]}, density: 5}", "name must be the body's own, not 'tank' like wall 0"),
       ("  - {name: x, mesh: {file: open.obj}, density: 5}", "edge"),
       ("  - {name: x, mesh: {file: none.obj}, density: 5}", "none.obj"),
       ("  - {name: x, plane: {point: [0, 0, 0], normal: [0, 0, 1], size: [1, 1]}, density: 5}", "plane"),
       ("  - {name: x, box: {min: [0.1, 0.1, 0.3], max: [0.2, 0.2, 0.4]}, density: 5, locked: [w]}", "must be one of x, y, z, roll, pitch, yaw"),
       ("  - {name: x, box: {min: [0.1, 0.1, 0.3], max: [0.2, 0.2, 0.4]}, density: 5, moorings: [{anchor: [0, 0, 0]}]}", "stiffness"),
       ("  - {name: x, box: {min: [0.1, 0.1, 0.3], max: [0.2, 0.2, 0.4]}, density: 5, forces: [{force: [1, 0, 0], start: 2, stop: 1}]}", "stop must be > "),
       ("  - {name: x, box: {min: [0.1, 0.1, 0.3], max: [0.2, 0.2, 0.4]}, density: 5, rotation: {axis: [0, 0, 0], angle: 3}}", "rotation.axis must not be zero"),
       ("  - {name: x, box: {min: [0.1, 0.1, 0.3], max: [0.2, 0.2, 0.4]}, density: 500, moorings: [{anchor: [0, 0, 0], stiffness: 1e6}]}", "too stiff for its mass"),
       ("  - {name: y, box: {min: [0.14, 0.14, 0.34], max: [0.17, 0.17, 0.37]}, density: 5}\n"
        "  - {name: x, box: {min: [0.1, 0.1, 0.3], max: [0.2, 0.2, 0.4]}, density: 5}", 'must not overlap bodies[0] "y"'),
       ("  - {name: x, box: {min: [0.1, 0.1, 0.3], max: [0.2, 0.2, 0.4]}, density: 5, gyration: [1, 0, 1]}", "gyration must have three radii > 0, or none"),
       ("  - {name: x, box: {min: [0.1, 0.1, 0.3], max: [0.2, 0.2, 0.4]}, density: 5, restitution: 2}", "restitution must be in [0, 1]"))
TANK = """
particle_spacing: 0.02
end_time: 0.1
fluid: {blocks: [{box: {min: [0, 0, 0], max: [0.4, 0.4, 0.2]}}]}
boundary: {walls: [{name: tank, box: {min: [0, 0, 0], max: [0.4, 0.4, 0.6]}, inside: fluid, open: [+z]}]}
"""
GOOD = "bodies: [{name: x, box: {min: [0.1, 0.1, 0.3], max: [0.2, 0.2, 0.4]}, density: 500}]\n"


LONG = ("domain.periodic=[false, true, false]", "domain.min=[0, 0, 0]", "domain.max=[0, 0.4, 0]", "bodies[0].box.min=[0.02, 0.02, 0.3]", "bodies[0].box.max=[0.38, 0.38, 0.4]", "boundary.walls[0].open=[-y, +y, +z]")


def refused(case, steps):
    """Bad bodies are errors of the scene, on every rank, with their place."""
    (case.folder / "open.obj").write_text("v 0.1 0.1 0.3\nv 0.3 0.1 0.3\nv 0.1 0.3 0.3\nv 0.1 0.1 0.5\nf 1 3 2\nf 1 2 4\nf 1 4 3\n",
                                          encoding="ascii")
    for number, (bodies, message) in enumerate(BAD):
        scene = case.write(f"bad_{number}", TANK + "bodies:\n" + bodies + "\n")
        said = case.call(["check", scene], 1 if number % 4 else 2, expected=2)
        c.expect(message in said, f"{bodies}: no '{message}' in: {said}")
        c.expect(f"bad_{number}.yaml:" in said, f"{bodies}: no place in: {said}")
    good = case.write("good", TANK + GOOD)
    case.call(["check", good])
    for settings, message in ((LONG, "than half the period along y, 0.2 m"),
                              (("boundary.method=ihmsen2010", "solver.method=pcisph"), "must be akinci2012 with bodies"),
                              (("solver.method=wcsph", "time_step.control=individual"), "must not be individual with bodies"),
                              (("output.gauges=[{name: g, type: body, body: y}]",), "must be the name of a body of the scene, not 'y'"),
                              (("output.gauges=[{name: g, type: mooring, body: x}]",), "must be below the number of moorings of 'x', 0")):
        said = case.call(["check", good, *(word for setting in settings for word in ("--set", setting))], expected=2)
        c.expect(message in said, f"{settings}: no '{message}' in: {said}")
    return f"{len(BAD)} bad bodies and 5 settings that do not go with them are refused"


THROWN = """
name: thrown
particle_spacing: 0.05
gravity: [0, 0, -9.81]
end_time: 0.3
domain: {periodic: [true, false, false], min: [0, 0, 0], max: [1.6, 0, 0]}
fluid: {blocks: [{box: {min: [0, 0, 0], max: [1.6, 0.8, 0.1]}}]}
boundary: {walls: [{box: {min: [0, 0, 0], max: [1.6, 0.8, 0.8]}, inside: fluid, open: [-x, +x, +z]}]}
bodies: [{name: ball, sphere: {center: [1.2, 0.4, 0.4], radius: 0.12}, density: 500, velocity: [4, 0, 1]}]
output: {snapshots: {every: 0.05, fields: [velocity]}}
"""


def middle_of(pixels, where):
    """Where in an image what has the colour of bodies is, across and down, as a share of the image."""
    red, blue = pixels[..., 0], pixels[..., 2]
    y, x = np.nonzero((red > blue) & (red - blue < 20) & (red > 60) & (red < 200))
    c.expect(len(x) > 100, f"{where}: no body")
    return np.median(x) / red.shape[1], np.median(y) / red.shape[0]


def middles_of(film):
    """The frames of a film, and where in them bodies are."""
    frames, middles = [], []
    with Image.open(film) as image:
        for k in range(image.n_frames):
            image.seek(k)
            frames.append(np.asarray(image.convert("RGB")).astype(int))
            middles.append(middle_of(frames[-1], f"{film}, frame {k}"))
    return frames, np.array(middles)


def panels_of(picture, told):
    """Where in the two panels of a picture, side by side, what has the colour of bodies is."""
    c.expect(f"{picture}\n" in told and picture.stat().st_size > 20000, f"{picture} is nearly empty, or not named: {told}")
    with Image.open(picture) as image:
        pixels = np.asarray(image.convert("RGB")).astype(int)
    half = pixels.shape[1] // 2
    return np.array([middle_of(pixels[:, k * half:(k + 1) * half], f"{picture}, panel {k}") for k in range(2)])


def plotted(case, _):
    """plot_run makes films of all snapshots, with the same colours and limits, and pictures that follow a body across a seam."""
    output = case.run(case.write("thrown", THROWN), "thrown", 2)

    def draw(code, *options, environment=None):
        done = subprocess.run(["/usr/bin/python3", str(c.SOURCE / "scripts/plot_run"), str(output), *map(str, options)], env=environment,
                              stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, check=False, timeout=300)
        c.expect(done.returncode == code and "Traceback" not in done.stdout, f"plot_run {options}: {done.stdout}")
        return done.stdout

    paths = {}
    for name, options in (("still", ("--view", "top")), ("top", ("--view", "top", "--follow", "ball")), ("behind", ("--view", "behind", "--follow", "ball")),
                          ("side", ("--view", "side", "--follow", "ball", "--width", 0.6, "--fps", 10))):
        film = output / f"{name}.gif"
        c.expect(draw(0, "--movie", film, *options) == f"{film}\n", f"plot_run does not name {film}")
        frames, paths[name] = middles_of(film)
        c.expect(len(frames) == len(c.snapshots(output)), f"{film} has {len(frames)} frames")
        bar = [frame[-55:] for frame in frames]
        c.expect(all((b == bar[0]).all() for b in bar) and len(np.unique(bar[0])) > 20, f"{film}: the colours' bar is not that of all frames")
        c.expect(any((frame != frames[0]).any() for frame in frames[1:]), f"{film}: nothing moves")
    c.expect(np.ptp(paths["still"][:, 0]) > 0.3, f"the ball stays in the middle of a view that stands still: {paths['still']}")
    for name in ("top", "behind", "side"):
        c.expect(np.abs(paths[name][:, 0] - 0.5).max() < 0.02, f"{name}: the ball leaves the middle: {paths[name]}")
    c.expect(np.ptp(paths["side"][:, 1]) > 0.05, f"the view goes up and down with the ball: {paths['side']}")

    film = output / "film.mp4"
    told = draw(2, "--movie", film, environment={"PATH": str(case.folder)})
    c.expect(f"{film} needs ffmpeg" in told and str(film.with_suffix(".gif")) in told and not film.exists(), f"without ffmpeg: {told}")
    if shutil.which("ffmpeg"):
        draw(0, "--movie", film)
        c.expect(film.read_bytes()[4:8] == b"ftyp", f"{film} is no film")
    for message, *options in (("ends with .mp4 or .gif, not film.avi", "--movie", "film.avi"), ("--fps needs --movie", "--fps", 10),
                              ("the run has only ball", "--follow", "nobody"),
                              ("--width needs --follow", "--width", 1),
                              ("--fps must be more than 0", "--movie", output / "a.gif", "--fps", 0),
                              ("there is no folder", "--movie", output / "nowhere/a.gif")):
        c.expect(message in draw(2, *options), f"plot_run {options} does not say: {message}")
    still, top = (panels_of(output / "thrown_top.png", draw(0, "--view", "top", "--panels", 2, *options))
                  for options in ((), ("--follow", "ball")))
    c.expect(np.ptp(still, axis=0).max() > 0.1, f"the ball stays in the middle of panels of a view that stands still: {still}")
    c.expect(np.abs(top[:, 0] - 0.5).max() < 0.02 and np.ptp(top, axis=0).max() < 0.02, f"the ball leaves the middle of the panels: {top}")
    return f"films of {len(frames)} frames, {'with' if shutil.which('ffmpeg') else 'without'} ffmpeg"


CASES = {"bits": bits, "restart": restart, "momentum": momentum, "draft": draft, "tiny": tiny, "stack": stack, "walls": walls, "refused": refused,
         "plotted": plotted}

if __name__ == "__main__":
    c.main(__doc__, CASES)
