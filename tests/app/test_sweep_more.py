"""tests/app/test_sweep_more.py: sweeps that add runs to a folder: more values, more seeds, the rest after a kill."""
import csv
import itertools
import re
import shutil

import numpy as np
import pytest
import xarray
from support import (MODELS, assert_same_bytes, drover, drover_json, end_group, not_sanitized, start, wait_until,
                     write_scene)

BRIEF = {"time.end": 10.0, "output.frame_every": 5.0, "output.sample_every": 0.5}
# A uniform flock without noise, whose order is zero beyond an onset line through the plane of these two keys.
FLOCK = ["--set", "grid.nx=8", "--set", "grid.ny=8", "--set", "time.end=100", "--set", "time.dt=0.1",
         "--set", "output.frame_every=100", "--set", "output.sample_every=2", "--set", "noise.order=0",
         "--set", "noise.rods=0", "--keep", "table", "--quiet"]
PLANE = ["--vary", "relaxation.rate = 0.02:0.3:4", "--vary", "driving.strength = 0.2:2:3"]


def names_in(folder):
    return {file.stem for file in folder.glob("*.h5")}


def points_of(folder):
    with open(folder / "table.csv", newline="", encoding="utf-8") as file:
        return {(float(row["relaxation.rate"]), float(row["driving.strength"])): float(row["polar_order [1]"])
                for row in csv.DictReader(file)}


def test_more_values_and_seeds_in_the_same_folder_run_only_what_is_new(tmp_path):
    scene, folder = write_scene(tmp_path, BRIEF), tmp_path / "flock.sweep"
    drover(tmp_path, "sweep", scene, "--vary", "relaxation.rate = 0.5:1.5:3", "--seeds", "2")
    first = names_in(folder)
    assert first == {f"point-000{point}-seed-{seed}" for point in range(3) for seed in (7, 8)}
    more = ["--vary", "relaxation.rate = 0.5:1.5:5", "--seeds", "3"]
    assert "15 runs (6 already finished)" in drover(tmp_path, "sweep", scene, *more).stderr
    assert names_in(folder) == first | {f"point-000{point}-seed-9" for point in range(3)} | {
        f"relaxation.rate={rate},seed={seed}" for rate in (0.75, 1.25) for seed in (7, 8, 9)}
    drover(tmp_path, "sweep", scene, *more, "-o", "fresh")
    for name in ("table.csv", "table.nc"):
        assert (folder / name).read_bytes() == (tmp_path / "fresh" / name).read_bytes()
    # And back: the table is that of the values given.
    again = drover(tmp_path, "sweep", scene, "--vary", "relaxation.rate = 1.25", "--seeds", "3")
    assert "3 runs (3 already finished)" in again.stderr
    # Runs of another scene are refused as before, with what is different, which is not the values.
    ended = drover(tmp_path, "sweep", scene, *more, "--set", "time.end=5", status=2)
    assert "time.end = 10.0 there, 5.0 here" in ended.stderr and "vary" not in ended.stderr


def test_another_ramp_in_the_folder_of_a_ramp_is_rejected(tmp_path):
    scene = write_scene(tmp_path, BRIEF)
    ramp = ["sweep", scene, "--ramp", "up", "--keep", "table", "-o", "ramp"]
    drover(tmp_path, *ramp, "--vary", "relaxation.rate = 1, 2")
    for more in (["--vary", "relaxation.rate = 3, 4"], ["--vary", "relaxation.rate = 1, 2", "--seeds", "2"]):
        for share in ([], ["--share", "1/2"]):
            assert "results of another scene" in drover(tmp_path, *ramp, *more, *share, status=2).stderr


def test_a_value_given_twice_is_run_once(tmp_path):
    scene = write_scene(tmp_path, BRIEF)
    drover(tmp_path, "sweep", scene, "--vary", "relaxation.rate = 1, 2, 1", "--keep", "table")
    assert "2 of 2 done" in drover(tmp_path, "sweep", scene, "--vary", "relaxation.rate = 1, 2, 1", "--keep", "table",
                                   "--status").stdout


@pytest.fixture(name="refined", scope="module")
def fixture_refined(tmp_path_factory):
    folder = tmp_path_factory.mktemp("refined")
    shutil.copy(MODELS / "flock.toml", folder)
    drover(folder, "sweep", "flock.toml", *FLOCK, *PLANE, "--refine", "polar_order = 0.04", "-o", "fine")
    return folder


def test_neighbours_that_differ_by_more_than_asked_are_at_the_smallest_distance(refined):
    points, levels = points_of(refined / "fine"), 3
    rates, drives = (sorted({point[axis] for point in points}) for axis in (0, 1))
    finest = (0.28 / 3 / 2 ** levels, 0.9 / 2 ** levels)
    jumps = 0
    for axis, values, step in ((0, rates, finest[0]), (1, drives, finest[1])):
        others = drives if axis == 0 else rates
        for other in others:
            line = [value for value in values if ((value, other) if axis == 0 else (other, value)) in points]
            for low, high in itertools.pairwise(line):
                ends = [points[(value, other) if axis == 0 else (other, value)] for value in (low, high)]
                if abs(ends[1] - ends[0]) > 0.04:
                    jumps += 1
                    assert high - low == pytest.approx(step, rel=1e-9), (axis, low, high, other)
    assert jumps > 5
    assert 12 < len(points) < 0.5 * (3 * 2 ** levels + 1) * (2 * 2 ** levels + 1)  # of the whole finest grid


def test_the_refined_points_are_the_same_for_three_shares_and_after_a_coarser_sweep(refined):
    words = ["sweep", "flock.toml", *FLOCK, *PLANE, "--refine", "polar_order = 0.04"]
    shares = [start(refined, *words, "--workers", "1", "--share", f"{share}/3", "-o", "shared") for share in (1, 2, 3)]
    assert [share.wait(timeout=120) for share in shares] == [0] * 3
    drover(refined, "sweep", "flock.toml", *FLOCK, *PLANE, "-o", "grown")
    drover(refined, *words, "-o", "grown", "--refine-levels", "1")
    assert len(points_of(refined / "grown")) < len(points_of(refined / "fine"))
    drover(refined, *words, "-o", "grown")
    for name in ("table.csv", "table.nc"):
        tables = [(refined / folder / name).read_bytes() for folder in ("fine", "shared", "grown")]
        assert tables[0] == tables[1] == tables[2]
    with xarray.open_dataset(refined / "fine" / "table.nc") as data:
        assert data.polar_order.dims == ("point",) and data.relaxation_rate.dims == ("point",)
        table = points_of(refined / "fine")
        found = dict(zip(zip(data.relaxation_rate.values, data.driving_strength.values), data.polar_order.values))
        assert found == table and np.isfinite(list(table.values())).all()


def test_noise_alone_adds_no_points(tmp_path):
    # The order of the linear model grows as the root of the strength of noise, here by one in 10^6: more than was asked
    # for, and far below the error of four seeds.
    scene = write_scene(tmp_path, {**BRIEF, "time.end": 20.0})
    words = ["sweep", scene, "--vary", "noise.order = 0.04:0.0400001:2", "--seeds", "4", "--keep", "table", "--refine",
             "polar_order = 1e-12", "--refine-levels", "6"]
    drover(tmp_path, *words)
    with open(tmp_path / "flock.sweep" / "table.csv", newline="", encoding="utf-8") as file:
        assert len(list(csv.DictReader(file))) == 2


def rows_of(folder):
    with open(folder / "table.csv", newline="", encoding="utf-8") as file:
        return list(csv.DictReader(file))


def test_seeds_are_added_until_the_wanted_error_is_met_in_any_order(tmp_path):
    # The mean square of the order of the linear model fluctuates by much in these short runs.
    scene = write_scene(tmp_path, {**BRIEF, "time.end": 40.0})
    words = ["sweep", scene, "--vary", "relaxation.rate = 0.5, 4", "--keep", "table", "--want", "polar_order=6%",
             "--max-seeds", "40"]
    drover(tmp_path, *words, "-o", "one")
    for row in rows_of(tmp_path / "one"):
        seeds = int(row["seeds"])
        assert seeds in (4, 6, 9, 13, 19, 28, 40)
        error, mean = float(row["polar_order error"]), float(row["polar_order [1]"])
        assert error * (1.0 + (2.0 * (seeds - 1))**-0.5) <= 0.06 * mean
    seeds = [int(row["seeds"]) for row in rows_of(tmp_path / "one")]
    assert seeds[0] > seeds[1]  # slow order has fewer independent samples in a run
    shares = [start(tmp_path, *words, "--workers", "1", "--share", f"{share}/3", "-o", "shared") for share in (1, 2, 3)]
    assert [share.wait(timeout=120) for share in shares] == [0] * 3
    drover(tmp_path, *words[:-4], "--seeds", "4", "-o", "grown")
    drover(tmp_path, *words, "-o", "grown")
    for name in ("table.csv", "table.nc"):
        assert len({(tmp_path / folder / name).read_bytes() for folder in ("one", "shared", "grown")}) == 1
    with xarray.open_dataset(tmp_path / "one" / "table.nc") as data:
        assert data.seeds.values.tolist() == seeds and data.sizes["seed"] == max(seeds)
        assert np.isnan(data.polar_order_of_runs.values[1, seeds[1]:]).all()


def test_a_wanted_error_that_no_seeds_reach_is_named(tmp_path):
    scene = write_scene(tmp_path, {**BRIEF, "time.end": 20.0})
    said = drover(tmp_path, "sweep", scene, "--vary", "relaxation.rate = 0.5, 4", "--keep", "table", "--want",
                  "polar_order=0.01%", "--max-seeds", "5").stdout
    for value in ("0.5", "4"):
        assert re.search(rf"at relaxation\.rate = {value}: polar_order = [\d.e-]+ has an error of [\d.e-]+ after 5 "
                         "seeds", said)


@pytest.mark.parametrize("words, expected", [
    (["--want", "no_such_order=1%"], ["sweep.want names no_such_order", "expected one of polar_order"]),
    (["--want", "polar_order"], ["expected OBSERVABLE=ERROR"]),
    (["--want", "structure_factor_rods(q<1)=1%"], ["a part of an array"]),
    (["--want", "polar_order=1%", "--ramp", "up"], ["sweep.want on a ramp"]),
    (["--want", "polar_order=1%", "--seeds", "8", "--max-seeds", "4"], ["sweep.max_seeds = 4 is less than"]),
    (["--refine", "no_such_order = 0.1"], ["no_such_order", "expected one of polar_order"]),
    (["--refine", "polar_order = 0"], ["expected a change > 0"]),
    (["--refine", "polar_order"], ["expected a name, = and numbers"]),
    (["--refine", "polar_order = 0.1", "--ramp", "up"], ["sweep.refine", "ramp"]),
    (["--vary", "grid.nx = 8:16:2", "--refine", "polar_order = 0.1"], ["grid.nx", "integer"])])
def test_bad_refinements_and_wishes_are_refused_in_a_sentence(words, expected, tmp_path):
    scene = write_scene(tmp_path, BRIEF)
    vary = [] if "--vary" in words else ["--vary", "relaxation.rate = 1, 2"]
    ended = drover(tmp_path, "sweep", scene, *vary, *words, "--keep", "table", status=2)
    assert all(word in ended.stderr for word in expected), ended.stderr


OWN_ORDER = """
model = {name = "a vector"}
field = [{symbol = "p", rank = "vector", noise = 0.05}, {symbol = "c", conserved = true, reference = "1"}]
equations = {p = "-a p + lap p", c = "lap c"}
coefficients = {a = 1.0}
grid = {nx = 8, ny = 8, lx = 8.0, ly = 8.0}
time = {dt = 0.5, end = 6000.0}
output = {sample_every = 0.5, frame_every = 0.0}
analysis = {warm_up = 0.0}
"""


def test_any_order_has_its_susceptibility_and_binder_cumulant(tmp_path):
    """The mean has two Gaussian components of variance D/(2 a A): its size is that of Rayleigh, as of rods."""
    (tmp_path / "own.toml").write_text(OWN_ORDER)
    rows = drover_json(tmp_path, "sweep", "own.toml", "--vary", "coefficients.a = 0.5, 2")
    for row in rows:
        square = 0.05 / row["coefficients.a"] / 64.0
        exact = {"size_mean_p": (square * np.pi / 4.0) ** 0.5,
                 "size_mean_p_susceptibility": 64.0 * square * (1.0 - np.pi / 4.0), "size_mean_p_binder": 1.0 / 3.0}
        for name, value in exact.items():
            found = row[name]
            # Four standard errors: one run in 16000 is outside, and the seed is fixed.
            assert abs(found["mean"] - value) <= 4.0 * found["error"] and found["error"] < 0.06 * value, (name, found)
    text = drover(tmp_path, "sweep", "own.toml", "--vary", "coefficients.a = 0.5, 2", "--quiet").stdout
    assert all(name in text.splitlines()[0] for name in ("size_mean_p_binder", "variance_c"))


@not_sanitized
@pytest.mark.parametrize("ramp", ["none", "up"])
def test_a_killed_sweep_resumes_to_the_same_table(ramp, tmp_path):
    scene = write_scene(tmp_path, {"time.end": 200.0, "output.frame_every": 20.0})
    words = ["sweep", scene, "--vary", "relaxation.rate = 0.5, 1, 2", "--seeds", "2", "--workers", "2", "--ramp", ramp]
    drover(tmp_path, *words, "--quiet", "-o", "whole")
    process = start(tmp_path, *words, "--quiet", "-o", "parts")
    try:
        wait_until(lambda: len(list((tmp_path / "parts").glob("*.h5"))) >= 3, "a third run", process=process)
        process.kill()
        process.wait()
        drover(tmp_path, *words, "--quiet", "-o", "parts")  # at once, though its workers may still be ending
    finally:
        end_group(process)
    assert (tmp_path / "parts" / "table.csv").read_bytes() == (tmp_path / "whole" / "table.csv").read_bytes()
    for archive in (tmp_path / "whole").glob("*.h5"):
        assert_same_bytes(archive, tmp_path / "parts" / archive.name)
    names = [sorted(file.name for file in (tmp_path / folder).iterdir()) for folder in ("parts", "whole")]
    assert names[0] == names[1]
    assert not list((tmp_path / "parts" / "claims").iterdir())


def test_points_without_a_run_have_as_many_columns_in_the_table_as_the_others(tmp_path):
    drover(tmp_path, "sweep", MODELS / "flock.toml", *FLOCK, "--vary", "relaxation.rate = 0.02,0.1,0.3", "--workers",
           "1", "--stop-when", "jobs=1", "-o", "part", status=3)
    header, *rows = (line.split(",") for line in (tmp_path / "part" / "table.csv").read_text().splitlines())
    assert len(rows) == 3 and rows[2][3:] == [""] * (len(header) - 3)
    assert all(len(row) == len(header) for row in rows)
