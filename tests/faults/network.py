"""tests/faults/network.py: shares of a sweep on a network file system that caches, stalls, and loses a machine.

Usage: DROVER=build/release/drover python3 tests/faults/network.py
Needs root, and Debian's sshfs and openssh-server.  Two mounts of one folder stand for two machines: each keeps what it
has read of attributes and names for seconds, as clients of NFS do, gives links of one file other numbers, and has no
locks that the other sees.  The processes are in name spaces of their own, so that only heartbeats tell whether they
live.  One is killed, and the mount of another stalls for longer than the time after which it counts as dead.  Prints
what happened; the status is 1 if the table is not that of one process on the disk.
"""
import os
import shutil
import signal
import socket
import subprocess
import sys
import tempfile
import time
from pathlib import Path

DROVER = str(Path(os.environ.get("DROVER", "drover")).absolute())
MODELS = Path(__file__).resolve().parents[2] / "models"
WORDS = ["--set", "grid.nx=8", "--set", "grid.ny=8", "--set", "time.end=30", "--set", "time.dt=0.01",
         "--vary", "relaxation.rate = 0.1:1:300", "--set", "output.frame_every=0", "--keep", "table", "--quiet",
         "-o", "swept"]
DEATH = 60.0  # seconds without a heartbeat: files/claims.hpp


def why_not():
    """Why it cannot run here; "" if it can."""
    missing = [name for name in ("sshfs", "fusermount", "ssh-keygen", "unshare") if not shutil.which(name)]
    if missing or not Path("/usr/sbin/sshd").exists():
        return f"needs {', '.join(missing or ['sshd'])}: apt-get install sshfs openssh-server"
    return "" if os.geteuid() == 0 and Path("/dev/fuse").exists() else "needs root and FUSE"


def free_port():
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return probe.getsockname()[1]


class Mounts:
    """A server and two mounts of its folder."""

    def __init__(self, folder):
        self.folder, self.store, self.clients = folder, folder / "store", []
        for key in ("host", "user"):
            subprocess.run(["ssh-keygen", "-q", "-t", "ed25519", "-N", "", "-f", folder / key], check=True)
        Path("/run/sshd").mkdir(exist_ok=True)
        self.store.mkdir()
        port = free_port()
        self.server = subprocess.Popen(
            ["/usr/sbin/sshd", "-D", "-p", str(port), "-h", folder / "host", "-o",
             f"AuthorizedKeysFile={folder / 'user.pub'}", "-o", "StrictModes=no", "-o", "PermitRootLogin=yes", "-o",
             "ListenAddress=127.0.0.1", "-o", "PidFile=none"])
        for name in ("one", "two"):
            (folder / name).mkdir()
            words = ["sshfs", "-f", "-p", str(port), "-o", f"IdentityFile={folder / 'user'},StrictHostKeyChecking=no",
                     "-o", "UserKnownHostsFile=/dev/null,LogLevel=ERROR,cache_timeout=20,attr_timeout=10",
                     "-o", "entry_timeout=10", f"root@127.0.0.1:{self.store}", folder / name]
            for _ in range(50):  # until the server listens
                client = subprocess.Popen(words, stderr=subprocess.DEVNULL)
                while client.poll() is None and not (folder / name).is_mount():
                    time.sleep(0.05)
                if client.poll() is None:
                    break
            self.clients.append(client)

    def end(self):
        for name, client in zip(("one", "two"), self.clients):
            client.send_signal(signal.SIGCONT)
            subprocess.run(["fusermount", "-u", "-z", self.folder / name], check=False)
            client.wait()
        self.server.terminate()
        self.server.wait()


def share(folder, *words):
    """In a process name space of its own, as on another machine; killed as a whole."""
    return subprocess.Popen(["unshare", "--pid", "--fork", "--kill-child", "--mount-proc", DROVER, "sweep",
                             "flock.toml", *WORDS, "--workers", "1", *words], cwd=folder)


def records(folder):
    return sum(file.stat().st_size for file in (folder / "swept" / "records").glob("*"))


def study(folder, log=print):
    """What is wrong; "" if nothing is."""
    (folder / "alone").mkdir()
    mounts = Mounts(folder)
    try:
        for place in (folder / "alone", mounts.store):
            shutil.copy(MODELS / "flock.toml", place)
        subprocess.run([DROVER, "sweep", "flock.toml", *WORDS], cwd=folder / "alone", stdout=subprocess.DEVNULL,
                       check=True)
        one, two = (share(folder / name, "--share", f"{number}/2") for number, name in ((1, "one"), (2, "two")))
        while not (mounts.store / "swept" / "records").exists() or records(mounts.store) < 20000:
            time.sleep(0.2)
        one.kill()
        log("the first share was killed")
        one.wait()
        stalled = share(folder / "one", "--share", "1/2")
        time.sleep(3.0)
        mounts.clients[0].send_signal(signal.SIGSTOP)
        log(f"the first mount stalls for {1.3 * DEATH:.0f} s")
        time.sleep(1.3 * DEATH)
        mounts.clients[0].send_signal(signal.SIGCONT)
        statuses = [process.wait(timeout=600) for process in (two, stalled)]
        log(f"statuses of the shares: {statuses}")
        subprocess.run([DROVER, "sweep", "flock.toml", *WORDS], cwd=folder / "two", stdout=subprocess.DEVNULL,
                       check=True, timeout=600)
        wrong = [name for name in ("table.csv", "table.nc")
                 if (folder / "alone" / "swept" / name).read_bytes() != (mounts.store / "swept" / name).read_bytes()]
        return f"other bytes in {' and '.join(wrong)}" if wrong else ""
    finally:
        mounts.end()


def main():
    if why_not():
        sys.exit(why_not())
    with tempfile.TemporaryDirectory(prefix="drover-network-") as folder:
        problem = study(Path(folder))
    print(problem or "the table is that of one process on the disk")
    return 1 if problem else 0


if __name__ == "__main__":
    sys.exit(main())
