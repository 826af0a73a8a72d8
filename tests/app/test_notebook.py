"""tests/app/test_notebook.py: every notebook runs from its first cell to its last, and is stored without results."""
import json
import os
import sys
from pathlib import Path

import nbformat
import pytest
from jupyter_client.kernelspec import KernelSpecManager
from nbconvert.preprocessors import ExecutePreprocessor

FOLDER = Path(__file__).resolve().parents[2] / "notebooks"
NOTEBOOKS = sorted(FOLDER.glob("*.ipynb"))


@pytest.fixture(name="this_python")
def a_kernel_that_is_this_python(tmp_path, monkeypatch):
    """The kernel python3 is the Python of this test, whichever comes first on PATH."""
    kernel = tmp_path / "kernels" / "python3"
    kernel.mkdir(parents=True)
    command = [sys.executable, "-m", "ipykernel_launcher", "-f", "{connection_file}"]
    (kernel / "kernel.json").write_text(json.dumps({"argv": command, "display_name": "Python 3", "language": "python"}))
    for variable in ("JUPYTER_CONFIG_DIR", "JUPYTER_RUNTIME_DIR", "JUPYTER_DATA_DIR", "IPYTHONDIR"):
        monkeypatch.setenv(variable, str(tmp_path / variable))
    monkeypatch.setenv("JUPYTER_PATH", str(tmp_path))
    monkeypatch.delenv("MPLBACKEND", raising=False)
    # Without this a kernel called python3 is always the one that ipykernel brings: here the same, elsewhere not.
    monkeypatch.setattr(KernelSpecManager, "ensure_native_kernel", False)
    assert KernelSpecManager().get_kernel_spec("python3").argv == command


def test_there_is_a_notebook():
    assert [path.name for path in NOTEBOOKS] == ["quick-start.ipynb"]


@pytest.mark.parametrize("path", NOTEBOOKS, ids=lambda path: path.stem)
def test_a_notebook_is_stored_without_results(path):
    notebook = nbformat.read(path, as_version=4)
    nbformat.validate(notebook)
    cells = [cell for cell in notebook.cells if cell.cell_type == "code"]
    assert cells
    assert all(cell.outputs == [] and cell.execution_count is None for cell in cells)
    assert notebook.metadata.kernelspec.name == "python3"


@pytest.mark.parametrize("path", NOTEBOOKS, ids=lambda path: path.stem)
def test_a_notebook_runs_to_its_end_and_its_physics_holds(path, this_python):
    assert os.environ.get("DROVER"), "expected the program's path in the environment variable DROVER"
    notebook = nbformat.read(path, as_version=4)
    executor = ExecutePreprocessor(timeout=300, kernel_name="python3")
    executor.preprocess(notebook, {"metadata": {"path": str(path.parent)}})  # raises with the cell and its error
    cells = [cell for cell in notebook.cells if cell.cell_type == "code"]
    assert all(cell.execution_count for cell in cells)
    complaints = [output for cell in cells for output in cell.outputs if output.get("name") == "stderr"]
    assert complaints == []
    pictures = [output for cell in cells for output in cell.outputs if "image/png" in output.get("data", {})]
    assert len(pictures) >= 4
