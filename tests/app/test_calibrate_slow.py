"""tests/app/test_calibrate_slow.py: twenty kills of one calibration at random moments; see calibration.py for what must hold."""
import random
import time

from calibration import kill_again_and_again, write_tiny
from support import drover


def test_a_calibration_killed_twenty_times_ends_with_the_same_bytes(tmp_path):
    # More trials than in the fast tests, so that twenty kills meet it at work.
    scene = write_tiny(tmp_path, {"calibrate.relative_error": 0.1, "calibrate.trials_most": 48})
    began = time.monotonic()
    drover(tmp_path, "calibrate", scene, "-o", "whole", "--quiet")
    took = time.monotonic() - began
    assert kill_again_and_again(tmp_path, scene, tmp_path / "whole", 20, random.Random(11), took / 8.0) >= 15
