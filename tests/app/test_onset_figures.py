"""tests/app/test_onset_figures.py: the figure of the onset of flocking by the coefficients of a table."""
import subprocess
import sys

import h5py
import numpy
import pytest
from matplotlib import image
from pictures import overlaps, share_of
from support import environment

import drover as package
from drover import boundary_panels, figure, onset_figure
from drover.paper import new_figure

BEADS, RODS, LINE = numpy.linspace(0.2, 0.7, 51), numpy.array([0.05, 0.08, 0.11]), numpy.linspace(0.05, 0.11, 21)


def numbers(rods=RODS, line=LINE):
    """alpha/Gamma = 2 + 5 Phi_r, a/lambda = 1/Phi_b: crossings at Phi_b = 1/(2 + 5 Phi_r) and at half of it."""
    drag = numpy.outer(2.0 + 5.0 * rods, numpy.ones_like(BEADS))
    threshold = numpy.outer(numpy.ones_like(rods), 1.0 / BEADS)
    place = 1.0 / (2.0 + 5.0 * line)
    single = numpy.where(0.5 * place >= BEADS[0], 0.5 * place, numpy.nan)
    ones = numpy.ones_like(line)
    return {"curves": {"rod_fraction": rods, "bead_fraction": BEADS, "drag": drag, "drag_error": 0.05 * drag,
                       "threshold": threshold, "threshold_error": 0.1 * threshold},
            "line": {"line_rod_fraction": line, "mean": place, "mean_error": 0.02 * ones, "mean_share": ones,
                     "single_rod": single,
                     "single_rod_error": 0.01 * ones, "single_rod_share": ones, "mean_above": 0.0 * ones,
                     "single_rod_above": 0.0 * ones}}


AXES = {"curves": ("rod_fraction", "bead_fraction"), "line": ("line_rod_fraction",)}


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
    assert numpy.allclose(lines_of(right, "-", len(LINE))[0].get_xdata(), 1.0 / (2.0 + 5.0 * LINE))
    experiment = next(line for line in right.lines if line.get_linewidth() == 0.7)
    assert numpy.allclose(experiment.get_xdata() + 2.0 * numpy.asarray(experiment.get_ydata()), 0.65)
    assert {text.get_text() for text in right.texts} == {"flocks", "no flocks"}


def test_a_band_shows_the_error_on_both_sides_and_has_the_gaps_of_its_line(tmp_path):
    groups = numbers()
    groups["line"]["mean"][5:8] = groups["line"]["mean_error"][5:8] = numpy.nan
    right = picture_of(write(tmp_path, groups)).axes[1]
    bands = [band for band in right.collections if band.get_alpha() == 0.18]
    pieces = [path.vertices for path in bands[0].get_paths()]
    assert len(pieces) == 2
    for piece in pieces:
        middle = 1.0 / (2.0 + 5.0 * piece[:, 1])
        assert numpy.allclose(abs(piece[:, 0] - middle), 0.02)
    assert not any((piece[:, 1] > LINE[4] + 1e-9).any() and (piece[:, 1] < LINE[8] - 1e-9).any() for piece in pieces)


def test_the_caption_reports_gaps(tmp_path):
    groups = numbers()
    groups["line"]["mean"][:] = numpy.nan
    groups["line"]["mean"][10] = 0.42  # isolated between gaps
    groups["line"]["mean_share"][:] = 0.0  # the caption omits lines that are not drawn
    groups["line"]["mean_share"][10] = 0.4
    picture = picture_of(write(tmp_path, groups))
    assert "λ\u00a0=\u00a0λs/2: no crossing in the table at 20 of 21 area fractions of rods." in words_of(picture)
    assert "that have a crossing, at least 40 % of them" in words_of(picture)
    lone = [line for line in picture.axes[1].lines if line.get_marker() == "o" and len(line.get_xdata()) == 1]
    assert [float(line.get_xdata()[0]) for line in lone] == [0.42]
    assert overlaps(picture) == []


@pytest.mark.parametrize("drag, sentence", [(0.1, "no flocks are predicted"), (9.0, "flocks at all"), (None, "table")])
def test_a_table_without_a_crossing_is_drawn_with_the_reason(tmp_path, drag, sentence):
    groups = numbers()
    groups["curves"]["drag"][:] = [[0.1], [9.0], [9.0]] if drag is None else drag
    for name in ("mean", "single_rod"):
        groups["line"][name][:] = groups["line"][f"{name}_error"][:] = numpy.nan
        groups["line"][f"{name}_share"][:] = 0.0
    picture = picture_of(write(tmp_path, groups))
    said = [text.get_text() for text in picture.axes[1].texts]
    assert len(said) == 1 and said[0].startswith("no crossing in this table")
    assert said[0].rstrip(" on").count(sentence) == 1
    assert overlaps(picture) == []


def test_the_onset_of_the_demo_is_where_the_drag_equals_its_threshold(tmp_path):
    with package.open_theory(write(tmp_path, numbers())) as theory:
        curves, line = theory.groups["curves"].load(), theory.groups["line"].load()
        axes = new_figure((6, 5)).add_subplot()
        runs = {"bead_area_fraction": numpy.array([0.4]), "rod_area_fraction": numpy.array([0.06]),
                "polar_order": numpy.array([0.7])}
        keys, points = onset_figure.draw_onset(axes, curves, line, runs)
        excess, error = onset_figure.margins(curves, line["line_rod_fraction"].values)
        known = curves["rod_fraction"].values
        for number, rods in enumerate(known):  # the interpolation goes through the table
            at = int(numpy.abs(line["line_rod_fraction"].values - rods).argmin())
            if abs(line["line_rod_fraction"].values[at] - rods) < 1e-12:
                assert numpy.allclose(excess[at], (curves["drag"] - curves["threshold"]).values[number])
        places, rods = numpy.concatenate([path.vertices for path in axes.collections[1].get_paths()]).T
        # The threshold is 1/Phi_b; the contour is linear between beads 0.01 apart.
        assert len(places) > 10 and numpy.abs(places - 1.0 / (2.0 + 5.0 * rods)).max() < 2e-4
        assert (error > 0.0).any() and list(points.get_array()) == [0.7] and len(keys) == 4
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


def test_damaged_archives_and_wrong_requests_are_rejected_with_a_message(tmp_path, monkeypatch):
    monkeypatch.setattr("drover.stored.COMMIT_SECONDS", 0.0)
    path = write(tmp_path, numbers())
    with pytest.raises(package.DroverError, match="--frame 0 does not apply, since drover boundary wrote this archive"):
        figure.draw_file(path, frame=0)
    with pytest.raises(package.DroverError,
                       match="is not a run: drover boundary wrote it; open it with drover.open_theory"):
        package.open_run(path)
    for name, sentence in (("line/mean_error", "the group line has no mean_error over line_rod_fraction"),
                           ("line", "has no group line, which drover boundary TABLE writes")):
        with h5py.File(path, "r+") as file:
            del file[name]
        with pytest.raises(package.DroverError, match=sentence):
            figure.draw_file(path)
