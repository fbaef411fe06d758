#!/usr/bin/python3
"""Moving walls and emitters in whole runs: the same bits, the physics that can be known, what check says of them."""

import json

import h5py
import numpy as np

import case as c

SCENE = "tests/cases/prescribed.yaml"


def compare(case, one, other):
    case.same(one, other)
    last = [sorted((output / "checkpoints").glob("*.h5"))[-1] for output in (one, other)]
    case.diff(*last)


def bits(case, steps):
    """Ranks, rebalances of fluid and walls, the place in the world and the instruction set change nothing."""
    options = ["--steps", steps or 60]
    plain = case.run(SCENE, "plain", 1, ("parallel.rebalance=none",), options)
    for ranks in (1, 2, 3, 4, 7):
        settings = (f"parallel.rebalance_every={ranks + 4}", f"parallel.decomposition={'metis' if ranks % 2 else 'slabs'}")
        forced = case.run(SCENE, f"forced_{ranks}", ranks, settings, options)
        c.expect("rebalance" in (forced / "load.csv").read_text(encoding="utf-8"), f"{forced}: no rebalance")
        compare(case, plain, forced)
    far = case.run(SCENE, "far", 2, ("origin_cells=[1000000,1000,-1000000]",), options)
    c.expect_same_text(plain / "steps.csv", far / "steps.csv")
    avx2 = case.run(SCENE, "avx2", 2, (), options, {"HALOCLINE_ISA": "avx2"})
    c.expect_same_text(plain / "steps.csv", avx2 / "steps.csv")
    return f"{len(c.steps(plain))} steps are the same on 1, 2, 3, 4, 7 ranks with rebalances, far away, and with AVX2"


def restart(case, steps):
    """Stopped twice, in the midst of motions and of what comes in, on other ranks each time."""
    whole = case.run(SCENE, "whole", 2)
    output = case.folder / "stopped"
    start = ["run", c.SOURCE / SCENE, "-o", output, "--quiet", "--set", "parallel.rebalance_every=9"]
    case.call([*start, "--steps", 17], 3)
    case.call([*start, "--steps", 66, "--restart"], 4)
    case.call([*start, "--restart"], 1)
    compare(case, whole, output)
    return "stopped after 17 and 66 steps, on 3, 4 and 1 ranks: the same bytes"


def read(path):
    """Time, points and velocities of the fluid, points and ids of the boundary."""
    with h5py.File(path, "r") as file:
        data, points = file["VTKHDF/PointData"], file["VTKHDF/Points"][:]
        fluid = data["kind"][:] == 0
        return (float(file["Halocline"].attrs["time"]), points[fluid], data["velocity"][:][fluid], points[~fluid],
                data["id"][:][~fluid])


def piston(case, steps):
    """The piston goes where it should, nothing passes it, the water keeps its volume and rises as much as it must."""
    output = case.run("tests/cases/piston.yaml", "piston", 2)
    worst = 0.0
    spacing, count = 0.025, None
    for path in c.snapshots(output):
        time, points, velocity, walls, ids = read(path)
        face = 0.2 + 0.4 * min(max(time - 0.1, 0), 0.5)
        moving = walls[(ids >> 40 & 0xfffff) == 1]
        c.expect(abs(moving[:, 0].max() - (face - spacing / 2)) < 1e-6, f"{path}: the piston is at {moving[:, 0].max()}")
        count = count or len(points)
        low, high = np.array((face, 0, 0)) - 0.5 * spacing, np.array((0.8, 0.25, 0.7)) + 0.5 * spacing
        outside = np.any((points < low) | (points > high), axis=1).sum()
        c.expect(len(points) == count and outside == 0, f"{path}: {outside} of {len(points)} particles are outside")
        worst = max(worst, face - points[:, 0].min())
        if 0.2 < time < 0.6:  # what touches the piston goes with it
            near = velocity[(points[:, 0] < face + 0.75 * spacing) & (points[:, 2] < 0.2)][:, 0].mean()
            c.expect(abs(near - 0.4) < 0.08, f"{path}: water at the piston moves at {near} m/s, not 0.4")
    depth = 2 * points[:, 2].mean()
    expected = 0.25 * 0.6 / 0.4
    c.expect(abs(depth - expected) < 0.06 * expected, f"the water is {depth} m deep, not {expected}")
    errors = max(float(row["density_error_max"]) for row in c.steps(output))
    return (f"{count} particles stay in front of the piston (at most {worst:.4f} m into it), depth {depth:.3f} m for "
            f"{expected:.3f}; densities off by at most {100 * errors:.1f} %")


def filling(case, steps):
    """An empty box: as much comes in as the rate says, within a layer; the volume is the particles'."""
    output = case.run("scenes/filling_box.yaml", "filling", 2, ("end_time=0.25",))
    rows = c.steps(output)
    spacing, layer, speed = 0.02, 16, 2.0
    rate = layer * spacing**2 * speed
    begin = 0.0
    for row in rows:
        expected = rate * begin / spacing**3
        found = int(row["fluid_particles"])
        c.expect(-1e-6 <= found - expected <= layer + 1e-6, f"step {row['step']}: {found} particles, {expected} for {rate} m3/s")
        c.expect(not row["event"], f"step {row['step']}: {row['event']}")
        begin = float(row["time"])
    c.expect(found > 350, f"{found} particles came in")
    return f"{found} particles after {begin:.3f} s, {rate * begin / spacing**3:.1f} foretold by the rate"


def foretold(case, steps):
    """What check says of motions and emitters holds."""
    said = json.loads(case.call(["check", c.SOURCE / SCENE, "--json"]))
    output = case.run(SCENE, "foretold", 1)
    rows = c.steps(output)
    c.expect(float(rows[0]["dt"]) == said["first_step"]["dt"], f"first step {said['first_step']}, taken {rows[0]['dt']}")
    most = sum(e["most"] for e in said["emitters"])
    c.expect(said["fluid_most"] == said["fluid"] + most, f"{said['fluid_most']} particles at the end, {most} of emitters")
    found = int(rows[-1]["fluid_particles"])
    c.expect(said["fluid"] < found <= said["fluid_most"], f"{found} particles at the end, {said['fluid_most']} foretold")
    c.expect("swept" not in said["walls"][0], "the tank stands")
    for path in c.snapshots(output):
        _, _, _, walls, ids = read(path)
        for number in (1, 2):
            points, swept = walls[(ids >> 40 & 0xfffff) == number], said["walls"][number]["swept"]
            low, high = np.array(swept["low"]), np.array(swept["high"])
            c.expect(np.all(points >= low - 1e-6) and np.all(points <= high + 1e-6), f"{path}: wall {number} beyond {swept}")
    return f"first step exact; {found} of at most {said['fluid_most']} particles; walls stay where they should"


if __name__ == "__main__":
    c.main(__doc__, {"bits": bits, "restart": restart, "piston": piston, "filling": filling, "foretold": foretold})
