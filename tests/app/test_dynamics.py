"""tests/app/test_dynamics.py: the measured S(q, omega) against exact solutions and the linear theory."""
import numpy
import pytest
import scipy.linalg
from pictures import overlaps
from support import MODELS, SMALL

import drover
from drover import figure
from drover.dynamics import segment_powers
from drover.figures import dynamics_figure

RELAXATION = {**SMALL, "relaxation.rate": 0.5, "current.speed": 0.0, "pressure.rods": 0.0, "elasticity.stiffness": 0.0,
              "elasticity.splay": 0.0, "noise.rods": 0.0, "time.dt": 0.2, "time.end": 6000.0,
              "output.frame_every": 0.4, "output.sample_every": 100.0}


def mean_power(omega, interval, length, correlation):
    """The mean of |T sum_k h_k a_k exp(i omega T k)|^2/(T sum_k h_k^2) with the window h of Hann, by its double sum.

    `correlation`: C(n T) of the amplitudes, n = 0 .. length - 1."""
    window = 0.5 * (1.0 - numpy.cos(2.0 * numpy.pi * numpy.arange(length) / length))
    matrix = scipy.linalg.toeplitz(correlation)  # <a_k a_l*>: C(k - l)
    waves = window * numpy.exp(1j * omega[:, None] * interval * numpy.arange(length))
    return interval * ((waves @ matrix) * waves.conj()).sum(axis=1).real / (window**2).sum()


def test_a_mode_that_relaxes_has_the_spectrum_of_its_exact_solution(tmp_path):
    # d_t p = -a p + f: the amplitudes at intervals T are an autoregression, C(n T) = S exp(-a n T), of which S(omega) =
    # T S (1 - rho^2)/(1 - 2 rho cos(omega T) + rho^2), rho = exp(-a T), S = noise/(2 a) for <f f> = noise.
    with drover.Scene.from_dict(RELAXATION).run(tmp_path / "relaxation.h5") as run:
        found = drover.dynamic_structure_factor(run, "polar_order_x", modes=4, begin=50.0, segments=100)
    values, errors = (found[f"dynamic_structure_factor_polar_order_x{end}"].values for end in ("", "_error"))
    rho = numpy.exp(-0.5 * 0.4)
    omega = found.frequency.values
    expected = 0.4 * 0.05 / (2 * 0.5) * (1 - rho**2) / (1 - 2 * rho * numpy.cos(omega * 0.4) + rho**2)
    deviation = (values - expected) / errors
    assert abs(values.mean(axis=0) / expected - 1).mean() < 0.1
    assert 0.8 < numpy.sqrt((deviation**2).mean()) < 1.3 and abs(deviation.mean()) < 0.2
    linear = found.dynamic_structure_factor_polar_order_x_linear.values  # of frames 0.4 s apart in windows of 117 s
    # A window of 117 s has a width of .05 /s, a tenth of the peak: its square times a curvature of order 1.
    assert linear == pytest.approx(numpy.broadcast_to(expected, linear.shape), rel=1e-2)
    windowed = mean_power(omega, 0.4, len(omega), 0.05 / (2 * 0.5) * rho**numpy.arange(len(omega)))
    assert linear == pytest.approx(numpy.broadcast_to(windowed, linear.shape), rel=1e-9)
    # The sum rule: the integral over omega/(2 pi) is S(q), up to the error of a mean over 6000 s.
    total = values.sum(axis=1) * (omega[1] - omega[0]) / (2 * numpy.pi)
    assert total == pytest.approx(0.05, rel=0.15)


@pytest.mark.slow
def test_errors_of_few_segments_are_at_least_those_of_gaussian_noise(tmp_path):
    with drover.Scene.from_dict(RELAXATION).run(tmp_path / "relaxation.h5") as run:
        found = drover.dynamic_structure_factor(run, "polar_order_x", modes=4)
    values, errors = (found[f"dynamic_structure_factor_polar_order_x{end}"].values for end in ("", "_error"))
    assert (errors >= values / numpy.sqrt(8)).all()


def test_waves_of_a_flock_have_the_spectrum_of_the_linear_theory(tmp_path):
    # Rods of a flock along x are carried at the speed u: S(q, omega) has one peak, at omega = u q, of width D q^2.
    # Noise so weak that the theory is exact; frames five times as often as the fastest wave that is seen.
    flock = {**SMALL, "relaxation.rate": -1.0, "relaxation.saturation": 1.0, "noise.order": 1e-4, "noise.rods": 1e-4,
             "current.kind": "density-order", "current.speed": 0.5, "pressure.rods": 0.0, "diffusion.rods": 2.0,
             "initial.kind": "formula", "initial.polar_order_x": "1", "time.dt": 0.05, "time.end": 4000.0,
             "output.frame_every": 0.5, "output.sample_every": 100.0}
    scene = drover.Scene.from_dict(flock)
    theory = scene.stability().groups["ordered"]
    with scene.run(tmp_path / "flock.h5") as run:
        found = drover.dynamic_structure_factor(run, "rod_density", begin=100.0, segments=60)
    values, errors = (found[f"dynamic_structure_factor_rod_density{end}"].values[0] for end in ("", "_error"))
    omega, predicted = found.frequency.values, theory.dynamic_structure_factor_rods.isel(angle=0).values
    assert float(theory.sound_wavenumber) == pytest.approx(float(found.wavenumber[0]), rel=1e-12)
    inside = abs(omega) < theory.frequency_axis.values.max()
    expected = numpy.interp(omega[inside], theory.frequency_axis.values, predicted)
    deviation = (values[inside] - expected) / errors[inside]
    # The width of the windows, 0.05 /s, is a sixth of that of the peak; errors of 60 segments are known to a tenth.
    assert len(deviation) >= 12 and 0.6 < numpy.sqrt((deviation**2).mean()) < 1.5
    assert expected.max() > 3.0 * expected.min() and omega[values.argmax()] > 0.0
    # The theory beside the measurement is that of drover stability about the state of the flock, whose direction has
    # wandered from the x axis by some 0.2, and the peak with it by half of its square.
    linear = found.dynamic_structure_factor_rod_density_linear
    assert "ordered" in linear.comment
    assert linear.values[0][inside] == pytest.approx(expected, rel=6e-2)


def test_the_theory_of_a_flock_turns_with_its_order(tmp_path):
    # A flock along y has along y what one along x has along x; and 90 degrees off, each component has the other one.
    flock = {**SMALL, "relaxation.rate": -1.0, "relaxation.saturation": 1.0, "noise.order": 1e-4, "noise.rods": 1e-4,
             "current.kind": "density-order", "pressure.rods": 0.3, "diffusion.rods": 2.0, "initial.kind": "formula",
             "time.end": 20.0, "output.frame_every": 0.5}
    found = {}
    for axis in "xy":
        scene = drover.Scene.from_dict({**flock, f"initial.polar_order_{axis}": "1"})
        with scene.run(tmp_path / f"{axis}.h5") as run:
            for along in "xy":
                for part in ("rod_density", "polar_order_x", "polar_order_y"):
                    data = drover.dynamic_structure_factor(run, part, along=along, segments=2, begin=0.0)
                    found[axis, along, part] = data[f"dynamic_structure_factor_{part}_linear"].values
    other = {"x": "y", "y": "x", "rod_density": "rod_density", "polar_order_x": "polar_order_y",
             "polar_order_y": "polar_order_x"}
    for (axis, along, part), values in found.items():
        assert numpy.isfinite(values).all() and (values > 0.0).any()
        # The direction of the order diffuses: by some 1e-3 within the run.
        assert values == pytest.approx(found[other[axis], other[along], other[part]], rel=2e-2), (axis, along, part)
    assert found["x", "x", "polar_order_x"] != pytest.approx(found["x", "x", "polar_order_y"], rel=0.1)


def test_the_theory_of_a_model_of_ones_own_is_that_of_its_symbol(tmp_path):
    model = drover.Model([drover.Field("a", "-2 a + b + lap a", noise=0.1),
                          drover.Field("b", "-a - b", noise=0.3)])
    scene = model.scene(points=(16, 1), side=(8.0, 1.0), dt=0.05, end=20.0).set("output.frame_every", 0.1)
    with scene.run(tmp_path / "pair.h5") as run:
        found = drover.dynamic_structure_factor(run, "a", modes=3, segments=2, begin=0.0)
    for q, values in zip(found.wavenumber.values, found.dynamic_structure_factor_a_linear.values):
        symbol = model.symbol((q, 0.0)).real
        equal = scipy.linalg.solve_continuous_lyapunov(symbol, -numpy.diag([0.1, 0.3]))
        lagged = [(scipy.linalg.expm(0.1 * n * symbol) @ equal)[0, 0] for n in range(len(values))]
        assert values == pytest.approx(mean_power(found.frequency.values, 0.1, len(values), lagged), rel=1e-9)


def test_the_theory_of_slow_waves_is_that_of_their_windows(tmp_path):
    # Waves that diffuse for longer than a segment: they have all their power within the width of the window, where
    # S(q, omega) of the equations is up to 25 times as large.
    model = drover.Model([drover.Field("c", "D lap c", noise=0.2, conserved_noise=True)], D=0.01)
    scene = model.scene(points=16, side=16.0, dt=0.5, end=40.0).set("output.frame_every", 0.5)
    with scene.run(tmp_path / "slow.h5") as run:
        found = drover.dynamic_structure_factor(run, "c", segments=3, begin=0.0)
    rate, count = 0.01 * found.wavenumber.values[0]**2, found.sizes["frequency"]
    windowed = mean_power(found.frequency.values, 0.5, count, 10.0 * numpy.exp(-rate * 0.5 * numpy.arange(count)))
    linear = found.dynamic_structure_factor_c_linear.values[0]
    assert linear == pytest.approx(windowed, rel=1e-9)
    assert 10.0 * 2.0 / rate > 25.0 * linear.max()


def test_the_theory_of_walkers_is_about_the_mean_of_their_start(tmp_path):
    # Independent walkers: S(q) is their density c, and the amplitudes of frames are an autoregression.
    model = drover.Model([drover.Field("c", "D lap c + div(sqrt(2 D max(c, 0)) j)", conserved=True, reference=20.0)],
                         noises=[drover.Noise("j", spin=1)], D=1.0)
    scene = model.scene(points=16, side=16.0, dt=0.5, end=100.0, initial={"c": "40"}).set("output.frame_every", 0.5)
    with scene.run(tmp_path / "walkers.h5") as run:
        found = drover.dynamic_structure_factor(run, "c")
    rate = found.wavenumber.values[:, None]**2
    count = found.sizes["frequency"]
    correlation = 40.0 * numpy.exp(-0.5 * rate[0] * numpy.arange(count))
    expected = mean_power(found.frequency.values, 0.5, count, correlation)
    assert found.dynamic_structure_factor_c_linear.values[0] == pytest.approx(expected, rel=1e-9)


def test_a_scene_without_noise_has_no_theory_of_fluctuations(tmp_path):
    quiet = drover.Scene.from_dict({**SMALL, "noise.order": 0.0, "noise.rods": 0.0, "initial.kind": "uniform",
                                    "output.frame_every": 1.0})
    with quiet.run(tmp_path / "quiet.h5") as run:
        found = drover.dynamic_structure_factor(run, "rod_density", segments=2)
    linear = found.dynamic_structure_factor_rod_density_linear
    assert numpy.isnan(linear.values).all() and "no noise" in linear.comment


def test_the_map_is_drawn_measured_and_predicted_with_one_scale(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    scene = drover.Scene.from_dict({**SMALL, "output.frame_every": 0.5, "time.end": 100.0})
    with scene.run("waves.h5") as run:
        axes = drover.plot.dynamics(run, "rod_density"), drover.plot.dynamics(run, "rod_density", linear=True)
        norms = [one.collections[0].norm for one in axes]
        assert [norm.vmin for norm in norms] == [norms[0].vmin] * 2 and norms[0].vmax == norms[1].vmax
        assert axes[0].get_xlabel() == "wavenumber $q$ [mm$^{-1}$]" and axes[0].get_ylim() == axes[1].get_ylim()
        drawn = dynamics_figure.draw(run, "rod_density")
    assert overlaps(drawn) == [] and len(drawn.axes) == 6
    assert figure.main(["waves.h5", "--dynamics", "rod_density", "--output", "waves.png"]) == 0
    assert figure.main(["waves.h5", "--dynamics", "nothing"]) == 2
    drover.Scene.load(MODELS / "isotropic.toml").set({"grid.nx": 16, "grid.ny": 16}).stability("theory.h5")
    assert figure.main(["theory.h5", "--dynamics", "rod_density"]) == 2


def test_waves_that_the_run_does_not_keep_have_no_theory_and_are_not_drawn(tmp_path):
    scene = drover.Scene.from_dict({**SMALL, "relaxation.saturation": 0.1, "output.frame_every": 0.5, "time.end": 80.0})
    kept = scene.explain()["largest_mode_kept"]["x"]
    assert kept == 3  # of 16 points, with a product of three fields
    with scene.run(tmp_path / "waves.h5") as run:
        assert dynamics_figure.found_of(run, "rod_density").sizes["wavenumber"] == kept
        found = drover.dynamic_structure_factor(run, "rod_density", modes=7, segments=2)
    linear = found.dynamic_structure_factor_rod_density_linear.values
    assert numpy.isfinite(linear[:kept]).all() and numpy.isnan(linear[kept:]).all()


@pytest.mark.parametrize("changes, sentence", [
    ({"field": "nothing"}, "expected one of the fields of the run: rod_density, polar_order_x, polar_order_y"),
    ({"along": "z"}, 'expected "x" or "y"'), ({"modes": 8}, "expected 1 to 7"), ({"segments": 20}, "frames in 20")])
def test_what_cannot_be_computed_is_a_sentence(changes, sentence, tmp_path):
    with drover.Scene.from_dict({**SMALL, "output.frame_every": 1.0}).run(tmp_path / "small.h5") as run, \
            pytest.raises(drover.Error, match=sentence):
        drover.dynamic_structure_factor(run, **{"field": "rod_density", "segments": 2, "begin": 0.0, **changes})


def test_a_run_of_particles_is_none_of_fields(tmp_path):
    scene = drover.Scene.load(MODELS / "bead-gas.toml").set({"time.end": 0.01, "output.frame_every": 0.0})
    with scene.run(tmp_path / "gas.h5") as run, pytest.raises(drover.Error, match="expected one of fields"):
        drover.dynamic_structure_factor(run, "rod_density")


def test_a_run_in_memory_has_one_frame_and_is_told_to_be_an_archive():
    with pytest.raises(drover.Error, match="expected an archive with at least three"):
        drover.plot.dynamics(drover.Scene.from_dict({**SMALL, "output.frame_every": 1.0}).start(), "rod_density")


def test_a_wave_that_stands_still_has_its_power_at_frequency_0():
    """No mean is subtracted: a slow wave of noise has a mean over any number of frames."""
    window = numpy.hanning(33)[:-1]
    powers = segment_powers(numpy.full((96, 1), 0.3 - 0.4j), window, 0.5)
    assert powers.shape == (5, 1, 32)
    numpy.testing.assert_allclose(powers[:, 0, 16], 0.125 * window.sum()**2 / (window**2).sum(),
                                  rtol=1e-13)


def test_rods_that_neither_decay_nor_are_driven_leave_the_spectrum_of_the_order(tmp_path):
    # The scene of the docstring: of the order alone S = noise/(2 a) exp(-a t), a = 1 /s.
    scene = drover.Scene.from_dict({"grid": {"nx": 16, "ny": 16}, "time": {"dt": 0.1, "end": 60.0}, "relaxation.rate":
                                    1.0, "noise.order": 0.1, "output.frame_every": 0.2})
    with scene.run(tmp_path / "waves.h5") as run:
        found = drover.dynamic_structure_factor(run, "polar_order_x", modes=2)
    linear = found.dynamic_structure_factor_polar_order_x_linear
    omega = found.frequency.values
    expected = mean_power(omega, 0.2, len(omega), 0.05 * numpy.exp(-0.2 * numpy.arange(len(omega))))
    assert linear.values == pytest.approx(numpy.broadcast_to(expected, linear.shape), rel=1e-9)
    assert linear.comment.endswith(f"of frames 0.2 s apart in windows of {0.2 * len(omega):g} s")
