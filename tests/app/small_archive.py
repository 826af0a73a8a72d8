"""tests/app/small_archive.py: a short run of rods, for tests of its archive and its figure."""
import os
import signal
import subprocess
import time

import drover

SCENE = """
[uniform]
rod_density = 0.5
[current]
speed = 1.0
[relaxation]
rate = 1.0
[elasticity]
stiffness = 0.5
[pressure]
rods = 0.5
[diffusion]
rods = 0.2
[noise]
order = 0.1
rods = 0.2
[grid]
nx = 32
ny = 32
lx = 32.0
ly = 32.0
[time]
dt = 0.25
end = 60.0
[initial]
kind = "stationary"
[output]
frame_every = 30.0
sample_every = 0.5
[run]
seed = 5
"""
SHAPES = {  # of the grid and the cell: nx, ny, lx, ly
    "square": (32, 32, 32, 32), "least": (4, 4, 8, 8), "tiny": (8, 8, 8, 8), "wide": (32, 8, 64, 8),
    "tall": (8, 32, 12, 60), "strip": (64, 4, 128, 4), "oblong": (32, 16, 30, 20)}


def shape_settings(name):
    return [f"grid.{key}={value}" for key, value in zip(("nx", "ny", "lx", "ly"), SHAPES[name])]


def command(folder, output, settings=()):
    scene = folder / "rods.toml"
    scene.write_text(SCENE)
    assert os.environ.get("DROVER"), "expected the program's path in the environment variable DROVER"
    overrides = [word for setting in settings for word in ("--set", setting)]
    return [os.environ["DROVER"], "run", str(scene), "--quiet", "--output", str(output), *overrides]


def run(folder, settings=(), name="rods.h5"):
    """Archive of a run."""
    done = subprocess.run(command(folder, folder / name, settings), capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    return folder / name


def frames_of(path):
    """Number of frames so far; a run in progress has no summary."""
    if not path.exists():
        return 0
    with drover.open_run(path) as going_on:
        assert going_on.summary is None
        return going_on.frames.sizes["time"]


def wait_for_frames(process, path, wanted):
    while frames_of(path) < wanted and process.poll() is None:  # no matter how long it takes
        time.sleep(0.01)


def stopped_run(folder):
    """The archive, and data read from it during the run through a file opened some frames earlier."""
    path = folder / "rods.h5"
    settings = ["time.end=1000000", "output.frame_every=1.0", "output.checkpoint_minutes=0"]
    line = command(folder, path, settings)
    with subprocess.Popen(line, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE) as process:
        try:
            wait_for_frames(process, path, 2)
            with drover.open_run(path) as going_on:
                wait_for_frames(process, path, going_on.frames.sizes["time"] + 3)
                seen = going_on.frames.load(), going_on.observables.load()
        finally:
            process.send_signal(signal.SIGINT)
            message = process.communicate()[1]
    assert process.returncode == 3, message
    return path, seen
