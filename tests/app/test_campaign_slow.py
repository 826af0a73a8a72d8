"""tests/app/test_campaign_slow.py: work on a real Slurm whose jobs and daemons are killed, and on a network folder."""
import sys
from pathlib import Path

import pytest

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
