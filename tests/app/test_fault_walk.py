"""tests/app/test_fault_walk.py: some of the faults of tests/faults/walk.py: every n there, a few here."""
import os
import sys
from pathlib import Path

import pytest
from support import slow_but

FAULTS = Path(__file__).resolve().parents[1] / "faults"
sys.path.insert(0, str(FAULTS))
from walk import walk  # noqa: E402

SHIM = os.environ.get("DROVER_SHIM")
FAST = (("run:pwrite", 5), ("run:pread", 4), ("run:rename", 2), ("run:open", 3), ("restart:pread", 3),
        ("sweep:pwrite", 2), ("calibrate:write", 1), ("check:read", 4), ("fit:pread", 2), ("stability:rename", 2))
SLOW = (("run:fsync", 2), ("calibrate:pread", 1), ("film:write", 1), ("film:read", 2),
        ("check:pread", 6), ("info:pread", 3), ("stability:pwrite", 4), ("states:pwrite", 3), ("boundary:fsync", 1))


@pytest.mark.skipif(not SHIM, reason="DROVER_SHIM is not set; ctest sets it")
@pytest.mark.parametrize("only, most", slow_but([*FAST, *SLOW], *FAST))
def test_a_command_survives_a_failing_call_and_the_next_one_ends_with_the_same_bytes(only, most):
    lines = []
    faults, failures = walk(SHIM, 0, only, lines.append, most)
    assert faults > 0 and failures == 0, "\n".join(lines)


# Allocations that libraries do not survive: the iterator of the standard library and the TOML parser end the process.
@pytest.mark.skipif(not SHIM, reason="DROVER_SHIM is not set; ctest sets it")
@pytest.mark.parametrize("within, only, most", slow_but([
    ("directory_iterator", "sweep:malloc", 16), ("libtomlplusplus", "restart:malloc", 27)]))
def test_a_library_that_finds_no_memory_ends_a_command_with_a_sentence(within, only, most, monkeypatch):
    monkeypatch.setenv("DROVER_FAULT_WITHIN", within)
    lines = []
    faults, failures = walk(SHIM, 0, only, lines.append, most)
    assert faults > 0 and failures == 0, "\n".join(lines)
