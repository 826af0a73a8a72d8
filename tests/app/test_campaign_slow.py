"""tests/app/test_campaign_slow.py: work on a real Slurm whose jobs and daemons are killed, and on a network folder."""
import os
import random
import shutil
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest
from support import DROVER, drover, environment, write_scene

sys.path.append(str(Path(__file__).resolve().parents[1] / "faults"))
import network  # noqa: E402
import slurm  # noqa: E402


@pytest.mark.skipif(bool(slurm.why_not()), reason=slurm.why_not() or "it can run")
@pytest.mark.parametrize("command, points, shares, end", [("sweep", 300, 10, 200.0), ("calibrate", 48, 4, 20.0),
                                                          ("wanted", 48, 4, 20.0), ("tradeoff", 30, 4, 20.0)])
def test_work_on_slurm_whose_jobs_and_daemons_are_killed_has_the_result_of_one_worker(command, points, shares, end,
                                                                                       tmp_path):
    assert slurm.study(slurm.COMMANDS[command](tmp_path, points, end), shares=shares, kills=8) == ""


@pytest.mark.skipif(bool(network.why_not()), reason=network.why_not() or "it can run")
def test_shares_on_a_network_file_system_that_stalls_have_the_table_of_one_process(tmp_path):
    assert network.study(tmp_path) == ""


def programs_of(session):
    """The processes of drover in a session, workers included."""
    found = []
    for folder in Path("/proc").glob("[0-9]*"):
        try:
            is_drover = os.path.samefile(folder / "exe", DROVER)
            if is_drover and os.getsid(int(folder.name)) == session:
                found.append(int(folder.name))
        except OSError:  # it has ended
            continue
    return found


@pytest.mark.skipif(not shutil.which("parallel"), reason="GNU parallel is not installed")
def test_gnu_parallel_whose_shares_are_killed_ten_times_has_the_table_of_one_worker(tmp_path):
    scene = write_scene(tmp_path, {"output.frame_every": 0.0, "time.end": 100.0})
    words = [scene, "--vary", "relaxation.rate = 0.5:2:1000", "--keep", "table", "--quiet"]
    drover(tmp_path, "sweep", *words, "--workers", "1", "-o", "whole")
    parallel = subprocess.Popen(
        ["parallel", "-j", "3", DROVER, "sweep", *(f"'{word}'" for word in words), "--workers", "1", "--share", "{}/20",
         "-o", "shares", ":::", *map(str, range(1, 21))], cwd=tmp_path, env=environment(), start_new_session=True)
    chance, kills = random.Random(11), 0
    while kills < 10 and parallel.poll() is None:
        time.sleep(chance.uniform(0.2, 0.8))
        programs = programs_of(parallel.pid)
        if programs:
            try:
                os.kill(chance.choice(programs), signal.SIGKILL)
                kills += 1
            except ProcessLookupError:  # it ended a moment ago
                pass
    parallel.wait(timeout=600)
    assert kills == 10
    drover(tmp_path, "sweep", *words, "-o", "shares")
    for name in ("table.csv", "table.nc"):
        assert (tmp_path / "shares" / name).read_bytes() == (tmp_path / "whole" / name).read_bytes()
