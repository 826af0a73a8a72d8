"""tests/app/test_divergence.py: a run that diverges stops and names the field that failed first."""
import numpy as np
import pytest
from support import drover, drover_json, write_scene

SMALL_GRID = {"grid.nx": 32, "grid.ny": 32, "grid.lx": 16.0, "grid.ly": 16.0, "output.frame_every": 0.0}
LINEAR = {**SMALL_GRID, "relaxation.rate": -0.5, "time.dt": 0.5, "time.end": 1000.0, "output.sample_every": 10.0,
          "initial.kind": "random", "initial.amplitude": 1e-6}
# Self-advection in a step that is too long.
ADVECTED = {**SMALL_GRID, "relaxation.rate": -1.0, "relaxation.saturation": 1.0, "advection.strength": 30.0,
            "time.dt": 0.02, "time.end": 50.0, "initial.kind": "random", "initial.amplitude": 0.1,
            "output.sample_every": 0.1}
BEADS = {"fields.bead_density": True, "fields.bead_velocity": "dynamic", "drag.coefficient": 2.0,
         "driving.strength": 1.0, "stiffness.beads": 1.0, "weathercock.strength": 1.0}


def failed(folder, base, changes=None):
    """What the error message of a run says that fails."""
    write_scene(folder, changes, base=base)
    ended = drover(folder, "run", "flock.toml", "-q", status=1)
    assert ended.stdout == ""
    return ended.stderr


def test_growth_that_no_term_stops_ends_the_run_beyond_any_physical_size(tmp_path):
    message = failed(tmp_path, LINEAR)
    assert "the run diverged" in message and "polar_order" in message and "grows at 0.5 /s" in message


def test_growth_that_no_term_stops_is_predicted_before_the_run(tmp_path):
    write_scene(tmp_path, base=LINEAR)
    warning = "a mode grows at 0.5 /s at |q| = 0 /mm, by a factor e^500 in this run, and no term stops it"
    ended = drover(tmp_path, "run", "flock.toml", status=1)
    assert warning in ended.stderr and "give relaxation.saturation > 0, or choose time.end = 28 or less" in ended.stderr
    ended = drover(tmp_path, "check", "flock.toml")
    assert warning in ended.stderr
    for key in ("relaxation.saturation=1", "time.end=20"):
        assert "warning" not in drover(tmp_path, "check", "flock.toml", "--set", key).stderr


def test_growth_from_a_tiny_start_in_a_linear_model_is_no_fault(tmp_path):
    write_scene(tmp_path, {"time.end": 25.0}, base=LINEAR)  # by e^12.5
    report = drover_json(tmp_path, "run", "flock.toml", "-q")
    assert report["warnings"] == []
    growth = np.sqrt(report["results"]["variance_polar_order"]["mean"])
    assert growth > 1e3 * 1e-6


@pytest.mark.parametrize("changes", [{}, {"elasticity.stiffness": 0.1}, {"time.stepper": "etdrk4"}])
def test_a_field_that_fails_alone_is_named(tmp_path, changes):
    message = failed(tmp_path, ADVECTED, changes)
    assert "polar_order" in message and "rod_density" not in message, message


def test_a_vacuum_that_another_field_caused_is_not_blamed_on_the_beads(tmp_path):
    message = failed(tmp_path, {**ADVECTED, **BEADS, "elasticity.stiffness": 0.1, "relaxation.saturation": 0.0})
    assert message.startswith("error: polar_order became unstable: in step "), message
    assert "choose time.dt = 0.01 or smaller" in message and "the bead density reached -" in message


OWN = """
[[field]]
symbol = "rho"
name = "density"
conserved = true
reference = 1.0
[[field]]
symbol = "p"
name = "polarity"
rank = "vector"
[equations]
rho = "-div p + 0.1 lap rho"
p = "a p - b |p|^2 p - w p.grad p + 0.1 lap p - grad rho"
[coefficients]
a = 0.5
b = 0.0
w = 0.0
[grid]
nx = 32
ny = 32
lx = 16.0
ly = 16.0
[time]
dt = 0.5
end = 1000.0
stepper = "etdrk2"
max_error = 0.0
[initial]
kind = "random"
amplitude = 1e-6
[output]
frame_every = 0.0
sample_every = 10.0
"""


def own_failed(folder, *settings):
    (folder / "own.toml").write_text(OWN)
    words = [word for setting in settings for word in ("--set", setting)]
    ended = drover(folder, "run", "own.toml", "-q", *words, status=1)
    assert ended.stdout == ""
    return ended.stderr


def test_growth_that_no_term_of_an_own_model_stops_ends_the_run_beyond_the_size_of_its_fields(tmp_path):
    message = own_failed(tmp_path)
    assert "the run diverged" in message and "the root mean square of density" in message
    assert "expected at most 1e+06 times its size in this model, 1;" in message
    assert "a linear mode grows at 0.5 /s (|q| = 0 /mm) and no term of the equations stops it (coefficients.b = 0)" \
        in message


def test_a_step_that_is_too_long_for_an_own_model_is_told_with_the_term_that_would_limit_the_field(tmp_path):
    message = own_failed(tmp_path, "coefficients.a=1", "coefficients.b=1", "coefficients.w=30", "time.dt=0.05",
                         "output.sample_every=0.1", "initial.amplitude=0.1")
    assert "coefficients.b does not stop it, or the time step is too long" in message
    assert "choose time.dt = 0.025" in message
