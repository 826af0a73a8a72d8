"""tests/app/test_densities.py: densities that are negative or beyond the table of coefficients."""
import re

import h5py
import pytest
from support import SMALL, drover_json, write_scene

# Two rods in a cell of the grid, in a model that is not linear in their density.
SPARSE = {**SMALL, "current.kind": "density-order", "initial.kind": "uniform", "time.end": 20.0, "pressure.rods": 0.1,
          "current.speed": 0.5}


def warnings_of(folder, base, changes=None):
    """The warnings of a short run, without those of resolution."""
    write_scene(folder, changes, base=base)
    found = drover_json(folder, "run", "flock.toml", "-q", "--overwrite", "-o", "flock.h5")["warnings"]
    return [warning for warning in found if "resolve" not in warning]


def test_a_negative_density_in_a_nonlinear_model_warns_with_count_and_place(tmp_path):
    warning, = warnings_of(tmp_path, SPARSE)
    found = re.search(r"rod_density is negative in (\d+) samples, (\S+) mm-2 at t = (\S+) s", warning)
    with h5py.File(tmp_path / "flock.h5") as file:
        smallest, times = file["observables/min_rod_density"][()], file["observables/time"][()]
    assert int(found[1]) == (smallest < 0.0).sum() > 0
    assert float(found[2]) == pytest.approx(smallest.min(), rel=5e-3)  # three digits
    assert float(found[3]) == times[smallest.argmin()]
    assert "linear in the fields" in warning


def test_the_grid_that_such_a_warning_names_keeps_the_density_positive(tmp_path):
    large = {**SPARSE, "grid.nx": 64, "grid.ny": 64, "grid.lx": 64.0, "grid.ly": 64.0}
    warning, = warnings_of(tmp_path, large)
    nx, ny = re.search(r"grid.nx = (\d+) and grid.ny = (\d+)", warning).groups()
    assert warnings_of(tmp_path, large, {"grid.nx": int(nx), "grid.ny": int(ny)}) == []


def test_a_negative_density_is_allowed_in_a_model_that_is_linear_in_it(tmp_path):
    assert warnings_of(tmp_path, SMALL) == []
    with h5py.File(tmp_path / "flock.h5") as file:
        assert file["observables/min_rod_density"][()].min() < 0.0


def test_a_negative_density_without_noise_warns(tmp_path):
    emptied = {"relaxation.rate": 0.0, "current.speed": 1.0, "current.kind": "density-order", "diffusion.rods": 0.0,
               "grid.nx": 32, "grid.ny": 4, "grid.lx": 32.0, "grid.ly": 4.0, "time.dt": 0.02, "time.end": 40.0,
               "initial.kind": "formula", "initial.polar_order_x": "0.5*sin(2*pi*x/32)"}
    warning, = warnings_of(tmp_path, emptied)
    assert "rod_density is negative" in warning and "choose a larger diffusion.rods" in warning
    assert warnings_of(tmp_path, emptied, {"diffusion.rods": 2.0}) == []


def test_densities_beyond_a_table_that_is_held_warn(tmp_path):
    held = {"relaxation.saturation": 1.0, "table.rod_density": [0.9, 1.0, 1.1], "table.outside": "hold",
            "table.relaxation_rate": [0.0, -0.5, -1.0], "current.speed": 1.0, "time.dt": 0.05, "time.end": 20.0,
            "initial.kind": "random", "initial.amplitude": 0.01, "diffusion.rods": 0.5, "elasticity.stiffness": 0.5,
            "grid.nx": 16, "grid.ny": 16, "grid.lx": 16.0, "grid.ly": 16.0}
    below, above = warnings_of(tmp_path, held)
    for warning in (below, above):
        assert "rod_density left the table of coefficients" in warning and "wider than 0.9 to 1.1 mm-2" in warning
    wide = {"table.rod_density": [-5.0, 1.0, 9.0], "table.relaxation_rate": [0.0, -0.5, -1.0]}
    assert warnings_of(tmp_path, held, wide) == []
