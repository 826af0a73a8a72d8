"""tests/app/test_kinks.py: texts without a derivative where their fields vanish, such as |p| p and p/|p|."""
import json
import math

import h5py
import pytest
from rejection import rejected
from scipy.integrate import solve_ivp
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
    assert explained["growth_rate"] == pytest.approx(-0.7, rel=1e-12)  # rounding of one eigenvalue
    assert "the slowest mode decays" in drover(tmp_path, "explain", scene).stdout
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
    assert "no derivative at the references" in explained and "leaves out terms[1]" in explained
    assert "valid" in drover(tmp_path, "check", scene).stdout
    rejected(tmp_path, ["stability", scene], ['"terms[1]" has no finite derivative'])


def test_a_run_from_a_state_where_a_text_is_not_finite_names_the_text(tmp_path):
    failed = drover(tmp_path, "run", write(tmp_path, f"P/{SIZE}", initial='kind = "uniform"'), "--quiet", status=1)
    assert f"order_x/{SIZE}" in failed.stderr and "is not finite" in failed.stderr


# A friction of constant size that is smooth at rest, over s = 1e-3: its slope there is W/s = 500 /s.
FRICTION = "-W P/sqrt(order_x^2 + order_y^2 + 1e-6)"


def friction_scene(folder, more=""):
    scene = folder / write(folder, FRICTION)
    scene.write_text(scene.read_text().replace("[grid]", f"{more}\nparameters = {{ W = 0.5 }}\n[grid]"))
    return ["kink.toml", "--set", "time.end=0.4", "--set", "output.frame_every=0.4", "--set", "output.sample_every=0.4"]


def slowed(rate, friction, start, end):
    """|p| of d_t |p| = -rate |p| - friction |p|/sqrt(|p|^2 + s^2), by a method of its own."""
    found = solve_ivp(lambda t, p: -rate * p - friction * p / (p * p + 1e-6) ** 0.5, (0.0, end), [start], rtol=1e-12,
                      atol=1e-13)
    return found.y[0, -1]


def test_an_explicit_text_is_not_split_by_a_slope_that_holds_at_rest_alone(tmp_path):
    exact = slowed(1.0, 0.5, 0.5, 0.4)
    errors = []
    for more in ("", "explicit = true"):
        drover(tmp_path, "run", *friction_scene(tmp_path, more), "--quiet", "--overwrite", status=None)
        with h5py.File(tmp_path / "kink.h5") as file:
            errors.append(abs(math.hypot(file["polar_order_x"][-1][0, 0], file["polar_order_y"][-1][0, 0]) - exact))
    # With the term whole the method sees rates of 1/|p|, so that it has an error of (dt)^4 times a factor below 10;
    # with the slope at rest it decays by exp(-5) in each step, and the rest must undo that.
    assert errors[1] < 1e-7 and errors[0] > 1e3 * errors[1]


def test_an_explicit_text_is_called_so_and_kept(tmp_path):
    arguments = friction_scene(tmp_path, "explicit = true")
    explained = drover(tmp_path, "explain", *arguments).stdout
    assert "  as written\n" in explained and "leaves out terms[1]" in explained
    # Theory has its slope all the same: it says nothing else of the scene.
    without = drover(tmp_path, "stability", *friction_scene(tmp_path)).stdout
    assert drover(tmp_path, "stability", *friction_scene(tmp_path, "explicit = true")).stdout == without
    (tmp_path / "resolved.toml").write_text(drover(tmp_path, "check", *arguments, "--resolved").stdout)
    assert "  as written\n" in drover(tmp_path, "explain", "resolved.toml").stdout
    pytest.importorskip("drover._drover", reason="sanitizers have no Python module")
    from drover import Scene  # pylint: disable=import-outside-toplevel
    more = Scene.load(tmp_path / "kink.toml").term("order", ["-order_x", "-order_y"], explicit=True)
    assert [term["explicit"] for term in more.values["terms"]] == [True, True]
    wrong = friction_scene(tmp_path, "explicit = 1")
    rejected(tmp_path, ["explain", *wrong], ["terms[1].explicit = 1", "true or false"])
