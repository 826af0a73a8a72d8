"""tests/app/test_python_runs.py: runs in Python have the bytes of those of the program, for every shipped scene."""
import copy
import pickle

import h5py
import numpy as np
import pytest
import xarray
from support import MODELS, SMALL, assert_same_bytes, drover as program, settings
from test_particle_scenes import SHORT as PARTICLES
from test_scenes import SHORT as FIELDS

import drover

SHORT = {**FIELDS, **PARTICLES}
STEPS = 12  # of each run, with a frame at every fourth and a sample at every second


def shortened(name):
    """A scene of models/ on the small grid or cell of its own test, for a few steps."""
    scene = drover.Scene.load(MODELS / f"{name}.toml")
    changes = dict(text.split("=") for text in SHORT[name])
    changes = {key: float(value) if "." in value else int(value) for key, value in changes.items()}
    dt = changes.get("time.dt", scene["time.dt"])
    return scene.set({**changes, "time.end": STEPS * dt, "output.frame_every": 4 * dt, "output.sample_every": 2 * dt,
                      "analysis.warm_up": -1.0, "run.threads": 1})


@pytest.mark.parametrize("name", sorted(SHORT))
def test_a_run_in_memory_has_the_bytes_of_the_program(name, tmp_path):
    scene = shortened(name)
    program(tmp_path, "run", MODELS / f"{name}.toml", *settings(scene.settings), "--quiet", "-o", "program.h5")
    run = scene.start()
    frames = [frame.to_xarray() for frame in run.every()]
    with h5py.File(tmp_path / "program.h5") as archive:
        for number, frame in enumerate(frames):
            for variable, array in frame.data_vars.items():
                row = stored(archive, variable)
                assert array.values.tobytes() == (row if row.ndim == array.ndim else row[number]).tobytes(), variable
        group = archive["observables" if scene.kind == "fields" else "series"]
        for variable in run.observables.variables:
            assert run.observables[variable].values.tobytes() == group[variable][()].tobytes(), variable
    assert len(frames) == 4 and len(run.observables.time) == 7


def stored(archive, variable):
    """The rows of an array of a frame in an archive, or a fixed array."""
    for prefix, group in (("bead_", "bodies/beads"), ("rod_", "bodies/rods")):
        path = f"{group}/{variable.removeprefix(prefix)}"
        if variable.startswith(prefix) and path in archive:
            return archive[path if isinstance(archive[path], h5py.Dataset) else path + "/value"][()]
    return archive[variable][()]


def test_an_archive_of_python_has_the_bytes_of_the_program_also_after_a_restart(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    scene = shortened("isotropic")
    with scene.run("python.h5") as run:
        assert run.frames.rod_density.sizes["time"] == 4 and run.summary is not None
    program(tmp_path, "run", MODELS / "isotropic.toml", *settings(scene.settings), "--quiet", "-o", "program.h5")
    assert_same_bytes("python.h5", "program.h5")
    end = 2 * scene["time.end"]
    with drover.restart("python.h5", end=end, threads=2) as run:
        assert float(run.frames.time[-1]) == end
    program(tmp_path, "restart", "program.h5", "--set", f"time.end={end}", "--quiet")
    assert_same_bytes("python.h5", "program.h5")


@pytest.mark.parametrize("command, scene", [("stability", "flock"), ("stability", "rods"), ("boundary", "flock")])
def test_theory_in_memory_equals_the_archive_of_the_program(command, scene, tmp_path):
    changes = {"stability.wavenumbers": 12, "stability.angles": 5, "boundary.map": 8, "boundary.chord": 0.03,
               "boundary.lines": ["onset", "banding"]}
    loaded = (drover.Scene.load(MODELS / "flock.toml").set(changes) if scene == "flock" else
              drover.Scene.load(MODELS / "isotropic.toml").set(changes))
    axes = {"x": ("driving.strength", 5.0, 60.0), "y": "relaxation.rate = 0.1:1.0"} if command == "boundary" else {}
    theory = getattr(loaded, command)(**axes)
    words = [word for name, key in (("--x", "driving.strength = 5:60"), ("--y", "relaxation.rate = 0.1:1"))
             for word in (name, key) if axes]
    program(tmp_path, command, loaded.name, *settings(loaded.settings), *words, "-o", "program.h5")
    with drover.open_theory(tmp_path / "program.h5") as archive:
        assert theory.groups.keys() == archive.groups.keys() and theory.kind == archive.kind
        for name, group in archive.groups.items():
            assert theory.groups[name].identical(group.load()), name
        main = archive.main.load()
    assert theory.main.identical(main)
    shown = program(tmp_path, command, loaded.name, *settings(loaded.settings), *words).stdout
    assert theory.text == shown


def test_a_sweep_has_the_table_of_the_program(tmp_path):
    scene = shortened("isotropic").set("run.threads", 0)
    found = drover.sweep(scene, {"relaxation.rate": [0.2, 0.4], "current.speed": "1:2:2"}, workers=2,
                         folder=tmp_path / "python.sweep")
    program(tmp_path, "sweep", scene.name, *settings(scene.settings), "--vary", "relaxation.rate = 0.2, 0.4",
            "--vary", "current.speed = 1:2:2", "--quiet", "-o", "program.sweep")
    tables = [(tmp_path / f"{name}.sweep" / "table.csv").read_text() for name in ("python", "program")]
    assert tables[0] == tables[1]
    mean = found.data.polar_order
    assert mean.dims == ("relaxation.rate", "current.speed") and mean.shape == (2, 2) and mean.attrs["units"]
    row = tables[1].splitlines()[2].split(",")  # relaxation.rate = 0.2, current.speed = 2
    column = [name.split(" ")[0] for name in tables[1].splitlines()[0].split(",")].index("polar_order")
    assert float(mean.sel({"relaxation.rate": 0.2, "current.speed": 2})) == float(row[column])


def test_a_sweep_says_why_a_job_failed():
    scene = drover.Scene.from_dict({**SMALL, "time.end": 2.0, "initial.kind": "random", "initial.amplitude": 0.1})
    with pytest.warns(UserWarning, match="1 jobs of the sweep failed: point-0001-seed-7: .*the run diverged"):
        found = drover.sweep(scene, {"relaxation.rate": [0.5, -200.0]}, workers=2)
    assert found.failed == 1 and len(found.failures) == 1 and found.failures[0] in repr(found)
    assert np.isfinite(found.polar_order[1]) and np.isnan(found.polar_order[0])
    with pytest.raises(drover.Error, match="no run of the sweep ended: point-0000-seed-7: .*the run diverged"):
        drover.sweep(scene, {"relaxation.rate": [-200.0]})


@pytest.mark.parametrize("changes", [{}, {"analysis.warm_up": 5.0}, {"noise.order": 0.0, "initial.kind": "uniform"}])
def test_a_run_in_memory_has_the_means_and_the_theory_of_its_archive(changes, tmp_path):
    scene = drover.Scene.from_dict({**SMALL, **changes}, "small.toml")
    run = scene.start()
    run.advance()
    with scene.run(tmp_path / "small.h5") as kept:
        assert set(run.summary.variables) <= set(kept.summary.variables)
        missing = set(kept.summary.variables) - set(run.summary.variables)
        assert all("step_bias" in name for name in missing)  # measured by runs with halved steps, into archives
        for name, values in run.summary.variables.items():
            assert values.values.tobytes() == kept.summary[name].values.tobytes(), name
            assert values.dims == kept.summary[name].dims and values.attrs["units"] == kept.summary[name].attrs["units"]


def test_the_means_of_a_run_of_particles_are_those_of_its_archive_without_paths(tmp_path):
    scene = shortened("bead-gas")
    run = scene.start()
    run.advance()
    with scene.run(tmp_path / "gas.h5") as kept:
        assert "bead_speed" in run.summary or len(run.summary) > 3
        for name, values in run.summary.variables.items():
            assert values.values.tobytes() == kept.summary[name].values.tobytes(), name


def test_a_run_at_its_start_has_no_means():
    with pytest.raises(drover.Error, match="advance it first"):
        drover.Scene.from_dict(SMALL).start().summary  # pylint: disable=expression-not-assigned


# --- copies, frames and keys

SMALLEST = {"grid": {"nx": 8, "ny": 4, "lx": 8.0, "ly": 4.0}, "time": {"dt": 0.1, "end": 1.0}, "relaxation.rate": 0.5,
            "noise.order": 0.1, "output.sample_every": 0.3, "output.frame_every": 0.5}


def test_an_open_run_is_copied_and_pickled(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    run = drover.Scene.from_dict(SMALLEST).run("small.h5")
    copied, pickled = run.frames.copy(deep=True), pickle.dumps(run)
    monkeypatch.chdir("/")
    other = pickle.loads(pickled)
    for frames in (copied, other.frames, run.frames.sortby("x")):
        assert np.array_equal(frames.polar_order_x.values, run.frames.polar_order_x.values)
    other.close()
    with copy.deepcopy(run):
        pass
    assert run.observables.polar_order.interp(time=0.15) > 0.0  # still open
    run.close()
    with pytest.raises(drover.Error, match="is closed"):
        pickle.loads(pickle.dumps(run)).observables.polar_order_mean_x.load()


def test_a_model_and_a_frame_are_copied_and_pickled():
    model = drover.Model([drover.Field("phi", "D lap mu", conserved=True, noise=0.5, conserved_noise=True)],
                         define={"mu": "phi + s phi^3"}, D=2.0, s=0.3)
    for other in (pickle.loads(pickle.dumps(model)), copy.deepcopy(model)):
        assert repr(other) == repr(model) and other.coefficients == model.coefficients
        assert np.array_equal(other.symbol((1.0, 0.5)), model.symbol((1.0, 0.5)))
    run = drover.Scene.from_dict(SMALLEST).start()
    frame = run.advance(0.5)
    kept = [pickle.loads(pickle.dumps(frame)), copy.deepcopy(frame), copy.copy(frame)]
    values = frame.polar_order_x.copy()
    run.advance(0.5)
    for one in kept:
        assert one.time == 0.5 and np.array_equal(one.polar_order_x, values)
        assert np.array_equal(one.to_xarray().polar_order_x, values)


def test_a_field_that_is_set_by_a_data_array_is_taken_by_its_dimensions():
    run = drover.Scene.from_dict(SMALLEST).start()
    values = np.add.outer(np.zeros(4), 2.0 + np.cos(np.arange(8) * np.pi / 4))  # a wave that the run keeps
    for given in (xarray.DataArray(values, dims=("y", "x")), xarray.DataArray(values.T, dims=("x", "y"))):
        with run.edit() as fields:
            fields.rod_density = given
        assert np.allclose(run.frame.rod_density, values, atol=1e-10)
    square = drover.Scene.from_dict({**SMALLEST, "grid": {"nx": 8, "ny": 8}}).start()
    ramp = np.tile(np.cos(np.arange(8) * np.pi / 4), (8, 1))
    with square.edit() as fields:
        fields.rod_density = xarray.DataArray(ramp.T, dims=("x", "y"))
    assert np.allclose(square.frame.rod_density, ramp, atol=1e-10)


def test_an_observable_of_the_users_own_is_sampled_at_an_end_off_the_schedule():
    run = drover.Scene.from_dict(SMALLEST).start()
    run.observe(lambda frame: frame.time, "now")
    run.advance()
    assert run.observables.now.values.tolist() == run.observables.time.values.tolist() == pytest.approx(
        [0.0, 0.3, 0.6, 0.9, 1.0])
    assert float(run.summary.now) == pytest.approx(np.mean([0.0, 0.3, 0.6, 0.9]))  # samples at equal times
    run.advance(0.5)
    assert run.observables.now.values.tolist() == pytest.approx([0.0, 0.3, 0.6, 0.9, 1.2, 1.5])
    assert run.observables.time.size == 6


def test_frames_are_exported_by_their_number_from_the_end(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    drover.Scene.from_dict(SMALLEST).run("small.h5").close()
    assert [path.name for path in drover.export("small.h5", "last.vtk", frame=-1)] == ["last.vtk"]
    drover.export("small.h5", "third.vtk", frame=2)
    assert (tmp_path / "last.vtk").read_bytes() == (tmp_path / "third.vtk").read_bytes()
    for options, words in (({"frame": -4}, "has no frame -4; expected 0 to 2"),
                           ({"frame": 1, "every": 2}, "frame = 1 and every = 2; expected one of them")):
        with pytest.raises(drover.Error, match=words):
            drover.export("small.h5", "none.vtk", **options)
    with pytest.raises(drover.Error, match='none.txt: the name ends with ".txt"; expected .xyz of particles, or .vtk'):
        drover.export("small.h5", "none.txt")
    with pytest.raises(drover.Error, match="every = 2.5; expected a whole number of frames"):
        drover.film("small.h5", "none.png", every=2.5)


def test_a_scene_has_its_keys():
    scene = drover.Scene.from_dict(SMALLEST)
    assert "grid.nx" in scene and "grid.foo" not in scene and "foo" not in scene and list(scene) == scene.keys()


def test_an_archive_that_exists_is_replaced_with_the_argument_that_the_error_names(tmp_path):
    scene, file = drover.Scene.from_dict(SMALLEST), tmp_path / "small.h5"
    scene.run(file).close()
    with pytest.raises(drover.Error, match="exists; choose another name, or give overwrite=True;"):
        scene.run(file)
    scene.run(file, overwrite=True).close()
