"""tests/app/test_campaign_slow.py: a sweep on a real Slurm whose jobs and daemons are killed."""
import sys
from pathlib import Path

import pytest

sys.path.append(str(Path(__file__).resolve().parents[1] / "faults"))
import slurm  # noqa: E402


@pytest.mark.skipif(bool(slurm.why_not()), reason=slurm.why_not() or "it can run")
def test_a_sweep_on_slurm_whose_jobs_and_daemons_are_killed_ends_in_the_table_of_one_worker(tmp_path):
    assert slurm.study(tmp_path, points=300, shares=10, kills=8, end=200.0) == ""
