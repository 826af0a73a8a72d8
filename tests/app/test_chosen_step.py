"""tests/app/test_chosen_step.py: scenes that leave time.dt out."""
import json
import re
import tomllib

import h5py
import numpy as np
import pytest
from rejection import rejected
from support import drover, write_scene

FLOCK = {
    "fields.bead_density": True, "fields.bead_velocity": "dynamic", "uniform.rod_density": 1.0,
    "uniform.bead_density": 1.0, "drag.coefficient": 4.0, "driving.strength": 3.0, "stiffness.beads": 2.0,
    "viscosity.shear": 1.0, "relaxation.rate": 0.3, "relaxation.saturation": 1.0, "elasticity.stiffness": 0.5,
    "weathercock.strength": 1.5, "advection.strength": 0.5, "pressure.rods": 0.3, "diffusion.rods": 0.2,
    "diffusion.beads": 0.2, "grid.nx": 32, "grid.ny": 32, "grid.lx": 16.0, "grid.ly": 16.0,
    "time.end": 4.0, "output.frame_every": 4.0, "output.sample_every": 1.0,
}
SMOOTH = {"initial.kind": "formula", "initial.polar_order_x": "0.3 + 0.2 * sin(2*pi*y/16)",
          "initial.polar_order_y": "0.2 * cos(2*pi*(x + y)/16)"}

LATE = {"uniform.rod_density": 1.0, "relaxation.rate": -0.1, "relaxation.saturation": 1.0,
        "elasticity.stiffness": 0.5, "advection.strength": 0.5, "initial.kind": "random",
        "time.stepper": "exponential-euler",
        "initial.amplitude": 1e-4, "grid.nx": 32, "grid.ny": 32, "grid.lx": 16.0, "grid.ly": 16.0,
        "time.end": 200.0, "output.sample_every": 1.0, "output.frame_every": 200.0}


def run(folder, name, base=FLOCK, **changes):
    scene = write_scene(folder, changes, name=name + ".toml", base=base)
    return json.loads(drover(folder, "run", scene, "--json", "--overwrite").stdout)


def time_table(archive):
    with h5py.File(archive) as file:
        return tomllib.loads(file.attrs["scene"].decode())["time"]


def error_of(archive, exact, vector):
    """The relative error of a field in the last frame."""
    with h5py.File(archive) as a, h5py.File(exact) as b:
        wrong = sum(((a[name][-1] - b[name][-1]) ** 2).sum() for name in vector)
        return np.sqrt(wrong / sum((b[name][-1] ** 2).sum() for name in vector))


@pytest.mark.parametrize("max_error", [0.1, 0.01, 1e-4])
def test_the_fields_of_a_run_without_a_step_have_the_error_that_is_asked_for(tmp_path, max_error):
    result = run(tmp_path, "chosen", **SMOOTH, **{"time.max_error": max_error})
    chosen = time_table(tmp_path / "chosen.h5")
    assert chosen["chosen"] == "fields" and chosen["dt"] > 0.0 and "pilot run" in chosen["pilot"]
    assert chosen["stepper"] == "etdrk4-krogstad"  # the method is left out too
    run(tmp_path, "fine", **SMOOTH, **{"time.dt": chosen["dt"] / 16, "time.stepper": "etdrk4-krogstad"})
    for field in (["rod_density"], ["polar_order_x", "polar_order_y"], ["bead_velocity_x", "bead_velocity_y"]):
        # A step is chosen for 0.4 of the error, by an estimate that is right within a factor of three.
        assert error_of(tmp_path / "chosen.h5", tmp_path / "fine.h5", field) < 1.5 * max_error, field
    assert not [warning for warning in result["warnings"] if "time.dt" in warning]


def test_a_run_of_a_sweep_chooses_step_and_method_as_it_does_alone_and_the_sweep_resumes(tmp_path):
    run(tmp_path, "alone", **SMOOTH)
    words = ("sweep", "alone.toml", "--vary", "relaxation.rate = 0.3, 0.4", "-o", "both", "--quiet")
    drover(tmp_path, *words)
    drover(tmp_path, *words)  # all runs are there, and are those of this scene
    assert time_table(tmp_path / "both" / "point-0000-seed-1.h5") == time_table(tmp_path / "alone.h5")


OSCILLATION = """model = {name = "oscillation"}
field = [{symbol = "X"}, {symbol = "Y"}]
grid = {nx = 8, ny = 8, lx = 8.0, ly = 8.0}
initial = {kind = "formula", X = "1"}
[equations]
X = "X - (X^2 + Y^2) (X + Y) + lap X"
Y = "Y - (X^2 + Y^2) (Y - X) + lap Y"
"""
# A cubic field, and one with noise that multiplies it, whose steps are of first weak order.
NOISY = """model = {name = "height"}
field = [{symbol = "h"}]
white_noise = [{symbol = "xi"}]
grid = {nx = 8, ny = 8, lx = 16.0, ly = 16.0}
time = {end = 400.0, max_error = 0.05}
initial = {kind = "formula", h = "1"}
output = {frame_every = 0.0, sample_every = 0.5}
analysis = {warm_up = 50.0}
[equations]
"""


@pytest.mark.parametrize("max_error", [0.1, 1e-3])
def test_a_model_of_ones_own_without_a_step_has_the_error_that_is_asked_for(max_error, tmp_path):
    (tmp_path / "own.toml").write_text(OSCILLATION)
    drover(tmp_path, "run", "own.toml", "-q", "--set", "time.end=30.0", "--set", f"time.max_error={max_error}",
           "--set", "output.frame_every=1.0", "--set", "output.sample_every=0.5", "-o", "own.h5")
    chosen = time_table(tmp_path / "own.h5")
    assert chosen["chosen"] == "fields" and chosen["stepper"] == "etdrk4-krogstad" and 0.0 < chosen["dt"] <= 0.5
    with h5py.File(tmp_path / "own.h5") as file:
        wave = np.exp(1j * file["time"][:])  # X + i Y, exactly
        wrong = np.abs(file["X"][:].mean(axis=(1, 2)) - wave.real).max() / np.std(wave.real)
    # A step is chosen for 0.4 of the error, by an estimate that is right within a factor of three.
    assert 0.0 < wrong < 1.5 * max_error


# d_t u at one point, the end of the run, the start, and u at the end: fields that diverge soon after it, and a pulse
# that is shorter than any step, beyond the end of the pilots.
SUDDEN = {"square": ("u^2 + lap u", 9.9, 0.1, 10.0), "exponential": ("exp(u)/20 + lap u", 19.9, 0.0, -np.log(0.005)),
          "pulse": ("-0.1 u + exp(-((t - 83.777)/0.01)^2)/0.01", 100.0, 0.0, np.sqrt(np.pi) * np.exp(-1.6223))}


@pytest.mark.parametrize("name", SUDDEN)
def test_what_happens_within_few_steps_is_seen(tmp_path, name):
    equation, end, start, exact = SUDDEN[name]
    (tmp_path / "sudden.toml").write_text(f"""
field = [{{symbol = "u"}}]
equations = {{u = "{equation}"}}
grid = {{nx = 4, ny = 1, lx = 1.0, ly = 1.0}}
time = {{end = {end}}}
initial = {{kind = "formula", u = "{start}"}}
output = {{frame_every = 0.0, sample_every = 0.0}}
""")
    drover(tmp_path, "run", "sudden.toml", "--quiet", "--output", "sudden.h5")
    with h5py.File(tmp_path / "sudden.h5") as file:
        assert abs(file["u"][-1].mean() / exact - 1.0) < 0.01  # time.max_error


def test_a_step_is_foreseen_by_a_pilot_with_twice_the_step(tmp_path):
    (tmp_path / "own.toml").write_text(OSCILLATION)
    foreseen = 0
    for max_error in (0.05, 0.025, 0.0125, 0.006):  # a step of fourth order is halved once over a factor of 16
        said = drover(tmp_path, "run", "own.toml", "--overwrite", "--set", "time.end=30.0", "--set",
                      f"time.max_error={max_error}", "--set", "output.frame_every=1.0", "--set",
                      "output.sample_every=0.5", "-o", "own.h5").stderr
        chosen = time_table(tmp_path / "own.h5")
        found = re.search(r"step_error ([0-9.e-]+) with dt = ([0-9.]+) s", chosen["pilot"])
        if found:
            foreseen += 1
            assert float(found[2]) == 2.0 * chosen["dt"] and 0.39 * max_error < float(found[1]) < 3.3 * max_error
        assert "doing so now" not in said
        with h5py.File(tmp_path / "own.h5") as file:
            wave = np.exp(1j * file["time"][:])
            wrong = np.abs(file["X"][:].mean(axis=(1, 2)) - wave.real).max() / np.std(wave.real)
        assert wrong < 1.5 * max_error
    assert foreseen > 0


@pytest.mark.parametrize("equation", ["h - h^3 + lap h + 0.6 xi", "h - h^2 + lap h + 0.4 h xi"])
def test_a_noisy_model_of_ones_own_without_a_step_has_means_with_a_small_bias(equation, tmp_path):
    (tmp_path / "own.toml").write_text(NOISY + f'h = "{equation}"\n')
    drover(tmp_path, "run", "own.toml", "-q", "-o", "own.h5")
    chosen = time_table(tmp_path / "own.h5")
    assert chosen["chosen"] == "means" and "bias of" in chosen["pilot"]
    drover(tmp_path, "run", "own.toml", "-q", "-o", "fine.h5", "--set", f"time.dt={chosen['dt'] / 4}",
           "--set", f"time.stepper={chosen['stepper']}")
    with h5py.File(tmp_path / "own.h5") as a, h5py.File(tmp_path / "fine.h5") as b:
        mean, exact = (np.mean(file["observables/variance_h"][100:]) for file in (a, b))
    # Both runs are on one noise path, so that their difference is the bias; twice the limit for its scatter.
    assert abs(mean - exact) < 2 * 0.05 * exact


def test_a_larger_error_is_given_a_longer_step(tmp_path):
    steps = []
    for max_error in (0.1, 1e-4):
        run(tmp_path, "run", **SMOOTH, **{"time.max_error": max_error, "time.stepper": "etdrk2"})
        steps.append(time_table(tmp_path / "run.h5")["dt"])
    assert steps[0] >= 4.0 * steps[1]  # second order: a thousandth of the error takes a thirtieth of the step


def test_a_noisy_run_without_a_step_has_means_with_a_small_bias(tmp_path):
    noisy = {"noise.order": 0.02, "noise.rods": 0.01, "time.end": 100.0, "output.frame_every": 0.0,
             "output.sample_every": 0.5, "time.max_error": 0.02}
    run(tmp_path, "chosen", **noisy)
    chosen = time_table(tmp_path / "chosen.h5")
    assert chosen["chosen"] == "means" and "+-" in chosen["pilot"]
    run(tmp_path, "fine", **noisy, **{"time.dt": chosen["dt"] / 8})
    with h5py.File(tmp_path / "chosen.h5") as a, h5py.File(tmp_path / "fine.h5") as b:
        for name in ("polar_order", "variance_rod_density", "bead_speed"):
            mean, exact = (np.mean(file["observables"][name][50:]) for file in (a, b))
            # Both runs are on one noise path, so that their difference is the bias; twice the limit for its scatter.
            assert abs(mean - exact) < 2 * 0.02 * abs(exact), name


def test_a_linear_model_has_the_longest_step(tmp_path):
    linear = {"uniform.rod_density": 2.0, "relaxation.rate": 0.5, "elasticity.stiffness": 2.0, "noise.order": 0.05,
              "grid.nx": 16, "grid.ny": 16, "grid.lx": 16.0, "grid.ly": 16.0, "time.end": 3.0,
              "output.frame_every": 1.5, "output.sample_every": 0.6}
    run(tmp_path, "linear", base=linear)
    chosen = time_table(tmp_path / "linear.h5")
    assert chosen["chosen"] == "linear" and abs(chosen["dt"] - 0.3) < 1e-12  # the common divisor of 3, 1.5 and 0.6


def test_a_run_whose_pilot_saw_too_little_starts_again_with_a_shorter_step(tmp_path):
    # The pilot of a grid that cannot be coarsened ends at 64 s, while the linear terms, which are exact, still decide.
    scene = write_scene(tmp_path, LATE, name="late.toml", base={})
    done = drover(tmp_path, "run", scene)
    assert "doing so now" in done.stderr
    with h5py.File(tmp_path / "late.h5") as file:
        assert file["observables/step_error"][...].max() <= 0.01
        assert file["time"][-1] == 200.0


def test_a_restart_keeps_the_chosen_step(tmp_path):
    run(tmp_path, "run", **SMOOTH)
    before = time_table(tmp_path / "run.h5")
    drover(tmp_path, "restart", "run.h5", "--set", "time.end=8.0")
    assert time_table(tmp_path / "run.h5") == {**before, "end": 8.0}


def test_check_and_explain_take_a_scene_without_a_step(tmp_path):
    scene = write_scene(tmp_path, SMOOTH, name="scene.toml", base=FLOCK)
    assert "valid" in drover(tmp_path, "check", scene).stdout
    assert json.loads(drover(tmp_path, "explain", scene, "--json").stdout)["steps"] > 0


def test_durations_without_a_common_step_are_rejected(tmp_path):
    scene = write_scene(tmp_path, {"time.end": 3.14159265358979}, name="scene.toml", base=FLOCK)
    rejected(tmp_path, ["run", scene], ["time.end", "3.14159", "common divisor"])


def test_a_start_that_a_coarse_pilot_would_lose_has_a_pilot_on_all_points(tmp_path):
    fine = {**SMOOTH, "grid.nx": 128, "grid.ny": 8, "initial.polar_order_x": "0.3 + 0.2*sin(2*pi*14*x/16)",
            "time.max_error": 0.05}
    run(tmp_path, "fine", **fine)
    # The pilot of 32 points keeps 10 modes, that of 64 points 21.
    assert "of 64 by 8 points" in time_table(tmp_path / "fine.h5")["pilot"]


@pytest.mark.slow
def test_a_run_that_no_chosen_step_brings_to_the_limit_ends_with_a_remedy(tmp_path):
    # A pilot to 64 s sees linear terms alone; the method, of first order, would then need steps of 1e-5 s.
    scene = write_scene(tmp_path, {**LATE, "time.max_error": 1e-5}, name="late.toml", base={})
    failed = drover(tmp_path, "run", scene, status=1)
    assert re.search(r"\d halvings of the step did not suffice.*give time.dt", failed.stderr)


DEMIX = """field = [{symbol = "phi", conserved = true}]
grid = {nx = 32, ny = 1, lx = 48.0, ly = 1.0}
time = {end = 1.0}
initial = {kind = "random", amplitude = 1.5}
equations = {phi = "div((1 - phi^2) grad mu)"}
define = {mu = "phi^3 - phi - kappa lap phi"}
coefficients = {kappa = 0.05}
"""
# The explicit decay is too fast for the chosen step only after the pilot has ended, at a quarter of the run.
HARDER = """field = [{symbol = "h", noise = 0.01}]
grid = {nx = 16, ny = 16, lx = 16.0, ly = 16.0}
time = {end = 100.0, max_error = 1.0}
initial = {kind = "random", amplitude = 0.05}
output = {frame_every = 10.0, sample_every = 0.5}
equations = {h = "lap h - (1 + 0.1 t) h"}
"""


def test_where_no_step_is_found_on_a_grid_that_is_too_coarse_the_message_names_the_grid(tmp_path):
    (tmp_path / "demix.toml").write_text(DEMIX)
    failed = drover(tmp_path, "run", "demix.toml", status=1)
    assert re.search(r"no time step was found.*of the variance of phi is in the shortest waves of the grid: choose "
                     r"grid.nx = 64[;,]", failed.stderr), failed.stderr


def test_a_run_that_fails_with_its_chosen_step_starts_again_with_a_shorter_one(tmp_path):
    (tmp_path / "harder.toml").write_text(HARDER)
    said = drover(tmp_path, "run", "harder.toml", "-o", "harder.h5").stderr
    dt = [float(one) for one in re.findall(r"steps of dt = (\S+) s", said)]
    assert len(dt) >= 2 and "doing so now" in said, said
    assert "is too long: its estimated error" not in said  # fields that may part are no reason to warn
    with h5py.File(tmp_path / "harder.h5") as file:
        assert file["time"][-1] == 100.0 and time_table(tmp_path / "harder.h5")["dt"] == dt[-1] <= dt[0] / 2


def test_a_start_from_another_grid_is_told_once_and_not_by_each_pilot_run(tmp_path):
    write_scene(tmp_path, SMOOTH, name="first.toml", base={**FLOCK, "time.dt": 0.1, "time.end": 0.5})
    drover(tmp_path, "run", "first.toml", "-o", "first.h5")
    start = {"initial.kind": "file", "initial.file": "first.h5", "grid.nx": 64}
    write_scene(tmp_path, start, name="finer.toml", base={**FLOCK, "time.end": 1.0})
    said = drover(tmp_path, "run", "finer.toml", "-o", "finer.h5").stderr
    assert "pilot run" in said and said.count("by their Fourier modes") == 1, said
