"""tests/app/test_anisotropic_theory.py: linear theory of runs with terms that depend on direction, place or time."""
import re

import numpy as np
import pytest
from rejection import rejected
from support import drover, drover_json

# Order along y decays more than twice as fast as along x.
ANCHORED = """
[fields]
rod_density = false

[relaxation]
rate = 0.5

[elasticity]
stiffness = 0.5

[noise]
order = 0.1

[[terms]]
of = "order"
value = ["0", "-W order_y"]
parameters = { W = 0.7 }

[grid]
nx = 16
ny = 16
lx = 16.0
ly = 16.0

[time]
dt = 0.1
end = 1500.0

[output]
frame_every = 0.0
sample_every = 1.0

[run]
seed = 3
"""
VARYING = ANCHORED.replace('["0", "-W order_y"]', '["0", "-W cos(2 * pi * x / 16) order_y"]')


def write(folder, text):
    (folder / "anchored.toml").write_text(text)


def test_structure_factors_of_an_anisotropic_model_agree_with_their_prediction(tmp_path):
    write(tmp_path, ANCHORED)
    results = drover_json(tmp_path, "run", "anchored.toml", "-q")["results"]
    for name in ("structure_factor_order_along", "structure_factor_order_across"):
        row = results[name]
        sigmas = [(value["mean"] - linear) / value["error"] for value, linear in zip(row["values"], row["linear"])]
        assert len(sigmas) >= 5 and np.abs(sigmas).max() < 4.5, (name, sigmas)
    # At the longest waves, |q| = 2 pi/16: half of them run along x, half along y.
    rate = 0.5 + 0.5 * (2.0 * np.pi / 16)**2
    both = 0.5 * (0.1 / (2.0 * rate) + 0.1 / (2.0 * (rate + 0.7)))
    assert results["structure_factor_order_along"]["linear"][0] == pytest.approx(both, rel=0.1)  # a shell has width


def test_a_model_that_depends_on_position_has_no_prediction_and_says_why(tmp_path):
    write(tmp_path, VARYING)
    report = drover_json(tmp_path, "run", "anchored.toml", "-q", "--set", "time.end=10")
    assert re.search(r"terms\[1\] depends on position or time: there is no uniform state", report["no_prediction"])


@pytest.mark.parametrize("text, says", [
    (ANCHORED, ["terms[1] depend on direction, position or time"]),
    (VARYING, ["terms[1] depend on direction, position or time"]),
    (ANCHORED.replace("-W order_y", "W"), ["a force or a field of this model"]),
    (ANCHORED.split("[[terms]]")[0] + "[orienting_field]\nx = 0.1\n", ["a force or a field of this model"]),
])
def test_a_stationary_start_is_rejected_where_the_isotropic_theory_does_not_hold(tmp_path, text, says):
    write(tmp_path, text + '\n[initial]\nkind = "stationary"\n')
    for command in ("check", "run"):
        rejected(tmp_path, [command, "anchored.toml"], ['initial.kind = "stationary"', *says])


def test_explain_names_the_terms_that_its_growth_rate_leaves_out(tmp_path):
    write(tmp_path, ANCHORED)
    assert drover_json(tmp_path, "explain", "anchored.toml")["growth_leaves_out"] == ["terms[1]"]
    assert "the growth rate leaves out terms[1], which depend" in drover(tmp_path, "explain", "anchored.toml").stdout
    write(tmp_path, ANCHORED.replace('["0", "-W order_y"]', '["-W order_x", "-W order_y"]'))
    assert drover_json(tmp_path, "explain", "anchored.toml")["growth_leaves_out"] == []


@pytest.mark.parametrize("field, equation, growth", [
    ('{symbol = "u"}', 'u = "r u - u^3 + lap u"', 0.2),
    ('{symbol = "p", rank = "vector"}', 'p = "(r - p.p) p + lap p"', 0.2)])
def test_waves_longer_than_those_searched_grow_up_to_the_neutral_one(tmp_path, field, equation, growth):
    """The rate is r - q^2, positive below sqrt(r) = 0.447, and the search begins at 0.7."""
    (tmp_path / "s.toml").write_text(f"""
field = [{field}]
equations = {{{equation}}}
coefficients = {{r = {growth}}}
grid = {{nx = 32, ny = 32, lx = 10.0, ly = 10.0}}
time = {{dt = 0.1, end = 1.0}}
""")
    found = drover_json(tmp_path, "stability", "s.toml", "--set", "stability.min_wavenumber=0.7")
    one, = next(state["instabilities"] for state in found["states"] if state["instabilities"])
    assert (one["rate"], one["wavenumber"]) == (pytest.approx(growth, rel=1e-9), 0.0)
    assert one["grows_to"] == pytest.approx(growth**0.5, rel=1e-9)
