"""tests/app/test_python_own_fields.py: scenes with fields of their own in Python: models, archives, figures, films."""
import dataclasses
import shutil

import matplotlib
import numpy as np
import pytest
import xarray
from pictures import covered, overlaps, unlabelled
from support import drover as program

import drover
from drover import Field, Model
from drover.figures import model_panels
from drover.roles import Role, roles_of
from drover.typeset import simple_unit

matplotlib.use("Agg")
from matplotlib import pyplot  # noqa: E402  # after the backend is chosen

RANKS = Model([Field("rho", "-div J + D lap rho", name="density", unit="1/mm^2", conserved=True, reference="rho0",
                     noise="2 D rho0", conserved_noise=True, meaning="number <density>"),
               Field("w", "-w + lap w + curl p", name="vorticity", unit="1/s", odd=True),
               Field("p", "(a rho - p.p) p + lap p - grad rho", spin=1, name="polarity", noise=0.01),
               Field("Q", "-Q + lap Q + sym(outer(p, p))", spin=2, name="nematic_order"),
               Field("H", "-H + lap H", spin=6, noise=0.1)],
              define={"J": "u rho p"}, rho0=0.8, D=0.5, a=0.6, u=0.3)


@pytest.fixture(autouse=True)
def close_figures():
    yield
    pyplot.close("all")


def scene_of_ranks(points=16, side=16.0, **changes):
    scene = RANKS.scene(points, side, dt=0.1, end=2.0, initial={"polarity_x": 0.5}, seed=5, name="ranks")
    return scene.set({"output.frame_every": 0.5, "output.sample_every": 0.1, **changes})


@pytest.fixture(scope="module")
def archive(tmp_path_factory):
    """A finished run of all ranks."""
    path = tmp_path_factory.mktemp("own") / "ranks.h5"
    scene_of_ranks().run(path).close()
    return path


def test_a_scene_of_a_model_takes_the_tolerance_that_its_method_needs():
    decay = Model([Field("s", "-s", reference=1.0)])
    with pytest.raises(drover.Error, match="expected a tolerance"):
        decay.scene(8, 8.0, dt=0.1, end=1.0, initial={"s": 2.0}, method="cvode-bdf")
    run = decay.scene(8, 8.0, dt=0.1, end=1.0, initial={"s": 2.0}, method="cvode-bdf", tolerance=1e-8).start()
    run.advance()
    assert np.allclose(run.frame["s"], 2.0 * np.exp(-1.0), rtol=1e-6)  # a hundred times the tolerance of a step


def test_maps_of_fields_without_noise_are_smooth_and_colours_keep_to_the_signs_of_a_field():
    demixing = Model([Field("c", "lap (c^3 - c - lap c)", name="composition", conserved=True, reference=0.3)])
    scene = demixing.scene(64, 64.0, dt=0.1, end=60.0, initial={"kind": "random", "amplitude": 0.05}, seed=1)
    run = scene.start()
    run.advance()
    image = drover.plot.map(run, field="composition").images[0]
    assert image.get_array().shape >= (64, 64) and image.get_array().std() > 0.9 * run.frame.composition.std()
    assert image.norm.vmin == -image.norm.vmax < 0.0  # both signs, about 0
    positive = Role("u", "u", 0, ("u",), reference=1.0)
    assert positive.centre(np.array([[0.2, 2.3], [0.5, 1.5]])) is None  # 1 - 1.3 < 0
    assert positive.centre(np.array([[0.9, 1.1], [0.95, 1.2]])) == 1.0
    assert Role("u", "u", 0, ("u",), reference=1.0).centre(np.array([[-0.2, 2.3], [-0.5, 1.5]])) == 0.0


# --- models and scenes

def test_a_scene_of_a_model_runs_as_the_model_does_and_gives_the_model_back():
    scene = scene_of_ranks()
    assert scene.kind == "model" and scene.model.fields == RANKS.fields and scene.model.latex == RANKS.latex
    assert (scene.model.define, scene.model.coefficients) == (RANKS.define, RANKS.coefficients)
    assert scene == drover.Scene.parse(scene.to_toml()) == drover.Scene.from_dict(scene.values)
    run, alone = scene.start(), RANKS.start(16, 16.0, dt=0.1, seed=5).set(polarity_x=0.5)
    run.advance(), alone.advance(2.0)
    for name in scene.model.components:
        assert np.array_equal(run.frame[name], alone.fields[name]), name  # the same steps and noise


def test_every_key_of_a_scene_with_fields_of_its_own_is_found_described_and_set():
    scene = scene_of_ranks()
    for key in scene.keys():
        if key.partition(".")[0] != "boundary":  # has no values without axes
            assert scene[key] is not None and scene.describe(key)["doc"]
    changed = scene.set({"coefficients.D": 2.0, "field[3].noise": 0.5, "equations.w": "-2 w"})
    assert (changed["coefficients.D"], changed["equations.w"]) == (2.0, "-2 w")
    assert changed["field[3].noise"] == "0.5" and changed.model.noise_strengths == [3.2, 0.0, 0.5, 0.0, 0.1]
    with pytest.raises(drover.Error, match="not a key"):
        scene.describe("coefficients.unknown")
    with pytest.raises(drover.Error, match=r"expected a scene with \[\[field\]\]"):
        drover.Scene.from_dict({}).model
    assert {part["name"] for part in drover.schema("model")} >= {"model", "equations", "coefficients"}


def test_a_scene_shows_its_equations_fields_and_coefficients_in_a_notebook():
    page = scene_of_ranks()._repr_html_()
    for part in (r"\partial_t \rho", r"$u\, \rho\, \boldsymbol{p}$", "mm-2", "odd scalar", "spin 6", ", conserved",
                 "number &lt;density&gt;"):
        assert part in page, part
    assert "<density>" not in page
    built_in = drover.Scene.from_dict({"relaxation.rate": 0.25, "pressure.rods": 2.0, "current.kind": "order"})
    page = built_in._repr_html_()
    for part in ("relaxation.rate", ">0.25<", "decay rate of the order", ">mm s-1<", "256 × 256 points"):
        assert part in page, part
    assert "elasticity.splay" not in page and "[p]" not in page  # as by default; the unit of p is put in


def test_a_formula_of_an_unknown_coefficient_is_an_error_at_the_field():
    with pytest.raises(drover.Error) as caught:
        Model([Field("s", "-s", noise="2 unknown")])
    assert caught.value.place.startswith("s.noise")


# --- archives

def test_an_archive_is_read_restarted_and_swept_as_one_of_rods_and_beads(archive, tmp_path):
    copy = shutil.copy(archive, tmp_path)
    for path in archive.parent.glob("ranks.h5.checkpoint*"):
        shutil.copy(path, tmp_path)
    with drover.restart(copy, end=2.5) as run:
        assert set(run.frames) == set(RANKS.components)
        assert run.frames.density.units == "1/mm^2" and run.frames.sizes["time"] == 6
        assert float(run.summary.mean_density) == pytest.approx(0.8)
    table = drover.sweep(scene_of_ranks(**{"time.end": 1.0}), {"coefficients.a": [0.2, 0.8]})
    assert table.size_mean_polarity.dims == ("coefficients.a",)
    assert np.diff(table.size_mean_polarity) > 0.0  # growth at a rho - p.p
    assert table.plot("size_mean_polarity").get_xlabel() == "coefficients.a"


def test_units_are_products_with_each_base_once():
    for unit, simple in (("1/mm^2", "mm-2"), ("(1/mm^2)^2 mm2", "mm-2"), ("(1/mm^2) (1/s) mm2", "s-1"), ("1", "1"),
                         ("mg mm/s2", "mg mm s-2"), ("", "1"), ("(s", "(s"), ("a$b", "a$b"), ("[p] mm", "[p] mm")):
        assert simple_unit(unit) == simple


# --- pictures

@pytest.mark.parametrize("points, side", [(16, 16.0), ((16, 1), 16.0), ((64, 16), (64.0, 16.0)),
                                          ((8, 32), (8.0, 32.0))])
def test_the_figure_of_any_cell_has_a_panel_for_each_field_and_no_texts_overlap(points, side):
    run = scene_of_ranks(points, side).start()
    run.advance()
    figure = drover.plot.figure(run)
    figure.set_dpi(100)
    assert overlaps(figure) == [] and covered(figure) == [] and figure.get_figwidth() == 3.5
    texts = [text.get_text() for text in figure.texts]
    words = " ".join(texts).replace("\n", " ")
    for name in ("density", "vorticity", "polarity", "nematic order", "$", "means", "deviations", "structure factors"):
        assert f") {name}" in words
    assert "[1]" not in words and "[]" not in words and "$t$ = 2 s" in texts[0]


def test_the_figure_of_an_archive_shows_linear_theory_where_the_summary_has_it(archive):
    with drover.open_run(archive) as run:
        theory = run.summary.assign(structure_factor_density_linear=2.0 * run.summary.structure_factor_density)
        known = dataclasses.replace(run, summary=theory)
        figure, bare = drover.plot.figure(known), drover.plot.figure(run)
        figure.set_dpi(100)
        assert overlaps(figure) == [] and covered(figure) == []
        labels = [[text.get_text() for text in picture.axes[-1].get_legend().get_texts()] for picture in (figure, bare)]
        assert "linear theory" in labels[0] and r"along $\mathbf{q}$" in labels[1]
        lines = [line.get_ydata() for line in figure.axes[-1].lines]
        assert any(np.array_equal(line, theory.structure_factor_density_linear) for line in lines)


def test_the_figure_of_linear_theory_has_the_structure_factors_of_own_fields():
    figure = drover.plot.figure(scene_of_ranks(**{"coefficients.a": -1.0, "coefficients.u": 0.0}).stability())
    axes = next(axes for axes in figure.axes if "$S(" in axes.get_title(loc="left"))
    labels = [text.get_text() for text in axes.get_legend().get_texts()]
    parts = [rf"$\mathbf{{{name}}}$ {end} $\mathbf{{q}}$ [mm$^{{2}}$]" for name in "pH" for end in ("along", "across")]
    assert labels == [r"$\rho$ [mm$^{-2}$]", r"$w$ [s$^{-2}$ mm$^{2}$]", *parts]  # Q is driven by products of p alone
    figure.set_dpi(60)
    assert overlaps(figure) == []


def test_colours_diverge_about_zero_or_the_reference_of_a_field_with_two_signs_and_not_of_a_density():
    scalar = Role("s", "s", 0, ("s",), reference=20.0)
    density = Role("d", "d", 0, ("d",), is_density=True, reference=0.5)
    wave = np.sin(np.linspace(0.0, 2.0 * np.pi, 48, endpoint=False)) * np.ones((48, 1))
    noise = np.where(np.add.outer(np.arange(48), np.arange(48)) % 2 == 0, 1.0, -1.0)  # of every cell of the grid
    assert scalar.centre(wave) == 0.0 and scalar.centre(20.0 + 0.1 * wave) == 20.0
    assert scalar.centre(22.0 + wave) is None
    assert density.centre(0.5 + 0.1 * wave) is None and density.centre(0.5 + noise) is None
    assert density.centre(0.1 + wave) == 0.0  # it is negative in large regions: no density
    for values, colours in ((0.1 * wave, model_panels.DIVERGING), (22.0 + wave, model_panels.SEQUENTIAL)):
        cmap, low, high, _ = model_panels.colours_for(scalar, values)
        assert cmap == colours and (cmap != model_panels.DIVERGING or low == -high)


def test_the_lines_of_a_nematic_have_half_the_angle_of_its_components():
    angle = np.linspace(-1.5, 1.5, 7)
    first, second = model_panels.directions_of(Role("Q", "Q", 2, ("a", "b")), 0.3 * np.cos(2 * angle),
                                               0.3 * np.sin(2 * angle))
    assert np.hypot(first, second) == pytest.approx(0.3) and np.arctan2(second, first) == pytest.approx(angle)


def test_panels_of_a_run_with_fields_of_its_own_draw_on_the_axes_that_they_are_given(archive):
    with drover.open_run(archive) as run:
        for draw in (drover.plot.map, drover.plot.means, drover.plot.structure, drover.plot.numbers,
                     drover.plot.profiles, drover.plot.growth, drover.plot.length, drover.plot.order):
            axes = pyplot.figure().add_subplot()
            assert draw(run, axes) is axes and axes.has_data() and axes.get_xlabel()
            assert unlabelled(axes.figure) == [], draw
        assert drover.plot.map(run, field="Q").get_title(loc="left") == r"nematic order $|\mathbf{Q}|$"
        assert drover.plot.series(run, "variance_density").get_ylabel() == "variance density [mm$^{-4}$]"
        number = drover.plot.numbers(run)
        assert number.get_xlabel() == "mean amount $N$ of density in a box"
        with pytest.raises(drover.Error, match="expected one of density"):
            drover.plot.map(run, field="X")
        both = drover.plot.compare(run, run)
        assert r"(c) $|\langle\mathbf{p}\rangle|$" in [axes.get_title(loc="left") for axes in both.axes]
        both.set_dpi(60)
        assert overlaps(both) == []
        assert [role.is_density for role in roles_of(run)] == [True, False, False, False, False]


def test_a_run_without_what_a_panel_shows_says_so():
    scalar = Model([Field("s", "-s", reference=1.0)]).scene(8, 8.0, dt=0.1, end=0.1).start()
    assert "no vector" in drover.plot.order(scalar).texts[0].get_text()
    assert "(c) variance of s" in [axes.get_title(loc="left") for axes in drover.plot.compare(scalar, scalar).axes]
    rods = drover.Scene.from_dict({"grid": {"nx": 16, "ny": 16}, "time": {"dt": 0.1, "end": 0.1}}).start()
    assert len(drover.plot.means(rods).lines) == 2  # of their density and of the order, a density too
    assert drover.plot.map(rods, field="p").get_title(loc="left") == r"polar order $|\mathbf{p}|$ [mm$^{-2}$]"


@pytest.mark.skipif(shutil.which("ffmpeg") is None, reason="ffmpeg is not installed")
def test_a_film_shows_all_fields_or_one(archive, tmp_path):
    size = {}
    for field in (None, "Q"):
        run = scene_of_ranks(**{"time.end": 0.2}).start()
        path = drover.film(run, tmp_path / "own.mp4", every=0.1, field=field)
        size[field] = path.stat().st_size
    assert size[None] > size["Q"] > 1000  # five maps, and one
    made = program(tmp_path, "film", archive, "--every", "4", "--field", "vorticity", "--output", "w.mp4")
    assert made.stdout.strip() == "w.mp4"
    failed = program(tmp_path, "film", archive, "--field", "X", "--output", "x.mp4", status=2)
    assert "expected one of density" in failed.stderr


def test_a_uniform_field_and_one_of_rounding_errors_are_drawn_as_such():
    still = Model([Field("s", "-s", reference=2.0), Field("v", "-v", spin=1)])
    run = still.scene(8, 8.0, dt=0.1, end=0.2, initial={"s": 2.0}, name="still").start()
    run.advance()
    figure = drover.plot.figure(run)
    figure.set_dpi(100)
    assert overlaps(figure) == []
    assert "every $S(q)$ is zero" in figure.axes[-1].texts[0].get_text()
    wave = xarray.DataArray(np.full((4, 4), 1e-30), {"y": range(4), "x": range(4)}, ("y", "x"))
    assert model_panels.colours_for(roles_of_still(run)[0], wave.values)[0] == model_panels.SEQUENTIAL


def roles_of_still(run):
    from drover.run_view import run_of
    return roles_of(run_of(run))
