"""drover/campaign.py: work of many processes, as jobs of Slurm."""
import subprocess

from drover.error import Error


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
