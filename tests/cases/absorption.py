#!/usr/bin/python3
"""Walls that absorb waves, in whole runs: the same bits, water comes in and goes out, still water stays, what is refused.

Scenes are put together here, at a spacing of 0.05 m.
"""

import case as c

METHODS = {"dfsph": (), "pcisph": ("solver.method=pcisph", "fluid.viscosity.model=artificial"),
           "wcsph": ("solver.method=wcsph", "fluid.viscosity.model=artificial")}


def write(case, name, blocks, absorption="{wall: end, ocean_height: 0.4}"):
    """A trough 1.2 m long, periodic across; its end at x = 1.2 absorbs."""
    return case.write(name, f"""
particle_spacing: 0.05
end_time: 1.5
domain: {{periodic: [false, true, false], min: [0, 0, 0], max: [0, 0.4, 0], leaving: remove}}
fluid: {{blocks: [{blocks}]}}
boundary:
  walls:
    - {{name: trough, box: {{min: [0, 0, 0], max: [1.2, 0.4, 1]}}, inside: fluid, open: [+x, -y, +y, +z]}}
    - {{name: end, plane: {{point: [1.2, 0.2, 0.4], normal: [-1, 0, 0], size: [0.4, 1.2]}}, surface_velocity: [0, 0.2, 0]}}
absorption: [{absorption}]
output: {{snapshots: {{every: 0.5}}, gauges_every: 0.05, gauges: [{{name: H, type: height, at: [0.9, 0.2]}}, {{name: E, type: energy}}]}}
""")


STILL = "{box: {min: [0, 0, 0], max: [1.2, 0.4, 0.4]}}"
COLUMN = f"{STILL}, {{box: {{min: [0, 0, 0.4], max: [0.4, 0.4, 0.8]}}}}"
AWAY = "{box: {min: [0, 0, 0], max: [1.2, 0.4, 0.5]}, velocity: [-0.8, 0, 0]}"


def counted(output, word):
    """How many particles the events of that word were of."""
    events = [event.split(":") for row in c.steps(output) for event in row["event"].split("+")]
    return sum(int(event[1]) for event in events if event[0] == word)


def bits(case, steps):
    """Ranks, rebalances and the place in the world change nothing, with any solver, nor does a step that is taken back."""
    scene = write(case, "away", AWAY)
    for name, method in METHODS.items():
        settings = (*method, f"end_time={0.25 if name == 'wcsph' else 0.5}")
        plain = case.same_everywhere(scene, name, settings, (2, 3, 4, 7) if name == "dfsph" else (3,), 9)
        c.expect(counted(plain, "outflow") > 30, f"{counted(plain, 'outflow')} particles went out")
        c.expect(counted(plain, "inflow") > 20, f"{counted(plain, 'inflow')} particles came in")
    shocks = [case.run(scene, f"shock_{ranks}", ranks, (*METHODS["pcisph"], "faults.shock_at=60"), ["--steps", 80]) for ranks in (1, 3)]
    case.same(*shocks)
    c.expect(any("rollback" in row["event"] for row in c.steps(shocks[0])), "no step was taken back")
    return ", ".join(METHODS)


def restart(case, steps):
    """Stopped while water goes out and comes in, and gone on with on other ranks: the same bytes."""
    scene = write(case, "away", AWAY)
    for name in ("dfsph", "pcisph"):
        settings = (*METHODS[name], "end_time=0.4")
        whole = case.run(scene, f"{name}_whole", 2, settings)
        rows = c.steps(whole)
        first = next(int(row["step"]) for row in rows if "inflow" in row["event"])
        for ranks, stop in ((3, first), (1, (first + len(rows)) // 2)):
            case.goes_on(scene, whole, name, stop, ranks, settings)
    return "stopped as the first came in, and later"


def level(case, steps):
    """A wave is taken up: the energy goes and the level comes back; still water stays as it is."""
    still = case.run(write(case, "still", STILL), "still")
    gone, come = counted(still, "outflow"), counted(still, "inflow")
    c.expect(gone + come <= 12, f"of still water {gone} went out and {come} came in")
    energy = {}
    for name, absorption in (("taken", "{wall: end, ocean_height: 0.4}"), ("closed", "")):
        output = case.run(write(case, name, COLUMN, absorption), name, 1, ("end_time=3",))
        rows = [row for row in c.steps(output) if float(row["time"]) > 2.5]
        energy[name] = sum(float(row["kinetic_energy"]) for row in rows) / len(rows)
        if absorption:
            left = int(rows[-1]["fluid_particles"])
            c.expect(abs(left / 1536 - 1) < 0.04, f"{left} particles for 1536 of still water")
    c.expect(energy["taken"] < 0.3 * energy["closed"], f"{energy} J are left")
    return f"still water lets {gone} out and {come} in; {energy['taken']:.2f} J are left of a wave, {energy['closed']:.2f} in a closed trough"


def refused(case, steps):
    """What cannot work is said with its place, on all ranks."""
    for settings, words in ((("absorption[0].wall=nobody",), "absorption[0].wall must be the name of a wall"),
                            (("absorption[0].inflow_distance=3",), "absorption[0].inflow_distance must be in [0, 2]"),
                            (("gravity=[0,0,0]",), "absorption[0].ocean_height must not be given without gravity"),
                            (("boundary.walls[1].motion={type: constant, velocity: [1,0,0]}",), "must be one that stands still")):
        said = case.call(["run", write(case, "still", STILL), "-o", case.folder / "refused", "--quiet",
                          *c.words(settings)], 2, expected=2)
        c.expect(words in said, f"{settings} is answered by: {said}")
    return "four settings"


if __name__ == "__main__":
    c.main(__doc__, {"bits": bits, "restart": restart, "level": level, "refused": refused})
