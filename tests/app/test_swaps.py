"""tests/app/test_swaps.py: some of the swaps of tests/faults/swaps.py: 200 there, a few here."""
import os
import random
import sys
from pathlib import Path

import pytest

FAULTS = Path(__file__).resolve().parents[1] / "faults"
sys.path.insert(0, str(FAULTS))
from swaps import complaints  # noqa: E402


@pytest.mark.parametrize("kind, difference", [
    ("archive", "relaxation.rate"), ("archive", "run.seed"), ("archive", "version"), ("archive", "grid.nx"),
    ("checkpoint", "output.frame_every"), ("checkpoint", "nothing"), ("journal", "noise.rods"),
    ("sweep", "noise.order"), ("sweep", "version"), ("records", "run.seed"), ("trial", "nothing"),
    ("calibration", "run.seed")])
def test_files_of_two_runs_are_not_joined_and_their_difference_is_named(kind, difference, tmp_path):
    if kind == "journal" and not os.environ.get("DROVER_SHIM"):
        pytest.skip("DROVER_SHIM is not set; ctest sets it")
    assert complaints(tmp_path, kind, difference, None, random.Random(1)) == []
