"""tests/app/test_campaign.py: a sweep in shares: any number of processes, killed at any time, give the same table."""
import os
import random
import shutil
import signal
import subprocess
import time

import h5py
import pytest
from support import DROVER, checkpoints, damage, drover, end_group, environment, start, wait_until, write_scene

TINY = {"grid.nx": 8, "grid.ny": 8, "grid.lx": 8.0, "grid.ly": 8.0, "time.dt": 0.1, "time.end": 4.0,
        "output.frame_every": 0.0, "output.sample_every": 0.5}
VARY = ["--vary", "relaxation.rate = 0.5:2:10", "--seeds", "2", "--keep", "table", "--quiet"]


def table_of(folder):
    return (folder / "table.csv").read_bytes(), (folder / "table.nc").read_bytes()


@pytest.fixture(name="whole", scope="module")
def fixture_whole(tmp_path_factory):
    """The table of one worker that nothing disturbs."""
    folder = tmp_path_factory.mktemp("whole")
    drover(folder, "sweep", write_scene(folder, TINY), *VARY, "--workers", "1")
    return table_of(folder / "flock.sweep")


def test_a_table_of_records_is_that_of_archives(whole, tmp_path):
    words = [word if word != "table" else "archives" for word in VARY]
    drover(tmp_path, "sweep", write_scene(tmp_path, TINY), *words)
    assert table_of(tmp_path / "flock.sweep")[0] == whole[0]
    assert len(list((tmp_path / "flock.sweep").glob("*.h5"))) == 20


def test_shares_one_after_another_and_at_the_same_time_give_that_table(whole, tmp_path):
    scene = write_scene(tmp_path, TINY)
    for folder, together in (("one", False), ("all", True)):
        processes = []
        for share in range(1, 5):
            processes.append(start(tmp_path, "sweep", scene, *VARY, "--share", f"{share}/4", "-o", folder))
            if not together:
                assert processes[-1].wait(timeout=60) == 0
        assert [process.wait(timeout=60) for process in processes] == [0] * 4
        assert "20 of 20 done, 0 failed" in drover(tmp_path, "sweep", scene, *VARY, "--status", "-o", folder).stdout
        drover(tmp_path, "sweep", scene, *VARY, "--collect", "-o", folder)
        assert table_of(tmp_path / folder) == whole
        files = [file for file in (tmp_path / folder).rglob("*") if file.is_file()]
        assert len(files) <= 3 + 4 and not list((tmp_path / folder).glob("*.h5"))


def test_whoever_is_killed_the_same_command_ends_in_that_table(whole, tmp_path):
    scene = write_scene(tmp_path, TINY)
    chance = random.Random(5)
    for round_ in range(3):
        folder = f"killed-{round_}"
        for _ in range(4):
            shares = [start(tmp_path, "sweep", scene, *VARY, "--share", f"{share}/2", "-o", folder)
                      for share in (1, 2)]
            time.sleep(chance.uniform(0.0, 0.15))
            for process in shares:
                os.kill(process.pid, signal.SIGKILL)
                process.wait()
                end_group(process)
        drover(tmp_path, "sweep", scene, *VARY, "-o", folder)
        assert table_of(tmp_path / folder) == whole
        # Whose file is still empty is not known: a process killed before it wrote it counts as dead after a minute.
        assert not [file for file in (tmp_path / folder / "claims").iterdir() if file.stat().st_size > 0]


def test_collecting_names_what_is_missing_and_the_same_command_goes_on(whole, tmp_path):
    scene = write_scene(tmp_path, TINY)
    process = start(tmp_path, "sweep", scene, *VARY, "--workers", "1")
    while not list((tmp_path / "flock.sweep" / "records").glob("*")):
        time.sleep(0.005)
    process.kill()
    process.wait()
    end_group(process)
    ended = drover(tmp_path, "sweep", scene, *VARY, "--collect", status=1)
    assert "of 20 runs are missing; re-run the same command without --collect" in ended.stderr
    drover(tmp_path, "sweep", scene, *VARY)
    assert table_of(tmp_path / "flock.sweep") == whole


def test_a_point_that_fails_is_named_by_every_share_and_tried_again_by_the_plain_command(tmp_path):
    scene = write_scene(tmp_path, {**TINY, "initial.kind": "random", "initial.amplitude": 0.1})
    words = ["sweep", scene, "--vary", "relaxation.rate = 0.5, -200, 2", "--keep", "table", "--quiet"]
    assert "1 jobs failed" in drover(tmp_path, *words, "--share", "1/2", status=1).stderr
    assert "1 jobs failed" in drover(tmp_path, *words, "--share", "2/2", status=1).stderr
    assert "the run diverged" in drover(tmp_path, *words, "--collect", status=1).stderr
    assert "the run diverged" in drover(tmp_path, *words, status=1).stderr
    assert "2 of 3 done, 1 failed" in drover(tmp_path, *words, "--status").stdout


def test_a_ramp_in_shares_passes_states_on_and_keeps_no_archive(tmp_path):
    words = ["--vary", "relaxation.rate = 0.5, 1, 2", "--ramp", "up-down", "--quiet"]
    scene = write_scene(tmp_path, TINY)
    drover(tmp_path, "sweep", scene, *words, "-o", "archives")
    drover(tmp_path, "sweep", scene, *words, "--keep", "table", "--share", "2/3", "-o", "table")
    drover(tmp_path, "sweep", scene, *words, "--keep", "table", "-o", "table")
    assert table_of(tmp_path / "table")[0] == table_of(tmp_path / "archives")[0]
    assert not list((tmp_path / "table").glob("*.h5*"))


@pytest.mark.skipif(not shutil.which("parallel"), reason="GNU parallel is not installed")
def test_gnu_parallel_runs_the_shares(whole, tmp_path):
    scene = write_scene(tmp_path, TINY)
    words = ["parallel", "-j", "3", DROVER, "sweep", str(scene), *(f"'{word}'" for word in VARY), "--share", "{}/6",
             ":::", *map(str, range(1, 7))]
    subprocess.run(words, cwd=tmp_path, env=environment(), check=True, timeout=120)
    assert table_of(tmp_path / "flock.sweep") == whole


RAMP = ["--vary", "relaxation.rate = 0.5, 1", "--ramp", "up", "--quiet"]


def without_records(folder):
    shutil.rmtree(folder / "records")
    return folder


def test_a_run_of_another_length_is_not_taken_for_that_of_the_sweep(tmp_path):
    words = ["sweep", write_scene(tmp_path, TINY), "--vary", "time.end = 2, 4", "--quiet"]
    drover(tmp_path, *words)
    folder = without_records(tmp_path / "flock.sweep")
    for ending in ("", ".checkpoint-a", ".checkpoint-b"):
        shutil.copy(folder / f"point-0000-seed-7.h5{ending}", folder / f"point-0001-seed-7.h5{ending}")
    assert "time.end = 2.0 in the archive, 4.0 in" in drover(tmp_path, *words, status=2).stderr


def test_an_archive_of_another_run_ends_a_share_and_nothing_is_recorded(tmp_path):
    words = ["sweep", write_scene(tmp_path, TINY), *RAMP]
    drover(tmp_path, *words)
    folder = without_records(tmp_path / "flock.sweep")
    drover(tmp_path, "restart", folder / "point-0000-seed-7.h5", "--set", "time.end=8", "--quiet")
    for more in ([], ["--share", "1/2"]):
        assert "time.end = 8.0 in the archive, 4.0 in" in drover(tmp_path, *words, *more, status=2).stderr
    assert not list((folder / "records").glob("*"))


def test_the_next_point_of_a_ramp_does_not_start_from_another_run(tmp_path):
    words = ["sweep", write_scene(tmp_path, TINY), *RAMP, "--share", "1/2"]
    drover(tmp_path, *words, "--workers", "1", "--stop-when", "jobs=1", status=3)
    archive = tmp_path / "flock.sweep" / "point-0000-seed-7.h5"
    drover(tmp_path, "restart", archive, "--set", "time.end=8", "--quiet")
    assert "time.end = 8.0 in the archive, 4.0 in" in drover(tmp_path, *words, status=2).stderr
    archive.unlink()
    records = list((tmp_path / "flock.sweep" / "records").glob("*"))
    drover(tmp_path, *words)  # its record counts no more
    assert len(list((tmp_path / "flock.sweep" / "records").glob("*"))) > len(records)


def test_damaged_archives_are_repeated_and_other_files_stay(tmp_path):
    scene = write_scene(tmp_path, TINY)
    words = ["sweep", scene, "--vary", "relaxation.rate = 0.5, 1, 2", "--quiet"]
    drover(tmp_path, *words)
    folder = without_records(tmp_path / "flock.sweep")
    table = table_of(folder)
    cut, empty, left = sorted(folder.glob("*.h5"))
    os.truncate(cut, cut.stat().st_size // 2)
    os.truncate(empty, 0)
    with h5py.File(left, "r+") as file:  # as before its end
        del file["summary"]
    for checkpoint in filter(os.path.exists, checkpoints(left)):
        damage(checkpoint)
    assert drover(tmp_path, *words, "--share", "1/2").stderr.count("is run again from its start") == 3
    drover(tmp_path, *words)
    assert table_of(folder) == table
    os.truncate(cut, cut.stat().st_size // 2)  # a run with a record
    assert drover(tmp_path, *words).stderr.count("is run again from its start") == 1
    assert table_of(folder) == table and drover(tmp_path, "info", cut).stdout
    without_records(folder)
    cut.write_text("my notes")
    for more in ([], ["--share", "1/2"]):
        assert "move this elsewhere" in drover(tmp_path, *words, *more, status=2).stderr
    assert cut.read_text() == "my notes"


def test_a_damaged_start_of_a_ramp_is_repeated_before_what_starts_from_it(tmp_path):
    words = ["sweep", write_scene(tmp_path, TINY), *RAMP]
    drover(tmp_path, *words)
    folder = tmp_path / "flock.sweep"
    table = table_of(folder)
    os.truncate(folder / "point-0000-seed-7.h5", 0)
    (folder / "point-0001-seed-7.h5").unlink()
    drover(tmp_path, *words)
    assert table_of(folder) == table


def test_an_archive_that_is_deleted_during_its_run_is_no_failure_of_the_scene(tmp_path):
    scene = write_scene(tmp_path, {**TINY, "time.end": 1e5, "output.frame_every": 0.5})
    words = ["sweep", scene, "--vary", "relaxation.rate = 0.5, 1", "--quiet"]
    process = start(tmp_path, *words, "--share", "1/2", "--workers", "1")
    try:
        archive = tmp_path / "flock.sweep" / "point-0000-seed-7.h5"
        wait_until(checkpoints(archive)[0].exists, "the first checkpoint", process=process)
        archive.unlink()
        assert "was deleted while the run wrote it" in process.communicate(timeout=60)[1]
        assert process.returncode == 1
    finally:
        end_group(process)
    assert "0 of 2 done, 0 failed" in drover(tmp_path, *words, "--status").stdout


def test_a_ramp_whose_last_point_failed_keeps_what_the_next_try_starts_from(tmp_path):
    scene = write_scene(tmp_path, {**TINY, "initial.kind": "random", "initial.amplitude": 0.1})
    words = ["sweep", scene, "--vary", "relaxation.rate = 0.5, -200", "--ramp", "up", "--keep", "table", "--quiet"]
    for _ in range(2):
        assert "the run diverged" in drover(tmp_path, *words, status=1).stderr
        assert (tmp_path / "flock.sweep" / "point-0000-seed-7.h5").exists()


def test_a_table_is_made_of_what_is_known_when_its_turn_comes(whole, tmp_path):
    words = ["sweep", write_scene(tmp_path, TINY), *VARY]
    drover(tmp_path, *words, "-o", "all")
    drover(tmp_path, *words, "--share", "1/2", "--stop-when", "jobs=3", status=3)
    folder = tmp_path / "flock.sweep"
    turn = folder / "claims" / "table.0"  # of a process that is writing its name
    turn.touch()
    process = start(tmp_path, *words, "--collect")
    try:
        wait_until(lambda: list((folder / "claims").glob("owner-*")), "the wait for its turn", process=process)
        for file in (tmp_path / "all" / "records").iterdir():
            shutil.copy(file, folder / "records")
        turn.unlink()
        assert process.wait(timeout=60) == 0
    finally:
        end_group(process)
    assert table_of(folder) == whole


def test_a_sweep_is_not_resumed_from_another_start(tmp_path):
    for name, seed in (("one", 1), ("other", 2)):
        drover(tmp_path, "run", write_scene(tmp_path, TINY), "--set", f"run.seed={seed}", "-o", f"{name}.h5", "--quiet")
    scene = write_scene(tmp_path, {**TINY, "initial.kind": "file", "initial.file": "st.h5"})
    words = ["sweep", scene, "--vary", "relaxation.rate = 0.5, 1", "--keep", "table", "--quiet"]
    shutil.copy(tmp_path / "one.h5", tmp_path / "st.h5")
    drover(tmp_path, *words, "--share", "1/2", "--workers", "1", "--stop-when", "jobs=1", status=3)
    shutil.copy(tmp_path / "other.h5", tmp_path / "st.h5")
    for more in ([], ["--share", "2/2"]):
        assert "initial.file is not the archive from which" in drover(tmp_path, *words, *more, status=2).stderr
    (tmp_path / "st.h5").unlink()
    assert "1 of 2 runs are missing" in drover(tmp_path, *words, "--collect", status=1).stderr
    shutil.copy(tmp_path / "one.h5", tmp_path / "st.h5")
    drover(tmp_path, *words)
    # Earlier versions wrote no checksum.
    manifest = without_records(tmp_path / "flock.sweep") / "sweep.toml"
    text = manifest.read_text()
    manifest.write_text(text[:text.index("\n# Checksum")])
    for _ in range(2):
        drover(tmp_path, *words)


def test_a_script_for_slurm_keeps_the_time_and_refuses_workers(tmp_path):
    words = ["sweep", write_scene(tmp_path, TINY), *VARY, "--slurm", "2"]
    assert drover(tmp_path, *words, "--max-time", "1h").stdout.count(" --max-time 3600") == 1
    assert "omit it, and give --cpus-per-task" in drover(tmp_path, *words, "--workers", "3", status=2).stderr


def test_a_script_for_slurm_ends_at_once_where_there_is_no_drover(tmp_path):
    script = drover(tmp_path, "sweep", write_scene(tmp_path, TINY), *VARY, "--slurm", "2").stdout
    sh = shutil.which("sh")
    (tmp_path / "bin").mkdir()
    ended = subprocess.run([sh], input=script, cwd=tmp_path, capture_output=True, text=True, check=False,
                           env={"PATH": str(tmp_path / "bin")})
    assert ended.returncode == 2 and ended.stderr == "drover is not found: add its folder to PATH\n"
    assert ended.stdout == ""
