"""tests/app/test_python_model.py: models of declared fields in Python: exact results, and the page of the manual."""
import copy
import pickle
import sys
import warnings

import matplotlib
import numpy as np
import pytest
from support import DROVER, MODELS

sys.path.insert(0, str(MODELS.parent / "src" / "docs"))
import blocks  # noqa: E402  # pylint: disable=wrong-import-position

import drover  # noqa: E402
from drover import Field, Model, Table  # noqa: E402

PAGE = (MODELS.parent / "src" / "docs" / "model.md").read_text(encoding="utf-8")


def test_every_block_of_the_page_runs(tmp_path):
    matplotlib.use("Agg")
    printed = blocks.run(PAGE, tmp_path, DROVER, MODELS)
    assert len(printed) == 17
    scalar, spots, demixing, flock, nematic, vortices, swirls, *more = printed
    steps, plane_wave, table, balance, shared, memory, walkers, turned, *scenes = more
    scene, made_scene = scenes
    assert scalar[0].split() == ["[[", "-1.]", "[-19.]]"] or "-19" in "".join(scalar[:2])
    assert float(spots[0].strip("[]").split()[0]) < 0.0 < float(spots[0].strip("[]").split()[1])
    assert float(spots[1]) > 0.3
    assert float(demixing[1]) < 3e-4, "walls 16 apart, of width sqrt(2), attract each other by exp(-16 sqrt(2))"
    assert demixing[2] == "True True"
    assert flock[0] == "True" and float(flock[1]) > 0.0
    growth, end = float(nematic[0]), float(nematic[1])
    flow = 0.5**2 / (1 + 0.5**2)  # zeta q^2/(Gamma + eta q^2): the vorticity of a bend, half the shear that aligns
    assert growth == pytest.approx(flow * (1 + 0.7 / 2) - 0.05 * 0.5**2, rel=1e-12) and end > 0.01
    assert abs(float(vortices[0])) < 1e-14
    assert swirls == ["True"]
    assert 0.0 < float(steps[0]) < 0.05
    assert plane_wave == ["True"] and table == ["[[-0.8]]"]
    assert balance == ["[[-1.2]]"]
    assert float(shared[0].strip("[]")) == pytest.approx(-0.3 * 0.2 / 3.5, abs=1e-8)  # as printed
    assert memory[0] == "True True" and float(memory[1]) == pytest.approx(0.7 / (0.5 * (1 + 0.5 * 2.0)), rel=1e-12)
    assert walkers == ["[40. 40.]", "True True"]
    assert float(turned[0]) == pytest.approx(0.831, abs=0.012)  # of 400 seeds; three standard errors of 100
    assert float(scene[0].strip("[]")) == pytest.approx(0.1875, rel=1e-12)
    assert scene[1].startswith("('time', 'y', 'x')") and made_scene == ["True 21"]
    assert all((tmp_path / name).stat().st_size > 10_000 for name in ("turing.png", "demixing.png", "swirls.png"))
    made = {path.name for path in tmp_path.iterdir()}
    assert {"demix.h5", "demix.png", "demix.mp4", "demix.sweep", "cold.h5", "cold.png"} <= made


def test_burgers_follows_the_solution_of_cole_and_hopf():
    # u = -2 nu d_x log psi with psi = 1 + 0.5 cos(q x) exp(-nu q^2 t) solves d_t u + u d_x u = nu d_xx u.
    nu, side, points = 0.2, 2 * np.pi, 64

    def exact(x, t):
        wave = 0.5 * np.exp(-nu * t)
        return 2 * nu * wave * np.sin(x) / (1 + wave * np.cos(x))

    burgers = Model([Field("u", "-u.grad u + nu lap u", spin=1)], nu=nu)
    run = burgers.start((points, 1), side, dt=0.01).set(u_x=lambda x, y: exact(x, 0.0)).advance(2.0)
    error = np.abs(run.fields.u_x.values[0] - exact(run.fields.x.values, 2.0)).max()
    assert error < 1e-10  # fourth order in dt = 0.01, and a spectrum that has decayed to rounding on 64 points
    assert np.abs(run.fields.u_y).max() < 1e-15  # rounding


def test_stripes_of_swift_and_hohenberg_have_their_amplitude():
    # Near onset u = 2 sqrt(eps/3) cos(q x); the next harmonic, of 3 q, changes it by eps/(64 * 3) of itself.
    eps = 0.01
    stripes = Model([Field("u", "eps u - (u + 2 lap u + lap lap u) - u^3")], eps=eps)
    run = stripes.start((32, 1), 2 * np.pi, dt=1.0).set(u=lambda x, y: 0.05 * np.cos(x)).advance(2000.0)
    amplitude = 2 * np.abs(np.fft.rfft(run.fields.u.values[0])[1]) / 32
    assert amplitude == pytest.approx(2 * np.sqrt(eps / 3), rel=3e-4)


def test_the_noise_of_an_interface_is_stationary_at_any_step():
    # Edwards-Wilkinson, the linear part of KPZ: S = D/(2 nu q^2), for steps of 20 relaxation times too.
    height = Model([Field("h", "nu lap h", noise=0.6, conserved_noise=False)], nu=1.0)
    run = height.start(16, 16.0, dt=50.0, seed=2)
    found = np.mean([run.advance(50.0).structure_factor("h").values for _ in range(400)], axis=0)
    q = run.structure_factor("h").wavenumber.values
    modes = 400 * np.maximum(2 * np.pi * np.arange(1, len(q) + 1) / 2, 1)  # independent samples of a shell, at least
    assert np.all(np.abs(found[:7] / (0.3 / q[:7] ** 2) - 1) < 5 / np.sqrt(modes[:7]) + 0.05)  # and q varies in a shell


def test_rates_are_those_of_the_equations_by_hand():
    model = Model([Field("s", "-div(s p)", conserved=True, reference=2.0),
                   Field("p", "-w p.grad p + (1 - p.p) p - B grad s", spin=1)], w=0.3, B=0.7)
    p, s, q = np.array([0.6, 0.2]), 1.5, np.array([0.4, -0.9])
    expected = np.zeros((3, 3), complex)
    expected[0] = [-1j * q @ p, -1j * s * q[0], -1j * s * q[1]]
    expected[1:, 0] = -0.7j * q
    expected[1:, 1:] = (1 - p @ p - 0.3j * q @ p) * np.eye(2) - 2 * np.outer(p, p)
    assert np.abs(model.symbol(q, {"s": s, "p": p}) - expected).max() < 1e-15
    assert np.allclose(model.rates({"s": s, "p": p}), [0, *(1 - p @ p) * p], atol=1e-16)


@pytest.mark.parametrize("equation, column, said", [
    ("-w p.grad p + p p", 17, "is multiplied by"), ("lap s", 1, "this is a scalar; expected a vector"),
    ("-a p", 2, "expected"), ("p^2", 2, "a power of a vector"), ("-p + perp p", 6, "pseudovector"),
    ("-p - s", 6, "this is a scalar; expected a vector"), ("-p/(s - s)", 3, "divides by zero"),
    ("grad p.grad p", 1, "a tensor of rank 2; expected a vector"), ("-p + (p + s) p", 9, "are added"),
])
def test_a_wrong_equation_is_rejected_at_its_column(equation, column, said):
    with pytest.raises(drover.Error) as caught:
        Model([Field("s"), Field("p", equation, spin=1)], w=1.0)
    assert caught.value.place == f"p.equation:1:{column}" and said in str(caught.value)


def test_what_cannot_be_run_is_rejected_with_a_remedy():
    with pytest.raises(drover.Error, match="no divergence"):
        Model([Field("s", "-s", conserved=True)])
    with pytest.raises(drover.Error, match="conserved_noise"):
        Model([Field("s", "lap s", conserved=True, noise=1.0)])
    with pytest.raises(drover.Error, match="is not linear in it"):
        Model([Field("s", "lap s"), Field("v", "-|v| v + grad s", spin=1, balance=True)])
    for fields, said in [([Field("s", conserved_noise=0.5)], "conserved_noise of the field s = 0.5; expected bool"),
                         ([Field("p", spin=1, name="a"), Field("a_x")], "a_x is a component of p and of a_x"),
                         ([Field("s", noise=[1.0])], "expected int or float or str"), (["s"], "is not a field")]:
        with pytest.raises(drover.Error, match=said):
            Model(fields)
    one = Field("s", "-s")
    run = drover.Scene.from_dict({"output.sample_every": 0.5, "time.dt": 0.5, "grid.nx": 8, "grid.ny": 8}).start()
    for call, said in [(lambda: Model(1.0), "fields = 1.0; expected a list of drover.Field"),
                       (lambda: Model(one, noises=2), "noises = 2; expected a list of drover.Noise"),
                       (lambda: Model(one, define="k = 1"), "define = 'k = 1'; expected a dictionary"),
                       (lambda: Table("a", [1], (0.0, 2.0), (1.0, 3.0)), "expected formulas of fields, as texts"),
                       (lambda: Model(one).start(8, 8.0, 0.1, method=1), "method = 1, threads = 1; expected a text"),
                       (lambda: Model(one).start(8, 8.0, 0.1, seed=np.array(1.7)), "seed = 1.7; expected an integer"),
                       (lambda: Model(one).growth_rates([1.0], angle=np.nan), "angle = nan; expected a finite number"),
                       (lambda: drover.slurm_script(drover.Scene.from_dict({}), 0), "shares = 0; expected a whole"),
                       (lambda: drover.Scene.from_dict(1.0), "the scene is 1.0; expected a dictionary"),
                       (lambda: run.observe("peak"), "the observable is 'peak'; expected a function of a frame")]:
        with pytest.raises(drover.Error, match=said):
            call()
    with pytest.raises(drover.Error, match="no finite derivative"):
        Model([Field("p", "-|p| p - sqrt(|p|) e_x", spin=1)]).growth_rates([1.0])
    with pytest.raises(drover.Error, match="a uniform state of 1 values; expected 2"):
        Model([Field("p", "-p", spin=1)]).rates([1.0])
    assert Model([Field("p", "-|p|^2 p", spin=1)]).growth_rates([1.0]).growth_rate.values[0, 0] == 0.0
    model = Model([Field("s", "s^3")])
    with pytest.raises(drover.Error, match="diverged: s is NaN or infinite"):
        model.start(8, 1.0, dt=1.0).set(s=1.0).advance(100.0)
    run = model.start(8, 1.0, dt=0.1)
    for action, said in [(lambda: run.advance(0.25), "whole number of steps"), (lambda: run.set(q=1.0), "no"),
                         (lambda: run.set(s=np.nan), "finite"), (lambda: model.state(q=1.0), "not a field"),
                         (lambda: model.state(s=(1.0, 2.0)), "2 values; expected 1"),
                         (lambda: model.start(7, 1.0, 0.1), "even"), (lambda: model.start(8.9, 1.0, 0.1), "whole"),
                         (lambda: model.start(np.nan, 1.0, 0.1), "whole"),
                         (lambda: Model([Field("p", "-p", spin=1)]).start(8, 1.0, 0.1).set(p=(1j, 0.0)), "complex"),
                         (lambda: model.start((8, 8, 8), 1.0, 0.1), "two along x and y"),
                         (lambda: model.start(8, 1.0, 0.1, seed=-1), "seed = -1"),
                         (lambda: run.set(s=np.zeros((3, 8))), "of shape \\(3, 8\\)"),
                         (lambda: model.growth_rates([]), "no wavenumbers"),
                         (lambda: model.growth_rates([[1.0, 2.0]]), "of numbers"),
                         (lambda: model.growth_rates("long"), "expected a number or a list"),
                         (lambda: model.symbol([1.0, 2.0, 3.0]), "two components"),
                         (lambda: run.set(s=lambda x, y: 1j * x), "complex"),
                         (lambda: run.set(s=np.ma.masked_greater(np.zeros((8, 8)) + np.arange(8), 5)), "masked"),
                         (lambda: model.growth_rates([1.0], state="s"), "expected values by field"),
                         (lambda: Model([Field("h", "lap h + grad h.grad h")]), "write \\(grad h\\).\\(grad h\\)"),
                         (lambda: Model([Field("h", "-y h")], y=1.0), "the name y is that of the position"),
                         (lambda: run.advance(np.nan), "finite"), (lambda: model.start(8, 1.0, 0.0), "dt = 0")]:
        with pytest.raises(drover.Error, match=said):
            action()
    with pytest.raises(TypeError, match="its copy would be the same run"):
        copy.copy(run)


def test_balances_are_solved_in_the_order_of_their_dependence():
    # All are v = -grad rho: the growth rate is -q^2.
    rho, v = Field("rho", "-div(rho v)", reference=1.0), Field("v", "-rho v - rho grad rho", spin=1, balance=True)
    w = Field("w", "-rho w + rho v", spin=1, balance=True)
    for fields, define in [((rho, v), {}), ((Field("rho", "-div(rho w)", reference=1.0), w, v), {}),
                           ((Field("rho", "-div(rho w)", reference=1.0), v, w), {}),
                           ((Field("rho", "-div J", reference=1.0),
                             Field("v", "-J - rho grad rho", spin=1, balance=True)), {"J": "rho v"})]:
        assert Model(fields, define=define).growth_rates([2.0]).growth_rate.values == pytest.approx(-4.0, rel=1e-14)
    with pytest.raises(drover.Error, match="one after the other"):
        Model([rho, Field("v", "-rho v + rho w", spin=1, balance=True), w])
    # A field in balance has the value that follows from the others, whatever the state gives.
    drift = Model([Field("s", "-v.grad s"), Field("v", "-v + e_x", spin=1, balance=True)])
    assert drift.growth_rates([1.0]).frequency.values == pytest.approx(1.0, rel=1e-14)
    assert np.abs(drift.rates({"s": 2.0})).max() == 0.0


def test_a_multistep_method_starts_anew_where_fields_are_set():
    model = Model([Field("u", "u - u^3")])
    run = model.start(4, 1.0, dt=0.05, method="etd-abm4").set(u=2.0).advance(2.0).set(u=0.1).advance(1.0)
    fresh = model.start(4, 1.0, dt=0.05, method="etd-abm4").set(u=0.1).advance(1.0)
    assert np.abs(run.fields.u - fresh.fields.u).max() < 1e-14  # the same steps but for the time, which does not enter


def test_structure_factors_are_of_the_modes_that_are_kept():
    cubic = Model([Field("s", "-s + lap s - 1e-9 s^3", noise=1.0)])
    run = cubic.start(32, 16.0, dt=20.0)
    found = np.mean([run.advance(20.0).structure_factor("s").values for _ in range(60)], axis=0)
    q = run.structure_factor("s").wavenumber.values
    assert q.max() < 2 * np.pi / 16 * 8 * 2**0.5  # |k| < 32/4 on each axis
    assert np.all(np.abs(found * 2 * (1 + q**2) - 1) < 0.5)  # 5 deviations of 120 samples, the least of a shell


def test_a_model_shows_its_equations():
    model = Model([Field("rho", "-div(rho v) + D lap rho", conserved=True, reference=1.0),
                   Field("v", "-Gamma v / 2 + alpha_0 |v| v", spin=1, mass="m rho")],
                  D=1.0, Gamma=1.0, alpha_0=0.1, m=1.0)
    assert model.latex == (
        r"\begin{aligned}\partial_t \rho &= -\nabla \cdot \left(\rho\, \boldsymbol{v}\right) + D\, \nabla^2 \rho \\ "
        r"m\, \rho\, \partial_t \boldsymbol{v} &= -\frac{\Gamma\, \boldsymbol{v}}{2} + "
        r"\alpha_{0}\, \left|\boldsymbol{v}\right|\, \boldsymbol{v}\end{aligned}")
    assert model.terms[0] == ("rho", "-div(rho v)") and model.components == ("rho", "v_x", "v_y")


@pytest.mark.parametrize("one, other", [
    ("(s^2)^3", "s^(2^3)"), ("grad p.w", "(grad p).w"), ("div Q.p", "(div Q).p")])
def test_formulas_that_differ_are_shown_differently(one, other):
    def shown(term):
        rank = 1 if term.startswith(("grad", "(grad")) else 0
        scalar, vector = ("", f" + {term}") if rank else (f" + {term}", "")
        return Model([Field("s", "-s" + scalar), Field("p", "-p" + vector, spin=1), Field("w", "-w", spin=1),
                      Field("Q", "-Q", spin=2)]).latex
    assert shown(one) != shown(other)
    assert "}^{" not in shown("(s^2)^3").replace("\\right)^{", "")  # no double superscript


def test_waves_that_a_run_cuts_off_are_warned_of():
    """Of a cubic equation those from N/4 on: of cos(x)/2 + 3 cos(9 x)/10 on 32 points .09/.34 of the variance."""
    run = Model([Field("s", "-s^3")]).start((32, 1), 2 * np.pi, dt=0.1)
    with pytest.warns(UserWarning, match="s: the run cuts off 0.26 of its variance"):
        run.set(s=lambda x, y: 0.5 * np.cos(x) + 0.3 * np.cos(9 * x))
    assert run.fields.s.values[0] == pytest.approx(0.5 * np.cos(run.fields.x.values), abs=1e-15)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        run.set(s=lambda x, y: 1e6 + 0.3 * np.cos(7 * x)).set(s=1.0)
    named = Model([Field("self", "-self")]).start(8, 1.0, dt=0.1)
    assert (named.set(self=2.0).fields["self"] == 2.0).all()


def test_a_quotient_by_a_derivative_is_a_term():
    # (lap s)^2/lap s is lap s: of a wave that decays by exp(-q^2 t), no zero of which is a point of the grid.
    run = Model([Field("s", "(lap s)^2/lap s")]).start(16, 2 * np.pi, dt=1e-3, method="etdrk4-krogstad")
    wave = np.cos(run.fields.x.values + 0.1)[None, :] * np.ones((16, 1))
    assert np.abs(run.set(s=wave).advance(0.2).fields.s.values / (wave * np.exp(-0.2)) - 1).max() < 1e-11
    for term in ("p.grad s/|grad s|", "s^2/(curl p)^2", "log(lap s)"):  # undefined without gradients
        Model([Field("s", f"-s + {term}"), Field("p", "-p", spin=1)])


def test_a_word_that_an_equation_does_not_know_is_an_operator_or_a_coefficient_to_be_given():
    for equation in ("laplace u", "-decay u"):
        with pytest.raises(drover.Error, match="expected one of .* an operator such as grad or lap, a function, or a "
                                               "coefficient with a value"):
            Model([Field("u", equation)], D=1.0)


def test_a_keyword_that_no_equation_has_is_warned_of():
    """noise is an argument of a Field: as a coefficient it would have no effect, and no one would notice."""
    fields = [drover.Field("phi", "-k phi")]
    with pytest.warns(UserWarning, match="noise has no effect: no equation of this model has it"):
        drover.Model(fields, k=1.0, noise=0.5)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        drover.Model(fields, coefficients={"k": 1.0, "spare": 2.0})


def test_fields_in_balance_follow_the_others_in_a_run_in_memory():
    # 0 = lap psi - psi + s, and u = grad psi: wave by wave psi_q = s_q/(1 + q^2), exact but for rounding.
    model = Model([Field("s", "-s"), Field("psi", "lap psi - psi + s", balance=True),
                   Field("u", "grad psi - u", spin=1, balance=True)])
    run = model.start(16, 2 * np.pi, dt=0.1).set(s=lambda x, y: np.cos(2 * x) + np.sin(y))
    for decay in (1.0, np.exp(-1.0)):
        x, y = np.meshgrid(run.fields.x, run.fields.y)
        assert run.fields.psi.values == pytest.approx(decay * (np.cos(2 * x) / 5 + np.sin(y) / 2), abs=1e-13)
        assert run.fields.u_x.values == pytest.approx(decay * -2 * np.sin(2 * x) / 5, abs=1e-13)
        run.advance(1.0)
    with pytest.raises(drover.Error, match="with a rate; expected one of s"):
        run.set(psi=1.0)


def test_a_run_takes_complex_fields_and_vectors_as_such():
    model = Model([Field("A", "-A", complex=True), Field("p", "-p", spin=1, name="polarity")])
    run = model.start(8, 1.0, dt=0.1).set(A=lambda x, y: np.exp(2j * np.pi * x), p=(0.5, np.ones((8, 8))))
    now = run.fields
    assert now.A_re.values + 1j * now.A_im.values == pytest.approx(np.exp(2j * np.pi * now.x.values) * np.ones((8, 1)))
    assert (now.polarity_x == 0.5).all() and (now.polarity_y == 1.0).all()
    assert (run.set(A=2.0).fields.A_im == 0.0).all() and (run.set(polarity=(0.0, 1.0)).fields.polarity_y == 1.0).all()
    with pytest.raises(drover.Error, match="two components, polarity_x and polarity_y"):
        run.set(p=0.5)


def test_a_run_takes_arrays_by_the_names_of_their_dimensions():
    run = Model(Field("phi", "lap phi")).start(points=(16, 8), side=(16.0, 8.0), dt=0.1)
    x, y = run.fields.x, run.fields.y
    wave = np.sin(2 * np.pi * x / 16) + 0.5 * np.cos(2 * np.pi * y / 8)  # over (x, y)
    assert wave.dims == ("x", "y")
    assert run.set(phi=wave).fields.phi.values == pytest.approx(wave.transpose("y", "x").values, abs=1e-14)
    with pytest.raises(drover.Error, match="other values of x"):
        run.set(phi=wave.assign_coords(x=2.0 * x))
    with pytest.raises(drover.Error, match="has the dimensions x; expected y and x"):
        run.set(phi=np.sin(x))


def test_a_mean_that_noise_drives_has_no_stationary_variance():
    # The mean of d_t h = nu lap h + f diffuses; of noise that is a divergence it stays.
    with pytest.raises(drover.Error, match="noise drives a mean that the equations conserve"):
        Model([Field("h", "nu lap h", noise=1.0)], nu=1.0).structure_factors([0.0])
    still = Model([Field("h", "nu lap h", noise=1.0, conserved_noise=True)], nu=1.0)
    assert still.structure_factors([0.0, 2.0]).values.ravel() == pytest.approx([0.0, 0.5])


def test_a_model_keeps_its_numbers():
    model = Model([Field("h", "-nu h")], nu=1.0, define={"g": "2 nu"})
    for change in (model.coefficients, model.define):
        with pytest.raises(TypeError, match="does not support item assignment"):
            change["nu"] = 5.0
    copied = pickle.loads(pickle.dumps(model))
    assert copied.rates({"h": 1.0}) == model.rates({"h": 1.0}) == [-1.0] and copied.define == {"g": "2 nu"}
    with pytest.raises(drover.Error, match="coefficient nu is given twice"):
        Model([Field("h", "-nu h")], coefficients={"nu": 1.0}, nu=2.0)


@pytest.mark.parametrize("equation", ["-(1 + cos(x)) h", "-h + cos(t)"])
def test_terms_of_place_or_time_have_no_uniform_rates(equation):
    with pytest.raises(drover.Error, match="depends on position or time"):
        Model([Field("h", equation)]).rates({"h": 0.5})


@pytest.mark.parametrize("spin", [-1, -2])
def test_a_negative_spin_is_rejected(spin):
    for fields, noises in (([Field("p", "-p", spin=spin)], []), ([Field("p", "-p + n")], [drover.Noise("n", spin)])):
        with pytest.raises(drover.Error, match=f"has spin {spin}; expected 0 or more"):
            Model(fields, noises=noises)
