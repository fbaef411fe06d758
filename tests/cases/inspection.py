#!/usr/bin/python3
"""What check foretells, against what runs then do; info and diff on the files of these runs."""

import json

import case as c

SMALL = ("particle_spacing=0.05", "output.snapshots.every=0.02")


def look(case, arguments, expected=0):
    """A command's JSON object, one line: warnings may come before it, words of the launcher behind."""
    text = case.call([*arguments, "--json"], expected=expected)
    try:
        return json.loads(next(line for line in text.split("\n") if line.startswith("{")))
    except (StopIteration, ValueError) as error:
        raise c.CaseFailed(f"{arguments} --json printed no JSON: {error}\n{text}") from error


def check(case, scene, ranks=1, settings=()):
    options = [word for setting in settings for word in ("--set", setting)]
    return look(case, ["check", c.SOURCE / scene, "--ranks", ranks, *options])


def expect_close(what, foretold, found, allowed):
    c.expect(abs(foretold - found) <= allowed * found, f"{what}: {foretold} foretold, {found} found, more than "
             f"{100 * allowed:g} % apart")
    return foretold / found - 1


def foretell(case, scene, ranks, steps, settings=()):
    """One run against its estimate; returns the error of the memory's."""
    name = f"{scene}_{ranks}"
    said = check(case, f"scenes/{scene}.yaml", ranks, settings)
    output = case.run(f"scenes/{scene}.yaml", name, ranks, settings, ["--steps", steps] if steps else [])
    files = c.snapshots(output)
    start = look(case, ["info", files[0]])
    for kind in ("fluid", "boundary"):
        c.expect(said[kind] == start[kind], f"{name}: {said[kind]} {kind} particles foretold, {start[kind]} found")
        settles = kind == "fluid" and scene in ("taylor_green", "standing_wave")  # particles have moved before the first snapshot
        c.expect(settles or said["extents"][kind] == start["extents"][kind],
                 f"{name}: {kind} foretold in {said['extents'][kind]}, found in {start['extents'][kind]}")
    for kind, sources in (("fluid", "blocks"), ("boundary", "walls")):
        total = sum(source["particles"] for source in said[sources])
        c.expect(total == said[kind], f"{name}: {sources} have {total} particles, the {kind} has {said[kind]}")
    rows = c.steps(output)
    c.expect(float(rows[0]["dt"]) == said["first_step"]["dt"],
             f"{name}: first step {said['first_step']['dt']} foretold, {rows[0]['dt']} taken")
    for file in (output / "checkpoints").glob("ckpt_*.h5"):
        expect_close(f"{name}: size of {file.name}", said["output"]["checkpoint_bytes"], file.stat().st_size, 0.05)
    for file in files:
        expect_close(f"{name}: size of {file.name}", said["output"]["snapshot_bytes"], file.stat().st_size, 0.03)
    if not steps:
        written = sum(f.stat().st_size for f in output.rglob("*") if f.is_file())
        expect_close(f"{name}: bytes in all", said["output"]["total_bytes"], written, 0.2)
        c.expect(len(files) <= said["output"]["snapshots"], f"{name}: more snapshots than {said['output']}")
        done = len(rows)
        good = done == said["steps"] if said["steps_exact"] else done >= said["steps"]
        c.expect(good, f"{name}: {said['steps']} steps foretold, {done} done")
    timings = json.loads((output / "timings.json").read_text(encoding="utf-8"))
    return expect_close(f"{name}: memory", said["memory_per_rank"]["total"], timings["memory_bytes_per_rank"]["max"],
                        0.2)


def on_ranks(case, scene, steps, settings=()):
    errors = [foretell(case, scene, ranks, steps, settings) for ranks in (1, 3)]
    return f"{scene}: counts, extents and first step exact; memory off by " + ", ".join(f"{100 * e:.1f} %" for e in errors)


def dam_break(case, steps):
    return on_ranks(case, "dam_break", steps or 60)


def finer_dam(case, steps):
    return on_ranks(case, "dam_break", steps or 5, ("particle_spacing=0.0125",))


def free_fall(case, steps):
    return on_ranks(case, "free_fall", steps)


def hydrostatic(case, steps):
    return on_ranks(case, "hydrostatic", steps or 150)


def hydrostatic_walled(case, steps):
    return on_ranks(case, "hydrostatic_walled", steps or 150)


def martin_moyce(case, steps):
    return on_ranks(case, "martin_moyce", steps or 100)


def kleefsman(case, steps):
    return on_ranks(case, "kleefsman", steps or 5)


def poiseuille(case, steps):
    return on_ranks(case, "poiseuille", steps or 100)


def standing_wave(case, steps):
    return on_ranks(case, "standing_wave", steps or 5, ("fluid.settle_steps=5",))


def meshes(case, steps):
    return on_ranks(case, "meshes", steps or 20)


def shapes(case, steps):
    return on_ranks(case, "shapes", steps or 20)


def taylor_green(case, steps):
    return on_ranks(case, "taylor_green", steps or 60)


def check_by_hand(case, _):
    """Numbers that need no run: blocks and walls one by one, and bounds of the first step."""
    scene = case.folder / "by_hand.yaml"
    scene.write_text("""\
particle_spacing: 0.1
end_time: 1
fluid:
  blocks:
    - {box: {min: [0, 0, 0], max: [0.4, 0.3, 0.2]}}
    - {box: {min: [1, 0, 0], max: [1.2, 0.2, 0.2]}, velocity: [0, 60, 80]}
boundary:
  walls:
    - {name: floor, plane: {point: [0.5, 0.5, 0], normal: [0, 0, 1], size: [1, 1]}}
    - {box: {min: [3, 3, 3], max: [4, 4, 4]}, inside: solid}
time_step: {control: cfl, factor: 0.4, max: 0.005}
output: {snapshots: {every: 0, fields: []}}
""", encoding="utf-8")
    said = check(case, scene)
    found = [(s["name"], s["particles"]) for s in said["blocks"] + said["walls"]]
    c.expect(found == [("fluid.blocks[0]", 24), ("fluid.blocks[1]", 8), ('boundary.walls[0] "floor"', 100),
                       ('boundary.walls[1] "wall_1"', 1000 - 512)], f"by block and wall: {found}")
    c.expect(all(abs(a - b) < 1e-8 for a, b in zip(said["blocks"][1]["extent"]["low"], (1.05, 0.05, 0.05))),
             f"second block: {said['blocks'][1]}")
    c.expect(abs(said["first_step"]["dt"] - 0.4 * 0.1 / 100) < 1e-15 and said["first_step"]["bound"] == "velocity",
             f"first step: {said['first_step']}")
    c.expect(said["output"]["snapshots"] == 2, f"first and last snapshot only: {said['output']}")
    c.expect(said["steps"] == 200 and not said["steps_exact"] and said["periodic"] == [None] * 3, str(said))
    text = case.call(["check", scene])
    for line in ('  boundary.walls[0] "floor" 100, ', ", bounded by: velocity"):
        c.expect(line in text, f'"{line}" is not in\n{text}')
    bare = check(case, scene, 2, ("boundary.walls=[]",))
    c.expect(bare["boundary"] == 0 and bare["extents"]["boundary"] is None, f"a scene without walls: {bare}")
    case.call(["check", scene, "--set", "end_time=-1", "--json"], expected=2)
    text = case.call(["check", scene, "--set", "boundary.walls=[]", "--set", "particle_spacing=0.0001"], expected=2)
    c.expect("a rank can hold at most" in text, f"more particles than a rank can hold: {text}")
    return "blocks, walls, first step and scenes without walls are right"


def info(case, steps):
    """The same numbers whatever the ranks, and those of steps.csv."""
    steps = steps or 20
    told = []
    for ranks in (1, 3):
        output = case.run("scenes/dam_break.yaml", f"info_{ranks}", ranks, SMALL, ["--steps", steps])
        last = look(case, ["info", c.snapshots(output)[-1]])
        c.expect(last.pop("pieces") == ranks, f"info_{ranks}: pieces are not the ranks")
        last.pop("file")
        told.append(last)
    c.expect(told[0] == told[1], f"info depends on the ranks:\n{told[0]}\n{told[1]}")
    row = c.steps(output)[-1]
    for name in ("step", "time", "dt", "kinetic_energy", "potential_energy"):
        c.expect(abs(told[0][name] - float(row[name])) <= 1e-12 * abs(float(row[name])),
                 f"{name}: {told[0][name]} in info, {row[name]} in steps.csv")
    fastest = next(field for field in told[0]["fields"] if field["name"] == "velocity")["max"]
    c.expect(abs(fastest - float(row["v_max"])) <= 1e-12 * fastest, f"v_max: {fastest}, {row['v_max']}")
    c.expect(abs(told[0]["mass"] - 240) < 0.1, f"0.24 m3 of water weigh {told[0]['mass']} kg")
    case.call(["info", output / "steps.csv"], expected=2)
    case.call(["info", output / "none.hdf", "--json"], expected=2)
    return "info tells the same on 1 and 3 ranks, and what steps.csv tells"


def diff(case, steps):
    """Exit codes, the tolerance, and the worst particle by its id."""
    output = case.run("scenes/dam_break.yaml", "diff", 2, SMALL, ["--steps", steps or 20])
    other = case.run("scenes/dam_break.yaml", "other", 2, (*SMALL, "name=other", "gravity=[0, 0, -9.8]"),
                     ["--steps", steps or 20])
    files = c.snapshots(output)
    c.expect(look(case, ["diff", files[0], files[0]])["same"], "a file is not the same as itself")
    found = look(case, ["diff", files[0], files[-1]], expected=1)
    worst = max(found["fields"], key=lambda f: f["worst"] if f["name"] == "velocity" else -1)
    c.expect(worst["id"] < 1920 and len(worst["at"]) == 3 and not found["same_time"], f"worst: {worst}")
    case.call(["diff", files[0], files[-1], "--tolerance", 2 * max(f["worst"] for f in found["fields"] if "worst" in f)])
    apart = look(case, ["diff", files[0], c.snapshots(other)[0]], expected=1)
    c.expect([s["name"] for s in apart["settings"]] == ["gravity"] and not apart["same_scene"] and
             apart["differing"] == 0, f"gravity and name differ, no particle does: {apart}")
    case.call(["diff", files[0], output / "none.hdf", "--json"], expected=2)
    case.call(["diff", files[0], files[0], "--tolerance=-1"], expected=2)
    return "same 0, different 1, impossible 2; tolerance and settings are seen"


if __name__ == "__main__":
    c.main(__doc__, {"dam_break": dam_break, "finer_dam": finer_dam, "free_fall": free_fall, "hydrostatic": hydrostatic,
                     "hydrostatic_walled": hydrostatic_walled, "taylor_green": taylor_green, "martin_moyce": martin_moyce,
                     "kleefsman": kleefsman, "poiseuille": poiseuille, "standing_wave": standing_wave, "shapes": shapes, "meshes": meshes,
                     "check_by_hand": check_by_hand, "info": info, "diff": diff})
