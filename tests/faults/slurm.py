"""tests/faults/slurm.py: work on a real Slurm, on this machine, whose jobs and daemons are killed.

Usage: DROVER=build/release/drover python3 tests/faults/slurm.py --points 10000 --shares 100 --kills 20
       ... --command calibrate, wanted or tradeoff --shares 8 --kills 8
Needs root, and Debian's slurm-wlm and munge.  Prints what happened, and the status is 1 if the result is not that of
one worker that nothing disturbs: for `sweep` and `calibrate` to the byte.  Which trials run for wanted numbers
(`calibrate --want`) and for a trade-off depends on their times: the numbers must be reached, and a run recommended.
"""
import argparse
import json
import os
import random
import shutil
import signal
import socket
import subprocess
import sys
import tempfile
import time
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "app"))
from calibration import write_tiny  # noqa: E402

DROVER = str(Path(os.environ.get("DROVER", "drover")).absolute())
PROGRAMS = ("slurmctld", "slurmd", "munged", "sbatch", "squeue", "scancel")
SCENE = """[uniform]
rod_density = 2.0
[relaxation]
rate = 0.5
[elasticity]
stiffness = 2.0
[diffusion]
rods = 0.2
[noise]
order = 0.05
rods = 0.8
[grid]
nx = 16
ny = 16
lx = 16.0
ly = 16.0
[time]
dt = 0.1
end = {end}
[initial]
kind = "stationary"
[output]
frame_every = 0.0
sample_every = 1.0
"""
CONFIGURATION = """ClusterName=drover
SlurmctldHost={host}(127.0.0.1)
SlurmctldPort=17017
SlurmUser=root
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
SelectType=select/cons_tres
SelectTypeParameters=CR_CPU
AuthType=auth/munge
AuthInfo=socket={folder}/munge.socket,cred_expire=5
CredType=cred/munge
SlurmdTimeout=20
ReturnToService=2
SlurmdParameters=config_overrides
MaxArraySize=20001
MaxJobCount=40000
JobAcctGatherType=jobacct_gather/none
StateSaveLocation={folder}/state
SlurmctldPidFile={folder}/slurmctld.pid
SlurmctldLogFile={folder}/slurmctld.log
SlurmdSpoolDir={folder}/spool.%n
SlurmdPidFile={folder}/slurmd.%n.pid
SlurmdLogFile={folder}/slurmd.%n.log
SchedulerParameters=batch_sched_delay=0
NodeName=n1 NodeHostname={host} NodeAddr=127.0.0.1 Port=17001 CPUs=4
NodeName=n2 NodeHostname={host} NodeAddr=127.0.0.1 Port=17002 CPUs=4
PartitionName=main Nodes=ALL Default=YES MaxTime=INFINITE State=UP
"""


def why_not():
    """Why there can be no Slurm here; "" if there can."""
    missing = [name for name in PROGRAMS if not shutil.which(name, path=f"{os.environ['PATH']}:/usr/sbin")]
    if missing:
        return f"{', '.join(missing)} not found: install slurm-wlm and munge"
    return "" if os.geteuid() == 0 else "only root can start slurmctld and slurmd here"


class Slurm:
    """slurmctld and two slurmd with their own configuration, in a folder."""

    def __init__(self, folder):
        self.folder = folder
        (folder / "state").mkdir()
        (folder / "slurm.conf").write_text(CONFIGURATION.format(folder=folder, host=socket.gethostname()))
        self.environment = {**os.environ, "SLURM_CONF": str(folder / "slurm.conf"),
                            "PATH": f"{Path(DROVER).parent}:{os.environ['PATH']}:/usr/sbin"}
        key = folder / "munge.key"
        key.write_bytes(os.urandom(128))
        key.chmod(0o400)
        self.daemons = {}
        self.start("munged", "--foreground", "--force", f"--key-file={key}", f"--socket={folder}/munge.socket",
                   f"--pid-file={folder}/munge.pid", f"--log-file={folder}/munge.log", f"--seed-file={folder}/seed")
        time.sleep(1)
        self.start_controller()
        for node in ("n1", "n2"):
            self.start_node(node)

    def start(self, name, *words):
        with open(self.folder / "daemons.log", "a", encoding="utf-8") as log:
            self.daemons[name] = subprocess.Popen([name.partition("@")[0], *words], env=self.environment, stdout=log,
                                                  stderr=log, start_new_session=True)

    def start_controller(self, *words):
        self.start("slurmctld", "-D", *words)

    def start_node(self, node):
        self.start(f"slurmd@{node}", "-D", "-N", node)

    def kill(self, name):
        self.daemons[name].kill()
        self.daemons[name].wait()

    def run(self, *words):
        return subprocess.run(words, env=self.environment, capture_output=True, text=True, check=False, timeout=120)

    def jobs(self):
        """Lines of squeue; nothing while the controller does not answer.  A job whose launch failed is held until its
        user releases it: it is cancelled here, and the next call submits it again."""
        found = self.run("squeue", "--noheader", "--format=%i %T %r")
        if found.returncode != 0:
            return None
        lines = found.stdout.splitlines()
        for line in lines:
            if "held" in line:
                self.run("scancel", line.split()[0])
        return lines

    def end(self):
        self.run("scancel", "--user=root")
        time.sleep(1)
        for process in reversed(self.daemons.values()):
            process.terminate()
            try:
                process.wait(timeout=10)
            except subprocess.TimeoutExpired:
                process.kill()


def work_of(sweep):
    """The processes of drover that work in this folder."""
    found = []
    for entry in Path("/proc").glob("[0-9]*"):
        try:
            words = (entry / "cmdline").read_bytes().split(b"\0")
        except OSError:
            continue
        if words and words[0].endswith(b"drover") and os.fsencode(sweep) in words:
            found.append(int(entry.name))
    return found


def kill_something(slurm, what, sweep, chance):
    """One kill, and the start of what a cluster would start again."""
    working = work_of(sweep)
    if what == "job" and working:
        try:
            os.kill(chance.choice(working), signal.SIGKILL)
        except ProcessLookupError:
            pass
    elif what == "controller":
        slurm.kill("slurmctld")
        time.sleep(1)
        slurm.start_controller()
    elif what in ("node", "node and jobs"):
        node = chance.choice(("n1", "n2"))
        slurm.kill(f"slurmd@{node}")
        for process in working if what == "node and jobs" else ():
            try:
                os.kill(process, signal.SIGKILL)
            except ProcessLookupError:
                pass
        time.sleep(1)
        slurm.start_node(node)


class Work:
    """What the jobs do: the command and its words, without the folder; and whether the result in a folder is right."""

    def __init__(self, folder, points, end):
        self.folder, self.points = folder, points
        (folder / "flock.toml").write_text(SCENE.format(end=end))
        self.command = "sweep"
        self.words = ["flock.toml", "--vary", f"relaxation.rate = 0.5:2:{points}", "--keep", "table"]
        self.results = ["table.csv"]

    def make_reference(self):
        subprocess.run([DROVER, self.command, *self.words, "--quiet", "--workers", "1", "-o", "whole"], cwd=self.folder,
                       check=True, stdout=subprocess.DEVNULL)

    def is_right(self):
        return all(file.exists() and file.read_bytes() == (self.folder / "whole" / name).read_bytes()
                   for name in self.results for file in [self.folder / "shares" / name])


class Calibrate(Work):
    """The small calibration of the tests, with more trials."""

    def __init__(self, folder, points, end):
        super().__init__(folder, points, end)
        write_tiny(folder, {"calibrate.relative_error": 0.02, "calibrate.max_trials": points})
        self.command, self.words, self.results = "calibrate", ["tiny.toml"], ["table.h5", "table.toml"]


class Wanted(Calibrate):
    """Wanted numbers: which trials run depends on their times."""

    def __init__(self, folder, points, end):
        super().__init__(folder, points, end)
        self.words = ["tiny.toml", "--want", "damping_rate=0.5%", "--want", "viscosity_kinematic=5%",
                      "--set", "calibrate.max_trials=100000"]

    def make_reference(self):
        pass

    def is_right(self):
        ended = subprocess.run([DROVER, "calibrate", *self.words, "--quiet", "--collect", "--json", "-o", "shares"],
                               cwd=self.folder, check=False, capture_output=True, text=True)
        return ended.returncode == 0 and all(one["reached"] for one in json.loads(ended.stdout)["want"]["numbers"])


class Tradeoff(Work):
    """A trade-off: which trials run depends on their times, but a run is recommended."""

    def __init__(self, folder, points, end):
        super().__init__(folder, points, 20.0 * end)
        self.command = "tradeoff"
        self.words = ["flock.toml", "--budget", "200s", "--want", "polar_order=2%"]

    def make_reference(self):
        pass

    def is_right(self):
        shared = self.folder / "shares"
        return (shared / "recommended.toml").exists() and not list((shared / "claims").iterdir())


COMMANDS = {"sweep": Work, "calibrate": Calibrate, "wanted": Wanted, "tradeoff": Tradeoff}


def study(work, shares, kills, seed=1, log=print):
    """Returns what is wrong; "" if nothing is."""
    folder, chance = work.folder, random.Random(seed)
    began = time.time()
    work.make_reference()
    log(f"one worker: {time.time() - began:.1f} s")
    script = subprocess.run([DROVER, work.command, *work.words, "--slurm", str(shares), "-o", "shares"], cwd=folder,
                            check=True, capture_output=True, text=True).stdout
    (folder / "work.sh").write_text(script)
    shared = str(folder / "shares")
    slurm = Slurm(folder)
    try:
        while slurm.jobs() is None:
            time.sleep(0.5)
        plan = [("job", "node and jobs", "node", "controller")[i % 4] for i in range(kills)]
        chance.shuffle(plan)
        for call in (1, 2):
            began = time.time()
            with subprocess.Popen(["sh", "work.sh"], cwd=folder, env=slurm.environment, stdout=subprocess.DEVNULL,
                                  stderr=subprocess.DEVNULL) as submission:
                while call == 1 and plan:
                    time.sleep(chance.uniform(0.3, 2.0))
                    kill_something(slurm, plan.pop(), shared, chance)
                submission.wait(timeout=300)
            while time.time() - began < 3600 and (slurm.jobs() is None or slurm.jobs()):
                time.sleep(1)
            log(f"call {call}: {time.time() - began:.0f} s")
            if work.is_right():
                break
    finally:
        slurm.end()
    files = sum(file.is_file() for file in Path(shared).rglob("*"))
    size = sum(file.stat().st_size for file in Path(shared, "records").glob("*"))
    began = time.time()
    subprocess.run([DROVER, work.command, *work.words, "--quiet", "--collect", "-o", "shares"], cwd=folder, check=False,
                   stdout=subprocess.DEVNULL)
    log(f"{kills} kills; {files} files, {size / work.points:.0f} bytes of records a point, collected in "
        f"{time.time() - began:.1f} s")
    return "" if work.is_right() else "the result is not that of one worker"


def main():
    options = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    options.add_argument("--command", choices=COMMANDS, default="sweep")
    options.add_argument("--points", type=int, default=10000)
    options.add_argument("--shares", type=int, default=100)
    options.add_argument("--kills", type=int, default=20)
    options.add_argument("--seed", type=int, default=1)
    options.add_argument("--end", type=float, default=20.0, help="simulated seconds of a point of a sweep")
    given = options.parse_args()
    if why_not():
        sys.exit(why_not())
    with tempfile.TemporaryDirectory(prefix="drover-slurm-") as folder:
        problem = study(COMMANDS[given.command](Path(folder), given.points, given.end), given.shares, given.kills,
                        given.seed)
    print(problem or "the result is that of one worker")
    sys.exit(bool(problem))


if __name__ == "__main__":
    main()
