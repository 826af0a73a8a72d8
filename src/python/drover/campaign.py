"""drover/campaign.py: work of many processes, as jobs of Slurm."""
import os
import subprocess

from drover.error import Error


class Submitted:
    """Work that jobs of Slurm do in a folder: see status() and collect()."""

    def __init__(self, folder, status, collect):
        self.folder, self._status, self._collect = folder, status, collect

    def __repr__(self):
        return self.status()

    def status(self):
        """One line: how far all jobs have come."""
        return self._status() if os.path.isdir(self.folder) else "no share has started yet"

    def collect(self):
        """The result of what has ended."""
        return self._collect()


def folder_for_jobs(folder):
    """An absolute path."""
    if folder is None:
        raise Error("slurm without a place for the results that all nodes see; expected folder=, or for a boundary "
                    "output=")
    return os.path.abspath(folder)


def submit(command, scene, folder, shares, options=()):
    """Writes the scene and a script for sbatch beside the folder, and runs it."""
    from drover import _drover
    file, script = folder + ".toml", folder + ".sh"
    with open(file, "w", encoding="utf-8") as out:
        out.write(scene.to_toml())
    with open(script, "w", encoding="utf-8") as out:
        out.write(_drover.slurm_script(command, file, [], folder, shares, list(options)))
    ended = subprocess.run(["sh", script], capture_output=True, text=True, check=False)
    if ended.returncode:
        raise Error(f"{script}: the jobs could not be submitted: {ended.stderr.strip()[-2000:]}", fault="environment")
