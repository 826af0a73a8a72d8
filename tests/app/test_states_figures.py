"""tests/app/test_states_figures.py: figures of drover states: fields of the states, and the curve that they are on."""
import numpy
import pytest
from matplotlib.colors import to_hex
from pictures import overlaps
from support import MODELS

import drover
from drover import figure
from drover.figures import states_figure
from drover.figures.panels import BLUE

BAND = drover.Scene.load(MODELS / "band.toml").set({
    "grid.nx": 192, "grid.lx": 96.0, "uniform.rod_density": 1.05,
    "initial.rod_density": "1.05 + 0.25 * (tanh((x - 30) / 6) - tanh((x - 70) / 4) - 1)",
    "initial.polar_order_x": "0.29 * (tanh((x - 30) / 6) - tanh((x - 70) / 4))"})


@pytest.fixture(scope="module", name="curve")
def curve_of(tmp_path_factory):
    """Bands past their fold, where they become unstable, of a scene whose path is longer than a page is wide."""
    folder = tmp_path_factory.mktemp("states")
    scene = folder / ("a-folder-with-a-long-name/" * 6) / ("band-" * 20 + "that-turns.toml")
    scene.parent.mkdir(parents=True)
    scene.write_text(BAND.to_toml())
    path = folder / "curve.h5"
    return drover.Scene.load(scene).states(follow="uniform.rod_density = 0.8", points=70, output=path), path


def profile_lines(axes):
    return [line.get_ydata() for line in axes.lines]


def test_the_figure_of_a_curve_draws_states_and_marks_unstable_ones_and_folds(curve):
    theory, path = curve
    drawn = theory.plot()
    frames, line = theory.groups["frames"], theory.groups["curve"]
    fields, numbers = [axes for axes in drawn.axes if axes.get_xlim()[1] > 90], drawn.axes[-2:]
    shown = states_figure.chosen_states(frames.sizes["state"])
    assert shown[0] == 0 and shown[-1] == frames.sizes["state"] - 1
    for axes, name in zip(fields, ("rod_density", "polar_order_x")):
        assert axes.get_title(loc="left").endswith(name.replace("_", " "))
        for state, values in zip(shown, profile_lines(axes)):
            assert values == pytest.approx(frames[name].values[state, 0], rel=1e-12)
    unstable = line.curve_growth_rate.values > 1e-6
    assert 0 < unstable.sum() < len(unstable) and line.curve_fold.values.sum() == 1
    for axes in numbers:
        _, stable_points, unstable_points, *_, folds, pitchforks = axes.lines
        assert len(stable_points.get_xdata()) == (~unstable).sum()
        assert len(unstable_points.get_xdata()) == unstable.sum()
        assert to_hex(stable_points.get_markerfacecolor()) == BLUE.lower()
        assert len(folds.get_xdata()) == line.curve_fold.values.sum() and len(pitchforks.get_xdata()) == 0
    assert overlaps(drawn) == []
    with drover.open_theory(path) as kept:
        assert kept.speed == theory.speed and numpy.array_equal(kept.groups["frames"].rod_density, frames.rod_density)
        assert overlaps(figure.draw_theory(kept)) == []


def test_a_single_state_of_a_model_of_ones_own_is_drawn_over_the_whole_width(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    pulse = drover.Model([drover.Field("X", "X + lap X - 0.5 lap Y - (X^2 + Y^2) (X + 0.4 Y)", name="real"),
                          drover.Field("Y", "Y + lap Y + 0.5 lap X - (X^2 + Y^2) (Y - 0.4 X)", name="imaginary")])
    pulse.scene(points=(64, 4), side=(20.0, 4.0), dt=0.05, end=10.0, initial={
        "real": "0.9 cos(2 pi x / lx)", "imaginary": "0.9 sin(2 pi x / lx)"}).states(output="wave.h5")
    drawn = figure.draw_file("wave.h5")
    assert [axes.get_title(loc="left") for axes in drawn.axes] == ["(a) real", "(b) imaginary"]
    assert overlaps(drawn) == []
    # The plane wave X + i Y = sqrt(1 - q^2) exp(i q x).
    amplitude = numpy.hypot(*(profile_lines(axes)[0] for axes in drawn.axes))
    assert amplitude == pytest.approx(numpy.sqrt(1.0 - (2.0 * numpy.pi / 20.0) ** 2), rel=1e-9)
    assert figure.main(["wave.h5", "--frame", "0"]) == 0
    assert figure.main(["wave.h5", "--frame", "1"]) == 2 and figure.main(["wave.h5", "--state", "ordered"]) == 2
