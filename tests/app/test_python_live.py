"""tests/app/test_python_live.py: figures that are redrawn while a run goes on."""
import subprocess
import sys

import matplotlib
import pytest
from support import SMALL, environment

import drover
from drover import figure, live

matplotlib.use("Agg")
from matplotlib import pyplot  # noqa: E402  # after the backend is chosen


class Kept:
    """A screen that keeps what it shows, and is closed after so many figures."""

    def __init__(self, count, between=lambda: None):
        self.count, self.titles, self.between = count, [], between

    @property
    def is_open(self):
        return len(self.titles) < self.count

    def show(self, picture):
        self.titles.append(picture.texts[0].get_text())

    def wait(self, _):
        self.between()


def scene(**changes):
    return drover.Scene.from_dict({**SMALL, "time.end": 2.0, "output.frame_every": 0.5, **changes}, "small.toml")


def times(screen):
    return [title.split("$t$ = ")[1].split(" ")[0] for title in screen.titles]


def test_a_watched_run_shows_each_frame_until_its_end_or_until_the_window_is_closed(monkeypatch):
    for count, expected in ((9, ["0", "1", "2"]), (2, ["0", "1"])):
        screen = Kept(count)
        monkeypatch.setattr(live, "screen", lambda screen=screen: screen)
        run = scene().start()
        assert run.watch(1.0).time == float(expected[-1])
        assert times(screen) == expected


def test_the_figure_of_a_file_is_redrawn_when_the_file_has_changed(tmp_path, monkeypatch):
    path = tmp_path / "small.h5"
    scene().run(path).close()
    waits = []

    def restart():
        waits.append(1)
        if len(waits) == 2:
            drover.restart(path, end=3.0).close()

    screen = Kept(2, restart)
    monkeypatch.setattr(live, "screen", lambda: screen)
    assert figure.main([str(path), "--watch"]) == 0
    assert times(screen) == ["2", "3"] and len(waits) >= 2
    assert not path.with_suffix(".png").exists()


def test_a_window_shows_the_picture_of_a_figure_and_the_next_one_in_its_place():
    window = live.Window()
    run = scene().start()
    window.show(drover.plot.figure(run))
    first = window.image.get_array().copy()
    run.advance(1.0)
    window.show(drover.plot.figure(run))
    assert first.shape == window.image.get_array().shape == (770, 1160, 4) and first[..., :3].std() > 10.0
    assert abs(first.astype(int) - window.image.get_array()).max() > 50 and window.is_open
    pyplot.close("all")
    assert not window.is_open


def test_without_a_window_an_error_says_what_to_use_instead(tmp_path):
    code = "import drover; drover.Scene.from_dict({'time.dt': 0.1, 'time.end': 1.0}).start().watch()"
    ended = subprocess.run([sys.executable, "-c", code], cwd=tmp_path, capture_output=True, text=True, check=False,
                           env=environment(MPLBACKEND="agg"))
    assert ended.returncode == 1 and "drover.film" in ended.stderr.splitlines()[-1]


def test_a_notebook_replaces_the_figure_in_the_output_of_its_cell(monkeypatch):
    shown = []

    class Handle:
        def update(self, picture):
            shown.append(("update", picture))

    display = pytest.importorskip("IPython.display")
    monkeypatch.setattr(display, "display", lambda picture, display_id: shown.append(("new", picture)) or Handle())
    notebook = live.Notebook()
    for picture in ("first", "second", "third"):
        notebook.show(picture)
    assert shown == [("new", "first"), ("update", "second"), ("update", "third")]
