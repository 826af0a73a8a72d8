"""tests/app/test_tasks.py: the common tasks of src/docs/commands.md run as they are written, shortened."""
import os
import re
import shlex
import shutil
import subprocess
import sys

import matplotlib
import pytest
from support import DROVER, MODELS

import drover

matplotlib.use("Agg")

PAGE = (MODELS.parent / "src" / "docs" / "commands.md").read_text(encoding="utf-8")
SECTION = re.search(r"^## Common tasks\n(.*?)^## ", PAGE, re.M | re.S)[1]
SHELL, PYTHON = (part.strip("\n").replace("\\\n", "").splitlines()
                 for part in re.findall(r"(?:^    .+\n)+", SECTION, re.M))
# Settings that make runs short, before those of a line; one line is about the size of the grid.
SHORT = {"quench": ["grid.nx=32", "grid.ny=32", "grid.lx=16", "grid.ly=16", "time.end=20"],
         "noisy-flock": ["grid.nx=16", "grid.ny=16", "grid.lx=160", "grid.ly=160", "time.end=200"]}
pytestmark = pytest.mark.skipif(shutil.which("ffmpeg") is None, reason="ffmpeg is not installed")


def words_of(line):
    words = shlex.split(line, comments=True)
    if words[0] == "python3":
        return [sys.executable, *words[1:]]
    short = next((keys for name, keys in SHORT.items() if f"models/{name}.toml" in words), [])
    if "grid.nx=512" in words:
        short = ["time.end=0.4", "output.frame_every=0.4", "output.sample_every=0.4"]
    return [DROVER, *words[1:3], *(word for key in short for word in ("--set", key)),
            *("time.end=30" if word == "time.end=200" else word for word in words[3:])]


@pytest.fixture(scope="module", name="folder")
def the_shell_commands_have_run(tmp_path_factory):
    folder = tmp_path_factory.mktemp("tasks")
    (folder / "models").symlink_to(MODELS)
    for line in SHELL:
        done = subprocess.run(words_of(line), cwd=folder, capture_output=True, text=True, check=False)
        assert done.returncode == 0, f"{line}\n{done.stderr}"
    return folder


def test_every_task_of_the_shell_leaves_what_it_says(folder):
    assert len(SHELL) == 11
    made = set(os.listdir(folder))
    assert {"quench.h5", "strong.h5", "quiet.h5", "random.h5", "disordered.h5", "fine.h5", "quench.mp4",
            "frames-0000.vtk", "quench.png", "noisy-flock.sweep"} <= made
    with drover.open_run(folder / "quench.h5") as run:
        assert float(run.frames.time[-1]) == 30.0  # was restarted
    with drover.open_run(folder / "fine.h5") as run:
        assert run.frames.sizes["x"] == run.frames.sizes["y"] == 512
    with drover.open_run(folder / "quiet.h5") as run:
        assert float(run.observables.variance_rod_density[-1]) < 1e-20
    with drover.open_run(folder / "disordered.h5") as run:
        assert float(run.observables.polar_order[0]) < 0.1 < 0.6


def test_the_tasks_in_python_run_in_their_order(folder, monkeypatch):
    monkeypatch.chdir(folder)
    text = "\n".join(line.removeprefix("    ") for line in PYTHON).replace("256", "32")
    for name, keys in SHORT.items():
        changes = {key.split("=")[0]: float(key.split("=")[1]) for key in keys}
        changes = {key: int(value) if key.startswith("grid.n") else value for key, value in changes.items()}
        text = text.replace(f'load("models/{name}.toml")', f'load("models/{name}.toml").set({changes})')
    names = {}
    exec(text, names)  # pylint: disable=exec-used
    assert names["changed"]["driving.strength"] == 0.8 and names["scene"]["driving.strength"] == 0.6
    assert names["run"].was_changed and names["run"].time == 20.0
    assert all((folder / name).stat().st_size > 10_000 for name in ("sweep.png", "both.png", "own.png"))
