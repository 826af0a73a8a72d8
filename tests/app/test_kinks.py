"""tests/app/test_kinks.py: texts without a derivative where their fields vanish, such as |p| p and p/|p|."""
import json
import math

import h5py
import pytest
from rejection import rejected
from support import drover, drover_json

SCENE = """
[fields]
rod_density = false
[relaxation]
rate = {rate}
saturation = 1.0
[elasticity]
stiffness = 1.0
[[terms]]
of = "order"
value = ["{x}", "{y}"]
[grid]
nx = 16
ny = 4
lx = 16.0
ly = 4.0
[time]
dt = 0.01
end = 4.0
stepper = "etdrk4-krogstad"
[initial]
{initial}
[output]
frame_every = 4.0
sample_every = 0.5
"""
SIZE = "sqrt(order_x^2 + order_y^2)"
TILTED = 'kind = "formula"\npolar_order_x = "0.4"\npolar_order_y = "0.3"'
WAVE = 'kind = "formula"\npolar_order_x = "0.3*sin(2*pi*x/16)"'  # it vanishes at two points


def write(folder, text, rate=1.0, initial=TILTED, saturation=0.0):
    scene = SCENE.format(rate=rate, initial=initial, x=text.replace("P", "order_x"), y=text.replace("P", "order_y"))
    (folder / "kink.toml").write_text(scene.replace("saturation = 1.0", f"saturation = {saturation}"))
    return "kink.toml"


def end_of(folder):
    with h5py.File(folder / "kink.h5") as file:
        return file["polar_order_x"][-1], file["polar_order_y"][-1]


@pytest.mark.parametrize("text, exact", [
    # dp/dt = -p - |p| p: 1/|p| + 1 grows as exp(t).  dp/dt = -p + p/|p|: |p| - 1 decays as exp(-t).
    (f"-{SIZE} P", lambda t: 1.0 / (3.0 * math.exp(t) - 1.0)), (f"P/{SIZE}", lambda t: 1.0 - 0.5 * math.exp(-t))])
def test_the_order_follows_the_exact_solution(tmp_path, text, exact):
    drover(tmp_path, "run", write(tmp_path, text), "--quiet")
    x, y = end_of(tmp_path)
    size = exact(4.0)
    # The method has an error of (dt)^4: 1e-8 times a factor below 10.
    assert abs(x - 0.8 * size).max() < 1e-7 * size and abs(y - 0.6 * size).max() < 1e-7 * size


def test_quadratic_damping_has_no_part_in_the_linear_theory_of_the_state_at_rest(tmp_path):
    scene = write(tmp_path, f"-{SIZE} P", rate=0.7, saturation=1.0)
    explained = drover_json(tmp_path, "explain", scene)
    assert explained["growth_leaves_out"] == []
    assert "decays at 0.7 /s" in drover(tmp_path, "explain", scene).stdout
    # Of the flock: 1 = |p| + |p|^2, and a longitudinal rate of -(|p| + 2 |p|^2).
    found = drover_json(tmp_path, "stability", write(tmp_path, f"-{SIZE} P", rate=-1.0, saturation=1.0))
    flock = json.dumps(found)
    assert f"{(math.sqrt(5.0) - 1.0) / 2.0:.6f}"[:6] in flock


def test_a_wave_that_vanishes_somewhere_runs_with_quadratic_damping(tmp_path):
    result = drover_json(tmp_path, "run", write(tmp_path, f"-{SIZE} P", initial=WAVE), "--quiet")
    assert 0.0 < result["results"]["variance_polar_order"]["mean"] < 0.045


def test_a_text_without_a_derivative_is_explicit_and_called_so(tmp_path):
    scene = write(tmp_path, f"P/{SIZE}")
    explained = drover(tmp_path, "explain", scene).stdout
    assert "explicit: it has no derivative" in explained and "leaves out terms[1]" in explained
    assert "valid" in drover(tmp_path, "check", scene).stdout
    rejected(tmp_path, ["stability", scene], ["terms[1] has no finite derivative", "|p| = 0"])


def test_a_run_from_a_state_where_a_text_is_not_finite_names_the_text(tmp_path):
    failed = drover(tmp_path, "run", write(tmp_path, f"P/{SIZE}", initial='kind = "uniform"'), "--quiet", status=1)
    assert f"order_x/{SIZE}" in failed.stderr and "is not finite" in failed.stderr
