"""tests/app/test_readme.py: every command of README.md runs (shortened), and every link leads to a file."""
import os
import re
import shlex
import shutil
import subprocess
import sys
from pathlib import Path

import matplotlib
import pytest
from support import DROVER, MODELS

import drover

matplotlib.use("Agg")

TREE = MODELS.parent
README = (TREE / "README.md").read_text(encoding="utf-8")
PAGES = ["README.md", "src/README.md", "src/files/README.md", "tests/bench/README.md", "models/README.md",
         "notebooks/README.md",
         *(path.relative_to(TREE).as_posix() for path in sorted((TREE / "src" / "docs").rglob("*.md")))]
# Pages that the build of the manual writes, and pictures that the blocks of a page draw.
GENERATED = re.compile(r"src/docs/(?:(?:gallery|cpp|python|reference/[\w-]+)\.md|(?:checks/)?[\w-]+\.png)")
# Replacements that shorten what a line computes.
SHORT = (("noisy-flock.toml ", "noisy-flock.toml --set time.end=200 "), ("time.end=16000", "time.end=300"),
         ("phase-boundary.toml ", "phase-boundary.toml --set boundary.map=8 "), ('"time.end", 1000', '"time.end", 300'))


def blocks(text):
    """Indented blocks: a list of lists of lines."""
    return [part.strip("\n").splitlines() for part in re.findall(r"(?:^    .+\n)+", text, re.M)]


def lines(is_wanted):
    return [line.strip() for block in blocks(README) for line in block if is_wanted(line.strip())]


def shortened(line):
    for old, new in SHORT:
        line = line.replace(old, new, 1)
    return line


def is_python(line):
    return not line.startswith(("make ", "build/release/drover ", "PYTHONPATH="))


def test_the_readme_is_short():
    assert len(README.splitlines()) < 150


def test_every_target_of_make_exists():
    targets = re.findall(r"^([a-z-]+):", (TREE / "Makefile").read_text(), re.M)
    named = [line.split()[1] for line in lines(lambda line: line.startswith("make "))]
    assert named == ["demo", "test"] and set(named) <= set(targets)
    assert re.search(r"make --no-print-directory test$", (TREE / ".ci" / "run").read_text(), re.M)


@pytest.mark.skipif(shutil.which("ffmpeg") is None, reason="ffmpeg is not installed")
def test_the_commands_of_the_readme_run_in_their_order(tmp_path):
    (tmp_path / "models").symlink_to(MODELS)
    commands = lines(lambda line: line.startswith(("build/release/drover ", "PYTHONPATH=")))
    assert len(commands) >= 6
    for command in commands:
        words = shlex.split(shortened(command), comments=True)
        words = [word for word in words if not word.startswith("PYTHONPATH=")]
        words[0] = DROVER if words[0] == "build/release/drover" else sys.executable
        if words[1] == "serve":
            with subprocess.Popen(words, cwd=tmp_path, stdout=subprocess.PIPE, text=True) as serving:
                assert serving.stdout.readline().startswith("http://127.0.0.1:")
                serving.terminate()
            assert serving.returncode == 0
            continue
        done = subprocess.run(words, cwd=tmp_path, capture_output=True, text=True, check=False)
        assert done.returncode == 0, f"{command}\n{done.stderr}"
    assert {"noisy-flock.h5", "flock.mp4", "frames-0000.vtk", "plane.h5", "plane.png"} <= set(os.listdir(tmp_path))


@pytest.mark.skipif(shutil.which("ffmpeg") is None, reason="ffmpeg is not installed")
def test_the_python_of_the_readme_runs(tmp_path, monkeypatch):
    (tmp_path / "models").symlink_to(MODELS)
    monkeypatch.chdir(tmp_path)
    names = {}
    exec("\n".join(shortened(line) for line in lines(is_python)), names)  # pylint: disable=exec-used
    assert isinstance(names["run"], drover.Simulation) and names["run"].time == 300.0
    assert 0.005 < names["orders"][-1] < 0.02  # p0 = 0.0189 /mm^2
    assert Path("flock.pdf").stat().st_size > 10_000 and Path("flock.mp4").stat().st_size > 10_000


@pytest.mark.parametrize("page", PAGES)
def test_every_link_of_a_page_leads_to_a_file(page):
    text = (TREE / page).read_text(encoding="utf-8")
    links = [link for link in re.findall(r"\]\(([^)\s]+)\)", text) if "://" not in link]
    for link in links:
        file, _, anchor = link.partition("#")
        target = (TREE / page).parent / file if file else TREE / page
        if GENERATED.fullmatch(os.path.relpath(target, TREE)):
            continue
        assert target.exists(), f"{page}: {link}"
        if anchor:
            titles = re.findall(r"^#+ (.+)$", target.read_text(encoding="utf-8"), re.M)
            assert anchor in [re.sub(r"[^\w -]", "", title).lower().replace(" ", "-") for title in titles], link
