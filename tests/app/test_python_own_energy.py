"""tests/app/test_python_own_energy.py: energies and powers of models of one's own, and what archives call them."""
import numpy as np
import pytest

import drover

WAVE = """
[[field]]
symbol = "A"
name = "amplitude"
rank = "complex"
[[field]]
symbol = "u"
name = "flow"
mass = "2 + c"
mass_unit = "mg mm-2"
unit = "mm s-1"
energy = "motion"
[[field]]
symbol = "c"
energy = "none"
[equations]
A = "0.3 A + (1 + i) lap A - (1 - 2 i) |A|^2 A"
u = "0.1 lap u - u"
c = "0.2 lap c + 0.1 u"
[grid]
nx = 16
ny = 16
lx = 8.0
ly = 8.0
[time]
dt = 0.001
end = 0.02
stepper = "etdrk4-krogstad"
[initial]
kind = "formula"
amplitude_re = "0.5 + 0.2 cos(2 pi x / lx)"
amplitude_im = "0.3 sin(2 pi y / ly)"
flow = "0.7 + 0.1 cos(2 pi y / ly)"
c = "0.2 cos(2 pi x / lx)"
[output]
powers = true
sample_every = 0.001
[analysis]
warm_up = 0.0
"""


@pytest.fixture(scope="module")
def run(tmp_path_factory):
    folder = tmp_path_factory.mktemp("energy")
    return drover.Scene.parse(WAVE).run(folder / "wave.h5", quiet=True)


def test_energies_change_by_the_sum_of_their_powers(run):
    for name in ("amplitude", "motion"):
        energy, powers = run.observables[f"energy_{name}"], run.observables[f"power_{name}"]
        step = float(energy.time[1] - energy.time[0])
        # The fourth-order difference over four samples: its error is of 1e-12 of the fifth derivative.
        slope = (energy.values[:-4] - 8 * energy.values[1:-3] + 8 * energy.values[3:-1] - energy.values[4:]) / 12 / step
        size = np.abs(powers.values).sum(axis=1).max()
        assert size > 0.1
        assert np.abs(powers.values[2:-2].sum(axis=1) - slope).max() < 1e-8 * size


def test_energies_have_names_units_and_terms(run):
    names = {name for name in run.observables if name.startswith(("energy_", "power_"))}
    assert names == {"energy_amplitude", "power_amplitude", "energy_motion", "power_motion"}
    assert run.observables["energy_motion"].attrs["units"] == "mg mm2 s-2"
    assert run.observables["power_motion"].attrs["units"] == "mg mm2 s-3"
    assert "A_re: 0.3 A, " in run.observables["power_amplitude"].term.attrs["comment"]


def test_power_of_the_decay_follows_its_formula(run):
    decay = run.observables["power_motion"].values[0]
    # u = 0.7 + 0.1 cos(y) and 2 + c: the term -u has the power -int u^2, of the c of 2 + c the growth 0.1 u adds
    # int u^3/20.
    square, cube = 0.49 + 0.005, 0.343 + 3 * 0.7 * 0.005
    assert decay[np.abs(decay + square * 64.0).argmin()] == pytest.approx(-square * 64.0, rel=1e-12)
    assert decay[-1] == pytest.approx(0.05 * cube * 64.0, rel=1e-12)


def test_a_field_of_python_names_its_energy():
    flow = drover.Model([drover.Field("u", "-u", mass="m", mass_unit="mg", energy="motion"),
                         drover.Field("c", "lap c", energy="none")], m=2.0)
    scene = flow.scene(points=8, side=8.0, dt=0.1, end=0.1)
    assert [(scene[f"field[{k}].energy"], scene[f"field[{k}].mass_unit"]) for k in (1, 2)] == [("motion", "mg"),
                                                                                             ("none", "1")]
