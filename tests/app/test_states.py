"""tests/app/test_states.py: drover states: an exact band from a poor guess, its curve, its archive, and bad input."""
import json

import h5py
import numpy as np
import pytest
from support import MODELS, drover

BAND = MODELS / "band.toml"
# Fronts 120 mm apart: their tails leave 1e-8 of the plateaus.
LONG = ["--set", "grid.lx=240", "--set", "grid.nx=512", "--set",
        'initial.rod_density="13/12 + 0.3 * (tanh((x - 50) / 6) - tanh((x - 170) / 3) - 1)"', "--set",
        'initial.polar_order_x="0.35 * (tanh((x - 50) / 6) - tanh((x - 170) / 3))"', "--set",
        "uniform.rod_density=1.08"]

NO_FORMULA = ["--set", 'initial.rod_density=""', "--set", 'initial.polar_order_x=""']


def states(folder, *words):
    return json.loads(drover(folder, "states", *words, "--wave", "x", "--json").stdout)


def test_band_is_found_from_a_poor_guess_with_its_speed_and_both_binodals(tmp_path):
    found = states(tmp_path, BAND, *LONG)
    assert found["speed"] == pytest.approx(np.sqrt(4 / 3), abs=1e-9)
    assert found["rod_low"] == pytest.approx(5 / 6, abs=1e-6)
    assert found["rod_high"] == pytest.approx(4 / 3, abs=1e-6)
    assert found["rod_coexistence"] is True and found["residual"] < 1e-10
    assert found["max_polar_order"] == pytest.approx(1 / np.sqrt(3), abs=1e-6)


@pytest.mark.parametrize("guess", ["1e5", "1e9", "-1e14"])
def test_the_guess_of_the_speed_does_not_set_the_accuracy(tmp_path, guess):
    coarse = ["--set", "grid.nx=64"]
    # Ends of Newton's method with residuals of 1e-10 differ by less than 1e-9 of the speed; where the terms were as
    # large as the guess makes them, 1e5 changed it by 1e-8 and 1e9 by a tenth.
    assert states(tmp_path, BAND, *coarse, f"--speed={guess}")["speed"] == pytest.approx(
        states(tmp_path, BAND, *coarse)["speed"], rel=1e-9)


@pytest.mark.parametrize("words", [["--speed", "inf"], ["--speed", "nan"], ["--settle", "nan"]])
def test_guesses_that_are_not_finite_are_rejected(tmp_path, words):
    assert "expected a finite number" in drover(tmp_path, "states", BAND, "--wave", "x", *words, status=2).stderr


def test_a_state_that_the_grid_does_not_resolve_is_said(tmp_path):
    (tmp_path / "ks.toml").write_text("""
field = [{symbol = "u", conserved = true}]
equations = {u = "-d_x (u^2 / 2) - lap u - lap lap u - d_x lap u"}
grid = {nx = 128, ny = 1, lx = 12.0, ly = 1.0}
time = {dt = 0.01, end = 10.0}
initial = {kind = "formula", u = "2 cos(2 pi x / 12)"}
""")
    speeds = {}
    for points, is_told in ((128, False), (32, False), (16, True)):
        done = drover(tmp_path, "states", "ks.toml", "--wave", "x", "--set", f"grid.nx={points}")
        assert ("the grid does not resolve the state" in done.stdout) == is_told, points
        found = states(tmp_path, "ks.toml", "--set", f"grid.nx={points}")
        assert any("does not resolve the state" in note for note in found["notes"]) == is_told
        speeds[points] = found["speed"]
    assert abs(speeds[32] / speeds[128] - 1.0) < 1e-9 < abs(speeds[16] / speeds[128] - 1.0)


def test_a_state_of_many_fields_is_that_of_the_one_that_drives_them(tmp_path):
    """Cahn and Hilliard's phi, and eight fields that relax to it: u_i = i/(i + q^2) phi in each wave."""
    followers = range(1, 9)
    scene = """
grid = {nx = 128, ny = 1, lx = 25.0, ly = 1.0}
time = {dt = 0.1, end = 200.0}
initial = {kind = "formula", phi = "0.9*tanh(5*sin(2*pi*x/25.0))"}
[equations]
phi = "lap (phi^3 - phi - lap phi)"
"""
    frames = {}
    for name, others in (("one", []), ("nine", followers)):
        symbols = ['{symbol = "phi", conserved = true}', *(f'{{symbol = "u{i}"}}' for i in others)]
        (tmp_path / f"{name}.toml").write_text(f"field = [{', '.join(symbols)}]" + scene +
                                               "".join(f'u{i} = "{i}*(phi - u{i}) + lap u{i}"\n' for i in others))
        states(tmp_path, f"{name}.toml", "-o", f"{name}.h5")
        with h5py.File(tmp_path / f"{name}.h5") as file:
            frames[name] = {key: np.ravel(file[key][-1]) for key in ["phi", *(f"u{i}" for i in others)]}
    phi, squares = np.fft.rfft(frames["one"]["phi"]), (2 * np.pi / 25 * np.arange(65))**2
    # Both are solved to a residual of 1e-10 of the largest rate; the slowest perturbation relaxes at 0.1 of it.
    for i, expected in ((0, phi), *((i, i / (i + squares) * phi) for i in followers)):
        found = np.fft.rfft(frames["nine"][f"u{i}" if i else "phi"])
        assert np.abs(np.abs(found) - np.abs(expected)).max() < 1e-7 * np.abs(phi).max(), i


def test_binodals_follow_the_rate(tmp_path):
    found = states(tmp_path, BAND, *LONG, "--set", "relaxation.rate=0.8333333333333334", "--set",
                   'initial.rod_density="11/12 + 0.3 * (tanh((x - 50) / 6) - tanh((x - 170) / 3) - 1)"')
    assert found["rod_low"] == pytest.approx(2 / 3, abs=1e-6)
    assert found["rod_high"] == pytest.approx(7 / 6, abs=1e-6)


def test_boundary_draws_both_binodals_over_the_rate(tmp_path):
    """With the rate a = r - sigma, all densities of the band shift with r: r - 1/6 and r + 1/3."""
    plane = ["--x", "uniform.rod_density = 0.5:1.5", "--y", "relaxation.rate = 0.8:1.1"]
    found = json.loads(drover(tmp_path, "boundary", BAND, *LONG, *plane, "--set", 'boundary.lines=["binodal"]',
                              "--set", "boundary.map=8", "--json").stdout)
    low, high = found["traced"][0]["lines"]
    for line, shift in ((low, -1 / 6), (high, 1 / 3)):
        points = np.array([(point["x"], point["y"]) for point in line["points"]])
        assert np.abs(points[:, 0] - points[:, 1] - shift).max() < 1e-6
        assert (points[0, 1], points[-1, 1]) == (0.8, 1.1)
    swapped = drover(tmp_path, "boundary", BAND, "--y", plane[1], "--x", "pressure.rods = 0.9:1.1", "--set",
                     'boundary.lines=["binodal"]', "--set", "boundary.map=0").stdout
    assert "2 lines" in swapped
    refused = drover(tmp_path, "boundary", BAND, "--x", "pressure.rods = 0.9:1.1", *plane[2:], "--set",
                     'boundary.lines=["binodal"]', status=2)
    assert "expected the mean density of a field as one axis" in refused.stderr


def test_a_run_from_the_archive_of_a_state_moves_at_its_speed_without_change(tmp_path):
    small = ["--set", "grid.nx=256", "--set", "grid.ny=8"]
    found = states(tmp_path, BAND, *small, "-o", "state.h5")
    drover(tmp_path, "run", BAND, *small, "--set", "initial.kind=file", "--set", "initial.file=state.h5", *NO_FORMULA,
           "--set", "time.end=8", "--set", "time.stepper=etdrk4", "--set", "output.frame_every=8", "--set",
           "output.sample_every=1", "-o", "run.h5", "--quiet")
    with h5py.File(tmp_path / "run.h5") as file:
        first, last, x = file["rod_density"][0, 3], file["rod_density"][-1, 3], file["x"][()]
    modes = np.fft.rfft(first) * np.exp(-2j * np.pi * np.arange(129) / 128.0 * found["speed"] * 8.0)
    assert len(x) == 256 and np.abs(np.fft.irfft(modes) - last).max() < 1e-7  # (rate dt)^4 of the run


def test_the_curve_of_bands_turns_at_a_fold_where_their_stability_changes(tmp_path):
    found = states(tmp_path, BAND, "--set", "grid.nx=192", "--set", "grid.lx=96", "--set",
                   'initial.rod_density="1.05 + 0.25 * (tanh((x - 30) / 6) - tanh((x - 70) / 4) - 1)"', "--set",
                   'initial.polar_order_x="0.29 * (tanh((x - 30) / 6) - tanh((x - 70) / 4))"', "--set",
                   "uniform.rod_density=1.05", "--follow", "uniform.rod_density = 0.8", "--points", "70", "-o",
                   "curve.h5")
    curve = found["curve"]
    density = np.array([point["parameter"] for point in curve])
    growth = np.array([point["growth_rate"] for point in curve])
    fold = density.argmin()
    assert found["curve_is_complete"] is False  # it comes back from the fold
    assert [point["fold"] for point in curve].count(True) == 1 and curve[fold]["fold"]
    # Bands exist from above the binodal 5/6 (the cell is finite) and below the onset of order, 1.
    assert 5 / 6 < density[fold] < 0.95
    assert growth[:fold - 1].max() < 0.0 and growth[fold + 2:].min() > 0.0
    with h5py.File(tmp_path / "curve.h5") as file:
        assert file["rod_density"].shape == (len(curve), 32, 192)
        assert file["curve/curve_parameter"][fold] == pytest.approx(density[fold])


@pytest.mark.parametrize("words, expected", [
    (["--wave", "y"], ["--wave", "x"]),
    (["--wave", "x", "--follow", "pressure.rod = 2"], ["pressure.rod", "did you mean pressure.rods"]),
    (["--wave", "x", "--follow", "pressure.rods"], ["--follow", "pressure.rods"]),
    (["--wave", "x", "--follow", "pressure.rods = 1"], ["is 1 already"]),
    (["--wave", "x", "--set", "initial.kind=uniform", *NO_FORMULA], ["does not depend on x"]),
])
def test_bad_input_is_rejected_with(words, expected, tmp_path):
    result = drover(tmp_path, "states", BAND, *words, status=2)
    for text in expected:
        assert text in result.stderr


def test_a_guess_that_leads_to_no_wave_ends_with_status_1(tmp_path):
    result = drover(tmp_path, "states", BAND, "--wave", "x", "--set", "uniform.rod_density=0.5", "--set", "time.end=40",
                    "--set", "grid.nx=128", "--set", 'initial.rod_density=""', "--set",
                    'initial.polar_order_x="0.1 * cos(2 * pi * x / 128)"', status=1)
    assert "expected" in result.stderr


def swift_hohenberg(rate, size):
    """With unit length: its rates in parts of `rate`, its field in parts of `size`."""
    return f"""
field = [{{symbol = "u"}}]
equations = {{u = "(e - g) u - 2 g lap u - g lap lap u - b u^3"}}
coefficients = {{e = {0.1 * rate!r}, g = {rate!r}, b = {rate / size**2!r}}}
grid = {{nx = 32, ny = 1, lx = {2 * np.pi!r}, ly = 1.0}}
time = {{dt = {0.1 / rate!r}, end = {20 / rate!r}}}
output = {{frame_every = {20 / rate!r}, sample_every = {1 / rate!r}}}
initial = {{kind = "formula", u = "{0.3 * size!r} cos(x)"}}
"""


def test_the_unit_of_time_changes_no_state_and_no_curve(tmp_path):
    found = {}
    for rate, size in ((1.0, 1.0), (2.0**-20, 1.0), (2.0**-40, 1.0), (2.0**30, 2.0**20)):
        (tmp_path / "sh.toml").write_text(swift_hohenberg(rate, size))
        one = states(tmp_path, "sh.toml")
        curve = states(tmp_path, "sh.toml", "--follow", f"coefficients.e = {0.2 * rate!r}")["curve"]
        found[rate] = [one["max_u"] / size, one["growth_rate"] / rate, curve[-1]["max_u"] / size, len(curve)]
        assert curve[-1]["parameter"] >= 0.2 * rate
    for values in found.values():  # the residual of Newton's method, by the slowest rate of 0.2
        assert values == pytest.approx(found[1.0], rel=1e-7)


@pytest.mark.parametrize("unit", [2.0**22, 2.0**-22])
def test_the_unit_of_one_field_changes_no_perturbation_of_a_band(tmp_path, unit):
    def found(u):
        (tmp_path / "band.toml").write_text(f"""
field = [{{symbol = "rho", conserved = true, reference = 1.1}}, {{symbol = "p", rank = "vector"}}]
grid = {{nx = 64, ny = 1, lx = 50.0, ly = 1.0}}
time = {{dt = 0.25, end = 40.0}}
output = {{frame_every = 20.0, sample_every = 1.0}}
[equations]
rho = "-c div p"
p = "(rho - 1 - b p.p) p - w p.grad p + lap p - e grad rho"
[coefficients]
c = {1 / u!r}
b = {1 / u**2!r}
w = {1 / u!r}
e = {u!r}
[initial]
kind = "formula"
rho = "5/6 + 1/4 * (tanh((x - 15)/4) - tanh((x - 35)/4))"
p_x = "{0.4 * u!r} * (tanh((x - 15)/4) - tanh((x - 35)/4))"
""")
        one = states(tmp_path, "band.toml")
        return [one["speed"], *(rate["rate"] for rate in one["perturbations"])]

    assert found(unit) == pytest.approx(found(1.0), rel=1e-4, abs=1e-6)  # of differences; transforms mix fields
