"""tests/app/test_extreme_scenes.py: a sample of the scenes of tests/extremes; each commit takes another one."""
import hashlib
import os
import subprocess
import sys
from pathlib import Path

import pytest
from support import DROVER

ATLAS = Path(__file__).resolve().parents[1] / "extremes" / "atlas.py"


def first_of(kind, count, sample):
    """Where the sample begins: by the commit, or at 0 outside a repository."""
    commit = subprocess.run(["git", "rev-parse", "HEAD"], cwd=ATLAS.parent, capture_output=True, text=True, check=False)
    return int(hashlib.sha256((kind + commit.stdout).encode()).hexdigest(), 16) % (count - sample)


@pytest.mark.parametrize("kind, count, sample", [("fields", 2000, 16), ("theory", 200, 4), ("particles", 500, 16)])
def test_no_extreme_scene_is_wrong_in_silence(tmp_path, kind, count, sample):
    first = first_of(kind, count, sample)
    words = [kind, "--drover", DROVER, "--output", tmp_path, "--count", sample, "--first", first,
             "--seconds", 5]  # slow scenes are for whole atlases
    ended = subprocess.run([sys.executable, ATLAS, *map(str, words)], capture_output=True, text=True, check=False,
                           env={**os.environ, "PYTHONDONTWRITEBYTECODE": "1"})
    assert ended.returncode == 0, f"scenes from {first}:\n{ended.stdout}{ended.stderr}"
