#!/usr/bin/python3
"""scripts/slurm/halocline.sbatch, with a scheduler that this file plays.

Puts srun, mpirun, scontrol and squeue of its own on the PATH, starts the script as sbatch would, keeps its #SBATCH lines
(--signal, --requeue, --open-mode), ends the job at its limit, and starts it again when it was queued again. What Slurm
sends to whom and what it tells meanwhile is what Slurm 22.05 was seen to do. Most cases run a stand-in for the
program; the last ones the program itself.
"""

import os
import re
import shlex
import shutil
import signal
import subprocess
import time
from pathlib import Path

import case as c

SCRIPT = c.SOURCE / "scripts/slurm/halocline.sbatch"
RANKS = 2

# srun and mpirun: the options that a scheduler's own would understand are dropped, the rest is left to mpiexec. Both
# pass USR1 on to every rank, and kill the ranks when they get TERM.
LAUNCHER = """#!/bin/bash
echo "$(basename "$0") $*" >>"$FAKE/launched"
while [ $# -gt 0 ]; do
  case $1 in
  --bind-to) shift 2 ;;
  -*) shift ;;
  *) break ;;
  esac
done
"""
SCONTROL = """#!/bin/bash
[ "$*" = "requeue $SLURM_JOB_ID" ] || { echo "scontrol: unexpected $*" >&2; exit 1; }
[ ! -e "$FAKE/refuse" ] || { echo "scontrol: requests are refused" >&2; exit 1; }
touch "$FAKE/requeue"
"""
SQUEUE = """#!/bin/bash
case "$*" in
"-h -j $SLURM_JOB_ID -o %e") cat "$FAKE/end" ;;
"-h -j $SLURM_JOB_ID -o %r") cat "$FAKE/reason" ;;
*) echo "squeue: unexpected $*" >&2; exit 1 ;;
esac
"""

# The program's interface and nothing else: STEPS steps of 0.05 s, a checkpoint every 50 and before it ends early.
STAND_IN = """#!/usr/bin/python3
import os, signal, sys, time
from pathlib import Path
arguments = sys.argv[1:]
assert arguments[0] == "run", arguments
folder = Path(arguments[arguments.index("-o") + 1])
walltime = float(arguments[arguments.index("--walltime") + 1]) if "--walltime" in arguments else 1e9
first = os.environ["OMPI_COMM_WORLD_RANK"] == "0"
caught = []
for number in (signal.SIGTERM, signal.SIGUSR1, signal.SIGUSR2):
    signal.signal(number, lambda *_: caught.append(1) if "DEAF" not in os.environ else None)
checkpoints = folder / "checkpoints"
checkpoints.mkdir(parents=True, exist_ok=True)
found = sorted(checkpoints.glob("ckpt_*.h5"))
assert "--restart" in arguments or not found, "this directory holds a run"
assert not ("--restart" in arguments and "--force" in arguments), arguments
step = int(found[-1].stem[5:]) if found else 0
start = time.time()
print("begins at", step, flush=True)
while step < int(os.environ["STEPS"]):
    if os.environ.get("FAIL"):
        sys.exit(int(os.environ["FAIL"]))
    time.sleep(0.05)
    if "STUCK" not in os.environ:
        step += 1
    early = caught or time.time() > start + walltime - 1
    if first and step and (early or step % 50 == 0):
        (checkpoints / f"ckpt_{step:08d}.h5").write_text("")
    if early:
        sys.exit(75)
print("done", flush=True)
"""


def write_program(path, text):
    path.write_text(text, encoding="utf-8")
    path.chmod(0o755)
    return path


class Scheduler:
    """A job and its attempts. `ends`: what each attempt suffers, "limit" (the default), "node_failure" or "cancel"."""

    def __init__(self, case, name, program, limit, lead, launcher="srun", environment=None):
        self.folder = case.folder / name
        self.bin = self.folder / "bin"
        self.bin.mkdir(parents=True)
        self.limit, self.lead, self.kill_wait = limit, lead, 4  # s
        self.mpiexec = Path(shutil.which(case.mpiexec[0]))  # before ours come first
        for launch in ("srun", "mpirun"):
            command = shlex.join([str(self.mpiexec), *case.mpiexec[1:], "-n", str(RANKS)])
            write_program(self.bin / launch, LAUNCHER + f'exec {command} "$@"\n')
        write_program(self.bin / "scontrol", SCONTROL)
        write_program(self.bin / "squeue", SQUEUE)
        if program is None:
            program = write_program(self.folder / "halocline", STAND_IN)
        self.environment = {**c.MPI_ENVIRONMENT, **os.environ, "PATH": f"{self.bin}:{os.environ['PATH']}",
                            "FAKE": str(self.folder), "HALOCLINE": str(program), "LAUNCHER": launcher,
                            "SLURM_JOB_ID": "17", **(environment or {})}
        self.environment.pop("SLURM_RESTART_COUNT", None)
        self.directives = dict((option.split("=") + [""])[:2] for option in
                               re.findall(r"^#SBATCH (--\S+)", SCRIPT.read_text(encoding="utf-8"), re.MULTILINE))
        self.log = self.folder / "job.log"
        self.attempts = 0

    def text(self):
        return self.log.read_text(encoding="utf-8", errors="replace")

    def fail(self, text):
        raise c.CaseFailed(f"{self.folder.name}: {text}\n{self.text()[-5000:]}")

    def run(self, arguments, ends=(), limits=(), most=8):
        """Attempts until the job stays out of the queue; the exit code of the script. `limits`: of the first ones."""
        for option in ("--requeue", "--open-mode", "--signal"):
            c.expect(option in self.directives, f"{SCRIPT.name} has no {option}")
        usual = self.limit
        for attempt in range(most):
            self.attempts += 1
            self.limit = limits[attempt] if attempt < len(limits) else usual
            code, again = self.attempt(attempt, arguments, ends[attempt] if attempt < len(ends) else "limit")
            if not again:
                return code
        self.fail(f"still in the queue after {most} attempts")

    def attempt(self, number, arguments, end):
        (self.folder / "requeue").unlink(missing_ok=True)
        (self.folder / "reason").write_text("None\n")
        start = time.time()
        (self.folder / "end").write_text(time.strftime("%Y-%m-%dT%H:%M:%S\n", time.localtime(start + self.limit)))
        environment = dict(self.environment)
        if number > 0:
            environment["SLURM_RESTART_COUNT"] = str(number)
        mode = "ab" if self.directives["--open-mode"] == "append" else "wb"
        with open(self.log, mode) as log:
            shell = subprocess.Popen(["bash", str(SCRIPT), *map(str, arguments)], env=environment, cwd=self.folder,
                                     stdin=subprocess.DEVNULL, stdout=log, stderr=log, start_new_session=True)
        try:
            return self.watch(shell, start, end)
        finally:
            self.kill_session(shell.pid, signal.SIGKILL)
            shell.wait()

    def watch(self, shell, start, end):
        """Plays the job's time; its exit code and whether it is queued again."""
        target, name, lead = re.fullmatch(r"(?:(B):)?(\w+)@(\d+)", self.directives["--signal"]).groups()
        c.expect(int(lead) >= 120, f"{SCRIPT.name}: --signal comes {lead} s before the end only")
        warned = self.lead is None
        while shell.poll() is None and not (self.folder / "requeue").exists():
            now = time.time() - start
            if end == "limit" and not warned and now >= self.limit - self.lead:
                warned = True
                if target:
                    os.kill(shell.pid, getattr(signal, f"SIG{name}"))
                else:
                    self.kill_session(shell.pid, getattr(signal, f"SIG{name}"), without=shell.pid)
            if end == "node_failure" and now >= self.limit / 2:
                self.kill_session(shell.pid, signal.SIGKILL)
                shell.wait()
                return None, "--requeue" in self.directives
            if now >= (self.limit if end == "limit" else self.limit / 2):
                (self.folder / "reason").write_text("TimeLimit\n" if end == "limit" else "None\n")
                self.kill_session(shell.pid, signal.SIGTERM)
                break
            time.sleep(0.05)
        try:  # what is left may end by itself, for a while
            shell.wait(self.kill_wait)
        except subprocess.TimeoutExpired:
            pass
        return shell.poll(), (self.folder / "requeue").exists()

    def kill_session(self, session, number, without=None):
        """The processes of a session that are still there, as Slurm finds those of a job by its own means. What
        plays srun here would kill its ranks at TERM, which srun does not do when its job is being ended."""
        for entry in Path("/proc").iterdir():
            if not entry.name.isdigit():
                continue
            try:
                pid = int(entry.name)
                spared = number == signal.SIGTERM and (entry / "comm").read_text().strip() == self.mpiexec.name
                if os.getsid(pid) == session and pid != without and not spared:
                    os.kill(pid, number)
            except (ProcessLookupError, PermissionError, FileNotFoundError):
                pass


def expect(job, condition, text):
    if not condition:
        job.fail(text)


def notes(job):
    return (job.folder / "out/slurm_attempts.txt").read_text(encoding="utf-8").split()


def completes(case, _):
    """The limit comes several times; by srun and by mpirun."""
    texts = []
    for launcher in ("srun", "mpirun"):
        job = Scheduler(case, f"completes_{launcher}", None, 4, 2, launcher, {"STEPS": "100"})
        code = job.run(["scene.yaml", "out", "--quiet", "--force"])
        expect(job, code == 0 and job.text().count("done") == RANKS, f"ended with {code}, expected 0")
        expect(job, job.attempts >= 3, f"the run was done after {job.attempts} jobs, too few to show anything")
        expect(job, "begins at 0" in job.text(), "the log of the first job is lost")
        at = notes(job)
        expect(job, len(at) == job.attempts and len(set(at)) == len(at) and at[0] == "none",
               f"the attempts began at {at}")
        lines = (job.folder / "launched").read_text(encoding="utf-8").splitlines()
        expect(job, "--force" in lines[0] and "--restart" not in lines[0], f"first: {lines[0]}")
        expect(job, all("--restart" in line and "--force" not in line and "--quiet" in line for line in lines[1:]),
               f"then: {lines[1:]}")
        expect(job, all(line.startswith(launcher) for line in lines), f"launched by {lines[0]}, not by {launcher}")
        texts.append(f"{job.attempts} jobs by {launcher}")
    return "done after " + ", ".join(texts)


def codes(case, _):
    """What the program ends with is passed on, and only 75 leads back into the queue."""
    for code in (1, 2, 3, 134):
        job = Scheduler(case, f"code_{code}", None, 30, 5, environment={"STEPS": "10", "FAIL": str(code)})
        found = job.run(["scene.yaml", "out"])
        expect(job, found == code and job.attempts == 1, f"ended with {found} after {job.attempts} jobs, expected {code}")
    job = Scheduler(case, "refused", None, 4, 2, environment={"STEPS": "1000"})
    (job.folder / "refuse").touch()
    found = job.run(["scene.yaml", "out"])
    expect(job, found == 75 and job.attempts == 1, f"ended with {found} after {job.attempts} jobs, expected 75")
    return "1, 2, 3, 134 end the job; 75 is passed on where the queue refuses"


def no_signal(case, _):
    """A node fails, the warning is lost, the program does not hear: the next job goes on from the last checkpoint."""
    job = Scheduler(case, "node_failure", None, 8, 2, environment={"STEPS": "80"})
    code = job.run(["scene.yaml", "out"], ends=["node_failure"])
    expect(job, code == 0 and "begins at 50" in job.text(), f"ended with {code} after {job.attempts} jobs")
    job = Scheduler(case, "deaf", None, 4, None, environment={"STEPS": "100", "DEAF": "1"})
    code = job.run(["scene.yaml", "out"])
    expect(job, code == 0 and "begins at 50" in job.text(), f"ended with {code} after {job.attempts} jobs")
    return "a node failure and a limit without warning lead on from the last checkpoint"


def walltime(case, _):
    """The program knows when to end, should the signal get lost."""
    job = Scheduler(case, "walltime", None, 64, None, environment={"STEPS": "100"})
    code = job.run(["scene.yaml", "out"])
    expect(job, code == 0 and job.attempts >= 2, f"ended with {code} after {job.attempts} jobs")
    seconds = [int(s) for s in re.findall(r"--walltime (\d+)", (job.folder / "launched").read_text())]
    expect(job, len(seconds) == job.attempts and all(2 <= s <= 4 for s in seconds), f"--walltime was {seconds}")
    return f"done after {job.attempts} jobs, each ended by --walltime"


def no_progress(case, _):
    """A run that makes no step is not queued for ever."""
    job = Scheduler(case, "stuck", None, 3, 2, environment={"STEPS": "10", "STUCK": "1"})
    code = job.run(["scene.yaml", "out"])
    expect(job, code == 75 and job.attempts == 3, f"ended with {code} after {job.attempts} jobs, expected 3")
    job = Scheduler(case, "failing_nodes", None, 3, 2, environment={"STEPS": "1000"})
    code = job.run(["scene.yaml", "out"], ends=["node_failure"] * 8)
    expect(job, code == 75 and job.attempts == 4, f"ended with {code} after {job.attempts} jobs, expected 4")
    expect(job, "no progress in 3 attempts" in job.text(), "the log does not say why")
    return "three jobs from the same checkpoint are enough"


def cancelled(case, _):
    """Who cancels a job does not want it back, but keeps its checkpoint."""
    job = Scheduler(case, "cancelled", None, 6, 1, environment={"STEPS": "1000"})
    code = job.run(["scene.yaml", "out"], ends=["cancel"])
    expect(job, code == 75 and job.attempts == 1, f"ended with {code} after {job.attempts} jobs, expected 1")
    expect(job, list((job.folder / "out/checkpoints").glob("ckpt_*.h5")), "there is no checkpoint")
    return "a cancelled job stays out of the queue"


def the_program(case, steps):
    """The program itself: interrupted jobs end in the same bits as a run in one piece."""
    job = Scheduler(case, "bad_scene", case.halocline, 50, 5)
    code = job.run([c.SOURCE / "scenes/dam_break.yaml", "out", "--set", "particle_spacing=-1"])
    expect(job, code == 2 and job.attempts == 1, f"a bad scene ended with {code} after {job.attempts} jobs")
    if "--restart" not in case.call(["run", "--help"]):
        return "a bad scene ends the job; this program cannot be restarted"
    settings = ["--set", "particle_spacing=0.025", "--steps", steps or 250]
    arguments = [c.SOURCE / "scenes/dam_break.yaml", "out", "--quiet", *settings]
    job = Scheduler(case, "the_program", case.halocline, 300, 5)
    code = job.run(arguments, ends=["limit", "node_failure"], limits=[6, 5])
    expect(job, code == 0, f"ended with {code} after {job.attempts} jobs")
    expect(job, job.attempts >= 2, "the run was done before the first signal")
    whole = case.run("scenes/dam_break.yaml", "whole", RANKS, options=settings)
    c.expect_same_text(whole / "steps.csv", job.folder / "out/steps.csv")
    case.diff(c.snapshots(whole)[-1], c.snapshots(job.folder / "out")[-1])
    return f"{job.attempts} jobs end in the bits of one run"


if __name__ == "__main__":
    c.main(__doc__, {"completes": completes, "codes": codes, "no_signal": no_signal, "walltime": walltime,
                     "no_progress": no_progress, "cancelled": cancelled, "the_program": the_program})
