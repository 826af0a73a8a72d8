"""tests/app/test_onset_figures.py: the figure of the onset of flocking by the coefficients of a table."""
import subprocess
import sys

import h5py
import numpy
import pytest
from matplotlib import image
from pictures import overlaps, share_of
from support import MODELS, environment

import drover as package
from drover import figure
from drover.figures import boundary_panels, onset_figure
from drover.figures.paper import new_figure

BEADS, RODS, LINE = numpy.linspace(0.2, 0.7, 51), numpy.array([0.05, 0.08, 0.11]), numpy.linspace(0.05, 0.11, 21)


def numbers(rods=RODS, line=LINE):
    """alpha/Gamma = 2 + 5 Phi_r, a/lambda = 1/Phi_b: crossings at Phi_b = 1/(2 + 5 Phi_r) and at half of it."""
    drag = numpy.outer(2.0 + 5.0 * rods, numpy.ones_like(BEADS))
    threshold = numpy.outer(numpy.ones_like(rods), 1.0 / BEADS)
    place = 1.0 / (2.0 + 5.0 * line)
    single = numpy.where(0.5 * place >= BEADS[0], 0.5 * place, numpy.nan)
    ones = numpy.ones_like(line)
    excess = {name: factor * BEADS - place[:, None] for name, factor in (("mean", 1.0), ("single_rod", 2.0))}
    crossing = [(rods, number, bead, error) for number, (beads, error) in enumerate(((place, 0.02), (single, 0.01)))
                for rods, bead in zip(line, beads) if bead == bead]
    of_crossings = numpy.array(crossing).T
    return {"curves": {"rod_fraction": rods, "bead_fraction": BEADS, "drag": drag, "drag_error": 0.05 * drag,
                       "threshold": threshold, "threshold_error": 0.1 * threshold},
            "line": {"line_rod_fraction": line, "mean": place, "mean_error": 0.02 * ones, "mean_share": ones,
                     "single_rod": single, "single_rod_error": 0.01 * ones, "single_rod_share": ones},
            "field": {"rod_fraction": line, "bead_fraction": BEADS,
                      **{f"{name}_excess": values for name, values in excess.items()},
                      **{f"{name}_deviation": values / 0.02 for name, values in excess.items()}},
            "crossings": {"crossing": numpy.arange(len(crossing), dtype=float),
                          "crossing_rod_fraction": of_crossings[0], "convention": of_crossings[1],
                          "bead_area_fraction": of_crossings[2], "low": of_crossings[2] - of_crossings[3],
                          "high": of_crossings[2] + of_crossings[3], "alone": numpy.ones(len(crossing))}}


AXES = {"curves": ("rod_fraction", "bead_fraction"), "line": ("line_rod_fraction",),
        "field": ("rod_fraction", "bead_fraction"), "crossings": ("crossing",)}


def write(folder, groups):
    """An archive as drover boundary TABLE writes it."""
    path = folder / "onset.h5"
    with h5py.File(path, "w") as file:
        file.attrs.update({"title": "drover onset of table.h5 (its scene)", "drover_version": "0.1.0",
                           "scene": "[cell]\nlx = 45.0\n", "scene_file": "table.h5 (its scene)"})
        for name, arrays in groups.items():
            for axis in AXES[name]:
                file.create_dataset(f"{name}/{axis}", data=arrays[axis]).make_scale(axis)
            for key in arrays.keys() - set(AXES[name]):
                dataset = file.create_dataset(f"{name}/{key}", data=arrays[key])
                dataset.attrs["units"] = "mm s-1" if name == "curves" else "1"
                for i, axis in enumerate(AXES[name]):
                    dataset.dims[i].attach_scale(file[f"{name}/{axis}"])
    return path


def picture_of(path):
    with package.open_theory(path) as theory:
        assert theory.kind == "onset"
        return onset_figure.draw(theory)


def words_of(picture):
    return " ".join(text.get_text() for text in picture.texts).replace("\n", " ")


def lines_of(axes, style, least=2):
    return [line for line in axes.lines if line.get_linestyle() == style and len(line.get_xdata()) >= least]


def vertices_of(collection):
    return numpy.concatenate([path.vertices for path in collection.get_paths()]).T


def test_curves_lines_crossings_and_regions_are_drawn(tmp_path):
    picture = picture_of(write(tmp_path, numbers()))
    left, right = picture.axes
    assert overlaps(picture) == []
    assert left.get_ylim() == (0.0, pytest.approx(2.5 * 2.55))  # independent of a/lambda
    thresholds = lines_of(left, "-", len(BEADS))[0], lines_of(left, "--", len(BEADS))[0]
    for line, part in zip(thresholds, (1.0, 0.5)):
        assert line.get_color() == "black" and numpy.allclose(line.get_ydata(), part / BEADS)
    marks = sorted((float(line.get_xdata()[0]), float(line.get_ydata()[0])) for line in left.lines
                   if line.get_marker() == "o")
    places = [(part / (2.0 + 5.0 * rods), 2.0 + 5.0 * rods) for rods in RODS for part in (0.5, 1.0)
              if part / (2.0 + 5.0 * rods) >= 0.2]
    assert numpy.allclose(marks, sorted(places))
    band, mean, single = right.collections[-3:]
    for contour, factor in ((mean, 1.0), (single, 2.0)):
        places, rods = vertices_of(contour)
        # Straight lines between area fractions of rods 0.003 apart.
        assert len(places) > 10 and numpy.abs(places * factor - 1.0 / (2.0 + 5.0 * rods)).max() < 1e-4
    places, rods = vertices_of(band)
    assert numpy.abs(places - 1.0 / (2.0 + 5.0 * rods)).max() < 0.02 + 1e-4
    assert places.min() >= BEADS[0] and places.max() <= BEADS[-1]
    experiment = next(line for line in right.lines if line.get_linewidth() == 0.7)
    assert numpy.allclose(experiment.get_xdata() + 2.0 * numpy.asarray(experiment.get_ydata()), 0.65)
    assert {text.get_text() for text in right.texts} == {"flocks", "no flocks"}


def test_a_line_that_turns_back_is_drawn_whole_and_marked_where_it_is_within_errors(tmp_path):
    """Flocks begin, end and begin again along the beads at few rods: one smooth line, without a jump."""
    groups = numbers()
    excess = LINE[:, None] - 0.08 - 0.02 * numpy.cos(4.0 * numpy.pi * (BEADS - 0.2))
    groups["field"]["mean_excess"], groups["field"]["mean_deviation"] = excess, excess / 0.004
    groups["crossings"]["alone"][:3] = 0.0
    picture = picture_of(write(tmp_path, groups))
    right = picture.axes[1]
    (path,) = right.collections[-2].get_paths()
    steps = numpy.hypot(*numpy.diff(path.vertices, axis=0).T)
    assert steps.max() < 0.02 and len(path.vertices) > 50
    assert "within one band are consistent, within errors, with no threshold" in words_of(picture)
    assert overlaps(picture) == []


def test_marks_at_the_ends_of_the_table_are_whole(tmp_path):
    groups = numbers()
    groups["crossings"]["bead_area_fraction"][0], groups["crossings"]["low"][0] = BEADS[0], numpy.nan
    left = picture_of(write(tmp_path, groups)).axes[0]
    assert left.get_xlim()[0] < BEADS[0] - 0.01 and left.get_xlim()[1] > BEADS[-1] + 0.01


@pytest.mark.parametrize("drag, sentence", [(0.1, "no flocks are predicted"), (9.0, "flocks at all"), (None, "table")])
def test_a_table_without_a_crossing_is_drawn_with_the_reason(tmp_path, drag, sentence):
    groups = numbers()
    groups["curves"]["drag"][:] = [[0.1], [9.0], [9.0]] if drag is None else drag
    groups["crossings"] = {name: values[:0] for name, values in groups["crossings"].items()}
    for name in ("mean", "single_rod"):
        groups["field"][f"{name}_excess"][:] = groups["field"][f"{name}_deviation"][:] = -5.0
    picture = picture_of(write(tmp_path, groups))
    said = [text.get_text() for text in picture.axes[1].texts]
    assert len(said) == 1 and said[0].startswith("no crossing in this table")
    assert said[0].rstrip(" on").count(sentence) == 1
    assert overlaps(picture) == []


def test_the_onset_of_the_demo_is_where_the_drag_equals_its_threshold(tmp_path):
    with package.open_theory(write(tmp_path, numbers())) as theory:
        axes = new_figure((6, 5)).add_subplot()
        runs = {"bead_area_fraction": numpy.array([0.4]), "rod_area_fraction": numpy.array([0.06]),
                "polar_order": numpy.array([0.7])}
        keys, points = onset_figure.draw_onset(axes, theory.groups["field"].load(), runs)
        places, rods = vertices_of(axes.collections[1])
        # Straight lines between area fractions of rods 0.003 apart.
        assert len(places) > 10 and numpy.abs(places - 1.0 / (2.0 + 5.0 * rods)).max() < 1e-4
        assert list(points.get_array()) == [0.7] and len(keys) == 4
        labels = " ".join(key.get_label() for key in keys)
        assert "lambda" not in labels and "onset" in labels


@pytest.mark.parametrize("threshold", [1e300, -1e300, -2.0, numpy.nan, numpy.inf])
def test_a_negative_huge_or_missing_threshold_does_not_change_the_axis(tmp_path, threshold):
    groups = numbers()
    groups["curves"]["threshold"][:, 10:20] = groups["curves"]["threshold_error"][:, 10:20] = threshold
    picture = picture_of(write(tmp_path, groups))
    picture.canvas.draw()
    assert picture.axes[0].get_ylim() == (0.0, pytest.approx(2.5 * 2.55))
    assert ("a/λ is omitted where it is not positive." in words_of(picture)) == (threshold < 0.0)


def test_drag_that_is_nowhere_positive_is_drawn_below_zero(tmp_path):
    groups = numbers()
    groups["curves"]["drag"] *= -1.0
    groups["curves"]["drag_error"] *= -1.0
    low, high = picture_of(write(tmp_path, groups)).axes[0].get_ylim()
    assert low < -2.55 and high > 0.0


@pytest.mark.parametrize("rods", [[0.08], numpy.linspace(0.02, 0.2, 14)], ids=["one", "many"])
def test_one_area_fraction_of_rods_and_many_are_drawn_without_overlaps(tmp_path, rods):
    rods = numpy.array(rods)
    picture = picture_of(write(tmp_path, numbers(rods, rods)))
    assert overlaps(picture) == []
    assert len(lines_of(picture.axes[0], "-", len(BEADS))) == 1 + len(rods)


def test_the_command_draws_the_figure(tmp_path):
    path = write(tmp_path, numbers())
    line = [sys.executable, "-m", "drover.figure", path.name, "-o", "picture.png"]
    done = subprocess.run(line, capture_output=True, text=True, check=False, cwd=tmp_path, env=environment())
    assert done.returncode == 0, done.stderr
    assert share_of(image.imread(tmp_path / "picture.png"), boundary_panels.PALE[3]) > 0.01


def test_damaged_archives_and_wrong_requests_are_rejected_with_a_message(tmp_path):
    path = write(tmp_path, numbers())
    with pytest.raises(package.DroverError, match="--frame 0 does not apply, since drover boundary wrote this archive"):
        figure.draw_file(path, frame=0)
    with pytest.raises(package.DroverError,
                       match="is not a run: drover boundary wrote it; open it with drover.open_theory"):
        package.open_run(path)
    for name, sentence in (("line/mean_error", "the group line has no mean_error over line_rod_fraction"),
                           ("field/mean_excess", "the group field has no mean_excess over rod_fraction, bead_fraction"),
                           ("field", "has no group field, which drover boundary TABLE writes")):
        with h5py.File(path, "r+") as file:
            del file[name]
        with pytest.raises(package.DroverError, match=sentence):
            figure.draw_file(path)
        path = write(tmp_path, numbers())


def test_the_figure_of_a_table_has_the_coefficients_that_scenes_take_with_their_errors():
    table = MODELS / "matched.calibration" / "table.h5"
    known = package.info(table)["coefficients"]
    drawn = package.plot.figure(table)
    titles = [axes.get_title(loc="left") for axes in drawn.axes]
    assert len(titles) == 11 and any(title.startswith("(b) drag [mm/s]") for title in titles)
    assert not any("viscosity bulk" in title for title in titles)  # 0 everywhere
    drag = drawn.axes[1]
    points = [point for point in known["drag"]["points"] if point["rod_area_fraction"] == 0.08]
    line, _, (bars,) = drag.containers[1]
    assert list(line.get_ydata()) == [point["value"] for point in points]
    heights = [numpy.ptp(bar[:, 1]) / 2.0 for bar in bars.get_segments()]
    assert heights == pytest.approx([point["error"] for point in points])
    assert overlaps(drawn) == []
