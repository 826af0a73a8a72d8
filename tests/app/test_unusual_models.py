"""tests/app/test_unusual_models.py: models whose formulas and orders of fields are not as most are: numbers that touch
names, fields in balance before the order, flows without drag, instabilities between the angles of a search."""
import re

import h5py
import numpy as np
import pytest
from rejection import rejected
from support import MODELS, drover as program, drover_json

import drover

HEAD = """
field = [{fields}]
grid = {{nx = 16, ny = 16, lx = 16.0, ly = 16.0}}
time = {{dt = 0.1, end = 2.0}}
output = {{frame_every = 1.0, sample_every = 0.5}}
[equations]
{equations}
[coefficients]
{coefficients}
"""
P, V, Q = '{symbol = "p", rank = "vector"}', '{symbol = "v", rank = "vector", balance = true}', \
    '{symbol = "Q", rank = "nematic"}'


def write(folder, fields, equations, coefficients="", name="own.toml"):
    (folder / name).write_text(HEAD.format(fields=", ".join(fields), equations="\n".join(equations),
                                           coefficients=coefficients))
    return name


def line_of(folder, scene, name, x, y, *more):
    """The points (x, y) of the one line of a plane."""
    found = drover_json(folder, "boundary", scene, "--x", x, "--y", y, "--set", f'boundary.lines=["{name}"]', "--set",
                        "boundary.cells=8", "--set", "boundary.map=8", *more)
    (lines,) = (one["lines"] for one in found["traced"])
    assert len(lines) == 1
    return np.array([[point["x"], point["y"]] for point in lines[0]["points"]])


def test_a_name_after_a_number_is_that_name(tmp_path):
    scene = write(tmp_path, ['{symbol = "n", reference = 1.0, conserved = true}'], ['n = "2D lap n - 3E lap lap n"'],
                  "D = 1.0\nE = 0.1")
    assert "no effect" not in program(tmp_path, "check", scene).stderr
    for factor in ("43 t", "43t"):
        write(tmp_path, ['{symbol = "u"}'], [f'u = "-0.01 u + cos({factor})"'])
        assert "does not resolve the time dependence of a term" in program(tmp_path, "check", scene).stderr


@pytest.mark.parametrize("fields", [[P, V], [V, P]])
def test_the_onset_does_not_depend_on_the_order_of_fields(tmp_path, fields):
    scene = write(tmp_path, fields, ['p = "(a - p.p) p + K lap p + 0.3 v"', 'v = "-2 v + lap v + 0.2 p"'],
                  "a = 1.0\nK = 0.7")
    points = line_of(tmp_path, scene, "onset", "a=-1:1", "K=0.5:1")
    assert abs(points[:, 0] + 0.03).max() < 1e-9  # v = 0.1 p adds .03 to a


def test_a_pole_of_a_coefficient_is_no_line(tmp_path):
    # abar = c - e/(2 - n) vanishes on two branches, and changes its sign at n = 2 by diverging.
    scene = write(tmp_path, ['{symbol = "n", conserved = true, reference = 1.0}', P],
                  ['n = "D lap n - div p"', 'p = "(c - e/(2 - n) - p.p) p + K lap p - grad n"'],
                  "c = 0.3\ne = 0.5\nK = 1.0\nD = 1.0")
    found = drover_json(tmp_path, "boundary", scene, "--x", "uniform.n=0.2:3.5", "--y", "c=-1:1", "--set",
                        'boundary.lines=["onset"]', "--set", "boundary.cells=16", "--set", "boundary.map=0")
    (traced,) = found["traced"]
    points = np.array([[point["x"], point["y"]] for part in traced["lines"] for point in part["points"]])
    assert abs(points[:, 1] - 0.5 / (2.0 - points[:, 0])).max() < 1e-9 and traced["poles"] > 0
    assert points[:, 0].min() < 0.3 and points[:, 0].max() > 3.4


def test_a_flow_without_drag_has_no_part_in_long_waves(tmp_path):
    scene = write(tmp_path, ['{symbol = "phi", conserved = true}', V.replace("}", ", solenoidal = true}")],
                  ['phi = "M lap (phi^3 - r phi - lap phi) - v.grad phi"', 'v = "lap v + phi grad lap phi"'],
                  "r = 0.5\nM = 1.0")
    points = line_of(tmp_path, scene, "phase-separation", "r=-1:1", "M=0.5:2")
    assert abs(points[:, 0]).max() < 1e-9
    state = drover_json(tmp_path, "stability", scene)["states"][0]
    assert abs(state["slow_modes"][0]["damping"] + 0.5) < 1e-12  # M (-r) q^2


def test_a_search_that_leaves_the_numbers_goes_on_another_way(tmp_path):
    scene = write(tmp_path, [P, Q], ['p = "(a - p.p) p - 0.4 p.grad p + lap p + 0.3 Q.p"',
                                     'Q = "(b - Q:Q) Q + lap Q + 0.2 sym(outer(p, p))"'], "a = 0.2\nb = -0.5")
    words = program(tmp_path, "boundary", scene, "--x", "a=-1:1", "--y", "b=-1:0.5", "--set",
                    'boundary.lines=["banding"]', "--set", "boundary.cells=8", "--set", "boundary.map=8", "-q").stdout
    assert "banding: " in words


def test_the_line_of_oblique_long_waves_is_where_they_begin_to_grow(tmp_path):
    equations = ['Q = "-v.grad Q + curl(v) perp Q + 0.7 sym(grad v) + (a - Q:Q/2) Q + lap Q"',
                 'v = "-0.2 v + lap v - div(z Q)"']
    scene = write(tmp_path, [Q, V.replace("}", ", solenoidal = true}")], equations, "a = 1.0\nz = 2.0")
    points = line_of(tmp_path, scene, "ordered", "z=-1.5:-1", "a=0.15:0.3", "--set", "boundary.cells=4")
    model = drover.Scene.load(tmp_path / scene).model
    for z, a in points[:: len(points) // 3 or 1]:
        at = drover.Scene.load(tmp_path / scene).set({"coefficients.z": z, "coefficients.a": a}).model
        state, q = model.state(Q=(a**0.5, 0.0)), 1e-3
        growth = max(at.growth_rates([q], angle=angle, state=state).growth_rate.values.max() / q**2
                     for angle in np.radians(np.arange(40.0, 140.0, 0.5)))
        assert abs(growth) < 2e-4  # of 1, to the half degree and q^2; a 5 % larger a gives 0.03


def test_a_number_given_twice_by_its_two_names_is_rejected(tmp_path):
    scene = write(tmp_path, ['{symbol = "u", noise = 0.1}'], ['u = "-a u + lap u"'], "a = 1.0")
    program(tmp_path, "run", scene, "--set", "time.end=70", "-o", "run.h5")
    rejected(tmp_path, ["fit", "run.h5", "coefficients.a", "a"], ["a is given twice"])
    rejected(tmp_path, ["boundary", scene, "--x", "a=-1:1", "--y", "coefficients.b=0:1"], ["coefficients.b"])


def test_a_term_that_names_a_direction_is_explicit_and_called_so(tmp_path):
    scene = write(tmp_path, ['{symbol = "u"}'], ['u = "lap u - 3 d_y u"'])
    assert "names a direction" in program(tmp_path, "explain", scene).stdout


def test_the_square_of_a_root_is_what_it_is_where_the_root_exists_and_nothing_else():
    def after_a_unit_of_time(equation, start):
        run = drover.Model([drover.Field("u", equation)]).start(8, 8.0, dt=0.01, seed=1)
        return run.set(u=start).advance(1.0).fields.u.values[0, 0]

    assert abs(after_a_unit_of_time("-sqrt(u)^2", 1.0) - np.exp(-1.0)) < 1e-6  # of second order in dt
    with pytest.raises(drover.DroverError, match="NaN"):
        after_a_unit_of_time("-sqrt(u)^2", -1.0)
    assert abs(after_a_unit_of_time("-sqrt(u^2)^2", -0.5) + 1.0) < 1e-3  # -1/(2 - t)


def test_perturbations_of_a_state_keep_a_conserved_sum(tmp_path):
    scene = write(tmp_path, ['{symbol = "a"}', '{symbol = "b"}'], ['a = "0.1 lap a + f"', 'b = "10 lap b - f"'])
    (tmp_path / scene).write_text((tmp_path / scene).read_text() + '[define]\nf = "(0.067 + a^2/(1 + a^2)) b - a"\n')
    start = ["initial.kind=formula", 'initial.a="0.3 + 0.8 exp(-((x - 10)/2)^4)"', 'initial.b="1.9"', "grid.nx=128",
             "grid.ny=1", "grid.lx=20", "grid.ly=1"]
    found = drover_json(tmp_path, "states", scene, "--wave", "x", "-o", "state.h5",
                        *(word for one in start for word in ("--set", one)))
    with h5py.File(tmp_path / "state.h5") as file:
        a, b = (file[name][-1].ravel() for name in "ab")
    waves = 2 * np.pi * np.fft.fftfreq(128, 20 / 128)
    laplacian = np.real(np.fft.ifft(-waves[:, None]**2 * np.fft.fft(np.eye(128), axis=0), axis=0))
    by_a, by_b = np.diag(2 * a / (1 + a**2)**2 * b - 1), np.diag(0.067 + a**2 / (1 + a**2))
    rates = np.linalg.eigvals(np.block([[0.1 * laplacian + by_a, by_b], [-by_a, 10 * laplacian - by_b]]))
    exact = np.sort(rates.real[abs(rates) > 1e-3])[::-1]  # without a translation and the sum
    assert np.allclose([one["rate"] for one in found["perturbations"]][:4], exact[:4], atol=1e-4)


def test_a_mean_that_one_balance_leaves_free_is_free_beside_others(tmp_path):
    fields = ['{symbol = "n", conserved = true, reference = 1.0}', '{symbol = "P", balance = true}',
              '{symbol = "c", balance = true}', '{symbol = "v", rank = "vector", balance = true}']
    equations = ['n = "0.3 lap n + 0.5 div(n grad P)"', 'P = "lap P + n - 1.0"', 'c = "lap c - c + n"',
                 'v = "-v + grad n"']
    rates = [drover_json(tmp_path, "stability", write(tmp_path, fields[:count], equations[:count]))["states"][0]
             ["fastest_rate"] for count in (2, 3, 4)]
    assert rates[0] == rates[1] == rates[2]
    for count in (2, 3, 4):
        program(tmp_path, "run", write(tmp_path, fields[:count], equations[:count]), "--overwrite", "-o", "run.h5")
    read = 'c = "lap c - c + P"'  # the mean of P, which nothing determines
    rejected(tmp_path, ["run", write(tmp_path, fields[:3], [*equations[:2], read])], ["does not determine it"])


@pytest.mark.parametrize("unit", [2.0**12, 2.0**20, 2.0**-20])
def test_the_units_of_two_balances_change_no_rate(tmp_path, unit):
    def found(u):
        """c in units of 1/u, and its balance and that of v multiplied by other numbers."""
        fields = ['{symbol = "n", conserved = true, reference = 1.0}', '{symbol = "c", balance = true}', V]
        equations = ['n = "0.3 lap n - div(n v) - chi div(n grad c)"', 'c = "m*(lap c - c + s n)"',
                     'v = "k*(-v + 0.5 lap v - e grad c)"']
        coefficients = {"chi": 0.5 / u, "s": u, "e": 0.3 / u, "m": 1 / u, "k": u**2}
        scene = write(tmp_path, fields, equations, "\n".join(f"{key} = {one!r}" for key, one in coefficients.items()))
        state, = drover_json(tmp_path, "stability", scene)["states"]
        return state["fastest_rate"], drover_json(tmp_path, "explain", scene)["fastest_rate"]

    assert np.allclose(found(unit), found(1.0), rtol=1e-10)  # rounding, and the search for the fastest wave


def test_terms_add_up_to_the_rate_whatever_the_masses_of_fields(tmp_path):
    own = write(tmp_path, ['{symbol = "n", conserved = true, reference = 2.0}', '{symbol = "u", mass = "n"}'],
                ['n = "lap n"', 'u = "a u - u^3 + lap u"'], "a = 1.0")
    for scene in (own, MODELS / "flock.toml", MODELS / "isotropic-beads.toml"):
        for state in drover_json(tmp_path, "stability", scene)["states"]:
            growth = sum(one["growth"] for one in state["shares"])
            assert abs(growth - state["fastest_rate"]) < 1e-9 * max(1.0, abs(growth))  # of rounding of the vectors


@pytest.mark.parametrize("size", [1.0, 1e-10])
def test_a_grid_that_does_not_resolve_a_field_is_named_in_any_unit_of_it(size, tmp_path):
    (tmp_path / "own.toml").write_text(f"""
field = [{{symbol = "phi", conserved = true}}]
grid = {{nx = 16, ny = 8, lx = 20.0, ly = 10.0}}
time = {{dt = 0.02, end = 10.0}}
initial = {{kind = "formula", phi = "{size} (0.5 cos(2 pi x/lx) + 0.1 sin(2 pi (x/lx + y/ly)))"}}
output = {{frame_every = 10.0, sample_every = 0.1}}
[equations]
phi = "lap(b phi^3 - phi - 0.1 lap phi)"
[coefficients]
b = {size**-2}
""")
    assert "the grid does not resolve phi" in program(tmp_path, "run", "own.toml", "-q", "-o", "run.h5").stdout


@pytest.mark.parametrize("size", [1.0, 1e8, 1e30])
@pytest.mark.parametrize("term, stops", [("- b u^3", True), ("- c u d_x u", False)])
def test_growth_that_a_term_stops_is_known_in_any_unit_of_the_field(size, term, stops, tmp_path):
    scene = write(tmp_path, ['{symbol = "u"}'], [f'u = "u {term} + lap u"'], f"b = {size**-2}\nc = {1.0 / size}")
    said = program(tmp_path, "check", scene, "--set", "time.end=100").stderr
    assert ("no term stops it" in said) != stops


def test_waves_that_grow_along_a_line_are_judged_along_it(tmp_path):
    scene = write(tmp_path, ['{symbol = "u"}'], ['u = "u - u^3 + K d_x d_x u"'], "K = 1.5")
    line = ["--set", "grid.ny=1", "--set", "grid.nx=48", "--set", "grid.lx=80"]
    # Waves up to q = 0.82 grow, and the grid keeps those to 0.94; with K/2, the mean over directions, it would be 1.15.
    assert "grow about" not in program(tmp_path, "check", scene, *line).stderr
    said = program(tmp_path, "check", scene, *line, "--set", "grid.nx=32").stderr
    assert "waves down to a length of 7.71 mm grow" in said and "choose grid.nx = 64" in said


def test_a_coarse_map_hides_no_waves_that_grow(tmp_path):
    # Two patterns, at |q| = 1 and 1.4: the eight waves of the map are at every third of these.
    scene = write(tmp_path, ['{symbol = "u"}', '{symbol = "v"}'],
                  ['u = "(r - 1) u - 2 lap u - lap lap u"', 'v = "(r - 1) v - 2 lap v / 1.96 - lap lap v / 1.96^2"'],
                  "r = 0.001")
    found = drover_json(tmp_path, "stability", scene, "--set", "stability.wavenumbers=8")["states"][0]["instabilities"]
    assert sorted(one["wavenumber"] for one in found) == pytest.approx([1.0, 1.4], rel=1e-6)


def test_growth_is_told_in_the_units_of_the_scene(tmp_path):
    named = ["--set", "units.length=um", "--set", "units.time=h", "--set", "time.end=100"]
    scene = write(tmp_path, ['{symbol = "u"}'], ['u = "0.5 u + lap u"'])
    assert "a mode grows at 0.5 /h at |q| = 0 /um, by" in program(tmp_path, "check", scene, *named).stderr
    scene = write(tmp_path, ['{symbol = "u"}'], ['u = "u - u^3 + K lap u"'], "K = 0.1")
    assert "waves down to a length of 2 um grow" in program(  # 2 pi sqrt(K) = 1.99, to 1/32 of an octave
        tmp_path, "check", scene, *named, "--set", "grid.nx=8", "--set", "grid.ny=8").stderr


def test_a_grid_on_which_products_leave_no_wave_is_named(tmp_path):
    # Products of degree 5 keep |k| < N/6: no wave of 4 or 6 points, the first of 8.
    scene = write(tmp_path, ['{symbol = "u"}'], ['u = "u - u^5 + 9 lap u"'])
    said = program(tmp_path, "check", scene, "--set", "grid.nx=4", "--set", "grid.ny=6").stderr
    assert "leave no wave on 4 by 6 points" in said and "choose at least grid.nx = 8 and grid.ny = 8" in said
    for points in ("grid.nx=8", "grid.ny=8"):
        one = ["--set", "grid.nx=4", "--set", "grid.ny=4", "--set", points]
        assert "leave no wave" not in program(tmp_path, "check", scene, *one).stderr


def test_a_mean_that_may_be_an_axis_of_a_plane_is_named(tmp_path):
    height = '{symbol = "u", name = "height", conserved = true}'
    scene = write(tmp_path, [height], ['u = "lap (u^3 + a u) - lap lap u"'], "a = -1.0")
    rejected(tmp_path, ["boundary", scene, "--x", "uniform.density=-1:1", "--y", "a=-1:1"],
             ["boundary.x names uniform.density", "one of coefficients.a, uniform.height"])


def test_waves_that_grow_in_one_direction_alone_are_named_until_the_grid_keeps_them(tmp_path):
    # Across x the rate is -0.1 + 2 q^2 - q^4, which grows to q = 1.396; its mean over directions decays at q > 0.6.
    scene = write(tmp_path, ['{symbol = "u"}'],
                  ['u = "-0.1 u - u^3 - 2 d_y d_y u - d_x d_x lap u - lap lap u + d_x d_x u"'], "")
    cell = ["--set", "grid.nx=8", "--set", "grid.ny=8", "--set", "grid.lx=64", "--set", "grid.ly=64"]
    said = program(tmp_path, "check", scene, *cell).stderr
    assert "waves at 90 degrees from x down to a length of 4.5" in said and "choose grid.nx = 128" in said
    finer = ["--set", "grid.nx=128", "--set", "grid.ny=128"]
    assert "grow about" not in program(tmp_path, "check", scene, *cell, *finer).stderr


def test_small_coefficients_beside_large_ones_are_shown(tmp_path):
    scene = write(tmp_path, [P], ['p = "p - b p.p p + h e_x + lap p"'], "b = 1e8\nh = 5e-6")
    assert re.search(r"\n *h +5e-06\n", program(tmp_path, "explain", scene).stdout)


@pytest.mark.parametrize("k, l", [(0.245, 0.973), (0.136, 0.576), (0.561, 0.955), (0.31, 0.17)])
def test_what_two_fields_exchange_has_the_spectrum_of_their_difference(tmp_path, k, l):
    # a + b neither decays nor is driven; rounding errors give its rate either sign, by k and l.
    model = drover.Model([drover.Field("a", "-k a + l b + s xi"), drover.Field("b", "k a - l b - s xi"),
                          drover.Field("c", "0.9 a - c")], noises=[drover.Noise("xi")], k=k, l=l, s=0.7)
    scene = model.scene(points=(8, 8), side=(8.0, 8.0), dt=0.1, end=80.0).set({"output.frame_every": 0.4})
    theory = scene.stability()
    found = theory.main.dynamic_structure_factor_a
    omega = found.frequency_axis.values
    assert np.ptp(omega) == pytest.approx(4.0 * min(1.0, k + l))  # twice the slowest rate that is not 0, both signs
    exact = 0.49 / (omega**2 + (k + l)**2)
    assert abs(found.values / exact - 1.0).max() < 1e-12
    assert "NaN" not in found.comment
    with scene.run(tmp_path / "exchange.h5") as run:
        measured = drover.dynamic_structure_factor(run, "a")
    linear = measured.dynamic_structure_factor_a_linear.values[0]
    assert linear.min() > 0.0
    width = measured.frequency.values[1] - measured.frequency.values[0]
    assert linear.sum() * width / (2.0 * np.pi) == pytest.approx(0.49 / (2.0 * (k + l)), rel=1e-12)  # S(q)


def test_a_spectrum_that_is_not_there_says_why(tmp_path):
    model = drover.Model([drover.Field("a", "s xi"), drover.Field("b", "-b + a + lap b")], noises=[drover.Noise("xi")],
                         s=0.7)
    scene = model.scene(points=(8, 8), side=(8.0, 8.0), dt=0.1, end=80.0).set({"output.frame_every": 0.4})
    found = scene.stability(tmp_path / "maps.h5").main.dynamic_structure_factor_b
    why = "no stationary state: noise drives a mode at q = (0.7854, 0), which does not decay"
    assert np.isnan(found.values).all() and f"; NaN: {why}" in found.comment
    with scene.run(tmp_path / "driven.h5") as run:
        linear = drover.dynamic_structure_factor(run, "b").dynamic_structure_factor_b_linear
    assert np.isnan(linear.values).all() and linear.comment.startswith(f"no linear theory: {why}")


def test_a_stationary_state_without_a_derivative_is_said_in_data_and_text(tmp_path):
    scene = write(tmp_path, ['{symbol = "s"}'], ['s = "s (0.74 - 0.96 s^2) + lap s + 0.3 |s|"'])
    found = drover_json(tmp_path, "stability", scene)
    assert len(found["states"]) == 2 and "a term has no derivative there" in found["no_theory"]
    assert found["no_theory"] in " ".join(program(tmp_path, "stability", scene).stdout.split())
