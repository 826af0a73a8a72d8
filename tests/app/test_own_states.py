"""tests/app/test_own_states.py: drover states of models of one's own, against exact waves, bands of rods and beads, and
refusals."""
import json
import math

import h5py
import numpy as np
import pytest
from rejection import rejected
from support import MODELS, drover

LENGTH = 20.0
# Complex Ginzburg-Landau equation: A = X + i Y, d_t A = A + (1 + i b) lap A - (1 + i c) |A|^2 A.
GINZBURG_LANDAU = f"""
field = [{{symbol = "X", name = "real"}}, {{symbol = "Y", name = "imaginary"}}]
grid = {{nx = 64, ny = 4, lx = {LENGTH}, ly = 4.0}}
time = {{dt = 0.05, end = 10.0}}
initial = {{kind = "formula", real = "0.9 cos(2 pi x / lx)", imaginary = "0.9 sin(2 pi x / lx)"}}
define = {{power = "X^2 + Y^2"}}
coefficients = {{b = 0.5, c = -0.4}}
[equations]
X = "X + lap X - b lap Y - power (X - c Y)"
Y = "Y + lap Y + b lap X - power (Y + c X)"
"""


def write(folder, text, name="own.toml"):
    (folder / name).write_text(text)
    return name


def states(folder, *words):
    return json.loads(drover(folder, "states", *words, "--wave", "x", "--json").stdout)


def speed_of_plane_wave(b, c):
    """Of A = sqrt(1 - q^2) exp(i (q x - omega t)) with omega = b q^2 + c (1 - q^2)."""
    q = 2.0 * math.pi / LENGTH
    return (b * q * q + c * (1.0 - q * q)) / q


def rates_of_plane_wave(b, c, count):
    """Of (u exp(i k x) + conj(w) exp(-i k x)) times the wave, in its frame: two for each k."""
    q = 2.0 * math.pi / LENGTH
    power, rates = 1.0 - q * q, []
    for k in 2.0 * math.pi / LENGTH * np.arange(-8, 9):
        matrix = np.array([[-(1 + 1j * b) * (k * k + 2 * q * k) - (1 + 1j * c) * power, -(1 + 1j * c) * power],
                           [-(1 - 1j * c) * power, -(1 - 1j * b) * (k * k - 2 * q * k) - (1 - 1j * c) * power]])
        rates += list(np.linalg.eigvals(matrix) + 1j * k * speed_of_plane_wave(b, c))
    return sorted((rate for rate in rates if abs(rate) > 1e-9), key=lambda rate: -rate.real)


@pytest.mark.parametrize("size", [0.9, 0.6])
def test_a_state_far_from_its_guess_is_told(tmp_path, size):
    # The guess is the wave but for its size, and the position is kept: the state is the same wave, of its exact size.
    scene = write(tmp_path, GINZBURG_LANDAU.replace("0.9 ", f"{size} "))
    ended = drover(tmp_path, "states", scene, "--wave", "x", "--json")
    amplitude = math.sqrt(1.0 - (2.0 * math.pi / LENGTH)**2)
    assert json.loads(ended.stdout)["change"] == pytest.approx(amplitude / size - 1.0, rel=1e-8)
    assert ("a different branch" in ended.stderr) == (size == 0.6)


def test_a_plane_wave_has_its_exact_speed_amplitude_and_stability(tmp_path):
    found = states(tmp_path, write(tmp_path, GINZBURG_LANDAU), "-o", "wave.h5")
    assert found["speed"] == pytest.approx(speed_of_plane_wave(0.5, -0.4), rel=1e-11)
    amplitude = math.sqrt(1.0 - (2.0 * math.pi / LENGTH)**2)
    assert found["mean_real"] == pytest.approx(0.0, abs=1e-12)
    exact = rates_of_plane_wave(0.5, -0.4, 8)
    assert found["growth_rate"] == pytest.approx(exact[0].real, rel=1e-8)
    for rate, one in zip(found["perturbations"], exact):
        assert rate["rate"] == pytest.approx(one.real, rel=1e-7)
    with h5py.File(tmp_path / "wave.h5") as archive:
        real, imaginary = archive["real"][0], archive["imaginary"][0]
        assert archive["time"].attrs["units"] == b"1"  # the number of the state
    assert real.shape == (4, 64) and np.abs(np.hypot(real, imaginary) - amplitude).max() < 1e-11
    # A run that starts from the frame goes on with it: after 2 s the wave has moved by 2 speeds.
    line = next(line for line in GINZBURG_LANDAU.splitlines() if line.startswith("initial"))
    write(tmp_path, GINZBURG_LANDAU.replace(line, 'initial = {kind = "file", file = "wave.h5", frame = 0}'))
    drover(tmp_path, "run", "own.toml", "--set", "time.end=2", "--set", "output.frame_every=2", "--set", "time.dt=0.01",
           "--set", "time.stepper=etdrk4-krogstad", "-o", "run.h5", "--quiet")
    with h5py.File(tmp_path / "run.h5") as archive:
        after = archive["real"][-1, 0] + 1j * archive["imaginary"][-1, 0]
    turned = np.exp(-2j * math.pi / LENGTH * 2.0 * found["speed"])
    assert np.abs(after - turned * (real[0] + 1j * imaginary[0])).max() < 1e-8  # of the steps: 6e-10


def test_a_wave_is_followed_along_a_coefficient(tmp_path):
    found = states(tmp_path, write(tmp_path, GINZBURG_LANDAU), "--follow", "b = 1")
    curve = found["curve"]
    assert len(curve) > 3 and curve[-1]["parameter"] >= 1.0
    for point in curve:
        assert point["speed"] == pytest.approx(speed_of_plane_wave(point["parameter"], -0.4), rel=1e-9)


# A = X + i Y, d_t A = m A + |A|^2 A - |A|^4 A + lap A: waves of |A|^2 = 1/2 (1 +- sqrt(1 + 4 (m - q^2))).
QUINTIC = f"""
field = [{{symbol = "X", name = "real"}}, {{symbol = "Y", name = "imaginary"}}]
grid = {{nx = 64, ny = 4, lx = {LENGTH}, ly = 4.0}}
time = {{dt = 0.05, end = 10.0}}
initial = {{kind = "formula", real = "cos(2 pi x / lx)", imaginary = "sin(2 pi x / lx)"}}
define = {{power = "X^2 + Y^2"}}
coefficients = {{m = 0.2}}
[equations]
X = "m X + lap X + power (1 - power) X"
Y = "m Y + lap Y + power (1 - power) Y"
"""


def test_a_curve_turns_at_its_exact_fold_between_the_states_that_were_found(tmp_path):
    found = states(tmp_path, write(tmp_path, QUINTIC), "--follow", "m = -0.5", "--points", "30")
    square = (2.0 * math.pi / LENGTH)**2
    turns = [turn["parameter"] for turn in found["turns"]]
    states_at = [point["parameter"] for point in found["curve"] if point["fold"]]
    # m is of fourth order in |A|, and so is the polynomial: it turns where the root is 0, and where A passes through 0.
    assert turns[:2] == pytest.approx([square - 0.25, square], abs=1e-7)  # of Newton's method
    assert abs(states_at[0] - turns[0]) > 1e-5
    assert [turn["pitchfork"] for turn in found["turns"][:2]] == [False, True]
    assert [point["pitchfork"] for point in found["curve"]].count(True) == 1 and len(states_at) == len(turns) - 1
    assert all(1e-9 < turn["error"] < 0.01 for turn in found["turns"][:1])  # what a parabola leaves out


@pytest.mark.parametrize("last", [0.0, -0.2])
def test_a_curve_stays_on_its_branch_and_turns_where_that_meets_the_uniform_state(tmp_path, last):
    # Waves about u = r have |q|^2 < r, so there is none of the length of the cell below (2 pi/lx)^2.  With long steps
    # the curve ended up to 0.08 before, or went on along the waves about u = 0, which exist below minus this.
    pulse = """
field = [{symbol = "u"}]
equations = {u = "-r u + u^2 + lap u"}
coefficients = {r = 1.0}
grid = {nx = 64, ny = 1, lx = 20.0, ly = 1.0}
time = {dt = 0.05, end = 10.0}
initial = {kind = "formula", u = "1.5/cosh((x-lx/2)/2)^2"}
"""
    found = states(tmp_path, write(tmp_path, pulse), "--follow", f"coefficients.r = {last}")
    turn, = found["turns"]
    assert turn["pitchfork"] and turn["parameter"] == pytest.approx((2.0 * math.pi / 20.0)**2, abs=2e-4)  # of the steps
    assert min(point["parameter"] for point in found["curve"]) > turn["parameter"] - 1e-4


def test_a_band_of_the_same_equations_is_that_of_rods_and_beads(tmp_path):
    text = (MODELS / "toner-tu.toml").read_text()
    rise = "(1 / (1 + exp((x - 80) / sqrt(3))) + 1 / (1 + exp(-(x - 32) / sqrt(12))) - 1)"
    own = states(tmp_path, write(tmp_path, text), "--set", "grid.ny=1", "--set", "grid.nx=256", "--set", "grid.lx=128",
                 "--set", "grid.ly=8", "--set", "coefficients.rho0=1.0208333333333333", "--set", "initial.amplitude=0",
                 "--set", f'initial.density="5/6 + 0.5 * {rise}"',
                 "--set", f'initial.polarity_x="1 / sqrt(3) * {rise}"')
    of_rods = states(tmp_path, MODELS / "band.toml", "--set", "grid.nx=256")
    for name, other in (("speed", "speed"), ("low_density", "rod_low"), ("high_density", "rod_high"),
                        ("max_polarity", "max_polar_order"), ("growth_rate", "growth_rate")):
        # Newton's method stops at a residual of 1e-10 of the linear terms; the slowest rate is 1/100 of them.
        assert own[name] == pytest.approx(of_rods[other], rel=1e-8), name
    assert own["coexistence_density"] is True and own["speed"] == pytest.approx(math.sqrt(4 / 3), rel=1e-5)


@pytest.mark.parametrize("changes, words, says", [
    (("X = \"X", "X = \"cos(x) + X"), [], ["cos(x)", "depends on position or time"]),
    (("", ""), ["--follow", "d = 1"], ["--follow names d", "coefficients.b, coefficients.c"]),
    (("", ""), ["--follow", "b = 0.5"], ["b is 0.5 already"]),
    (('real = "0.9 cos(2 pi x / lx)", imaginary = "0.9 sin(2 pi x / lx)"', 'real = "1"'), ["--settle", "0"],
     ["does not depend on x"]),
])
def test_what_has_no_travelling_state_is_rejected(tmp_path, changes, words, says):
    scene = write(tmp_path, GINZBURG_LANDAU.replace(*changes))
    rejected(tmp_path, ["states", scene, "--wave", "x", *words], says)


def test_the_values_of_a_state_are_named_once(tmp_path):
    heads = [line for line in drover(tmp_path, "stability", MODELS / "malthusian-flock.toml").stdout.splitlines()
             if line.startswith("state: ")]
    assert len(heads) == 3 and "state: isotropic, rho = 1.1" in heads


@pytest.mark.parametrize("growth", [0.5, 1.0, 2.0])
def test_the_fastest_of_many_growing_perturbations_is_reported(growth, tmp_path):
    # A kink pair of Cahn and Hilliard, with w of the rates g - 100 k^2 and A of 0.9 - k^2 +- 5 i: more than eight grow
    # faster than the translation.
    side = 60.0
    write(tmp_path, f"""
field = [{{symbol = "u", conserved = true}}, {{symbol = "w"}}, {{symbol = "A", rank = "complex"}}]
grid = {{nx = 128, ny = 1, lx = {side}, ly = 1.0}}
time = {{dt = 0.05, end = 10.0}}
initial = {{kind = "formula", u = "tanh((x - 15)/sqrt(2)) - tanh((x - 45)/sqrt(2)) - 1"}}
coefficients = {{g = {growth}}}
[equations]
u = "lap (u^3 - u - lap u)"
w = "g w - w^3 + 100 lap w"
A = "(0.9 + 5 i) A + lap A - A^2 conj(A)"
""")
    found = states(tmp_path, "own.toml")
    assert found["growth_rate"] == pytest.approx(max(growth, 0.9), abs=1e-6)
    assert len(found["perturbations"]) == 8
