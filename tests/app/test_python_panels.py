"""tests/app/test_python_panels.py: numbers behind panels: paths, flow and memory of particles, exact profiles."""
from types import SimpleNamespace

import matplotlib
import numpy as np
import pytest
import xarray
from matplotlib.figure import Figure
from support import MODELS

import drover
from drover import exact, run_view
from drover.figures import model_film, model_panels, particle_motion as motion
from drover.roles import roles_of

matplotlib.use("Agg")

SIDES = np.array([10.0, 8.0])


def run_of(times, **bodies):
    """A run of particles in a periodic cell: {name: (frame, body, 3)}."""
    frames = xarray.Dataset({name: (("time", name.split("_")[0], "component"), values)
                             for name, values in bodies.items()}, {"time": times})
    return SimpleNamespace(frames=frames, summary=None, path="x.h5", scene={"cell": {"shape": "periodic"}},
                           attributes={"sides": SIDES}, store=None)


def turning(rates, times):
    angle = np.outer(times, rates)
    return np.stack([np.cos(angle), np.sin(angle), 0.0 * angle], axis=-1)


def test_the_memory_of_rods_that_turn_steadily_is_the_cosine_of_their_angle():
    times = np.linspace(0.0, 10.0, 201)
    lags, memory = motion.memory_of(run_of(times, rod_axis=turning([0.3, -0.3], times)))
    assert len(lags) == motion.MAX_LAGS and lags[-1] == pytest.approx(3.0)  # a part of .3 of the run
    assert memory == pytest.approx(np.cos(0.3 * lags), abs=1e-12)


def test_the_flow_of_beads_that_move_together_is_their_velocity_also_across_the_edge():
    start = np.random.default_rng(3).uniform(-0.5, 0.5, (600, 3)) * [*SIDES, 0.0]
    velocity = np.array([1.5, -0.7, 0.0])
    times = np.array([0.0, 2.0])
    run = run_of(times, bead_position=start + times[:, None, None] * velocity)
    flow, place, block, time, beads = motion.mean_flow(run, -1, SIDES)
    assert time == 2.0 and len(flow[0]) == 48 and beads == 12.5  # 8 by 6 blocks
    assert flow[0] == pytest.approx(1.5) and flow[1] == pytest.approx(-0.7)
    assert (np.abs(place) <= 0.5 * SIDES[:, None]).all() and block == pytest.approx(10.0 / 8.0)


def test_a_step_across_the_edge_of_a_periodic_cell_is_drawn_at_both_edges():
    times = np.array([0.0, 1.0])
    places = np.array([[[4.5, 0.0, 0.0]], [[5.5, 0.5, 0.0]]])
    run = run_of(times, rod_position=places, rod_axis=turning([0.0], times))
    axes = Figure().add_subplot()
    motion.draw_paths(axes, run, motion.paths(run, -1, SIDES), -1, SIDES, True)
    one, other = (collection.get_segments()[0] for collection in axes.collections)
    assert one.tolist() == [[4.5, 0.0], [5.5, 0.5]] and other.tolist() == [[-5.5, 0.0], [-4.5, 0.5]]


def test_the_view_of_one_rod_in_a_large_cell_is_around_its_path_and_that_of_many_is_the_cell():
    path = np.array([[[1.0, 2.0]], [[5.0, 3.0]]])
    left, right, bottom, top = motion.view_of(path, np.array([200.0, 200.0]))
    assert (left, right) == pytest.approx((3.0 - 6.3, 3.0 + 6.3)) and (bottom, top) == pytest.approx((-3.8, 8.8))
    assert motion.view_of(path, SIDES) is None
    assert motion.view_of(np.repeat(path, 4, axis=1), np.array([200.0, 200.0])) is None


def test_the_warm_up_is_shaded_beside_several_observables_and_the_speed_of_a_rod_whose_mean_begins_after_it():
    times = np.linspace(0.0, 10.0, 101)
    run = run_of(times, rod_position=np.stack([[[t, 0.0, 0.0]] for t in times]), rod_axis=turning([0.0], times))
    run.summary = xarray.Dataset({"warm_up": 2.5, "rod_speed": 1.0, "rod_speed_error": 0.1, "order": 0.5,
                                  "order_error": 0.1})
    run.observables = xarray.Dataset({"order": ("time", np.full(101, 0.5))}, {"time": times})
    for draw in (lambda axes: motion.draw_speed(axes, run, 10.0),
                 lambda axes: motion.draw_several(axes, run, {"order": "order"}, 10.0, "order")):
        axes = Figure().add_subplot()
        draw(axes)
        [shade] = axes.patches
        shaded = shade.get_extents().transformed(axes.transData.inverted())
        assert shaded.intervalx == pytest.approx([0.0, 2.5])
        for line in axes.lines:
            assert line.get_linestyle() != "--" or line.get_xdata()[0] == 2.5


def row_of(times, profile):
    x = (np.arange(256) + 0.5) * 0.25
    return xarray.DataArray([profile(x, t) for t in times], {"time": times, "x": x}, ("time", "x"))


def pulse(x, centre):
    return np.exp(8.0 * (np.cos(2.0 * np.pi * (x - centre) / 64.0) - 1.0))


def test_a_profile_that_moves_unchanged_is_known_with_its_speed_after_several_turns_of_the_cell():
    times = np.arange(0.0, 101.0, 10.0)
    row = row_of(times, lambda x, t: 1.0 + pulse(x, 20.0 + 1.7 * t))  # 170 mm: more than twice around
    profile, words = exact.travelling(row, {})
    assert words == "start, 1.7 mm s$^{-1}$"
    assert abs(profile(row["x"].values, 100.0) - row.values[-1]).max() < 0.02
    at_rest = exact.travelling(row_of(times, lambda x, t: 1.0 + pulse(x, 20.0)), {})
    assert at_rest[1] == "start, at rest"


@pytest.mark.parametrize("profile", [lambda x, t: 1.0 + (1.0 + 0.01 * t) * pulse(x, 20.0), lambda x, t: 1.0 + 0.0 * x])
def test_a_profile_that_grows_or_is_uniform_is_not_a_travelling_one(profile):
    assert exact.travelling(row_of(np.arange(0.0, 101.0, 10.0), profile), {}) is None


OWN = drover.Model([drover.Field("n", "k div(n grad n)", conserved=True, reference=1.0),
                    drover.Field("m", "k div(n grad m)", reference=1.0),
                    drover.Field("c", "k div(c grad c) - c", reference=1.0),
                    drover.Field("d", "k div(d grad d) + lap n", reference=1.0)], k=2.0).scene(16, 64.0, 0.1, 1.0)


def hill(times, name, along_y):
    """A paraboloid, or with along_y = 0 a ridge, as the frames of a run have it."""
    x = row_of(times, lambda x, t: x)["x"].values
    away = (x - 16.0)**2 + along_y * (x[:, None] - x[16])**2
    return xarray.DataArray([np.maximum(0.0, 1.0 - away / 16.0)], {"time": times, "y": x, "x": x}, ("time", "y", "x"),
                            name)


@pytest.mark.parametrize("scene, name, rate", [
    (drover.Scene.load(MODELS / "barenblatt.toml"), "bead_density", 2.0), (OWN, "n", 2.0),
    (drover.Scene.load(MODELS / "barenblatt.toml"), "polar_order_x", None), (OWN, "m", None), (OWN, "c", None),
    (OWN, "d", None)])
@pytest.mark.parametrize("along_y", [1.0, 0.0, 0.3])
def test_the_solution_of_barenblatt_follows_from_the_start_and_the_equations(scene, name, rate, along_y):
    plane = hill([3.0], name, along_y)
    row = plane.isel(y=16)
    found = exact.spreading(SimpleNamespace(attributes={"scene": scene.to_toml()}, frames={name: plane}), row, row)
    assert (found is None) == (rate is None or along_y == 0.3)
    x, dimensions = row["x"].values, 2 if along_y else 1
    for t in (0.0, 15.0) if found else ():
        # In d dimensions radius^2 = 16 (1 + t/age)^(2/(d + 2)), with an age of 16/(2 k (d + 2)).
        age = 16.0 / (2.0 * 2.0 * (dimensions + 2))
        radius = (1.0 + t / age)**(1.0 / (dimensions + 2))
        expected = np.maximum(0.0, 1.0 - (x - 16.0)**2 / (16.0 * radius**2)) / radius**dimensions
        assert found[0](x, 3.0 + t) == pytest.approx(expected, abs=1e-9)


def test_a_curve_that_a_like_one_would_hide_is_wider():
    values = np.geomspace(1e-6, 1.0, 50)
    assert model_panels.excess(values, [1.01 * values]) > 0.0
    assert model_panels.excess(values, [2.0 * values]) == 0.0 == model_panels.excess(values, [])
    assert model_panels.excess(np.full(50, np.nan), [values]) == 0.0


def test_a_film_averages_a_noisy_field_as_its_figure_does_and_not_a_smooth_one():
    noisy = drover.Scene.load(MODELS / "model-b.toml").start()  # 128 points, in maps of 64
    smooth = drover.Scene.load(MODELS / "cahn-hilliard.toml").set({"initial": {
        "kind": "formula", "composition": "0.1 cos(2 pi x / lx)", "amplitude": 0.0}}).start()
    for run, expected in ((noisy, [2, 2]), (smooth, [1, 1])):
        seen = run_view.run_of(run)
        assert model_film.pixels_of(seen, roles_of(seen)[0], run.frame.arrays) == expected
