"""tests/app/test_python_slow.py: long tests of the Python module."""
import subprocess
import sys

from support import MODELS
from test_python_module import memory_after


def test_a_thousand_runs_started_and_dropped_leak_nothing(tmp_path):
    assert memory_after(1000, tmp_path) < 2e6


def test_pip_installs_the_module_from_the_sources(tmp_path):
    words = [sys.executable, "-m", "pip", "install", "--quiet", "--no-build-isolation", "--no-deps", "--target",
             str(tmp_path / "site"), str(MODELS.parent)]
    subprocess.run(words, check=True, timeout=500)
    code = "import drover; print(drover.__file__, drover.Scene.from_dict({}).kind)"
    path, kind = subprocess.run([sys.executable, "-c", code], env={"PYTHONPATH": str(tmp_path / "site")}, check=True,
                                capture_output=True, text=True, cwd=tmp_path).stdout.split()
    assert path.startswith(str(tmp_path)) and kind == "fields"
