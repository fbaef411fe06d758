#!/usr/bin/python3
"""Does PCISPH let particles through a wall? Small versions of its scenes, all particles of all snapshots counted.

A wall holds particles half a spacing in front of its wetted surface, and lets them nearer where it is round, or hit hard.
None may come more than a few hundredths of a spacing behind it: without the contact, pressure alone lets them in by 0.04 to
1.4 spacings. Needs h5py and numpy.
"""

import h5py
import numpy as np

import case as c

BEHIND = 0.03  # spacings
PCISPH = ("solver.method=pcisph", "boundary.method=ihmsen2010", "solver.density_iterations.max=3",
          "solver.density_error_avg=0.01", "time_step.control=adaptive")


# ---- how deep points (n, 3) lie behind a wetted surface, m; negative where fluid belongs ----

def tank(low, high):
    return lambda points: np.maximum(np.array(low) - points, points - np.array(high)).max(axis=1)


def block(low, high):
    return lambda points: np.minimum(points - np.array(low), np.array(high) - points).min(axis=1)


def sphere(center, radius):
    return lambda points: radius - np.linalg.norm(points - np.array(center), axis=1)


def ring(center, radius, thickness):
    """About the x axis."""
    def depth(points):
        away = points - np.array(center)
        return thickness - np.hypot(np.hypot(away[:, 1], away[:, 2]) - radius, away[:, 0])
    return depth


def slope(foot, rise):
    """Everything below a plane that rises along x from its foot on."""
    normal = np.array((-rise, 0, 1)) / np.hypot(rise, 1)
    return lambda points: -(points - np.array(foot)) @ normal


def revolution(base, profile):
    """What a profile of (r, z), from the axis and back to it, sweeps out about the vertical axis."""
    profile = np.array(profile)

    def depth(points):
        away = points - np.array(base)
        r, z = np.hypot(away[:, 0], away[:, 1]), away[:, 2]
        inside, nearest = np.zeros(len(points), bool), np.full(len(points), np.inf)
        for (r0, z0), (r1, z1) in zip(profile, np.roll(profile, -1, axis=0)):
            if z0 != z1:  # how often does the way outwards cross the outline?
                crosses = (z0 > z) != (z1 > z)
                inside ^= crosses & (r < r0 + (z - z0) / (z1 - z0) * (r1 - r0))
            if r0 == 0 and r1 == 0:  # the axis is no surface
                continue
            length = (r1 - r0)**2 + (z1 - z0)**2
            share = np.clip(((r - r0) * (r1 - r0) + (z - z0) * (z1 - z0)) / length, 0, 1)
            nearest = np.minimum(nearest, np.hypot(r - r0 - share * (r1 - r0), z - z0 - share * (z1 - z0)))
        return np.where(inside, nearest, -nearest)
    return depth


# ---- counting ----

def read(path):
    """Points of the fluid, points and wall numbers of the boundary."""
    with h5py.File(path, "r") as file:
        points, data = file["VTKHDF/Points"][:], file["VTKHDF/PointData"]
        fluid, ids = data["kind"][:] == 0, data["id"][:]
    return points[fluid], points[~fluid], ids[~fluid] >> 40 & 0xfffff


def count(output, spacing, walls, kept=True):
    """No particle of a run behind a wetted surface; `walls` are depths, or functions of the samples to depths.

    With `kept` no particle may be lost either. Returns how near they came.
    """
    deepest = dict.fromkeys(walls, -np.inf)
    for path in c.snapshots(output):
        points, samples, numbers = read(path)
        for name, (moving, wall) in walls.items():
            depth = (wall if moving is None else wall(samples[numbers == moving]))(points)
            behind = int(np.count_nonzero(depth > BEHIND * spacing))
            deepest[name] = max(deepest[name], float(depth.max(initial=-np.inf)))
            c.expect(behind == 0, f"{path}: {behind} particles behind wall '{name}', the deepest {deepest[name] / spacing:.2f} "
                                  "spacings")
    for name, depth in deepest.items():
        c.expect(depth > -0.6 * spacing, f"nothing ever reached wall '{name}'")
    rows = c.steps(output)
    if kept:
        c.expect(len({row["fluid_particles"] for row in rows}) == 1, "particles are lost")
    name = max(deepest, key=deepest.get)
    return (f"{rows[-1]['fluid_particles']} particles, {len(rows)} steps to {float(rows[-1]['time']):.2f} s, "
            f"{sum('rollback' in row['event'] for row in rows)} rollbacks: none nearer than {-deepest[name] / spacing:.2f} "
            f"spacings to a surface ({name})")


def still(**walls):
    return {name: (None, wall) for name, wall in walls.items()}


def small(case, scene, spacing, end, settings=()):
    return case.run(scene, scene.split("/")[-1][:-5], 2,
                    (f"particle_spacing={spacing}", f"end_time={end}", f"output.snapshots.every={end / 20}", *settings))


# ---- the scenes ----

def corners(case, _steps):
    """A dam collapses in the corner of a tank and runs into the other three."""
    output = small(case, "scenes/cbd_small.yaml", 0.05, 1.5)
    return count(output, 0.05, still(tank=tank((0, 0, 0), (2, 2, 2))))


def spheres(case, _steps):
    """A block falls from 5.6 m on spheres."""
    output = small(case, "scenes/shock.yaml", 0.05, 1.3)
    balls = {name: sphere(center, 0.3) for name, center in
             {"left": (1.1, 1.2, 0.35), "right": (1.9, 1.2, 0.35), "back": (1.5, 1.9, 0.35)}.items()}
    return count(output, 0.05, still(tank=tank((0, 0, 0), (3, 3, 7)), **balls))


def glass(case, _steps):
    """A goblet, a surface of revolution, is filled."""
    profile = [[0, 0], [0.3, 0], [0.3, 0.05], [0.08, 0.12], [0.08, 0.3], [0.3, 0.4], [0.44, 0.55], [0.5, 0.75], [0.5, 0.95],
               [0.46, 1.15], [0.39, 1.15], [0.42, 0.95], [0.42, 0.75], [0.37, 0.58], [0.25, 0.46], [0.12, 0.4], [0, 0.39]]
    output = small(case, "scenes/glass.yaml", 0.03, 2.5)
    return count(output, 0.03, still(glass=revolution((0, 0, 0), profile)), kept=False)


def meshes(case, _steps):
    """Water breaks on a mesh; a ball of it falls into a bowl."""
    bowl = [[0, 0], [0.08, 0], [0.11, 0.03], [0.17, 0.2], [0.2, 0.35], [0.16, 0.35], [0.13, 0.21], [0.08, 0.06], [0, 0.05]]
    output = small(case, "scenes/meshes.yaml", 0.02, 0.6, (*PCISPH, "fluid.viscosity={model: artificial, coefficient: 0.02}",
                                                        "boundary.friction_law=none"))  # as in the paper
    return count(output, 0.02, still(tank=tank((0, 0, 0), (1.4, 0.6, 0.8)), ring=ring((0.65, 0.3, 0.22), 0.17, 0.05),
                                     bowl=revolution((1.15, 0.3, 0), bowl)))


def wave(case, _steps):
    """A wall that moves to and fro, a tilted beach, figures."""
    figure = [[0, 0], [0.12, 0], [0.15, 0.15], [0.12, 0.3], [0.06, 0.38], [0.09, 0.46], [0.06, 0.53], [0, 0.55]]
    output = small(case, "scenes/wave.yaml", 0.06, 4.5)
    walls = still(tank=tank((0, 0, 0), (9, 1.56, 9)), beach=slope((4.2, 0, 0), 0.25))
    walls["generator"] = (2, lambda samples: block((-np.inf, 0, 0), (samples[:, 0].max() + 0.03, np.inf, np.inf)))
    for name, base in {"left": (6.5, 0.36, 0.55), "middle": (6.3, 0.78, 0.5), "right": (6.5, 1.2, 0.55)}.items():
        walls[name] = (None, revolution(base, figure))
    return count(output, 0.06, walls)


def piston(case, _steps):
    """A wall pushes the water."""
    output = small(case, "tests/cases/piston.yaml", 0.025, 1.0, (*PCISPH, "fluid.viscosity={model: artificial, coefficient: 0.05}"))
    walls = still(tank=tank((0, 0, 0), (0.8, 0.25, 0.7)))
    walls["piston"] = (1, lambda samples: block((-np.inf, -1, -1), (samples[:, 0].max() + 0.0125, 2, 2)))
    return count(output, 0.025, walls)


def turn(axis, angle):
    """The rotation about an axis, radians."""
    x, y, z = axis / np.linalg.norm(axis)
    across = np.array(((0, -z, y), (z, 0, -x), (-y, x, 0)))
    return np.eye(3) + np.sin(angle) * across + (1 - np.cos(angle)) * across @ across


def troughs(case, count):
    """Drops fall into closed troughs with a sharp edge below, of all angles, turned and tilted; `--steps` says how many."""
    methods = ("dfsph, akinci2012", "pcisph, ihmsen2010", "dfsph, akinci2012", "pcisph, akinci2012")
    count, spacing, leaked = count or 20, 0.05, []
    for number in range(count):
        random = np.random.default_rng(number)
        half, depth, length = np.radians(random.uniform(8, 44)), 0.6, 1.0
        width = depth * np.tan(half)
        solver, walls = methods[number % 4].split(", ")
        corners = np.array([(x, y, z) for x in (0, length) for y, z in ((-width, depth), (width, depth), (0, 0))])
        rotation = turn(random.normal(size=3), np.radians(random.uniform(0, 20))) @ turn(np.array((0, 0, 1)), random.uniform(0, 2 * np.pi))
        edge = min(0.1, 1.2 * width * (depth - 0.12) / depth)
        low = np.array((random.uniform(0.1, 0.3), -edge / 2, 0.42))
        high = low + (random.uniform(0.3, 0.6), edge, 0.1)
        places = (corners - (0.5, 0, 0)) @ rotation.T
        faces = [(0, 1, 2), (3, 5, 4), (0, 4, 1), (0, 3, 4), (0, 5, 3), (0, 2, 5), (1, 5, 2), (1, 4, 5)]
        block = np.array([(x, y, z) for x in (low[0], high[0]) for y in (low[1], high[1]) for z in (low[2], high[2])])
        for name, points, triangles in (("trough", places, faces), ("drop", (block - (0.5, 0, 0)) @ rotation.T,
                                                                      [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)])):
            lines = [f"v {x!r} {y!r} {z!r}" for x, y, z in points.tolist()] + ["f " + " ".join(str(k + 1) for k in f) for f in triangles]
            (case.folder / f"{name}_{number}.obj").write_text("\n".join(lines), encoding="utf-8")
        (case.folder / f"trough_{number}.yaml").write_text(f"""
particle_spacing: {spacing}
end_time: 0.6
fluid: {{blocks: [{{mesh: {{file: drop_{number}.obj}}}}]}}
solver: {{method: {solver}}}
boundary: {{method: {walls}, walls: [{{name: trough, mesh: {{file: trough_{number}.obj}}, inside: fluid}}]}}
domain: {{leaving: remove}}
output: {{snapshots: {{every: 0.05}}}}
""", encoding="utf-8")
        output = case.folder / f"trough_{number}"
        case.call(["run", case.folder / f"trough_{number}.yaml", "-o", output, "--force", "--quiet"])
        inward = [np.array((0, np.cos(half), np.sin(half))), np.array((0, -np.cos(half), np.sin(half))), np.array((0, 0, -1.0)),
                  np.array((1.0, 0, 0)), np.array((-1.0, 0, 0))]
        offsets = [0, 0, depth, 0, length]
        worst, start = np.inf, len(read(c.snapshots(output)[0])[0])
        for path in c.snapshots(output):
            points = read(path)[0] @ rotation + (0.5, 0, 0)
            worst = min(worst, min((points @ n + o).min() for n, o in zip(inward, offsets)))
            if len(points) < start:
                worst = -np.inf
        if worst < -0.5 * spacing:
            leaked.append(f"{number} ({methods[number % 4]}, {2 * np.degrees(half):.0f} degrees, {worst:.3f} m)")
    c.expect(not leaked, f"{len(leaked)} of {count} troughs leak: {', '.join(leaked)}")
    return f"{count} troughs, none leaks"


if __name__ == "__main__":
    c.main(__doc__, {"troughs": troughs, "corners": corners, "spheres": spheres, "glass": glass, "meshes": meshes, "wave": wave, "piston": piston})
