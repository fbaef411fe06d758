#!/usr/bin/python3
"""Gauges where the world is not a box with z upward: periodic seams, other directions of gravity, moving walls, places
that water comes to later; patches and times of any size; and the times of rows and snapshots."""

import csv
import itertools
import json

import numpy as np

import case as c


def readings(output):
    with open(output / "gauges.csv", newline="", encoding="utf-8") as file:
        return [{key: float(value) for key, value in row.items()} for row in csv.DictReader(file)]


def run(case, name, text, ranks=1):
    path = case.folder / f"{name}.yaml"
    path.write_text(text, encoding="utf-8")
    output = case.folder / name
    case.call(["run", path, "-o", output, "--force", "--quiet"], ranks)
    return output


def turned(vector, axis):
    """A vector with its x along that axis, y and z after it."""
    return [vector[(k - axis) % 3] for k in range(3)]


def close(what, found, right, share):
    c.expect(abs(found - right) <= share * abs(right) + 1e-12, f"{what}: {found}, not {right}")


def flows(case, _steps):
    """A cube of one particle drifts through rectangles that cover a part of a period, all of it, or the seam."""
    bodies = 0
    for axis, seam in itertools.product(range(3), (1, 2)):
        across = [0.3 if k == seam else 0.0 for k in range(3)]
        periodic = [k == seam for k in range(3)]
        low = [0.0, 0.0, 0.0]
        low[seam] = 0.2
        high = [x + 0.05 for x in low]
        boxes = {"all": (0, 0.3, 1), "upper": (0.15, 0.3, 1), "lower": (0, 0.15, 0), "over_seam": (0.19, 0.31, 1),
                 "later": (0.49, 0.61, 1), "earlier": (-0.11, -0.04, 1), "beside": (0.26, 0.48, 0), "twice": (-1, 1, 1)}
        gauges = []
        for name, (start, end, _) in boxes.items():
            edges = [[0.06, 0.06], [-1, 1], [-1, 1]]
            edges[seam] = [start, end]
            corner, other = ([edge[k] for edge in edges] for k in range(2))
            gauges.append(f"{{name: {name}, type: flow, axis: +{'xyz'[axis]}, box: {{min: {turned(corner, axis)}, max: {turned(other, axis)}}}}}")
            gauges.append(f"{{name: {name}_v, type: volume, box: {{min: {turned([-9, *corner[1:]], axis)}, max: {turned([9, *other[1:]], axis)}}}}}")
        output = run(case, f"flow_{axis}_{seam}", f"""
particle_spacing: 0.05
end_time: 0.1
gravity: [0, 0, 0]
domain: {{periodic: {json.dumps(turned(periodic, axis))}, min: [0, 0, 0], max: {turned(across, axis)}}}
fluid: {{blocks: [{{box: {{min: {turned(low, axis)}, max: {turned(high, axis)}}}, velocity: {turned([1, 0, 0], axis)}}}]}}
output: {{snapshots: {{every: 0}}, gauges_every: 0.1, gauges: [{', '.join(gauges)}]}}
""", 1 + axis)
        last = readings(output)[-1]
        for name, (_, _, share) in boxes.items():
            close(f"flow along {axis}, seam along {seam}, {name}", last[name], share * 0.00125, 1e-3)
            close(f"volume, seam along {seam}, {name}", last[f"{name}_v"], share * 0.000125, 1e-3)
            bodies += 1
    # all three axes repeat, and water goes round: area times speed
    output = run(case, "round", """
particle_spacing: 0.05
end_time: 0.5
gravity: [0, 0, 0]
domain: {periodic: [true, true, true], min: [0, 0, 0], max: [0.3, 0.3, 0.3]}
fluid: {mass_factor: 0.99, blocks: [{box: {min: [0, 0, 0], max: [0.3, 0.3, 0.3]}, velocity: [0.6, 0, 0]}]}
output: {snapshots: {every: 0}, gauges_every: 0.5, gauges: [{name: q, type: flow, axis: +x, box: {min: [0.1, 0, 0], max: [0.1, 0.3, 0.3]}}]}
""", 3)
    close("flow round", readings(output)[-1]["q"], 0.99 * 0.09 * 0.6, 2e-3)
    return f"{bodies} rectangles and boxes, and one all round"


def seams(case, _steps):
    """A wall pressure reads the same in the middle of a period, at its seam and in its corner; along two axes."""
    most, radii = 0.0, (0, 0.05, 0.2, 100)
    for up in (1, 2):
        axis = (up + 1) % 3
        periodic, period, high = [True] * 3, [0.3] * 3, [0.3] * 3
        periodic[up], period[up], high[up] = False, 0, 0.2
        gravity, normal, middle = [0, 0, 0], [0, 0, 0], [0.15, 0.15, 0.15]
        gravity[up], normal[up], middle[up] = -9.81, 1, 0
        edge = list(middle)
        edge[axis] = 0
        places = {"middle": middle, "edge": edge, "corner": [0, 0, 0], "again": [x + (k != up) * 0.3 for k, x in enumerate(middle)]}
        output = run(case, f"seam_{up}", f"""
particle_spacing: 0.05
end_time: 0.3
gravity: {gravity}
domain: {{periodic: {json.dumps(periodic)}, min: [0, 0, 0], max: {period}}}
fluid: {{blocks: [{{box: {{min: [0, 0, 0], max: {high}}}}}]}}
boundary: {{walls: [{{name: floor, plane: {{point: {middle}, normal: {normal}, size: [0.3, 0.3]}}}}]}}
output:
  snapshots: {{every: 0}}
  gauges_every: 0.1
  gauges: [{{name: push, type: force, wall: floor}}, {', '.join(
      f"{{name: {name}_{k}, type: pressure, wall: floor, axis: -{'xyz'[up]}, at: {at}, radius: {radius}}}"
      for name, at in places.items() for k, radius in enumerate(radii))}]
""", up)
        last = readings(output)[-1]
        for name, (k, radius) in itertools.product(places, enumerate(radii)):
            close(f"pressure at the {name}, up {up}, radius {radius}", last[f"{name}_{k}"], last[f"middle_{k}"], 1e-3)
            most = max(most, abs(last[f"{name}_{k}"] / last[f"middle_{k}"] - 1))
            close(f"pressure under 0.2 m of water, radius {radius}", last[f"{name}_{k}"], 1962, 0.03)
        close("pressure on all of the floor", last["middle_3"], -last[f"push_f{'xyz'[up]}"] / 0.09, 1e-5)
    return f"at most {most:.1e} between places"


def weight(q):
    """The kernel's shape, the same as the solver's."""
    return 2 * np.maximum(1 - q, 0)**3 - 8 * np.maximum(0.5 - q, 0)**3


def radii(case, _steps):
    """Water at rest by metres and by millimetres: patches of any size read what the samples in them bear."""
    spacing, depth, worst = 0.05, 0.5, 0.0
    for scale in (1, 1e-3):
        sizes, heights = (1, 1.25, 2, 3, 8), (0.2, 0.31)
        places = {f"w{k}": f"wall: tank, axis: +x, at: {[scale, 0.3 * scale, z * scale]}" for k, z in enumerate(heights)}
        places["f"] = f"at: {[0.5 * scale, 0.3 * scale, 0.25 * scale]}"
        gauges = [f"{{name: {name}_{size}, type: pressure, {place}, radius: {size * spacing * scale}}}"
                  for name, place in places.items() for size in sizes]
        gauges += [f"{{name: {name}_usual, type: pressure, {place}}}" for name, place in places.items()]
        output = run(case, f"radii_{scale}", f"""
particle_spacing: {spacing * scale}
end_time: {0.9 * scale**0.5}
fluid: {{blocks: [{{box: {{min: [0, 0, 0], max: {[scale, 0.6 * scale, depth * scale]}}}}}]}}
boundary: {{walls: [{{name: tank, box: {{min: [0, 0, 0], max: {[scale, 0.6 * scale, 0.8 * scale]}}}, open: [+z]}}]}}
output: {{snapshots: {{every: 0}}, gauges_every: 0, gauges: [{', '.join(gauges)}]}}
""", 2)
        rows = readings(output)
        late = rows[len(rows) // 2:]  # single readings scatter by 2 %
        last = {name: np.mean([row[name] for row in late]) for name in rows[0]}
        y, z = np.meshgrid(spacing * (np.arange(12) + 0.5), spacing * (np.arange(16) + 0.5))
        for (k, height), size in itertools.product(enumerate(heights), sizes[:-1]):
            share = weight(np.sqrt((spacing / 2)**2 + (y - 0.3)**2 + (z - height)**2) / (size * spacing))
            wanted = 9810 * scale * (share * np.maximum(depth - z, 0)).sum() / share.sum()
            worst = max(worst, abs(last[f"w{k}_{size}"] / wanted - 1))
            what = f"pressure on a wall, height {height}, radius {size} spacings, scale {scale}"
            close(what, last[f"w{k}_{size}"], wanted, 0.03)
        for size in sizes[2:-1]:
            what = f"pressure in water, radius {size} spacings, scale {scale}"
            # layers that water comes to rest in bear more and less in turns: 2.9 % low with either pressure_solve
            close(what, last[f"f_{size}"], 9810 * scale * 0.25, 0.04)
        for name in places:
            c.expect(last[f"{name}_usual"] == last[f"{name}_2"], f"{name}: the default is not the support radius")
    c.expect(last["w0_8"] < 0.95 * last["w0_1"], "a wide patch near the floor does not reach up")
    return f"within {100 * worst:.1f} % of the mean depth of their samples"


def exact_mean(rows, name, over):
    """Of a column with a row a step, each the mean over it: the mean over a time before each row, or since the start."""
    times = np.array([row["time"] for row in rows])
    sums = np.concatenate([[0], np.cumsum(np.diff(times) * [row[name] for row in rows[1:]])])
    begin = np.maximum(times[1:] - over, 0)
    return (sums[1:] - np.interp(begin, times, sums)) / (times[1:] - begin)


def expect_moving_mean(rows, name, moving, over):
    """The column `moving` is the mean of `name` over a time; exactly, but for the share that leaves it."""
    wanted, found = exact_mean(rows, name, over), np.array([row[moving] for row in rows[1:]])
    values = np.array([row[name] for row in rows[1:]])
    leaving = (values.max() - values.min()) / 256 if over < rows[-1]["time"] else 0
    most = leaving + 1e-9 * np.abs(values).max()
    off = np.abs(found - wanted)
    worst = off.argmax()
    c.expect(off[worst] <= most, f"{moving}: {found[worst]}, the mean of {name} over {over} s is {wanted[worst]}")
    return off.max() / (values.max() - values.min())


MEANS = {"P": ("type: pressure, wall: sill, axis: +x, at: [0.28, 0.1, 0.03]", "P"),
         "F": ("type: pressure, at: [0.1, 0.1, 0.05]", "F"),
         "q": ("type: flow, axis: +x, box: {min: [0.23, -0.1, -0.1], max: [0.23, 0.3, 0.5]}", "q"),
         "push": ("type: force, wall: sill", "push_fx")}


def means(case, _steps):
    """Moving means: those of the steps, whatever the rows; shorter than a step, longer than the run, and between."""
    times, worst = (1e-5, 0.01, 0.1, 9), 0.0
    gauges = [f"{{name: {name}, {what}}}" for name, (what, _) in MEANS.items()]
    gauges += [f"{{name: {name}{k}, {what}, mean_over: {time}}}"
               for name, (what, _) in MEANS.items() for k, time in enumerate(times)]
    outputs = [case.run("tests/cases/gauges.yaml", f"means_{every}", ranks,
                        (f"output.gauges_every={every}", f"output.gauges=[{', '.join(gauges)}]"))
               for every, ranks in ((0, 2), (0.03, 1), (99, 3))]
    rows, fewer, last = map(readings, outputs)
    c.expect(len(rows) > 100 and len(fewer) == 11 and len(last) == 2, f"{len(rows)}, {len(fewer)} and {len(last)} rows")
    for (name, (_, column)), (k, time) in itertools.product(MEANS.items(), enumerate(times)):
        moving = column.replace(name, f"{name}{k}", 1)
        worst = max(worst, expect_moving_mean(rows, column, moving, time))
        at = {row["time"]: row[moving] for row in rows}
        for row in fewer + last:
            found, right = row[moving], at[row["time"]]
            c.expect(found == right, f"{moving} at {row['time']} s: {found} with fewer rows, not {right}")
        if k == 0:
            close(f"{moving}, shorter than a step", rows[-1][moving], rows[-1][column], 1e-9)
        if k == 3:
            close(f"{moving}, longer than the run", rows[-1][moving], last[-1][column], 1e-9)
    return f"off by at most {worst:.1e} of the range, the same bits with any rows"


def riding(case, _steps):
    """What stands on a wall goes with it: a tank under way reads what one at rest does, in any direction."""
    sensors, moments = {}, {}
    for name, v in (("rest", [0, 0, 0]), ("x", [0.5, 0, 0]), ("y", [0, -0.5, 0]), ("up", [0.2, 0.3, 0.4])):
        motion = f", motion: {{type: constant, velocity: {v}}}" if any(v) else ""
        output = run(case, f"riding_{name}", f"""
particle_spacing: 0.05
end_time: 0.4
fluid: {{settle_steps: 60, blocks: [{{box: {{min: [0, 0, 0], max: [0.3, 0.3, 0.2]}}, velocity: {v}}}]}}
boundary:
  walls:
    - {{name: tank, box: {{min: [0, 0, 0], max: [0.3, 0.3, 0.4]}}, open: [+z]{motion}}}
output:
  snapshots: {{every: 0}}
  gauges_every: 0.2
  gauges:
    - {{name: end, type: pressure, wall: tank, axis: -x, at: [0, 0.15, 0.05]}}
    - {{name: small, type: pressure, wall: tank, axis: -x, at: [0, 0.15, 0.05], radius: 0.05}}
    - {{name: wide, type: pressure, wall: tank, axis: -x, at: [0, 0.15, 0.05], radius: 0.3}}
    - {{name: push, type: force, wall: tank, at: [0.15, 0.15, 0]}}
""", 2)
        last = readings(output)[-1]
        sensors[name] = [last[sensor] for sensor in ("end", "small", "wide")]
        moments[name] = max(abs(last["push_mx"]), abs(last["push_my"]))
    for name, values in sensors.items():
        for value, at_rest in zip(values, sensors["rest"]):
            close(f"a tank that goes {name}", value, at_rest, 0.08)
        c.expect(moments[name] < 1, f"moment about the middle of a tank that goes {name}: {moments[name]} N m")
    return ", ".join(f"{name} {', '.join(f'{value:.0f}' for value in values)} Pa" for name, values in sensors.items())


def upright(case, _steps):
    """Depths against gravity, whatever its direction; two coordinates are those across it, an axis may be named."""
    for down, sign in itertools.product(range(3), (-1, 1)):
        gravity, middle, high, tank = [0] * 3, [0.1, 0.1, 0.1], [0.2] * 3, [0.2] * 3
        gravity[down], high[down], tank[down] = sign * 9.81, 0.3, 1.0
        low, bottom = [0] * 3, [0] * 3
        if sign > 0:
            low[down], high[down] = 0.7, 1.0
        two = [x for k, x in enumerate(middle) if k != down]
        output = run(case, f"upright_{down}_{sign}", f"""
particle_spacing: 0.05
end_time: 0.002
gravity: {gravity}
fluid: {{blocks: [{{box: {{min: {low}, max: {high}}}}}]}}
boundary: {{walls: [{{name: tank, box: {{min: {bottom}, max: {tank}}}}}]}}
output:
  snapshots: {{every: 0}}
  gauges:
    - {{name: two, type: height, at: {two}}}
    - {{name: three, type: height, at: {middle}}}
    - {{name: named, type: height, axis: {'-+'[sign < 0]}{'xyz'[down]}, at: {two}}}
    - {{name: across, type: height, axis: +{'xyz'[(down + 1) % 3]}, at: {[(x + y) / 2 for x, y in zip(low, high)]}}}
""")
        first = readings(output)[0]
        for name in ("two", "three", "named"):
            close(f"depth ({name}), gravity {gravity}", first[name], 0.3, 1e-9)
        close(f"width, gravity {gravity}", first["across"], 0.2, 1e-9)
    output = run(case, "oblique", """
particle_spacing: 0.02
end_time: 0.001
gravity: [6.936717523, 0, -6.936717523]
fluid: {blocks: [{box: {min: [-0.2, -0.1, -0.1], max: [0.2, 0.1, 0.1], rotation: {axis: [0, 1, 0], angle: -45}}}]}
output: {snapshots: {every: 0}, gauges: [{name: depth, type: height, at: [0, 0, 0]}]}
""")
    close("depth along an oblique gravity", readings(output)[0]["depth"], 0.2, 1e-6)
    output = run(case, "stepped", """
particle_spacing: 0.05
end_time: 0.002
fluid: {blocks: [{box: {min: [0, 0, 0], max: [0.4, 0.4, 0.3]}}, {box: {min: [0.4, 0, 0], max: [0.8, 0.4, 0.4]}}]}
boundary: {walls: [{name: tank, box: {min: [0, 0, 0], max: [0.8, 0.4, 1]}}]}
output:
  snapshots: {every: 0}
  gauges: [{name: low, type: height, at: [0.385, 0.2]}, {name: high, type: height, at: [0.415, 0.2]}]
""")
    low, high = (readings(output)[0][name] for name in ("low", "high"))
    c.expect(0.3 <= low < 0.34 and 0.36 < high <= 0.4, f"beside a step from 0.3 to 0.4 m water is {low} and {high} m deep")
    return f"six directions of gravity, and an oblique one; beside a step from 0.3 to 0.4 m {low:.3f} and {high:.3f} m"


def elsewhere(case, _steps):
    """Gauges where there is nothing at the start: over a fountain, beyond a rim, in a domain's limits; not far beyond."""
    fountain = """
particle_spacing: 0.05
end_time: 0.3
fluid: {emitters: [{disc: {position: [0, 0, 0.1], direction: [0, 0, 1], radius: 0.08}, speed: 4}]}
boundary: {walls: [{name: floor, plane: {point: [0, 0, 0], normal: [0, 0, 1], size: [1, 1]}}]}
output: {snapshots: {every: 0}, gauges_every: 0.3, gauges: [{name: q, type: flow, axis: +z, box: {min: [-0.4, -0.4, 0.3], max: [0.4, 0.4, 0.3]}}]}
"""
    c.expect(readings(run(case, "fountain", fountain))[-1]["q"] > 0.02, "nothing passes over the fountain")
    tank = """
particle_spacing: 0.05
end_time: 0.001
{more}fluid: {{blocks: [{{box: {{min: [0, 0, 0], max: [0.2, 0.2, 0.2]}}}}]}}
boundary: {{walls: [{{name: tank, box: {{min: [0, 0, 0], max: [0.2, 0.2, 0.2]}}, open: [+z]}}]}}
output: {{snapshots: {{every: 0}}, gauges: [{{name: spilt, type: volume, box: {{min: {low}, max: {high}}}}}]}}
"""
    run(case, "rim", tank.format(more="", low=[0.3, -1, -0.5], high=[1, 1, 0.1]))
    limits = "domain: {limits: {min: [-9, -9, -9], max: [9, 9, 9]}}\n"
    run(case, "limits", tank.format(more=limits, low=[7, -1, -0.5], high=[8, 1, 0.1]))
    for name, more, low, high in (("far", "", [70, 0, 0], [71, 1, 1]), ("beyond", limits, [9.5, 0, 0], [10, 1, 1])):
        path = case.folder / f"{name}.yaml"
        path.write_text(tank.format(more=more, low=low, high=high), encoding="utf-8")
        text = case.call(["check", path], expected=2)
        c.expect("measures nothing" in text, f"{name}: {text}")
    return "a fountain, a rim, a domain with limits"


def times(case, _steps):
    """Constant steps that divide the interval: each snapshot and each row on its time, none early, late or twice."""
    pairs = [(0.01, 0.1), (0.01, 0.01), (0.001, 0.01), (0.002, 0.01), (0.005, 0.05), (0.0025, 0.01), (0.004, 0.02), (0.003, 0.03),
             (0.007, 0.07), (0.0001, 0.0007), (0.02, 0.06), (0.03, 0.3), (0.05, 0.1), (0.1, 0.1), (0.1, 0.3), (0.0003, 0.0009),
             (0.006, 0.018), (0.009, 0.027), (0.011, 0.033), (0.013, 0.13)]
    for number, (step, every) in enumerate(pairs):
        intervals = 12
        output = run(case, f"times_{number}", f"""
particle_spacing: 0.1
end_time: {every * intervals!r}
gravity: [0, 0, 0]
fluid: {{blocks: [{{box: {{min: [0, 0, 0], max: [0.1, 0.1, 0.1]}}}}]}}
time_step: {{control: constant, size: {step}}}
output: {{snapshots: {{every: {every}}}, gauges_every: {every}, gauges: [{{name: v, type: volume}}]}}
""", 3 if number == 0 else 1)
        rows = [row["time"] for row in readings(output)]
        series = json.loads((output / "snapshots" / "run.hdf.series").read_text(encoding="utf-8"))
        for what, found in (("rows", rows), ("snapshots", [file["time"] for file in series["files"]])):
            c.expect(len(found) == intervals + 1, f"steps of {step}, {what} every {every}: {len(found)}, not {intervals + 1}")
            worst = max(abs(time - k * every) for k, time in enumerate(found))
            c.expect(worst <= 1e-6 * step, f"steps of {step}, {what} every {every}: one is {worst} s off: {found}")
    return f"{len(pairs)} pairs of step and interval"


if __name__ == "__main__":
    c.main(__doc__, {"flows": flows, "seams": seams, "radii": radii, "means": means, "riding": riding, "upright": upright,
                     "elsewhere": elsewhere, "times": times})
