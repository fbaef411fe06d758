"""What the whole-program tests share: running halocline on some ranks, reading what it left, failing loudly."""

import argparse
import csv
import os
import shlex
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

SOURCE = Path(__file__).resolve().parents[2]
MPI_ENVIRONMENT = {
    "OMPI_ALLOW_RUN_AS_ROOT": "1",
    "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM": "1",
    "OMPI_MCA_rmaps_base_oversubscribe": "1",
    "OMPI_MCA_mpi_yield_when_idle": "1",
    "OMPI_MCA_hwloc_base_binding_policy": "none",
    "OMPI_MCA_pml": "ob1",
    "OMPI_MCA_btl": "self,vader",
    "OMPI_MCA_ess_singleton_isolated": "1",
}


def mpi_environment(ranks, folder):
    """That of a program on so many ranks. Without a launcher Open MPI keeps its files in a folder of its own, within this one: in
    a common one, programs that run at the same time take each other's for theirs."""
    alone = {"OMPI_MCA_orte_tmpdir_base": tempfile.mkdtemp(prefix="mpi_", dir=folder)} if ranks == 1 else {}
    return {**MPI_ENVIRONMENT, **os.environ, **alone}


def without_leaks(environment):
    """ASAN_OPTIONS for MPI without a launcher, whose helper process the leak checker does not survive."""
    return environment.get("ASAN_OPTIONS", "") + ":detect_leaks=0"


TILE = """
particle_spacing: 0.05
end_time: 1
domain: {periodic: [true, true, true], min: [0, 0, 0], max: [0.4, 0.4, 0.4]}
fluid: {blocks: [{box: {min: [0, 0, 0], max: [0.4, 0.4, 0.4]}}]}
"""


def words(settings):
    return [word for setting in settings for word in ("--set", setting)]


class CaseFailed(Exception):
    """A test case that found what should not be; the text says what."""


def expect(condition, text):
    if not condition:
        raise CaseFailed(text)


class Case:
    """One invocation of a driver: the program under test, the launcher, and a folder for the runs."""

    def __init__(self, halocline, mpiexec, folder):
        self.halocline = str(Path(halocline).resolve())
        self.mpiexec = shlex.split(mpiexec)
        self.folder = Path(folder)

    def call(self, arguments, ranks=1, expected=0, timeout=600, environment=None):
        """Runs the program; any exit code but the expected one is a failure that shows the output."""
        launcher = [*self.mpiexec, "-n", str(ranks)] if ranks > 1 else []
        command = [*launcher, self.halocline, *map(str, arguments)]
        try:
            done = subprocess.run(command, env={**mpi_environment(ranks, self.folder), **(environment or {})}, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE,
                                  stderr=subprocess.STDOUT, text=True, errors="replace", timeout=timeout, check=False)
        except subprocess.TimeoutExpired as error:
            shown = error.stdout.decode(errors="replace") if isinstance(error.stdout, bytes) else error.stdout or ""
            raise CaseFailed(f"{shlex.join(command)}\nno end after {timeout} s\n{shown[-4000:]}") from error
        if done.returncode != expected:
            raise CaseFailed(f"{shlex.join(command)}\nexit code {done.returncode}, expected {expected}\n"
                             f"{done.stdout[-6000:]}")
        return done.stdout

    def run(self, scene, name, ranks=1, settings=(), options=(), environment=None):
        """halocline run of a scene (a path in the source tree); returns the output directory."""
        output = self.folder / name
        self.call(["run", SOURCE / scene, "-o", output, "--force", "--quiet", *words(settings), *options], ranks, environment=environment)
        return output

    def write(self, name, text):
        """A scene of the test's own."""
        path = self.folder / f"{name}.yaml"
        path.write_text(text, encoding="utf-8")
        return path

    def rest_state(self, name, settings=()):
        """A periodic rest state of 0.4 m at a spacing of 0.05 m, made once."""
        path = self.folder / f"{name}.rest"
        if not path.exists():
            self.call(["rest", self.write("tile", TILE), "-o", path, "--quiet", *words(settings)])
        return path

    def diff(self, one, other):
        """halocline diff of two snapshots; a difference is a failure."""
        self.call(["diff", one, other])

    def same(self, one, other):
        """Two runs agree in steps.csv, gauges.csv and every snapshot."""
        for name in ("steps.csv", "gauges.csv"):
            expect_same_text(one / name, other / name)
        ours, theirs = snapshots(one), snapshots(other)
        expect([p.name for p in ours] == [p.name for p in theirs], f"snapshots {ours} and {theirs}")
        for left, right in zip(ours, theirs):
            self.diff(left, right)


    def same_everywhere(self, scene, name, settings, ranks, every, options=()):
        """The same run on one rank, on others with rebalances every so many steps and a few more, and far from the origin: the same
        bits. Returns the first."""
        plain = self.run(scene, f"{name}_plain", 1, (*settings, "parallel.rebalance=none"), options)
        for count in ranks:
            divided = (*settings, f"parallel.rebalance_every={count + every}", f"parallel.decomposition={'metis' if count % 2 else 'slabs'}")
            self.same(plain, self.run(scene, f"{name}_{count}", count, divided, options))
        far = self.run(scene, f"{name}_far", 2, (*settings, "origin_cells=[1000000,0,-1000000]"), options)
        for text in ("steps.csv", "gauges.csv"):
            expect_same_text(plain / text, far / text)
        return plain

    def goes_on(self, scene, whole, name, stop, ranks, settings=()):
        """Stopped behind a step on some ranks and gone on with on two, a run comes to the bytes of the whole one."""
        output = self.run(scene, f"{name}_{stop}", ranks, settings, ["--steps", stop])
        self.call(["run", scene, "-o", output, "--quiet", "--restart", *words(settings)], 2)
        for text in ("steps.csv", "gauges.csv"):
            expect_same_text(whole / text, output / text)


def snapshots(output):
    found = sorted((output / "snapshots").glob("snap_*.hdf"))
    expect(found, f"no snapshots in {output}")
    return found


def steps(output):
    """steps.csv as a list of dictionaries of text."""
    with open(output / "steps.csv", newline="", encoding="utf-8") as file:
        return list(csv.DictReader(file))


def expect_same_text(one, other):
    """Two text files byte for byte; the first line that differs is shown."""
    a, b = one.read_bytes(), other.read_bytes()
    if a == b:
        return
    lines = zip(a.decode(errors="replace").splitlines(), b.decode(errors="replace").splitlines())
    for number, (left, right) in enumerate(lines, 1):
        if left != right:
            raise CaseFailed(f"{one} and {other} differ in line {number}:\n  {left}\n  {right}")
    raise CaseFailed(f"{one} and {other} differ in length: {len(a)} and {len(b)} bytes")


def main(description, cases):
    """Command line of a driver: `cases` maps a name to a function of (Case, quick)."""
    parser = argparse.ArgumentParser(description=description, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("halocline", nargs="?", default=os.environ.get("HALOCLINE", SOURCE / "build/release/halocline"),
                        help="the program (default: $HALOCLINE, else build/release/halocline)")
    parser.add_argument("--mpiexec", default=os.environ.get("MPIEXEC", "mpirun"), help="the launcher (default: mpirun)")
    parser.add_argument("--case", action="append", choices=list(cases), help="only this one (may be repeated)")
    parser.add_argument("--steps", type=int, help="steps of each run, instead of the case's own number")
    parser.add_argument("--keep", type=Path, metavar="DIR", help="leave the runs in DIR")
    options = parser.parse_args()
    if not os.access(options.halocline, os.X_OK):
        parser.error(f"{options.halocline} is not a program")

    folder = options.keep or Path(tempfile.mkdtemp(prefix="halocline_case_"))
    folder.mkdir(parents=True, exist_ok=True)
    case = Case(options.halocline, options.mpiexec, folder)
    failed = 0
    try:
        for name in options.case or cases:
            try:
                print(f"{name}: {cases[name](case, options.steps)}", flush=True)
            except CaseFailed as error:
                failed += 1
                print(f"{name}: FAILED\n{error}\n", flush=True)
    finally:
        if options.keep is None:
            shutil.rmtree(folder, ignore_errors=True)
    sys.exit(1 if failed else 0)
