#!/usr/bin/python3
"""Small runs under valgrind's memcheck: no read of what was never written, nothing out of bounds, no leak.

What MPI and other libraries do is left out by scripts/valgrind.supp. Needs valgrind; it knows no AVX-512, so the loops
are those of AVX2.
"""

import shlex
import shutil
from pathlib import Path

import case as c

WRONG = 99
OPTIONS = ("--quiet", f"--error-exitcode={WRONG}", "--leak-check=full", "--show-leak-kinds=definite,indirect",
           "--errors-for-leak-kinds=definite,indirect", "--track-origins=yes", "--num-callers=30",
           "--keep-debuginfo=yes",  # MPI unloads libraries before the end
           f"--suppressions={c.SOURCE / 'scripts/valgrind.supp'}")
SMALL = ("particle_spacing=0.1", "output.snapshots.every=0.004")


def memcheck(case, ranks, arguments):
    valgrind = shutil.which("valgrind")
    c.expect(valgrind, "valgrind is not installed (apt-get install valgrind)")
    watched = c.Case(valgrind, shlex.join(case.mpiexec), case.folder)
    watched.call([*OPTIONS, case.halocline, *arguments], ranks, environment={"HALOCLINE_ISA": "avx2"})


def run(case, ranks, scene, settings, steps):
    output = case.folder / f"{Path(scene).stem}_{ranks}"
    arguments = ["run", c.SOURCE / scene, "-o", output, "--quiet", "--steps", steps]
    for setting in settings:
        arguments += ["--set", setting]
    memcheck(case, ranks, arguments)
    return c.snapshots(output)


def one_rank(case, steps):
    """A run, and the commands that look at it."""
    found = run(case, 1, "scenes/dam_break.yaml", SMALL, steps or 4)
    c.expect(len(found) >= 2, f"the run wrote {len(found)} snapshots")
    memcheck(case, 1, ["check", c.SOURCE / "scenes/dam_break.yaml"])
    memcheck(case, 1, ["info", found[-1]])
    memcheck(case, 1, ["diff", found[-1], found[-1]])
    return "a run, check, info and diff are clean"


def two_ranks(case, steps):
    """Ghosts, a rebalance and every kind of gauge."""
    steps = steps or 4
    run(case, 2, "tests/cases/gauges.yaml", (f"parallel.rebalance_at={steps // 2}",), steps)
    return "a run on 2 ranks is clean"


def restart(case, steps):
    """A run that goes on from a checkpoint."""
    steps = steps or 4
    run(case, 2, "tests/cases/gauges.yaml", (), steps)
    memcheck(case, 2, ["run", c.SOURCE / "tests/cases/gauges.yaml", "-o", case.folder / "gauges_2", "--quiet", "--restart",
                       "--steps", steps + 3])
    found = sorted((case.folder / "gauges_2/checkpoints").glob("ckpt_*.h5"))
    c.expect(len(found) == 2, f"checkpoints: {found}")
    memcheck(case, 1, ["info", found[-1]])
    return "a restart on 2 ranks is clean"


def pcisph(case, steps):
    """A shock taken back, walls of two layers; then walls that move, openings and meshes."""
    steps = steps or 5
    method = ("solver.method=pcisph", "boundary.method=ihmsen2010", "time_step={control: adaptive, max: 0.02}")
    rows = run(case, 2, "tests/cases/corner.yaml", ("particle_spacing=0.1", "faults.shock_at=3", "fluid.surface_tension={model: becker2007, coefficient: 1e-4}",
                                                    "solver.density_correction=shepard"), steps)
    c.expect("rollback" in (rows[0].parents[1] / "steps.csv").read_text(encoding="utf-8"), "no rollback")
    coarse = (*method, "fluid.viscosity={model: artificial, coefficient: 0.02}")
    opening = "{disc: {position: [0.3, 0.125, 0.45], direction: [0, 0, -1], radius: 0.04}, speed: 1.5}"
    run(case, 1, "tests/cases/prescribed.yaml", (*coarse, f"fluid.emitters=[{opening}]"), steps)
    run(case, 1, "scenes/meshes.yaml", coarse, 2)
    return "runs with PCISPH are clean"


if __name__ == "__main__":
    c.main(__doc__, {"one_rank": one_rank, "two_ranks": two_ranks, "restart": restart, "pcisph": pcisph})
