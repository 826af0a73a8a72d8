"""tests/app/test_complex.py: complex fields as two scalars, and coefficients that are tables of fields."""
import numpy as np
import pytest
from support import drover as program

import drover
from drover import Error, Field, Model, Table

SIDE, POINTS = 2 * np.pi, 16


def test_a_complex_field_is_the_two_scalars_of_its_parts():
    numbers = dict(b=2.0, c=-1.0)
    one = Model([Field("A", "A + (1 + i b) lap A - (1 + i c) |A|^2 A", complex=True)], **numbers)
    two = Model([Field("X", "X + lap X - b lap Y - (X^2 + Y^2) (X - c Y)"),
                 Field("Y", "Y + lap Y + b lap X - (X^2 + Y^2) (Y + c X)")], **numbers)
    assert one.components == ("A_re", "A_im") and one.latex.count(r"\partial_t") == 1
    start = np.random.default_rng(1).normal(size=(2, POINTS, POINTS))
    a = one.start(POINTS, SIDE, dt=0.05).set(A_re=start[0], A_im=start[1]).advance(2.0).fields
    b = two.start(POINTS, SIDE, dt=0.05).set(X=start[0], Y=start[1]).advance(2.0).fields
    for part, other in (("A_re", "X"), ("A_im", "Y")):
        assert np.abs(a[part].values - b[other].values).max() < 1e-12  # rounding of 40 steps of fields of size 1
    waves = [model.growth_rates([0.3, 1.0], state=state) for model, state in
             ((one, one.state(A=1.0 + 0.0j)), (two, two.state(X=1.0)))]
    assert waves[0].growth_rate.values == pytest.approx(waves[1].growth_rate.values, abs=1e-13)
    # A uniform oscillation of size 1 has the frequency c.
    rate = one.rates(one.state(A=0.6 + 0.8j))
    assert complex(*rate) == pytest.approx(-1j * numbers["c"] * (0.6 + 0.8j), abs=1e-15)


@pytest.mark.parametrize("equation, value", [
    ("i A", lambda a, u: 1j * a),
    ("A^3 - A^(-2)", lambda a, u: a**3 - a**-2),
    ("conj(A)^2 + 2 A / (A + 3 i)", lambda a, u: np.conj(a)**2 + 2 * a / (a + 3j)),
    ("re(A) im(A^2) - i |A|", lambda a, u: a.real * (a * a).imag - 1j * abs(a)),
    ("exp(re(A)) (1 - 2 i) u A", lambda a, u: np.exp(a.real) * (1 - 2j) * u * a),
    ("-(u - i) (A - conj(A)) / u", lambda a, u: -(u - 1j) * (a - np.conj(a)) / u),
    ("mu A + re(u)", lambda a, u: (a * np.conj(a) + 1j * u) * a + u),
])
def test_formulas_of_complex_fields_have_the_values_of_complex_numbers(equation, value):
    model = Model([Field("A", equation, complex=True), Field("u", "0 u")], define={"mu": "A conj(A) + i u"})
    for a, u in ((0.3 + 0.7j, 1.3), (-1.1 + 0.2j, 0.4)):
        found = model.rates(model.state(A=a, u=u))
        assert complex(found[0], found[1]) == pytest.approx(value(a, u), rel=1e-14)


def test_derivatives_of_complex_fields_are_those_of_waves():
    # A = exp(i x): grad A.grad conj(A) = 1, lap A = -A, and their products are exact on the grid.
    x = np.arange(POINTS) * SIDE / POINTS
    wave = np.broadcast_to(np.exp(1j * x), (POINTS, POINTS))
    model = Model([Field("A", "i (grad A).(grad conj(A)) + div(A grad A)", complex=True)])
    run = model.start(POINTS, SIDE, dt=1e-4).set(A_re=wave.real, A_im=wave.imag).advance(1e-4).fields
    found = (run.A_re.values + 1j * run.A_im.values - wave) / 1e-4
    # div(A grad A) = lap(A^2)/2 = -2 exp(2 i x); of a step of 1e-4 the first order is left.
    assert np.abs(found - (1j - 2 * wave**2)).max() < 1e-2


@pytest.mark.parametrize("field, says", [
    (Field("A", "A", complex=True, spin=1), "expected spin 0"),
    (Field("u", "A"), "this is complex; expected a real value"),
    (Field("u", "exp(A)"), "u.equation:1:5: the expression \"exp(A)\" at character 5: the argument is complex"),
    (Field("u", "re(A^0.5)"), "a power of a complex value"),
    (Field("u", "re(A) + j"), "j"),
])
def test_what_is_not_real_is_rejected_at_its_column(field, says):
    fields = [field] if field.complex else [Field("A", "-A", complex=True), field]
    with pytest.raises(Error) as error:
        Model(fields)
    assert says in str(error.value)


def test_i_is_a_name_like_others_without_complex_fields():
    assert Model([Field("u", "-i u")], i=2.0).growth_rates([1.0]).growth_rate.values == -2.0
    with pytest.raises(Error):
        Model([Field("u", "-i u")])


@pytest.mark.parametrize("numbers", [{"i": 3.0}, {"conj": 1.0}])
def test_the_names_of_complex_notation_are_not_names_of_numbers_beside_complex_fields(numbers):
    with pytest.raises(Error, match="is that of a function, an operator or a constant"):
        Model([Field("A", "A", complex=True)], **numbers)


SCENE = """
field = [{symbol = "A", name = "amplitude", rank = "complex", noise = 0.01}]
equations = {A = "r A + (1 + i b) lap A - (1 + i c) |A|^2 A"}
coefficients = {r = 0.5, b = 0.3, c = 0.2}
grid = {nx = 16, ny = 16, lx = 16.0, ly = 16.0}
time = {dt = 0.1, end = 2.0}
initial = {kind = "formula", amplitude_re = "0.1 cos(2 pi x / lx)", amplitude_im = "0.1 sin(2 pi x / lx)"}
output = {frame_every = 1.0, sample_every = 0.5}
"""


def test_a_scene_with_a_complex_field_works_in_every_command(tmp_path):
    (tmp_path / "gl.toml").write_text(SCENE)
    plane = ["boundary", "--x", "r = -1:1", "--y", "c = -2:2", "--set", "boundary.map=0", "boundary.cells=8"]
    varied = ["sweep", "--set", 'sweep.vary=["coefficients.r = 0.4, 0.6"]']
    for words in (["check"], ["explain"], ["run"], ["stability"], plane, varied):
        program(tmp_path, words[0], "gl.toml", *words[1:])
    program(tmp_path, "restart", "gl.h5", "--set", "time.end=3")
    with drover.open_run(tmp_path / "gl.h5") as run:
        assert {"amplitude_re", "amplitude_im"} <= set(run.frames.data_vars)
        assert "mean_amplitude_re" in run.observables
        drover.plot.figure(run)
    model = drover.Scene.load(tmp_path / "gl.toml").model
    assert model.fields[0].complex and model.noise_strengths == [0.01, 0.01]
    again = model.scene(points=16, side=16.0, dt=0.1, end=1.0)
    assert again.model.latex == model.latex and again["field[1].rank"] == "complex"


# --- tables

def test_a_table_acts_as_the_function_through_its_values():
    # A cubic spline through a straight line is that line: growth, and a run, as with the formula.
    nodes = np.linspace(-1.0, 3.0, 9)
    table = Model([Field("n", "-a n + lap n", reference=1.0)], tables=[Table("a", "n", nodes, 0.5 + 2 * nodes)])
    formula = Model([Field("n", "-(0.5 + 2 n) n + lap n", reference=1.0)])
    assert table.growth_rates([0.0, 2.0]).growth_rate.values == pytest.approx(
        formula.growth_rates([0.0, 2.0]).growth_rate.values, rel=1e-12)
    start = 1 + 0.5 * np.cos(np.arange(POINTS) * SIDE / POINTS)[None, :] * np.ones((POINTS, 1))
    ends = [model.start(POINTS, SIDE, dt=0.02).set(n=start).advance(1.0).fields.n.values for model in (table, formula)]
    assert np.abs(ends[0] - ends[1]).max() < 1e-12


def test_a_table_of_two_densities_is_bilinear_on_a_mesh_of_two_by_two():
    table = Table("a", ("n", "m + 1"), (0.0, 2.0), [[1.0, 2.0], [3.0, 6.0]], second=(0.0, 4.0))
    model = Model([Field("n", "a", reference=1.0), Field("m", "0 m", reference=1.0)], tables=[table])
    for n, m in ((0.0, -1.0), (2.0, 3.0), (0.5, 0.2)):
        x, y = n / 2, (m + 1) / 4
        expected = (1 - x) * ((1 - y) * 1 + y * 2) + x * ((1 - y) * 3 + y * 6)
        assert model.rates(model.state(n=n, m=m))[0] == pytest.approx(expected, rel=1e-14)


@pytest.mark.parametrize("table, says", [
    (dict(values=[[1.0, 2.0, 3.0], [4.0, 5.0, 6.0]], second=(0.0, 1.0)), "expected (3, 2)"),
    (dict(values=(1.0, 2.0, 3.0), outside="clamp"), "expected refuse or hold"),
    (dict(first=(1.0,), values=(2.0,)), "one number along an axis"),
])
def test_a_table_that_cannot_be_is_rejected(table, says):
    given = {"first": (0.0, 1.0, 2.0), **table}
    with pytest.raises(Error) as error:
        Model([Field("n", "-a n"), Field("m", "-m")],
              tables=[Table("a", ("n", "m") if "second" in given else ("n",), **given)])
    assert says in str(error.value)


def test_arguments_of_a_table_are_rejected_and_a_product_with_it_is_not():
    table = [Table("a", "n", (0.0, 2.0), (1.0, 3.0))]
    with pytest.raises(Error, match=r"expected a without arguments, or a \* \(...\) for a product"):
        Model([Field("n", "-a(n) n")], tables=table)
    products = [Model([Field("n", equation, reference=1.0)], tables=table) for equation in ("-a * (n) n", "-a (n) n")]
    assert [model.rates(model.state(n=2.0))[0] for model in products] == [-12.0, -12.0]


TABLE = """
field = [{symbol = "n", name = "density", reference = 1.0, conserved = true}]
equations = {n = "div(D grad n)"}
tabulated = [{symbol = "D", of = ["n"], first = [0.5, 1.0, 1.5], values = [0.1, 0.2, 0.4]}]
grid = {nx = 16, ny = 1, lx = 16.0}
time = {dt = 0.1, end = 2.0}
initial = {kind = "formula", density = "1 + 0.4 cos(2 pi x / lx)"}
output = {frame_every = 1.0, sample_every = 0.5}
"""


def test_a_scene_with_a_table_runs_and_keeps_it_in_its_archive(tmp_path):
    (tmp_path / "t.toml").write_text(TABLE)
    program(tmp_path, "run", "t.toml")
    program(tmp_path, "restart", "t.h5", "--set", "time.end=3")
    program(tmp_path, "stability", "t.toml")  # which tries states beyond the table
    with drover.open_run(tmp_path / "t.h5") as run:
        assert run.scene["tabulated"][0]["values"] == [0.1, 0.2, 0.4]
    model = drover.Scene.load(tmp_path / "t.toml").model
    assert model.growth_rates([1.0]).growth_rate.values[0, 0] == pytest.approx(-0.2, rel=1e-12)
    wide = 'initial.density="1 + 0.7 cos(2 pi x / lx)"'
    said = program(tmp_path, "run", "t.toml", "-o", "wide.h5", "--set", wide, status=1)
    assert "the table D is read at n = " in said.stderr
    program(tmp_path, "run", "t.toml", "-o", "held.h5", "--set", wide, "--set", 'tabulated[1].outside="hold"')
    for key, value, says in (("first", "[0.5, 0.4, 1]", "ascending"), ("values", "[1, 2]", "2 values"),
                             ("of", '["n", "n", "n"]', "3 scalars"), ("second", "[1]", "second")):
        said = program(tmp_path, "check", "t.toml", "--set", f"tabulated[1].{key}={value}", status=2)
        assert says in said.stderr, said.stderr
