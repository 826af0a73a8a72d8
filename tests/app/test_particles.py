"""tests/app/test_particles.py: run, restart, sweep, explain, export and figures of scenes of particles."""
import json
import signal
import subprocess
import sys

import h5py
import numpy
import pytest
from matplotlib import image
from pictures import overlaps
from rejection import rejected
from scipy import stats
from support import (attributes, contents, drover, drover_json, end_group, environment, scene_text,
                     slow_but, start, tree, wait_until, write_scene)

import drover as package
from drover.figures import particle_figure, particle_panels

# Some dozens of bodies for a few periods of the plates: at most a second.
TINY = {
    "cell.lx": 24.0,
    "cell.ly": 18.0,
    "beads.count": 24,
    "rods.count": 6,
    "time.end": 0.02,
    "output.frame_every": 0.002,
    "output.sample_every": 0.0005,
    "run.seed": 7,
}
LONG = {**TINY, "time.end": 0.1, "output.checkpoint_minutes": 0.0}
SPHERES = 24 + 6 * 13


def write_tiny(folder, changes=None, name="tiny.toml", base=None):
    return write_scene(folder, changes, name=name, base=TINY if base is None else base)


@pytest.fixture(scope="module")
def ran(tmp_path_factory):
    """A folder with the tiny scene and its archive."""
    folder = tmp_path_factory.mktemp("tiny")
    drover(folder, "run", write_tiny(folder), "--quiet")
    return folder


def assert_same(one, other):
    a, b = contents(one), contents(other)
    assert {"particles/spheres/position/value", "bodies/rods/axis/value", "series/polar_order",
            "summary/polar_order"} <= set(a)
    assert sorted(a) == sorted(b)
    assert [name for name in a if a[name] != b[name]] == []


def frames_of(path):
    try:
        with h5py.File(path) as file:
            return len(file["particles/spheres/position/time"])
    except (OSError, KeyError, RuntimeError):
        return 0


def test_a_run_prints_means_with_errors_and_leaves_an_archive(tmp_path):
    ended = drover(tmp_path, "run", write_tiny(tmp_path))
    assert "polar_order " in ended.stdout and "energy_kinetic" in ended.stdout and "error" in ended.stdout
    assert "24 beads and 6 rods, 1000 steps" in ended.stderr and "impacts: " in ended.stderr
    assert "balanced to" in ended.stderr
    with h5py.File(tmp_path / "tiny.h5") as file:
        assert file["particles/spheres/position/value"].shape == (11, SPHERES, 3)
        assert list(file["particles/spheres/position/step"]) == list(range(0, 1001, 100))
        assert file["series/polar_order"].shape == (41,)
        assert numpy.isfinite(file["summary/polar_order"][()])


def test_body_frames_agree_with_sphere_frames(ran):
    with h5py.File(ran / "tiny.h5") as file:
        spheres, rods = file["particles/spheres"], file["bodies/rods"]
        body, edges = spheres["body"][:], numpy.diag(spheres["box/edges/value"][0])
        places = spheres["position/value"][:] + spheres["image/value"][:] * edges
        for rod in range(6):
            at = rods["sphere_at"][rod]
            expected = rods["position/value"][:, rod][:, None] + at[:, None] * rods["axis/value"][:, rod][:, None]
            assert numpy.allclose(places[:, body == 24 + rod], expected, rtol=0, atol=1e-12)  # rounding
        assert numpy.allclose(numpy.linalg.norm(rods["axis/value"][:], axis=-1), 1.0, rtol=0, atol=1e-9)


def test_half_a_run_and_a_restart_equal_an_uninterrupted_run(ran, tmp_path):
    drover(tmp_path, "run", write_tiny(tmp_path, {"time.end": 0.011}), "--quiet")
    drover(tmp_path, "restart", "tiny.h5", "--set", "time.end=0.02", "--quiet")
    assert_same(ran / "tiny.h5", tmp_path / "tiny.h5")
    whole, resumed = attributes(ran / "tiny.h5"), attributes(tmp_path / "tiny.h5")
    other = {name for name in whole if whole[name] != resumed[name]}
    assert other <= {"run_id", "start_time", "scene"}  # with its output.file


@pytest.mark.parametrize("sent, status", slow_but([(signal.SIGTERM, 3), (signal.SIGKILL, -9)], (signal.SIGTERM, 3)))
def test_a_stopped_or_killed_run_resumes_to_the_same_bytes(sent, status, tmp_path):
    drover(tmp_path, "run", write_tiny(tmp_path, base=LONG, name="whole.toml"), "--quiet")
    write_tiny(tmp_path, base=LONG, name="cut.toml")
    process = start(tmp_path, "run", "cut.toml", "--quiet")
    try:
        wait_until(lambda: frames_of(tmp_path / "cut.h5") >= 4, "four frames", process=process)
        process.send_signal(sent)
        process.wait(timeout=60)
    finally:
        end_group(process)
    if process.returncode != 0:  # it was quicker than the signal
        assert process.returncode == status
        drover(tmp_path, "restart", "cut.h5", "--quiet")
    assert_same(tmp_path / "whole.h5", tmp_path / "cut.h5")


def test_another_run_starts_from_a_frame(ran, tmp_path):
    write_tiny(tmp_path,
               {"packing.kind": "file", "packing.file": str(ran / "tiny.h5"), "packing.frame": 5, "time.end": 0.002})
    drover(tmp_path, "run", "tiny.toml", "--quiet")
    with h5py.File(ran / "tiny.h5") as one, h5py.File(tmp_path / "tiny.h5") as other:
        for name in ("bodies/beads/position", "bodies/rods/position", "bodies/rods/axis"):
            before, after = one[f"{name}/value"][5], other[f"{name}/value"][0]
            assert numpy.array_equal(before[:, :2], after[:, :2]), name


def test_a_run_from_a_frame_of_another_does_not_repeat_its_kicks(tmp_path):
    """200 rods alone: of independent kicks the turns correlate by 1/sqrt(200) = 0.07; of the same ones by 0.4."""
    changes = {"cell.lx": 400.0, "cell.ly": 400.0, "rods.count": 200, "kick.strength": 0.015, "plates.amplitude": 0.05,
               "plates.gap": 1.268, "time.end": 1.0, "output.frame_every": 0.02, "output.sample_every": 0.1}
    turns = []
    for name, more in (("one", {}), ("two", {"packing.kind": "file", "packing.file": "one.h5"})):
        write_tiny(tmp_path, {**changes, **more}, f"{name}.toml", base={"run.seed": 7})
        drover(tmp_path, "run", f"{name}.toml", "--quiet")
        with h5py.File(tmp_path / f"{name}.h5") as run:
            axis = run["bodies/rods/axis/value"][:]
        angles = numpy.unwrap(numpy.arctan2(axis[..., 1], axis[..., 0]), axis=0)
        turns.append(angles[-1] - angles[0])
    assert abs(numpy.corrcoef(*turns)[0, 1]) < 0.28  # four standard deviations


def test_a_packing_of_other_bodies_is_rejected(ran, tmp_path):
    given = {"packing.kind": "file", "packing.file": str(ran / "tiny.h5")}
    for changes, says in (({"beads.count": 23}, "other bodies"), ({"rods.count": 5}, "other bodies"),
                          ({"rods.length": 5.0}, "/bodies/rods/sphere_at differs from this scene"),
                          ({"beads.diameters": [0.9]}, "/bodies/beads/radius differs from this scene"),
                          ({"packing.frame": 11}, "packing.frame = 11; expected one of the frames 0 to 10"),
                          ({"cell.lx": 25.0},
                           "lies in a periodic cell of 24 by 18 mm and this scene in a periodic cell of 25 by 18 mm"),
                          ({"cell.shape": "circle"},
                           "and this scene in a circle of radius 25 mm; expected the same cell"),
                          ({"packing.file": "none.h5"}, "packing.file: none.h5: does not exist"),
                          ({"packing.file": "tiny.toml"}, "is not an HDF5 file")):
        write_tiny(tmp_path, {**given, **changes})
        rejected(tmp_path, ["run", "tiny.toml"], ["tiny.toml:", says])


def test_invalid_scenes_are_rejected_with_their_place(tmp_path):
    for changes, says in (({"grid.nx": 16}, "[grid] belongs to a scene of fields, [cell]"),
                          ({"uniform.rod_density": 1.0}, "[uniform] belongs to a scene of fields"),
                          ({"time.stepper": "etdrk4"}, "time.stepper is for scenes of fields"),
                          ({"output.powers": True}, "output.powers is for scenes of fields"),
                          ({"beads.diamters": [0.8]}, "unknown key beads.diamters; did you mean beads.diameters?"),
                          ({"beads.diameters": [1.3]}, "bad.toml:7:1: plates.gap = 1.2 mm, with bodies 1.3 mm thick"),
                          ({"beads.diameters": 0.8},
                           "expected a list of numbers > 0 [mm]: diameters of the beads, one for each component"),
                          ({"beads.diameters": [0.7, 0.8]}, "bad.toml:7:1: beads.proportions has 1 numbers beside 2"),
                          ({"beads.count": 2000}, "bad.toml:6:1: beads cover 2.327 and rods"),
                          ({"kick.strength": -0.1}, "kick.strength = -0.1; expected a number >= 0"),
                          ({"time.dt": 1e-3, "output.frame_every": 0.0, "output.sample_every": 0.0},
                           "time.dt = 0.001 s is 5 steps a period of plates.frequency = 200 1/s; expected at least 20"),
                          ({"contacts.substep": 1.0}, ": otherwise rods penetrate the plates"),
                          ({"time.end": 0.02001}, "is not a whole number of steps"),
                          ({"cell.shape": "square"}, 'cell.shape = "square"; expected one of')):
        (tmp_path / "bad.toml").write_text(scene_text({**TINY, **changes}))
        rejected(tmp_path, ["check", "bad.toml"], ["bad.toml:", says])
    write_tiny(tmp_path)
    for command in ("stability", "boundary"):
        rejected(tmp_path, [command, "tiny.toml"],
                 ["a scene of particles", f"drover {command} needs a scene of fields"])


def test_a_sweep_and_a_ramp_write_tables(tmp_path):
    write_tiny(tmp_path, {"time.end": 0.004})
    rows = json.loads(drover(tmp_path, "sweep", "tiny.toml", "--vary", "kick.strength = 0.01, 0.02", "--seeds", "2",
                             "--json", "--workers", "1", "--quiet").stdout)
    assert [row["kick.strength"] for row in rows] == [0.01, 0.02] and all("polar_order" in row for row in rows)
    drover(tmp_path, "sweep", "tiny.toml", "--vary", "kick.strength = 0.01, 0.02", "--ramp", "up-down",
           "--workers", "1", "--quiet", "-o", "ramp")
    archives = sorted((tmp_path / "ramp").glob("*.h5"))
    assert len(archives) == 3
    with h5py.File(archives[0]) as one, h5py.File(archives[1]) as other:
        assert numpy.array_equal(one["bodies/rods/axis/value"][-1], other["bodies/rods/axis/value"][0])
    rejected(tmp_path, ["sweep", "tiny.toml", "--vary", "rods.count = 4, 5", "--ramp", "up", "-o", "other"],
            ["sweep.ramp", "rods.count", "of the same bodies in one cell"])


def speeds_along(folder, skip):
    """Mean speed along n of each rod, from frame to frame."""
    with h5py.File(folder / "tiny.h5") as file:
        places, axes = (file[f"bodies/rods/{name}/value"][skip:, :, :2] for name in ("position", "axis"))
        spacing = file["bodies/rods/position/time"][1]
    directions = axes[:-1] / numpy.linalg.norm(axes[:-1], axis=-1, keepdims=True)
    return (numpy.diff(places, axis=0) * directions).sum(axis=-1).mean(axis=0) / spacing


def test_a_run_reports_the_statistics_of_its_paths(tmp_path):
    write_tiny(tmp_path, {"analysis.warm_up": 0.003})
    results = json.loads(drover(tmp_path, "run", "tiny.toml", "--json", "--quiet").stdout)["results"]
    speeds = speeds_along(tmp_path, 2)  # the frame at 0.002 s belongs to the warm-up
    assert results["rod_speed"]["mean"] == pytest.approx(speeds.mean(), rel=1e-9)
    assert "0.002 s" in results["rod_speed"]["formula"] and results["rod_speed"]["error"] > 0.0
    assert results["rod_head_first_fraction"]["mean"] == pytest.approx((speeds > 0).mean(), rel=1e-9)
    assert abs(results["rod_speed_deviation"]["mean"] - speeds.std(ddof=1)) < results["rod_speed_deviation"]["error"]
    with h5py.File(tmp_path / "tiny.h5") as file:
        steps = numpy.diff(file["bodies/beads/position/value"][2:, :, :2], axis=0)
        assert results["bead_displacement_squared"]["mean"] == pytest.approx((steps**2).sum(axis=-1).mean(), rel=1e-9)
        for name in ("rod_speed", "rotational_diffusion", "relaxation_time", "bead_displacement_squared"):
            assert file[f"summary/{name}"][()] == pytest.approx(results[name]["mean"], rel=1e-12)
        assert file["summary/rotational_diffusion"].attrs["units"] == b"rad2 s-1"
    assert "rod_head_first_fraction" in drover(tmp_path, "info", "tiny.h5").stdout


def test_a_run_without_enough_frames_omits_paths(tmp_path):
    write_tiny(tmp_path, {"output.frame_every": 0.0})
    words = drover(tmp_path, "run", "tiny.toml").stdout
    assert "polar_order" in words and "rod_speed " not in words
    write_tiny(tmp_path, {"output.frame_every": 0.01, "analysis.warm_up": 0.015})
    speed = json.loads(drover(tmp_path, "run", "tiny.toml", "--overwrite", "--json").stdout)["results"]["rod_speed"]
    assert speed["mean"] is None
    assert "1 frame after the warm-up, one every 0.01 s; expected two or more" in speed["refusal"]


def test_a_sweep_takes_means_over_seeds_of_single_rods(tmp_path):
    write_tiny(tmp_path, {"beads.count": 0, "rods.count": 1, "output.frame_every": 0.0005, "analysis.warm_up": 0.0})
    row, other = json.loads(drover(tmp_path, "sweep", "tiny.toml", "--vary", "beads.count = 0, 2", "--seeds", "8",
                                   "--json", "--workers", "1", "--quiet").stdout)
    archives = sorted((tmp_path / "tiny.sweep").glob("point-0000-*.h5"))
    runs = [drover_json(tmp_path, "info", archive)["results"] for archive in archives]
    for name in ("rod_speed", "rod_head_first_fraction", "rotational_diffusion"):
        means = numpy.array([run[name]["mean"] for run in runs])
        assert row[name]["mean"] == pytest.approx(means.mean(), rel=1e-9, abs=1e-12)
        # Student's t of 68.27 % for 7 degrees of freedom; abs: rounding
        expected = stats.t.ppf(0.841344746, 7) * means.std(ddof=1) / 8**0.5
        assert row[name]["error"] == pytest.approx(expected, rel=1e-6, abs=1e-12)
    assert all(run["rod_head_first_fraction"]["error"] is None for run in runs)
    if row["rotational_diffusion"]["mean"] > 0.0:
        assert row["relaxation_time"]["mean"] == pytest.approx(1.0 / row["rotational_diffusion"]["mean"])
    # A result that only the runs of one point have is in a separate column.
    assert row["bead_displacement_squared"]["mean"] is None and other["bead_displacement_squared"]["mean"] is not None
    assert other["rod_speed"]["mean"] == pytest.approx(numpy.mean(
        [drover_json(tmp_path, "info", archive)["results"]["rod_speed"]["mean"]
         for archive in sorted((tmp_path / "tiny.sweep").glob("point-0001-*.h5"))]), rel=1e-9)


def test_explain_reports_bodies_and_cost(tmp_path):
    write_tiny(tmp_path)
    words = drover(tmp_path, "explain", "tiny.toml").stdout
    assert "\n  24 beads\n" in words and "\n  6 rods\n" in words
    assert "area fraction" in words and "acceleration" in words
    told = drover_json(tmp_path, "explain", "tiny.toml")
    assert told["spheres"] == SPHERES and told["steps"] == 1000 and told["steps_per_period"] == pytest.approx(250.0)
    assert told["disk_bytes"] > 0 and told["memory_bytes"] > 0 and told["seconds_estimate"] > 0.0
    assert tree(tmp_path).keys() == {"tiny.toml"}


def test_schema_reports_which_scenes_have_a_section(tmp_path):
    kinds = {section["name"]: section.get("kind")
             for section in json.loads(drover(tmp_path, "schema", "--json").stdout)}
    assert kinds["grid"] == "fields" and kinds["rods"] == "particles" and kinds["time"] is None


def test_info_reports_the_content_of_an_archive(ran):
    words = drover(ran, "info", "tiny.h5").stdout
    for line in ("frames               11, t = 0 to 0.02 s", f"spheres              {SPHERES}",
                 "beads                24",
                 "rods                 6", "cell                 periodic: 24 by 18 by 1.28 mm", "polar_order "):
        assert line in words, words
    assert "polar_order" in drover_json(ran, "info", "tiny.h5")["results"]


def read_xyz(path):
    """Frames of an extended XYZ file: comment line, rows of words."""
    lines = iter(path.read_text().splitlines())
    return [(next(lines), [next(lines).split() for _ in range(int(count))]) for count in lines]


def test_exported_spheres_are_those_of_the_archive(ran, tmp_path):
    drover(tmp_path, "export", ran / "tiny.h5", "-o", "all.xyz", "--every", "5")
    frames = read_xyz(tmp_path / "all.xyz")
    assert len(frames) == 3 and 'pbc="T T F"' in frames[0][0] and "Time=0.02" in frames[2][0]
    with h5py.File(ran / "tiny.h5") as file:
        for number, (_, rows) in zip((0, 5, 10), frames):
            numbers = numpy.array([row[1:] for row in rows], dtype=float)
            for name, columns in (("position", slice(0, 3)), ("velocity", slice(4, 7))):
                assert numpy.allclose(numbers[:, columns], file[f"particles/spheres/{name}/value"][number], rtol=1e-8,
                                      atol=1e-12)
            assert (numbers[:, 3] == file["particles/spheres/radius"][:].round(9)).all()
            assert (numbers[:, 8] == file["particles/spheres/body"][:]).all()
            assert [row[0] for row in rows] == ["B"] * 24 + ["Rh"] * 78
    words = drover(tmp_path, "info", "all.xyz").stdout
    assert "frames               3, t = 0 to 0.02 s" in words and f"particles            {SPHERES}" in words
    assert "radius:R:1" in words


def test_exported_bodies_have_their_direction(ran, tmp_path):
    drover(tmp_path, "export", ran / "tiny.h5", "-o", "bodies.xyz", "--bodies", "--frame", "10")
    (head, rows), = read_xyz(tmp_path / "bodies.xyz")
    assert "director:R:3" in head and len(rows) == 30
    with h5py.File(ran / "tiny.h5") as file:
        axes = numpy.array([row[5:8] for row in rows[24:]], dtype=float)
        assert numpy.allclose(axes, file["bodies/rods/axis/value"][10], rtol=0, atol=1e-8)


def test_an_impossible_export_is_rejected_and_leaves_no_file(ran, tmp_path):
    (tmp_path / "kept.xyz").write_text("precious")
    archive = ran / "tiny.h5"
    for words, says in ((["-o", "kept.xyz"], "exists"), (["-o", "kept.xyz", "--overwrite"], "not an XYZ file"),
                        (["-o", "new.xyz", "--frame", "11"], "has no frame 11; expected one of 0 to 10"),
                        (["-o", "no/new.xyz"], 'the folder "no" does not exist'),
                        (["-o", archive, "--overwrite"], 'the name ends with ".h5"')):
        rejected(tmp_path, ["export", archive, *words], [says])
    drover(tmp_path, "export", archive, "-o", "new.xyz", "--frame", "0")
    drover(tmp_path, "export", archive, "-o", "new.xyz", "--frame", "1", "--overwrite")


def test_python_opens_a_run_of_particles(ran):
    with package.open_run(ran / "tiny.h5") as run:
        assert isinstance(run, package.ParticleRun)
        assert run.frames.rod_axis.dims == ("time", "rod", "component") and run.frames.sizes["time"] == 11
        assert run.spheres.position.shape == (11, SPHERES, 3) and run.scene["rods"]["count"] == 6
        flat = run.frames.rod_axis.values[..., :2]
        axes = (flat / numpy.linalg.norm(flat, axis=-1, keepdims=True)).mean(axis=1)
        every = run.observables.polar_order.sel(time=run.frames.time, method="nearest")
        assert numpy.allclose(every.values, numpy.hypot(*axes.T), rtol=1e-9, atol=1e-12)
        assert float(run.summary.polar_order) > 0.0


@pytest.mark.parametrize("shape", ["rectangle", "circle", "flower"])
def test_the_figure_draws_walls_of(shape, tmp_path):
    write_tiny(tmp_path, {"cell.shape": shape, "cell.radius": 14.0, "time.end": 0.002})
    drover(tmp_path, "run", "tiny.toml", "--quiet")
    with package.open_run(tmp_path / "tiny.h5") as run:
        assert overlaps(particle_figure.draw(run)) == []


def test_the_figure_shows_rods_by_their_direction(tmp_path):
    write_tiny(tmp_path, {"time.end": 0.002, "packing.kind": "aligned"})
    drover(tmp_path, "run", "tiny.toml", "--quiet")
    ended = subprocess.run([sys.executable, "-m", "drover.figure", "tiny.h5", "--frame", "0", "--output", "x.png"],
                           cwd=tmp_path, capture_output=True, text=True, env=environment(), check=False)
    assert ended.returncode == 0, ended.stderr
    picture = image.imread(tmp_path / "x.png")[..., :3]
    along = particle_panels.direction_colours(0.0)
    assert (abs(picture - along).max(axis=2) < 0.03).mean() > 0.005  # six rods, all along x
    with package.open_run(tmp_path / "tiny.h5") as run:
        assert overlaps(particle_figure.draw(run)) == []
        with pytest.raises(package.DroverError, match="has no frame 2; expected 0 to 1"):
            particle_figure.draw(run, 2)


def test_an_outline_encloses_all_spheres_tightly():
    at, radius = numpy.array([-1.0, 0.0, 0.5]), numpy.array([0.55, 0.44, 0.36])
    z, half = particle_panels.outline(at, radius)
    assert z[0] == pytest.approx(-1.55) and z[-1] == pytest.approx(0.86)
    assert half[0] == half[-1] == pytest.approx(0.0, abs=1e-6)
    for a, r in zip(at, radius):
        inside = numpy.abs(z - a) < r
        assert (half[inside] >= numpy.sqrt(r**2 - (z[inside] - a)**2) - 1e-12).all()
    assert half.max() < 0.5501
