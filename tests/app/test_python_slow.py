"""tests/app/test_python_slow.py: long tests of the Python module."""
from test_python_module import memory_after


def test_a_thousand_runs_started_and_dropped_leak_nothing(tmp_path):
    assert memory_after(1000, tmp_path) < 2e6
