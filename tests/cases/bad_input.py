#!/usr/bin/python3
"""Bad input never hurts: broken scenes, command lines, outputs and snapshots.

Each ends with its agreed exit code and one message that says what is wrong, on one rank and on three, and leaves
nothing behind. A run starts in a folder of its own with the scene scene.yaml, so that whatever it leaves is seen.
"""

import concurrent.futures
import os
import re
import shutil
import subprocess
import tempfile
from pathlib import Path

import case as c

# 64 particles; the cases below replace parts of it or add a fourth line.
GOOD = """\
particle_spacing: 0.1
end_time: 1
fluid: {blocks: [{box: {min: [0, 0, 0], max: [0.4, 0.4, 0.4]}}]}
"""
WALL = "plane: {point: [0, 0, 0], normal: [0, 0, 1], size: [1, 1]}"
NOISE = ("MPI_ABORT", "signal", "Sanitizer", "runtime error:", "PMIX ERROR", "HDF5-DIAG", "core dumped", "src/")
JOBS = 10  # much of a start under mpirun is waiting


def added(line):
    return GOOD + line + "\n"


def changed(old, new):
    assert old in GOOD
    return GOOD.replace(old, new, 1)


def adaptive(settings, solver=""):
    return added(f"time_step: {{control: adaptive, adaptive: {{{settings}}}}}\nsolver: {{method: pcisph{solver}}}")


def nested(key):
    word, inner = key.split(".")
    return f"{word}: {{{inner}: 0}}"


DISC = "disc: {position: [9, 9, 9], direction: [0, 0, 1], radius: 1}"


def moving(motion):
    return added(f"boundary: {{walls: [{{{WALL}, motion: {motion}}}]}}")


def emitting(emitter):
    return GOOD.replace("fluid: {", f"fluid:\n  emitters: [{{{emitter}}}]\n  ").replace("}}]}\n", "}}]\n")


# Name: the scene, and what the message must hold. A place such as 4:1 is that of the caret, checked against the line
# shown; one that is not a place is text.
SCENES = {
    "unknown key": (added("gravty: [0, 0, -1]"), "4:1", "unknown key 'gravty'; did you mean 'gravity'?"),
    "unknown inner key": (added("solver: {warm_stat: 1}"), "4:10", "'solver.warm_stat'", "'solver.warm_start'?"),
    "key in the wrong map": (added("rest_density: 998"), "4:1", "did you mean 'fluid.rest_density'?"),
    "dotted key": (added("fluid.rest_density: 998"), "4:1", "write nested maps, not dots"),
    "empty key": (added(": 3"), "4:3", "unknown key ''"),
    "list as key": (added("? [a]\n: 1"), "4:3", "a key must be a word, not a list"),
    "wrong type: number": (added("support_radius: wide"), "4:17", "must be a number, not 'wide'"),
    "wrong type: integer": (added("solver: {density_iterations: {min: 2.5}}"), "4:36", "must be an integer, not '2.5'"),
    "wrong type: flag": (added("boundary: {contact: 1}"), "4:21", "must be true or false, not '1'"),
    "wrong type: list": (added("gravity: -9.81"), "4:10", "must be a list of 3 numbers, not '-9.81'"),
    "wrong type: map": (added("solver: dfsph"), "4:9", "solver must be a map, not 'dfsph'"),
    "wrong type: list of maps": (added("boundary: {walls: tank}"), "4:19", "must be a list of maps, not 'tank'"),
    "wrong type: item": (added("boundary: {walls: [tank]}"), "4:20", "boundary.walls[0] must be a map, not 'tank'"),
    "wrong type: text": (added("name: [a, b]"), "4:7", "name must be text, not a list of 2"),
    "wrong choice": (added("solver: {method: dfsp}"), "4:18", "one of dfsph", "(nearest: dfsph)", "not 'dfsp'"),
    "wrong length": (added("gravity: [0, 0, 0, -9.81]"), "4:10", "must be a list of 3 numbers, not a list of 4"),
    "negative spacing": (changed("0.1", "-0.1"), "1:19", "particle_spacing must be > 0, not '-0.1'"),
    "zero spacing": (changed("0.1", "0"), "1:19", "particle_spacing must be > 0, not '0'"),
    "tiny spacing": (changed("0.1", "1e-320"), "1:19", "particle_spacing must be 1e-9 to 1e9"),
    "too many layers": (added("boundary: {layers: 3}"), "4:20", "boundary.layers must be in [0, 2], not '3'"),
    "walls of another method": (added("boundary: {method: ihmsen2010}"), "4:20",
                                "boundary.method must be akinci2012 with solver.method dfsph"),
    "unknown boundary method": (added("boundary: {method: ihmsen}"), "4:20", "one of akinci2012, ihmsen2010"),
    "laminar without volumes": (changed("{blocks", "{viscosity: {model: laminar}, blocks")
                                + "solver: {method: pcisph}\nboundary: {method: becker2009}\n", "3:28",
                                "must not be laminar unless boundary.method is akinci2012 or ihmsen2010"),
    "long mixing": (changed("{blocks", "{viscosity: {model: smagorinsky, coefficient: 1.5}, blocks"), "3:54",
                    "fluid.viscosity.coefficient must be in [0, 1] with model smagorinsky, not 1.5"),
    "negative mixing": (changed("{blocks", "{viscosity: {model: smagorinsky, coefficient: -0.1}, blocks"), "3:54",
                        "fluid.viscosity.coefficient must be >= 0, not '-0.1'"),
    "another spelling": (changed("{blocks", "{viscosity: {model: smagorinski}, blocks"), "3:28", "(nearest: smagorinsky)"),
    "more than sticks": (added("boundary: {friction: 1.5}"), "4:22", "boundary.friction must be in [0, 1], not '1.5'"),
    "unknown friction": (added("boundary: {friction_law: wet}"), "4:26", "one of none, no_slip, smooth, rough"),
    "rough without grains": (added("boundary: {friction_law: rough}"), "boundary.roughness", "required with friction_law rough"),
    "a rough wall without grains": (added("boundary: {walls: [{" + WALL + ", friction_law: rough}]}"), "roughness",
                                    "required with friction_law rough"),
    "laminar walls of two kinds": (changed("{blocks", "{viscosity: {model: laminar}, blocks")
                                   + "boundary: {walls: [{" + WALL + "}, {" + WALL.replace("point: [0, 0, 0]", "point: [0, 0, 2]") + ", friction_law: smooth}]}\n",
                                   "all walls must be no_slip, or none"),
    "no viscosity at walls": (changed("{blocks", "{kinematic_viscosity: 0, blocks"), "3:30", "fluid.kinematic_viscosity must be > 0"),
    "squared walls for predictions": (added("solver: {method: pcisph}\nboundary: {wall_density: squared}"), "5:26",
                                      "must be sum with solver.method pcisph"),
    "smoothing of short steps": (changed("{blocks", "{viscosity: {model: xsph}, blocks") + "solver: {method: wcsph}\n", "3:28",
                                 "must not be xsph with solver.method wcsph"),
    "no sound": (added("solver: {method: wcsph, sound_speed: -1}"), "4:38", "solver.sound_speed must be > 0"),
    "no word of sound": (added("gravity: [0, 0, 0]\nsolver: {method: wcsph}"), "5:18", "missing key 'solver.sound_speed'"),
    "more than weakly compressible": (added("solver: {method: wcsph, density_fluctuation: 0.5}"), "4:46", "must be in (0, 0.1]"),
    "faster than sound": (added("solver: {method: wcsph}\ntime_step: {control: constant, size: 0.1}"), "5:38",
                          "must be <= the longest step with which sound is stable"),
    "individual pressure solves": (added("time_step: {control: individual}"), "4:22", "must not be individual with solver.method dfsph"),
    "global pressure solves": (added("solver: {method: pcisph}\ntime_step: {control: global}"), "5:22", "must not be global with solver.method pcisph"),
    "taken back without": (added("solver: {method: wcsph}\ntime_step: {control: cfl}"), "5:22", "must not be cfl with solver.method wcsph"),
    "endless lists": (added("solver: {method: wcsph}\ntime_step: {control: individual, margin: 2}"), "5:42", "time_step.margin must be in (0, 1]"),
    "steps of three": (added("solver: {method: wcsph}\ntime_step: {control: individual, steps: thirds}"), "5:41", "one of power_of_two, raw"),
    "another's layers": (added("solver: {method: wcsph}\nboundary: {method: ihmsen2010}"), "boundary.method must be akinci2012 with solver.method wcsph"),
    "released for ever": (added("solver: {method: pcisph, release_steps: -1}"), "solver.release_steps", "must be in [0, 100000]"),
    "negative bounce": (added("boundary: {elasticity: -0.1}"), "4:24", "boundary.elasticity must be in [0, 1]"),
    "error of one below that of all": (added("solver: {method: pcisph, density_error_avg: 0.01, density_error_max: 0.001}\ntime_step: {control: cfl}"),
                                       "4:70", "density_error_max must be 0 or >= solver.density_error_avg"),
    "unknown correction": (added("solver: {method: pcisph, density_correction: kernel}"), "4:46", "one of none, shepard"),
    "surface tension that pushes": (changed("{blocks", "{surface_tension: {model: becker2007, coefficient: -1}, blocks"),
                                    "3:59", "fluid.surface_tension.coefficient must be >= 0"),
    "unknown surface tension": (changed("{blocks", "{surface_tension: {model: akinci}, blocks"), "3:34",
                                "one of none, becker2007"),
    "out of range": (added("fluid2: 1\nsolver: {warm_start: 1.5}"), "5:22", "must be in [0, 1], not '1.5'"),
    "NaN": (added("gravity: [0, 0, .nan]"), "4:17", "gravity[2] must be finite, not '.nan'"),
    "infinity": (changed("end_time: 1", "end_time: .inf"), "2:11", "end_time must be finite, not '.inf'"),
    "overflow": (changed("end_time: 1", "end_time: 1e999"), "2:11", "finite, below 1.8e308, not '1e999'"),
    "integer overflow": (added("origin_cells: [0, 99999999999999999999, 0]"), "4:19", "must be in [-1073741824, 10737"),
    "unit": (changed("0.1", "10 cm"), "1:19", "particle_spacing must be a number, not '10 cm'"),
    "unit without space": (changed("end_time: 1", "end_time: 1s"), "2:11", "must be a number, not '1s'"),
    "decimal comma": (changed("0.1", "0,1"), "1:19", "must be a number, not '0,1'"),
    "quoted number": (changed("0.1", "'0.1'"), "1:19", "must be a number, not the text '0.1'"),
    "duplicate key": (added("end_time: 2"), "4:1", "duplicate key 'end_time', first given on line 2"),
    "duplicate name": (added(f"boundary: {{walls: [{{name: a, {WALL}}}, {{name: a, {WALL}}}]}}"), "4:98",
                       "boundary.walls[1].name", "not 'a' like wall 0"),
    "merge key": (added("solver: {<<: {warm_start: 1}}"), "4:10", "unknown key 'solver.<<'"),
    "alias without anchor": (added("name: *other"), "4:7", "alias '*other' has no anchor before it"),
    "alias of itself": (added("name: &a [*a]"), "4:11", "alias '*a' has no anchor before it"),
    "tag": (added("name: !!python/object:os.system x"), "4:33", "tags are not supported"),
    "own tag": (added("name: !include other.yaml"), "4:16", "tags are not supported"),
    "two documents": (added("---\nname: other"), "4:1", "only one YAML document may be given"),
    "open list": (added("gravity: [0, 0"), "4:15", "not valid YAML", "without a closing bracket"),
    "open quote": (added('name: "tank'), "4:8", "not valid YAML", "without closing quote"),
    "two colons": (added("name: a: b"), "4:8", "not valid YAML"),
    "indentation": (added("solver:\n  warm_start: 1\n method: dfsph"), "6:2", "not valid YAML", "indentation"),
    "tab": (added("solver:\n\twarm_start: 1"), "5:1", "not valid YAML", "tab character"),
    "missing key": ("particle_spacing: 0.1\n", "1:1", "missing required key 'end_time'"),
    "missing inner key": (changed("min: [0, 0, 0], ", ""), "3:18", "missing required key 'fluid.blocks[0].box.min'"),
    "missing by mode": (added("time_step: {control: constant}"), "missing key 'time_step.size', required with"),
    "missing period": (added("domain: {periodic: [true, false, false]}"), "'domain.min'", "'domain.max'", "periodic"),
    "empty list": (added("gravity: []"), "4:10", "must be a list of 3 numbers, not an empty list"),
    "no value": (added("support_radius:"), "4:1", "must be a number, not nothing"),
    "upside-down box": (changed("0.4, 0.4, 0.4", "0.4, -0.4, 0.4"), "3:46", "box.max must be > box.min along y"),
    "no normal": (added(f"boundary: {{walls: [{{{WALL.replace('0, 0, 1', '0, 0, 0')}}}]}}"), "must not be zero"),
    "two shapes": (added(f"boundary: {{walls: [{{{WALL}, box: {{min: [0, 0, 0], max: [1, 1, 1]}}}}]}}"), "4:20",
                   "exactly one of box, cylinder, sphere, mesh, revolution, plane; it has box and plane"),
    "an empty shape": (added(f"boundary: {{walls: [{{{WALL}, box: {{}}}}]}}"), "4:86", "box must have keys, not {}"),
    "no shape": (added("boundary: {walls: [{}]}"), "4:20", "exactly one of", "it has none"),
    "a force that pushes": (added("central_force: {rate: -1}"), "4:23", "central_force.rate must be >= 0, not '-1'"),
    "a force without a place": (added("central_force: {rate: 1, center: 0}"), "4:34", "central_force.center must be a list of 3 numbers"),
    "a gradient of numbers": (changed("{blocks: [{", "{blocks: [{velocity_gradient: [1, 2, 3], "), "velocity_gradient must be a map"),
    "a short gradient": (changed("{blocks: [{", "{blocks: [{velocity_gradient: {x: [1, 2]}, "), "velocity_gradient.x must be a list of 3 numbers"),
    "an endless rotation": (changed("{blocks: [{", "{blocks: [{rotation: [0, .inf, 0], "), "rotation[1] must be finite"),
    "negative pressure with emitters": (changed("{blocks", "{emitters: [{disc: {position: [0.2, 0.2, 0.5], direction: [0, 0, -1], radius: 0.1}, speed: 1}], blocks")
                                        + "solver: {negative_pressure: true}\n", "negative_pressure must not be true with fluid.emitters"),
    "a solve that swells": (added("solver: {gap_rule: false, pressure_solve: fast}"), "4:43",
                            "solver.pressure_solve must be paper with solver.gap_rule false"),
    "wide ratio": (added("support_ratio: 5"), "4:16", "support_ratio must be in [1.5, 4]"),
    "two supports": (added("support_radius: 0.16\nsupport_ratio: 2"), "4:17", "support_radius must be support_ratio particle_spacing"),
    "wide support": (added("support_radius: 1"), "4:17", "support_radius must be 1.5 to 4 particle_spacing"),
    "a name that is a path": (added("name: ../escape"), "4:7", "name must do as a folder's name"),
    "long name": (added("name: " + 200 * "n"), "4:7", "name must be at most 127 bytes long"),
    "lines in a name": (added('name: "a\\nb"'), "4:7", "one line of text without control characters"),
    "long key": (added(100000 * "k" + ": 1"), "4:1", "unknown key 'kkk"),
    "long number": (added("gravity: [0, 0, " + 100000 * "9" + "]"), "4:17", "must be finite"),
    "long line": (added("gravity: [" + 100000 * " " + "x, 0, 0]"), "4:100011", "must be a number, not 'x'"),
    "deep nesting": (added("name: " + 10000 * "["), "nested more than 32 deep"),
    "deep maps": ("".join(" " * k + "a:\n" for k in range(200)), "nested more than 32 deep"),
    "aliases of aliases": (added("a: &a [x,x]\n" + "".join(f"{x}: &{x} [*{y},*{y},*{y}]\n"
                                                           for x, y in zip("bcdefghijklmno", "abcdefghijklmn"))),
                           "unknown key 'o'"),
    "ten megabytes of keys": (added("".join(f"key_{k}: {k}\n" for k in range(550000))), "'key_0'", "and more"),
    "too many blocks": ("fluid: {blocks: [" + "{}, " * (2**20 + 1) + "]}\n", "1:17", "at most 1048576 items, not 1048577"),
    "larger than a scene": (GOOD.encode() + b"#" * (33 << 20), "larger than 32 MiB"),
    "empty file": (b"", "scene.yaml: the file is empty"),
    "only a comment": ("# nothing\n", "must be a map of keys, not nothing"),
    "a list": ("- 1\n- 2\n", "1:1", "must be a map of keys, not a list of 2"),
    "a word": ("water\n", "1:1", "must be a map of keys, not 'water'"),
    "binary": (bytes(range(256)) * 8, "1:1", "not text: byte 0x00 is a control character"),
    "invalid UTF-8": (GOOD.encode() + b"name: k\xe4se\n", "4:8", "not UTF-8 text: byte 0xe4"),
    "UTF-16": (GOOD.encode("utf-16"), "1:1", "not UTF-8 text: byte 0xff"),
    "terminal control": (added("name: a\033[2J"), "4:8", "byte 0x1b is a control character"),
    "byte order mark": (b"\xef\xbb\xbf" + added("gravty: 1").encode(), "4:1", "unknown key 'gravty'"),
    "Windows line ends": (added("gravty: 1").replace("\n", "\r\n").encode(), "4:1", "unknown key 'gravty'"),
    "1e15 particles": (changed("0.1", "1e-5").replace("0.4", "1"), "must have at most 2^40 particles, got 10000000000"),
    "1e27 particles": (changed("0.1", "1e-9").replace("0.4", "1"), "must have at most 2^40 particles"),
    "beyond the world": (changed("max: [0.4", "max: [1e300"), "coordinates must lie within"),
    "no fluid": (changed("[{box: {min: [0, 0, 0], max: [0.4, 0.4, 0.4]}}]", "[]"), "3:17", "there is no fluid"),
    "overlapping blocks": (changed("0.4]}}]", "0.4]}}, {box: {min: [0.2, 0.2, 0.2], max: [0.6, 0.6, 0.6]}}]"), "overlap",
                           "fluid.blocks[1]", "fluid.blocks[0]"),
    "fluid in an obstacle": (added("boundary: {walls: [{name: rock, box: {min: [-1, -1, -1], max: [1, 1, 1]}, inside: solid}]}"),
                             "fluid.blocks[0]", "rock"),
    "step bounds": (added("time_step: {control: constant, size: 1, max: 0.1}"), "4:38", "time_step.size must be <= "
                    "time_step.max, not 1 > 0.1"),
    "limits turned round": (added("domain: {limits: {min: [0, 0, 0], max: [1, -1, 1]}}"), "4:40", "domain.limits.max must be > "
                            "domain.limits.min along y, not -1 <= 0"),
    "half of the limits": (added("domain: {limits: {max: [1, 1, 1]}}"), "missing key 'domain.limits.min', required with"),
    "fluid beyond the limits": (added("domain: {limits: {min: [-1, -1, -1], max: [1, 0.2, 1]}}"), "fluid.blocks[0]",
                                "must lie within domain.limits along y"),
    "limits that are words": (added("domain: {limits: {min: [a, 0, 0], max: [1, 1, 1]}}"), "4:25", "must be a number, not 'a'"),
    "another leaving": (added("domain: {leaving: ignore}"), "4:19", "one of error, remove", "not 'ignore'"),
    "negative floor": (added("time_step: {min: -1}"), "4:18", "time_step.min must be >= 0, not '-1'"),
    "floor above the largest step": (added("time_step: {max: 0.001, min: 1}"), "4:30", "time_step.min must be <= the "
                                     "largest time step, not 1 > 0.001"),
    "floor above the computed step": (added("time_step: {min: 1}"), "4:18", "time_step.min must be <= the largest time step"),
    "floor above the constant step": (added("time_step: {control: constant, size: 0.001, min: 0.002}"), "4:50",
                                      "time_step.min must be <= the largest time step, not 0.002 > 0.001"),
    "a step that changes by nothing": (adaptive("change: 0"), "4:51", "time_step.adaptive.change must be in (0, 0.5], not '0'"),
    "no restart allowed": (adaptive("restart: {most: 0}"), "4:59", "restart.most must be in [1, 1000], not '0'"),
    "half a restart": (adaptive("restart: {most: 1.5}"), "4:59", "must be an integer, not '1.5'"),
    "a restart no shorter": (adaptive("restart: {share: 1}"), "4:60", "restart.share must be in (0, 0.9], not '1'"),
    "negative rise": (adaptive("shock: {error_rise: -1}"), "4:63", "shock.error_rise must be >= 0, not '-1'"),
    "growth above shrinking": (adaptive("grow: {force: 0.3}"), "4:57", "time_step.adaptive.grow.force must be <= "
                               "time_step.adaptive.shrink.force, not 0.3 > 0.2"),
    "growth in what shrinks": (adaptive("shrink: {error_avg: 0.5}"), "4:63", "grow.error_avg must be <= ", "not 0.9 > 0.5"),
    "shrinking in a shock": (adaptive("shrink: {velocity: 0.5}"), "4:62", "shrink.velocity must be <= "
                             "time_step.adaptive.shock.velocity, not 0.5 > 0.45"),
    "errors below their average": (adaptive("change: 0.01", ", density_error_max: 0.01"), "solver.density_error_avg must be < "
                                   "solver.density_error_max, not 0.01 >= 0.01"),
    "a rise beyond the largest error": (adaptive("shock: {error_rise: 0.2}"), "4:63", "time_step.adaptive.shock.error_rise "
                                        "must be < solver.density_error_max, not 0.2 >= 0.1"),
    "a rise below the average error": (adaptive("shock: {error_rise: 0.01}"), "solver.density_error_avg must be < "
                                       "time_step.adaptive.shock.error_rise, not 0.01 >= 0.01"),
    "negative shocks": (added("faults: {shock_at: -1, shock_again: -1}"), "4:20", "4:37", "faults.shock_at must be >= 0",
                        "faults.shock_again must be >= 0"),
    "unknown adaptive key": (adaptive("grows: 1"), "4:43", "unknown key 'time_step.adaptive.grows'"),
    **{f"no {key}": (adaptive(nested(key)), f"time_step.adaptive.{key} must be > 0, not '0'")
       for key in ("grow.force", "grow.error_max", "grow.error_avg", "grow.velocity", "shrink.force", "shrink.error_max",
                   "shrink.error_avg", "shrink.velocity", "shock.velocity", "restart.force", "restart.velocity",
                   "first.velocity", "first.depth")},
    "negative fault": (added("faults: {nan_at: -1}"), "4:18", "faults.nan_at must be >= 0"),
    "unknown fault": (added("faults: {nan: 1}"), "4:10", "unknown key 'faults.nan'"),
    "gauge outside": (added(f"boundary: {{walls: [{{{WALL}}}]}}\noutput: {{gauges: [{{name: a, type: height, at: [5, 0]}}]}}"),
                      "gauge a measures nothing", "along x it is at 5"),
    "gauge off its wall": (added(f"boundary: {{walls: [{{name: bed, {WALL}}}]}}\noutput: {{gauges: [{{name: a, type: "
                                 "pressure, wall: bed, at: [0, 0, 0.39]}]}"), "gauge a measures nothing", "its wall reaches"),
    "gauge smaller than a spacing": (added("output: {gauges: [{name: a, type: pressure, at: [0, 0, 0], radius: 0.05}]}"),
                                     "4:68", "output.gauges[0].radius must be >= particle_spacing, or 0 for the support radius, "
                                     "not 0.05 < 0.1"),
    "gauge of negative radius": (added("output: {gauges: [{name: a, type: pressure, at: [0, 0, 0], radius: -1}]}"),
                                 "4:68", "output.gauges[0].radius must be >= 0, not '-1'"),
    "radius of another gauge": (added("output: {gauges: [{name: a, type: volume, radius: 1}]}"), "4:51",
                                "output.gauges[0].radius is a key of pressure, not of volume"),
    "mean over less than nothing": (added("output: {gauges: [{name: a, type: pressure, at: [0, 0, 0], mean_over: -1}]}"),
                                    "4:71", "output.gauges[0].mean_over must be >= 0, not '-1'"),
    "mean of a moment": (added("output: {gauges: [{name: a, type: front, axis: +x, mean_over: 1}]}"), "4:63",
                         "output.gauges[0].mean_over is a key of pressure, flow, force, not of front"),
    "gauge of no wall": (added("output: {gauges: [{name: a, type: force, wall: bed}]}"), "the name of a wall or body of the scene"),
    "key of another gauge": (added("output: {gauges: [{name: a, type: front, axis: +x, wall: bed}]}"), "4:58",
                             "wall is a key of pressure, force, not of front"),
    "unknown motion": (moving("{type: sine}"), "4:96", "one of none, constant, cosine, table", "not 'sine'"),
    "a motion without speed": (moving("{type: constant}"), "4:96", "motion.type must have a velocity or an angular_velocity"),
    "a turn about nothing": (moving("{type: constant, angular_velocity: 1, center: [0, 0, 0], axis: [0, 0, 0]}"),
                             "motion.axis must not be zero"),
    "a turn without a center": (moving("{type: constant, angular_velocity: 1}"), "motion.center', required of a wall that turns"),
    "velocity that is no number": (moving("{type: constant, velocity: [a, 0, 0]}"), "velocity[0] must be a number, not 'a'"),
    "a cosine without frequency": (moving("{type: cosine, amplitude: 1, direction: [1, 0, 0]}"), "'boundary.walls[0].motion."
                                   "frequency', required with motion.type cosine"),
    "frequency zero": (moving("{type: cosine, amplitude: 1, direction: [1, 0, 0], frequency: 0}"), "frequency must be > 0, not '0'"),
    "amplitude and speed": (moving("{type: cosine, amplitude: 1, speed: 1, direction: [1, 0, 0], frequency: 1}"),
                            "motion.speed must not be given beside motion.amplitude"),
    "angle and its speed": (moving("{type: cosine, angle: 1, angular_velocity: 1, center: [0, 0, 0], frequency: 1}"),
                            "motion.angular_velocity must not be given beside motion.angle"),
    "negative amplitude": (moving("{type: cosine, amplitude: -1, direction: [1, 0, 0], frequency: 1}"), "amplitude must be >= 0"),
    "negative angle": (moving("{type: cosine, angle: -1, center: [0, 0, 0], frequency: 1}"), "angle must be >= 0"),
    "a cosine along nothing": (moving("{type: cosine, amplitude: 1, frequency: 1}"), "motion.direction must not be zero"),
    "a cosine of nothing": (moving("{type: cosine, frequency: 1}"), "must have one of amplitude, speed, angle, angular_velocity"),
    "a phase too far": (moving("{type: cosine, amplitude: 1, direction: [1, 0, 0], frequency: 1, phase: 361}"),
                        "phase must be in [-360, 360]"),
    "a table without rows": (moving("{type: table}"), "motion.points must have a row, or motion.file name a table"),
    "a table twice": (moving("{type: table, file: a.csv, points: [{time: 0}]}"), "points must not be given beside motion.file"),
    "rows out of order": (moving("{type: table, points: [{time: 0}, {time: 1}, {time: 1}]}"),
                          "motion.points[2].time must be > the row's before it, not 1 <= 1"),
    "a row without time": (moving("{type: table, points: [{shift: [0, 0, 0]}]}"), "motion.points[0].time'"),
    "a shift that is short": (moving("{type: table, points: [{time: 0, shift: [0, 0]}]}"), "must be a list of 3 numbers"),
    "rows for no table": (moving("{type: constant, velocity: [1, 0, 0], points: [{time: 0}]}"), "they are for motion.type table"),
    "an unknown interpolation": (moving("{type: table, interpolation: cubic, points: [{time: 0}]}"), "one of linear, smooth"),
    "no such table": (moving("{type: table, file: none.csv}"), "boundary.walls[0].motion.file", "none.csv: cannot be opened"),
    "a table that is none": (moving("{type: table, file: scene.yaml}"), "must name the columns time, x, y, z"),
    "a stop before the start": (moving("{type: constant, velocity: [1, 0, 0], start: 2, stop: 1}"),
                                "motion.stop must be > motion.start, not 1 <= 2"),
    "a start before time": (moving("{type: constant, velocity: [1, 0, 0], start: -1}"), "motion.start must be >= 0"),
    "a wall that leaves": (moving("{type: constant, velocity: [0, 1e10, 0]}"), "boundary.walls[0]", "must stay within 2^31"),
    "an emitter without shape": (emitting("speed: 1"), "exactly one of disc, rectangle; it has none"),
    "an emitter with two": (emitting("disc: {position: [9, 9, 9]}, rectangle: {position: [9, 9, 9]}"), "it has disc and rectangle"),
    "no speed, no rate": (emitting(DISC), "4:14", "fluid.emitters[0] must have a speed or a rate"),
    "speed and rate": (emitting(f"{DISC}, speed: 1, rate: 1"), "rate must not be given beside speed"),
    "a negative speed": (emitting(f"{DISC}, speed: -1"), "speed must be >= 0, not '-1'"),
    "a negative rate": (emitting(f"{DISC}, rate: -1"), "rate must be >= 0, not '-1'"),
    "a flow to nowhere": (emitting(f"{DISC.replace('0, 0, 1', '0, 0, 0')}, speed: 1"), "disc.direction must not be zero"),
    "a disc of no size": (emitting(f"{DISC.replace('radius: 1', 'radius: 0')}, speed: 1"), "disc.radius must be > 0"),
    "a disc for less than a particle": (emitting(f"{DISC.replace('radius: 1', 'radius: 0.05')}, speed: 1"),
                                        "the opening must have room for a particle, at least 0.141421 m across"),
    "two openings in one place": (emitting(DISC + ", speed: 1}, {" + DISC.replace("[9, 9, 9]", "[9, 9, 9.05]") + ", speed: 1"),
                                  "fluid.emitters[1] must keep its clearance, 0.08 m, from fluid.emitters[0]"),
    "a disc as large as a world": (emitting(f"{DISC.replace('radius: 1', 'radius: 1e6')}, speed: 1"), "at most 2^24 particles"),
    "a disc beyond the world": (emitting(f"{DISC.replace('[9,', '[1e12,')}, speed: 1"), "must lie within 2^31 support radii"),
    "an emitter beyond the limits": (emitting(f"{DISC}, speed: 1") + "domain: {limits: {min: [-1, -1, -1], max: [5, 5, 5]}}\n",
                                     "fluid.emitters[0]: must lie within domain.limits along x"),
    "too many to name": (emitting(f"{DISC}, speed: 1e10"), "at most 2^40 particles until end_time"),
    "a rectangle of one edge": (emitting("rectangle: {position: [9, 9, 9], direction: [1, 0, 0], size: [1]}, speed: 1"),
                                "size must be a list of 2 numbers"),
    "an emitter that stops first": (emitting(f"{DISC}, speed: 1, start: 1, stop: 1"), "stop must be > start, not 1 <= 1"),
    "fewer than none": (emitting(f"{DISC}, speed: 1, max_particles: -1"), "max_particles must be >= 0"),
    "no clearance": (emitting(f"{DISC}, speed: 1, clearance: 0"), "clearance must be in (0, 1]"),
    "odd period": (added("domain: {periodic: [true, false, false], min: [0, 0, 0], max: [1.05, 1, 1]}"), "domain along x",
                   "whole number of particle spacings"),
    "short period": (added("domain: {periodic: [true, false, false], min: [0, 0, 0], max: [1e-300, 1, 1]}"),
                     "domain along x", "at least 3"),
    "endless period": (added("domain: {periodic: [true, false, false], min: [-1e308, 0, 0], max: [1e308, 1, 1]}"),
                       "domain along x"),
    "all at once": (GOOD.replace("0.1", "x").replace(": 1\n", ": -1\n") + "gravty: 1\nsolver: {warm_start: 2, method: a}\n"
                    "boundary: {walls: [{}, 3]}\n",
                    "particle_spacing must be a number", "end_time must be > 0", "unknown key 'gravty'",
                    "solver.warm_start must be", "solver.method must be one of", "boundary.walls[0] must have",
                    "boundary.walls[1] must be a map"),
}


def tree(folder):
    """All that lies below a folder, with sizes."""
    return {str(p.relative_to(folder)): p.stat().st_size if p.is_file() else -1 for p in folder.rglob("*")}


def start(case, arguments, folder, ranks, **more):
    """Runs the program in `folder`, on one rank without a launcher; returns exit code and output."""
    launcher = [*case.mpiexec, "-n", str(ranks)] if ranks > 1 else []
    command = [*more.pop("before", []), *launcher, *more.pop("within", []), case.halocline, *arguments]
    environment = c.mpi_environment(ranks, case.folder)
    if ranks == 1 and "run" in arguments:
        environment["ASAN_OPTIONS"] = c.without_leaks(environment)
    more.setdefault("stdout", subprocess.PIPE)
    more.setdefault("stderr", subprocess.STDOUT if more["stdout"] == subprocess.PIPE else subprocess.PIPE)
    try:
        done = subprocess.run(command, cwd=folder, env=environment, stdin=subprocess.DEVNULL, timeout=120, check=False,
                              **more)
    except subprocess.TimeoutExpired as error:
        raise c.CaseFailed(f"{command}: no end after 120 s") from error
    return done.returncode, ((done.stdout or b"") + (done.stderr or b"")).decode(errors="replace")


def expect_message(what, code, text, expected, words):
    """One message (none if the code is 0), with the words, and no noise."""
    told = f"{what}: exit code {code}, expected {expected}\n{text[:3000]}"
    c.expect(code == expected, told)
    for word in words:
        c.expect(word in text, f"{what}: nothing says \"{word}\"\n{text[:3000]}")
    for word in NOISE:
        c.expect(word not in text, f"{what}: \"{word}\" in\n{text[:3000]}")
    c.expect(text.count("halocline: error: ") <= 1, f"{what}: more than one message\n{text[:3000]}")


def expect_place(what, text, place):
    """The caret stands under the column that the message names."""
    found = re.search(rf"scene\.yaml:{place}: .*\n(.*)\n([ \t]*)\^", text)
    c.expect(found, f"{what}: no message with caret at {place}\n{text[:3000]}")
    column = int(place.split(":")[1])
    if column <= 110:
        c.expect(len(found.group(2)) == column - 1, f"{what}: the caret is not under {place}\n{text[:3000]}")


def refuse_scene(case, name, ranks):
    scene, *words = SCENES[name]
    what = f"{name}, {ranks} ranks"
    with tempfile.TemporaryDirectory(dir=case.folder) as folder:
        folder = Path(folder)
        (folder / "scene.yaml").write_bytes(scene if isinstance(scene, bytes) else scene.encode())
        before = tree(folder)
        arguments = ["check", "scene.yaml"] if ranks == 1 else ["run", "scene.yaml", "--quiet"]
        code, text = start(case, arguments, folder, ranks)
        places = [word for word in words if re.fullmatch(r"\d+:\d+", word)]
        expect_message(what, code, text, 2, ["halocline: error: ", *(word for word in words if word not in places)])
        for place in places:
            expect_place(what, text, place)
        c.expect(tree(folder) == before, f"{what}: left {sorted(tree(folder))}")


def all_of(tasks):
    """Runs them side by side and tells all that failed."""
    failures = []
    with concurrent.futures.ThreadPoolExecutor(JOBS) as pool:
        for done in [pool.submit(*task) for task in tasks]:
            try:
                done.result()
            except c.CaseFailed as failure:
                failures.append(str(failure))
    c.expect(not failures, "\n".join(failures))
    return len(tasks)


def scenes(case, _):
    count = all_of([(refuse_scene, case, name, 1) for name in SCENES])
    return f"check refuses {count} broken scenes"


def scenes_on_ranks(case, _):
    """Every fourth: what is wrong is found in one place, and told by another."""
    count = all_of([(refuse_scene, case, name, 3) for name in list(SCENES)[::4]])
    return f"run refuses {count} broken scenes on 3 ranks"


SETS = {
    "no equals sign": ("end_time", "--set end_time: path.to.key=value is meant"),
    "nothing at all": ("", "path.to.key=value is meant"),
    "no key": ("=1", "path.to.key=value is meant"),
    "no value": ("end_time=", "end_time has no value"),
    "unknown key": ("end_tim=1", "unknown key 'end_tim'; did you mean 'end_time'?"),
    "unknown map": ("solvr.method=dfsph", "unknown key 'solvr.method'"),
    "wrong type": ("end_time=soon", "--set end_time=soon: end_time must be a number, not 'soon'"),
    "out of range": ("end_time=-1", "end_time must be > 0, not '-1'"),
    "unit": ("particle_spacing=2cm", "must be a number, not '2cm'"),
    "a whole map by a word": ("solver=dfsph", "solver must be a map, not 'dfsph'"),
    "a map by a list": ("solver=[1]", "solver must be a map, not a list of 1"),
    "a list by a number": ("fluid.blocks=3", "fluid.blocks must be a list of maps, not '3'"),
    "a list of words": ("fluid.blocks=[a]", "fluid.blocks[0] must be a map, not 'a'"),
    "a map of unknown keys": ("solver={magic: 1}", "unknown key 'solver.magic'"),
    "item that is not there": ("fluid.blocks[7].velocity=[0,0,0]", "has no item 7: it has 1"),
    "negative item": ("fluid.blocks[-1].velocity=[0,0,0]", "list[index].key is meant"),
    "enormous item": ("fluid.blocks[99999999999999999999].velocity=[0,0,0]", "has no item"),
    "component of a vector": ("gravity[2]=0", "gravity is not a list of maps"),
    "not YAML": ("gravity=[0, 0", "not valid YAML"),
    "two documents": ("name=a\n---\nb", "only one YAML document may be given"),
    "invalid UTF-8": (b"name=k\xe4se", "not UTF-8 text: byte 0xe4"),
    "long key": (5000 * "k" + "=1", "unknown key"),
}

# Name: arguments, exit code, and what the message must hold. {long} is a long name.
COMMANDS = {
    "no command": ([], 2, "Usage:"),
    "unknown command": (["simulate", "scene.yaml"], 2, "there is no command 'simulate'"),
    "empty command": ([""], 2, "there is no command ''"),
    "unknown option": (["run", "scene.yaml", "--fast"], 2, "unrecognized option", "--fast"),
    "option of another command": (["check", "scene.yaml", "--force"], 2, "unrecognized option"),
    "no scene": (["run"], 2, "run needs SCENE.yaml"),
    "one file of two": (["diff", "scene.yaml"], 2, "diff needs A B"),
    "too many files": (["check", "scene.yaml", "other.yaml"], 2, "'other.yaml' is one argument too many"),
    "steps: word": (["run", "scene.yaml", "--steps", "many"], 2, "--steps must be a whole number", "got 'many'"),
    "steps: negative": (["run", "scene.yaml", "--steps=-1"], 2, "--steps must be", "got '-1'"),
    "steps: fraction": (["run", "scene.yaml", "--steps=1.5"], 2, "--steps must be", "got '1.5'"),
    "steps: enormous": (["run", "scene.yaml", "--steps=99999999999999999999"], 2, "--steps must be"),
    "steps: missing": (["run", "scene.yaml", "--steps"], 2, "requires an argument"),
    "ranks: none": (["check", "scene.yaml", "--ranks=0"], 2, "--ranks must be", "at least 1"),
    "tolerance: negative": (["diff", "a", "b", "--tolerance=-1"], 2, "--tolerance must be", "got '-1'"),
    "tolerance: NaN": (["diff", "a", "b", "--tolerance=nan"], 2, "--tolerance must be", "got 'nan'"),
    "unknown solver": (["keys", "--solver", "magic"], 2, "unknown solver 'magic'; known: dfsph"),
    "too many settings": (["check", "scene.yaml", *(["--set", "end_time=1"] * 257)], 2, "at most 256 --set"),
    "scene: missing file": (["check", "none.yaml"], 2, "none.yaml: cannot be opened: No such file"),
    "scene: folder": (["check", "."], 2, ".: a folder, not a scene file"),
    "scene: file as folder": (["check", "scene.yaml/x"], 2, "cannot be opened: Not a directory"),
    "scene: link to itself": (["check", "loop.yaml"], 2, "loop.yaml: cannot be opened: Too many levels"),
    "scene: unreadable": (["check", "/proc/self/mem"], 2, "/proc/self/mem: cannot be read: Input/output error"),
    "scene: endless": (["check", "/dev/zero"], 2, "/dev/zero: larger than 32 MiB"),
    "scene: long name": (["check", "{long}"], 2, "cannot be opened: File name too long"),
    "run: missing scene": (["run", "none.yaml"], 2, "none.yaml: cannot be opened"),
    "run: no name for the output": (["run", "scene.yaml", "-o", ""], 2, "the output directory must have a name"),
    "run: long output": (["run", "scene.yaml", "-o", "{long}"], 2, "output directory's name has"),
    "run: output is a file": (["run", "scene.yaml", "-o", "scene.yaml"], 3, "a file of that name is in the way"),
    "run: output in a file": (["run", "scene.yaml", "-o", "scene.yaml/out"], 3, "cannot create the output directory",
                              "Not a directory"),
    "run: unwritable output": (["run", "scene.yaml", "-o", "/proc/out"], 3, "cannot create the output directory"),
    "run: output is a dead link": (["run", "scene.yaml", "-o", "loop.yaml"], 3, "cannot create the output directory"),
    "run: more particles than memory": (["run", "scene.yaml", "--set", "particle_spacing=1e-4"], 1, "out of memory:",
                                        "64000000000 fluid", "particle_spacing"),
    "info: missing file": (["info", "none.hdf"], 2, "none.hdf", "No such file"),
    "info: folder": (["info", "."], 2, ".: a folder, not a snapshot"),
    "info: text": (["info", "scene.yaml"], 2, "scene.yaml"),
    "info: empty file": (["info", "/dev/null"], 2, "/dev/null"),
    "diff: missing files": (["diff", "none.hdf", "nought.hdf"], 2, "none.hdf", "No such file"),
    "diff: folders": (["diff", ".", "."], 2, ".: a folder, not a snapshot"),
    "diff: texts": (["diff", "scene.yaml", "scene.yaml"], 2, "scene.yaml"),
    "help": (["--help"], 0, "Usage:"),
    "help of a command": (["run", "--help"], 0, "--steps=N"),
    "version": (["--version"], 0, "halocline 0"),
    **{f"set: {name}": (["check", "scene.yaml", "--set", value], 2, *words) for name, (value, *words) in SETS.items()},
    **{f"run with set: {name}": (["run", "scene.yaml", "--set", value], 2, *words)
       for name, (value, *words) in list(SETS.items())[:5]},
}


def call_badly(case, name, ranks):
    arguments, expected, *words = COMMANDS[name]
    arguments = [5000 * "l" if argument == "{long}" else argument for argument in arguments]
    what = f"{name}, {ranks} ranks"
    with tempfile.TemporaryDirectory(dir=case.folder) as folder:
        folder = Path(folder)
        (folder / "scene.yaml").write_text(GOOD, encoding="utf-8")
        (folder / "loop.yaml").symlink_to("loop.yaml")
        before = tree(folder)
        code, text = start(case, arguments, folder, ranks)
        expect_message(what, code, text, expected, words)
        c.expect(text.count(words[0]) == 1, f"{what}: \"{words[0]}\" not once\n{text[:3000]}")
        c.expect(tree(folder) == before, f"{what}: left {sorted(tree(folder))}")


def commands(case, _):
    return f"{all_of([(call_badly, case, name, 1) for name in COMMANDS])} bad command lines end as agreed"


def commands_on_ranks(case, _):
    return f"{all_of([(call_badly, case, name, 3) for name in COMMANDS])} bad command lines end as agreed on 3 ranks"


def output_taken(case, folder, ranks):
    """A run is not overwritten, and --force removes the run but nothing else."""
    run = ["run", "scene.yaml", "-o", "out", "--quiet", "--steps", "1"]
    what = f"a folder that holds a run, {ranks} ranks"
    expect_message(what, *start(case, run, folder, ranks), 0, [])
    (folder / "out/mine.txt").write_text("keep", encoding="utf-8")
    before = tree(folder)
    code, text = start(case, run, folder, ranks)
    expect_message(what, code, text, 2, ["halocline: error: ", "already holds a run", "--force"])
    c.expect(tree(folder) == before, f"{what}: it was changed")
    expect_message(what, *start(case, [*run, "--force"], folder, ranks), 0, [])
    c.expect((folder / "out/mine.txt").exists(), f"{what}: --force removed a file that was not the run's")


def output_blocked(case, folder, ranks):
    """A file where the snapshots go, and a folder where steps.csv goes."""
    (folder / "out").mkdir()
    (folder / "out/snapshots").write_text("in the way", encoding="utf-8")
    code, text = start(case, ["run", "scene.yaml", "-o", "out", "--quiet"], folder, ranks)
    expect_message("a file called snapshots", code, text, 3, ["halocline: error: ", "out/snapshots"])
    c.expect((folder / "out/snapshots").read_text(encoding="utf-8") == "in the way", "a file called snapshots is lost")
    (folder / "other/steps.csv").mkdir(parents=True)
    code, text = start(case, ["run", "scene.yaml", "-o", "other", "--quiet", "--force"], folder, ranks)
    expect_message("a folder called steps.csv", code, text, 3, ["halocline: error: ", "other/steps.csv"])


def expect_whole(folder):
    """What a run left under final names is whole: tables of full rows, readable snapshots, no temporary files."""
    for path in folder.rglob("*"):
        c.expect(not path.name.endswith(".tmp"), f"a temporary file is left: {path}")
        if path.suffix == ".csv":
            text = path.read_text(encoding="utf-8")
            c.expect(not text or text.endswith("\n"), f"{path}: half a row: {text[-80:]!r}")


def output_limited(case, folder, ranks):
    """A limit of the size of files is met by a snapshot: a message, no signal."""
    settings = ["--set", "particle_spacing=0.01"]  # 64000 particles, a snapshot of 6 MB
    code, text = start(case, ["run", "scene.yaml", "-o", "out", "--quiet", "--steps", "1", *settings], folder, ranks,
                       within=["prlimit", "--fsize=4500000"])
    expect_message("a limit of file sizes", code, text, 3, ["halocline: error: ", "snap_000000.hdf", "file size limit"])
    c.expect(not list(folder.glob("out/snapshots/*.hdf")), "a limit of file sizes: a snapshot is left")
    expect_whole(folder)


def disk_full(case, folder, ranks):
    """A small disk: the first snapshot fits, the second does not. Skipped where nothing can be mounted."""
    disk = folder / "disk"
    disk.mkdir()
    if subprocess.run(["mount", "-t", "tmpfs", "-o", "size=1000k", "tmpfs", str(disk)], stderr=subprocess.DEVNULL,
                      check=False).returncode:
        print("a full disk: skipped, for nothing can be mounted here", flush=True)
        return
    try:
        code, text = start(case, ["run", "scene.yaml", "-o", "disk/out", "--quiet", "--steps", "20", "--set",
                                  "particle_spacing=0.02", "--set", "output.snapshots.every=1e-9"], folder, ranks)
        expect_message("a full disk", code, text, 3, ["halocline: error: ", "snap_", "No space left on device"])
        found = sorted(disk.glob("out/snapshots/*.hdf"))
        c.expect(found, "a full disk: not even the first snapshot is there")
        for snapshot in found:
            expect_message("a full disk", *start(case, ["info", snapshot], folder, 1), 0, [])
        expect_whole(disk)
    finally:
        subprocess.run(["umount", str(disk)], check=True)


def diverged(case, folder, ranks):
    """A run that fails says why once, in its log too, and keeps what it wrote."""
    code, text = start(case, ["run", "scene.yaml", "-o", "out", "--quiet", "--set",
                              "fluid.blocks[0].velocity=[1e308, 1e308, 0]"], folder, ranks)
    expect_message("a run that diverges", code, text, 1, ["halocline: error: the simulation diverged"])
    c.expect(text.count("diverged") == 1, f"a run that diverges says so more than once\n{text}")
    c.expect("diverged" in (folder / "out/run.log").read_text(encoding="utf-8"), "run.log does not tell why it ended")
    expect_whole(folder)


def unused_key(case, folder, ranks):
    """What the scene says in vain is told once, in the log too, and is no failure."""
    with open(folder / "scene.yaml", "a", encoding="utf-8") as scene:
        scene.write("time_step: {control: cfl, size: 0.001}\n")
    said = "scene.yaml:4:33: time_step.size is not used: time_step.control is cfl"
    for arguments in ["check", "scene.yaml"], ["run", "scene.yaml", "-o", "out", "--quiet", "--steps", "1"]:
        code, text = start(case, arguments, folder, ranks)
        expect_message("a key that is not used", code, text, 0, [f"halocline: warning: {said}"])
        c.expect(text.count(said) == 1, f"a key that is not used: told more than once\n{text}")
    c.expect(said in (folder / "out/run.log").read_text(encoding="utf-8"), "run.log does not tell of a key not used")
    code, text = start(case, ["check", "out/scene.yaml"], folder, 1)
    expect_message("the scene that a run wrote", code, text, 0, [])
    c.expect("warning" not in text, f"the scene that a run wrote has warnings\n{text}")


def in_folder(test, case, ranks):
    with tempfile.TemporaryDirectory(dir=case.folder) as folder:
        (Path(folder) / "scene.yaml").write_text(GOOD, encoding="utf-8")
        test(case, Path(folder), ranks)


def outputs(case, _):
    tests = (output_taken, output_blocked, output_limited, disk_full, diverged, unused_key)
    count = all_of([(in_folder, test, case, ranks) for test in tests for ranks in (1, 3)])
    return f"{count} runs between good and bad end as agreed"


def short_of_memory(case, folder, ranks):
    """Too little memory for the particles is foreseen; too little for all the rest is met by an allocation. With less
    than 600 MB the MPI library itself may hang."""
    spacing = {1: 3e-3, 3: 2e-3}[ranks]  # 2.4 and 8 million particles, foreseen with 860 and 930 MB on a rank
    for limit in {1: (600, 880), 3: (600, 950)}[ranks]:
        code, text = start(case, ["run", "scene.yaml", "-o", "out", "--quiet", "--steps", "1", "--set",
                                  f"particle_spacing={spacing}"], folder, ranks, within=["prlimit", f"--as={limit}000000"])
        what = f"{limit} MB of memory, {ranks} ranks"
        c.expect(code == 1 and "out of memory" in text, f"{what}: exit code {code}\n{text[:3000]}")
        c.expect(ranks > 1 or text.count("out of memory") == 1, f"{what}: more than one message\n{text[:3000]}")
        c.expect(not (folder / "out").exists(), f"{what}: there is an output directory")


def memory(case, _):
    all_of([(in_folder, short_of_memory, case, ranks) for ranks in (1, 3)])
    return "runs that lack memory say so and fail"


def lost_output(case, folder, _):
    """Standard output that is full or closed is a failed output, but no reason to end a run."""
    said = ["halocline: error: ", "standard output could not be written"]
    for arguments in (["check", "scene.yaml"], ["keys"]):
        with open("/dev/full", "wb") as full:
            expect_message(f"{arguments} > /dev/full", *start(case, arguments, folder, 1, stdout=full), 3, said)
        closed = ["sh", "-c", 'exec "$@" >&-', "sh"]
        expect_message(f"{arguments} >&-", *start(case, arguments, folder, 1, before=closed), 3, said)
    for arguments in (["--help"], ["--version"], ["run", "--help"]):
        with open("/dev/full", "wb") as full:
            code, _ = start(case, arguments, folder, 1, stdout=full)
            c.expect(code == 3, f"{arguments} > /dev/full: exit code {code}, expected 3")
    for name, streams in ("one", ">&-"), ("two", "2>&-"), ("all", "<&- >&- 2>&-"):
        closed = ["sh", "-c", f'exec "$@" {streams}', "sh"]
        code, text = start(case, ["run", "scene.yaml", "-o", name, "--steps", "1"], folder, 1, before=closed)
        expect_message(f"run {streams}", code, text, 0, [])
        expect_whole(folder / name)
        log = (folder / name / "run.log").read_text(encoding="utf-8")
        c.expect(all(re.match(r" *\d+\.\d+ info ", line) for line in log.splitlines()), f"run {streams}: in its log\n{log}")


def standard_output(case, _):
    in_folder(lost_output, case, 1)
    return "a standard output that is full or closed is told, and leaves runs alone"


def damaged_snapshots(case, good, folder):
    """Name and bytes of files that begin as a snapshot does."""
    size = len(good)
    for share in (0, 8, 64, 512, 2048, size // 4, size // 2, 3 * size // 4, size - 512, size - 1):
        yield f"first {share} bytes", good[:share]
    yield "text behind the signature", good[:8] + b"text " * 1000
    yield "zeros in the middle", good[:size // 3] + bytes(size // 3) + good[2 * size // 3:]
    state = 12345
    for k in range(60):
        flipped = bytearray(good)
        for _ in range(20):
            state = (1103515245 * state + 12345) % 2**31
            flipped[state % size] ^= 1 << (state >> 8) % 8
        yield f"20 bits flipped, {k}", bytes(flipped)


def altered_snapshots(good):
    """The same through HDF5: files in order, but no snapshots of ours."""
    import h5py
    import numpy as np

    def without(name):
        def alter(file):
            del file[name]
        return alter

    def replaced(name, value):
        def alter(file):
            del file[name]
            file[name] = value
        return alter

    alterations = {"no VTKHDF": without("VTKHDF"), "no Halocline": without("Halocline"),
                   "no points": without("VTKHDF/Points"), "no ids": without("VTKHDF/PointData/id"),
                   "text for points": replaced("VTKHDF/Points", "here"),
                   "flat points": replaced("VTKHDF/Points", np.zeros(7)),
                   "one point": replaced("VTKHDF/Points", np.zeros((1, 3))),
                   "no point": replaced("VTKHDF/Points", np.zeros((0, 3))),
                   "a group for ids": lambda file: (file.pop("VTKHDF/PointData/id"),
                                                    file.create_group("VTKHDF/PointData/id")),
                   "ids of one byte": replaced("VTKHDF/PointData/id", np.zeros(64, np.uint8)),
                   "enormous points": lambda file: (file.pop("VTKHDF/Points"),
                                                    file.create_dataset("VTKHDF/Points", (2**50, 3), "f8", chunks=(64, 3))),
                   "another version": lambda file: file["Halocline"].attrs.modify("format_version", 99),
                   "text for the time": lambda file: file["Halocline"].attrs.create("time", "late"),
                   "no time": lambda file: file["Halocline"].attrs.pop("time")}
    for name, alter in alterations.items():
        path = good.with_name("altered.hdf")
        shutil.copy(good, path)
        with h5py.File(path, "r+") as file:
            alter(file)
        yield name, path.read_bytes()


def read_damaged(case, folder, good, number, name, data, certain):
    """`certain`: whether it cannot be read, by diff at least, for info looks at less."""
    path = folder / f"damaged_{number}.hdf"
    path.write_bytes(data)
    for arguments in ["info", path], ["diff", good, path], ["diff", path, good]:
        what = f"{arguments[0]} of a snapshot, {name}"
        code, text = start(case, arguments, folder, 1)
        if code == 2 or (certain and arguments[0] == "diff"):
            expect_message(what, code, text, 2, ["halocline: error: ", path.name])
        else:
            c.expect(code in (0, 1), f"{what}: exit code {code}\n{text[:3000]}")


def snapshots(case, _):
    """info and diff of files that are nearly snapshots. Flipped bits may lie where nothing reads them."""
    with tempfile.TemporaryDirectory(dir=case.folder) as folder:
        folder = Path(folder)
        (folder / "scene.yaml").write_text(GOOD, encoding="utf-8")
        expect_message("a good run", *start(case, ["run", "scene.yaml", "-o", "out", "-q", "--steps", "1"], folder, 1), 0, [])
        good = folder / "out/snapshots/snap_000000.hdf"
        damaged = [(name, data, not name.startswith(("20 bits", "zeros")))
                   for name, data in damaged_snapshots(case, good.read_bytes(), folder)]
        damaged += [(name, data, True) for name, data in altered_snapshots(good)]
        count = all_of([(read_damaged, case, folder, good, number, *one) for number, one in enumerate(damaged)])
    return f"info and diff of {count} damaged snapshots end as agreed"


if __name__ == "__main__":
    c.main(__doc__, {"scenes": scenes, "scenes_on_ranks": scenes_on_ranks, "commands": commands,
                     "commands_on_ranks": commands_on_ranks, "outputs": outputs, "memory": memory, "standard_output": standard_output,
                     "snapshots": snapshots})
