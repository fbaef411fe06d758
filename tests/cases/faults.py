#!/usr/bin/python3
"""Runs that fail: they say which particle, where and why, leave a snapshot of the moment, and lose nothing.

The faults are those of the test hooks (keys faults.*) and those that scenes can have; on one rank and on three.
"""

import re
import shutil
import subprocess
import tempfile
from pathlib import Path

import bad_input as b
import case as c

DAM = ["run", c.SOURCE / "scenes/dam_break.yaml", "--quiet", "--force", "--set", "particle_spacing=0.05"]  # 1920 fluid particles
RANKS = (1, 3)

# Name: settings, the step that fails, and what the message must hold.
FAULTS = {
    "no number": (["faults.nan_at=12"], 13, "the velocity or pressure of particle 959 was no number",
                  "particle 959 (number 959 of fluid.blocks[0]): at (0.7768", "likely cause: the test hook faults.nan_at"),
    "kicked": (["faults.kick_at=12"], 13, "particle 959 would move by 396 m", "more than a support radius",
               "likely cause: the test hook faults.kick_at"),
    "no number, portable viscosity": (["faults.nan_at=2", "fluid.viscosity.model=artificial"], 3, "particle 959"),
    "too long a step": (["time_step={control: constant, size: 0.05, max: 0.05}"], None, "more than a support radius",
                        "the time step is too long", "lower time_step.size"),
    "too fast a start": (["fluid.blocks[0].velocity=[5, 0, 0]", "time_step={control: constant, size: 0.05, max: 0.05}"], 1,
                         "would move by 0.25 m", "a speed of 5 m/s allows 0.004 s"),
    "a step under the floor": (["time_step.min=0.0019"], None, "the time step, ", "is under its floor"),
    "too fast for the floor": (["fluid.blocks[0].velocity=[1e9, 0, 0]"], 1, "is under its floor", "its speed asks"),
    "an own step under the floor": (["solver.method=wcsph", "fluid.viscosity={model: artificial, coefficient: 0.1}",
                                     "time_step={control: individual, min: 0.0005}"], None, "asks for a time step of", "under the floor",
                                    "lower time_step.min"),
    "too viscous": (["fluid.viscosity={model: laminar, coefficient: 1e5}"], 1, "is under its floor",
                    "the viscosity allows"),
    "too viscous beside eddies": (["fluid.kinematic_viscosity=1e5", "fluid.viscosity={model: smagorinsky, coefficient: 0.15}"], 1,
                                  "is under its floor", "the viscosity allows"),
    "too viscous for a constant step": (["fluid.viscosity={model: laminar, coefficient: 100}",
                                         "time_step={control: constant, size: 0.004}"], None, "diverged",
                                        "the viscosity allows time steps of 3.13e-06 s"),
    "a solver at its cap": (["solver.negative_pressure=true", "solver.relaxation=1", "solver.density_iterations.max=20",
                             "boundary.walls[0].box.max=[0.8, 0.5, 0.6]", "boundary.wall_density=sum"], 1,
                            "more than a support radius", "the density solver was at its cap of 20 iterations in step 1"),
    "a wall missing": (["boundary.walls[0].open=[+z, -z]", "domain.limits={min: [-1, -1, -0.3], max: [3, 2, 3]}"], None,
                       "has left the world's limits", "likely cause: it is outside the walls", "domain.leaving: remove"),
}


def message_of(text):
    """The error, all its lines, without what the launcher adds."""
    found = re.search(r"halocline: error: (.*(?:\n  .*)*)", text)
    c.expect(found, f"no error in\n{text[:3000]}")
    return found.group(1)


def fault_snapshots(output):
    return sorted((output / "snapshots").glob("fault_*.hdf"))


def fail(case, name):
    """The same message and the same snapshot on any number of ranks."""
    settings, step, *words = FAULTS[name]
    said, moments = [], []
    folder = Path(tempfile.mkdtemp(dir=case.folder))
    for ranks in RANKS:
        output = folder / f"on_{ranks}"
        arguments = [*map(str, DAM), "-o", str(output), "--steps", "400"]
        for setting in settings:
            arguments += ["--set", setting]
        code, text = b.start(case, arguments, folder, ranks)
        b.expect_message(f"{name}, {ranks} ranks", code, text, 1, ["halocline: error: the simulation ", *words])
        said.append(message_of(text).replace(str(output), "DIR"))
        moment = fault_snapshots(output)
        c.expect(len(moment) == 1, f"{name}, {ranks} ranks: snapshots of the fault: {moment}")
        c.expect(step is None or moment[0].name == f"fault_{step:06d}.hdf", f"{name}: {moment[0].name}, not of step {step}")
        c.expect(f"DIR/snapshots/{moment[0].name}" in said[-1], f"{name}: the message does not name {moment[0]}\n{text}")
        c.expect(moment[0].name not in (output / "snapshots/run.hdf.series").read_text(), f"{name}: it is in the series")
        c.expect("the simulation " in (output / "run.log").read_text(), f"{name}: run.log does not tell why it ended")
        b.expect_whole(output)
        moments.append(moment[0])
    c.expect(len(set(said)) == 1, f"{name}: different messages\n" + "\n".join(said))
    b.expect_message(f"info, {name}", *b.start(case, ["info", moments[0]], folder, 1), 0, ["fluid"])
    code, text = b.start(case, ["diff", *moments], folder, 1)
    c.expect(code == 0, f"{name}: the snapshots of the fault differ\n{text[:2000]}")


def named(case, _):
    count = b.all_of([(fail, case, name) for name in FAULTS])
    return f"{count} faults are named alike on {', '.join(map(str, RANKS))} ranks, with a snapshot of the moment"


def plotted(case, _):
    """plot_run draws a run that failed, its broken moment too; --force clears it."""
    output = case.folder / "plotted"
    arguments = [*DAM, "-o", output, "--steps", 40]
    case.call([*arguments, "--set", "faults.nan_at=12"], 2, expected=1)
    c.expect(fault_snapshots(output), "no snapshot of the fault")
    done = subprocess.run(["/usr/bin/python3", str(c.SOURCE / "scripts/plot_run"), str(output)], stdout=subprocess.PIPE,
                          stderr=subprocess.STDOUT, text=True, check=False)
    c.expect(done.returncode == 0 and "left out" not in done.stdout, f"plot_run: {done.stdout}")
    case.call(arguments, 2)
    c.expect(not fault_snapshots(output), "--force left the snapshot of the old run's fault")
    return "a run that failed can be drawn, and --force clears its snapshot"


def unwritable(case, _):
    """The snapshot of the fault cannot be written: both are said, and the exit code is that of the fault."""
    for ranks in RANKS:
        output = case.folder / f"unwritable_{ranks}"
        shutil.rmtree(output, ignore_errors=True)
        (output / "snapshots/.fault_000013.hdf.tmp").mkdir(parents=True)
        arguments = [str(a) for a in [*DAM, "-o", output, "--steps", 40, "--set", "faults.nan_at=12"] if a != "--force"]
        code, text = b.start(case, arguments, case.folder, ranks)
        b.expect_message(f"no snapshot, {ranks} ranks", code, text, 1,
                         ["the simulation diverged in step 13", "its snapshot could not be written: ", "fault_000013.hdf",
                          "Is a directory"])
        c.expect(len(c.steps(output)) == 12, f"{output}: steps.csv has {len(c.steps(output))} rows, not 12")
    return "a fault whose snapshot fails is told with it"


def removed(case, _):
    """Particles that leave are taken out, counted and told; the rest has the same bits on any number of ranks."""
    settings = ("particle_spacing=0.05", "boundary.walls[0].open=[+z, -z]",
                "domain.limits={min: [-1, -1, -0.3], max: [3, 2, 3]}", "domain.leaving=remove", "output.snapshots.every=0.2",
                "output.gauges=[{name: volume, type: volume}, {name: energy, type: energy}]")
    runs = [case.run("scenes/dam_break.yaml", f"removed_{n}", n, settings, ["--steps", 80]) for n in (1, 3, 4)]
    rows = c.steps(runs[0])
    total = 1920
    for row in rows:
        events = [event for event in row["event"].split("+") if event.startswith("removed:")]
        total -= sum(int(event.split(":")[1]) for event in events)
        c.expect(int(row["fluid_particles"]) == total, f"step {row['step']}: {row['fluid_particles']} particles, not {total}")
    c.expect(0 < total < 1800, f"{1920 - total} of 1920 particles were removed")
    for run in runs[1:]:
        c.expect_same_text(runs[0] / "steps.csv", run / "steps.csv")
        c.expect_same_text(runs[0] / "gauges.csv", run / "gauges.csv")
        for one, other in zip(c.snapshots(runs[0]), c.snapshots(run)):
            case.diff(one, other)
    log = (runs[0] / "run.log").read_text(encoding="utf-8")
    single = re.findall(r"warning step \d+: particle \d+ \(number \d+ of fluid\.blocks\[\d+\]\) has left the world at \(.*\) m; removed", log)
    c.expect(len(single) == 10, f"{len(single)} particles are told one by one, not 10")
    c.expect(re.search(r"warning step \d+: \d+ particles have left the world; removed", log), "no count of the others")
    return f"{1920 - total} particles that left were removed, on 1, 3 and 4 ranks"


def counted(case, _):
    """A warning of many steps is told ten times, then seldom; its count goes on in a restart, and the end has the total."""
    settings = ("particle_spacing=0.05", "solver.density_iterations={min: 2, max: 2}",
                "solver.density_error_avg=1e-9", "output.snapshots.every=1")
    output = case.run("scenes/dam_break.yaml", "counted", 2, settings, ["--steps", 60])
    again = [argument for setting in settings for argument in ("--set", setting)]
    case.call(["run", c.SOURCE / "scenes/dam_break.yaml", "-o", output, "--quiet", "--restart", "--steps", 130, *again], 3)
    log = (output / "run.log").read_text(encoding="utf-8")
    capped = sum("density_cap" in row["event"] for row in c.steps(output))
    told = re.findall(r"warning step (\d+): density solver at its cap", log)
    c.expect(100 <= capped < 1000 and len(told) == 11, f"{capped} steps at the cap, told {told}")
    c.expect("; further ones are counted" in log and "; the 100th of its kind" in log, "the log does not say that it counts")
    totals = re.findall(r"warnings in all: density solver at its cap (\d+)", log)
    c.expect(len(totals) == 2 and int(totals[1]) == capped, f"totals {totals}, not {capped}")
    return f"{capped} steps at the solver's cap are told {len(told)} times, over a restart"


def memory(case, _):
    """One rank of three runs out of memory: a message, exit code 1, and nobody waits."""
    scene = case.folder / "scene.yaml"
    scene.write_text(b.GOOD, encoding="utf-8")
    script = ('[ "$OMPI_COMM_WORLD_RANK" = 1 ] && exec prlimit --as="$1" -- "${@:2}"; exec "${@:2}"')
    for limit in (800, 900):
        for attempt in range(2):
            code, text = b.start(case, ["run", "scene.yaml", "-o", f"memory_{limit}_{attempt}", "--quiet", "--steps", "2",
                                        "--set", "particle_spacing=2.2e-3"], case.folder, 3,
                                 within=["bash", "-c", script, "sh", f"{limit}000000"])
            c.expect(code == 1 and "out of memory" in text, f"{limit} MB on one rank: exit code {code}\n{text[:3000]}")
    return "one rank that runs out of memory ends them all"


if __name__ == "__main__":
    c.main(__doc__, {"named": named, "plotted": plotted, "unwritable": unwritable, "removed": removed, "counted": counted,
                    "memory": memory})
