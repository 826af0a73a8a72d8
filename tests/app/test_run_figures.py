"""tests/app/test_run_figures.py: drover.figure of archives of runs, finished or not, of any cell and form."""
import shutil
import subprocess
import sys
from pathlib import Path

import h5py
import numpy
import pytest
from matplotlib import image

import drover
from drover import figure
from drover.figures import panels
import pictures
from pictures import share_of
from small_archive import SHAPES, run, shape_settings, stopped_run
from support import in_process, slow_but


@pytest.fixture(scope="module", name="archive")
def the_archive_of_a_run(tmp_path_factory):
    return run(tmp_path_factory.mktemp("run"))


@pytest.fixture(name="copy")
def a_copy_that_a_test_may_spoil(archive, tmp_path):
    return Path(shutil.copy(archive, tmp_path / "copy.h5"))


def draw(path, *arguments):
    """The figure written by the command, [row, column, colour]."""
    line = [sys.executable, "-m", "drover.figure", str(path), *map(str, arguments)]
    done = subprocess.run(line, capture_output=True, text=True, check=False, cwd=path.parent)
    assert done.returncode == 0, done.stderr
    assert done.stderr == ""
    return image.imread(done.stdout.strip())


def overlaps(opened):
    return pictures.overlaps(figure.draw(opened))


def test_the_command_writes_a_png_beside_the_archive_and_prints_its_name(copy):
    picture = draw(copy)
    assert copy.with_suffix(".png").read_bytes().startswith(b"\x89PNG")
    assert picture.shape[0] > 1000 and picture.shape[1] > 1500
    for colour in (panels.BLUE, panels.VERMILLION, panels.GREEN):  # the lines and points of the run are there
        assert share_of(picture, colour) > 1e-4
    assert 0.3 < share_of(picture, "#ffffff") < 0.95  # paper: neither blank nor blotted


@pytest.mark.parametrize("shape", SHAPES)
def test_a_cell_of_any_shape_is_drawn_without_overlaps(tmp_path, shape):
    with drover.open_run(run(tmp_path, shape_settings(shape))) as opened:
        assert overlaps(opened) == []


def test_an_unfinished_run_is_drawn_and_marked(tmp_path):
    unfinished, _ = stopped_run(tmp_path)
    picture = draw(unfinished)
    assert share_of(picture, panels.BLUE) > 1e-4
    with drover.open_run(unfinished) as opened:
        assert overlaps(opened) == []
        assert any("is not finished" in text.get_text() for text in figure.draw(opened).texts)


def test_values_without_errors_are_drawn_as_open_symbols_and_explained(copy):
    with h5py.File(copy, "r+") as file:
        file["summary/structure_factor_rods_error"][:2] = numpy.nan
    with drover.open_run(copy) as opened:
        picture = figure.draw(opened)
        assert any("open symbols" in text.get_text() for text in picture.texts)
        hollow = [line for axes in picture.axes for line in axes.lines
                  if line.get_color() == panels.BLUE and line.get_markerfacecolor() == "white"]
        assert any(opened.summary.wavenumber.values[0] in line.get_xdata() for line in hollow)


@pytest.mark.parametrize("settings, words", [
    (["noise.order=0", "noise.rods=0", "initial.kind=uniform"], "no fluctuations"),
    (["relaxation.rate=-0.05", "initial.kind=uniform", "time.end=10", "output.frame_every=5"],
     "has no stationary state"),
], ids=["without noise", "growing"])
def test_a_run_without_linear_theory_is_drawn_and_marked(tmp_path, settings, words):
    with drover.open_run(run(tmp_path, settings)) as opened:
        picture = figure.draw(opened)
        texts = [*picture.texts, *(text for axes in picture.axes for text in axes.texts)]
        assert any(words in text.get_text().replace("\n", " ") for text in texts)
        assert overlaps(opened) == []


NO_RODS = ["fields.rod_density=false", "current.speed=0", "pressure.rods=0", "diffusion.rods=0", "noise.rods=0"]
BEADS = ["fields.bead_density=true", "drag.coefficient=2", "driving.strength=1", "weathercock.strength=1",
         "stiffness.beads=2",
         "noise.order=0.01", "noise.beads=0.001"]
FLOW = ["noise.order=0", "initial.kind=uniform", "force.kind=point", "force.x=0.1", "viscosity.shear=2", "time.end=5",
        "output.frame_every=5"]
FORMS = {  # settings, names of fields, what the map's title says
    "polar": (NO_RODS, {"polar_order"}, "polar order and its magnitude"),
    "rods, mean orientation": (["current.kind=density-order", "relaxation.saturation=1"],
                               {"rod_density", "polar_order"},
                               "rod density and polar order"),
    "dilute": ([*NO_RODS, *BEADS, "fields.bead_velocity=dynamic"], {"bead_density", "bead_velocity", "polar_order"},
               "bead density and polar order"),
    "two-component": ([*BEADS, "fields.bead_velocity=dynamic"],
                      {"bead_density", "rod_density", "bead_velocity", "polar_order"},
                      "rod density and polar order"),
    "overdamped": ([*BEADS, "fields.bead_velocity=slaved"],
                   {"bead_density", "rod_density", "bead_velocity", "polar_order"},
                   "rod density and polar order"),
    "flow alone": ([*NO_RODS, *BEADS, *FLOW, "fields.bead_velocity=dynamic", "noise.beads=0", "weathercock.strength=0"],
                   {"bead_density", "bead_velocity", "polar_order"}, "bead density and bead velocity"),
}


@pytest.mark.parametrize("shape", slow_but(["square", "wide"], "square"))
@pytest.mark.parametrize("form", FORMS)
def test_every_form_is_opened_and_drawn(tmp_path, form, shape):
    settings, fields, words = FORMS[form]
    with drover.open_run(run(tmp_path, [*shape_settings(shape), *settings])) as opened:
        assert {name.removesuffix("_x").removesuffix("_y") for name in opened.frames.data_vars} == fields
        unit = "mm-2" if form in ("two-component", "overdamped") else "1"
        assert opened.frames.polar_order_x.units == unit
        picture = figure.draw(opened)
        assert f"(a) {words}" in [axes.get_title(loc="left") for axes in picture.axes]
        assert overlaps(opened) == []


def test_a_frame_can_be_chosen(copy):
    assert not numpy.array_equal(draw(copy, "--output", copy.with_name("a.png"), "--frame", 0),
                                 draw(copy, "--output", copy.with_name("b.png"), "--frame", 2))


@pytest.mark.parametrize("arguments, message", [
    (["missing.h5"], "missing.h5 does not exist"),
    (["copy.h5", "--frame", "3"], "has no frame 3; expected 0 to 2"),
    (["copy.h5", "--output", "nowhere/picture.png"], "cannot be written"),
    (["copy.h5", "--output", "copy.h5"], 'the extension ".h5" is not supported'),
    (["damaged.h5"], "/rod_density is damaged"),
])
def test_bad_input_gives_status_2_a_message_and_no_figure(copy, arguments, message):
    with h5py.File(shutil.copy(copy, copy.with_name("damaged.h5"))) as file:
        place = file["rod_density"].id.get_chunk_info(2)
    with open(copy.with_name("damaged.h5"), "r+b") as file:  # its checksum no longer holds
        file.seek(place.byte_offset + place.size // 2)
        file.write(b"\x00\x01\x02\x03" * 16)
    done = in_process(figure.main, copy.parent, *arguments)
    assert done.returncode == 2 and done.stdout == ""
    assert done.stderr.startswith("error: ") and message in done.stderr and done.stderr.count("\n") == 1
    assert not list(copy.parent.glob("**/*.png"))
