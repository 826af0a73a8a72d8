"""tests/app/test_dynamics.py: the measured S(q, omega) against exact solutions and the linear theory."""
import numpy
import pytest
from support import MODELS, SMALL

import drover

RELAXATION = {**SMALL, "relaxation.rate": 0.5, "current.speed": 0.0, "pressure.rods": 0.0, "elasticity.stiffness": 0.0,
              "elasticity.splay": 0.0, "noise.rods": 0.0, "time.dt": 0.2, "time.end": 6000.0,
              "output.frame_every": 0.4, "output.sample_every": 100.0}


def test_a_mode_that_relaxes_has_the_spectrum_of_its_exact_solution(tmp_path):
    # d_t p = -a p + f: the amplitudes at intervals T are an autoregression with rho = exp(-a T), of which
    # S(omega) = T S (1 - rho^2)/(1 - 2 rho cos(omega T) + rho^2), S = noise/(2 a) for <f f> = noise.
    with drover.Scene.from_dict(RELAXATION).run(tmp_path / "relaxation.h5") as run:
        found = drover.dynamic_structure_factor(run, "polar_order_x", modes=4, begin=50.0, segments=100)
    values, errors = (found[f"dynamic_structure_factor_polar_order_x{end}"].values for end in ("", "_error"))
    rho = numpy.exp(-0.5 * 0.4)
    omega = found.frequency.values
    expected = 0.4 * 0.05 / (2 * 0.5) * (1 - rho**2) / (1 - 2 * rho * numpy.cos(omega * 0.4) + rho**2)
    # A window of 59 s has a width of .1 /s, a fifth of the peak: its square, a twenty-fifth, times a curvature of
    # order 1, is the bias at the top; 3 % elsewhere.  The mean is left out.
    away = abs(omega) > 0.3
    deviation = ((values - expected) / errors)[:, away]
    assert abs(values[:, away].mean(axis=0) / expected[away] - 1).mean() < 0.1
    assert 0.8 < numpy.sqrt((deviation**2).mean()) < 1.3 and abs(deviation.mean()) < 0.2
    # The sum rule: the integral over omega/(2 pi) is S(q), up to the error of a mean over 6000 s.
    total = values.sum(axis=1) * (omega[1] - omega[0]) / (2 * numpy.pi)
    assert total == pytest.approx(0.05, rel=0.15)


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
