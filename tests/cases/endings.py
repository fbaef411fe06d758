#!/usr/bin/python3
"""One of three ranks dies while the others wait: all end, soon, and the exit code says so.

    endings.py PROGRAM [--mpiexec CMD]

PROGRAM is built from endings.c. Sessions: of the program itself, on all ranks, on one rank each, on two of the three.
"""

import argparse
import os
import shlex
import subprocess
import sys
import time

import case as c

SESSIONS = ("own", "all", "alone", "pair")
# What the rank dies of: words of its message. The launcher is told not to look after the others.
CAUSES = {"check": "the test breaks an invariant", "abort": "", "segfault": "", "memory": "out of memory", "heap": "",
          "exit": ""}
SECONDS = 30
ALONE = {"OMPI_MCA_orte_abort_on_non_zero_status": "0"}


def end(program, mpiexec, session, cause):
    command = [*mpiexec, "-n", "3", program, session, cause]
    begin = time.monotonic()
    try:
        done = subprocess.run(command, env={**c.MPI_ENVIRONMENT, **os.environ, **ALONE}, stdin=subprocess.DEVNULL,
                              stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, timeout=SECONDS, check=False)
    except subprocess.TimeoutExpired as error:
        raise c.CaseFailed(f"{shlex.join(command)}\nno end after {SECONDS} s") from error
    text = done.stdout
    c.expect(done.returncode != 0, f"{shlex.join(command)}\nexit code 0\n{text}")
    c.expect(CAUSES[cause] in text, f"{shlex.join(command)}\n{text}")
    c.expect("exited on signal" not in text, f"{shlex.join(command)}\nended by the launcher\n{text}")
    return time.monotonic() - begin


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("program")
    parser.add_argument("--mpiexec", default="mpirun")
    options = parser.parse_args()
    try:
        longest = max(end(options.program, shlex.split(options.mpiexec), session, cause)
                      for session in SESSIONS for cause in CAUSES)
    except c.CaseFailed as error:
        sys.exit(f"endings: FAILED\n{error}")
    print(f"endings: {len(SESSIONS) * len(CAUSES)} deaths of a rank ended all, within {longest:.1f} s")


if __name__ == "__main__":
    main()
