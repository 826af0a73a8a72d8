"""tests/app/test_calibrate_shares.py: a calibration in shares and after kills: the same table for any processes."""
import json
import random
import re
import signal
import subprocess
import time
from pathlib import Path

import pytest
from calibration import (UNITS, already_done, assert_same_tables, kill_repeatedly, trials_in, undisturbed,
                         write_tiny)
from support import drover, end_group, end_shares, environment, slurm_at_once, start, start_shares, wait_until

ONE = {"calibrate.bead_area_fractions": [0.3], "calibrate.assays": ["damping"]}  # one measurement


@pytest.fixture(scope="module", name="whole")
def calibration_made_once(tmp_path_factory):
    """The reference calibration: its folder, JSON output and log."""
    return undisturbed(tmp_path_factory.mktemp("whole"))


def test_the_script_for_slurm_gives_the_same_table_in_shares(whole, tmp_path):
    slurm = slurm_at_once(tmp_path)
    folder = tmp_path / "it's here"  # a quote and a space
    folder.mkdir()
    scene = write_tiny(folder)
    script = drover(folder, "calibrate", scene, "--slurm", "3", "-o", "shares").stdout
    (folder / "calibrate.sh").write_text(script)
    ended = subprocess.run(["sh", "calibrate.sh", "--partition=short"], cwd=folder, capture_output=True, text=True,
                           check=False, env=environment(**slurm), timeout=300)
    assert ended.returncode == 0, ended.stderr
    array, table = Path(slurm["SBATCH_LOG"]).read_text().split("--parsable ")[1:]
    assert "--array=1-3" in array and "--partition=short" in array
    assert "--dependency=afterany:4711 " in table and "--partition=short" in table and "--share" not in table
    assert_same_tables(folder / "shares", whole[0])


def test_shares_at_the_same_time_divide_the_trials_and_the_last_makes_the_table(whole, tmp_path):
    scene = write_tiny(tmp_path)
    shares = start_shares(tmp_path, 3, "calibrate", scene, "--workers", "1")
    try:
        wait_until(lambda: len(trials_in(tmp_path / "tiny.calibration")) > 4, "some trials", process=shares[0])
        line = drover(tmp_path, "calibrate", scene, "--status").stdout
        assert re.match(rf"\d+ of {UNITS} measurements done; of the trials that are known to be needed: \d+ of \d+ "
                        r"done, 0 failed, \d+ running in 3 processes; .+ a minute, .+ left\n", line), line
    finally:
        end_shares(shares)
    found, undisturbed = trials_in(tmp_path / "tiny.calibration"), trials_in(whole[0])
    assert {name: set(numbers) for name, numbers in found.items()} == {name: set(numbers) for name, numbers
                                                                       in undisturbed.items()}
    count = sum(map(len, undisturbed.values()))  # a trial of a moment may be run twice, for the same result
    assert sum(map(len, found.values())) <= 1.1 * count
    assert_same_tables(tmp_path / "tiny.calibration", whole[0])
    assert not list((tmp_path / "tiny.calibration" / "claims").iterdir())


def test_shares_that_are_killed_and_started_twice_end_in_the_same_table(whole, tmp_path):
    scene, chance = write_tiny(tmp_path), random.Random(7)
    for _ in range(4):
        shares = [start(tmp_path, "calibrate", scene, "--workers", "1", "--share", f"{share}/2") for share in (1, 2, 2)]
        time.sleep(chance.uniform(0.05, 0.6))
        for process in shares:
            process.kill()
            process.wait()
            end_group(process)
    drover(tmp_path, "calibrate", scene, "--share", "1/2")
    assert_same_tables(tmp_path / "tiny.calibration", whole[0])
    numbers = trials_in(tmp_path / "tiny.calibration")
    assert {name: set(found) for name, found in numbers.items()} == {name: set(found) for name, found
                                                                     in trials_in(whole[0]).items()}


def test_shares_reach_wanted_numbers_together(tmp_path):
    scene = write_tiny(tmp_path, {"calibrate.max_trials": 200})
    words = ["calibrate", scene, "--want", "damping_rate=2%", "--workers", "1"]
    end_shares(start_shares(tmp_path, 3, *words))
    assert drover(tmp_path, *words, "--status").stdout.startswith("2 of 2 wanted numbers reached")
    found = json.loads(drover(tmp_path, *words, "--json").stdout)
    assert found["trials_run"] == 0 and all(one["reached"] for one in found["want"]["numbers"])
    script = drover(tmp_path, *words[:4], "--budget", "1h", "--slurm", "3").stdout
    assert "--want damping_rate=2% --budget 1h" in script


def test_what_is_not_finished_is_missing_in_the_table(tmp_path):
    scene = write_tiny(tmp_path, {**ONE, "calibrate.relative_error": 0.01, "calibrate.max_trials": 200})
    process = start(tmp_path, "calibrate", scene, "--workers", "1", "--share", "1/2")
    try:
        wait_until(lambda: trials_in(tmp_path / "tiny.calibration"), "a trial", process=process)
        process.send_signal(signal.SIGTERM)
        process.communicate(timeout=10)
    finally:
        end_group(process)
    assert process.returncode == 3 and not (tmp_path / "tiny.calibration" / "table.h5").exists()
    ended = drover(tmp_path, "calibrate", scene, "--collect", "--json", status=1)
    assert "1 of 1 measurements are not finished; re-run the same command without --collect" in ended.stderr
    hole, = json.loads(ended.stdout)["coefficients"]["damping_rate"]["points"]
    assert re.match(r"not finished: \d+ of at least \d+ trials", hole["remark"])
    drover(tmp_path, "calibrate", scene)


def test_the_table_is_the_same_for_any_number_of_workers_and_after_kills(whole, tmp_path):
    # Kills hit it with two workers; the rest runs on all cores.
    assert kill_repeatedly(tmp_path, write_tiny(tmp_path), whole[0], 3, random.Random(5), 0.5) >= 1


def test_a_signal_stops_it_quickly_and_the_same_command_resumes(whole, tmp_path):
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
