#!/usr/bin/python3
"""make install, as a program sees it that embeds a run.

    installed.py BUILD [--mpiexec CMD]

Installs the build directory into a temporary prefix, where only public headers may stand under include/, and builds
include/examples/embed.c against it: with find_package, with pkg-config, and with pkg-config against the static library.
Each program must follow the same dam break on two ranks, and pass on a scene's errors.
"""

import argparse
import os
import shlex
import subprocess
import sys
import tempfile
from pathlib import Path

import case as c

SETTINGS = ("particle_spacing=0.05",)
STEPS = 12
INSTALLED = ("bin/halocline", "include/halocline/halocline.h", "share/halocline/scenes/dam_break.yaml")


def call(command, expected=0, **more):
    done = subprocess.run(command, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True,
                          timeout=300, check=False, **more)
    if done.returncode != expected:
        raise c.CaseFailed(f"{shlex.join(map(str, command))}\nexit code {done.returncode}, expected {expected}\n"
                           f"{done.stdout[-6000:]}")
    return done.stdout


def library_folder(prefix):
    found = sorted(prefix.glob("lib*/**/pkgconfig/halocline.pc"))
    c.expect(len(found) == 1, f"{prefix} has {len(found)} halocline.pc")
    return found[0].parents[1]


def with_cmake(prefix, folder):
    build = folder / "cmake"
    call(["cmake", "-S", c.SOURCE / "include/examples", "-B", build, f"-DCMAKE_PREFIX_PATH={prefix}"])
    call(["cmake", "--build", build])
    return build / "embed"


def with_pkg_config(prefix, folder, static):
    """The one line of the example's head; the static library by its file name, since the shared one stands beside."""
    environment = {**os.environ, "PKG_CONFIG_PATH": str(library_folder(prefix) / "pkgconfig")}
    flags = call(["pkg-config", "--cflags", "--libs", *(["--static"] if static else []), "halocline"], env=environment)
    words = [w if w != "-lhalocline" or not static else "-l:libhalocline.a" for w in shlex.split(flags)]
    program = folder / ("static" if static else "shared")
    call(["mpicc", "-Wall", "-Wextra", "-Werror", "-std=c17", c.SOURCE / "include/examples/embed.c", "-o", program, *words])
    return program


def headers_stand_alone(prefix, folder):
    """Each public header compiles by itself, as C and as C++, with nothing but the installed tree."""
    for header in sorted((prefix / "include/halocline").glob("*.h")):
        for compiler, suffix in (("cc", "c"), ("c++", "cpp")):
            source = folder / f"header.{suffix}"
            source.write_text(f"#include <halocline/{header.name}>\nextern int something;\n", encoding="utf-8")
            call([compiler, "-Wall", "-Wextra", "-Werror", "-pedantic", "-fsyntax-only", f"-I{prefix / 'include'}", source])


def front_positions(program, prefix, mpiexec):
    environment = {**c.MPI_ENVIRONMENT, **os.environ, "LD_LIBRARY_PATH": str(library_folder(prefix))}
    scene = prefix / "share/halocline/scenes/dam_break.yaml"
    start = [*mpiexec, "-n", "2", str(program)]
    lines = call([*start, scene, str(STEPS), *SETTINGS], env=environment).splitlines()
    c.expect(len(lines) == STEPS, f"{program}: {STEPS} steps wanted, printed:\n" + "\n".join(lines))
    front = [float(line.split()[-2]) for line in lines]
    times = [float(line.split()[0]) for line in lines]
    c.expect(all(a < b for a, b in zip(times, times[1:])), f"{program}: times do not grow: {times}")
    c.expect(0.77 < front[0] < 0.78 and front[0] < front[-1] < 0.9, f"{program}: fronts are {front}")
    text = call([*start, prefix / "none.yaml", "1"], expected=2, env=environment)
    c.expect("No such file" in text, f"{program}: a missing scene is not named:\n{text}")
    text = call([*start, scene, "1", "particle_spacing=-1"], expected=2, env=environment)
    c.expect("particle_spacing" in text, f"{program}: a bad value is not named:\n{text}")
    return lines


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("build", type=Path, help="a build directory of Halocline")
    parser.add_argument("--mpiexec", default="mpirun", help="the launcher (default: mpirun)")
    options = parser.parse_args()
    with tempfile.TemporaryDirectory(prefix="halocline_installed_") as name:
        folder = Path(name)
        prefix = folder / "prefix"
        try:
            call(["cmake", "--install", options.build, "--prefix", prefix])
            for path in INSTALLED:
                c.expect((prefix / path).is_file(), f"{path} was not installed")
            others = sorted(p.name for p in (prefix / "include").iterdir() if p.name != "halocline")
            c.expect(not others, f"include/ has {others} beside the public headers")
            headers_stand_alone(prefix, folder)
            programs = [with_cmake(prefix, folder), with_pkg_config(prefix, folder, False),
                        with_pkg_config(prefix, folder, True)]
            printed = [front_positions(program, prefix, shlex.split(options.mpiexec)) for program in programs]
            c.expect(printed[0] == printed[1] == printed[2], f"the three programs disagree: {printed}")
            print(f"installed: three programs agree, the last front is {printed[0][-1]}")
        except c.CaseFailed as error:
            print(f"installed: FAILED\n{error}")
            sys.exit(1)


if __name__ == "__main__":
    main()
