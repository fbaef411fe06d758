#!/usr/bin/python3
"""The same bits on any number of ranks, and anywhere in the world.

Runs scenes on several numbers of ranks and expects the same snapshots (halocline diff) and the same steps.csv, byte
for byte. The first difference is shown.
"""

from pathlib import Path

import case as c

DAM = "scenes/dam_break.yaml"
SMALL = ("particle_spacing=0.05", "output.snapshots.every=0.05")  # 1920 fluid particles


def compare(case, one, other):
    """Two runs agree in steps.csv and in every snapshot; returns the number of snapshots."""
    c.expect_same_text(one / "steps.csv", other / "steps.csv")
    first, second = c.snapshots(one), c.snapshots(other)
    names = [p.name for p in first], [p.name for p in second]
    c.expect(names[0] == names[1], f"different snapshots: {one} has {names[0]}, {other} has {names[1]}")
    for a, b in zip(first, second):
        case.diff(a, b)
    return len(first)


def ranks_agree(case, scene, ranks, settings, steps):
    name = Path(scene).stem
    runs = [case.run(scene, f"{name}_{n}", n, settings, ["--steps", steps]) for n in ranks]
    done = len(c.steps(runs[0]))
    c.expect(done == steps, f"{scene}: asked for {steps} steps, steps.csv has {done}")
    count = min(compare(case, runs[0], run) for run in runs[1:])
    return f"{steps} steps and {count} snapshots are the same on {', '.join(map(str, ranks))} ranks"


def dam_break(case, steps):
    return ranks_agree(case, DAM, (1, 2, 3, 4, 7), SMALL, steps or 60)


def vortices(case, steps):
    """Periodic on all axes."""
    return ranks_agree(case, "tests/cases/vortices.yaml", (1, 4), (), steps or 15)


def gauges(case, steps):
    """A gauge of each kind."""
    text = ranks_agree(case, "tests/cases/gauges.yaml", (1, 3, 7), (), steps or 50)
    for ranks in (3, 7):
        c.expect_same_text(case.folder / "gauges_1/gauges.csv", case.folder / f"gauges_{ranks}/gauges.csv")
    return text + ", gauges.csv too"


def eddies(case, steps):
    """The eddy viscosity of pairs, dfsph and pcisph."""
    steps = steps or 40
    for method in ("dfsph", "pcisph"):
        settings = (f"solver.method={method}", "fluid.viscosity={model: smagorinsky, coefficient: 0.3}", "time_step.control=cfl")
        runs = [case.run("tests/cases/gauges.yaml", f"eddies_{method}_{n}", n, settings, ["--steps", steps]) for n in (1, 3, 7)]
        for run in runs[1:]:
            compare(case, runs[0], run)
            c.expect_same_text(runs[0] / "gauges.csv", run / "gauges.csv")
    return f"{steps} steps with dfsph and with pcisph, and gauges.csv, are the same on 1, 3, 7 ranks"


WEAK = {"constant": ("time_step.control=constant", "time_step.size=0.0005"), "global": ("time_step.control=global",),
        "powers": ("time_step.control=individual",), "raw": ("time_step.control=individual", "time_step.steps=raw"),
        "unlasting": ("time_step.control=individual", "time_step.blocks=false")}


def weak(case, steps):
    """wcsph with steps of every kind, moving walls, emitters and gauges, METIS every few steps, a million cells away too."""
    steps = steps or 40
    for name, control in WEAK.items():
        settings = ("solver.method=wcsph", "fluid.viscosity={model: artificial, coefficient: 0.1}", *control)
        runs = [case.run("tests/cases/gauges.yaml", f"weak_{name}_{ranks}", ranks,
                         (*settings, "parallel.rebalance=metis", f"parallel.rebalance_every={ranks}"), ["--steps", steps])
                for ranks in ((1, 2, 3, 4, 7) if name == "powers" else (1, 3))]
        runs.append(case.run("tests/cases/gauges.yaml", f"weak_{name}_far", 2, (*settings, "origin_cells=[1000000,-1000000,7]"),
                             ["--steps", steps]))
        for run in runs[1:]:
            compare(case, runs[0], run)
            c.expect_same_text(runs[0] / "gauges.csv", run / "gauges.csv")
        substeps = sum(int(row["substeps"]) for row in c.steps(runs[0]))
        c.expect((substeps > steps) == ("individual" in control[0]), f"{name}: {substeps} sub-steps in {steps} steps")
    return f"{steps} steps with {', '.join(WEAK)} steps, and gauges.csv, are the same on 1 and 3 ranks, powers on 2, 4, 7 too, and far away"


def round_tank(case, steps):
    """Round and tilted shapes in an open cylinder."""
    return ranks_agree(case, "tests/cases/round_tank.yaml", (1, 3), (), steps or 100)


def drop(case, steps):
    """A central force and linear velocity fields, dfsph and pcisph."""
    steps = steps or 15
    for method in ("dfsph", "pcisph"):
        settings = (f"solver.method={method}", "particle_spacing=0.1", "domain.max=[0, 0.6, 0]", "fluid.blocks[0].cylinder.length=0.6",
                    "fluid.blocks[0].velocity_gradient={x: [0, 0, 3], y: [1, 0, 0]}", "fluid.blocks[0].rotation=[0.5, 1, -2]",
                    "fluid.settle_steps=0", "fluid.disorder=0", "end_time=1", "central_force={center: [0.1, 0.2, -0.3], rate: 4}", "gravity=[0, 0, -1]")
        agreed = ranks_agree(case, "scenes/elliptical_drop.yaml", (1, 3, 7), settings, steps)
    return agreed


CORNER = "tests/cases/corner.yaml"


def boundary_methods(case, steps):
    """PCISPH with every boundary method, with and without the correction of densities at the surface."""
    steps = steps or 40
    for method, correction, viscosity in (("ihmsen2010", "none", "artificial"), ("ihmsen2010", "shepard", "xsph"),
                                          ("ihmsen2010", "none", "laminar"), ("becker2009", "none", "artificial"), ("harada2007", "shepard", "none"),
                                          ("akinci2012", "none", "laminar")):
        settings = (f"boundary.method={method}", f"solver.density_correction={correction}",
                    f"fluid.viscosity={{model: {viscosity}, coefficient: 0.001}}", "time_step.control=constant",
                    "time_step.size=0.004", "fluid.surface_tension={model: becker2007, coefficient: 1e-4}")
        runs = [case.run(CORNER, f"{method}_{correction}_{viscosity}_{n}", n, settings, ["--steps", steps]) for n in (1, 3)]
        compare(case, *runs)
    return f"{steps} steps with each boundary method are the same on 1 and 3 ranks"


def shock(case, steps):
    """PCISPH through a shock, whose rollback crosses a rebalance."""
    steps = steps or 70
    settings = ("solver.density_error_max=0.055",)
    runs = [case.run(CORNER, f"shock_{n}", n, (*settings, f"parallel.rebalance={'metis' if n > 2 else 'slabs'}",
                                               "parallel.rebalance_at=59"), ["--steps", steps])
            for n in (1, 2, 3, 4, 7)]
    for run in runs[1:]:
        compare(case, runs[0], run)
    events = [row["event"] for row in c.steps(runs[0]) if row["event"]]
    c.expect(events == ["rollback:2"], f"not one rollback by two steps: {events}")
    return f"{steps} steps with a rollback of two, a rebalance between them, are the same on 1, 2, 3, 4, 7 ranks"


def rebalances(output):
    """What load.csv and run.log say of rebalances."""
    load = (output / "load.csv").read_text(encoding="utf-8").count("rebalance")
    lines = [line for line in (output / "run.log").read_text(encoding="utf-8").splitlines() if "rebalanced by" in line]
    c.expect(len(lines) == load, f"{output}: load.csv has {load} rebalances, run.log {len(lines)}")
    return lines


def rebalanced(case, steps):
    """Rebalances forced by the test hooks, by slabs and by METIS, change nothing, on any number of ranks."""
    steps = steps or 30
    plain = case.run(DAM, "rebalance_none", 1, (*SMALL, "parallel.rebalance=none"), ["--steps", steps])
    for ranks in (1, 2, 3, 4, 7):
        for method, first in (("metis", "slabs"), ("slabs", "metis")):
            settings = (*SMALL, f"parallel.rebalance={method}", f"parallel.decomposition={first}",
                        "parallel.rebalance_every=5", f"parallel.rebalance_at={steps // 2 + 1}", f"parallel.ranks_per_host={ranks // 2}")
            forced = case.run(DAM, f"rebalance_{method}_{ranks}", ranks, settings, ["--steps", steps])
            compare(case, plain, forced)
            lines = rebalances(forced)
            c.expect(len(lines) >= (steps - 1) // 5 + 1, f"{forced}: {len(lines)} rebalances")
            c.expect(all(f"by {method} " in line for line in lines), f"{forced}: not all by {method}: {lines}")
    return f"{steps} steps without and with rebalances by slabs and by METIS are the same on 1, 2, 3, 4, 7 ranks"


def far_away(case, steps):
    """A scene shifted by whole cells: its own coordinates do not change, so neither does anything else."""
    steps = steps or 60
    here = case.run(DAM, "here", 2, SMALL, ["--steps", steps])
    there = case.run(DAM, "there", 2, (*SMALL, "origin_cells=[1000000,1000000,1000000]"), ["--steps", steps])
    compare(case, here, there)
    return f"{steps} steps a million cells away are the same"


def instruction_sets(case, steps):
    """AVX2 against the best of this machine (the same run twice where AVX2 is the best)."""
    steps = steps or 60
    best = case.run(DAM, "best", 2, SMALL, ["--steps", steps])
    avx2 = case.run(DAM, "avx2", 2, SMALL, ["--steps", steps], {"HALOCLINE_ISA": "avx2"})
    compare(case, best, avx2)
    return f"{steps} steps with AVX2 and with the machine's best instructions are the same"


def diff_sees(case, steps):
    """The comparison itself: two moments of one run are different, and a missing file cannot be compared."""
    output = case.run(DAM, "diff", 2, SMALL, ["--steps", steps or 20])
    found = c.snapshots(output)
    c.expect(len(found) >= 2, f"{output}: one snapshot only")
    case.call(["diff", found[0], found[0]], expected=0)
    case.call(["diff", found[0], found[-1]], expected=1)
    case.call(["diff", found[0], output / "none.hdf"], expected=2)
    return "halocline diff tells the same, the different and the unreadable apart"


if __name__ == "__main__":
    c.main(__doc__, {"dam_break": dam_break, "vortices": vortices, "gauges": gauges, "eddies": eddies, "weak": weak, "drop": drop,
                     "round_tank": round_tank,
                     "boundary_methods": boundary_methods, "shock": shock, "rebalanced": rebalanced,
                     "far_away": far_away, "instruction_sets": instruction_sets, "diff_sees": diff_sees})
