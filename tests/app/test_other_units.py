"""tests/app/test_other_units.py: models in other units of length and of their fields, and fields far from their
references: the same numbers as in the units of the examples."""
import h5py
import numpy as np
import pytest
from support import drover as program, drover_json

SCENE = """
field = [{{symbol = "u"{field}}}]
grid = {{nx = 16, ny = 16, lx = {length}, ly = {length}}}
time = {{{dt}end = {end}}}
initial = {{kind = "formula", u = "{start}"}}
output = {{frame_every = {end}, sample_every = {end}}}
run = {{threads = 1}}
[equations]
u = "{equation}"
[coefficients]
{coefficients}
"""


def write(folder, **given):
    values = {"field": "", "length": 1.0, "dt": "dt = 0.02, ", "end": 1.0, "coefficients": "", **given}
    (folder / "own.toml").write_text(SCENE.format(**values))
    return "own.toml"


def last_modes(folder, scene, *words):
    """The Fourier coefficients of the last frame of u, and what the run said."""
    said = program(folder, "run", scene, "--quiet", "--overwrite", *words)
    with h5py.File(folder / "own.h5") as run:
        u = run["u"][-1]
    return np.fft.fft2(u) / u.size, said.stdout + said.stderr


@pytest.mark.parametrize("length", [1e-9, 1.0, 1e9])
def test_terms_that_name_an_axis_act_at_every_length(tmp_path, length):
    q = 2 * np.pi / length
    scene = write(tmp_path, length=length, start="cos(2 pi x/lx) + sin(2 pi y/ly)",
                  dt='dt = 0.02, stepper = "etdrk4-krogstad", ', equation="-k u + D d_x d_x u - c d_y u",
                  coefficients=f"k = 1.0\nD = {0.5 / q**2}\nc = {0.7 / q}")
    modes, _ = last_modes(tmp_path, scene)
    # Fifty steps of fourth order, of dt |s| = 0.01, are right to 1e-9.
    assert abs(modes[0, 1] - 0.5 * np.exp(-1.5)) < 1e-8 and abs(modes[1, 0] + 0.5j * np.exp(-1 - 0.7j)) < 1e-8


@pytest.mark.parametrize("length", [1e-7, 1.0, 1e7])
def test_stability_finds_the_wave_that_an_axis_makes_grow(tmp_path, length):
    unit = length / 32  # of the wavelength of about 6.3 units
    scene = write(tmp_path, length=length, start="0", coefficients=f"a = 0.1\nK = {2 * unit**2}\nk4 = {unit**4}",
                  equation="-a u - K d_y d_y u - k4 lap lap u - u^3")
    state = drover_json(tmp_path, "stability", scene)["states"][0]
    assert abs(state["fastest_rate"] - 0.9) < 1e-6 and not state["stable"]


WELL = dict(equation="w - w^3 + 0.1 + lap w", start="{mean} + 0.3 cos(2 pi x/lx) + 0.2 sin(2 pi (x + y)/lx)", end=2.0,
            length=40.0)


def well(folder, mean, **more):
    given = {**WELL, "start": WELL["start"].format(mean=mean), **more}
    scene = write(folder, **given)
    text = (folder / scene).read_text()
    (folder / scene).write_text(text + f'[define]\nw = "u - {mean}"\n')
    return scene


@pytest.mark.parametrize("mean", [30.0, 1e3, 1e6])
@pytest.mark.parametrize("dt", ["dt = 0.05, ", ""])  # given, and chosen by pilots
def test_a_field_far_from_its_reference_moves_as_near_it(tmp_path, mean, dt):
    exact, _ = last_modes(tmp_path, well(tmp_path, 0.0, dt="dt = 0.005, "))
    modes, said = last_modes(tmp_path, well(tmp_path, mean, dt=dt))
    modes[0, 0] -= mean
    # 1 % is what time.max_error allows; without a linear part about the mean the waves stay as they are, 40 % too
    # small.
    assert abs(modes - exact).max() < 0.01 * abs(exact).max() and "slow changes" not in said


def test_a_field_that_is_read_far_from_its_reference_is_told_of(tmp_path):
    last_modes(tmp_path, well(tmp_path, 1e3))
    (tmp_path / "own.h5").rename(tmp_path / "first.h5")
    scene = well(tmp_path, 1e3, end=1.0)
    text = (tmp_path / scene).read_text()
    start = text.index("initial")
    (tmp_path / scene).write_text(text[:start] + 'initial = {kind = "file", file = "first.h5"}\n' +
                                  text[text.index("output"):])
    _, said = last_modes(tmp_path, scene)
    assert "less than half of the slow changes about the last means (u = 1e+03)" in said
    (tmp_path / scene).write_text((tmp_path / scene).read_text().replace('"u"', '"u", reference = 1e3'))
    assert "slow changes" not in last_modes(tmp_path, scene)[1]
