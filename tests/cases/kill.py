"""Kills a run again and again, restarts it each time, and compares what is left with the run that nobody killed.

    kill.py [HALOCLINE] [--rounds N] [--seed S] [--mpiexec MPIRUN] [--shocks]

A round starts the run with --restart, on another number of ranks each time and with or without rebalancing, and ends it
with SIGKILL at a random moment: one rank of it, or the launcher. Every third kill waits until a checkpoint is being
written. Every restart must go on by itself; a run that gets to its end is compared (snapshots, steps.csv, gauges.csv,
the last checkpoint) and started over. After N kills the run under way is finished and compared too.
"""

import argparse
import os
import random
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import rollback
from case import MPI_ENVIRONMENT, Case, CaseFailed, expect, expect_same_text, snapshots

SCENE = """
name: killed
particle_spacing: 0.05
end_time: {end}
fluid: {{blocks: [{{box: {{min: [0, 0, 0], max: [0.5, 0.5, 1.0]}}}}]}}
boundary: {{walls: [{{name: tank, box: {{min: [0, 0, 0], max: [1.5, 0.5, 1.2]}}}}]}}
output:
  snapshots: {{every: 0.1}}
  checkpoints: {{every_steps: 7, keep: 2}}
  gauges_every: 0.02
  gauges: [{{name: front, type: front, axis: +x}}, {{name: push, type: force, wall: tank}}]
"""


def start(case, scene, output, ranks, extra):
    command = [*case.mpiexec, "-n", str(ranks), case.halocline, "run", str(scene), "-o", str(output), "--quiet", *extra]
    return subprocess.Popen(command, env={**MPI_ENVIRONMENT, **os.environ}, stdin=subprocess.DEVNULL,
                            stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, errors="replace",
                            start_new_session=True)


def ranks_of(launcher, program):
    """Process ids of the ranks: below the launcher, running the program."""
    below = {}
    for entry in Path("/proc").iterdir():
        if not entry.name.isdigit():
            continue
        try:
            fields = (entry / "stat").read_text().rsplit(")", 1)[1].split()
            name = os.readlink(entry / "exe")
        except OSError:
            continue
        below.setdefault(int(fields[1]), []).append((int(entry.name), name))
    found, todo = [], [launcher.pid]
    while todo:
        for pid, name in below.get(todo.pop(), []):
            todo.append(pid)
            if name == program:
                found.append(pid)
    return found


def checkpoint_under_way(output):
    folder = output / "checkpoints"
    return folder.is_dir() and any(name.name.startswith(".ckpt_") for name in folder.iterdir())


def kill_in_time(case, launcher, output, chance, into_checkpoint, longest):
    """Kills at the moment wanted; False if the run ended by itself before."""
    deadline = time.monotonic() + (60 if into_checkpoint else chance.uniform(0.0, longest))
    skip = chance.randrange(12)
    while time.monotonic() < deadline:
        if launcher.poll() is not None:
            return False
        if into_checkpoint and checkpoint_under_way(output):
            if skip == 0:
                break
            skip -= 1
            while checkpoint_under_way(output) and launcher.poll() is None:
                time.sleep(0.0002)
        time.sleep(0.0005)
    time.sleep(chance.uniform(0, 0.004) if into_checkpoint else 0)
    victims = ranks_of(launcher, case.halocline)
    victim = chance.choice([launcher.pid, *victims]) if victims else launcher.pid
    try:
        os.kill(victim, signal.SIGKILL)
    except ProcessLookupError:
        return False
    return True


def compare(case, reference, output):
    for name in ("steps.csv", "gauges.csv"):
        expect_same_text(reference / name, output / name)
    expect_same_text(reference / "snapshots/run.hdf.series", output / "snapshots/run.hdf.series")
    ours, theirs = snapshots(reference), snapshots(output)
    expect([s.name for s in ours] == [s.name for s in theirs], f"other snapshots: {theirs}")
    for one, other in zip(ours, theirs):
        case.diff(one, other)
    last = sorted((reference / "checkpoints").glob("ckpt_*.h5"))[-1]
    case.diff(last, output / "checkpoints" / last.name)


def play(case, rounds, seed, text):
    chance = random.Random(seed)
    scene = case.folder / "killed.yaml"
    scene.write_text(text)
    reference, output = case.folder / "reference", case.folder / "killed"
    begin = time.monotonic()
    case.call(["run", scene, "-o", reference, "--quiet"], 2)
    longest = 0.7 * (time.monotonic() - begin) + 0.3
    killed = into = finished = 0
    while killed < rounds:
        ranks = chance.choice([1, 2, 3, 4, 7])
        rebalance = chance.choice(["none", "slabs", "metis"])
        extra = ["--restart", "--set", f"parallel.rebalance={rebalance}", "--set",
                 f"parallel.rebalance_every={chance.choice([0, 5])}"]
        launcher = start(case, scene, output, ranks, extra)
        aimed = into < killed // 3
        if kill_in_time(case, launcher, output, chance, aimed, longest):
            killed += 1
            into += aimed
        text = launcher.communicate(timeout=120)[0]
        if launcher.returncode == 0:
            finished += 1
            compare(case, reference, output)
            shutil.rmtree(output)
        else:
            expect("halocline: error" not in text, f"after {killed} kills: {text[-3000:]}")
    launcher = start(case, scene, output, 2, ["--restart"])
    text = launcher.communicate(timeout=300)[0]
    expect(launcher.returncode == 0, f"the last restart ends with {launcher.returncode}\n{text[-3000:]}")
    compare(case, reference, output)
    return f"{killed} kills, {into} of them at a checkpoint; {finished + 1} runs finished, all as the one left alone"


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("halocline", nargs="?", default="build/release/halocline", help="the program")
    parser.add_argument("--mpiexec", default="mpirun", help="the launcher (default: mpirun)")
    parser.add_argument("--rounds", type=int, default=100)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--end", type=float, default=1.0, help="simulated seconds of the run")
    parser.add_argument("--shocks", action="store_true", help="with the adaptive time step, whose shocks take steps back")
    options = parser.parse_args()
    scene = SCENE.format(end=options.end)
    if options.shocks:
        scene = rollback.SCENE.replace("every: 0.0002}", "every: 0.01}\n  checkpoints: {every_steps: 3}")
    folder = Path(tempfile.mkdtemp(prefix="halocline_kill_"))
    try:
        print(play(Case(options.halocline, options.mpiexec, folder), options.rounds, options.seed, scene))
    except CaseFailed as error:
        print(f"FAILED with --seed {options.seed}; the runs are in {folder}\n{error}")
        sys.exit(1)
    shutil.rmtree(folder, ignore_errors=True)


main()
