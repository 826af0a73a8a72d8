"""tests/app/test_compare.py: comparison of a calibrated field run with a particle run."""
import re
import shutil
import subprocess
import sys
import types

import h5py
import numpy
import pytest
import xarray
from matplotlib import image
from pictures import overlaps
from support import drover, environment, write_scene

import drover as package
from drover import compare, series_statistics, spectra
from drover.figures import compare_panels

SIDE = 15.0
FIELDS = {"fields.bead_density": True, "fields.bead_velocity": "dynamic", "uniform.rod_density": 0.03,
          "uniform.bead_density": 0.6,
          "current.speed": 2.0, "current.kind": "density-order", "inertia.bead_mass": 0.7, "drag.coefficient": 1.0,
          "driving.strength": 1.0, "viscosity.shear": 5.0, "stiffness.beads": 200.0, "relaxation.rate": 2.0,
          "elasticity.stiffness": 2.0, "weathercock.strength": 0.03, "pressure.rods": 40.0, "noise.order": 1.0,
          "grid.nx": 32,
          "grid.ny": 32, "grid.lx": SIDE, "grid.ly": SIDE, "time.dt": 0.05, "time.end": 60.0, "output.frame_every": 5.0,
          "output.sample_every": 0.1}
PARTICLES = {"cell.lx": SIDE, "cell.ly": SIDE, "plates.amplitude": 0.05, "plates.gap": 1.268,
             "contacts.max_overlap": 0.2,
             "beads.area_fraction": 0.3, "rods.count": 6, "time.dt": 5e-5, "time.end": 0.1, "output.frame_every": 0.02,
             "output.sample_every": 0.001}
# The section that drover stores for a calibrated scene.
CALIBRATED = '''[calibrated]
table = "table.h5"
bead_area_fraction = 0.3
rod_area_fraction = 0.11
expected = ["alignment = 2.319 +- 0.32", "effective_relaxation = -0.0102 +- 0.0097 1/s", "order = 0.5001 +- 0.19",
            "bead_velocity = 1.325 mm/s", "response_time = 1.8 +- 0.18 s"]
'''


def set_calibrated(path, text):
    """Replaces the section [calibrated] in the scene of an archive."""
    with h5py.File(path, "r+") as file:
        scene = file.attrs["scene"].decode() if isinstance(file.attrs["scene"], bytes) else file.attrs["scene"]
        kept = re.sub(r"^\[calibrated\]\n([^\[].*\n|\n)*", "", scene, flags=re.MULTILINE)
        file.attrs["scene"] = kept + "\n" + text


@pytest.fixture(scope="module", name="folder")
def a_folder_with_both_archives(tmp_path_factory):
    folder = tmp_path_factory.mktemp("both")
    for name, scene in (("fields", FIELDS), ("particles", PARTICLES)):
        drover(folder, "run", write_scene(folder, name=f"{name}.toml", base=scene), "--quiet", "--output", f"{name}.h5")
    set_calibrated(folder / "fields.h5", CALIBRATED)
    return folder


@pytest.fixture(scope="module", name="both")
def the_comparison_of_both(folder):
    with package.open_run(folder / "fields.h5") as fields, package.open_run(folder / "particles.h5") as particles:
        return compare.compare(fields, particles)


@pytest.fixture(name="copies")
def copies_that_a_test_may_spoil(folder, tmp_path):
    return [shutil.copy(folder / name, tmp_path / name) for name in ("fields.h5", "particles.h5")]


def command(folder, *arguments):
    line = [sys.executable, "-m", "drover.compare", *map(str, arguments)]
    return subprocess.run(line, capture_output=True, text=True, check=False, cwd=folder, env=environment())


# --- numbers

def test_numbers_come_from_the_table_and_both_archives(folder, both):
    assert both.expected == {"alignment": (2.319, 0.32), "effective_relaxation": (-0.0102, 0.0097),
                             "order": (0.5001, 0.19),
                             "bead_velocity": (1.325, 0.0), "response_time": (1.8, 0.18)}
    with h5py.File(folder / "particles.h5") as file:
        for key, name in compare.PARTICLE_SERIES.items():
            wanted = [file[f"summary/{part}"][()] for part in (name, f"{name}_error")]
            assert numpy.array_equal(both.particles.numbers[key], wanted, equal_nan=True)
    with h5py.File(folder / "fields.h5") as file:
        assert both.fields.numbers["order"][0] == file["summary/polar_order"][()]
        place = numpy.flatnonzero(file["observables/time"][()] == file["time"][-1])[0]
        last = {name: file[name][-1]
                for name in ("bead_density", "rod_density", *(f"{field}_{axis}" for axis in "xy" for field in
                                                  ("bead_velocity", "polar_order")))}
    v, n = (numpy.array([(last[density] * last[f"{name}_{axis}"]).mean() / last[density].mean() for axis in "xy"])
            # means over bodies
            for name, density in (("bead_velocity", "bead_density"), ("polar_order", "rod_density")))
    p = numpy.array([last[f"polar_order_{axis}"].mean() for axis in "xy"])
    for key, value in (("order", numpy.hypot(*n)), ("size", numpy.hypot(*v)), ("along", v @ p / numpy.hypot(*p))):
        assert both.fields.series[key][place] == pytest.approx(value, rel=1e-9)


def test_means_and_errors_from_blocks_agree_with_the_program(folder):
    compared = missing = 0
    for name in ("fields.h5", "particles.h5"):
        with package.open_run(folder / name) as run:
            scalars = [key for key in run.observables if run.observables[key].dims == ("time",)
                       and f"{key}_error" in run.summary]
            first = int(numpy.searchsorted(run.observables.time.values, float(run.summary.warm_up) * (1.0 - 1e-9)))
            # The summary has rates of work and impacts, and the last of a running maximum.
            for key in (key for key in scalars if not key.startswith(("work_", "impacts_", "overlap_"))):
                mean, error = series_statistics.mean_and_error(run.observables[key].values[first:])
                assert mean == pytest.approx(float(run.summary[key]), rel=1e-9, abs=1e-12), key
                assert error == pytest.approx(float(run.summary[f"{key}_error"]), rel=1e-6, abs=1e-12, nan_ok=True), key
                compared, missing = compared + 1, missing + numpy.isnan(error)
    assert compared > 20 and 0 < missing < compared


def test_the_last_sample_is_excluded_if_its_interval_is_short():
    assert [compare.ends_early(numpy.array(times))
            for times in ([0.0, 1.0, 2.0], [0.0, 1.0, 1.5], [0.0, 1.0])] == [False, True, False]


def test_the_table_says_where_a_run_is_too_short_for_an_error_and_leaves_unknown_numbers_out(both):
    assert [compare.number_text(*pair) for pair in ((0.5, 0.19), (0.5, 0.0), (0.5, numpy.nan))] == [
        "0.5 +- 0.19", "0.5", "0.5 (run too short for an error estimate)"]
    rows = {line.split("  ")[0]: re.split(r"  +", line)[1:] for line in compare.table_text(both).splitlines()
            if "  " in line}
    assert rows["alignment g"] == ["2.319 +- 0.32", "-", "-"]
    assert rows["polar order P"] == ["0.5001 +- 0.19",
                                     *(compare.number_text(*side.numbers["order"])
                                       for side in (both.fields, both.particles))]
    assert rows["bead velocity |<v>| [mm/s]"][0] == rows["bead velocity along the order [mm/s]"][0] == "1.325"


def test_area_fractions_follow_from_the_outlines_of_bodies(folder):
    with package.open_run(folder / "particles.h5") as run:
        assert compare.area_fraction(run, "bead") == 0.3
        assert 0.10 < compare.area_fraction(run, "rod") < 0.12
    two = compare.projected_area(numpy.array([-2.0, 2.0]), numpy.array([1.0, 0.5]))
    assert two == pytest.approx(1.25 * numpy.pi, rel=1e-3)  # disjoint circles; a sum over 2001 points


# --- structure factors

def random_rods(seed, count):
    draws = numpy.random.default_rng(seed)
    angle = draws.uniform(0.0, 2.0 * numpy.pi, count)
    return draws.uniform(0.0, SIDE, (count, 2)), numpy.column_stack([numpy.cos(angle), numpy.sin(angle)])


def test_independent_rods_have_unit_structure_factors():
    numbers = spectra.shells_of((SIDE, SIDE), 1.7).numbers
    found = numpy.array([spectra.body_factors(*random_rods(seed, 60), (SIDE, SIDE), numbers) for seed in range(200)])
    means = found.mean(axis=2)  # over some dozen waves
    for part in means.T:
        assert abs(part.mean() - 1.0) < 3.0 * part.std(ddof=1) / numpy.sqrt(len(part))
        assert part.std(ddof=1) / numpy.sqrt(len(part)) < 0.02


def test_direct_sums_agree_with_their_formula():
    places, axes = random_rods(1, 7)
    numbers = numpy.array([[0, 1], [2, -3], [1, 4]])
    sides = numpy.array([SIDE, 2.0 * SIDE])
    density, order = spectra.body_factors(places, 0.3 * axes, sides, numbers)  # only the direction counts
    for n, number in enumerate(numbers):
        waves = numpy.exp(-2j * numpy.pi * (places @ (number / sides)))
        assert density[n] == pytest.approx(abs(waves.sum()) ** 2 / 7)
        assert order[n] == pytest.approx((abs(axes.T @ waves) ** 2).sum() / 7)


def test_rods_with_a_wave_of_orientation_have_its_delta_peak():
    places = numpy.column_stack([numpy.arange(60) * SIDE / 60, numpy.zeros(60)])
    angle = 2.0 * numpy.pi * 2.0 * places[:, 0] / SIDE
    numbers = numpy.array([[n, 0] for n in range(1, 6)])
    density, order = spectra.body_factors(places, numpy.column_stack([numpy.cos(angle), numpy.sin(angle)]),
                                          (SIDE, SIDE), numbers)
    assert numpy.allclose(order, [0.0, 30.0, 0.0, 0.0, 0.0], atol=1e-12) and numpy.allclose(density, 0.0, atol=1e-12)


def field_run(kind, density, order):
    """A minimal run of one frame."""
    arrays = {"rod_density": density, "polar_order_x": order, "polar_order_y": numpy.zeros_like(order)}
    frames = xarray.Dataset({name: (("time", "y", "x"), array[None]) for name, array in arrays.items()})
    return types.SimpleNamespace(frames=frames, path="fields.h5",
                                 scene={"current": {"kind": kind}, "grid": {"lx": SIDE, "ly": 2 * SIDE}})


@pytest.mark.parametrize("kind", ["order", "density-order"])
def test_a_plane_wave_of_the_order_in_fields_has_its_delta_peak(kind):
    x, sigma, size = numpy.arange(16) / 16, 0.2, 0.4
    wave = numpy.tile(size * numpy.cos(2.0 * numpy.pi * 3.0 * x), (32, 1))
    run = field_run(kind, numpy.full((32, 16), sigma), sigma * wave if kind == "order" else wave)
    density, order = spectra.structure_factors(run, 2.0)
    count = sigma * 2.0 * SIDE**2
    sums = spectra.field_factors(run, 0, (SIDE, 2.0 * SIDE), numpy.array([[3, 0], [0, 3], [2, 0], [3, 1]]))
    assert numpy.allclose(sums[1], [count * (0.5 * size) ** 2, 0.0, 0.0, 0.0], atol=1e-12)
    assert numpy.allclose(density.mean, 0.0,
                          atol=1e-12) and order.mean.argmax() == 5  # 3 waves a side are 6 of the longer one


def test_structure_factors_of_fields_agree_with_the_program(folder):
    with package.open_run(folder / "fields.h5") as run:
        density, order = spectra.structure_factors(run, float(run.observables.wavenumber[-1]))
        at = run.observables.sel(time=run.frames.time[run.frames.sizes["time"] // 2:])
        mean = float(run.frames.rod_density.mean())
        assert numpy.allclose(density.x, run.observables.wavenumber, rtol=1e-12)
        assert numpy.allclose(density.mean, at.structure_factor_rods.mean("time") / mean, rtol=1e-8)
        sums = (at.structure_factor_order_along + at.structure_factor_order_across).mean("time") * mean
        assert numpy.allclose(order.mean, sums, rtol=0.2)  # of p there, of sigma p here


def test_shells_contain_one_of_each_pair_of_modes_and_none_is_empty():
    shells = spectra.shells_of((SIDE, 2.0 * SIDE), 10.2 * numpy.pi / SIDE)
    assert set(shells.shell) == set(range(10)) and len(shells.q) == 10
    pairs = {tuple(number) for number in shells.numbers}
    assert len(pairs) == len(shells.numbers) and not any((-x, -y) in pairs for x, y in pairs)
    assert len(spectra.shells_of((SIDE, SIDE), 0.9 * 2.0 * numpy.pi / SIDE).q) == 0


# --- figure and command

def test_the_figure_has_both_runs_the_band_and_no_overlaps(both):
    picture = compare_panels.draw(both, compare.heading(both))
    assert overlaps(picture) == []
    assert [axes.get_title(loc="left")[:3] for axes in picture.axes] == ["(a)", "(b)", "(c)", "(d)"]
    order = picture.axes[0]
    assert [line.get_ydata()[0] for line in order.lines if line.get_color() == compare_panels.GREY] == [0.5001]
    assert len(order.lines) == 3 and len(order.patches) == 1
    assert len(picture.axes[1].patches) == 0  # an error of zero has no band


def test_a_grid_without_shells_is_reported(both):
    nothing = tuple(type(result)(*(numpy.array([]) for _ in range(4))) for result in both.factors["rods"])
    picture = compare_panels.draw(compare.Comparison(both.expected, both.fields, both.particles,
                                                     {"rods": nothing, "order": nothing}), "x")
    assert "use a finer grid" in picture.axes[2].texts[0].get_text()


def test_the_command_prints_the_table_and_writes_the_figure(folder):
    done = command(folder, "fields.h5", "particles.h5")
    assert done.returncode == 0, done.stderr
    assert "polar order P" in done.stdout and done.stdout.strip().endswith("fields.compared.png")
    assert image.imread(folder / "fields.compared.png").shape[1] > 1500


def test_an_unfinished_run_has_means_over_its_second_half(copies):
    with h5py.File(copies[1], "r+") as file:
        del file["summary"]
        order = file["series/polar_order"][()]
    with package.open_run(copies[0]) as fields, package.open_run(copies[1]) as particles:
        both = compare.compare(fields, particles)
    assert both.particles.numbers["order"] == series_statistics.mean_and_error(order[len(order) // 2:])
    assert "is not finished" in compare.table_text(both)


# --- errors

def drop(path, name):
    with h5py.File(path, "r+") as file:
        del file[name]


def without_frames(path):
    with h5py.File(path, "r+") as file:
        for name in ("time", *(name for name in file if file[name] and getattr(file[name], "ndim", 0) == 3)):
            file[name].resize(0, axis=0)


@pytest.mark.parametrize("spoil, message", [
    (lambda fields, particles: without_frames(fields), "fields.h5 contains no frames"),
    (lambda fields, particles: drop(particles, "series/bead_velocity_along_order"), "has no series "
     "bead_velocity_along_order"),
    (lambda fields, particles: drop(fields, "observables/bead_velocity_mean_x"), "has no series bead_velocity_mean_x"),
], ids=["no frame", "no series", "no velocity"])
def test_incomplete_archives_are_rejected_with_a_message(copies, tmp_path, spoil, message):
    spoil(*copies)
    with pytest.raises(package.DroverError) as error:
        compare.compare_files(*copies)
    assert message in str(error.value) and str(tmp_path) in str(error.value) and "\n" not in str(error.value)


def set_section(run, section, **keys):
    run.scene[section].update(keys)


@pytest.mark.parametrize("spoil, message", [
    (lambda fields, particles: set_section(fields, "calibrated", table=""), "has no calibrated.table; expected a "
     "calibrated field run"),
    (lambda fields, particles: fields.scene.pop("calibrated"), "has no calibrated.table; expected a calibrated"),
    (lambda fields, particles: set_section(fields, "calibrated", expected=[]), "has no alignment"),
    (lambda fields, particles: set_section(fields, "calibrated", expected=["alignment = much"]), "has no "
     "alignment"),
    (lambda fields, particles: set_section(fields, "calibrated", bead_area_fraction=0.32),
     "the area fraction of its beads is 0.3; expected calibrated.bead_area_fraction = 0.32"),
    (lambda fields, particles: set_section(particles, "rods", area_fraction=0.05),
     "the area fraction of its rods is 0.05; expected calibrated.rod_area_fraction = 0.11"),
    (lambda fields, particles: set_section(particles, "cell", shape="circle"), 'cell.shape = "circle"; expected '
     '"periodic"'),
], ids=["no table", "no section", "nothing expected", "no number", "beads", "rods", "walls"])
def test_scenes_that_cannot_be_compared_are_rejected_with_a_message(folder, spoil, message):
    with package.open_run(folder / "fields.h5") as fields, package.open_run(folder / "particles.h5") as particles:
        spoil(fields, particles)
        with pytest.raises(package.DroverError) as error:
            compare.compare(fields, particles)
    assert message in str(error.value) and str(folder) in str(error.value) and "\n" not in str(error.value)


@pytest.mark.parametrize("names, message", [
    (("particles.h5", "particles.h5"), "is a particle run; expected first a field run"),
    (("fields.h5", "fields.h5"), "is a field run; expected a particle run as the second archive")])
def test_a_wrong_kind_of_archive_is_rejected_with_a_message(folder, names, message):
    with pytest.raises(package.DroverError, match=re.escape(message)):
        compare.compare_files(*(folder / name for name in names))


def test_the_command_fails_without_printing_a_table_or_writing_a_figure(folder):
    done = command(folder, "none.h5", "particles.h5", "--output", "none.png")
    assert done.returncode == 2 and done.stdout == "" and not (folder / "none.png").exists()
    assert done.stderr == "error: none.h5 does not exist; expected an archive: drover run SCENE writes one\n"
