"""tests/app/test_campaign.py: a sweep in shares: any number of processes, killed at any time, give the same table."""
import os
import random
import shutil
import signal
import subprocess
import time

import pytest
from support import DROVER, drover, end_group, environment, start, write_scene

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
