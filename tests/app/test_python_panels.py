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
from drover.figures import model_film, model_panels, panels, particle_motion as motion
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


# --- maps, deviations and lengths of unusual runs

def test_deviations_of_a_density_whose_mean_is_0_are_not_relative_to_it():
    model = drover.Model([drover.Field("phi", "lap(phi^3 - phi - lap phi)", conserved=True, noise=0.01,
                                       conserved_noise=True, reference=0.1)])
    for start, label in (("0.1 cos(pi x / 8)", r"$\delta \phi$"), ("1 + 0.1 cos(pi x / 8)", r"$\delta \phi/\phi$")):
        run = model.scene(points=16, side=16.0, dt=0.05, end=0.5, initial={"phi": start}).start()
        run.advance()
        axes = Figure().gca()
        assert model_panels.draw_deviations(axes, run_view.run_of(run), roles_of(run_view.run_of(run)))
        assert axes.lines[0].get_label() == label
        # At a mean of 1 both are one number, up to the rounding of the mean.
        assert axes.lines[0].get_ydata()[-1] == pytest.approx(float(np.std(run.frame.phi)), rel=1e-12)


@pytest.mark.parametrize("points, side", [((64, 4), (64.0, 4.0)), ((32, 1), (32.0, 1.0)), ((32, 32), (32.0, 32.0))])
def test_the_length_of_a_pattern_counts_the_modes_of_each_shell(points, side):
    model = drover.Model([drover.Field("phi", "lap(phi^3 - phi - lap phi)", conserved=True)])
    scene = model.scene(points=points, side=side, dt=0.1, end=2.0, initial={"kind": "random", "amplitude": 0.1})
    run = scene.start()
    run.advance()
    axes = drover.plot.length(run)
    x, y = (2.0 * np.pi * np.fft.fftfreq(count, length / count) for count, length in zip(points, side))
    size = np.hypot(*np.meshgrid(x, y))
    power = abs(np.fft.fft2(run.frame.phi))**2
    power[(size == 0.0) | (size > (len(run.observables.wavenumber) + 0.5) * 2.0 * np.pi / max(side))] = 0.0
    # Shells have the mean |q| of their modes: equal up to half of their width, of the third shell or longer here.
    assert axes.lines[0].get_ydata()[-1] == pytest.approx(2.0 * np.pi * power.sum() / (power * size).sum(), rel=0.03)


def test_a_map_of_one_column_or_row_has_a_width(tmp_path):
    assert panels.edges_of([2.0]).tolist() == [1.0, 3.0] and panels.edges_of([0.0]).tolist() == [-0.5, 0.5]
    assert panels.edges_of([1.0, 2.0, 4.0]).tolist() == [0.5, 1.5, 3.0, 5.0]
    scene = drover.Scene.from_dict({"grid": {"nx": 8, "ny": 8, "lx": 8.0, "ly": 8.0}, "relaxation.rate": 0.5,
                                    "noise.order": 0.1, "time.dt": 0.2, "time.end": 30.0, "output.frame_every": 0.4,
                                    "output.sample_every": 0.2})
    with scene.run(tmp_path / "one.h5") as run:
        axes = drover.plot.dynamics(run, "polar_order_x", modes=1)
        q = 2.0 * np.pi / 8.0
        assert axes.get_xlim() == pytest.approx((0.5 * q, 1.5 * q))
        linear = drover.plot.dynamics(run, "polar_order_x", modes=1, linear=True)
        assert linear.collections and not linear.texts  # rods that neither decay nor are driven have no part in it
    key = drover.sweep(scene.set("time.end", 1.0), {"relaxation.rate": [0.5], "noise.order": [0.1, 0.2]}, workers=1)
    assert key.plot("polar_order").get_ylim() == (0.25, 0.75)


def test_a_colour_bar_ends_at_the_few_pixels_that_differ():
    spot = np.ones(1000)
    assert panels.colour_range(spot) == (0.9, 1.1, "neither")
    spot[7] = 6.0
    assert panels.colour_range(spot) == (0.0, 6.0, "neither")
    spot[7] = 1.2
    assert panels.colour_range(spot) == (1.0, 1.2, "neither")
    assert panels.colour_range(np.arange(1000.0) + 1e4)[2] == "both"


def test_the_key_of_arrows_of_a_narrow_map_is_on_its_page():
    scene = drover.Scene.from_dict({"grid": {"nx": 4, "ny": 60, "lx": 2.0, "ly": 60.0}, "noise.order": 0.1,
                                    "relaxation.rate": 0.5, "time.dt": 0.1, "time.end": 1.0})
    run = scene.start()
    run.advance()
    picture = drover.plot.figure(run)
    picture.canvas.draw()
    (words,) = (text for axes in picture.axes for text in axes.texts if text.get_text().startswith("arrow"))
    assert words.get_window_extent().x0 > 0.0


def test_beads_alone_are_compared_by_the_order_of_their_velocities():
    scene = drover.Scene.load(MODELS / "bead-gas.toml").set({"cell.lx": 12, "cell.ly": 12, "time.end": 0.02,
                                                             "output.sample_every": 0.005})
    run = scene.start()
    run.advance()
    picture = drover.plot.compare(run, run, labels=("one", "other"))
    (axes,) = (axes for axes in picture.axes if axes.get_title(loc="left") == "(c) bead velocity order")
    assert np.array_equal(axes.lines[0].get_ydata(), run.observables.bead_velocity_order.values)


@pytest.mark.parametrize("draw", [drover.plot.map, drover.plot.figure, lambda run, frame: drover.plot.compare(
    run, run, frame=frame)])
def test_a_frame_that_a_run_does_not_have_is_rejected(draw):
    run = drover.Scene.from_dict({"grid": {"nx": 8, "ny": 8}, "time": {"dt": 0.1, "end": 1.0}}).start()
    with pytest.raises(drover.Error, match="has no frame 99; expected 0 to 0"):
        draw(run, frame=99)


def test_the_figure_of_states_is_of_the_frame_that_is_asked_for(tmp_path):
    scene = drover.Scene.load(MODELS / "kink.toml").set("grid.nx", 128)
    states = scene.states(follow="driving.strength = 1.25", points=3)
    assert states.groups["frames"].state.units == "1"
    drawn = [drover.plot.figure(states, frame=frame).axes[0].lines[0].get_ydata() for frame in (0, -1)]
    assert not np.array_equal(*drawn)
    with pytest.raises(drover.Error, match="state = ordered does not apply, since drover states wrote this archive"):
        drover.plot.figure(states, state="ordered")
