"""tests/app/test_theory_figures.py: archives of drover stability and drover boundary as Python users meet them."""
from dataclasses import replace

import h5py
import numpy
import pytest
import xarray
from matplotlib import image
from support import MODELS, SMALL, drover, drover_json, in_process, write_scene

import drover as package
from drover import figure
from drover.figures import boundary_figure, boundary_panels, panels, stability_figure, stability_panels
from drover.figures.paper import new_figure
from pictures import overlaps, share_of

COARSE = {"stability.wavenumbers": 32, "stability.angles": 7, "stability.frequencies": 41}  # a map of every 15 degrees
# abar = 1 - sigma = -0.1: a flock so near its onset that it bands.
BANDING = {"uniform.rod_density": 1.1, "relaxation.rate": 1.0, "relaxation.rate_terms": ["-1 sigma"],
           "relaxation.saturation": 1.0, "current.speed": 1.0, "pressure.rods": 1.0, "elasticity.stiffness": 1.0,
           "elasticity.splay": 0.0, "initial.kind": "uniform"}
POLAR = {"fields.rod_density": False, "relaxation.rate": -0.5, "relaxation.saturation": 0.5,
         "elasticity.stiffness": 1.0,
         "advection.strength": 0.5, "noise.order": 0.01, "grid.nx": 16, "grid.ny": 16, "grid.lx": 16.0, "grid.ly": 16.0}
ACROSS = r"of order $\mathbf{p}$ across"
STATES = {  # changes of a scene, its base, the state that is drawn, titles of the panels without their letters
    "a flock": ({"relaxation.rate": -0.5, "relaxation.saturation": 1.0, "initial.kind": "uniform"}, SMALL, "ordered",
                ["fastest growth rate", "growth rates of all modes", "speeds", "damping", "of rods", "of rods"]),
    "a flock that bands": (BANDING, SMALL, "ordered",
                           ["fastest growth rate", "growth rates of all modes", "speeds", "damping", "of rods",
                            "of rods"]),
    "no noise": ({"noise.order": 0.0, "noise.rods": 0.0, **BANDING}, SMALL, "ordered",
                 ["fastest growth rate", "growth rates of all modes", "speeds", "damping"]),
    "isotropic": ({}, SMALL, "isotropic", ["growth rates of all modes", "frequencies of all modes", "$S", "$S"]),
    "no densities": ({}, POLAR, "ordered", ["fastest growth rate", "growth rates of all modes", "speeds", "damping",
                                            ACROSS, ACROSS]),
    "nothing but decay": ({"relaxation.rate": 0.5, "noise.order": 0.0}, POLAR, "isotropic",
                          ["growth rates of all modes"]),
    "a field": ({"orienting_field.x": 0.05}, POLAR, "along the field",
                ["fastest growth rate", "growth rates of all modes", ACROSS, ACROSS]),
}
# Aligned rods drag beads, beads turn rods; both coefficients are known to some error on a mesh of densities.
TABLE = {"fields.bead_density": True, "fields.bead_velocity": "dynamic", "uniform.bead_density": 1.0,
         "uniform.rod_density": 0.05, "uniform.bead_area": 0.5, "uniform.rod_area": 2.0, "current.speed": 3.0,
         "current.kind": "density-order", "inertia.bead_mass": 0.7, "drag.coefficient": 30.0, "driving.strength": 10.0,
         "stiffness.beads": 200.0, "stiffness.rods": 400.0, "relaxation.rate": 0.4,
         "relaxation.saturation": 0.4, "elasticity.stiffness": 2.0, "weathercock.strength": 0.6, "pressure.beads": 1.0,
         "pressure.rods": 40.0, "table.bead_density": [0.5, 1.0, 1.5], "table.rod_density": [0.01, 0.1],
         "table.relaxation_rate": [0.45, 0.40, 0.38, 0.28, 0.30, 0.20],
         "table.driving_strength": [10.0, 15.0, 18.0, 30.0, 26.0, 44.0],
         "table.driving_strength_error": [0.5] * 6, "boundary.cells": 12, "boundary.chord": 0.002, "boundary.map": 12,
         "boundary.x": "bead_area_fraction = 0.26:0.74", "boundary.y": "rod_area_fraction = 0.03:0.19",
         "boundary.conventions": ["mean", "single-rod"]}
NO_LINE = {**POLAR, "boundary.x": "relaxation.rate = 0.1:1", "boundary.y": "elasticity.stiffness = 0.5:2",
           "boundary.cells": 8, "boundary.map": 8}


def archive(folder, command, base, changes=None, name="theory.h5"):
    scene = write_scene(folder, {**(COARSE if command == "stability" else {}), **(changes or {})}, base=base)
    drover(folder, command, scene, "--output", name)
    return folder / name


@pytest.fixture(scope="module", name="bands")
def the_stability_of_a_flock_that_bands(tmp_path_factory):
    return archive(tmp_path_factory.mktemp("bands"), "stability", SMALL, BANDING)


@pytest.fixture(scope="module", name="report")
def the_boundaries_of_a_table(tmp_path_factory):
    """What the command prints, with the folder of its archive."""
    folder = tmp_path_factory.mktemp("plane")
    printed = drover_json(folder, "boundary", write_scene(folder, {}, base=TABLE), "--output", "theory.h5")
    return folder, printed


@pytest.fixture(scope="module", name="plane")
def the_archive_of_these_boundaries(report):
    return report[0] / "theory.h5"


def draw(path, *arguments, status=0):
    """Runs the command that draws, in the archive's folder."""
    done = in_process(figure.main, path.parent, path.name, *arguments)
    assert done.returncode == status, done.stderr
    return done


def picture_of(path, state=None):
    with package.open_theory(path) as theory:
        return stability_figure.draw(theory, state) if theory.kind == "stability" else boundary_figure.draw(theory)


def titles_of(picture):
    return [axes.get_title(loc="left") for axes in picture.axes if axes.get_title(loc="left")]


def words_of(picture):
    return " ".join(text.get_text() for text in picture.texts).replace("\n", " ")


# --- stability

@pytest.mark.parametrize("case", STATES)
def test_the_most_ordered_state_is_drawn_without_overlaps_and_without_empty_panels(tmp_path, case):
    changes, base, state, wanted = STATES[case]
    picture = picture_of(archive(tmp_path, "stability", base, changes))
    titles = titles_of(picture)
    assert len(titles) == len(wanted), titles
    for letter, title, words in zip("abcdef", titles, wanted):
        assert title.startswith(f"({letter}) ") and words in title
    assert f"flock.toml: linear theory of its uniform state “{state}”" in words_of(picture)
    assert overlaps(picture) == []
    for axes in picture.axes:
        assert axes.lines or axes.collections, axes.get_title(loc="left")


def test_a_flock_that_bands_is_drawn_with_its_fastest_wave_and_the_line_where_none_grows(bands):
    picture = picture_of(bands)
    with package.open_theory(bands) as theory:
        state = stability_figure.state_of(theory, None)
        rate, q, angle = state.fastest
        most = state.array("growth_rate").max("branch")
        assert rate == float(most.max()) == float(most.sel(wavenumber=q, angle=angle))
    stars = [line for line in picture.axes[0].lines if line.get_marker() == "*"]
    assert [(line.get_xdata()[0], line.get_ydata()[0]) for line in stars] == [(q, angle)]
    assert f"grows at {rate:.4g}" in words_of(picture).replace("\u00a0", " ") and "(star)" in words_of(picture)


@pytest.mark.parametrize("scene, words", [("toner-tu", "ordered, density = 1.1, |polarity| = 0.316"),
                                          ("cahn-hilliard", "isotropic, all fields 0")])
def test_the_most_ordered_state_of_a_model_of_ones_own_is_drawn(scene, words, tmp_path):
    drover(tmp_path, "stability", MODELS / f"{scene}.toml", "-o", "own.h5")
    assert f"“{words}”" in words_of(picture_of(tmp_path / "own.h5"))
    with package.open_theory(tmp_path / "own.h5") as theory:
        names = list(theory.groups)
    assert all(titles_of(picture_of(tmp_path / "own.h5", name)) for name in names)


def test_another_state_can_be_chosen(bands):
    assert "“isotropic”" in words_of(picture_of(bands, "isotropic"))
    assert "The fastest" in words_of(picture_of(bands, "isotropic"))
    draw(bands, "--state", "isotropic", "--output", "isotropic.png")
    assert not numpy.array_equal(image.imread(bands.with_name("isotropic.png"))[:, :, 0],
                                 image.imread(draw_to(bands, "ordered.png"))[:, :, 0])


def test_the_dynamic_structure_factor_of_growing_waves_is_omitted(tmp_path):
    path = archive(tmp_path, "stability", SMALL, {**BANDING, "stability.sound": 0.05})
    assert any("omega" in title for title in titles_of(picture_of(path)))  # of the flock: waves across p0 decay
    assert not any("omega" in title for title in titles_of(picture_of(path, "isotropic")))


def draw_to(path, name):
    return path.with_name(draw(path, "--output", name).stdout.strip())


def test_maps_agree_with_the_report(bands):
    report = drover_json(bands.parent, "stability", "flock.toml")
    assert [state["name"] for state in report["states"]] == ["isotropic", "ordered"]
    with package.open_theory(bands) as theory:
        assert list(theory.groups) == ["isotropic", "ordered"] and theory.scene["relaxation"]["rate"] == 1.0
        for state in report["states"]:
            group = theory.groups[state["name"]]
            assert float(group.wavenumber[0]) == pytest.approx(report["searched_from"], rel=1e-12)
            assert float(group.wavenumber[-1]) == pytest.approx(report["searched_to"], rel=1e-12)
            fastest = max(one["rate"] for one in state["instabilities"])
            # The map has 32 wavenumbers over four decades and every 15 degrees: near the maximum, not on it.
            assert 0.8 * fastest < float(group.growth_rate.max()) <= fastest * (1.0 + 1e-9)
            for angle in (0, 30, 60, 90):
                modes = [mode for mode in state["slow_modes"] if round(mode["angle"]) == angle]
                for k, mode in enumerate(modes):
                    at = group.sel(angle=angle, method="nearest").isel(slow_mode=k)
                    assert float(at.slow_speed) == pytest.approx(mode["speed"], rel=1e-9, abs=1e-12)
                    assert float(at.slow_damping) == pytest.approx(mode["damping"], rel=1e-6, abs=1e-12)


def test_the_dynamic_structure_factor_sums_to_the_static_one(tmp_path):
    changes, base, *_ = STATES["no densities"]
    wide = {**changes, "stability.frequencies": 4001, "stability.wavenumbers": 64}
    with package.open_theory(archive(tmp_path, "stability", base, wide)) as theory:
        group = theory.groups["ordered"].load()
        dynamic = group.dynamic_structure_factor_order_across_p0.sel(angle=90.0)
        tails = float(dynamic[0]) / float(dynamic.max())
        total = float(dynamic.integrate("frequency_axis")) / (2.0 * numpy.pi)
        q = 2.0 * numpy.pi / 16.0  # the cell's longest wave, of which S is noise/(2 K q^2): a diffusing angle
        assert total <= 0.01 / (2.0 * q**2) * 1.02
        assert total >= 0.01 / (2.0 * q**2) * (1.0 - 2.0 * numpy.sqrt(tails))  # a Lorentzian's tails, cut off


# --- boundaries

def test_regimes_lines_conventions_errors_and_angles_are_drawn(plane):
    picture = picture_of(plane)
    labels = [text.get_text() for legend in picture.legends for text in legend.get_texts()]
    assert {"isotropic", "flock", "onset of a flock", "mean convention", "single-rod convention",
            "error: 16 to 84 % of the draws"} <= set(labels), labels
    axes = picture.axes[0]
    assert (axes.get_xlabel(), axes.get_ylabel()) == (
        r"area fraction of beads $\Phi_b$", r"area fraction of rods $\Phi_r$")
    assert axes.get_xlim() == (0.26, 0.74) and axes.get_ylim() == (0.03, 0.19)
    assert {line.get_linestyle() for line in axes.lines} == {"-", "--"}
    assert overlaps(picture) == []


def opened(path, group):
    with xarray.open_dataset(path, group=group, engine="netcdf4") as dataset:
        return dataset.load()


def test_a_band_is_where_16_to_84_percent_of_the_draws_are_unstable(plane):
    """Its edges are level lines of one function, so they cannot cross, and lie within the plane."""
    band = boundary_panels.bands_of(opened(plane, "band"))[0]
    shares = opened(plane, "band")["share"].values[0]
    # 15.9 and 84.1 %, one standard deviation of a normal law.
    inside = numpy.abs(band.deviation) < 1.0
    assert inside.any() and (shares[inside] > 0.15).all() and (shares[inside] < 0.85).all()
    axes = new_figure().add_subplot()
    assert boundary_panels.draw_band(axes, band)
    for collection in axes.collections:
        for path in collection.get_paths():
            places = path.vertices
            assert (places >= [0.26 - 1e-12, 0.03 - 1e-12]).all() and (places <= [0.74 + 1e-12, 0.19 + 1e-12]).all()
    assert not boundary_panels.draw_band(axes, replace(band, deviation=numpy.full_like(band.deviation, 3.0)))


def test_vertices_agree_with_the_report(plane, report):
    lines = [(traced, line) for traced in report[1]["traced"] for line in traced["lines"]]
    read = boundary_panels.lines_of(opened(plane, "boundary"))
    assert len(read) == len(lines) >= 2
    limits = ["onset", "phase-separation", "banding", "oblique"]
    for mine, (traced, line) in zip(read, lines):
        assert (limits[mine.limit], boundary_panels.CONVENTIONS[mine.convention]) == (traced["limit"],
                                                                                      traced["convention"])
        points = line["points"] + line["points"][:1] * (len(mine.places) - len(line["points"]))
        assert mine.places.tolist() == [[point["x"], point["y"]] for point in points]


def test_a_plane_without_a_line_is_drawn_with_its_regime_and_a_note(tmp_path):
    path = archive(tmp_path, "boundary", NO_LINE)
    picture = picture_of(path)
    assert [text.get_text() for text in picture.axes[0].texts] == ["no line in this plane"]
    assert picture.axes[0].get_xlabel() == "relaxation.rate [1/s]"
    assert picture.axes[0].get_ylabel() == "elasticity.stiffness [mm$^{2}$/s]"
    assert overlaps(picture) == []
    bare = archive(tmp_path, "boundary", {**NO_LINE, "boundary.map": 0}, name="bare.h5")
    assert [text.get_text() for text in picture_of(bare).axes[0].texts] == ["no line in this plane"]


def test_islands_are_closed():
    columns = {"line": [0, 0, 0, 1, 1], "limit": [2, 2, 2, 3, 3], "convention": [0] * 5, "closed": [1, 1, 1, 0, 0],
               "x": [0, 1, 0, 2, 3], "y": [0, 0, 1, 2, 2], "angle": [0, 0, 0, 30, 40]}
    vertices = xarray.Dataset({name: ("vertex", numpy.array(values, float)) for name, values in columns.items()})
    island, line = boundary_panels.lines_of(vertices)
    assert island.places.tolist() == [[0, 0], [1, 0], [0, 1], [0, 0]]
    assert line.places.tolist() == [[2, 2], [3, 2]]


# --- both

def test_the_command_recognises_the_kind_of_an_archive(bands, plane):
    for path, colour in ((bands, panels.BLUE), (plane, boundary_panels.PALE[3])):
        picture = image.imread(draw_to(path, "figure.png"))
        assert picture.shape[0] > 1000 and picture.shape[1] > 1500
        assert share_of(picture, colour) > 1e-4
        assert 0.2 < share_of(picture, "#ffffff") < 0.95  # paper: neither blank nor blotted


@pytest.mark.parametrize("name", ["bands", "plane"])
def test_xarray_opens_every_group_with_named_axes_meanings_and_units(request, name):
    path = request.getfixturevalue(name)
    with h5py.File(path) as file:
        groups = list(file)
        assert groups == (["isotropic", "ordered"] if name == "bands" else ["band", "boundary", "map", "plane"])
    for group in groups:
        dataset = opened(path, group)
        assert len(dataset.data_vars) > 1
        for array in dataset.variables.values():
            assert array.attrs["units"] and array.attrs["long_name"]
            assert all(axis in dataset.coords for axis in array.dims)


def spoil(path, change):
    with h5py.File(path, "r+") as file:
        change(file)


@pytest.mark.parametrize("change, sentence", [
    (lambda file: file.attrs.__delitem__("scene"), "is HDF5 but not a drover archive"),
    (lambda file: file["ordered"].__delitem__("growth_rate"), "the group ordered has no growth_rate"),
    (lambda file: [file.__delitem__(name) for name in list(file)], "contains no uniform state"),
], ids=["no scene", "no growth", "no state"])
def test_a_wrong_file_is_rejected_with_a_message_and_no_figure(tmp_path, change, sentence):
    path = archive(tmp_path, "stability", SMALL, BANDING)
    spoil(path, change)
    done = draw(path, status=2)
    assert done.stderr.startswith("error: ") and sentence in done.stderr and done.stderr.count("\n") == 1
    assert not list(tmp_path.glob("*.png"))


@pytest.mark.parametrize("name, arguments, sentence", [
    ("bands", ["--state", "smectic"], 'has no state "smectic"; expected isotropic or ordered'),
    ("bands", ["--frame", "0"], "--frame 0 does not apply, since drover stability wrote this archive"),
    ("plane", ["--state", "ordered"], "--state ordered does not apply, since drover boundary wrote this archive")])
def test_an_option_of_another_kind_is_rejected_with_a_message(request, name, arguments, sentence):
    done = draw(request.getfixturevalue(name), *arguments, "--output", "none.png", status=2)
    assert sentence in done.stderr and done.stderr.count("\n") == 1


def test_each_opener_names_the_other(bands, plane):
    for path, group in ((bands, "ordered"), (plane, "plane")):
        with pytest.raises(package.DroverError, match=rf'drover.open_theory, or a group of it with .*group="{group}"'):
            package.open_run(path)
    scene = write_scene(bands.parent, {"time.end": 1.0, "output.frame_every": 0.5}, "run.toml")
    drover(bands.parent, "run", scene, "--quiet", "--output", "run.h5")
    with pytest.raises(package.DroverError, match="is a run; .*open it with drover.open_run"):
        package.open_theory(bands.with_name("run.h5"))


def test_a_growing_sound_is_drawn_beside_the_speeds(bands, tmp_path):
    path = tmp_path / "growing.h5"
    path.write_bytes(bands.read_bytes())
    spoil(path, lambda file: file["ordered/slow_growth"].__setitem__((slice(0, 3), 1), 0.1))
    axes = next(axes for axes in picture_of(path).axes if "speeds" in axes.get_title(loc="left"))
    assert [text.get_text() for text in axes.get_legend().get_texts()] == ["Re $u$", "Im $u$ (growth if positive)"]
    low, high = stability_panels.range_without_spikes(numpy.append(numpy.linspace(1.0, 2.0, 100), 1e6))
    assert low < 0.0 and 2.0 < high < 100.0


def test_curves_of_all_modes_have_no_jumps_and_no_kinks(tmp_path):
    """Two modes of the Brusselator are conjugate below |q| = 0.38 /mm: of equal growth, in no order of their own."""
    drover(tmp_path, "stability", MODELS / "brusselator.toml", "-o", "theory.h5")
    growth, frequency = figure.draw_file(tmp_path / "theory.h5").axes[:2]
    assert growth.get_yscale() == "asinh"  # smooth, where "symlog" has kinks
    for axes in (growth, frequency):
        curves = [axes.transData.transform(line.get_xydata())[:, 1] for line in axes.lines if len(line.get_xdata()) > 2]
        assert len(curves) == 2
        for curve in curves:  # an exchange of the modes would jump over the whole height
            assert abs(numpy.diff(curve)).max() < 0.25 * axes.bbox.height
