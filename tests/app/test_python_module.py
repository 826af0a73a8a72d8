"""tests/app/test_python_module.py: the compiled module: memory, signals, threads, errors, imports, edits."""
import gc
import os
import signal
import subprocess
import sys
import threading
import time
from pathlib import Path

import numpy as np
import pytest
from support import MODELS, SMALL, environment, wait_until

import drover

QUICK = {**SMALL, "time.end": 2.0}


def scene_of(**changes):
    return drover.Scene.from_dict({**QUICK, **changes})


def python(code, folder, seconds=60):
    """Runs Python code in a process of its own."""
    return subprocess.run([sys.executable, "-c", code], cwd=folder, capture_output=True, text=True, timeout=seconds,
                          env=environment(), check=True).stdout


def address(array):
    return array.__array_interface__["data"][0]


# --- scenes

def test_a_scene_is_the_same_from_a_file_a_text_and_a_dict(tmp_path):
    one = scene_of()
    (tmp_path / "one.toml").write_text(one.to_toml())
    assert drover.Scene.load(tmp_path / "one.toml") == drover.Scene.parse(one.to_toml()) == one
    nested = {}
    for key, value in QUICK.items():
        nested.setdefault(key.split(".")[0], {})[key.split(".")[1]] = value
    assert drover.Scene.from_dict(nested) == one and one["grid.nx"] == 16 and one.values["grid"]["nx"] == 16


def test_set_leaves_the_scene_as_it_was_and_takes_numbers_texts_and_lists():
    one = scene_of()
    other = one.set({"grid.nx": np.int64(32), "relaxation.rate": np.float64(0.25), "initial.kind": "uniform",
                     "sweep.vary": ["grid.ny = 8, 16"], "output.powers": True})
    assert one["grid.nx"] == 16 and other["grid.nx"] == 32 and other["sweep.vary"] == ["grid.ny = 8, 16"]
    assert other["output.powers"] is True and other["relaxation.rate"] == 0.25


def test_a_term_as_text_joins_a_scene():
    scene = scene_of().term("order", ["-W order_x", "-W order_y"], W=0.7)
    assert "W" in scene.to_toml() and scene.set("terms.W", 0.5) != scene
    with pytest.raises(drover.Error):
        scene_of().term("order", ["nonsense(", "0"])


def test_every_key_of_the_schema_has_a_description():
    scene = scene_of()
    assert "driving.strength" in scene.keys() and "cell.lx" not in scene.keys()
    assert scene.describe("driving.strength")["doc"] and all(scene.describe(key)["doc"] for key in scene.keys())
    assert scene._ipython_key_completions_() == scene.keys()


@pytest.mark.parametrize("make, place, finding, remedy", [
    (lambda: scene_of().set("grid.nx", 7), "--set grid.nx=7", "grid.nx = 7", "expected an even number >= 4"),
    (lambda: drover.Scene.parse("[grid]\nnx = 7\n", "one.toml"), "one.toml:2:1", "grid.nx = 7", "even"),
    (lambda: drover.Scene.load("none.toml"), "none.toml", "no such file", "expected a scene"),
    (lambda: scene_of().set("grid.nz", 7), "--set grid.nz=7", "nz", "nx"),
    (lambda: scene_of().describe("grid.nz"), "", "grid.nz", "scene.keys()"),
    (lambda: drover.Scene.from_dict({"nx": 4}), "", "nx = 4", "section.key"),
    (lambda: scene_of().start().advance(0.123), "", "0.123 s", "whole number of steps"),
    (lambda: drover.Scene.load(MODELS / "rod.toml").stability(), str(MODELS / "rod.toml"), "", ""),
    (lambda: drover.info("none.h5"), "", "none.h5", ""),
    (lambda: drover.sweep(scene_of(), {"grid.nz": [1]}), "", "grid.nz", ""),
])
def test_an_error_has_its_place_its_finding_and_its_remedy(make, place, finding, remedy):
    with pytest.raises(drover.Error) as raised:
        make()
    error = raised.value
    assert (error.place == place or not place) and finding in str(error) and remedy in error.remedy
    assert error.fault == "input" and isinstance(error, drover.DroverError)


# --- memory

def test_frames_are_views_of_the_memory_of_the_run():
    run = scene_of().start()
    frame = run.frame
    places = {name: address(array) for name, array in frame.arrays.items()}
    before = frame.rod_density.copy()
    assert len(places) == 3 and not any(array.flags.owndata or array.flags.writeable for array in frame.arrays.values())
    for later in run.every(0.5):
        assert {name: address(array) for name, array in later.arrays.items()} == places
    assert (frame.rod_density == later.rod_density).all() and (frame.rod_density != before).any()
    with run.edit() as fields:
        assert address(fields.rod_density) == places["rod_density"]
        fields.polar_order_x = 0.25  # the values of the array, not another attribute
        assert address(fields.polar_order_x) == places["polar_order_x"]
        with pytest.raises(AttributeError, match="no order; expected one of rod_density"):
            fields.order = 1.0
    assert run.frame.polar_order_x == pytest.approx(0.25, rel=1e-12)  # rounding of the transforms
    with pytest.raises(ValueError):
        frame.rod_density[0, 0] = 1.0


def test_the_flow_of_slaved_beads_and_bodies_keep_their_places():
    slaved = scene_of(**{"fields.bead_density": True, "fields.bead_velocity": "slaved", "drag.coefficient": 1.0,
                         "stiffness.beads": 1.0, "driving.strength": 0.5, "current.speed": 0.1, "noise.order": 0.0,
                         "noise.rods": 0.0, "initial.kind": "uniform"})
    particles = drover.Scene.load(MODELS / "bead-gas.toml").set({"cell.lx": 12, "cell.ly": 12, "time.end": 0.02})
    for scene, dt in ((slaved, 0.5), (particles, 0.005)):
        run = scene.start()
        places = [address(array) for array in run.frame.arrays.values()]
        for frame in run.every(dt):
            assert [address(array) for array in frame.arrays.values()] == places


def test_a_view_outlives_the_run_that_it_shows():
    density = scene_of().start().advance(0.5).rod_density
    gc.collect()
    other = [scene_of().start() for _ in range(20)]  # would reuse the memory
    assert np.isfinite(density).all() and abs(density.mean() - 2.0) < 1.0 and other


def memory_after(runs, folder):
    """By how much the memory of a process grows with so many runs [bytes], after a hundred."""
    code = f"""
import drover, resource
scene = drover.Scene.from_dict({QUICK!r})
def cycle(count):
    for _ in range(count):
        scene.start().advance(steps=1)
    return int(open("/proc/self/statm").read().split()[1]) * resource.getpagesize()
before = cycle(100)
print(cycle({runs}) - before)
"""
    return int(python(code, folder, seconds=300))


def test_runs_started_and_dropped_leak_nothing(tmp_path):
    # A run of 16 by 16 points holds 0.2 MB: a leak of one run in 10 exceeds this; 1000 runs are in the slow test.
    assert memory_after(100, tmp_path) < 2e6


# --- changed fields

def test_changed_fields_are_those_of_a_run_that_starts_from_them(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    keys = {"noise.order": 0.0, "noise.rods": 0.0, "relaxation.saturation": 0.5, "initial.kind": "formula",
            "initial.polar_order_x": "0.1 * sin(2 * pi * x / 16)", "output.frame_every": 1.0}
    scene = scene_of(**keys)
    run = scene.start()
    for _ in run.every(until=1.0):
        pass
    with run.edit() as fields:
        fields.polar_order_x[...] *= 2.0
    run.advance(1.0)
    assert run.was_changed
    other = scene_of(**{**keys, "initial.polar_order_x": "0.2 * sin(2 * pi * x / 16)"})
    # The fields of a linear wave double; the cubic term makes the difference.
    assert abs(run.frame.polar_order_x).max() < abs(other.start().frame.polar_order_x).max()
    scene.run("start.h5")
    del keys["initial.polar_order_x"]
    third = scene_of(**{**keys, "initial.kind": "file", "initial.file": str(tmp_path / "start.h5"),
                        "initial.frame": 1}).start()
    with third.edit() as fields:
        fields.polar_order_x[...] *= 2.0
    third.advance(1.0)
    # Rounding: the file holds the fields on the grid, the run the modes.
    assert np.allclose(run.frame.polar_order_x, third.frame.polar_order_x, rtol=1e-12, atol=1e-14)


@pytest.mark.parametrize("spoil", [lambda fields: fields.rod_density.__setitem__((3, 4), np.nan),
                                   lambda fields: 1 / 0])
def test_an_edit_that_fails_changes_nothing(spoil):
    run, other = scene_of().start(), scene_of().start()
    frame = run.frame
    with pytest.raises((drover.Error, ZeroDivisionError)):
        with run.edit() as fields:
            fields.polar_order_x[...] += 1.0
            spoil(fields)
    assert not run.was_changed and frame.polar_order_x.tobytes() == other.frame.polar_order_x.tobytes()
    assert run.advance(1.0).rod_density.tobytes() == other.advance(1.0).rod_density.tobytes()


# --- signals and threads

def interrupt_soon(seconds=0.3):
    threading.Timer(seconds, os.kill, (os.getpid(), signal.SIGINT)).start()


def interrupt_when(holds):
    def work():
        wait_until(holds, "a change")
        os.kill(os.getpid(), signal.SIGINT)
    threading.Thread(target=work).start()


def test_ctrl_c_stops_a_run_between_two_steps_and_leaves_it_usable():
    long = {"time.end": 1e7, "output.frame_every": 1e7, "output.sample_every": 1e7}
    run, other = scene_of(**long).start(), scene_of(**long).start()
    interrupt_soon()
    with pytest.raises(KeyboardInterrupt):
        run.advance(1e6)
    assert 0 < run.step < 10_000_000
    other.advance(steps=run.step)
    assert run.advance(steps=10).rod_density.tobytes() == other.advance(steps=10).rod_density.tobytes()
    assert signal.getsignal(signal.SIGINT) is signal.default_int_handler


def test_ctrl_c_stops_a_run_with_an_archive_after_a_checkpoint(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    # Frames are committed every second, samples alone every half minute.
    scene = scene_of(**{"time.end": 1e6, "output.frame_every": 100.0, "output.sample_every": 100.0})

    checkpoint = tmp_path / "stopped.h5.checkpoint-a"

    def last_change():
        return max((path.stat().st_mtime_ns for path in tmp_path.glob("stopped.h5*") if path.exists()), default=0)

    for run in (lambda: scene.run("stopped.h5"), lambda: drover.restart("stopped.h5")):
        before = last_change()
        interrupt_when(lambda: checkpoint.exists() and last_change() > before)  # pylint: disable=cell-var-from-loop
        with pytest.raises(KeyboardInterrupt):
            run()
        assert last_change() > before
    assert scene.set("time.end", 10.0).start().advance().time == 10.0  # the request to stop is over


def test_ctrl_c_stops_a_sweep_with_its_workers(tmp_path):
    scene = scene_of(**{"time.end": 1e6, "output.frame_every": 0.0, "output.sample_every": 100.0})
    interrupt_soon(1.5)
    with pytest.raises(KeyboardInterrupt):
        drover.sweep(scene, {"relaxation.rate": [0.4, 0.5]}, folder=tmp_path / "stopped", workers=2)
    kept = sorted(path.name for path in (tmp_path / "stopped").glob("*.h5"))
    assert len(kept) == 2
    time.sleep(0.3)
    sizes = [(tmp_path / "stopped" / name).stat().st_mtime_ns for name in kept]
    time.sleep(0.3)
    assert sizes == [(tmp_path / "stopped" / name).stat().st_mtime_ns for name in kept]  # nobody writes any more


def test_a_sweep_ends_when_its_process_is_killed(tmp_path):
    scene = scene_of(**{"time.end": 1e6, "output.frame_every": 0.0, "output.sample_every": 100.0})
    code = (f"import drover\nscene = drover.Scene.parse({scene.to_toml()!r})\n"
            "drover.sweep(scene, {'relaxation.rate': [0.4, 0.5]}, folder='killed', workers=2)")
    with subprocess.Popen([sys.executable, "-c", code], cwd=tmp_path, env=environment()) as process:
        folder = tmp_path / "killed"
        wait_until(lambda: len(list(folder.glob("*.checkpoint-a"))) == 2, "the runs of the sweep", process=process)
        process.kill()

    def runs_here(process):
        try:
            return os.readlink(process / "cwd") == str(tmp_path)
        except OSError:  # it has ended since it was listed
            return False

    wait_until(lambda: not any(map(runs_here, Path("/proc").glob("[0-9]*"))), "the end of the workers", seconds=20.0)


def test_two_runs_at_once_in_one_process_have_the_bytes_of_each_alone():
    scenes = [scene_of(**{"run.seed": seed, "grid.nx": 64, "grid.ny": 64, "time.end": 20.0}) for seed in (1, 2)]
    alone = [scene.start().advance().rod_density.copy() for scene in scenes]
    together = [None, None]

    def work(number):
        together[number] = scenes[number].start().advance().rod_density.copy()

    threads = [threading.Thread(target=work, args=(number,)) for number in (0, 1)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert [one.tobytes() for one in alone] == [one.tobytes() for one in together]


def test_python_goes_on_while_a_run_advances_and_a_second_user_of_it_gets_an_error():
    run = scene_of(**{"time.end": 1e7, "grid.nx": 64, "grid.ny": 64, "output.sample_every": 1e6,
                      "output.frame_every": 1e7}).start()
    thread = threading.Thread(target=lambda: run._session.advance(500))
    thread.start()
    count, refused = 0, 0
    while thread.is_alive():
        count += 1
        try:
            run.frame
        except drover.Error as error:
            refused += "another thread" in str(error)
    thread.join()
    assert count > 10 and refused > 0 and run.step == 500


def test_a_sweep_runs_beside_other_threads():
    busy, stop = [], threading.Event()
    threads = [threading.Thread(target=lambda: (busy.append(np.ones((200, 200)) @ np.ones((200, 200))), stop.wait()))
               for _ in range(3)]
    for thread in threads:
        thread.start()
    try:
        found = drover.sweep(scene_of(), {"relaxation.rate": [0.4, 0.5]}, workers=2)
    finally:
        stop.set()
        for thread in threads:
            thread.join()
    assert found.data.seeds.values.tolist() == [1, 1] and found.failed == 0


# --- the package

def test_the_package_loads_without_the_large_ones(tmp_path):
    code = """
import sys
import drover
scene = drover.Scene.from_dict({"grid.nx": 16, "grid.ny": 16})
print(*(name for name in ("numpy", "xarray", "matplotlib", "h5py") if name in sys.modules))
"""
    assert not python(code, tmp_path).split()  # they take ten times as long


def test_nothing_is_written_unless_it_is_asked_for(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    scene = scene_of()
    for frame in scene.start().every(1.0):
        frame.to_xarray()
    scene.stability()
    scene.explain()
    scene.check()
    assert not list(Path(tmp_path).iterdir())


def test_numpy_code_of_a_user_joins_in_less_than_ten_lines():
    start = scene_of(**{"noise.order": 0.0, "noise.rods": 0.0, "initial.kind": "uniform"}).start()
    x = np.arange(16) + 0.5
    with start.edit() as fields:                                                  # a start
        fields.rod_density[...] = 2.0 + 0.1 * np.cos(2 * np.pi * x / 16)[None, :]
    variance = [frame.rod_density.var() for frame in start.every(0.5)]            # an observable
    assert variance[0] == pytest.approx(0.005) and 0.0 < variance[-1] < variance[0]


def test_the_summary_has_the_mean_and_error_of_an_observable_of_the_user():
    # The same number as a built-in observable: the same samples, warm-up and blocks.
    run = scene_of(**{"time.end": 200.0, "output.sample_every": 0.5}).start()
    run.observe(lambda frame: frame.rod_density.var(), "own")
    late = scene_of(**{"time.end": 200.0, "output.sample_every": 0.5}).start()
    late.advance(100.0)
    late.observe(lambda frame: frame.polar_order_x.mean(), "late", "mm-2")
    for one in (run, late):
        one.advance()
    found = run.summary
    for ending in ("", "_error", "_autocorrelation_time"):
        assert float(found[f"own{ending}"]) == pytest.approx(float(found[f"variance_rod_density{ending}"]), rel=1e-9)
    assert found.own_autocorrelation_time.units == "s" and late.summary.late_error.units == "mm-2"
    samples = late.observables.late.values
    assert float(late.summary.late) == pytest.approx(np.nanmean(samples), rel=1e-12)
    for name in ("warm_up", "own_error", "two words"):
        with pytest.raises(drover.Error, match="cannot be called"):
            run.observe(lambda frame: 0.0, name)
    with pytest.raises(drover.Error, match='measures "polar_order" already'):
        run.observe(lambda frame: 0.0, "polar_order")
    with pytest.raises(drover.Error, match='"field" gave memmap|"field" gave ndarray of shape'):
        run.observe(lambda frame: frame.rod_density, "field")
    run.observe(lambda frame: 0.0, "field")  # the name is free


def test_an_observable_of_the_user_is_sampled_with_those_of_the_run_and_changes_nothing():
    scene = scene_of(**{"time.end": 3.0, "output.sample_every": 0.5})
    plain, observed = scene.start(), scene.start()
    observed.observe(lambda frame: float(frame.rod_density.var()), "own_variance", "mm-4")
    plain.advance()
    for _ in observed.every(0.7, until=2.8):  # not a multiple of the samples
        pass
    observed.advance()
    series = observed.observables
    assert series.own_variance.units == "mm-4" and len(series.own_variance) == 7
    assert np.allclose(series.own_variance, series.variance_rod_density, rtol=1e-9)
    assert np.array_equal(plain.frame.rod_density, observed.frame.rod_density)
    with pytest.raises(drover.Error, match="new name"):
        observed.observe(np.max, "polar_order")


def test_the_order_of_the_rods_of_a_cell_is_a_group_of_the_onset(tmp_path):
    table = MODELS / "matched.calibration" / "table.h5"
    theory = drover.onset(table, cell=45.0, points=[(0.6, 0.11), (0.2, 0.05)], output=tmp_path / "onset.h5")
    cells = theory.groups["cells"]
    assert cells.order.dims == ("cell",) and 0 < cells.order[1] < cells.order[0] < 1
    with drover.open_theory(tmp_path / "onset.h5") as kept:
        assert (kept.groups["cells"].order == cells.order).all()
    with pytest.raises(drover.Error, match="above 0"):
        drover.onset(table, cell=0.0)
