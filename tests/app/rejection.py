"""tests/app/rejection.py: the form of an error message, and damaged archives."""
import os
import re
import subprocess

import pytest
from support import DROVER, SMALL, drover, environment, tree, write_scene

# An error message contains a remedy.
REMEDY = re.compile(r"expected|did you mean|choose|give |include |use |set |make |name |check |start |see |remove |"
                    r"omit |smaller|--help")
SHORT = {**SMALL, "time.end": 1.0, "output.frame_every": 0.5, "output.sample_every": 0.5}
not_as_root = pytest.mark.skipif(os.geteuid() == 0, reason="root may read and write everything")


def rejected(folder, words, says, max_lines=1, stdin=subprocess.DEVNULL):
    """Runs a command that must be rejected as bad input, with a one-line message that contains all of `says`."""
    before = tree(folder)
    ended = subprocess.run([DROVER, *map(str, words)], cwd=folder, capture_output=True, text=True, errors="replace",
                           stdin=stdin, timeout=60, env=environment(), check=False)
    report = f"drover {' '.join(map(str, words))}: {ended.returncode}\n{ended.stderr}{ended.stdout}"
    lines = ended.stderr.splitlines()
    assert ended.returncode == 2, report
    assert ended.stdout == "", report
    assert 1 <= len(lines) <= max_lines, report
    assert lines[0].startswith("error: "), report
    assert REMEDY.search(ended.stderr), report
    assert len(ended.stderr) < 1000, report
    assert [part for part in says if part not in ended.stderr] == [], report
    assert tree(folder) == before, report


def make_archive(folder, name, changes=None):
    """Runs a short scene beside the folder and copies its archive, without checkpoints, into it."""
    beside = folder.parent / (folder.name + "-made")
    beside.mkdir(exist_ok=True)
    write_scene(beside, changes, base=SHORT)
    drover(beside, "run", "flock.toml", "--quiet", "--overwrite", "-o", name)
    (folder / name).write_bytes((beside / name).read_bytes())
    return beside


def cut_in_two(file):
    """Leaves the first half of a file."""
    content = file.read_bytes()
    file.write_bytes(content[:len(content) // 2])
