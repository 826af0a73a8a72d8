"""tests/app/test_explicit.py: explicit(...), a summand of an equation of which nothing is in the exact linear part."""
import numpy as np
import pytest
from scipy.integrate import solve_ivp

from drover import Error, Field, Model

FRICTION = "mu v/sqrt(v.v + s^2)"  # of constant size, and smooth at rest: its slope there is mu/s
NUMBERS = {"G": 1.0, "mu": 0.5, "s": 1e-3}


def velocity_after(model, end=0.4, dt=0.01):
    run = model.start((4, 4), 1.0, dt=dt, method="etdrk4-krogstad").set(v_x=0.5).advance(end)
    return float(run.fields.v_x.values[0, 0])


def exact(end=0.4, drag=1.0, force=0.0, start=0.5):
    """By another method."""
    def rate(_, v):
        return force - drag * v - 0.5 * v / np.sqrt(v * v + 1e-6)

    return solve_ivp(rate, (0.0, end), [start], rtol=1e-12, atol=1e-13, method="LSODA").y[0, -1]


def test_a_summand_is_not_split_by_a_slope_that_holds_at_rest_alone():
    split, whole = (Model([Field("v", f"-G v - {term}", spin=1)], **NUMBERS) for term in (FRICTION,
                                                                                         f"explicit({FRICTION})"))
    # The method sees rates of 1/|v|: an error of (dt)^4 times a factor below 10.  Split, a slope of 500 /s decays by
    # exp(-5) in each step, and the rest must undo that.
    error = abs(velocity_after(whole) - exact())
    assert error < 1e-7 and abs(velocity_after(split) - exact()) > 1e3 * error
    for signed in (f"explicit(-G v - {FRICTION})", f"-explicit(G v + {FRICTION})"):
        assert abs(velocity_after(Model([Field("v", signed, spin=1)], **NUMBERS)) - exact()) < 1e-7
    # Theory, and the equation as it is typeset, are the same.
    q = [0.5, 2.0]
    assert np.array_equal(split.growth_rates(q).growth_rate, whole.growth_rates(q).growth_rate)
    assert split.latex.replace("- \\frac", "-\\frac") == whole.latex.replace("- \\frac", "-\\frac")


def test_a_linear_summand_may_be_explicit():
    # d_t s = -s by the method of Krogstad with an empty exact part: Runge and Kutta's, 1 + z + ... + z^4/24.
    def after_one_step(equation):
        run = Model([Field("s", equation)]).start((4, 4), 1.0, dt=0.5, method="etdrk4-krogstad").set(s=1.0)
        return float(run.advance(0.5).fields.s.values[0, 0])

    z = -0.5
    assert abs(after_one_step("explicit(-s)") - (1 + z + z**2 / 2 + z**3 / 6 + z**4 / 24)) < 1e-14  # rounding
    assert abs(after_one_step("-s") - np.exp(z)) < 1e-14


def test_the_other_forces_over_a_mass_stay_exact():
    # A drag of 1000 /s over the mass m rho = 1, in steps of 10 ms: outside the exact part it would grow by e^2 a step.
    model = Model([Field("rho", reference=2.0),
                   Field("v", f"-G v + F e_x - explicit({FRICTION})", spin=1, mass="m rho")],
                  **{**NUMBERS, "G": 1000.0, "F": 700.0, "m": 0.5})
    run = model.start((4, 4), 1.0, dt=0.01, method="etdrk4-krogstad").set(rho=2.0, v_x=0.5).advance(0.5)
    assert abs(run.fields.v_x.values[0, 0] - exact(0.5, 1000.0, 700.0)) < 1e-6


@pytest.mark.parametrize("fields, place, said", [
    ([Field("s", "-2 explicit(s)")], "s.equation:1:4", "whole summand"),
    ([Field("s", "-s"), Field("m", "s - explicit(m)", balance=True)], "m.equation:1:3", "in balance"),
    ([Field("explicit", "-explicit")], "explicit", "that of a function")])
def test_explicit_where_it_means_nothing_is_rejected(fields, place, said):
    with pytest.raises(Error) as caught:
        Model(fields)
    assert caught.value.place.startswith(place) and said in str(caught.value)


def test_explain_says_what_is_explicit_and_why():
    model = Model([Field("v", f"-v + explicit(-{FRICTION}) - v/|v| + cos(t) e_x", spin=1)], **NUMBERS)
    rows = model.scene(4, 1.0, dt=0.1, end=1.0).explain()["terms"]
    assert [row["explicit"] for row in rows] == ["", "as written", "no derivative at the references",
                                                 "depends on position or time"]


def test_a_stationary_start_needs_all_of_the_exact_part():
    with pytest.raises(Error, match="no explicit"):
        Model([Field("s", "-s - explicit(s)", noise=0.1)]).scene(8, 1.0, dt=0.1, end=1.0,
                                                                initial={"kind": "stationary"})
