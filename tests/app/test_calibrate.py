"""tests/app/test_calibrate.py: drover calibrate: tables, resuming and errors."""
import json
import math
import re
import shutil
import signal
from pathlib import Path

import h5py
import numpy as np
import pytest
import xarray
from calibration import (TINY, UNITS, already_done, assert_same_tables, toml_of, trials_in, undisturbed,
                         write_tiny)
from rejection import rejected
from support import (MODELS, SMALL, attributes, drover, drover_json, end_group, group_is_alive,
                     scene_text, scenes, settings, start, wait_until)

ONE = {"calibrate.bead_area_fractions": [0.3], "calibrate.assays": ["damping"]}  # one measurement


@pytest.fixture(scope="module", name="whole")
def calibration_made_once(tmp_path_factory):
    """The reference calibration: its folder, JSON output and log."""
    return undisturbed(tmp_path_factory.mktemp("whole"))


# --- the table

def test_stiffness_among_rods_and_drag_with_a_reversal_are_measured_at_each_area_fraction_of_rods(tmp_path):
    plan = {"calibrate.bead_area_fractions": [0.3], "calibrate.assays": ["stiffness", "drag"],
            "calibrate.stiffness.among_rods": True, "calibrate.drag.torques": [-20000.0, 2000.0, 20000.0],
            "calibrate.drag.time": 0.6}
    found = drover_json(tmp_path, "calibrate", write_tiny(tmp_path, plan))["coefficients"]
    for name in ("stiffness", "rods_follow", "drag", "drag_cubic", "drag_straight", "order_-20000"):
        assert [point["rod_area_fraction"] for point in found[name]["points"]] == [0.1, 0.2], name
    for back, along in zip(found["order_-20000"]["points"], found["order_20000"]["points"]):  # it acts last
        assert back["value"] < 0 < 0.5 < along["value"]
    scene = write_tiny(tmp_path, {**plan, "calibrate.drag.torques": [-2.0, -1.0, 3.0]}, name="two.toml")
    rejected(tmp_path, ["check", scene], ["torques > 0, ascending"])


def test_every_coefficient_has_a_value_an_error_trials_and_an_origin(whole):
    folder, output, log = whole
    assert already_done(log) == 0 and output["trials_found"] == 0
    assert output["trials_run"] == sum(map(len, trials_in(folder).values()))
    assert len(trials_in(folder)) == UNITS  # what does not depend on rods is measured once per Phi_b
    coefficients = output["coefficients"]
    assert {"relaxation_rate", "weathercock", "weathercock_single", "drag", "damping_rate", "viscosity_kinematic",
            "propulsion",
            "stiffness", "noise_order", "pressure_rods", "elasticity_stiffness", "elasticity_splay",
            "relaxation_saturation",
            "advection", "pressure_beads", "alignment", "relaxation_over_weathercock", "bead_diffusion",
            "rod_diffusion"} <= set(coefficients)
    for name, row in coefficients.items():
        by_rods = "rod_area_fraction" in row["points"][0]
        points = [(beads, rods) for beads in (0.2, 0.4) for rods in ((0.1, 0.2) if by_rods else (None,))]
        assert [(point["bead_area_fraction"], point.get("rod_area_fraction")) for point in row["points"]] == points
        assert row["unit"] and row["formula"]
        for point in row["points"]:
            if point["origin"] == "missing":
                assert point["value"] is None and point["error"] is None and point["remark"], name
            else:
                assert math.isfinite(point["value"]) and point["error"] >= 0.0, name
                assert (point["trials"] >= 8) == (point["origin"] in ("measured", "short") or point["trials"] > 0), name
                assert point["remark"] or point["origin"] != "short", name
    origins = {name: {point["origin"] for point in row["points"]} for name, row in coefficients.items()}
    assert origins["damping_rate"] == {"measured"} and origins["elasticity_splay"] == {"closure"}
    assert origins["pressure_beads"] == {"set"}
    assert origins["pressure_rods"] <= {"closure"}


def test_table_files_and_info_agree_with_the_output_of_the_command(whole):
    folder, output, _ = whole
    summary = toml_of(folder)
    with h5py.File(folder / "table.h5") as file:
        group = file
        assert sorted(file.attrs["coefficients"].decode().split()) == sorted(output["coefficients"])
        for name, row in output["coefficients"].items():
            points = row["points"]
            assert group[name].attrs["units"].decode() == row["unit"] == summary[name]["unit"]
            assert group[name].attrs["comment"].decode() == row["formula"] == summary[name]["formula"]
            for key, dataset in (("value", name), ("error", name + "_error"), ("trials", name + "_trials")):
                values = np.array([math.nan if point[key] is None else point[key] for point in points], float)
                assert np.array_equal(group[dataset][()].ravel(), values, equal_nan=True), dataset
                assert np.array_equal(np.ravel(summary[name][key]), values, equal_nan=True), dataset
            origins = ["missing", "measured", "short", "closure", "set"]
            assert [origins[code] for code in group[name + "_origin"][()].ravel()] == [point["origin"]
                                                                                       for point in points]
            assert list(np.ravel(summary[name]["origin"])) == [point["origin"] for point in points]
    assert drover_json(folder, "info", "table.h5")["coefficients"] == output["coefficients"]
    text = drover(folder, "info", "table.h5").stdout
    assert "scene_hash" in text and "alpha/Gamma [mm/s]" in text and "missing" in text
    about = attributes(folder / "table.h5")
    assert re.fullmatch(r"[0-9a-f]{16}", about["scene_hash"]) and about["seed"] == 3 and "[calibrate]" in about["scene"]
    assert about["drover_version"] and about["drover_commit"] and not {"host", "start_time"} & set(about)


def test_xarray_opens_a_table_with_its_area_fractions(whole):
    with xarray.open_dataset(whole[0] / "table.h5") as table:
        assert table["drag"].dims == ("bead_area_fraction", "rod_area_fraction")
        assert table["relaxation_rate"].dims == ("bead_area_fraction",)
        assert list(table["rod_area_fraction"].values) == [0.1, 0.2]
        found = table["drag"].sel(bead_area_fraction=0.4, rod_area_fraction=0.2)
        assert float(found) == whole[1]["coefficients"]["drag"]["points"][3]["value"] and found.attrs["units"] == "mm/s"


def test_closures_follow_from_the_measured_coefficients(whole):
    values = {name: np.array([point["value"] or math.nan for point in row["points"]], float) for name,
              row in whole[1]["coefficients"].items()}
    u, a = np.repeat(values["propulsion"], 2), np.repeat(values["relaxation_rate"], 2)
    sigma = np.tile([0.1, 0.2], 2) / values["rod_area"][0]
    mass_density = values["bead_mass"] * [0.2, 0.4] / values["bead_area"]
    assert np.allclose(values["pressure_rods"], u**2 / 2)
    assert np.allclose(values["noise_order"], a * sigma * u**2)
    assert np.allclose(values["friction_of_plates"], values["damping_rate"] * mass_density)
    # A cell contains integer numbers of bodies.
    assert np.allclose(values["rod_density"], sigma, atol=0.005) and np.allclose(values["bead_mass_density"],
                                                                                 mass_density, rtol=0.02)


def test_an_additional_varied_key_has_an_axis(tmp_path):
    scene = write_tiny(tmp_path, {**ONE, "calibrate.vary": "plates.amplitude = 0.04, 0.05"})
    row = drover_json(tmp_path, "calibrate", scene)["coefficients"]["damping_rate"]
    assert [point["plates.amplitude"] for point in row["points"]] == [0.04, 0.05]
    assert row["points"][0]["value"] != row["points"][1]["value"]
    with h5py.File(tmp_path / "tiny.calibration" / "table.h5") as file:
        assert file["damping_rate"].shape == (2, 1) and list(file["plates_amplitude"]) == [0.04,
                                                                                                                   0.05]
    assert len(toml_of(tmp_path / "tiny.calibration")["damping_rate"]["value"]) == 2


# --- resuming

def test_re_running_a_finished_calibration_runs_nothing_and_writes_the_same_bytes(whole, tmp_path):
    shutil.copytree(whole[0], tmp_path / "again")
    trials = trials_in(tmp_path / "again")
    ended = drover(tmp_path, "calibrate", write_tiny(tmp_path), "-o", "again", "--json", "--workers", "1")
    output = json.loads(ended.stdout)
    assert output["trials_run"] == 0 and output["coefficients"] == whole[1]["coefficients"]
    assert trials_in(tmp_path / "again") == trials
    assert_same_tables(tmp_path / "again", whole[0])


def test_a_smaller_target_error_and_more_points_use_the_stored_trials(tmp_path):
    scene = write_tiny(tmp_path, ONE)
    first = json.loads(drover(tmp_path, "calibrate", scene, "--json").stdout)
    more = settings(["calibrate.bead_area_fractions=[0.2, 0.3]", "calibrate.relative_error=0.02",
                     "calibrate.max_trials=24"])
    second = json.loads(drover(tmp_path, "calibrate", scene, "--json", *more).stdout)
    assert second["trials_found"] == first["trials_run"]
    points = second["coefficients"]["damping_rate"]["points"]
    assert points[1]["trials"] > first["coefficients"]["damping_rate"]["points"][0]["trials"]
    again = json.loads(drover(tmp_path, "calibrate", scene, "--json").stdout)
    assert again["trials_run"] == 0 and again["coefficients"] == first["coefficients"]  # only the first trials


def test_wanted_numbers_run_only_the_trials_that_they_need_and_a_smaller_error_continues(tmp_path):
    scene = write_tiny(tmp_path, {"calibrate.max_trials": 200})

    def wanted(wish, *more, status=0):
        return json.loads(drover(tmp_path, "calibrate", scene, "--json", "--want", wish, *more, status=status).stdout)

    first = wanted("damping_rate=30%")
    assert set(trials_in(tmp_path / "tiny.calibration")) == {"damping-bead-0.2", "damping-bead-0.4"}
    assert all(one["reached"] and 0 < one["error"] <= one["wanted_error"] for one in first["want"]["numbers"])
    assert first["want"]["core_seconds"] > 0 and first["want"]["assays"][0]["assay"] == "damping"
    assert first["trials_run"] == 16  # eight of each show that this is more than enough
    assert wanted("damping_rate=30%")["trials_run"] == 0
    second = wanted("damping_rate(Phi_b<0.3)=0.9%")
    assert second["trials_found"] == 8 and second["trials_run"] > 2
    assert [one["number"] for one in second["want"]["numbers"]] == ["damping_rate at bead area fraction 0.2"]
    points = second["coefficients"]["damping_rate"]["points"]
    assert points[0]["trials"] == 8 + second["trials_run"] and points[1]["trials"] == 8
    refused = wanted("damping_rate=0.01%", "--budget", "1s", status=1)["want"]["numbers"]
    assert not any(one["reached"] for one in refused) and "budget" in refused[0]["note"]
    # Without a wish the same trials have every assay reach its own target.
    whole = drover(tmp_path, "calibrate", scene, "--collect", "--json", status=1)
    assert "no trial was made" in json.loads(whole.stdout)["coefficients"]["drag"]["points"][0]["remark"]


def test_wishes_that_a_calibration_cannot_answer_are_rejected(tmp_path):
    scene = write_tiny(tmp_path)
    for wish, expected in (("onsett=5%", "did you mean onset?"), ("onset(q<1)=5%", "expected Phi_b, Phi_r"),
                           ("onset", "OBSERVABLE=ERROR"), ("onset=5", "the value is at most 1; expected onset=5%"),
                           ("onset(Phi_r>0.5)=5%", "no point of the table")):
        assert expected in drover(tmp_path, "calibrate", scene, "--want", wish, status=2).stderr
    assert not list(tmp_path.glob("*.calibration"))


def test_another_plan_of_one_assay_keeps_the_trials_of_the_others(tmp_path):
    scene = write_tiny(tmp_path, ONE)
    first = json.loads(drover(tmp_path, "calibrate", scene, "--json").stdout)
    second = json.loads(drover(tmp_path, "calibrate", scene, "--json", "--set", "calibrate.shear.hold=0.03").stdout)
    assert second["trials_run"] == 0 and second["trials_found"] == first["trials_run"]


def test_an_incomplete_record_is_passed_over_and_its_trial_repeated(whole, tmp_path):
    shutil.copytree(whole[0], tmp_path / "torn")
    file, = (tmp_path / "torn" / "records").glob("*.records")
    file.write_bytes(file.read_bytes()[:-5])
    ended = drover(tmp_path, "calibrate", write_tiny(tmp_path), "-o", "torn", "--json")
    assert json.loads(ended.stdout)["trials_run"] == 1
    assert_same_tables(tmp_path / "torn", whole[0])


@pytest.mark.parametrize("name", ["bed", "matched"])
def test_files_of_trials_of_earlier_versions_give_the_shipped_tables(name, tmp_path):
    shutil.copytree(MODELS / f"{name}.calibration", tmp_path / "kept")
    (tmp_path / "kept" / "table.h5").unlink()
    drover(tmp_path, "calibrate", MODELS / f"calibrate-{name}.toml", "--collect", "--quiet", "-o", "kept")
    shipped, found = (drover_json(tmp_path, "info", path)["coefficients"]
                      for path in (MODELS / f"{name}.calibration" / "table.h5", "kept/table.h5"))
    assert found == shipped


# --- errors

def test_a_result_with_a_larger_error_is_kept_marked_and_reported(tmp_path):
    scene = write_tiny(tmp_path, {**ONE, "calibrate.relative_error": 1e-6})
    ended = drover(tmp_path, "calibrate", scene)
    assert "1 of 1 measurements have a larger error than requested" in ended.stderr
    assert re.search(r"\d !\n", ended.stdout) and re.search(r"! damping_rate at bead area fraction 0.3: .*trials "
                                                            r"are needed", ended.stdout)
    with h5py.File(tmp_path / "tiny.calibration" / "table.h5") as file:
        assert list(file["damping_rate_origin"]) == [2]
        assert "trials are needed" in file.attrs["remarks"].decode()


def test_a_point_whose_trials_fail_is_missing_with_the_reason(tmp_path):
    scene = write_tiny(tmp_path, {**ONE, "calibrate.bead_area_fractions": [0.3, 0.5], "contacts.max_overlap": 1e-4})
    ended = drover(tmp_path, "calibrate", scene, "--json", status=1)
    assert len(re.findall(r"trial \d+ failed: ", ended.stderr)) == 2 and "2 of 2 measurements failed" in ended.stderr
    for point in json.loads(ended.stdout)["coefficients"]["damping_rate"]["points"]:
        assert point["origin"] == "missing" and re.search(r"8 of 8 trials failed; expected at most 10 %: .* overlap",
                                                          point["remark"])
    assert json.loads(drover(tmp_path, "calibrate", scene, "--json", status=1).stdout)["trials_run"] == 0


def test_scenes_that_cannot_be_calibrated_are_rejected_with_a_message(tmp_path):
    for changes, says in (
            ({"calibrate.bead_area_fractions": []}, ["tiny.toml", "nothing to calibrate", "[0.2, 0.4, 0.6]"]),
            ({"calibrate.rod_area_fractions": []}, ["rod_area_fractions is empty", "drag depends on it"]),
            ({"calibrate.bead_area_fractions": [0.4, 0.2]}, ["has 0.2 after 0.4", "ascend"]),
            ({"calibrate.bead_area_fractions": [0.0]}, ["> 0"]),
            ({"calibrate.assays": ["dragg"]}, ['did you mean "drag"?']),
            ({"calibrate.vary": "run.seed = 1, 2"}, ["names run.seed"]),
            ({"calibrate.vary": "kick.strength"}, ["expected a name, = and numbers"]),
            ({"calibrate.vary": "kick.strenght = 0.1"}, ["did you mean kick.strength?"]),
            ({"calibrate.max_trials": 8, "calibrate.round": 16}, ["two rounds"]),
            ({"calibrate.drag.torques": [1.0]}, ["calibrate.drag: ", "at least two torques"]),
            ({"calibrate.drag.torque": 1.0}, ["unknown key calibrate.drag.torque", "torques"]),
            ({"calibrate.dragg.time": 1.0}, ["unknown table [calibrate.dragg]", "[calibrate.drag]"]),
            ({"gravity.x": 100.0}, ["tiny.toml:", "gravity.x = 100 mm/s^2: tilted plates"]),
            ({"gravity.y": -1.0}, ["gravity.y = -1 mm/s^2: tilted plates"]),
            ({"calibrate.vary": "gravity.x = 0, 100"}, ["names gravity.x"]),
            ({"cell.shape": "circle"}, ['expected "periodic"'])):
        rejected(tmp_path, ["calibrate", write_tiny(tmp_path, changes)], says)
    (tmp_path / "flock.toml").write_text(scene_text(SMALL))
    rejected(tmp_path, ["calibrate", "flock.toml"], ["scene of fields"])
    scene = write_tiny(tmp_path)
    rejected(tmp_path, ["check", write_tiny(tmp_path, {"calibrate.rod_area_fractions": []}, name="empty.toml")],
            ["drag depends on it"])
    heavy = {"rods.densities": [8.7] * 7 + [2.7] * 6}  # heads 2.89 mm from the centre of mass
    rejected(tmp_path, ["check", write_tiny(tmp_path, {**heavy, "calibrate.scattering.range": 5.6}, name="near.toml")],
             ["near.toml:", "a range of 5.6 mm", "5.781 mm apart"])
    for share in ("0/2", "3/2", "2", "1/2x", "a/b"):
        rejected(tmp_path, ["calibrate", scene, "--share", share], ["expected I/N"])
    rejected(tmp_path, ["calibrate", scene, "--collect"], ["no such folder"])
    rejected(tmp_path, ["calibrate", scene, "--share", "1/2", "--json"], ["prints no result"])
    rejected(tmp_path, ["calibrate", scene, "-o", "."], ["not empty and holds no calibrate.toml"])


def test_folders_and_trials_of_another_scene_are_rejected(tmp_path):
    scene = write_tiny(tmp_path, ONE)
    drover(tmp_path, "calibrate", scene, "--quiet")
    rejected(tmp_path, ["calibrate", scene, "--set", "restitution.bead_bead=0.9"],
            ["results of another scene", "restitution.bead_bead = 0.3 there, 0.9 here"])
    folder = tmp_path / "tiny.calibration"
    rejected(tmp_path, ["calibrate", scene, "--set", "calibrate.damping.hold=0.03"],
             ["records: the trials of damping-bead-0.3 have another plan: calibrate.damping.hold = 0.02 there, 0.03 "
              "here"])
    (folder / "records" / "notes.records").write_text("notes of mine")
    rejected(tmp_path, ["calibrate", scene], ["notes.records", "is not a file of records"])
    (folder / "records" / "notes.records").unlink()


def test_a_trial_longer_than_the_grace_period_is_killed(tmp_path):
    scene = write_tiny(tmp_path, {**ONE, "calibrate.damping.time": 2000.0})
    process = start(tmp_path, "calibrate", scene, "--workers", "1")
    try:
        claims = tmp_path / "tiny.calibration" / "claims"
        wait_until(lambda: list(claims.glob("damping-*")), "a claim",
                   process=process)  # the trial itself takes a minute
        process.send_signal(signal.SIGINT)
        process.communicate(timeout=10)
    finally:
        end_group(process)
    assert process.returncode == 3 and not group_is_alive(process.pid)


def test_damaged_tables_are_rejected(whole, tmp_path):
    def spoiled(change):
        shutil.copy(whole[0] / "table.h5", tmp_path / "table.h5")
        with h5py.File(tmp_path / "table.h5", "r+") as file:
            change(file)
        return ["info", "table.h5"]

    def put(name, value):
        def change(group):
            group[name][0] = value
        return change

    def drop(name):
        def change(group):
            del group[name]
        return change

    rejected(tmp_path, spoiled(put("damping_rate_error", -1.0)),
            ["damping_rate at bead area fraction 0.2 has the standard error -1"])
    rejected(tmp_path, spoiled(put("damping_rate", math.nan)), ["damping_rate at bead area fraction 0.2 is nan"])
    rejected(tmp_path, spoiled(put("damping_rate_origin", 9)), ["damping_rate_origin holds 9"])
    rejected(tmp_path, spoiled(put("bead_area_fraction", 0.7)), ["expected ascending area fractions between 0 and 1"])
    rejected(tmp_path, spoiled(drop("drag_trials")), ["/drag_trials is missing"])
    rejected(tmp_path, spoiled(drop("drag")), ["/drag is listed but missing"])
    (tmp_path / "table.h5").write_bytes((whole[0] / "table.h5").read_bytes()[:3000])
    rejected(tmp_path, ["info", "table.h5"], ["table.h5"])


# --- the scenes

SHORT = ["cell.lx=10", "cell.ly=10", "time.dt=4e-5", "contacts.max_overlap=0.2", "calibrate.bead_area_fractions=[0.3]",
         "calibrate.round=4",
         'calibrate.assays=["damping"]', "calibrate.max_trials=8", "calibrate.damping.time=0.2"]


def test_scenes_for_calibrate_are_listed_in_the_readme():
    listed = dict(re.findall(r"^\| `([a-z-]+)\.toml` \|.*\| ([^|]+) \|$", (MODELS / "README.md").read_text(), re.M))
    assert scenes("calibrate") == ["calibrate-bed", "calibrate-matched", "calibrate-paper", "calibrate-small"]
    for scene in scenes("calibrate"):
        first, second = (MODELS / f"{scene}.toml").read_text().splitlines()[:2]
        assert re.fullmatch(r"# Shows: .+\.", first) and listed[scene] == re.fullmatch(r"# Takes: (.+)\.",
                                                                                       second).group(1), scene


@pytest.mark.parametrize("scene", scenes("calibrate"))
def test_a_shipped_calibration_scene_is_valid_and_runs(scene, tmp_path):
    path = MODELS / f"{scene}.toml"
    drover(tmp_path, "check", path)
    units = {"calibrate-bed": 6, "calibrate-small": 26, "calibrate-matched": 54, "calibrate-paper": 48}[scene]
    assert f"drover calibrate: {units} measurements" in drover(tmp_path, "explain", path).stdout
    point = json.loads(drover(tmp_path, "calibrate", path, "--json",
                              *settings(SHORT)).stdout)["coefficients"]["damping_rate"]["points"][0]
    assert point["value"] is not None and point["trials"] == 8
    drover(tmp_path, "run", path, "--quiet", *settings(SHORT[:4]), "--set", "time.end=0.02", "--set",
           "output.sample_every=0.01")


def test_the_schema_lists_every_key_of_a_calibration():
    output = {section["name"]: section
            for section in json.loads(drover(Path.cwd(), "schema", "--kind", "particles", "--json").stdout)}
    for key in TINY:
        section, name = key.rsplit(".", 1)
        row = next(row for row in output[section]["rows"] if row["name"] == name)
        assert row["doc"]
