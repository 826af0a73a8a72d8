"""tests/app/test_python_bodies.py: bodies that a program changes between two steps of a run in memory."""
import numpy as np
import pytest
from support import MODELS

import drover

# Elastic and smooth, between plates at rest and without gravity: the motion is reversible, and energy is kept.
ELASTIC = {**{f"restitution.{pair}": 1.0 for pair in ("bead_bead", "rod_bead", "rod_rod", "bead_plate", "rod_plate",
                                                      "bead_wall", "rod_wall")},
           **{f"friction.{pair}": 0.0 for pair in ("bead_bead", "rod_bead", "rod_rod", "bead_plate", "rod_plate",
                                                   "bead_wall", "rod_wall")},
           "plates.amplitude": 0.0, "gravity.z": 0.0, "contacts.inelastic_threshold": 0.0}
GAS = {"cell.lx": 12.0, "cell.ly": 12.0, "beads.area_fraction": 0.0, "time.dt": 2e-5, "time.end": 1.0,
       "output.sample_every": 0.01}


def gas(beads=1, **changes):
    return drover.Scene.load(MODELS / "bead-gas.toml").set({**GAS, "beads.count": beads, **changes}).start()


def rods(count=4):
    return drover.Scene.load(MODELS / "bead-flock.toml").set(
        {"cell.lx": 30.0, "cell.ly": 30.0, "beads.area_fraction": 0.0, "rods.area_fraction": 0.0, "rods.count": count,
         "time.end": 0.02, "output.sample_every": 0.001}).start()


def test_a_reversed_bead_returns_along_its_path():
    run = gas(**ELASTIC)
    with run.edit() as bodies:
        bodies.bead_velocity[0] = 31.0, 17.0, 40.0
    start = run.frame.bead_position.copy()
    run.advance(0.2)
    assert np.hypot(*(run.frame.bead_position - start)[0, :2]) == pytest.approx(0.2 * np.hypot(31, 17), rel=1e-9)
    with run.edit() as bodies:
        bodies.bead_velocity[...] *= -1.0
    run.advance(0.2)
    # 20 flights of 10000 steps, each rounded at 12 mm.
    assert run.frame.bead_position == pytest.approx(start, abs=1e-10) and run.was_changed


def test_bodies_that_are_given_back_unchanged_go_on_as_without():
    one, other = (gas(20, **ELASTIC) for _ in range(2))
    for run in (one, other):
        with run.edit() as bodies:
            bodies.bead_velocity[:, 0] = np.linspace(-40.0, 40.0, 20)
        run.advance(0.05)
    with other.edit():
        pass
    for run in (one, other):
        run.advance(0.002)  # too short for chaos to grow the rounding of another order of pairs
    assert one.frame.bead_position == pytest.approx(other.frame.bead_position, abs=1e-12)


@pytest.mark.parametrize("gravity", [0.0, -9810.0])
def test_what_an_edit_does_to_the_kinetic_energy_is_work_of_forces_and_heights_are_none(gravity):
    run = gas(20, **{**ELASTIC, "gravity.z": gravity})
    run.advance(0.01)
    with run.edit() as bodies:
        bodies.bead_velocity[...] = 3.0
        bodies.bead_position[:, 2] = 1.2 - bodies.bead_position[:, 2]  # mirrored in the middle of the gap
    run.advance(0.02)
    series = run.observables
    works = {name: float(series[name][-1]) for name in series if name.startswith("work_")}
    first, last = (float(series.energy_kinetic[at]) for at in (0, -1))
    assert last == pytest.approx(first + sum(works.values()), rel=1e-9) and len(works) == 6
    assert gravity or works["work_gravity"] == 0.0
    assert works["work_forces"] != 0.0


def test_rods_turned_alike_have_the_order_one():
    run = rods()
    with run.edit() as bodies:
        bodies.rod_axis[...] = 0.0, 1.0, 0.0
        bodies.rod_position[:, 0] = 7.0 * np.arange(4)
        bodies.rod_position[:, 1] = 0.0
        bodies.rod_velocity[...] = 0.0
        bodies.rod_angular_velocity[...] = 0.0
    run.advance(0.001)
    # Kicks and impacts turn them a little within a millisecond.
    assert float(run.observables.polar_order[-1]) == pytest.approx(1.0, abs=1e-3)


@pytest.mark.parametrize("spoil, words", [
    (lambda bodies: bodies.bead_position.__setitem__((0, 0), np.nan), "finite"),
    (lambda bodies: bodies.bead_position.__setitem__(0, bodies.bead_position[1]), "bead 0 and bead 1 overlap|bead 1 and"
                                                                                  " bead 0 overlap"),
    (lambda bodies: bodies.bead_position.__setitem__((0, 2), 5.0), "bead 0 and the lid overlap"),
    (lambda bodies: bodies.bead_position.__setitem__((0, 2), 0.0), "bead 0 and the base overlap"),
    (lambda bodies: 1 / 0, "zero")])
def test_an_edit_that_fails_changes_no_body(spoil, words):
    run, other = gas(20), gas(20)
    with pytest.raises((drover.Error, ZeroDivisionError), match=words):
        with run.edit() as bodies:
            bodies.bead_velocity[...] += 1.0
            spoil(bodies)
    assert not run.was_changed
    assert run.advance(0.01).bead_position.tobytes() == other.advance(0.01).bead_position.tobytes()


def test_an_axis_of_a_rod_has_the_length_one_and_what_follows_from_bodies_is_read_only():
    run = rods()
    with pytest.raises(drover.Error, match="rod 2 .* length 2; expected 1"):
        with run.edit() as bodies:
            bodies.rod_axis[2] = 0.0, 2.0, 0.0
    with run.edit() as bodies:
        for array in (bodies.spheres.position, bodies.rod_mass):
            with pytest.raises(ValueError, match="read-only"):
                array[0] = 1.0
