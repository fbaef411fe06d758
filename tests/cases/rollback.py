#!/usr/bin/python3
"""Runs whose shocks take steps back, with the adaptive time step and cfl: nothing of those steps stays, whatever the ranks, and a
restart from just before a shock goes on to the same bytes."""

import csv
import json
import re
import subprocess

import case as c
import gauges

# A block hits the floor; bounds of the density error so narrow that the impact needs several restarts.
SCENE = """
name: drop
particle_spacing: 0.05
end_time: 0.12
fluid:
  viscosity: {model: artificial, coefficient: 0.05}
  blocks: [{box: {min: [0.4, 0.1, 0.3], max: [1.0, 0.5, 0.9]}, velocity: [0, 0, -3]}]
boundary: {method: ihmsen2010, walls: [{name: tank, box: {min: [0, 0, 0], max: [1.5, 0.6, 1.5]}}]}
solver: {method: pcisph, density_error_avg: 0.003}
time_step: {control: adaptive, max: 0.02}
output:
  snapshots: {every: 0.0002}
  gauges: [{name: front, type: front, axis: +z}, {name: push, type: force, wall: tank},
           {name: lately, type: force, wall: tank, mean_over: 0.01}, {name: ever, type: force, wall: tank, mean_over: 1}]
"""
# As many shocks as wanted, where wanted, and no others.
CALM = ("solver.density_error_max=9", "time_step.adaptive.shock.error_rise=8")


def launch(case, output, ranks=1, settings=(), options=(), expected=0, scene=SCENE):
    path = case.folder / "scene.yaml"
    path.write_text(scene, encoding="utf-8")
    pairs = [word for setting in settings for word in ("--set", setting)]
    return case.call(["run", path, "-o", output, "--quiet", *pairs, *options], ranks, expected)


def log_of(output):
    return (output / "run.log").read_text(encoding="utf-8")


def expect_whole(output, session_from_start=True):
    """Time rises from row to row in all tables, snapshots and their series agree, and the counts do."""
    for table in ("steps.csv", "gauges.csv"):
        rows = (output / table).read_text(encoding="utf-8").splitlines()
        column = rows[0].split(",").index("time")
        times = [float(row.split(",")[column]) for row in rows[1:]]
        c.expect(all(a < b for a, b in zip(times, times[1:])), f"{output / table}: time does not rise")
    numbers = [int(row["step"]) for row in c.steps(output)]
    c.expect(numbers == list(range(1, len(numbers) + 1)), f"{output}: steps {numbers}")
    load = [int(row.split(",")[0]) for row in (output / "load.csv").read_text(encoding="utf-8").splitlines()[1:]]
    c.expect(load == numbers, f"{output}: load.csv has the steps {load}")
    series = (output / "snapshots/run.hdf.series").read_text(encoding="utf-8")
    entries = re.findall(r'"name":"(snap_\d+\.hdf)","time":([0-9.e-]+)', series)
    c.expect([name for name, _ in entries] == [path.name for path in c.snapshots(output)], f"{output}: {entries}")
    c.expect(all(float(a[1]) < float(b[1]) for a, b in zip(entries, entries[1:])), f"{output}: series {entries}")
    told = sum(int(n) for row in c.steps(output) for n in re.findall(r"rollback:(\d+)", row["event"]))
    timings = json.loads((output / "timings.json").read_text(encoding="utf-8"))
    if session_from_start:
        shocks = log_of(output).count(": shock: ")
        c.expect(shocks == timings["rollbacks"], f"{output}: {shocks} shocks in run.log, {timings['rollbacks']} counted")
    c.expect(f"rollbacks: {timings['rollbacks']}, which took back {timings['rollback_steps']} steps" in log_of(output),
             log_of(output))
    return timings["rollbacks"], timings["rollback_steps"], told


def expect_same(case, one, other):
    for name in ("steps.csv", "gauges.csv", "snapshots/run.hdf.series"):
        c.expect_same_text(one / name, other / name)
    pairs = list(zip(c.snapshots(one), c.snapshots(other), strict=True))
    for k in sorted({0, len(pairs) // 3, 2 * len(pairs) // 3, len(pairs) - 1}):
        case.diff(*pairs[k])
    digests = [re.findall(r"digest of the last state.*: (\w+)", log_of(run))[-1] for run in (one, other)]
    c.expect(digests[0] == digests[1], f"last states {digests}")


def shocks(case, _):
    """Shocks of an impact, on several ranks with and without rebalances."""
    one, other = case.folder / "one", case.folder / "three"
    launch(case, one, 1)
    launch(case, other, 3, ("parallel.rebalance_every=2",))
    counts = expect_whole(one)
    c.expect(counts[0] >= 3 and counts[1] == counts[2], f"rollbacks, steps taken back, steps told of: {counts}")
    c.expect("restart 3" in log_of(one), "there should be an impact that needs three restarts")
    c.expect(expect_whole(other) == counts, "other counts on other ranks")
    for name, time in (("lately", 0.01), ("ever", 1)):
        gauges.expect_moving_mean(gauges.readings(one), "push_fz", f"{name}_fz", time)
    expect_same(case, one, other)
    lines = [line for line in log_of(one).splitlines() if ": shock: " in line]
    c.expect(all(re.search(r"rose by [\d.]+ %, more than 1.5 % \(25\); v_max .* back 2 steps to step \d+, t = .* restart "
                           r"[123]: time step [\d.e-]+ s -> [\d.e-]+ s$", line) for line in lines), "\n".join(lines))
    return f"{counts[0]} shocks took back {counts[1]} steps: the same bytes on 1 and 3 ranks, time rises"


def restarts(case, _):
    """Stops at every step around a shock that comes twice: the restarted run meets it as the straight one did."""
    hook = (*CALM, "faults.shock_at=12", "faults.shock_again=1")
    whole = case.folder / "whole"
    launch(case, whole, 2, hook, ["--steps", 22])
    counts = expect_whole(whole)
    c.expect(counts == (2, 4, 4), f"rollbacks, steps taken back, steps told of: {counts}")
    c.expect(c.steps(whole)[11]["event"] == "rollback:4", "the replay's first row tells of both")
    for number, stop in enumerate((1, 11, 12, 13, 14, 21)):
        output = case.folder / f"stop_{stop}"
        launch(case, output, 1 + number % 3, (*hook, "parallel.rebalance_every=3"), ["--steps", stop])
        kept = [path.name for path in (output / "checkpoints").iterdir()]
        c.expect(kept == [f"ckpt_{stop - 1:08d}.h5"], f"stopped after {stop} steps, it holds {kept}")
        launch(case, output, 3 - number % 3, hook, ["--steps", 22, "--restart"])
        c.expect(expect_whole(output, False) == counts, "other counts after a restart")
        expect_same(case, whole, output)
    launch(case, output, 2, hook, ["--steps", 22, "--restart"])  # does the last step again
    expect_same(case, whole, output)
    return "stopped after 1, 11 to 14 and 21 steps: the same bytes"


def prescribed(case, _):
    """A layer that an emitter brought in is taken back with its step, and walls that moved are where they were."""
    scene = c.SOURCE / "tests/cases/prescribed.yaml"
    base = ["--set", "solver.density_error_avg=0.05", "--set", "output.snapshots.every=0.01", "--set",
            "time_step={control: adaptive, adaptive: {shock: {error_rise: 0.4}}}"]

    def run(name, ranks, options):
        case.call(["run", scene, "-o", case.folder / name, "--quiet", *base, *options], ranks)
        return case.folder / name

    counts = [int(row["fluid_particles"]) for row in c.steps(run("undisturbed", 2, ["--steps", 45]))]
    grown = [k + 1 for k in range(20, 40) if counts[k] > counts[k - 1]]
    c.expect(grown, f"no layer comes in: {counts}")
    at = grown[0]
    hook = ["--set", f"faults.shock_at={at}", "--set", "faults.shock_again=1"]
    one = run("moving_one", 1, [*hook, "--steps", 45])
    c.expect(expect_whole(one) == (2, 4, 4), "two shocks are wanted")
    expect_same(case, one, run("moving_three", 3, [*hook, "--steps", 45, "--set", "parallel.rebalance_every=1"]))
    for stop in (at, at + 1):
        name = f"moving_stop_{stop}"
        run(name, 2, [*hook, "--steps", stop])
        expect_same(case, one, run(name, 3, [*hook, "--steps", 45, "--restart"]))
    return f"a layer of step {at} is taken back twice: the same bytes on 1, 2 and 3 ranks"


def sessions(case, _):
    """Sessions of the shortest kind, each of which must get on."""
    hook = (*CALM, "faults.shock_at=2", "faults.shock_again=1", "end_time=0.01")
    whole, output = case.folder / "at_once", case.folder / "in_sessions"
    launch(case, whole, 1, hook)
    count = 0
    while True:
        count += 1
        try:
            launch(case, output, 2, hook, ["--restart", "--walltime", "0.01"], 75)
        except c.CaseFailed as failure:
            if "exit code 0," in str(failure):
                break
            raise
        c.expect(count < 60, "the run does not get on")
    expect_same(case, whole, output)
    c.expect(count > 5, f"{count} sessions")
    return f"{count} sessions of two steps each: the same bytes"


def ends(case, _):
    """A shock that is never past ends the run; one checkpoint further back it can go on."""
    output, plain = case.folder / "stuck", case.folder / "plain"
    often = "output.checkpoints.every_steps=5"
    text = launch(case, output, 3, (*CALM, often, "faults.shock_at=12", "faults.shock_again=999"), expected=1)
    for wanted in ("in step 12 ", "a shock came again in each of 10 replays", "likely cause: a shock at ",
                   "forced by the test hook", "fault_000012.hdf"):
        c.expect(wanted in text, f"'{wanted}' is missing:\n{text}")
    rows = c.steps(output)
    c.expect(len(rows) == 11, "rows of steps that were taken back")
    series = (output / "snapshots/run.hdf.series").read_text(encoding="utf-8")
    times = [float(t) for t in re.findall(r'"time":([0-9.e-]+)', series)]
    c.expect(times[-1] == float(rows[-1]["time"]) and len(times) == len(c.snapshots(output)),
             f"snapshots of steps that were taken back: {times}")
    text = launch(case, case.folder / "floor", 2, (*CALM, "faults.shock_at=12", "faults.shock_again=999",
                                                   "time_step.min=0.0005"), expected=1)
    c.expect("is under its floor" in text and "a shock at " in text, text)
    launch(case, output, 2, (*CALM, often), ["--restart", "--steps", 20])
    launch(case, plain, 1, CALM, ["--steps", 20])
    expect_same(case, plain, output)
    c.expect(not list((output / "snapshots").glob("fault_*")), "the fault's snapshot is left")
    return "the message names the shock; the checkpoint before it goes on"


# PCISPH in steps as long as cfl allows: the step before the one that diverges has spoilt the state.
DAM = """
name: dam
particle_spacing: 0.03
end_time: 0.15
fluid: {viscosity: {model: xsph, coefficient: 0.02}, blocks: [{box: {min: [0, 0, 0], max: [0.8, 0.2, 0.6]}}]}
boundary: {method: akinci2012, walls: [{name: tank, box: {min: [0, 0, 0], max: [1.4, 0.2, 1.0]}}]}
solver: {method: pcisph}
time_step: {control: cfl}
output: {gauges: [{name: front, type: front, axis: +x}]}
"""


def spoilt_before(case, _):
    """A step that diverges whatever its length: the one before it is taken back too, and the run goes on."""
    runs = [case.folder / "one", case.folder / "three"]
    for output, ranks in zip(runs, (1, 3)):
        launch(case, output, ranks, scene=DAM)
    counts = expect_whole(runs[0])
    c.expect(counts[0] > 0 and counts[1] == 2 * counts[0], f"rollbacks, steps taken back, steps told of: {counts}")
    fastest = max(float(row["v_max"]) for row in c.steps(runs[0]))
    c.expect(fastest < 1.5 * (2 * 9.81 * 0.6) ** 0.5, f"something ran off at {fastest} m/s")
    expect_same(case, *runs)
    return f"{counts[0]} steps that diverged, 2 taken back each, v_max {fastest:.2f} m/s: the same bytes on 1 and 3 ranks"


# Water at rest between a tank and its back, in a step that is as good as halved.
TANK = """
name: tank
particle_spacing: 0.04
end_time: 1.2
fluid: {viscosity: {model: artificial, coefficient: 0.05}, blocks: [{box: {min: [0, 0, 0], max: [0.4, 0.4, 0.4]}}]}
boundary:
  method: ihmsen2010
  walls:
    - {name: tank, box: {min: [0, 0, 0], max: [0.4, 0.4, 0.6]}, open: [-x, +z]}
    - {name: back, plane: {point: [0, 0.2, 0.3], normal: [1, 0, 0], size: [0.4, 0.6]}}
solver: {method: pcisph}
faults: {shock_at: 150}
output: {snapshots: {every: 0}, gauges: [{name: back, type: force, wall: back}]}
"""


def pulse(case, _):
    """A step that a shock has shortened keeps the pressure on walls far from it: no pulse."""
    shares = {}
    for name, steps in (("released", 100), ("as_printed", 0)):
        output = case.folder / name
        launch(case, output, 2, (f"solver.release_steps={steps}",), scene=TANK)
        shock = next(float(row["time"]) for row in c.steps(output) if "rollback" in row["event"])
        with open(output / "gauges.csv", newline="", encoding="utf-8") as file:
            rows = [(float(row["time"]) - shock, -float(row["back_fx"])) for row in csv.DictReader(file)]
        around = [push for time, push in rows if abs(time) <= 0.1]
        after = [[push for time, push in rows if 0.004 * k <= time < 0.004 * (k + 1)] for k in range(5)]
        shares[name] = [sum(part) / len(part) * len(around) / sum(around) for part in after]
    found = ", ".join(f"{name}: {low:.2f} to {high:.2f}"
                      for name, low, high in ((n, min(s), max(s)) for n, s in shares.items()))
    c.expect(0.7 < min(shares["released"]) and max(shares["released"]) < 1.3, f"force on the back over 4 ms: {found}")
    c.expect(max(shares["as_printed"]) > 2, f"the paper's own step has no pulse to show: {found}")
    return f"force on the back over 4 ms, over that of the 0.2 s around: {found}"


# Reference files: what is drawn, and what is wrong.
GOOD_REFERENCE = "# by hand\ntime_s,front_m,push_fz,nobody_Pa\n0,0.9,-100,1\n\n# later\n0.05,0.8,,2\n0.1,0.7,-300,3\n"
BROKEN_REFERENCES = {
    "none.csv": (None, "No such file"),
    "empty.csv": ("# nothing\n", "a line of names"),
    "words.csv": ("time,front\n0,high\n", "'high'"),
    "ragged.csv": ("# head\ntime,front\n0,1\n0.1\n", "line 4 must have 2 columns, not 1"),
    "twice.csv": ("time,front,front\n0,1,2\n", "names of their own"),
    "timeless.csv": ("time,front\n,1\n", "must have a time"),
}


def compare(output, plot):
    """plot_run draws what was measured over the gauges, tells what it has no gauge for, and refuses broken files."""
    def draw(code, *options):
        done = subprocess.run(["/usr/bin/python3", *plot, *map(str, options)], stdout=subprocess.PIPE, check=False,
                              stderr=subprocess.PIPE, text=True, timeout=120)
        c.expect(done.returncode == code and "Traceback" not in done.stderr, f"plot_run {options}: {done.stderr}")
        return done.stderr, (output / "gauges.png").read_bytes()

    reference = output / "measured.csv"
    reference.write_text(GOOD_REFERENCE, encoding="utf-8")
    plain = (output / "gauges.png").read_bytes()
    told, drawn = draw(0, "--reference", reference)
    c.expect(f"{reference}: there is no gauge for nobody_Pa\n" in told and "front" not in told, f"plot_run tells: {told}")
    told, away = draw(0, "--reference", reference, "--reference-shift", -7)
    c.expect("its times, -7 to -6.9 s, are not the run's" in told, f"plot_run tells: {told}")
    c.expect(away == plain != drawn, "the reference is not in the picture, or not shifted")
    for name, (text, message) in BROKEN_REFERENCES.items():
        broken = output / name
        if text is not None:
            broken.write_text(text, encoding="utf-8")
        told, _ = draw(2, "--reference", reference, "--reference", broken)
        c.expect(f"--reference {broken}: " in told and message in told, f"{name}: {told}")


def plotted(case, _):
    """plot_run draws the time step with its shocks, pressures, and references over gauges."""
    output = case.folder / "drawn"
    launch(case, output, 2, ("output.snapshots.every=0.05",))
    plot = [str(c.SOURCE / "scripts/plot_run"), str(output), "--panels", "2"]
    for options, wanted in ((["--color", "pressure"], "drop_pressure.png"), ([], "drop.png")):
        done = subprocess.run(["/usr/bin/python3", *plot, *options], stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
                              text=True, check=False, timeout=120)
        for name in (wanted, "history.png", "time_step.png"):
            c.expect(done.returncode == 0 and f"{output / name}\n" in done.stdout, f"plot_run, {name}: {done.stdout}")
            c.expect((output / name).stat().st_size > 20000, f"{name} is nearly empty")
    compare(output, plot)
    launch(case, output, 1, ("output.snapshots.every=0.05", "output.snapshots.fields=[velocity]"), ["--force", "--steps", 3])
    done = subprocess.run(["/usr/bin/python3", *plot, "--color", "pressure"], stdout=subprocess.PIPE, check=False,
                          stderr=subprocess.STDOUT, text=True, timeout=120)
    c.expect(done.returncode == 2 and "output.snapshots.fields" in done.stdout, f"without pressures: {done.stdout}")
    return "drop.png, drop_pressure.png, history.png, time_step.png"


if __name__ == "__main__":
    c.main(__doc__, {"shocks": shocks, "restarts": restarts, "prescribed": prescribed, "sessions": sessions, "ends": ends,
                     "spoilt_before": spoilt_before, "pulse": pulse, "plotted": plotted})
