"""tests/app/test_sweep.py: sweeps: grids, seeds, ramps, resuming, and the exact values of the linear model."""
import csv
import json
import math

import h5py
import numpy as np
import pytest
import xarray
from rejection import rejected
from support import (assert_same_bytes, drover, drover_json, end_group, not_sanitized, start, wait_until,
                     write_scene)

BRIEF = {"time.end": 10.0, "output.frame_every": 5.0, "output.sample_every": 0.5}


def table_of(folder):
    """The rows of a sweep's table, as dictionaries by the heading."""
    with open(folder / "table.csv", newline="", encoding="utf-8") as file:
        return list(csv.DictReader(file))


def test_a_grid_of_two_keys_and_seeds_runs_every_combination_once(tmp_path):
    scene = write_scene(tmp_path, BRIEF)
    drover(tmp_path, "sweep", scene, "--vary", "relaxation.rate = 0.5:2.5:3", "--vary", "noise.order = 0.01, 0.04",
           "--seeds", "2")
    rows = table_of(tmp_path / "flock.sweep")
    assert [(float(row["relaxation.rate"]), float(row["noise.order"])) for row in rows] == [
        (rate, noise) for rate in (0.5, 1.5, 2.5) for noise in (0.01, 0.04)]
    assert [(row["branch"], row["seeds"]) for row in rows] == [("", "2")] * 6
    archives = sorted((tmp_path / "flock.sweep").glob("*.h5"))
    assert [file.stem for file in archives] == [f"point-000{point}-seed-{seed}" for point in range(6) for seed in (7,
                                                                                                                   8)]
    found = set()
    for archive in archives:
        text = drover(tmp_path, "info", archive, "--scene").stdout
        keys = {line.split(" = ")[0]: line.split(" = ")[1] for line in text.splitlines() if " = " in line}
        found.add((float(keys["rate"]), float(keys["order"]), int(keys["seed"])))
    assert found == {(rate, noise, seed) for rate in (0.5, 1.5, 2.5) for noise in (0.01, 0.04) for seed in (7, 8)}


def test_a_run_of_a_sweep_is_the_run_of_its_scene(tmp_path):
    scene = write_scene(tmp_path, BRIEF)
    drover(tmp_path, "sweep", scene, "--vary", "relaxation.rate = 0.5, 2", "--quiet")
    drover(tmp_path, "run", scene, "--set", "relaxation.rate=2", "--quiet")
    assert_same_bytes(tmp_path / "flock.h5", tmp_path / "flock.sweep" / "point-0001-seed-7.h5")


def test_table_json_and_runs_agree(tmp_path):
    scene = write_scene(tmp_path, {**BRIEF, "time.end": 100.0})
    words = ["sweep", scene, "--vary", "relaxation.rate = 1, 3", "--seeds", "2"]
    rows = drover_json(tmp_path, *words)
    table = table_of(tmp_path / "flock.sweep")
    assert len(rows) == len(table) == 2
    for number, (row, line) in enumerate(zip(rows, table)):
        assert row["relaxation.rate"] == float(line["relaxation.rate"]) and row["seeds"] == int(line["seeds"]) == 2
        archives = [tmp_path / "flock.sweep" / f"point-000{number}-seed-{seed}.h5" for seed in (7, 8)]
        infos = [drover_json(tmp_path, "info", archive)["results"] for archive in archives]
        names = [name for name, value in row.items() if isinstance(value, dict)]
        assert {"polar_order", "polar_order_susceptibility", "polar_order_binder", "rods_total"} <= set(names)
        assert set(names) == {name for name, result in infos[0].items() if "mean" in result}
        for name in names:
            value, unit = row[name], row[name]["unit"]
            assert value["mean"] == float(line[f"{name} [{unit}]"])
            means, errors = ([info[name][part] for info in infos] for part in ("mean", "error"))
            assert value["mean"] == pytest.approx(sum(means) / 2, rel=1e-12, abs=1e-300)
            # The error is that of the scatter: Student's t of one degree of freedom, within one standard deviation of
            # a normal distribution.  Two runs may agree by chance: it is at least the one that they tell.
            student = math.tan(math.pi * (0.841344746068543 - 0.5))
            least = 0.0 if None in errors else math.hypot(*errors) / 2
            expected = max(student * abs(means[0] - means[1]) / 2, least)
            assert value["error"] == pytest.approx(expected, rel=1e-9, abs=1e-15)
            assert value["error"] == float(line[f"{name} error"])
            if None in errors:
                assert "own_error" not in value and line[f"{name} own error"] == ""
            else:  # the runs are independent: their own errors add in quadrature
                assert value["own_error"] == pytest.approx(math.hypot(*errors) / 2, rel=1e-12, abs=1e-300)
                assert value["own_error"] == float(line[f"{name} own error"])
    text = drover(tmp_path, *words, "--quiet").stdout.splitlines()
    assert text[0].split()[:4] == ["relaxation.rate", "branch", "seeds", "polar_order"] and "table.csv" in text[-1]
    # Printed to the second digit of its error, or to six digits.
    printed, row = float(text[1].split()[3]), rows[0]["polar_order"]
    assert printed == pytest.approx(row["mean"], rel=1e-5, abs=0.1 * (row["error"] or 0.0))


def test_a_sweep_that_is_repeated_runs_nothing_and_prints_the_same(tmp_path):
    scene = write_scene(tmp_path, BRIEF)
    words = ["sweep", scene, "--vary", "relaxation.rate = 1, 3", "--seeds", "2"]
    first = drover(tmp_path, *words)
    made = {file.name: file.stat().st_mtime_ns for file in (tmp_path / "flock.sweep").glob("*.h5*")}
    again = drover(tmp_path, *words)
    assert again.stdout == first.stdout and "4 runs (4 already finished)" in again.stderr
    assert made == {file.name: file.stat().st_mtime_ns for file in (tmp_path / "flock.sweep").glob("*.h5*")}


def test_a_ramp_passes_the_state_on_up_and_down(tmp_path):
    scene = write_scene(tmp_path, {**BRIEF, "grid.nx": 24, "grid.ly": 20.0})
    drover(tmp_path, "sweep", scene, "--vary", "relaxation.rate = 0.5:1.5:3", "--ramp", "up-down", "--seeds", "2")
    rows = table_of(tmp_path / "flock.sweep")
    assert [(float(row["relaxation.rate"]), row["branch"]) for row in rows] == [
        (0.5, "up"), (1.0, "up"), (1.5, "up"), (1.0, "down"), (0.5, "down")]
    assert {row["seeds"] for row in rows} == {"2"}
    for seed in (7, 8):
        for point in range(1, 5):
            with h5py.File(tmp_path / "flock.sweep" / f"point-000{point - 1}-seed-{seed}.h5") as before, \
                    h5py.File(tmp_path / "flock.sweep" / f"point-000{point}-seed-{seed}.h5") as after:
                for name in ("rod_density", "polar_order_x", "polar_order_y"):
                    # A transform there and back costs some roundings of numbers of order one.
                    assert np.abs(before[name][-1] - after[name][0]).max() < 1e-12, (seed, point, name)
                    assert np.abs(before[name][0] - after[name][0]).max() > 1e-3  # and not from the same initial state


def test_a_ramp_of_two_keys_is_one_of_the_last_for_each_value_of_the_first(tmp_path):
    scene = write_scene(tmp_path, BRIEF)
    both = ["--ramp", "up-down", "--vary", "relaxation.rate = 1, 2"]
    drover(tmp_path, "sweep", scene, "--vary", "noise.order = 0.1, 0.2", *both, "-o", "two")
    rows = [(float(row["noise.order"]), float(row["relaxation.rate"]), row["branch"])
            for row in table_of(tmp_path / "two")]
    ramp = [(1.0, "up"), (2.0, "up"), (1.0, "down")]
    assert rows == [(noise, *point) for noise in (0.1, 0.2) for point in ramp]
    # The first ramp is that of a sweep of one key, to the byte; the second starts anew, and not where the first ended.
    drover(tmp_path, "sweep", scene, *both, "--set", "noise.order=0.1", "-o", "one")
    for point in range(3):
        with h5py.File(tmp_path / "two" / f"point-000{point}-seed-7.h5") as there, \
                h5py.File(tmp_path / "one" / f"point-000{point}-seed-7.h5") as here:
            assert np.array_equal(there["rod_density"][...], here["rod_density"][...])
    with h5py.File(tmp_path / "two" / "point-0000-seed-7.h5") as first, \
            h5py.File(tmp_path / "two" / "point-0002-seed-7.h5") as last, \
            h5py.File(tmp_path / "two" / "point-0003-seed-7.h5") as second:
        assert np.abs(second["rod_density"][0] - last["rod_density"][-1]).max() > 1e-3
        assert first["rod_density"].shape == second["rod_density"].shape
    with xarray.open_dataset(tmp_path / "two" / "table.nc") as data:
        assert data.polar_order.dims == ("noise_order", "relaxation_rate", "branch")


def test_a_ramp_may_start_from_formulas(tmp_path):
    scene = write_scene(tmp_path, {**BRIEF, "initial.kind": "formula", "initial.polar_order_x": "0.1"})
    drover(tmp_path, "sweep", scene, "--vary", "relaxation.rate = 1, 2", "--ramp", "up-down", "--quiet")
    assert [row["branch"] for row in table_of(tmp_path / "flock.sweep")] == ["up", "up", "down"]


def test_the_points_of_a_ramp_have_independent_noise(tmp_path):
    # With the same noise again, the difference of two runs of the linear model decays as exp(-a t), here to exp(-20):
    # both branches would agree for any model.
    scene = write_scene(tmp_path, {**BRIEF, "time.end": 20.0})
    drover(tmp_path, "sweep", scene, "--vary", "relaxation.rate = 1, 2", "--ramp", "up-down", "--quiet")
    with h5py.File(tmp_path / "flock.sweep" / "point-0000-seed-7.h5") as up, \
            h5py.File(tmp_path / "flock.sweep" / "point-0002-seed-7.h5") as down:
        assert np.abs(up["polar_order_x"][-1] - down["polar_order_x"][-1]).max() > 1e-3


def test_a_failed_run_does_not_affect_the_others(tmp_path):
    scene = write_scene(tmp_path, {**BRIEF, "initial.kind": "random", "initial.amplitude": 0.1})
    ended = drover(tmp_path, "sweep", scene, "--vary", "relaxation.rate = 0.5, -200, 2", status=1)
    assert "the run diverged" in ended.stderr and "1 jobs failed" in ended.stderr
    rows = table_of(tmp_path / "flock.sweep")
    assert [row["seeds"] for row in rows] == ["1", "0", "1"]
    assert rows[0]["polar_order [1]"] and rows[2]["polar_order [1]"] and not rows[1].get("polar_order [1]")


def test_a_sweep_stops_when_enough_of_its_runs_have_failed_and_tries_them_again(tmp_path):
    scene = write_scene(tmp_path, {**BRIEF, "initial.kind": "random", "initial.amplitude": 0.1, "time.end": 100.0})
    words = ["sweep", scene, "--vary", "relaxation.rate = -200, -201, 0.5", "--workers", "1"]
    ended = drover(tmp_path, *words, "--stop-when", "failures = 1", status=3)
    assert "stopped by --stop-when failures = 1 after checkpoints" in ended.stderr
    assert "1 jobs failed" not in ended.stderr and ended.stderr.count("the run diverged") == 1
    drover(tmp_path, *words, "--stop-when", "failures = 3", "--stop-when", "core-time = 1h", status=1)
    assert [row["seeds"] for row in table_of(tmp_path / "flock.sweep")] == ["0", "0", "1"]
    rejected(tmp_path, [*words, "--stop-when", "failed=1"], ["jobs, failures, core-time"])


@not_sanitized
def test_susceptibility_and_binder_cumulant_are_those_of_the_linear_model(tmp_path):
    # Each component of <p> is an independent Ornstein-Uhlenbeck process: Gaussian, with variance Delta/(2 a area).
    # So P = |<p>|/sigma has a Rayleigh distribution, whose moments are exact.
    sigma, noise, side = 2.0, 0.05, 8.0
    scene = write_scene(tmp_path, {
        "uniform.rod_density": sigma, "noise.order": noise, "grid.lx": side, "grid.ly": side, "grid.nx": 8,
        "grid.ny": 8,
        "time.dt": 0.5, "time.end": 6000.0, "output.frame_every": 0.0, "output.sample_every": 0.5,
        "analysis.warm_up": 0.0})
    rows = drover_json(tmp_path, "sweep", scene, "--vary", "relaxation.rate = 0.5, 1, 2")
    area = side * side
    for row in rows:
        second = 2.0 * noise / (2.0 * row["relaxation.rate"] * area) / sigma**2
        exact = {"polar_order": math.sqrt(second * math.pi / 4.0),
                 "polar_order_susceptibility": area * second * (1.0 - math.pi / 4.0),
                 "polar_order_binder": 1.0 / 3.0,
                 "polar_order_mean_x": 0.0, "polar_order_mean_y": 0.0, "rods_total": sigma * area}
        for name, value in exact.items():
            found = row[name]
            assert found["error"] is not None, (name, found)
            # Four standard errors: one run in 16000 lies outside, and the seed is fixed.  Rods: conserved to rounding.
            assert abs(found["mean"] - value) <= 4.0 * found["error"] + 1e-12 * value, (name, found, value)
        # The errors are small enough to detect a wrong factor, of 2 or pi/4, or a Binder cumulant of 0 or 2/3.
        for name, largest in (("polar_order", 0.02), ("polar_order_susceptibility", 0.06),
                              ("polar_order_binder", 0.06)):
            assert row[name]["error"] < largest * exact[name], (name, row[name])


def test_a_stopped_sweep_prints_valid_json(tmp_path):
    scene = write_scene(tmp_path, {"time.end": 20000.0, "output.frame_every": 1000.0})
    process = start(tmp_path, "sweep", scene, "--vary", "relaxation.rate = 1, 2", "--json", "--workers", "1")
    try:
        wait_until(lambda: any((tmp_path / "flock.sweep").glob("*.checkpoint-a")), "a run at work", process=process)
        process.terminate()
        out, _ = process.communicate(timeout=10)
    finally:
        end_group(process)
    assert process.returncode == 3
    assert [row["seeds"] for row in json.loads(out)] == [0, 0]


def test_seeds_that_end_in_different_states_contradict_their_errors_and_are_reported(tmp_path):
    # A flock whose order a term holds along +x or -x, whichever the noise chooses at the start.
    scene = {"fields.rod_density": False, "relaxation.rate": -1.0, "relaxation.saturation": 1.0, "noise.order": 0.01,
             "elasticity.stiffness": 1.0, "grid.nx": 8, "grid.ny": 8, "grid.lx": 8.0, "grid.ly": 8.0, "time.dt": 0.1,
             "time.end": 100.0, "analysis.warm_up": 20.0, "output.sample_every": 0.5, "output.frame_every": 0.0,
             "accuracy.effort": 0.0, "run.seed": 1}
    write_scene(tmp_path, name="pinned.toml", base=scene)
    with (tmp_path / "pinned.toml").open("a") as file:
        file.write('\n[[terms]]\nof = "order"\nvalue = ["0.5*order_x", "-0.5*order_y"]\n')
    told = drover(tmp_path, "sweep", "pinned.toml", "--vary", "elasticity.stiffness = 1.0", "--seeds", "4").stdout
    means = []
    for seed in (1, 2, 3, 4):
        result = drover_json(tmp_path, "info", tmp_path / "pinned.sweep" / f"point-0000-seed-{seed}.h5")["results"]
        means.append(result["polar_order_mean_x"]["mean"])
    assert min(means) < -0.9 and max(means) > 0.9, means
    (warning,) = [line for line in told.splitlines() if "the seeds differ by far more than their errors" in line]
    # All seeds agree on the size of the order: one in two thousand runs of the test would say otherwise.
    named = warning.split("their errors in ")[1].split(";")[0].split(", ")
    assert "polar_order_mean_x" in named and "polar_order" not in named


CUBIC = """
field = [{symbol = "h", noise = "1"}]
equations = {h = "-a h + lap h - b h^3"}
coefficients = {a = 1.0, b = 1.0}
grid = {nx = 16, ny = 16, lx = 16.0, ly = 16.0}
time = {dt = 0.1, end = 20.0}
output = {sample_every = 0.5, frame_every = 0.0}
"""


def test_points_that_keep_other_modes_are_reported_and_may_keep_the_same(tmp_path):
    (tmp_path / "cubic.toml").write_text(CUBIC)
    words = ("--vary", "coefficients.b = 0, 1", "--keep", "table", "--quiet")
    warned = drover(tmp_path, "sweep", "cubic.toml", *words).stdout
    (warning,) = [line for line in warned.splitlines() if "dealiasing.degree" in line]
    assert "point-0000-seed-1 keeps modes |k| < N/2, point-0001-seed-1 |k| < N/4" in warning
    assert warning.endswith("set dealiasing.degree = 3 for all points")
    same = drover(tmp_path, "sweep", "cubic.toml", *words, "--set", "dealiasing.degree=3", "-o", "same.sweep").stdout
    assert "dealiasing" not in same
    # The variance without b is then that of the kept waves: 1/(2 A (1 + q^2)) each, of |k| < 4 on each axis.
    number = np.arange(-3, 4) * 2.0 * np.pi / 16.0
    exact = (0.5 / 256.0 / (1.0 + number[:, None]**2 + number[None, :]**2)).sum()
    found = [float(row["variance_h [1]"]) for row in table_of(tmp_path / "same.sweep")][0]
    assert found == pytest.approx(exact, rel=0.2)  # of 20 s: waves of 7 by 7 modes; N/2 has 1.9 times as much


def test_seeds_are_added_to_one_point_until_its_error_is_reached(tmp_path):
    (tmp_path / "cubic.toml").write_text(CUBIC)
    drover(tmp_path, "sweep", "cubic.toml", "--want", "variance_h=2%", "--keep", "table", "--quiet")
    (row,) = table_of(tmp_path / "cubic.sweep")
    assert int(row["seeds"]) >= 4 and float(row["variance_h error"]) < 0.02 * float(row["variance_h [1]"])


# --- the dataset

def test_one_file_has_every_observable_of_all_runs_over_the_keys_the_seeds_and_its_own_axes(tmp_path):
    scene = write_scene(tmp_path, {"time.end": 4.0, "output.sample_every": 0.5, "analysis.warm_up": 0.0})
    drover(tmp_path, "sweep", scene, "--vary", "relaxation.rate = 0.5, 1, 2", "--vary", "noise.order = 0.1, 0.2",
           "--seeds", "3", "--quiet")
    with xarray.open_dataset(tmp_path / "flock.sweep" / "table.nc") as data:
        keys = ("relaxation_rate", "noise_order")
        assert data.polar_order.dims == keys and data.structure_factor_rods.dims == (*keys, "wavenumber")
        assert data.structure_factor_rods_of_runs.dims == (*keys, "seed", "wavenumber")
        assert data.structure_factor_rods.attrs["units"] == "mm-2" and data.relaxation_rate.attrs["units"] == "1/s"
        names = set()
        for point, (rate, noise) in enumerate((rate, noise) for rate in (0.5, 1.0, 2.0) for noise in (0.1, 0.2)):
            at = data.sel(relaxation_rate=rate, noise_order=noise)
            for place, archive in enumerate(sorted((tmp_path / "flock.sweep").glob(f"point-{point:04}-*.h5"))):
                run = at.isel(seed=place)
                with xarray.open_dataset(archive, group="summary") as summary:
                    names = {name for name in summary if f"{name}_error" in summary}
                    for name in names:
                        for ending in ("", "_error"):
                            assert np.array_equal(run[f"{name}_of_runs{ending}"], summary[name + ending],
                                                  equal_nan=True), name
            runs = at.structure_factor_rods_of_runs
            assert np.allclose(at.structure_factor_rods, runs.mean("seed"), rtol=1e-12)  # sums of three
            # Student's t of two degrees of freedom covers 68.3 % within 1.3213 standard errors.
            assert np.allclose(at.structure_factor_rods_error, 1.3213 * runs.std("seed", ddof=1) / np.sqrt(3.0),
                               rtol=1e-4)
        assert len(names) > 30


def test_axes_that_differ_between_points_have_their_values_beside_them(tmp_path):
    scene = write_scene(tmp_path, {"time.end": 1.0, "grid.nx": 32})
    drover(tmp_path, "sweep", scene, "--vary", "grid.ny = 16, 32", "--quiet")
    with xarray.open_dataset(tmp_path / "flock.sweep" / "table.nc") as data:
        assert np.array_equal(data.wavenumber, np.arange(data.sizes["wavenumber"]))
        for place, archive in enumerate(sorted((tmp_path / "flock.sweep").glob("*.h5"))):
            with xarray.open_dataset(archive, group="summary") as summary:
                at, count = data.isel(grid_ny=place), summary.sizes["wavenumber"]
                for one, other in ((at.wavenumber_values, summary.wavenumber),
                                   (at.structure_factor_rods, summary.structure_factor_rods)):
                    assert np.array_equal(one[:count], other, equal_nan=True) and np.isnan(one[count:]).all()


def test_a_run_that_failed_leaves_a_gap_in_the_dataset(tmp_path):
    scene = write_scene(tmp_path, {"time.end": 1.0, "initial.kind": "random", "initial.amplitude": 0.1})
    drover(tmp_path, "sweep", scene, "--vary", "relaxation.rate = -200, 1", "--quiet", status=1)
    with xarray.open_dataset(tmp_path / "flock.sweep" / "table.nc") as data:
        assert np.isnan(data.polar_order).values.tolist() == [True, False] and data.seeds.values.tolist() == [0, 1]


def test_of_many_like_warnings_ten_are_printed_and_with_json_all(tmp_path):
    scene = write_scene(tmp_path, {**BRIEF, "time.end": 1.0, "time.max_error": 1e-9, "advection.strength": 0.5})
    words = ("sweep", scene, "--vary", "relaxation.rate = 0.4:0.6:12", "--keep", "table", "-o", "many", "--quiet")
    said = drover(tmp_path, *words).stdout
    every = drover(tmp_path, *words, "--json").stderr.count("warning: point-")
    assert every >= 12 and said.count("warning: point-") == 10
    assert f"warning: {every - 10} more: with --json" in said
