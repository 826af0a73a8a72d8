"""tests/app/test_own_step_error.py: models of one's own tell the error of their time steps, as rods and beads do."""
import json
import re

import h5py
import numpy as np
import pytest
from support import MODELS, contents, drover, drover_json, settings

SMALL = ["grid.nx=32", "grid.ny=32", "grid.lx=32.0", "grid.ly=32.0", "time.end=250.0", "output.frame_every=250.0",
         "accuracy.effort=0.2"]
# A cubic field with noise: its step of 0.5 s biases the variance by some per cent.
CUBIC = """
model = {name = "cubic"}
field = [{symbol = "f", name = "height", noise = 1.0}]
grid = {nx = 16, ny = 16, lx = 16.0, ly = 16.0}
time = {dt = 0.5, end = 2000.0}
output = {frame_every = 0.0, sample_every = 1.0}
analysis = {warm_up = 50.0}
accuracy = {effort = 0.5}
[equations]
f = "-f - f^3 + lap f"
"""


def errors(path):
    with h5py.File(path) as file:
        return file["observables/time"][:], file["observables/step_error"][:]


def test_the_error_of_equations_of_ones_own_is_that_of_the_built_in_ones(tmp_path):
    enough = [*SMALL, "accuracy.effort=1.0"]  # that biases are resolved
    built_in, own = (drover_json(tmp_path, "run", MODELS / f"{name}.toml", "-o", f"{name}.h5", "-q", *settings(enough))
                     for name in ("flock", "flock-as-equations"))
    found, expected = errors(tmp_path / "flock-as-equations.h5")[1], errors(tmp_path / "flock.h5")[1]
    # The same method on the same equations.  The fields agree to about 1e-12, and the error of a step is the difference
    # of fields that agree to 1e-7: 1e-5 of it is rounding, which differences of rates enlarge.
    assert expected.max() > 1e-3 and np.abs(found - expected).max() < 1e-3 * expected.max()
    for of_own, of_built_in in (("rod_density", "rods"), ("bead_density", "beads"),
                                ("polar_order_across", "order_across")):
        one = own["results"][f"structure_factor_{of_own}"]["values"]
        other = built_in["results"][f"structure_factor_{of_built_in}"]["values"]
        resolved = [(a, b) for a, b in zip(one, other) if b["step_bias"] is not None]
        assert len(resolved) >= 5
        for a, b in resolved:
            assert a["step_bias"] == pytest.approx(b["step_bias"], rel=1e-3, abs=1e-6 * b["mean"])


def test_the_error_of_the_phase_of_an_oscillation_adds_up_over_its_periods(tmp_path):
    # X + i Y = exp(-i c t) is exact.  The errors of single steps turn with it, and those of its size change its phase.
    end = 60.0  # ten periods
    drover(tmp_path, "run", MODELS / "ginzburg-landau.toml", "-q", "-o", "run.h5",
           *settings(["grid.nx=16", "grid.ny=16", "initial.amplitude=0.0", f"time.end={end}", "output.frame_every=1.0",
                      "coefficients.c=-1.0"]))
    times, found = errors(tmp_path / "run.h5")
    with h5py.File(tmp_path / "run.h5") as run:
        exact = np.exp(1j * run["time"][:])
        for frame in (10, 20, 40, 60):
            true = max(abs(run[name][frame].mean() - wave[frame]) / np.std(wave[: frame + 1])
                       for name, wave in (("amplitude_re", exact.real), ("amplitude_im", exact.imag)))
            told = found[np.argmin(np.abs(times - run["time"][frame]))]
            # Between two checks of the steps the errors turn by 50 degrees, which is extrapolated: good to some tenths.
            assert 0.5 < told / true < 2.0, frame


def test_the_error_of_a_pattern_is_the_true_one_within_a_factor_of_three(tmp_path):
    # Its waves are shorter than those of the grid on which errors of long waves evolve.
    words = ["run", MODELS / "brusselator.toml", "-q",
             *settings(["grid.nx=64", "grid.ny=64", "grid.lx=50.0", "grid.ly=50.0", "time.end=40.0",
                        "output.frame_every=10.0"])]
    drover(tmp_path, *words, "-o", "run.h5")
    drover(tmp_path, *words, "-o", "fine.h5", "--set", "time.dt=0.0025", "--set", 'time.stepper="etdrk4-krogstad"')
    times, found = errors(tmp_path / "run.h5")
    with h5py.File(tmp_path / "run.h5") as run, h5py.File(tmp_path / "fine.h5") as fine:
        for frame in (2, 3, 4):
            true = max(np.sqrt(np.mean((run[name][frame] - fine[name][frame]) ** 2)) / np.std(fine[name][frame])
                       for name in ("activator", "inhibitor"))
            told = found[np.argmin(np.abs(times - run["time"][frame]))]
            assert true / 3.0 < told < 3.0 * true


@pytest.mark.parametrize("equation, points, time, frequency", [
    ("-d_x u", 128, "dt = 0.1, end = 20.0, tolerance = 1e-4", lambda k: k),
    ("-d_x d_x d_x u", 128, "dt = 0.01, end = 2.0, tolerance = 1e-5", lambda k: -k**3),
    ("-d_x d_x d_x u", 32, "dt = 0.01, end = 2.0, tolerance = 1e-5", lambda k: -k**3)])
def test_steps_as_long_as_is_stable_do_not_make_short_waves_of_the_error_grow(tmp_path, equation, points, time,
                                                                              frequency):
    # Waves keep their size, and the exact solution is a sum of them.  A method of second order for the error let its
    # shortest waves grow to 1 (the true errors are 2e-5 and 2e-8), and local errors of waves that the fields hardly
    # have counted as if they added up in all steps (0.33 for 2e-5).
    (tmp_path / "wave.toml").write_text(f"""
field = [{{symbol = "u", conserved = true}}]
grid = {{nx = {points}, ny = 1, lx = {2.0 * np.pi}, ly = 1.0}}
time = {{{time}, stepper = "etdrk4-krogstad"}}
initial = {{kind = "formula", u = "exp(cos(x))"}}
equations = {{u = "{equation}"}}
output = {{frame_every = 0.2, sample_every = 0.2}}
""")
    assert "too inaccurate" not in drover(tmp_path, "run", "wave.toml", "-q").stderr
    found = errors(tmp_path / "wave.h5")[1]
    with h5py.File(tmp_path / "wave.h5") as run:
        fields = np.array(run["u"])
        fields = fields.reshape(len(fields), -1)
        start, k = np.fft.fft(fields[0]), np.fft.fftfreq(points, 1.0 / points)
        largest = 0.0  # short waves come and go, and the first are seen a step or two late
        for frame in range(1, len(fields)):
            exact = np.fft.ifft(start * np.exp(-1j * frequency(k) * run["time"][frame])).real
            true = np.sqrt(np.mean((fields[frame] - exact)**2)) / np.std(exact)
            largest = max(largest, true)
            assert frame < 8 or true / 3.0 < found[frame] < 5.0 * largest


def test_a_long_step_is_reported_with_a_step_that_is_not(tmp_path):
    words = ["run", MODELS / "swift-hohenberg.toml", "-q", *settings(["time.end=40.0"])]
    told = drover_json(tmp_path, *words, "-o", "long.h5", "--set", "time.dt=4.0", "--set", "output.sample_every=4.0",
                       "--set", "output.frame_every=0.0")
    (warning,) = [one for one in told["warnings"] if one.startswith("time.dt")]
    suggested = re.search(r"choose time.dt = ([0-9.e-]+)", warning)[1]
    told = drover_json(tmp_path, *words, "-o", "short.h5", "--set", f"time.dt={suggested}", "--set",
                       "output.sample_every=2.0", "--set", "output.frame_every=0.0")
    assert not [one for one in told["warnings"] if one.startswith("time.dt")]


def test_the_bias_of_each_number_of_a_noisy_model_is_within_its_uncertainty(tmp_path):
    (tmp_path / "cubic.toml").write_text(CUBIC)
    found = json.loads(drover(tmp_path, "run", "cubic.toml", "-o", "run.h5", "--json").stdout)["results"]
    fine = json.loads(drover(tmp_path, "run", "cubic.toml", "-o", "fine.h5", "--json", "--set",
                             "time.dt=0.0625").stdout)["results"]
    right, resolved = 0, 0
    for name, row in found.items():
        for one, other in zip(row.get("values", [row]), fine[name].get("values", [fine[name]])):
            if None in (one.get("step_bias"), one.get("step_bias_error"), one["error"], other["mean"]):
                continue
            resolved += 1
            # Both runs follow one noise path, so that their difference scatters by less than the error of each.
            right += abs(one["mean"] - other["mean"] - one["step_bias"]) <= 2.0 * one["step_bias_error"] + one["error"]
    assert resolved > 15 and right >= 0.9 * resolved
    variance = found["variance_height"]
    assert abs(variance["step_bias"]) > 2.0 * variance["step_bias_error"]
    assert re.search(r"variance_height .* [+-][0-9.]+ \+- [0-9.]+ %", drover(tmp_path, "info", "run.h5").stdout)


def test_a_restart_within_a_piece_that_is_repeated_gives_the_same_bytes(tmp_path):
    (tmp_path / "cubic.toml").write_text(CUBIC)
    # Most of the run is repeated.
    for name, end in (("whole", 300.0), ("parts", 151.0)):
        drover(tmp_path, "run", "cubic.toml", "-q", "-o", name + ".h5",
               *settings([f"time.end={end}", "accuracy.effort=2.0"]))
    drover(tmp_path, "restart", "parts.h5", "-q", "--set", "time.end=300.0")
    with h5py.File(tmp_path / "whole.h5") as file:
        assert len(file["step_bias/steps"]) > 4
    assert contents(tmp_path / "whole.h5") == contents(tmp_path / "parts.h5")


# Whose rates grow without limit while their mean squares do not: that of T by its offset, that of D by its size.
SINGULAR = {
    "a temperature far from zero runs away": ("T", "exp(T - 1000)", "999", 2.7, lambda t: 1000 - np.log(np.e - t)),
    "the same near zero": ("T", "exp(T)", "-1", 2.7, lambda t: -np.log(np.e - t)),
    "a drop evaporates": ("D", "-1/D", "1", 0.4999, lambda t: np.sqrt(1 - 2 * t)),
    "a film ruptures": ("D", "-1/D^3", "1", 0.2499, lambda t: (1 - 4 * t) ** 0.25),
}


@pytest.mark.parametrize("stepper", ["etdrk2", "etdrk4-krogstad"])
@pytest.mark.parametrize("name", SINGULAR)
def test_the_error_of_a_rate_that_grows_without_limit_is_told(tmp_path, name, stepper):
    symbol, rate, start, end, exact = SINGULAR[name]
    (tmp_path / "s.toml").write_text(f"""
field = [{{symbol = "{symbol}"}}]
equations = {{{symbol} = "{rate}"}}
grid = {{nx = 8, ny = 1}}
time = {{dt = {end / 50!r}, end = {end}, stepper = "{stepper}"}}
initial = {{kind = "formula", {symbol} = "{start}"}}
output = {{frame_every = 0.0, sample_every = {end / 50!r}}}
""")
    done = drover(tmp_path, "run", "s.toml", "-q")
    times, told = errors(tmp_path / "s.h5")
    with h5py.File(tmp_path / "s.h5") as run:
        true = abs(run[symbol][-1].mean() - exact(end)) / np.std(exact(times))
    # Each has an error of some per cent of its change.  It is that of the last steps, in each of which it grows several
    # times: the next may be checked too late by one.
    assert true > 0.005 and 0.2 < told[-1] / true < 20.0
    assert "time.dt" in done.stdout


def test_the_error_of_a_run_of_a_few_steps_from_zero_is_told(tmp_path):
    (tmp_path / "s.toml").write_text("""
field = [{symbol = "a"}]
equations = {a = "30 - a^3"}
grid = {nx = 8, ny = 1}
time = {dt = 0.05, end = 0.15}
output = {frame_every = 0.0, sample_every = 0.05}
""")
    assert "time.dt = 0.05 is too long" in drover(tmp_path, "run", "s.toml", "-q").stdout  # 2.69 for 2.94


WAVES = """
field = [{symbol = "A", rank = "complex"}]
grid = {nx = 24, ny = 18, lx = 12.0, ly = 9.0}
time = {dt = 0.1, end = 10.0, stepper = "etdrk2", max_error = 1.0}
output = {frame_every = 0.0, sample_every = 0.2}
analysis = {warm_up = 0.0}
equations = {A = "A + (1 + 0.5 i) lap A - (1 + i) |A|^2 A"}
[initial]
kind = "formula"
A_re = "0.9*cos(2*pi*x/lx) + 0.2"
A_im = "0.9*sin(2*pi*x/lx) + 0.2*cos(2*pi*y/ly)"
"""


def test_biases_of_structure_factors_hold_where_the_grid_of_the_error_has_their_waves(tmp_path):
    """Elsewhere the estimate has no error at all, although the shortest waves are wrong by some per cent."""
    (tmp_path / "waves.toml").write_text(WAVES)
    exact = ["time.stepper=etdrk4-krogstad", "time.dt=0.02", "accuracy.effort=0"]
    found, expected = (drover_json(tmp_path, "run", "waves.toml", "-o", f"{len(words)}.h5", "-q", *settings(words))
                       ["results"]["structure_factor_A_re"]["values"] for words in ([], exact))
    biases = [shell["step_bias"] for shell in found]
    assert biases[0] is not None and biases[-2:] == [None, None]
    for shell, other in zip(found, expected):
        if shell["step_bias"] is not None:
            assert abs(shell["mean"] - other["mean"] - shell["step_bias"]) < 4.0 * shell["step_bias_error"]


@pytest.mark.parametrize("method, dt", [("etdrk4", 0.5), ("cvode-bdf", 0.5), ("etdrk4", 0.25)])
def test_the_error_of_a_limit_cycle_grows_as_its_phase_does(tmp_path, method, dt):
    """A Hopf normal form, with outputs less often than its steps: u + i w has the phase 3 t, and 1/r^2 - 1 decays as
    exp(-2 t).  Along chords between outputs the error grew by a factor of e in a few seconds."""
    (tmp_path / "cycle.toml").write_text(f"""
field = [{{symbol = "u"}}, {{symbol = "w"}}]
grid = {{nx = 8, ny = 1, lx = 8.0, ly = 1.0}}
time = {{dt = {dt}, end = 40.0, stepper = "{method}", tolerance = 1e-6}}
output = {{frame_every = 40.0, sample_every = {dt}}}
initial = {{kind = "formula", u = "0.5"}}
[equations]
u = "u - 3 w - (u^2 + w^2) u"
w = "w + 3 u - (u^2 + w^2) w"
""")
    drover(tmp_path, "run", "cycle.toml", "-q")
    with h5py.File(tmp_path / "cycle.h5") as file:
        u, w = file["u"][-1].mean(), file["w"][-1].mean()
    radius = (1.0 + 3.0 * np.exp(-80.0))**-0.5
    error = np.hypot(u - radius * np.cos(120.0), w - radius * np.sin(120.0))  # of fluctuations of 0.7
    estimate = errors(tmp_path / "cycle.h5")[1][-1]
    # Good to a factor of 3; the error of steps that follow a tolerance scatters by as much.
    assert 0.2 * error < estimate < 10.0 * error


def test_a_field_that_noise_takes_through_zero_does_not_end_the_run(tmp_path):
    """A uniform field in noise of D per area 4 changes by sqrt(0.2 D/4) = 0.36 in a step.  With these seeds it is as
    small as the error of the first step after that step alone, which was taken for a step that is too long."""
    (tmp_path / "s.toml").write_text("""
field = [{symbol = "u", noise = 2.56}]
equations = {u = "1 - u - u^3"}
grid = {nx = 4, ny = 1, lx = 4.0, ly = 1.0}
time = {dt = 0.2, end = 20.0, stepper = "etdrk2"}
initial = {kind = "formula", u = "0.5"}
output = {frame_every = 0.0, sample_every = 0.2}
""")
    for seed in (38, 40):
        drover(tmp_path, "run", "s.toml", "-q", "-o", f"{seed}.h5", *settings([f"run.seed={seed}"]))
        with h5py.File(tmp_path / f"{seed}.h5") as run:
            first, second = np.abs(run["observables/mean_u"][:2])
        assert second < 0.1 * first
