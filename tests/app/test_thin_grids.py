"""tests/app/test_thin_grids.py: one-dimensional runs, and thin grids of four rows."""
import math

import h5py
import numpy as np
import pictures
import pytest
from support import MODELS, drover, drover_json, settings, write_scene

import drover as drover_python
from drover import figure, results

FIELDS = ["bead_density", "rod_density", "bead_velocity_x", "bead_velocity_y", "polar_order_x", "polar_order_y"]
# Waves along x of every field, all terms nonlinear.
WAVES = {
    "fields.bead_density": True,
    "fields.bead_velocity": "dynamic",
    "uniform.rod_density": 2.0,
    "uniform.bead_density": 3.0,
    "current.speed": 0.5,
    "current.kind": "density-order",
    "inertia.bead_mass": 0.5,
    "inertia.advection": True,
    "drag.coefficient": 2.0,
    "viscosity.shear": 0.3,
    "driving.strength": 0.6,
    "stiffness.beads": 1.0,
    "relaxation.rate": -0.2,
    "relaxation.saturation": 0.5,
    "elasticity.stiffness": 0.3,
    "weathercock.strength": 0.4,
    "advection.strength": 0.3,
    "pressure.rods": 0.2,
    "diffusion.rods": 0.3,
    "diffusion.beads": 0.2,
    "grid.nx": 64,
    "grid.ny": 1,
    "grid.lx": 16.0,
    "grid.ly": 2.0,
    "time.dt": 0.02,
    "time.end": 4.0,
    "initial.kind": "formula",
    "initial.bead_density": "3 + 0.3*cos(2*pi*x/16)",
    "initial.rod_density": "2 + 0.2*sin(2*pi*x/16)",
    "initial.bead_velocity_y": "0.1*sin(4*pi*x/16)",
    "initial.polar_order_x": "0.3 + 0.1*cos(2*pi*x/16 + 1)",
    "initial.polar_order_y": "0.1*sin(2*pi*x/16)",
    "output.frame_every": 2.0,
    "output.sample_every": 0.2,
}
NOISY = {
    "uniform.rod_density": 20.0,
    "current.speed": 1.0,
    "relaxation.rate": 0.5,
    "elasticity.stiffness": 0.5,
    "pressure.rods": 0.5,
    "diffusion.rods": 0.2,
    "noise.order": 4.0,
    "noise.rods": 8.0,
    "grid.nx": 32,
    "grid.ny": 1,
    "grid.lx": 16.0,
    "grid.ly": 2.0,
    "time.dt": 0.5,
    "time.end": 4000.0,
    "initial.kind": "stationary",
    "output.frame_every": 0.0,
    "output.sample_every": 1.0,
    "analysis.warm_up": 0.0,
}


def run(folder, changes=None, base=None):
    write_scene(folder, changes, base=WAVES if base is None else base)
    return drover_json(folder, "run", "flock.toml", "-q", "--overwrite", "-o", "flock.h5")


def fields_of(folder):
    with h5py.File(folder / "flock.h5") as file:
        return {name: file[name][()] for name in FIELDS}


@pytest.mark.parametrize("stepper", ["etdrk2", "etdrk4"])
@pytest.mark.parametrize("rows", [4, 6, 32])
def test_a_one_dimensional_run_equals_a_two_dimensional_run_of_the_same_data(tmp_path, rows, stepper):
    enough = {"time.stepper": stepper, "accuracy.effort": 5.0}  # that errors are checked at the same steps
    one = run(tmp_path, enough)
    fields = fields_of(tmp_path)
    assert fields["polar_order_x"].shape[1:] == (1, 64) and np.ptp(fields["polar_order_x"][-1]) > 0.01
    two = run(tmp_path, {**enough, "grid.ny": rows})
    for name, found in fields_of(tmp_path).items():
        assert np.abs(found - fields[name]).max() < 1e-12, name  # rounding, 200 steps of numbers of order one
    compared = [name for name, row in one["results"].items() if "mean" in row and "variance" not in name]
    assert {"polar_order", "rods_total", "bead_speed", "spectral_tail_polar_order"} <= set(compared)
    for name in compared:
        found, expected = (report["results"][name]["mean"] for report in (one, two))
        if found is not None:
            # Binder cumulants and susceptibilities are differences of numbers close to each other.  The estimate of the
            # error evolves on fewer points, which are others in two dimensions.
            rel = 0.1 if name == "step_error" else 1e-9
            assert found == pytest.approx(expected, rel=rel, abs=1e-11), name


def test_shells_and_boxes_of_a_one_dimensional_run_are_its_waves_and_segments(tmp_path):
    report = run(tmp_path)["results"]
    with h5py.File(tmp_path / "flock.h5") as file:
        density, q = file["rod_density"][-1, 0], file["observables/wavenumber"][()]
        factor = file["observables/structure_factor_rods"][-1]
        variance = file["observables/rod_number_variance"][-1]
        sides = file["observables/box_side"][()]
    assert q == pytest.approx(2.0 * math.pi / 16.0 * np.arange(1, len(q) + 1), rel=1e-12) and len(q) >= 10
    power = np.abs(np.fft.rfft(density) / 64)**2
    assert factor == pytest.approx(32.0 * power[1:len(q) + 1], rel=1e-9, abs=1e-15)
    for n, cells in enumerate([1, 2, 3, 4]):
        segments = [np.roll(density, -start)[:cells].sum() * 16.0 / 64 * 2.0 for start in range(64)]
        assert variance[n] == pytest.approx(np.var(segments), rel=1e-9), sides
    # A uniform stretch of density has DN ~ N.
    assert report["rod_number_exponent"]["values"][0]["mean"] == pytest.approx(1.0, abs=0.01)


def test_fluctuations_of_a_one_dimensional_run_agree_with_its_linear_theory(tmp_path):
    report = run(tmp_path, base=NOISY)
    assert report["no_prediction"] == "" and report["warnings"] == []
    for name in ("structure_factor_rods", "rod_number_deviation", "structure_factor_order_along"):
        row = report["results"][name]
        assert len(row["values"]) >= 4
        sigmas = [(value["mean"] - linear) / value["error"] for value, linear in zip(row["values"], row["linear"])
                  if value["error"] and linear]
        assert len(sigmas) >= 4 and np.abs(sigmas).max() < 4.5, (name, sigmas)


def test_commands_of_theory_take_a_one_dimensional_grid(tmp_path):
    write_scene(tmp_path, base=WAVES)
    wide = {"grid.ny": 64, "grid.ly": 16.0}
    explained = drover_json(tmp_path, "explain", "flock.toml")
    assert explained["largest_mode_kept"]["y"] == 0 and explained["growth_rate"] > 0.0
    stability = drover_json(tmp_path, "stability", "flock.toml")
    write_scene(tmp_path, wide, base=WAVES)
    assert drover_json(tmp_path, "stability", "flock.toml") == stability  # |q| of the longest side and the finest cells
    write_scene(tmp_path, base=WAVES)
    drover(tmp_path, "boundary", "flock.toml", "--x", "driving.strength = 0:2", "--y", "relaxation.rate = 0:1")


def test_a_one_dimensional_run_restarts_to_the_same_bytes(tmp_path):
    run(tmp_path)
    whole = fields_of(tmp_path)
    run(tmp_path, {"time.end": 2.0})
    drover(tmp_path, "restart", "flock.h5", "-q", "--set", "time.end=4.0")
    for name, found in fields_of(tmp_path).items():
        assert np.array_equal(found, whole[name]), name


def test_a_grid_of_two_rows_or_one_column_is_rejected(tmp_path):
    write_scene(tmp_path, base=WAVES)
    for key, sentence in (("grid.ny=2", "expected"), ("grid.ny=3", "expected"), ("grid.nx=1", "along x, with ny = 1")):
        assert sentence in drover(tmp_path, "check", "flock.toml", "--set", key, status=2).stderr


@pytest.mark.parametrize("rows", [1, 4])
def test_a_figure_shows_a_thin_run(tmp_path, rows):
    run(tmp_path, {"grid.ny": rows})
    with drover_python.open_run(tmp_path / "flock.h5") as opened:
        picture = figure.draw(opened)
        numbers = results.number_fluctuations(opened)
    with h5py.File(tmp_path / "flock.h5") as file:
        side, area = file["observables/box_side"][()], 16.0 * 2.0
    assert numbers.x == pytest.approx(2.0 * area * side**2 / area, rel=1e-6)  # the side of a square of the same area
    if rows == 4:
        assert pictures.overlaps(picture) == []
    else:  # a profile of the density
        x, y = picture.axes[0].lines[0].get_data()
        assert len(x) == 64 and np.array_equal(y, fields_of(tmp_path)["rod_density"][-1, 0])


def test_a_cell_of_metres_has_noise_at_its_longest_waves(tmp_path):
    # What noise leaves to the halves of an interval is far below the variance of the densities at q = 0.0008 /mm.
    keys = ["grid.nx=16", "grid.ny=16", "grid.lx=8192.0", "grid.ly=8192.0", "time.dt=0.05", "time.end=40.0",
            "output.frame_every=0.0"]
    drover(tmp_path, "run", MODELS / "flock.toml", *settings(keys), "--output", "flock.h5")
    with h5py.File(tmp_path / "flock.h5") as file:
        order = file["polar_order_x"][-1]
    assert np.isfinite(order).all() and order.std() > 0.0


def test_segments_of_a_line_are_called_so():
    scene = drover_python.Scene.from_dict({"grid": {"nx": 32, "ny": 1, "lx": 32.0, "ly": 1.0}, "time.dt": 0.1,
                                           "time.end": 1.0, "noise.rods": 0.1, "diffusion.rods": 0.1})
    run = scene.start()
    run.advance()
    found = run.observables
    assert "segment of the line, four times as long as" in found.rod_number_variance_long_x.comment
    assert "segment of the line, as long as" in found.rod_number_variance_long_y.comment
    assert found.long_box_side.comment == "length of a segment of the line, or a quarter of it"
