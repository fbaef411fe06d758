#!/usr/bin/python3
"""Rest states in whole runs: made, fitted to shapes, walls, bodies and fluid that is there; the same bits; what is refused.

Scenes are put together here, at a spacing of 0.05 m; each solver makes its own rest state.
"""

import csv
import math

import h5py
import numpy as np

import case as c

METHODS = {"dfsph": (), "pcisph": ("solver.method=pcisph", "fluid.viscosity.model=artificial"),
           "wcsph": ("solver.method=wcsph", "fluid.viscosity.model=artificial"),
           "ihmsen": ("solver.method=pcisph", "boundary.method=ihmsen2010")}


def tile(case, method="dfsph"):
    """A rest state of that solver."""
    return case.rest_state(method, METHODS[method])


def made(case, steps):
    """A rest state is the same file on any number of ranks, at rest, and tells of itself."""
    one = tile(case)
    scene = case.folder / "tile.yaml"
    three = case.folder / "three.rest"
    case.call(["rest", scene, "-o", three, "--quiet"], 3)
    c.expect(one.read_bytes() == three.read_bytes(), "the rest states of 1 and 3 ranks differ")
    said = case.call(["info", one])
    c.expect("a rest state" in said and "512 in 0.4 x 0.4 x 0.4 m, periodic along x y z" in said, f"info says {said}")
    c.expect('"content": "rest state"' in case.call(["info", one, "--json"]), "info --json does not say what it is")
    with h5py.File(one) as file:
        facts = dict(file["Halocline"].attrs)
    c.expect(facts["density_max"] < 1.002 and facts["speed_max"] < 0.002, f"{facts} is not at rest")
    c.expect(facts["density_deviation"] > 1e-5, "the rest state is a lattice")
    case.call(["rest", scene, "-o", three, "--quiet"], expected=2)
    case.call(["rest", scene, "-o", three, "--quiet", "--force"])
    said = case.call(["rest", scene, "-o", case.folder / "none/x.rest", "--quiet"], 2, expected=3)
    c.expect("none" in said, f"no folder in: {said}")
    return "512 particles, the same on 1 and 3 ranks"


def everything(case, method="dfsph"):
    """A tank with a ball that floats and a post, filled from a rest state beside a block of a lattice, and again later."""
    state = tile(case, method)
    later = "" if method == "ihmsen" else f"""
    - {{box: {{min: [0.1, 0.1, 0.1], max: [0.45, 0.5, 0.4]}}, rest_state: {state}, rest_offset: [0.01, 0, 0.03], start: 0.03, replaces: true}}"""
    bodies = "" if method == "ihmsen" else """
bodies: [{name: ball, sphere: {center: [0.7, 0.3, 0.42], radius: 0.14}, density: 500}]"""
    return case.write(f"everything_{method}", f"""
particle_spacing: 0.05
end_time: 0.2
fluid:
  blocks:
    - {{box: {{min: [0, 0, 0], max: [0.2, 0.6, 0.4]}}}}
    - {{box: {{min: [0.2, 0, 0], max: [1.2, 0.6, 0.42]}}, rest_state: {state}, rest_offset: [0.02, 0.01, 0.03]}}{later}
boundary:
  walls:
    - {{name: tank, box: {{min: [0, 0, 0], max: [1.2, 0.6, 0.9]}}, inside: fluid, open: [+z]}}
    - {{name: post, cylinder: {{base: [1, 0.3, 0], axis: [0, 0, 1], radius: 0.1, length: 0.6}}, inside: solid}}{bodies}
output: {{snapshots: {{every: 0.02}}, gauges_every: 0.01, checkpoints: {{keep: 9}}, gauges: [{{name: H, type: height, at: [0.5, 0.3]}}]}}
""")


def bits(case, steps):
    """Choosing, coming to rest and 300 steps after it are the same on any ranks, anywhere, with any solver."""
    for method in METHODS:
        scene, settings = everything(case, method), (*METHODS[method], "end_time=2")
        options = ["--steps", steps or (300 if method == "dfsph" else 40)]
        ranks = (2, 3, 4, 7) if method == "dfsph" else (3,)
        plain = case.same_everywhere(scene, method, settings, ranks, 20, options)
        if method == "dfsph":
            c.expect(any("refill" in row["event"] for row in c.steps(plain)), "no block came later")
    return "four solvers, DFSPH for 300 steps"


def restart(case, steps):
    """A run goes on to the same bits from before and from behind a block that comes later."""
    scene = everything(case)
    plain = case.run(scene, "plain", 2)
    event = next(int(row["step"]) for row in c.steps(plain) if "refill" in row["event"])
    for ranks, stop in ((3, event - 1), (1, event), (4, event + 5)):
        case.goes_on(scene, plain, "stop", stop, ranks)
    return f"stopped before, at and behind step {event}, in which a block comes"


def energy(output):
    """Mean and largest kinetic energy, J, and the largest speed, m/s, of a run."""
    rows = c.steps(output)
    mean = sum(float(row["kinetic_energy"]) * float(row["dt"]) for row in rows) / float(rows[-1]["time"])
    return mean, max(float(row["kinetic_energy"]) for row in rows), max(float(row["v_max"]) for row in rows)


def calm(case, steps):
    """In a bowl and a tilted box, which no lattice fits, water is near rest from its first step on."""
    turned = "rotation: {axis: [1, 0.3, 0.2], angle: 25}"
    shapes = {"ball": "sphere: {center: [0, 0, 0], radius: 0.5}", "tilted": f"box: {{min: [0, 0, 0], max: [0.8, 0.8, 0.6], {turned}}}"}
    vertices = [f"v {x} {y} {z}" for z in (0, 0.6) for x, y in ((0, 0), (0.8, 0), (0.8, 0.8), (0, 0.8))]
    sides = [f"f {a} {b} {d}" for s in range(4) for a, b, d in ((1 + s, 1 + (s + 1) % 4, 5 + (s + 1) % 4), (1 + s, 5 + (s + 1) % 4, 5 + s))]
    (case.folder / "box.obj").write_text("\n".join([*vertices, "f 1 4 3", "f 1 3 2", "f 5 6 7", "f 5 7 8", *sides]) + "\n", encoding="ascii")
    told = []
    for name, shape in shapes.items():
        # a mesh is filled with the scene's lattice, cut to it; a box with a lattice of its own, which fits
        cut = f"mesh: {{file: box.obj, rotation: {{axis: [1, 0.3, 0.2], angle: 25}}, translation: {place((0.4, 0.4, 0.3))}}}" if name == "tilted" else shape
        found = {}
        for start, block in (("lattice", cut), ("rest", f"{shape}, rest_state: {tile(case)}, rest_offset: [0.013, 0.021, 0.037]")):
            scene = case.write(f"{name}_{start}", f"""
particle_spacing: 0.05
end_time: 0.5
fluid: {{blocks: [{{{block}}}]}}
boundary: {{walls: [{{name: room, {shape}, inside: fluid}}]}}
""")
            found[start] = energy(case.run(scene, f"{name}_{start}", 2))
        mean, most, speed = (found["rest"][k] / found["lattice"][k] for k in range(3))
        c.expect(mean < 0.25 and most < 0.15 and speed < 0.5, f"{name}: {found}")
        told.append(f"{name} {mean:.2f}, {most:.2f}, {speed:.2f}")
    return "of a lattice's mean and largest energy and speed: " + "; ".join(told)


def place(middle):
    """By how much a box turned about the origin must be moved so that its middle stays where it was."""
    axis = np.array([1, 0.3, 0.2]) / math.sqrt(1 + 0.09 + 0.04)
    angle, m = math.radians(25), np.array(middle)
    turned = m * math.cos(angle) + np.cross(axis, m) * math.sin(angle) + axis * axis.dot(m) * (1 - math.cos(angle))
    return [float(x) for x in m - turned]


def seams(case, steps):
    """Where a rest state repeats it is as calm as within: over whole periods, and where blocks of it meet."""
    scene = case.write("seams", f"""
particle_spacing: 0.05
gravity: [0, 0, 0]
end_time: 0.3
domain: {{periodic: [true, true, true], min: [0, 0, 0], max: [0.8, 0.8, 0.8]}}
fluid:
  blocks:
    - {{box: {{min: [0, 0, 0], max: [0.33, 0.8, 0.8]}}, rest_state: {tile(case)}}}
    - {{box: {{min: [0.33, 0, 0], max: [0.8, 0.8, 0.8]}}, rest_state: {tile(case)}}}
output: {{snapshots: {{every: 0.3, fields: [velocity, density]}}}}
""")
    output = case.run(scene, "seams", 3)
    rows = c.steps(output)
    c.expect({row["fluid_particles"] for row in rows} == {"4096"}, f"{rows[0]['fluid_particles']} particles, not eight tiles' 4096")
    c.expect(energy(output)[2] < 2e-3, f"it moves at {energy(output)[2]} m/s")
    with h5py.File(c.snapshots(output)[0]) as file:
        density = file["VTKHDF/PointData/density"][:]
        at = file["VTKHDF/Points"][:]
    seam = (np.abs((at + 0.1) % 0.4 - 0.1) < 0.1).any(axis=1)
    spread = [float(np.std(density[chosen]) / 1000) for chosen in (seam, ~seam)]
    c.expect(spread[0] < 2 * spread[1] + 1e-4, f"deviation {spread[0]} at seams, {spread[1]} within")
    return f"eight tiles in two blocks, deviation {spread[0]:.1e} at seams and {spread[1]:.1e} within"


def fields(case, steps):
    """Particles of a rest state get their block's velocity, and their number is right in a box without walls."""
    scene = case.write("fields", f"""
particle_spacing: 0.05
gravity: [0, 0, 0]
end_time: 0.01
fluid: {{blocks: [{{box: {{min: [0, 0, 0], max: [0.8, 0.6, 0.4]}}, velocity: [1, 2, 0], rest_state: {tile(case)}}}]}}
output: {{snapshots: {{every: 1, fields: [velocity]}}}}
""")
    with h5py.File(c.snapshots(case.run(scene, "fields", 2))[0]) as file:
        velocity = file["VTKHDF/PointData/velocity"][:]
    c.expect(np.allclose(velocity, [1, 2, 0]), f"velocities from {velocity.min(axis=0)} to {velocity.max(axis=0)}")
    c.expect(abs(len(velocity) / 1536 - 1) < 0.02, f"{len(velocity)} particles for 1536 lattice cells")
    # a block that comes later, high above the tank and fast: the world reaches so far, and the step is short enough at once
    scene = case.write("thrown", f"""
particle_spacing: 0.05
gravity: [0, 0, 0]
end_time: 0.08
fluid:
  blocks:
    - {{box: {{min: [0, 0, 0], max: [0.6, 0.6, 0.3]}}}}
    - {{box: {{min: [0.2, 0.2, 2.2], max: [0.4, 0.4, 2.4]}}, velocity: [0, 0, -20], rest_state: {tile(case)}, start: 0.03}}
boundary: {{walls: [{{box: {{min: [0, 0, 0], max: [0.6, 0.6, 0.5]}}, inside: fluid, open: [+z]}}]}}
""")
    rows = c.steps(case.run(scene, "thrown", 2))
    c.expect(not any("rollback" in row["event"] for row in rows), "the step did not know how fast the block came")
    c.expect(abs(float(rows[-1]["v_max"]) / 20 - 1) < 0.1, f"it moves at {rows[-1]['v_max']} m/s")
    return f"{len(velocity)} particles of 1536 m3/spacing3"


BOX = """
particle_spacing: 0.05
end_time: 0.1
fluid: {{blocks: [{{box: {{min: [0, 0, 0], max: [0.8, 0.8, 0.4]}}, rest_state: {}}}]}}
boundary: {{walls: [{{name: tank, box: {{min: [0, 0, 0], max: [0.8, 0.8, 0.8]}}, inside: fluid, open: [+z]}}]}}
"""


def refused(case, steps):
    """Bad rest states are errors of the scene, on every rank, with their place."""
    good = tile(case)
    scene = case.write("good", BOX.format(good))
    case.call(["check", scene])
    whole = bytearray(good.read_bytes())
    whole[-100] ^= 1
    broken = {"damaged": bytes(whole), "short": good.read_bytes()[:-512], "text": b"water\n" * 200, "empty": b"",
              "seal": b"Halocline checkpoint, format 2\n"}
    for name, content in broken.items():
        path = case.folder / f"{name}.rest"
        path.write_bytes(content)
        said = case.call(["check", case.write(name, BOX.format(path))], 2, expected=2)
        c.expect(f"{name}.yaml:" in said and f"{name}.rest" in said, f"{name}: no place in: {said}")
    other = case.run(case.write("other", BOX.format(good)), "other", 1, (), ["--steps", 1])
    checkpoint = next((other / "checkpoints").glob("*.h5"), None)
    settings = [(("fluid.blocks[0].rest_state=none.rest",), "none.rest"),
                (("particle_spacing=0.04",), "was made with a particle_spacing of 0.05"),
                (("support_ratio=2.2",), "was made with a support_radius of 0.1"),
                (("fluid.rest_density=990",), "was made with a fluid.rest_density of 1000"),
                (("fluid.mass_factor=0.99",), "was made with a fluid.mass_factor of 1"),
                (("solver.method=pcisph",), "was made with the solver dfsph"),
                (("fluid.blocks[0].rest_checksum=0123456789abcdef",), "it has changed"),
                (("domain.periodic=[true, false, false]", "domain.min=[0, 0, 0]", "domain.max=[0.9, 0, 0]", "fluid.blocks[0].box.max=[0.9, 0.8, 0.4]",
                  "boundary.walls[0].box.max=[0.9, 0.8, 0.8]", "boundary.walls[0].open=[-x, +x, +z]"), "is no multiple"),
                (("fluid.blocks=[{box: {min: [0, 0, 0], max: [0.8, 0.8, 0.4]}, start: 0.05}]",), "must be 0 without a rest_state"),
                (("fluid.blocks[0].replaces=true",), "there is nothing to replace"),
                (("fluid.rest.damping_end=0.9",), "fluid.rest.damping_end must be > 0 and <= fluid.rest.damping_start (0.8), not 0.9")]
    if checkpoint:
        settings.append(((f"fluid.blocks[0].rest_state={checkpoint}",), "not a rest state"))
    for given, message in settings:
        said = case.call(["check", scene, *c.words(given)], expected=2)
        c.expect(message in said, f"{given}: no '{message}' in: {said}")
    said = case.call(["run", scene, "-o", case.folder / "x", *c.words(("fluid.blocks[0].rest_state=none.rest",))], 3, expected=2)
    c.expect(said.count("none.rest: cannot be opened") == 1, f"said {said}")
    return f"{len(broken)} broken files and {len(settings)} that do not go with the scene"


CASES = {"made": made, "bits": bits, "restart": restart, "calm": calm, "seams": seams, "fields": fields, "refused": refused}

if __name__ == "__main__":
    c.main(__doc__, CASES)
