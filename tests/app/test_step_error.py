"""tests/app/test_step_error.py: runs tell the error of their time steps, and what to do about it."""
import json
import re

import h5py
import numpy as np
from support import drover, write_scene

QUENCH = {
    "fields.bead_density": True, "fields.bead_velocity": "dynamic", "uniform.rod_density": 1.0,
    "uniform.bead_density": 1.0, "drag.coefficient": 4.0, "driving.strength": 3.0, "stiffness.beads": 2.0,
    "viscosity.shear": 1.0, "relaxation.rate": 0.3, "relaxation.saturation": 1.0, "elasticity.stiffness": 0.5,
    "weathercock.strength": 1.5, "advection.strength": 0.5, "pressure.rods": 0.3, "diffusion.rods": 0.2,
    "diffusion.beads": 0.2, "grid.nx": 32, "grid.ny": 32, "grid.lx": 16.0, "grid.ly": 16.0, "time.dt": 0.05,
    "time.end": 4.0, "initial.kind": "formula", "initial.polar_order_x": "0.3 + 0.2 * sin(2*pi*y/16)",
    "initial.polar_order_y": "0.2 * cos(2*pi*(x + y)/16)", "output.frame_every": 4.0, "output.sample_every": 1.0,
}


def run(folder, name, **changes):
    scene = write_scene(folder, changes, name=name + ".toml", base=QUENCH)
    return json.loads(drover(folder, "run", scene, "--json", "--overwrite").stdout)


def of_dt(warnings):
    return [warning for warning in warnings if warning.startswith("time.dt")]


def test_a_long_step_is_reported_and_the_suggested_one_is_not(tmp_path):
    long = run(tmp_path, "long", **{"time.dt": 0.5})
    (warning,) = of_dt(long["warnings"])
    suggested = float(re.search(r"choose time.dt = ([0-9.e-]+)", warning)[1])
    short = run(tmp_path, "short", **{"time.dt": suggested})
    assert of_dt(short["warnings"]) == []
    with h5py.File(tmp_path / "long.h5") as file:
        assert file["observables/step_error"][-1] > 0.0
    shown = drover(tmp_path, "info", "long.h5").stdout
    assert "warning: time.dt = 0.5 is too long" in shown and "step_error" in shown


def test_the_error_is_not_estimated_where_no_limit_is_given(tmp_path):
    assert of_dt(run(tmp_path, "silent", **{"time.dt": 0.5, "time.max_error": 0.0})["warnings"]) == []
    with h5py.File(tmp_path / "silent.h5") as file:
        assert "step_error" not in file["observables"]


def test_a_tolerance_divides_a_step_that_leaves_the_domain(tmp_path):
    # One step of 4 s empties a cell of beads; it is rejected, not the end of the run.
    divided = run(tmp_path, "divided", **{"time.dt": 4.0, "time.tolerance": 1e-4, "output.sample_every": 4.0})
    fine = run(tmp_path, "fine", **{"time.dt": 0.01})
    with h5py.File(tmp_path / "divided.h5") as a, h5py.File(tmp_path / "fine.h5") as b:
        for name in ("rod_density", "polar_order_x"):
            # 1e-4 a part, and some dozens of parts.
            assert np.abs(a[name][-1] - b[name][-1]).max() < 5e-3 * np.abs(b[name][-1]).max(), name
    assert divided and fine


def test_steps_with_noise_and_a_tolerance_follow_the_path_of_short_steps(tmp_path):
    noise = {"noise.order": 1e-3, "noise.rods": 1e-4}
    run(tmp_path, "fine", **noise, **{"time.dt": 1 / 256})
    errors = []
    for tolerance in (1e-1, 1e-3):
        run(tmp_path, "divided", **noise, **{"time.dt": 1.0, "time.tolerance": tolerance})
        with h5py.File(tmp_path / "divided.h5") as a, h5py.File(tmp_path / "fine.h5") as b:
            errors.append(np.abs(a["polar_order_x"][-1] - b["polar_order_x"][-1]).max())
    # On another path the difference would be that of the noise, 0.1 at its largest.
    assert errors[1] < 0.3 * errors[0] and errors[1] < 0.01, errors


def test_the_noise_of_shared_modes_is_the_same_on_any_grid(tmp_path):
    scene = {"grid.lx": 16.0, "grid.ly": 16.0, "time.dt": 0.05, "time.end": 4.0, "initial.kind": "uniform",
             "relaxation.rate": 2.0, "relaxation.saturation": 0.0, "elasticity.stiffness": 0.5, "noise.order": 1e-2,
             "output.frame_every": 4.0, "output.sample_every": 1.0}
    modes = []
    for points in (32, 64):
        changes = {"grid.nx": points, "grid.ny": points}
        drover(tmp_path, "run", write_scene(tmp_path, changes, name="noisy.toml", base=scene), "--quiet", "--overwrite")
        with h5py.File(tmp_path / "noisy.h5") as file:
            modes.append(np.fft.fft2(file["polar_order_x"][-1])[:6, :6] / points**2)
    # A linear model: the modes do not know of each other; 1e-13 is the rounding of the transforms.
    assert np.abs(modes[1] - modes[0]).max() < 1e-13 * np.abs(modes[0]).max()
