#!/usr/bin/python3
"""Damaged scenes never hurt.

Damages the scenes of scenes/ at random (bytes, lines, words, numbers, keys, whole blocks). `halocline check` must
accept or refuse each of them; what it accepts runs two steps, coarser where it has many particles, under a limit of
memory and of time. Every end must be one of the agreed exit codes: no signal, no hang, no sanitizer report. The damage
depends on the seed and on the number of the scene alone, so that --only N repeats one.
"""

import argparse
import collections
import concurrent.futures
import os
import random
import re
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

import case as c

EXTREME = ["0", "-0.0", "-1", "1", "1e-320", "1e-30", "1e-9", "1e-3", "1e3", "1e9", "1e18", "1e30", "1e300", "-1e300",
           "1.7976931348623157e308", "1e999", ".nan", ".inf", "-.inf", "0x10", "1_000", "2147483647", "2147483648",
           "-2147483649", "9223372036854775807", "9223372036854775808", "1e", "1.0.0", "2 cm", '"1"', "", "~", "true",
           "[]", "{}", "[[]]", "*a", "&a 1", "!!float 1"]
WORDS = ["none", "xsph", "artificial", "laminar", "smagorinsky", "constant", "cfl", "fluid", "solid", "true", "false", "computed",
         "taylor_green", "slabs", "[+z]", "[-x, +x]", "plane", "box", "id", "velocity", "acceleration", "dfsph"]
NUMBER = re.compile(r"(?<![\w.])[-+]?\d[\d.]*(?:e[-+]?\d+)?")
WORD = re.compile(r"[A-Za-z_]\w*")
MANY = 20000      # particles; more are made fewer
HOPELESS = 5e7    # particles that do not fit the limit of memory: the program must say so
REPORTS = ("AddressSanitizer", "LeakSanitizer", "runtime error:", "Assertion", "MPI_ERR")


def replace_match(text, pattern, make, rng):
    """Replaces a random match of a pattern, outside comments as a rule."""
    found = list(pattern.finditer(text))
    body = [m for m in found if "#" not in text[text.rfind("\n", 0, m.start()) + 1:m.start()]]
    if not body:
        return text
    match = rng.choice(body)
    return text[:match.start()] + make(match.group()) + text[match.end():]


def damage_bytes(text, rng, _):
    for _ in range(rng.randint(1, 4)):
        at = rng.randrange(len(text) + 1)
        kind = rng.randrange(3)
        new = "" if kind == 0 else rng.choice("\0\x01\t\r\n\x7f\xe9\u2028\U0001f30a" + "{}[],:#&*!|>'\"%@`?-~<= ")
        text = text[:at] + new + text[at + (kind != 1):]
    return text


def damage_lines(text, rng, others):
    lines = text.split("\n")
    at = rng.randrange(len(lines))
    kind = rng.randrange(5)
    if kind == 0:
        del lines[at]
    elif kind == 1:
        lines.insert(rng.randrange(len(lines)), lines[at])
    elif kind == 2:
        other = rng.randrange(len(lines))
        lines[at], lines[other] = lines[other], lines[at]
    elif kind == 3:
        lines.insert(at, rng.choice(rng.choice(others).split("\n")))
    else:
        lines = lines[:at]
    return "\n".join(lines)


def damage_words(text, rng, others):
    words = WORDS + WORD.findall(re.sub(r"#.*", "", rng.choice(others)))
    return replace_match(text, WORD, lambda _: rng.choice(words), rng)


def damage_numbers(text, rng, _):
    for _ in range(rng.choice((1, 1, 1, 2, 5))):
        text = replace_match(text, NUMBER, lambda _: rng.choice(EXTREME), rng)
    return text


def scale_numbers(text, rng, _):
    """Stays plausible: most of these scenes are valid, and odd."""
    def scaled(number):
        try:
            return repr(float(number) * rng.choice((-1, 0.01, 0.1, 0.5, 1.001, 2, 10, 100, 1e4)))
        except ValueError:
            return number
    for _ in range(rng.choice((1, 1, 2, 4))):
        text = replace_match(text, NUMBER, scaled, rng)
    return text


def block_at(lines, at):
    """The end of the line's block: of all that is indented deeper."""
    indent = len(lines[at]) - len(lines[at].lstrip())
    end = at + 1
    while end < len(lines) and (not lines[end].strip() or len(lines[end]) - len(lines[end].lstrip()) > indent):
        end += 1
    return end


def damage_blocks(text, rng, others):
    lines = text.split("\n")
    at = rng.randrange(len(lines))
    end = block_at(lines, at)
    block = lines[at:end]
    kind = rng.randrange(4)
    if kind == 0:
        del lines[at:end]
    elif kind == 1:
        lines[end:end] = block
    elif kind == 2:
        del lines[at:end]
        where = rng.randrange(len(lines) + 1)
        lines[where:where] = [" " * rng.choice((0, 2, 4)) + line for line in block]
    else:
        source = rng.choice(others).split("\n")
        start = rng.randrange(len(source))
        lines[end:end] = source[start:block_at(source, start)]
    return "\n".join(lines)


def damage_shape(text, rng, _):
    """Lists that are longer, nested, repeated."""
    kind = rng.randrange(3)
    if kind == 0:
        return replace_match(text, re.compile(r"\[[^\[\]\n]*\]"), lambda m: rng.choice(("[]", m[:-1] + ", 1]", f"[{m}]")),
                             rng)
    if kind == 1:
        return replace_match(text, re.compile(r"^ *- .*$", re.MULTILINE),
                             lambda m: "\n".join([m] * rng.choice((2, 3, 50))), rng)
    return replace_match(text, re.compile(r"\{[^{}\n]*\}"), lambda m: rng.choice(("{}", "{" * 40, m + m, "~")), rng)


DAMAGES = [damage_bytes, damage_lines, damage_words, damage_numbers, scale_numbers, scale_numbers, damage_blocks,
           damage_shape]


def damaged(scenes, seed, number):
    rng = random.Random(f"{seed} {number}")
    text = rng.choice(scenes)
    for _ in range(rng.choice((1, 1, 2, 3))):
        text = rng.choice(DAMAGES)(text, rng, scenes) or "\n"
    return text.encode("utf-8", errors="surrogatepass")


class Failure(Exception):
    pass


def call(options, folder, arguments, allowed):
    """Runs the program on one rank, without a launcher; returns exit code and output."""
    environment = c.mpi_environment(1, folder.parent)
    if arguments[0] == "run":
        environment["ASAN_OPTIONS"] = c.without_leaks(environment)
    limits = ["--core=0"] + ([f"--as={int(options.memory * 2**30)}"] if options.memory else [])
    command = ["prlimit", *limits, options.halocline, *arguments]
    try:
        done = subprocess.run(command, cwd=folder, env=environment, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE,
                              stderr=subprocess.STDOUT, timeout=options.timeout, check=False)
    except subprocess.TimeoutExpired as error:
        raise Failure(f"{' '.join(command)}: no end after {options.timeout} s") from error
    text = done.stdout.decode(errors="replace")
    if done.returncode not in allowed or any(report in text for report in REPORTS):
        raise Failure(f"{' '.join(command)}: exit code {done.returncode}\n{text[-3000:]}")
    if done.returncode and text.count("halocline: error: ") != 1:
        raise Failure(f"{' '.join(command)}: exit code {done.returncode} without one message\n{text[-3000:]}")
    return done.returncode, text


def particles(report):
    found = re.findall(r"^(?:fluid|boundary) particles +(\d+)", report, re.MULTILINE)
    return sum(map(int, found))


def try_scene(options, scenes, number):
    """What became of a scene: the code of `check`, or "run" and the code of the run."""
    folder = Path(tempfile.mkdtemp(prefix="halocline_fuzz_")) / "scene"
    folder.mkdir()
    try:
        (folder / "scene.yaml").write_bytes(damaged(scenes, options.seed, number))
        code, report = call(options, folder, ["check", "scene.yaml"], (0, 2))
        if code:
            left = sorted(p.name for p in folder.iterdir())
            if left != ["scene.yaml"]:
                raise Failure(f"check left {left}")
            return "refused by check"
        arguments = ["run", "scene.yaml", "-o", "out", "--quiet", "--steps", "2"]
        count = particles(report)
        if MANY < count < HOPELESS:
            spacing = float(re.search(r"^particle spacing +(\S+) m", report, re.MULTILINE).group(1))
            spacing *= 1.05 * (count / MANY) ** 0.5  # the walls' particles fall by its square only
            arguments += ["--set", f"particle_spacing={spacing!r}"]
        code, _ = call(options, folder, arguments, (0, 1, 2, 3))
        if code == 2 and (folder / "out").exists():
            raise Failure("a refused scene left an output directory")
        return f"run, exit code {code}"
    except Failure as error:
        kept = options.keep / f"scene_{number}.yaml"
        options.keep.mkdir(parents=True, exist_ok=True)
        shutil.copy(folder / "scene.yaml", kept)
        return f"FAILED: scene {number}, kept as {kept}\n{error}"
    finally:
        shutil.rmtree(folder.parent, ignore_errors=True)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("halocline", nargs="?", default=str(c.SOURCE / "build/release/halocline"), help="the program")
    parser.add_argument("--count", type=int, default=1000, help="scenes to damage (default: 1000)")
    parser.add_argument("--seed", type=int, default=1, help="of the damage (default: 1)")
    parser.add_argument("--only", type=int, metavar="N", help="only scene N")
    parser.add_argument("--memory", type=float, default=4, metavar="GIB",
                        help="limit of address space (default: 4; 0: none, which sanitizers need)")
    parser.add_argument("--timeout", type=float, default=600, metavar="S",
                        help="limit of each call (default: 600: surfaces may be large)")
    parser.add_argument("--jobs", type=int, default=4, help="scenes at a time; much of a start is waiting (default: 4)")
    parser.add_argument("--keep", type=Path, default=Path(tempfile.gettempdir()) / "halocline_fuzz_failures",
                        metavar="DIR", help="where scenes that failed are left")
    options = parser.parse_args()
    options.halocline = str(Path(options.halocline).resolve())
    scenes = [path.read_text(encoding="utf-8") for path in sorted((c.SOURCE / "scenes").glob("*.yaml"))]
    scenes = [text.replace("meshes/", f"{c.SOURCE}/scenes/meshes/") for text in scenes]  # they are read from elsewhere
    numbers = range(options.count) if options.only is None else [options.only]
    counts, failures = collections.Counter(), []
    with concurrent.futures.ThreadPoolExecutor(options.jobs) as pool:
        for result in pool.map(lambda number: try_scene(options, scenes, number), numbers):
            counts[result if not result.startswith("FAILED") else "FAILED"] += 1
            if result.startswith("FAILED"):
                failures.append(result)
                print(result, flush=True)
    print(f"{len(numbers)} damaged scenes, seed {options.seed}: "
          + ", ".join(f"{count} {what}" for what, count in sorted(counts.items())))
    if options.only is None and not any(what.startswith("run, exit code 0") for what in counts):
        failures.append("no scene ran: this fuzzer tests nothing")
        print(failures[-1])
    sys.exit(1 if failures else 0)


if __name__ == "__main__":
    main()
