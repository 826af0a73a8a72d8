"""tests/app/test_python_pictures.py: figures, panels and films of runs in memory and in archives."""
import errno
import json
import os
import shutil
import subprocess
import sys

import matplotlib
import numpy as np
import pytest
import xarray
from matplotlib import image
from matplotlib.quiver import Quiver
from pictures import covered, odd_ticks, overlaps
from support import MODELS, SMALL, drover as program, write_scene

import drover
from drover import figure
from drover.figures import panels
from drover.sweeping import Sweep
from drover.figures.trade_panel import draw_trade

matplotlib.use("Agg")
from matplotlib import pyplot  # noqa: E402  # after the backend is chosen

BEADS = {"cell.lx": 12, "cell.ly": 12, "time.end": 0.02}
needs_ffmpeg = pytest.mark.skipif(shutil.which("ffmpeg") is None, reason="ffmpeg is not installed")


@pytest.fixture(autouse=True)
def close_figures():
    yield
    pyplot.close("all")


def fields(**changes):
    return drover.Scene.from_dict({**SMALL, "time.end": 2.0, **changes}, "small.toml")


def particles(name="bead-flock"):
    return drover.Scene.load(MODELS / f"{name}.toml").set(BEADS)


# --- panels

@pytest.mark.parametrize("scene", [fields(), fields(**{"grid.ny": 1}), particles()])
def test_the_figure_of_a_run_in_memory_has_its_panels(scene):
    run = scene.start()
    run.advance()
    figure = drover.plot.figure(run)
    assert len(figure.axes) >= 3
    assert f"$t$ = {run.time:g} s" in figure.texts[0].get_text()


def test_a_run_in_memory_that_has_ended_is_not_called_unfinished():
    run = fields().start()
    for ended in (False, True):
        words = " ".join(text.get_text() for text in drover.plot.figure(run).texts)
        assert ("not finished" in words) == (not ended)
        run.advance()


def test_a_resolved_field_is_drawn_between_its_points_by_its_fourier_series():
    # A wave of 5 periods on 16 points, and its values on 384: exact but for rounding.
    def wave(x, y):
        return 2.0 + np.cos(2 * np.pi * 5 * x / 8.0) * np.sin(2 * np.pi * 3 * y / 8.0)

    places = {name: np.arange(16) * 0.5 for name in "yx"}
    array = xarray.DataArray(wave(places["x"][None, :], places["y"][:, None]), places, ("y", "x"))
    fine, pixel = panels.refined(array)
    assert fine.shape == (384, 384) and pixel == (8.0 / 384, 8.0 / 384)
    assert float(abs(fine - wave(fine.x, fine.y)).max()) < 1e-13  # rounding of a transform of 384 points
    assert np.allclose(fine[::24, ::24], array, atol=1e-13)
    line = panels.refined_values(array.values[:1])
    assert line.shape == (1, 384)


def test_an_open_run_is_described_in_one_line(tmp_path):
    for scene, words in ((fields(), "rod_density"), (particles(), "beads")):
        with scene.run(tmp_path / f"{scene.kind}.h5") as run:
            assert words in repr(run) and "samples>" in repr(run) and len(repr(run)) < 200 and "\n" not in repr(run)


def test_every_panel_draws_on_the_axes_that_it_is_given(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    with fields().run("small.h5") as run:
        for draw in (drover.plot.map, drover.plot.structure, drover.plot.numbers, drover.plot.order):
            axes = pyplot.figure().add_subplot()
            assert draw(run, axes) is axes and axes.get_xlabel() and axes.get_ylabel() and axes.has_data()
        axes = drover.plot.series("small.h5", "rod_density_variance"
                                  if "rod_density_variance" in run.observables else "polar_order")
        assert axes.has_data() and axes.get_xlabel() == "time $t$ [s]"
        upper, lower = pyplot.figure().subplots(2)
        drover.plot.numbers(run, upper, lower)
        assert lower.has_data()
    with pytest.raises(drover.Error, match="expected one of"):
        drover.plot.series("small.h5", "nothing")
    with pytest.raises(drover.Error, match="drover.plot.map"):
        drover.plot.structure(particles().start())


def test_a_panel_alone_fits_on_its_page_with_its_labels_and_a_colour_bar_as_high_as_the_map(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    with fields(**{"grid.ly": 2.0, "grid.ny": 8}).run("wide.h5") as run:
        for draw in (drover.plot.map, drover.plot.structure, drover.plot.numbers, drover.plot.order):
            page = draw(run).figure
            assert not overlaps(page) and not odd_ticks(page), draw
        shown, bar = drover.plot.map(run).figure.axes
        shown.apply_aspect()
        assert bar.get_position().y1 == pytest.approx(shown.get_position().y1, abs=1e-3)
    own = drover.Scene.load(MODELS / "cahn-hilliard.toml").set({"grid": {"nx": 32, "ny": 16, "ly": 48.0},
                                                                "time.end": 1.0}).start()
    own.advance()
    for draw in (drover.plot.map, drover.plot.means, drover.plot.structure, drover.plot.growth):
        assert not overlaps(draw(own).figure), draw
    size = drover.plot.map(own).get_window_extent()
    assert size.width / size.height == pytest.approx(2.0, rel=1e-3)


def test_ticks_of_a_logarithmic_axis_are_plain_or_powers_and_never_both_nor_fewer_than_two():
    for low, high, tall in ((0.15, 0.4, 2.0), (0.06, 2.3, 2.0), (1e-5, 0.3, 0.7), (2e-6, 9.0, 0.7), (1e-12, 1.0, 2.0),
                            (0.002, 0.0031, 1.0)):
        page = pyplot.figure(figsize=(3.0, 2 * tall))
        axes = page.add_axes((0.3, 0.25, 0.6, 0.5))
        axes.plot([low, high], [low, high])
        panels.log_axes(axes)
        axes.set(xlim=(low, high), ylim=(low, high))
        assert not odd_ticks(page), (low, high)


def test_a_tick_is_shortened_only_where_no_digit_is_lost():
    for value, text in ((1.0005, "1.0005"), (0.0005, "5e\N{MINUS SIGN}4"), (123456.0, "123456"), (200000.0, "2e5")):
        assert panels.plain(value, 0) == text
        assert float(text.replace("\N{MINUS SIGN}", "-")) == value


def test_the_key_of_arrows_stays_below_the_map_when_a_notebook_cuts_the_margins_of_a_page():
    axes = drover.plot.map(fields().start())
    [key] = [text for text in axes.texts if text.get_text().startswith("arrow:")]
    page = axes.figure
    page.canvas.draw()
    box = key.get_window_extent()
    assert box.y1 < axes.xaxis.label.get_window_extent().y0 and key.xycoords == "axes fraction"
    assert page.get_tightbbox().y0 == pytest.approx(box.y0 / page.dpi)  # cut at the key, and not above it


def test_the_legend_of_a_map_of_one_row_is_within_its_page():
    axes = drover.plot.map(fields(**{"grid.ny": 1}).start())
    axes.figure.canvas.draw()
    box, frame = axes.get_legend().get_window_extent(), axes.get_window_extent()
    assert frame.x0 < box.x0 and box.x1 <= frame.x1 + 1 and box.y1 < axes.figure.bbox.y1


def test_arrows_of_a_resolved_field_on_few_points_stay_within_the_cell():
    run = fields(**{"grid.nx": 8, "grid.ny": 8, "noise.order": 0, "noise.rods": 0,
                    "initial.kind": "formula", "initial.polar_order_x": "0.3"}).start()
    axes = drover.plot.map(run)
    arrows = next(child for child in axes.get_children() if isinstance(child, Quiver))
    half = 0.5 * np.hypot(arrows.U, arrows.V).max() / arrows.scale
    left, right = axes.get_xlim()
    assert (arrows.X - half).min() >= left and (arrows.X + half).max() <= right


def test_the_path_of_one_rod_is_drawn_in_the_view_of_its_map():
    run = drover.Scene.load(MODELS / "rod-matched.toml").set({"time.end": 0.02}).start()
    run.advance()
    for edges in ("get_xlim", "get_ylim"):
        shown = getattr(drover.plot.paths(run), edges)()
        assert shown == getattr(drover.plot.map(run), edges)() and np.ptp(shown) < 50.0  # mm


def test_lines_of_a_flow_leave_the_edges_of_a_map_where_they_are():
    run = drover.Scene.load(MODELS / "point-force.toml").set({"grid": {"nx": 64, "ny": 64}, "time.end": 1.0}).start()
    run.advance()
    axes = drover.plot.map(run)
    assert axes.collections and axes.get_xlim() == pytest.approx(axes.images[0].get_extent()[:2])
    assert axes.get_ylim() == pytest.approx(axes.images[0].get_extent()[2:])


def test_a_map_shows_every_point_of_a_smooth_field_and_averages_of_a_noisy_one():
    x = (np.arange(256) + 0.5) / 4.0
    wave = np.sin(2 * np.pi * x / 64.0)
    smooth = xarray.DataArray(wave[:, None] * wave[None, :], {"y": x, "x": x}, ("y", "x"))
    assert panels.shown_means(smooth)[0].shape == (256, 256)
    pattern = smooth.copy(data=np.sin(2 * np.pi * x / 2.0)[:, None] + 0.0 * x)  # 8 points for each wave
    assert panels.shown_means(pattern)[0].shape == (256, 256)
    noise = smooth.copy(data=np.random.default_rng(1).normal(size=(256, 256)))
    assert panels.shown_means(noise)[0].shape == (64, 64)


@pytest.mark.parametrize("kinds", [(fields, fields), (fields, particles)])
def test_two_runs_of_any_kind_are_drawn_side_by_side(kinds):
    runs = [make().start() for make in kinds]
    for run in runs:
        run.advance()
    picture = drover.plot.compare(*runs, labels=("one", "other"))
    titles = [axes.get_title(loc="left") for axes in picture.axes]
    assert {"(a) one", "(b) other", "(c) polar order"} <= set(titles)
    orders = next(axes for axes in picture.axes if axes.get_title(loc="left") == "(c) polar order")
    scaled = kinds[0] != kinds[1]  # 2 s of fields and 0.02 s of particles
    assert orders.get_xlabel() == ("time over duration $t/T$" if scaled else "time $t$ [s]")
    for run, line in zip(runs, orders.lines):
        assert line.get_xdata()[-1] == pytest.approx(1.0 if scaled else run.time)
        assert np.array_equal(line.get_ydata(), run.observables.polar_order.values)
    picture.set_dpi(60)
    assert overlaps(picture) == [] and covered(picture) == []


def test_runs_without_an_order_are_compared_by_their_variance():
    model = drover.Model([drover.Field("phi", "-k phi", name="height", noise=0.5)], k=1.0)
    scene = model.scene(points=8, side=8.0, dt=0.1, end=2.0)
    runs = [scene.set("coefficients.k", value).start() for value in (1.0, 2.0)]
    for run in runs:
        run.advance()
    axes = next(axes for axes in drover.plot.compare(*runs).axes
                if axes.get_title(loc="left") == "(c) variance of height")
    for run, line in zip(runs, axes.lines):
        assert np.array_equal(line.get_ydata(), run.observables.variance_height.values)


def test_a_legend_on_a_curve_is_found_and_one_beside_it_is_not():
    for corner, expected in (("upper left", [("", "rising")]), ("lower right", [])):
        figure = pyplot.figure()
        axes = figure.add_subplot()
        axes.plot([0.0, 0.05, 1.0], [0.0, 1.0, 1.0], label="rising")
        axes.legend(loc=corner)
        assert covered(figure) == expected


def test_an_exact_solution_is_drawn_beside_the_profiles_of_a_run(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    beads = drover.Scene.load(MODELS / "barenblatt.toml").set({"grid.nx": 64, "grid.ny": 64})
    with beads.run("spread.h5") as run:
        def exact(x, t):
            return np.maximum(0.0, 1.0 - (x - 16.0)**2 / (16.0 * np.sqrt(1.0 + t))) / np.sqrt(1.0 + t)
        axes = drover.plot.profiles(run, exact=exact)
        for solved, predicted in zip(axes.lines[0::2], axes.lines[1::2]):
            # 64 points: an error of 1.2e-2 of the mass, most of it at the front; the peak of the start is 1.
            assert np.abs(solved.get_ydata() - predicted.get_ydata()).max() < 0.05
        assert [line.get_label() for line in axes.lines][-1] == "exact"
        assert drover.plot.length(run).lines[0].get_ydata()[-1] > 12.0  # the spot grows to a radius of 8 mm
        density, velocity = drover.plot.growth(run).lines  # which is in balance, and slows down
        assert density.get_ydata()[0] == pytest.approx(
            float(np.sqrt(run.observables.variance_bead_density[0]) / run.observables.mean_bead_density[0]))
        assert velocity.get_ydata()[-1] < 0.5 * velocity.get_ydata()[0]


def sweep_of(keys, value, branches=()):
    """A sweep over these keys; of the first key's value 1 no error is known."""
    axes = {**{key: sorted(values) for key, values in keys.items()}, **({"branch": list(branches)} if branches else {})}
    places = np.meshgrid(*axes.values(), indexing="ij")
    means = np.vectorize(value, otypes=[float])(*places)
    errors = np.where(places[0].astype(float) == 1.0, np.nan, 0.1)
    data = xarray.Dataset({name: (tuple(axes), values, {"units": "mm-2"})
                           for name, values in (("polar_order", means), ("polar_order_error", errors))}, axes)
    return Sweep({"keys": list(keys), "rows": [], "warnings": [], "failed": 0, "failures": [], "text": ""}, data=data)


def test_a_sweep_of_one_key_is_drawn_at_its_values_with_open_symbols_without_error():
    axes = sweep_of({"relaxation.rate": [3.0, 1.0, 2.0]}, lambda rate: rate**2).plot("polar_order")
    points = {tuple(point): line.get_markerfacecolor() for line in axes.lines
              if line.get_marker() == "o" for point in line.get_xydata()}
    assert set(points) == {(1.0, 1.0), (2.0, 4.0), (3.0, 9.0)}
    assert points[1.0, 1.0] == "white" and points[2.0, 4.0] != "white"
    assert axes.get_xlabel() == "relaxation.rate [1/s]" and axes.get_ylabel() == "polar order [mm$^{-2}$]"
    assert clear(axes)


def test_a_sweep_of_two_keys_is_drawn_as_a_map_of_its_values():
    axes = sweep_of({"relaxation.rate": [1.0, 2.0], "current.speed": [1.0, 2.0, 3.0]},
                    lambda rate, speed: 10.0 * rate + speed).plot("polar_order")
    assert axes.collections[0].get_array().reshape(2, 3).tolist() == [[11.0, 12.0, 13.0], [21.0, 22.0, 23.0]]
    assert (axes.get_xlabel(), axes.get_ylabel()) == ("current.speed [mm/s]", "relaxation.rate [1/s]")
    assert list(axes.get_xticks()) == [1.0, 2.0, 3.0] and list(axes.get_yticks()) == [1.0, 2.0]  # the values
    assert clear(axes)


def test_an_observable_with_an_axis_of_its_own_is_drawn_as_a_line_for_each_value_of_the_key():
    sweep = sweep_of({"relaxation.rate": [1.0, 2.0, 3.0]}, lambda rate: rate)
    q = np.array([0.1, 1.0, 10.0])
    spectra, errors = (sweep.data[name] / xarray.DataArray(q, {"wavenumber": q}, "wavenumber")
                       for name in ("polar_order", "polar_order_error"))
    sweep.data = sweep.data.assign(structure_factor=spectra, structure_factor_error=errors)
    axes = sweep.plot("structure_factor")
    lines = [line.get_ydata().tolist() for line in axes.lines if line.get_linestyle() == "-"]
    assert lines == [(rate / q).tolist() for rate in (1.0, 2.0, 3.0)]
    open_points = [line for line in axes.lines if line.get_markerfacecolor() == "white" and len(line.get_ydata())]
    assert [line.get_ydata().tolist() for line in open_points] == [(1.0 / q).tolist()]
    bars = [part for part in axes.collections if len(part.get_segments()) == 3]
    assert np.ptp(bars[1].get_segments()[0][:, 1]) == pytest.approx(2.0 * 0.1 / q[0])
    assert len({line.get_color() for line in axes.lines}) == 3 and axes.get_xlabel() == "wavenumber"
    assert axes.get_xscale() == axes.get_yscale() == "log" and clear(axes)
    places = xarray.DataArray(np.outer([1.0, 2.0, 3.0], q), dims=("relaxation.rate", "wavenumber"),
                              attrs={"units": "mm-1"})  # points of cells of different size
    sweep.data = sweep.data.assign(wavenumber_values=places)
    axes = sweep.plot("structure_factor")
    assert [line.get_xdata().max() for line in axes.lines if line.get_linestyle() == "-"] == [
        rate * max(q) for rate in (1.0, 2.0, 3.0)]
    assert "mm" in axes.get_xlabel()
    two = sweep_of({"relaxation.rate": [1.0, 2.0], "current.speed": [1.0, 2.0]}, lambda rate, speed: rate)
    two.data = two.data.assign(spectrum=two.data.polar_order * xarray.DataArray(q, {"wavenumber": q}, "wavenumber"))
    with pytest.raises(drover.Error, match="the axes wavenumber beside"):
        two.data = two.data.assign(spectrum_error=two.data.spectrum)
        two.plot("spectrum")


@pytest.mark.parametrize("refine", [None, {"polar_order": 0.01}])
@pytest.mark.parametrize("vary, panels", [({"relaxation.rate": [0.5, 1.0, 2.0]}, 2),
                                          ({"relaxation.rate": [0.5, 1.0], "noise.order": [0.1, 0.2]}, 1)])
def test_the_dataset_of_a_sweep_has_a_figure(vary, panels, refine, tmp_path):
    scene = drover.Scene.from_dict({"relaxation.saturation": 1.0, "elasticity.stiffness": 1.0, "noise.order": 0.1,
                                    "grid.nx": 8, "grid.ny": 8, "time.dt": 0.5, "time.end": 20.0,
                                    "output.sample_every": 0.5, "output.frame_every": 10.0})
    drover.sweep(scene, vary, refine=refine, refine_levels=1, folder=tmp_path / "s.sweep")
    figure = drover.plot.figure(tmp_path / "s.sweep" / "table.nc")
    titles = [axes.get_title(loc="left") for axes in figure.axes]
    assert [title for title in titles if title][0] == "(a) polar order"
    assert sum(bool(title) for title in titles) == panels and overlaps(figure) == []


def test_both_branches_of_a_ramp_are_named_and_hide_no_point():
    axes = sweep_of({"relaxation.rate": [1.0, 2.0, 3.0]}, lambda rate, branch: rate + (branch == "down"),
                    ("up", "down")).plot("polar_order")
    assert [text.get_text() for text in axes.get_legend().get_texts()] == ["up", "down"] and clear(axes)
    plane = sweep_of({"relaxation.rate": [1.0, 2.0], "current.speed": [1.0, 2.0]},
                     lambda rate, speed, branch: rate + (branch == "down"), ("up", "down")).plot("polar_order")
    assert plane.get_title(loc="right") == "branch up"


def test_the_front_of_a_study_has_labels_and_a_legend_beside_it():
    by_model = [{"model": model, "cost": cost, "error_of_allowed": error / cost}
                for model, error in (("full", 2.0), ("one-dimensional", 6.0)) for cost in (0.5, 1.0, 4.0)]
    axes = draw_trade({"by_model": by_model, "front": by_model[:3]})
    assert (axes.get_xlabel(), axes.get_ylabel()) == ("work [s of a core]", "error over error allowed")
    labels = [text.get_text() for text in axes.get_legend().get_texts()]
    assert labels == ["full", "one-dimensional", "cheapest that is allowed"]
    axes.figure.canvas.draw()
    assert axes.get_legend().get_window_extent().x0 > axes.get_window_extent().x1  # beside the data
    assert axes.get_legend().get_window_extent().x1 <= axes.figure.bbox.x1 and clear(axes)


def clear(axes):
    """Whether nothing overlaps and nothing lies below the legend."""
    return overlaps(axes.figure) == [] and covered(axes.figure) == []


def test_a_plot_of_what_a_sweep_has_not_measured_lists_what_it_has():
    with pytest.raises(drover.Error, match="polar_order"):
        sweep_of({"relaxation.rate": [1.0, 2.0]}, lambda rate: rate).plot("nothing")


# --- films

def probed(path):
    """Width, height and number of pictures of a film."""
    words = ["ffprobe", "-v", "error", "-count_frames", "-show_entries",
             "stream=width,height,nb_read_frames,codec_name", "-of", "json", path]
    stream, = json.loads(subprocess.run(words, capture_output=True, check=True).stdout)["streams"]
    assert stream["codec_name"] == {".mp4": "h264", ".gif": "gif"}[path.suffix]
    return stream["width"], stream["height"], int(stream["nb_read_frames"])


def pictures_of(path, width, height):
    """All pictures of a film, as arrays."""
    words = ["ffmpeg", "-v", "error", "-i", path, "-f", "rawvideo", "-pix_fmt", "rgb24", "-"]
    raw = subprocess.run(words, capture_output=True, check=True).stdout
    return np.frombuffer(raw, np.uint8).reshape(-1, height, width, 3).astype(int)


@needs_ffmpeg
@pytest.mark.parametrize("scene, every", [(fields(), 0.5), (fields(**{"grid.ny": 1}), 0.5), (particles(), 0.005),
                                          (particles("bead-gas"), 0.005)])
def test_a_film_shows_the_frames_of_a_run(scene, every, tmp_path):
    run = scene.start()
    path = drover.film(run, tmp_path / "run.mp4", every=every)
    width, height, count = probed(path)
    assert count == 5 and run.step == run.steps and width % 2 == height % 2 == 0
    shown = pictures_of(path, width, height)
    assert shown.std() > 10.0  # not blank
    assert all(abs(one - other).max() > 50 for one, other in zip(shown, shown[1:]))  # the picture or its time
    assert list(tmp_path.iterdir()) == [path]


@needs_ffmpeg
def test_the_program_makes_a_film_of_an_archive(tmp_path, monkeypatch):
    scene = write_scene(tmp_path, {"time.end": 2.0, "output.frame_every": 0.5})
    program(tmp_path, "run", scene, "--quiet")
    words = [sys.executable, "-m", "drover.film", "flock.h5"]
    made = subprocess.run(words, cwd=tmp_path, capture_output=True, text=True, check=True)
    assert made.stdout.strip() == "flock.mp4" and probed(tmp_path / "flock.mp4")[2] == 5
    made = program(tmp_path, "film", "flock.h5", "--every", "2", "--output", "half.mp4")
    assert made.stdout.strip() == "half.mp4" and probed(tmp_path / "half.mp4")[2] == 3
    monkeypatch.setenv("PATH", str(tmp_path))
    assert "apt-get install ffmpeg" in program(tmp_path, "film", "flock.h5", status=2).stderr
    with pytest.raises(drover.Error, match="expected .mp4"):
        drover.film(tmp_path / "flock.h5", tmp_path / "film.avi")
    program(tmp_path, "film", "flock.h5", "--every", "4", "--output", "still.png")  # without ffmpeg


@pytest.mark.parametrize("body", ["exit 0", "cat > /dev/null"])
def test_an_encoder_that_makes_no_film_is_an_error(body, tmp_path, monkeypatch):
    (tmp_path / "ffmpeg").write_text(f"#!/bin/sh\n{body}\n")
    (tmp_path / "ffmpeg").chmod(0o755)
    monkeypatch.setenv("PATH", f"{tmp_path}:/usr/bin:/bin")
    with pytest.raises(drover.Error, match="ffmpeg"):
        drover.film(fields().start(), tmp_path / "run.gif", every=0.5)
    assert not (tmp_path / "run.gif").exists()


@needs_ffmpeg
def test_a_gif_has_the_frames_of_a_film(tmp_path):
    path = drover.film(fields().start(), tmp_path / "run.gif", every=0.5)
    width, height, count = probed(path)
    shown = pictures_of(path, width, height)
    assert count == len(shown) == 5 and shown.std() > 10.0 and list(tmp_path.iterdir()) == [path]


def test_a_film_of_one_field_is_another_than_that_of_a_density_with_arrows(tmp_path):
    for field in (None, "p", "rod_density"):
        drover.film(fields().start(), tmp_path / f"{field}.png", every=2.0, field=field)
    shown = [image.imread(tmp_path / f"{field}-0001.png") for field in (None, "p", "rod_density")]
    for one, other in ((0, 1), (0, 2), (1, 2)):
        assert abs(shown[one] - shown[other]).max() > 0.2
    with pytest.raises(drover.Error, match="expected one of rod_density, polar_order"):
        drover.film(fields().start(), tmp_path / "no.png", field="q")


def test_pictures_of_the_frames_are_those_of_a_film(tmp_path, monkeypatch):
    run = fields().start()
    monkeypatch.setenv("PATH", "")  # without ffmpeg
    assert drover.film(run, tmp_path / "run.png", every=0.5) == tmp_path / "run-*.png"
    made = sorted(tmp_path.iterdir())
    assert [path.name for path in made] == [f"run-000{number}.png" for number in range(5)]
    shown = [image.imread(path) for path in made]
    assert all(one.shape == shown[0].shape and one.std() > 0.04 for one in shown)
    assert all(abs(one - other).max() > 0.2 for one, other in zip(shown, shown[1:]))  # the picture or its time


@needs_ffmpeg
def test_links_at_temporary_names_are_replaced_and_not_followed(tmp_path):
    diary, run = tmp_path / "diary.txt", fields().start()
    diary.write_text("dear diary")
    for name in ("run.mp4", "run.png"):
        (tmp_path / f".{name}.part").symlink_to(diary)
    drover.film(run, tmp_path / "run.mp4", every=0.5)
    figure.write(drover.plot.figure(run), tmp_path / "run.png")
    assert diary.read_text() == "dear diary" and probed(tmp_path / "run.mp4")[2] == 5
    assert sorted(path.name for path in tmp_path.iterdir()) == ["diary.txt", "run.mp4", "run.png"]


def test_a_figure_that_cannot_be_written_leaves_the_old_one(tmp_path, monkeypatch):
    path = tmp_path / "run.png"
    path.write_bytes(b"old")

    def full(_):
        raise OSError(errno.ENOSPC, "No space left on device")

    monkeypatch.setattr(os, "fsync", full)
    with pytest.raises(drover.Error, match="No space left on device"):
        figure.write(drover.plot.figure(fields().start()), path)
    assert path.read_bytes() == b"old" and list(tmp_path.iterdir()) == [path]


def test_without_ffmpeg_an_error_says_how_to_install_it(tmp_path, monkeypatch):
    monkeypatch.setenv("PATH", str(tmp_path))
    run = fields().start()
    with pytest.raises(drover.Error, match="apt-get install ffmpeg"):
        drover.film(run, tmp_path / "run.mp4")
    assert run.step == 0
