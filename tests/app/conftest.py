"""tests/app/conftest.py: the marker of slow tests, and scratch files in memory.

Drover waits for the disk at every commit, half of the time of short runs.  Scratch files are in memory where there is
room for them and TMPDIR names no other place; that files survive a crash of the machine is tested in tests/faults.
"""
import os
import shutil
import tempfile
from pathlib import Path

MEMORY = Path("/dev/shm")
ROOM = 2 << 30  # bytes; a run of all tests keeps some 200 MB

if "TMPDIR" not in os.environ and os.access(MEMORY, os.W_OK) and shutil.disk_usage(MEMORY).free > ROOM:
    os.environ["TMPDIR"] = tempfile.tempdir = str(MEMORY)


def pytest_configure(config):
    config.addinivalue_line("markers", "slow: run by `make test-slow`; see tests/CMakeLists.txt")
