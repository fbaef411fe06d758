"""Runs that are stopped and go on: the same bytes as without a stop, whatever the ranks; and checkpoints that are damaged."""

import fcntl
import json
import os
import random
import re
import shutil
import signal
import subprocess
import time

from case import MPI_ENVIRONMENT, CaseFailed, expect, expect_same_text, main, snapshots, steps

SCENE = """
name: splash
particle_spacing: 0.05
end_time: 0.7
fluid: {blocks: [{box: {min: [0, 0, 0], max: [0.5, 0.5, 1.0]}}]}
boundary: {walls: [{name: tank, box: {min: [0, 0, 0], max: [1.5, 0.5, 1.2]}}]}
output:
  snapshots: {every: 0.1}
  gauges_every: 0.02
  gauges: [{name: front, type: front, axis: +x}, {name: push, type: force, wall: tank},
           {name: P, type: pressure, at: [1.5, 0.25, 0.2], wall: tank}, {name: q, type: flow, axis: +x,
            box: {min: [0.7, 0, 0], max: [0.7, 0.5, 1.2]}},
           {name: lately, type: force, wall: tank, mean_over: 0.013}, {name: slowly, type: pressure, at: [1.5, 0.25, 0.2],
            wall: tank, radius: 0.15, mean_over: 0.4}]
"""


def scene_of(case, text=SCENE):
    path = case.folder / "splash.yaml"
    path.write_text(text)
    return path


def launch(case, scene, output, ranks=1, options=(), expected=0, environment=None):
    return case.call(["run", scene, "-o", output, "--quiet", *options], ranks, expected, environment=environment)


def checkpoints(output):
    return sorted(p.name for p in (output / "checkpoints").iterdir()) if (output / "checkpoints").is_dir() else []


def expect_same_run(case, one, other):
    for name in ("steps.csv", "gauges.csv", "snapshots/run.hdf.series"):
        expect_same_text(one / name, other / name)
    ours, theirs = snapshots(one), snapshots(other)
    expect([s.name for s in ours] == [s.name for s in theirs], f"snapshots {ours} and {theirs}")
    for left, right in zip(ours, theirs):
        case.diff(left, right)
    case.diff(one / "checkpoints" / checkpoints(one)[-1], other / "checkpoints" / checkpoints(other)[-1])


def reference(case):
    """The run that nobody stopped, made once."""
    output = case.folder / "reference"
    if not output.exists():
        launch(case, scene_of(case), output, 2)
    return output


def exact(case, _):
    """Three stops at random steps, each time other ranks, with and without rebalances."""
    whole = reference(case)
    count = len(steps(whole))
    chance = random.Random(4)
    for number, rebalance in enumerate(REBALANCES):
        output = case.folder / f"stopped_{number}"
        stops = sorted(chance.sample(range(5, count - 5), 3))
        ranks = chance.sample([1, 2, 3, 4, 7], 4)
        for k, (stop, size) in enumerate(zip([*stops, count + 1], ranks)):
            settings = ["--set", f"parallel.rebalance={rebalance}", "--set", "parallel.rebalance_every=9"]
            launch(case, scene_of(case), output, size, [*settings, "--steps", stop, *(["--restart"] if k else [])])
        expect_same_run(case, whole, output)
    return f"{count} steps, stopped after {stops} on {ranks} ranks: the same bytes"


def brief(case, _):
    """One stop, other ranks: for builds in which all takes its time."""
    scene = scene_of(case)
    one, other = case.folder / "at_once", case.folder / "in_two"
    launch(case, scene, one, 1, ["--steps", 14])
    launch(case, scene, other, 3, ["--steps", 9, "--set", "parallel.rebalance_every=4"])
    launch(case, scene, other, 2, ["--steps", 14, "--restart"])
    expect_same_run(case, one, other)
    return "14 steps with a stop after 9: the same bytes"


def eddies(case, _):
    """The same with the eddy viscosity of pairs."""
    scene = scene_of(case, SCENE.replace("fluid: {", "fluid: {viscosity: {model: smagorinsky}, "))
    one, other = case.folder / "at_once", case.folder / "in_two"
    launch(case, scene, one, 1, ["--steps", 60])
    launch(case, scene, other, 3, ["--steps", 40, "--set", "parallel.rebalance_every=4"])
    launch(case, scene, other, 7, ["--steps", 60, "--restart"])
    expect_same_run(case, one, other)
    return "60 steps with a stop after 40: the same bytes"


def weak(case, _):
    """The same with wcsph, whose particles have steps of their own, or one for all."""
    for control in ("individual", "individual, steps: raw", "global"):
        scene = scene_of(case, SCENE.replace("fluid: {", "solver: {method: wcsph}\ntime_step: {control: " + control + "}\nfluid: {"))
        one, other = case.folder / "at_once", case.folder / "in_two"
        launch(case, scene, one, 1, ["--steps", 60, "--force"])
        launch(case, scene, other, 3, ["--steps", 40, "--force", "--set", "parallel.rebalance_every=4"])
        launch(case, scene, other, 7, ["--steps", 60, "--restart"])
        expect_same_run(case, one, other)
    launch(case, scene, other, 1, ["--steps", 70, "--restart", "--set", "time_step.control=individual"], expected=2)
    return "60 steps with a stop after 40: the same bytes; other cells are refused"


REBALANCES = ["none", "slabs", "metis"]


def stops(case, _):
    """Signals and --walltime: exit code 75, then on to the same end."""
    whole = reference(case)
    scene = scene_of(case)
    output = case.folder / "signalled"
    for name in ("SIGTERM", "SIGUSR1", "SIGUSR2"):
        command = [*case.mpiexec, "-n", "1" if name == "SIGTERM" else "2", case.halocline, "run", str(scene), "-o",
                   str(output), "--restart"]
        with subprocess.Popen(command, env={**MPI_ENVIRONMENT, **os.environ}, stdin=subprocess.DEVNULL,
                              stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True) as run:
            deadline = time.monotonic() + 60
            rows = output / "steps.csv"
            begin = rows.read_bytes().count(b"\n") if rows.exists() else 0
            while time.monotonic() < deadline and (not rows.exists() or rows.read_bytes().count(b"\n") < begin + 6):
                time.sleep(0.002)
            target = run.pid
            if name == "SIGTERM":  # the launcher would end its ranks: the signal goes to the rank itself
                target = int(subprocess.run(["pgrep", "-P", str(run.pid)], stdout=subprocess.PIPE, text=True,
                                            check=True).stdout.split()[0])
            os.kill(target, getattr(signal, name))
            text = run.communicate(timeout=60)[0]
        expect(run.returncode == 75, f"{name}: exit code {run.returncode}\n{text}")
        expect(f"stopped by {name}" in text and "--restart" in text, text)
    launch(case, scene, output, 3, ["--restart"])
    expect_same_run(case, whole, output)

    alone = json.loads((whole / "timings.json").read_text(encoding="utf-8"))["wall_seconds"]
    for share in (0.45, 0.2, 0.05):  # the machine may be less busy than it was
        output, sessions = case.folder / f"out_of_time_{share}", 1
        limit = f"{1.1 + share * alone:.2f}"  # a second is kept for the end
        while subprocess.run([*case.mpiexec, "-n", "2", case.halocline, "run", str(scene), "-o", str(output), "--restart",
                              "--quiet", "--walltime", limit], env={**MPI_ENVIRONMENT, **os.environ}, check=False,
                             stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
                             timeout=60).returncode == 75:
            sessions += 1
            expect(sessions < 400, "the run does not get on")
        if sessions > 1:
            break
    expect(sessions > 1, "--walltime never stopped the run")
    expect_same_run(case, whole, output)
    return f"three signals and {sessions} sessions of --walltime: exit code 75, then the same bytes"


def scenes(case, _):
    """What may change at a restart, and what may not."""
    scene = scene_of(case)
    output = case.folder / "changed"
    launch(case, scene, output, 2, ["--steps", 20])
    text = launch(case, scene, output, 2, ["--restart", "--set", "gravity=[0, 0, -9]", "--set", "boundary.walls[0].open=[+z]"], 2)
    expect("gravity: was [0, 0, -9.81], is [0, 0, -9]" in text and "boundary.walls[0].open: was [], is [+z]" in text, text)
    text = launch(case, scene, output, 1, ["--restart", "--set", "output.gauges=[]"], 2)
    expect("output.gauges: was 6 items, is 0 items" in text, text)
    text = launch(case, scene, output, 1, ["--restart", "--set", "output.gauges[4].mean_over=0.02"], 2)
    expect("output.gauges[4].mean_over: was 0.013, is 0.02" in text, text)
    expect(len(steps(output)) == 20, "a refused restart changed steps.csv")
    launch(case, scene, output, 3, ["--restart", "--set", "end_time=0.2", "--set", "output.snapshots.every=0.05",
                                    "--set", "parallel.rebalance=none"])
    log = (output / "run.log").read_text()
    expect("changed since then: end_time: was 0.7, is 0.2; output.snapshots.every: was 0.1, is 0.05" in log, log)
    times = [float(t) for t in re.findall(r'"time":([0-9.e-]+)', (output / "snapshots/run.hdf.series").read_text())]
    expect(len(times) >= 4 and times == sorted(times) and times[-1] == 0.2, f"snapshots at {times}")
    # an interval far below the step: one snapshot a step, and an end
    launch(case, scene, case.folder / "often", 1, ["--steps", 3, "--set", "output.snapshots.every=1e-20"])
    expect(len(snapshots(case.folder / "often")) == 4, "a snapshot of the start and of each step")
    text = launch(case, scene, output, 1, ["--restart", "--force"], 2)
    expect("exclude each other" in text, text)
    return "changes of physics are refused by name, others noted"


def choice(case, _):
    """Which checkpoint a restart takes, and how many are kept."""
    scene = scene_of(case)
    whole = reference(case)
    output = case.folder / "chosen"
    every = ["--set", "output.checkpoints.every_steps=10", "--set", "output.checkpoints.keep=3"]
    launch(case, scene, output, 2, [*every, "--steps", 45])
    expect(checkpoints(output) == [f"ckpt_{k:08d}.h5" for k in (30, 40, 45)], f"kept: {checkpoints(output)}")
    folder = output / "checkpoints"
    bad = bytearray((folder / "ckpt_00000045.h5").read_bytes())
    bad[len(bad) // 2] ^= 4
    (folder / "ckpt_00000045.h5").write_bytes(bad)
    with open(folder / "ckpt_00000040.h5", "r+b") as file:
        file.truncate(5000)
    (folder / ".ckpt_00000050.h5.tmp").write_bytes(b"half")
    text = launch(case, scene, output, 3, ["--restart", *every, "--steps", 50])
    expect("ckpt_00000045.h5: damaged" in text and "ckpt_00000040.h5: has 5000 bytes" in text, text)
    expect("ckpt_00000030.h5, written by 2 ranks: step 30" in (output / "run.log").read_text(), "it must go on from step 30")
    expect(checkpoints(output) == [f"ckpt_{k:08d}.h5" for k in (30, 40, 50)], f"kept: {checkpoints(output)}")
    # an older one by name: what came after it is taken back
    shutil.copy(folder / "ckpt_00000030.h5", case.folder / "mine.h5")
    launch(case, scene, output, 2, [f"--restart={case.folder / 'mine.h5'}", "--steps", 33])
    expect(checkpoints(output) == [f"ckpt_{k:08d}.h5" for k in (30, 33)], f"kept: {checkpoints(output)}")
    expect(len(steps(output)) == 33, "rows after the checkpoint must go")
    launch(case, scene, output, 1, ["--restart"])
    expect_same_run(case, whole, output)
    launch(case, scene, output, 4, ["--restart"])  # nothing to do
    expect_same_run(case, whole, output)

    for name in checkpoints(output):
        (folder / name).write_bytes(b"Halocline checkpoint, format 9\nbytes 2000\n" + bytes(2000))
    text = launch(case, scene, output, 3, ["--restart"], 3)
    expect("format 9" in text and "none of the" in text, text)
    text = launch(case, scene, output, 2, [f"--restart={case.folder / 'nowhere.h5'}"], 3)
    expect("nowhere.h5: cannot be opened: No such file" in text, text)
    shutil.rmtree(folder)
    text = launch(case, scene, output, 2, ["--restart", "--steps", 3])
    expect("starts over" in text and len(steps(output)) == 3, text)
    return "the newest valid one is taken, the rest named; keep holds"


def taken_back(case, _):
    """A run that goes back to an older checkpoint and dies leaves nothing behind that a later restart could take."""
    scene = scene_of(case)
    output = case.folder / "taken_back"
    every = ["--set", "output.checkpoints.every_steps=15", "--set", "output.checkpoints.keep=3"]
    launch(case, scene, output, 2, [*every, "--steps", 45])
    old = output / "checkpoints/ckpt_00000015.h5"
    shutil.copy(old, case.folder / "old.h5")
    launch(case, scene, output, 2, [f"--restart={old}", "--set", "faults.nan_at=20"], 1)
    expect(checkpoints(output) == [old.name], f"checkpoints of what was taken back: {checkpoints(output)}")
    expect((output / "snapshots/fault_000021.hdf").exists(), "the fault left no snapshot")
    launch(case, scene, output, 3, ["--restart"])
    expect_same_run(case, reference(case), output)
    expect(not (output / "snapshots/fault_000021.hdf").exists(), "the fault that was taken back has still a snapshot")

    # a directory without tables but with a checkpoint is no free one, and another run's is not taken over
    (output / "steps.csv").unlink()
    (output / "scene.yaml").rename(case.folder / "scene.yaml")
    text = launch(case, scene, output, 1, [], 2)
    expect("already holds a run (checkpoints)" in text, text)
    (output / "scene.yaml").write_text((case.folder / "scene.yaml").read_text().replace("0.05", "0.06")
                                       .replace("support_radius: 0.1", "support_radius: 0.12"))
    text = launch(case, scene, output, 2, [f"--restart={case.folder / 'old.h5'}"], 2)
    expect("particle_spacing: was 0.06, is 0.05" in text, text)
    return "later checkpoints go before the rows do"


def losses(case, _):
    """A run that goes on says what of it is not there, makes the series anew, and says where there is nothing left to do."""
    scene, output = scene_of(case), case.folder / "losses"
    launch(case, scene, output, 1, ["--steps", 60])
    series = output / "snapshots" / "run.hdf.series"
    kept = series.read_text(encoding="utf-8")
    series.unlink()
    (output / "steps.csv").unlink()
    text = launch(case, scene, output, 2, ["--restart", "--steps", 60])
    for word in ("steps.csv is not there: it begins anew behind step 60", "run.hdf.series was not there: made anew from the snapshots"):
        expect(word in text, f"nothing says {word!r}:\n{text}")
    entries = [line.strip(" ,") for line in kept.splitlines() if "snap_" in line]
    missing = [entry for entry in entries[:-1] if entry not in series.read_text(encoding="utf-8")]  # the last is the end's
    expect(entries[1:] and not missing, f"the series made anew lacks {missing}")
    text = launch(case, scene, output, 1, ["--restart", "--set", "end_time=0.001"])
    expect("past end_time (0.001 s): there is nothing left to do" in text, f"a run past its end says nothing:\n{text}")
    with open(snapshots(output)[0], "rb") as file:
        fcntl.flock(file, fcntl.LOCK_EX)
        text = case.call(["info", snapshots(output)[0]], expected=2)
    expect("in use by another program" in text, f"info on a locked file: {text}")
    return "lost files are told, the series is made anew, an end that is past and a locked file are called so"


def damage(case, count):
    """Random damage of the newest of two checkpoints: always found, and the older one taken, or exit code 3."""
    scene = scene_of(case)
    output = case.folder / "damaged"
    launch(case, scene, output, 2, ["--set", "output.checkpoints.every_steps=20", "--steps", 25])
    files = [output / "checkpoints" / name for name in checkpoints(output)]
    expect(len(files) == 2, f"two checkpoints are wanted, there are {files}")
    good = [file.read_bytes() for file in files]
    kept = case.folder / "kept"
    shutil.copytree(output, kept)
    chance = random.Random(7)
    count = count or 8
    for number in range(count):
        data = bytearray(good[1])
        place = len(data) * number // count + chance.randrange(max(1, len(data) // count))
        place = min(place, len(data) - 1)
        how = chance.choice(["flip", "flip", "zero", "cut", "grow", "hole", "swap"])
        if number < max(2, count // 10):
            place = chance.randrange(600)  # the seal and HDF5's own beginning
        if how == "flip":
            data[place] ^= 1 << chance.randrange(8)
        elif how == "zero":
            data[place:place + 64] = bytes(len(data[place:place + 64]))
        elif how == "cut":
            del data[place:]
        elif how == "grow":
            data += bytes(chance.randrange(1, 5000))
        elif how == "hole":
            del data[place:place + chance.randrange(1, 100)]
        else:
            other = chance.randrange(len(data))
            data[place], data[other] = data[other], data[place]
        if bytes(data) == good[1]:
            data[place] ^= 255
        alone = number % 5 == 4  # no older one to fall back to
        files[1].write_bytes(data)
        files[0].write_bytes(b"" if alone else good[0])
        case.call(["info", files[1]], expected=2)
        text = launch(case, scene, output, 1 + number % 2, ["--restart", "--steps", 21], 3 if alone else 0)
        expect("checkpoint passed over" in text, f"{how} at byte {place} of {len(good[1])} was not found:\n{text}")
        if not alone:
            expect("step 20" in (output / "run.log").read_text(), "it must go on from step 20")
            shutil.rmtree(output)
            shutil.copytree(kept, output)
    return f"{count} damages, all found"


def disk_full(case, _):
    """A small tmpfs that fills up at each stage of output: exit code 3, and the older checkpoints stay valid."""
    if os.geteuid() != 0:
        return "skipped: mounting a small disk needs root"
    scene = scene_of(case)
    disk = case.folder / "disk"
    disk.mkdir()
    if subprocess.run(["mount", "-t", "tmpfs", "-o", "size=2200k", "tmpfs", str(disk)], check=False,
                      stderr=subprocess.DEVNULL).returncode != 0:
        return "skipped: no tmpfs can be mounted here"
    seen = set()
    try:
        output = disk / "run"
        often = ["--set", "output.checkpoints.every_steps=5", "--set", "output.snapshots.every=0.02"]
        launch(case, scene, output, 2, [*often, "--steps", 12])
        for room in range(1600, 0, -310):
            filler = disk / "filler"
            filler.unlink(missing_ok=True)
            free = shutil.disk_usage(disk).free
            filler.write_bytes(bytes(max(0, free - room * 1024)))
            command = ["run", scene, "-o", output, "--quiet", "--restart", *often]
            try:
                text = case.call(command, 2, 3)
            except CaseFailed as failure:
                if "exit code 0" in str(failure):
                    continue
                raise
            expect("No space left" in text or "are free" in text, text)
            seen.update(re.findall(r"(checkpoint|snapshot|steps.csv|load.csv|gauges.csv|scene.yaml|run.log)[^\n]*(?:No space|are free)",
                                   text))
            for name in checkpoints(output):
                if name.startswith("ckpt_"):
                    case.call(["info", output / "checkpoints" / name])
        (disk / "filler").unlink()
        for number in range(40):  # room again, by taking old snapshots away
            for old in snapshots(output)[:-1]:
                old.unlink()
            try:
                case.call(["run", scene, "-o", output, "--quiet", "--restart", "--set", "output.snapshots.every=0"], 3)
                break
            except CaseFailed as failure:
                expect("exit code 3" in str(failure), str(failure))
        expect_same_text(reference(case) / "steps.csv", output / "steps.csv")
        expect_same_text(reference(case) / "gauges.csv", output / "gauges.csv")
    finally:
        subprocess.run(["umount", str(disk)], check=False)
    return f"full at {', '.join(sorted(seen))}: exit code 3, and the run goes on once there is room"


if __name__ == "__main__":
    main(__doc__, {"exact": exact, "brief": brief, "eddies": eddies, "weak": weak, "stops": stops, "scenes": scenes, "choice": choice, "taken_back": taken_back, "losses": losses, "damage": damage,
                   "disk_full": disk_full})
