"""tests/app/test_calibrate.py: drover calibrate: its table, how it goes on, shares, and what is refused."""
import json
import math
import os
import random
import re
import shutil
import signal
import subprocess
from pathlib import Path

import h5py
import numpy as np
import pytest
import xarray
from calibration import TINY, UNITS, already_done, assert_same_tables, kill_again_and_again, toml_of, trials_in, write_tiny
from rejection import rejected
from support import (DROVER, MODELS, SMALL, attributes, drover, drover_json, end_group, environment, group_is_alive, scene_text, scenes,
                     settings, start, wait_until)

ONE = {"calibrate.bead_area_fractions": [0.3], "calibrate.assays": ["damping"]}  # one measurement


@pytest.fixture(scope="module", name="whole")
def calibration_made_once(tmp_path_factory):
    """The undisturbed calibration that all others are compared with: its folder, and what it said."""
    folder = tmp_path_factory.mktemp("whole")
    ended = drover(folder, "calibrate", write_tiny(folder), "--json", "--workers", "2")
    return folder / "tiny.calibration", json.loads(ended.stdout), ended.stderr


# --- the table

def test_every_coefficient_has_a_value_an_error_trials_and_an_origin(whole):
    folder, told, log = whole
    assert already_done(log) == 0 and told["trials_found"] == 0
    assert told["trials_run"] == sum(map(len, trials_in(folder).values()))
    assert len(trials_in(folder)) == UNITS  # rods matter for drag alone: all else is measured once a Phi_b
    coefficients = told["coefficients"]
    assert {"relaxation_rate", "weathercock", "weathercock_single", "drag", "damping_rate", "viscosity_kinematic", "propulsion",
            "stiffness", "noise_order", "pressure_rods", "elasticity_stiffness", "elasticity_splay", "relaxation_saturation",
            "advection", "pressure_beads", "alignment", "relaxation_over_weathercock"} <= set(coefficients)
    for name, row in coefficients.items():
        by_rods = "rod_area_fraction" in row["points"][0]
        points = [(beads, rods) for beads in (0.2, 0.4) for rods in ((0.1, 0.2) if by_rods else (None,))]
        assert [(point["bead_area_fraction"], point.get("rod_area_fraction")) for point in row["points"]] == points
        assert row["unit"] and row["formula"]
        for point in row["points"]:
            if point["origin"] == "refused":
                assert point["value"] is None and point["error"] is None and point["remark"], name
            else:
                assert math.isfinite(point["value"]) and point["error"] >= 0.0, name
                assert (point["trials"] >= 8) == (point["origin"] in ("measured", "short") or point["trials"] > 0), name
                assert point["remark"] or point["origin"] != "short", name
    origins = {name: {point["origin"] for point in row["points"]} for name, row in coefficients.items()}
    assert origins["damping_rate"] == {"measured"} and origins["elasticity_splay"] == {"closure"} and origins["advection"] == {"set"}
    assert origins["pressure_rods"] <= {"closure"}


def test_the_file_the_summary_and_info_say_what_the_command_said(whole):
    folder, told, _ = whole
    summary = toml_of(folder)
    with h5py.File(folder / "table.h5") as file:
        group = file["calibration"]
        assert sorted(file.attrs["coefficients"].decode().split()) == sorted(told["coefficients"])
        for name, row in told["coefficients"].items():
            points = row["points"]
            assert group[name].attrs["units"].decode() == row["unit"] == summary[name]["unit"]
            assert group[name].attrs["long_name"].decode() == row["formula"] == summary[name]["formula"]
            for key, dataset in (("value", name), ("error", name + "_error"), ("trials", name + "_trials")):
                values = np.array([math.nan if point[key] is None else point[key] for point in points], float)
                assert np.array_equal(group[dataset][()].ravel(), values, equal_nan=True), dataset
                assert np.array_equal(np.ravel(summary[name][key]), values, equal_nan=True), dataset
            origins = ["refused", "measured", "short", "closure", "set"]
            assert [origins[code] for code in group[name + "_origin"][()].ravel()] == [point["origin"] for point in points]
            assert list(np.ravel(summary[name]["origin"])) == [point["origin"] for point in points]
    assert drover_json(folder, "info", "table.h5")["coefficients"] == told["coefficients"]
    text = drover(folder, "info", "table.h5").stdout
    assert "scene_hash" in text and "alpha/Gamma [mm/s]" in text and "refused" in text
    about = attributes(folder / "table.h5")
    assert re.fullmatch(r"[0-9a-f]{16}", about["scene_hash"]) and about["seed"] == 3 and "[calibrate]" in about["scene"]
    assert about["drover_version"] and about["drover_commit"] and not {"host", "start_time"} & set(about)


def test_xarray_opens_a_table_by_its_area_fractions(whole):
    with xarray.open_dataset(whole[0] / "table.h5", group="calibration") as table:
        assert table["drag"].dims == ("bead_area_fraction", "rod_area_fraction")
        assert table["relaxation_rate"].dims == ("bead_area_fraction",)
        assert list(table["rod_area_fraction"].values) == [0.1, 0.2]
        found = table["drag"].sel(bead_area_fraction=0.4, rod_area_fraction=0.2)
        assert float(found) == whole[1]["coefficients"]["drag"]["points"][3]["value"] and found.attrs["units"] == "mm/s"


def test_closures_are_those_of_the_numbers_beside_them(whole):
    values = {name: np.array([point["value"] or math.nan for point in row["points"]], float) for name, row in whole[1]["coefficients"].items()}
    u, a, sigma = np.repeat(values["propulsion"], 2), np.repeat(values["relaxation_rate"], 2), np.tile([0.1, 0.2], 2) / values["rod_area"][0]
    mass_density = values["bead_mass"] * [0.2, 0.4] / values["bead_area"]
    assert np.allclose(values["pressure_rods"], u**2 / 2)
    assert np.allclose(values["noise_order"], a * sigma * u**2)
    assert np.allclose(values["friction_of_plates"], values["damping_rate"] * mass_density)
    # A cell holds whole bodies.
    assert np.allclose(values["rod_density"], sigma, atol=0.005) and np.allclose(values["bead_mass_density"], mass_density, rtol=0.02)


def test_a_key_more_is_varied_and_has_an_axis(tmp_path):
    scene = write_tiny(tmp_path, {**ONE, "calibrate.vary": "plates.amplitude = 0.04, 0.05"})
    row = drover_json(tmp_path, "calibrate", scene)["coefficients"]["damping_rate"]
    assert [point["plates.amplitude"] for point in row["points"]] == [0.04, 0.05]
    assert row["points"][0]["value"] != row["points"][1]["value"]
    with h5py.File(tmp_path / "tiny.calibration" / "table.h5") as file:
        assert file["calibration/damping_rate"].shape == (2, 1) and list(file["calibration/plates_amplitude"]) == [0.04, 0.05]
    assert len(toml_of(tmp_path / "tiny.calibration")["damping_rate"]["value"]) == 2


# --- going on

def test_given_again_it_runs_nothing_and_writes_the_same_bytes(whole, tmp_path):
    shutil.copytree(whole[0], tmp_path / "again")
    trials = trials_in(tmp_path / "again")
    ended = drover(tmp_path, "calibrate", write_tiny(tmp_path), "-o", "again", "--json", "--workers", "1")
    told = json.loads(ended.stdout)
    assert told["trials_run"] == 0 and told["coefficients"] == whole[1]["coefficients"]
    assert trials_in(tmp_path / "again") == trials
    assert_same_tables(tmp_path / "again", whole[0])


def test_the_table_is_the_same_for_any_number_of_workers_and_after_kills(whole, tmp_path):
    # Kills meet it with two workers; what is left is done by as many as there are cores.
    assert kill_again_and_again(tmp_path, write_tiny(tmp_path), whole[0], 3, random.Random(5), 0.5) >= 1


def test_a_smaller_error_and_more_points_use_the_trials_that_are_there(tmp_path):
    scene = write_tiny(tmp_path, ONE)
    first = json.loads(drover(tmp_path, "calibrate", scene, "--json").stdout)
    more = settings(["calibrate.bead_area_fractions=[0.2, 0.3]", "calibrate.relative_error=0.02", "calibrate.max_trials=24"])
    second = json.loads(drover(tmp_path, "calibrate", scene, "--json", *more).stdout)
    assert second["trials_found"] == first["trials_run"]
    points = second["coefficients"]["damping_rate"]["points"]
    assert points[1]["trials"] > first["coefficients"]["damping_rate"]["points"][0]["trials"]
    again = json.loads(drover(tmp_path, "calibrate", scene, "--json").stdout)
    assert again["trials_run"] == 0 and again["coefficients"] == first["coefficients"]  # the first trials decide, not all


def test_a_signal_ends_it_within_moments_and_the_same_command_goes_on(whole, tmp_path):
    scene = write_tiny(tmp_path)
    process = start(tmp_path, "calibrate", scene, "-o", "parts", "--workers", "2", "--json")
    try:
        wait_until(lambda: sum(map(len, trials_in(tmp_path / "parts").values())) > 20, "some trials", process=process)
        process.send_signal(signal.SIGTERM)
        out, log = process.communicate(timeout=10)
    finally:
        end_group(process)
    assert process.returncode == 3 and "re-run the same command to resume" in log
    remarks = [point["remark"] for row in json.loads(out)["coefficients"].values() for point in row["points"]]
    assert any(remark.startswith("not finished: ") for remark in remarks)
    found = sum(map(len, trials_in(tmp_path / "parts").values()))
    ended = drover(tmp_path, "calibrate", scene, "-o", "parts")
    assert already_done(ended.stderr) == found
    assert_same_tables(tmp_path / "parts", whole[0])


def test_a_torn_record_is_cut_off_told_and_done_again(whole, tmp_path):
    shutil.copytree(whole[0], tmp_path / "torn")
    file = tmp_path / "torn" / "damping-bead-0.2.trials"
    file.write_bytes(file.read_bytes()[:-5])
    ended = drover(tmp_path, "calibrate", write_tiny(tmp_path), "-o", "torn", "--json")
    assert "bytes at its end were no whole trial" in ended.stderr and json.loads(ended.stdout)["trials_run"] == 1
    assert_same_tables(tmp_path / "torn", whole[0])


# --- shares

SBATCH = """#!/bin/sh
# Stands in for Slurm: runs the tasks of an array, or a job, one after the other, at once.
echo "$@" >> "$SBATCH_LOG"
tasks=0
for word in "$@"; do
    case "$word" in --array=1-*) tasks=${word#--array=1-} ;; esac
    last=$word
done
SLURM_CPUS_PER_TASK=1; export SLURM_CPUS_PER_TASK
if [ "$tasks" = 0 ]; then sh -c "$last" >> "$SBATCH_LOG.out" 2>&1; fi
while [ "$tasks" -gt 0 ]; do
    SLURM_ARRAY_TASK_ID=$tasks sh -c "$last" >> "$SBATCH_LOG.out" 2>&1
    tasks=$((tasks - 1))
done
echo "4711;cluster"
"""


def test_the_script_for_slurm_makes_the_same_table_in_shares(whole, tmp_path):
    binaries = tmp_path / "bin"
    binaries.mkdir()
    (binaries / "sbatch").write_text(SBATCH)
    (binaries / "sbatch").chmod(0o755)
    (binaries / "drover").symlink_to(DROVER)
    folder = tmp_path / "it's here"  # a quote and a space
    folder.mkdir()
    scene = write_tiny(folder)
    script = drover(folder, "calibrate", scene, "--slurm", "3", "-o", "shares").stdout
    (folder / "calibrate.sh").write_text(script)
    log = tmp_path / "log"
    ended = subprocess.run(["sh", "calibrate.sh", "--partition=short"], cwd=folder, capture_output=True, text=True, check=False,
                           env=environment(PATH=f"{binaries}:{os.environ['PATH']}", SBATCH_LOG=str(log)), timeout=300)
    assert ended.returncode == 0, ended.stderr
    array, table = log.read_text().split("--parsable ")[1:]
    assert "--array=1-3" in array and "--partition=short" in array
    assert "--dependency=afterany:4711 " in table and "--partition=short" in table and "--collect" in table
    assert_same_tables(folder / "shares", whole[0])


def test_a_share_makes_no_table_and_what_is_missing_is_a_hole(tmp_path):
    scene = write_tiny(tmp_path, {"calibrate.assays": ["damping", "shear"], "calibrate.rod_area_fractions": []})
    drover(tmp_path, "calibrate", scene, "--share", "1/2")
    assert len(trials_in(tmp_path / "tiny.calibration")) == 2 and not (tmp_path / "tiny.calibration" / "table.h5").exists()
    ended = drover(tmp_path, "calibrate", scene, "--collect", "--json", status=1)
    assert "2 of 4 measurements are not finished" in ended.stderr
    rows = json.loads(ended.stdout)["coefficients"]
    holes = [point for row in (rows["damping_rate"], rows["viscosity_kinematic"]) for point in row["points"] if point["origin"] == "refused"]
    assert len(holes) == 2 and all(hole["remark"].startswith("not finished: 0 trials") for hole in holes)
    drover(tmp_path, "calibrate", scene, "--share", "2/2")
    drover(tmp_path, "calibrate", scene, "--collect")


# --- what goes wrong

def test_an_error_out_of_reach_is_kept_marked_and_told(tmp_path):
    scene = write_tiny(tmp_path, {**ONE, "calibrate.relative_error": 1e-6})
    ended = drover(tmp_path, "calibrate", scene)
    assert "1 of 1 measurements have a larger error than was asked" in ended.stderr
    assert re.search(r"\d !\n", ended.stdout) and re.search(r"! damping_rate at bead area fraction 0.3: .*trials would do", ended.stdout)
    with h5py.File(tmp_path / "tiny.calibration" / "table.h5") as file:
        assert list(file["calibration/damping_rate_origin"]) == [2] and "trials would do" in file.attrs["remarks"].decode()


def test_a_point_whose_trials_fail_is_refused_with_their_reason(tmp_path):
    scene = write_tiny(tmp_path, {**ONE, "calibrate.bead_area_fractions": [0.3, 0.5], "contacts.max_overlap": 1e-4})
    ended = drover(tmp_path, "calibrate", scene, "--json", status=1)
    assert ended.stderr.count("failed: ") == 2 and "2 of 2 measurements were refused" in ended.stderr
    for point in json.loads(ended.stdout)["coefficients"]["damping_rate"]["points"]:
        assert point["origin"] == "refused" and re.search(r"8 of 8 trials failed; expected at most 10 %: .* overlap", point["remark"])
    assert json.loads(drover(tmp_path, "calibrate", scene, "--json", status=1).stdout)["trials_run"] == 0


def test_what_cannot_be_calibrated_is_refused_in_a_sentence(tmp_path):
    for changes, says in (
            ({"calibrate.bead_area_fractions": []}, ["tiny.toml", "nothing to calibrate", "[0.2, 0.4, 0.6]"]),
            ({"calibrate.rod_area_fractions": []}, ["rod_area_fractions is empty", "drag depends on it"]),
            ({"calibrate.bead_area_fractions": [0.4, 0.2]}, ["has 0.2 after 0.4", "ascend"]),
            ({"calibrate.bead_area_fractions": [0.0]}, ["> 0"]),
            ({"calibrate.assays": ["dragg"]}, ['did you mean "drag"?']),
            ({"calibrate.vary": "run.seed = 1, 2"}, ["names run.seed"]),
            ({"calibrate.vary": "kick.strength"}, ["section.key = values"]),
            ({"calibrate.vary": "kick.strenght = 0.1"}, ["did you mean kick.strength?"]),
            ({"calibrate.max_trials": 8, "calibrate.round": 16}, ["two rounds"]),
            ({"calibrate.drag.torques": [1.0]}, ["calibrate.drag: ", "two torques"]),
            ({"calibrate.drag.torque": 1.0}, ["unknown key calibrate.drag.torque", "torques"]),
            ({"calibrate.dragg.time": 1.0}, ["unknown table [calibrate.dragg]", "[calibrate.drag]"]),
            ({"cell.shape": "circle"}, ['expected "periodic"'])):
        rejected(tmp_path, ["calibrate", write_tiny(tmp_path, changes)], says)
    (tmp_path / "flock.toml").write_text(scene_text(SMALL))
    rejected(tmp_path, ["calibrate", "flock.toml"], ["scene of fields"])
    scene = write_tiny(tmp_path)
    rejected(tmp_path, ["check", write_tiny(tmp_path, {"calibrate.rod_area_fractions": []}, name="empty.toml")], ["drag depends on it"])
    for share in ("0/2", "3/2", "2", "1/2x", "a/b"):
        rejected(tmp_path, ["calibrate", scene, "--share", share], ["expected I/N"])
    rejected(tmp_path, ["calibrate", scene, "--collect"], ["no such folder"])
    rejected(tmp_path, ["calibrate", scene, "--share", "1/2", "--json"], ["makes no table"])
    rejected(tmp_path, ["calibrate", scene, "-o", "."], ["not empty and holds no calibrate.toml"])


def test_a_folder_of_another_scene_and_foreign_trials_are_refused(tmp_path):
    scene = write_tiny(tmp_path, ONE)
    drover(tmp_path, "calibrate", scene, "--quiet")
    rejected(tmp_path, ["calibrate", scene, "--set", "restitution.bead_bead=0.9"],
            ["trials of another scene", "restitution.bead_bead = 0.3 there, 0.9 here"])
    folder = tmp_path / "tiny.calibration"
    shutil.copy(folder / "damping-bead-0.3.trials", folder / "damping-bead-0.4.trials")
    rejected(tmp_path, ["calibrate", scene, "--set", "calibrate.bead_area_fractions=[0.4]"], ["damping-bead-0.4.trials", "another scene or point"])
    (folder / "damping-bead-0.4.trials").write_text("notes of mine")
    rejected(tmp_path, ["calibrate", scene, "--set", "calibrate.bead_area_fractions=[0.4]"], ["is not a file of trials"])


def test_two_at_work_in_one_folder_are_refused_and_the_first_is_not_disturbed(tmp_path):
    scene = write_tiny(tmp_path, {**ONE, "calibrate.damping.time": 2000.0})
    process = start(tmp_path, "calibrate", scene, "--workers", "1")
    try:
        file = tmp_path / "tiny.calibration" / "damping-bead-0.3.trials"
        wait_until(lambda: file.exists() and file.stat().st_size >= 16, "the head of its file", process=process)  # then nothing for a minute
        rejected(tmp_path, ["calibrate", scene], ["another drover calibrate is at work"])
        process.send_signal(signal.SIGINT)
        process.communicate(timeout=10)  # the trial takes longer than the patience: it is ended
    finally:
        end_group(process)
    assert process.returncode == 3 and not group_is_alive(process.pid)


def test_tables_that_were_tampered_with_are_refused(whole, tmp_path):
    def spoiled(change):
        shutil.copy(whole[0] / "table.h5", tmp_path / "table.h5")
        with h5py.File(tmp_path / "table.h5", "r+") as file:
            change(file["calibration"])
        return ["info", "table.h5"]

    def put(name, value):
        def change(group):
            group[name][0] = value
        return change

    def drop(name):
        def change(group):
            del group[name]
        return change

    rejected(tmp_path, spoiled(put("damping_rate_error", -1.0)), ["damping_rate at bead area fraction 0.2 has the standard error -1"])
    rejected(tmp_path, spoiled(put("damping_rate", math.nan)), ["damping_rate at bead area fraction 0.2 is nan"])
    rejected(tmp_path, spoiled(put("damping_rate_origin", 9)), ["damping_rate_origin holds 9"])
    rejected(tmp_path, spoiled(put("bead_area_fraction", 0.7)), ["area fractions between 0 and 1 that ascend"])
    rejected(tmp_path, spoiled(drop("drag_trials")), ["has no /calibration/drag_trials"])
    rejected(tmp_path, spoiled(drop("drag")), ["has no /calibration/drag"])
    (tmp_path / "table.h5").write_bytes((whole[0] / "table.h5").read_bytes()[:3000])
    rejected(tmp_path, ["info", "table.h5"], ["table.h5"])


# --- the scenes

SHORT = ["cell.lx=10", "cell.ly=10", "time.dt=4e-5", "contacts.max_overlap=0.2", "calibrate.bead_area_fractions=[0.3]", "calibrate.round=4",
         'calibrate.assays=["damping"]', "calibrate.max_trials=8", "calibrate.damping.time=0.2"]


def test_scenes_for_calibrate_are_listed_in_the_readme():
    listed = dict(re.findall(r"^\| `([a-z-]+)\.toml` \|.*\| ([^|]+) \|$", (MODELS / "README.md").read_text(), re.M))
    assert scenes("calibrate") == ["calibrate-matched", "calibrate-small"]
    for scene in scenes("calibrate"):
        first, second = (MODELS / f"{scene}.toml").read_text().splitlines()[:2]
        assert re.fullmatch(r"# Shows: .+\.", first) and listed[scene] == re.fullmatch(r"# Takes: (.+)\.", second).group(1), scene


@pytest.mark.parametrize("scene", scenes("calibrate"))
def test_a_scene_for_calibrate_is_good_and_its_calibration_works(scene, tmp_path):
    path = MODELS / f"{scene}.toml"
    drover(tmp_path, "check", path)
    units = {"calibrate-small": 16, "calibrate-matched": 48}[scene]
    assert f"drover calibrate: {units} measurements" in drover(tmp_path, "explain", path).stdout
    point = json.loads(drover(tmp_path, "calibrate", path, "--json", *settings(SHORT)).stdout)["coefficients"]["damping_rate"]["points"][0]
    assert point["value"] is not None and point["trials"] == 8
    drover(tmp_path, "run", path, "--quiet", *settings(SHORT[:4]), "--set", "time.end=0.02", "--set", "output.sample_every=0.01")


def test_the_schema_knows_every_key_of_a_calibration():
    told = {section["name"]: section for section in json.loads(drover(Path.cwd(), "schema", "--kind", "particles", "--json").stdout)}
    for key in TINY:
        section, name = key.rsplit(".", 1)
        row = next(row for row in told[section]["rows"] if row["name"] == name)
        assert row["doc"]
