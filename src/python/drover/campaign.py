"""drover/campaign.py: work of many processes, as jobs of Slurm."""
import os
import subprocess
from pathlib import Path

from drover import new_file
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


def with_absolute_files(scene):
    """The scene with the files that it names beside itself by their absolute paths: a copy of it is elsewhere."""
    changes = {}
    for section, key in (("initial", "file"), ("packing", "file"), ("calibrated", "table")):
        name = scene.values.get(section, {}).get(key)
        if name:
            beside = Path(scene.name).parent / name
            changes[f"{section}.{key}"] = os.path.abspath(beside if beside.exists() else name)
    return scene.set(changes) if changes else scene


def write_once(path, text):
    """Writes a file of this text; one that has another text may be the user's, or what queued jobs still read."""
    there = Path(path)
    if there.exists() and there.read_bytes() != text.encode():
        raise Error(f"{path} exists with another content; remove it if no job needs it, or choose another folder")
    new_file.write(there, text.encode())


def submit(command, scene, folder, shares, options=()):
    """Writes the scene and a script for sbatch beside the folder, and runs it; returns the scene of the jobs."""
    from drover import _drover
    scene = with_absolute_files(scene)
    file, script = folder + ".slurm.toml", folder + ".slurm.sh"
    write_once(file, scene.to_toml())
    write_once(script, _drover.slurm_script(command, file, [], folder, shares, list(options)))
    ended = subprocess.run(["sh", script], capture_output=True, text=True, check=False)
    if ended.returncode:
        raise Error(f"{script}: the jobs could not be submitted: {ended.stderr.strip()[-2000:]}", fault="environment")
    return scene
