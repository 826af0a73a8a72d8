"""tests/app/test_demo.py: the page that `make demo` writes, from shortened runs."""
import re
import shutil

import matplotlib
import numpy
import pytest
from matplotlib import image
from support import MODELS

import drover
from drover import demo
from drover.figures import panels

matplotlib.use("Agg")


@pytest.fixture(scope="module", name="page")
def a_page_of_short_runs(tmp_path_factory):
    if shutil.which("ffmpeg") is None:
        pytest.skip("ffmpeg is not installed")
    folder = tmp_path_factory.mktemp("demo")
    return folder, demo.make(MODELS, folder, part=0.05)


def test_the_page_has_its_pictures_its_film_a_sentence_and_a_command_in_each_part(page):
    folder, parts = page
    text = (folder / "index.html").read_text(encoding="utf-8")
    files = re.findall(r'(?:src|poster)="([^"]+)"', text)
    assert sorted(files) == ["flock.png", "particles.mp4", "particles.png", "threshold.png"]
    assert (folder / "particles.mp4").stat().st_size > 10_000
    for name in files[1:]:
        if name.endswith(".png"):
            picture = image.imread(folder / name)
            assert min(picture.shape[:2]) >= 800 and picture.std() > 0.05, name
    assert len(parts) == 3
    for part in parts:
        assert part.sentence.split(":")[0] in ("Particles", "Fields", "Theory") and part.sentence in text
        assert part.command.startswith("build/release/drover ")
    assert "://" not in text  # plain files: nothing is loaded from elsewhere


def test_the_terminal_shows_at_most_twenty_lines(page, monkeypatch, capsys):
    folder, parts = page
    monkeypatch.setattr(demo, "make", lambda *_: parts)
    assert demo.main(["--output", str(folder)]) == 0
    shown = capsys.readouterr().out
    lines = sum(1 + len(line) // 120 for line in shown.splitlines())
    assert lines <= 20 and shown.rstrip().endswith("index.html")


def test_the_kept_start_is_a_flock_and_stays_one(page):
    sentence = page[1][0].sentence
    order, flow = (float(number) for number in re.findall(r"(?:order is|velocities) (0\.\d+)", sentence))
    # P = 0.9 in the run that the start comes from; bodies that fell or overlapped would stop within the first beats.
    # Directions of 2400 beads by chance have an order of 0.02.
    assert order > 0.7 and flow > 0.2


def test_the_map_shows_densities_that_are_not_negative(page):
    with drover.open_run(page[0] / "flock.h5") as run:
        for frame in range(run.frames.sizes["time"]):
            density = run.frames.rod_density.isel(time=frame)
            shown, pixel = panels.shown_means(density)
            assert float(shown.min()) >= 0.0 and pixel[0] <= 30.0
            assert numpy.isclose(float(shown.mean()), float(density.mean()))


def test_missing_scenes_are_reported(tmp_path, capsys):
    assert demo.main(["--models", str(tmp_path), "--output", str(tmp_path / "out")]) == 2
    assert "noisy-flock.toml" in capsys.readouterr().err
