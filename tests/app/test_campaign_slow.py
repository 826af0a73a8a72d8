"""tests/app/test_campaign_slow.py: work on a real Slurm whose jobs and daemons are killed."""
import sys
from pathlib import Path

import pytest

sys.path.append(str(Path(__file__).resolve().parents[1] / "faults"))
import slurm  # noqa: E402


@pytest.mark.skipif(bool(slurm.why_not()), reason=slurm.why_not() or "it can run")
@pytest.mark.parametrize("command, points, shares, end", [("sweep", 300, 10, 200.0), ("calibrate", 48, 4, 20.0),
                                                          ("wanted", 48, 4, 20.0), ("tradeoff", 30, 4, 20.0)])
def test_work_on_slurm_whose_jobs_and_daemons_are_killed_has_the_result_of_one_worker(command, points, shares, end,
                                                                                       tmp_path):
    assert slurm.study(slurm.COMMANDS[command](tmp_path, points, end), shares=shares, kills=8) == ""
