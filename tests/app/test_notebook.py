"""tests/app/test_notebook.py: every notebook runs from its first cell to its last, and is stored without results."""
import json
import re
import sys
from pathlib import Path

import nbformat
import pytest
from jupyter_client.kernelspec import KernelSpecManager
from nbconvert.preprocessors import ExecutePreprocessor
from support import slow_but

FOLDER = Path(__file__).resolve().parents[2] / "notebooks"
NOTEBOOKS = sorted(FOLDER.glob("*.ipynb"))

# The pictures of each notebook, and what must hold at its end.  Readers do not see these lines.
CHECKS = {
    "quick-start": (6, """
ratio = deviation / np.sqrt(number)
assert ratio.max() > 1.5 and ratio[1] < 1  # giant in large boxes, below independent rods in small ones
assert np.all(abs(ratio - linear / np.sqrt(number)) < 5 * error / np.sqrt(number) + 0.08 * ratio)
assert float(flock.frames.time[-1]) == 3300.0
orders = sweep.data.polar_order.values
assert abs(orders[0] - 0.708) < 0.001 and np.all(np.diff(orders) < 0)
assert changed.observables.polar_order.values[-1] > 0.5 > changed.observables.polar_order.values[0]
assert (folder / "flock.mp4").stat().st_size > 10_000 and list(folder.glob("flock*.vtk"))
assert variations["512 squared"].check() == []
"""),
    "your-own": (7, """
assert abs(settled.frame.polar_order_x.mean() - 0.8) < 0.02  # from 0.3, where 10 s are three relaxation times
assert "by differences" in measured.check()[0]
times, turned = np.transpose(angles)
assert np.allclose(turned, 0.3 * times, atol=1e-3)  # second order in the step of 0.05 s
series = run.observables.enstrophy
assert len(series) == 25 and run.time == 12.0 and float(series[-1]) == enstrophy(run.frame)
assert abs(series[0] / series[20] - 1) > 0.02
assert 0 < correlation[0] and abs(correlation[16] / correlation[0]) < 1
"""),
    "paper": (11, """
verdict = {(figure, says): [one.verdict for one in found] for figure, says, _, *found in rows}
assert verdict["2k-n", "order at .60 of beads, none at .20"] == 2 * [paper.IN_PART]
assert verdict["7b", "α/Γ grows, a/λ falls, they cross"][0] == paper.AGREES
assert verdict["7b", "flocks begin where they cross"] == 2 * [paper.IN_PART]
assert min(printed.plane[0.6, 0.11]) > 0.8 and max(printed.plane[0.2, 0.11]) < 0.35
begins, plane = printed.onset.groups["curves"]["mean"], printed.onset.groups["field"].mean_deviation
for rods, error in ((0.05, 0.03), (0.11, 0.06)):  # by the scatter of three seeds between points .1 apart
    assert abs(paper.half_order(printed, rods) - float(begins.sel(rod_fraction=rods, method="nearest"))) < error
for (beads, rods), orders in printed.plane.items():  # each point is on its side of the line, or in its error band
    excess = float(plane.interp(bead_fraction=beads, rod_fraction=rods))  # NaN outside the table
    assert not ((np.mean(orders) > 0.5 and excess < -1) or (np.mean(orders) < 0.5 and excess > 1))
missed = [figure for figure, _, _, _, found in rows if found.verdict == paper.MISSES]
assert missed == ["2a", "3a-d", "3e-f", "S: flow", "Methods"]  # of the matched rods
(_, free, free_error), (_, held, held_error) = matched.strays["free"], matched.strays["held"]
assert free > 5 * free_error and abs(held) < 3 * held_error
spread = {beads: paper.spread_of(matched, beads)[1] for beads in (0.2, 0.4, 0.6)}
assert spread[0.2][-1] > 1.5 and spread[0.4][-1] > 1.2 and abs(spread[0.6] - 1).max() < 0.1
about = [series["rod_velocity_azimuthal"][series["time"] > 30].mean() for _, series in matched.flowers.values()]
assert min(sum(value > 1 for value in about), sum(value < -1 for value in about)) >= 4
assert 0.5 < matched.order("matched-dense") < 0.9
"""),
    "theory-and-stability": (4, """
assert abs(crossing / q_c - 1) < 0.005  # the theory has discrete wavenumbers
assert np.allclose(measured, predicted, rtol=0.02)  # and is interpolated between them
"""),
    "phase-boundaries": (4, """
assert np.allclose(onset.y, onset.x * 0.6 / 33.6, rtol=1e-6)
assert run.observables.polar_order[-1] > 3 * run.observables.polar_order[0]  # above the line
middle, low = float(crossings.bead_area_fraction[0]), float(crossings.low[0])
assert abs(middle - 0.55) < 2 * (middle - low)  # of the experiment
assert {0, 2, 3} <= set(np.unique(plane.main.limit))
"""),
    "number-fluctuations": (3, """
for name, run in runs.items():
    found = run.summary
    ratio, linear = (found[f"rod_number_deviation{end}"] / np.sqrt(found.rod_number) for end in ("", "_linear"))
    assert np.all(abs(ratio / linear - 1) < 0.15)  # the noise reduces the order by 5 per cent
    assert (ratio.max() > 1.5) if name == "flock" else (0.85 < ratio.max() < 1.05)
assert np.allclose(finite_cell, [0.618, 0.802, 0.870, 0.904, 0.924, 0.937], atol=0.001)
"""),
    "particles": (4, """
assert 1 < speed < 6  # 3.6(2.5) mm/s over many rods
assert float(abs(balance).max()) < 1e-9 * float(bed.observables.energy_kinetic.max())
assert order > 0.75 and beads > 0.4
assert 1.5 < along.mean() / np.hypot(*axis) < 3.5
"""),
    "calibration": (4, """
assert abs(correlation[0] - 1) < 1e-3 and 0 < correlation[-1] < correlation[10]
kept_again = drover.info(table.file)["coefficients"]
assert kept_again["drag"]["points"] == kept["drag"]["points"]
assert 0.5 < float(run.observables.polar_order[-40:].mean()) < 0.95
"""),
    "campaigns": (1, """
small, large = (data.rod_number_exponent.sel(box_side=side) for side in (3.0, 6.0))
assert abs(float(small[0]) - 0.5) < 0.1 and float(small.max()) > 0.7 and (small > large - 0.02).all()
assert (np.diff(data.polar_order) < 0).all() and data.polar_order_of_runs.shape == (7, 16)
assert sweep.data.polar_order.values.tobytes() == data.polar_order.values.tobytes()
"""),
    "speed-for-accuracy": (3, """
for result, allowed in ((found, 0.02), (found_smooth, 0.001)):
    assert result.recommended is not None and result.reasons and result.front
assert abs(float(run.observables.polar_order[20:].mean()) / 0.6985 - 1) < 0.02  # of a run of 1e5 s
assert found_gas.levels
"""),
}


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


def test_the_head_of_the_paper_counts_its_verdicts():
    sys.path.insert(0, str(FOLDER.parent / "tests" / "bench" / "particles"))
    import verdicts
    head = " ".join(nbformat.read(FOLDER / "paper.ipynb", as_version=4).cells[0].source.split())
    rows = verdicts.verdicts()
    for kind in (0, 1):
        found = verdicts.counts(rows, kind)
        assert sum(found.values()) == len(rows) == 19 and f"Of {len(rows)} claims" in head
        assert (f"{found[verdicts.AGREES]} agree, {found[verdicts.IN_PART]} agree in part, "
                f"{found[verdicts.MISSES]} miss") in head


@pytest.mark.parametrize("path", NOTEBOOKS, ids=lambda path: path.stem)
def test_a_notebook_is_stored_without_results(path):
    notebook = nbformat.read(path, as_version=4)
    nbformat.validate(notebook)
    cells = [cell for cell in notebook.cells if cell.cell_type == "code"]
    assert cells
    assert all(cell.outputs == [] and cell.execution_count is None for cell in cells)
    assert notebook.metadata.kernelspec.name == "python3"


def test_every_notebook_is_checked_and_listed_for_readers():
    assert sorted(CHECKS) == [path.stem for path in NOTEBOOKS]
    listed = re.findall(r"^\d+\. \[[^]]+\]\(([a-z-]+)\.ipynb\)", (FOLDER / "README.md").read_text(), re.M)
    assert sorted(listed) == sorted(CHECKS)


@pytest.mark.parametrize("path", slow_but(NOTEBOOKS, FOLDER / "quick-start.ipynb", FOLDER / "your-own.ipynb"),
                         ids=lambda path: path.stem)
def test_a_notebook_runs_to_its_end_and_its_physics_holds(path, this_python):
    notebook = nbformat.read(path, as_version=4)
    cells = [cell for cell in notebook.cells if cell.cell_type == "code"]
    pictures, physics = CHECKS[path.stem]
    notebook.cells.append(nbformat.v4.new_code_cell(physics))
    executor = ExecutePreprocessor(timeout=300, kernel_name="python3")
    executor.preprocess(notebook, {"metadata": {"path": str(path.parent)}})  # raises with the cell and its error
    assert all(cell.execution_count for cell in cells)
    outputs = [output for cell in cells for output in cell.outputs]
    # A notebook shows the progress of a run that takes longer than two seconds.
    complaints = [output.text for output in outputs if output.get("name") == "stderr"
                  and output.text.strip() and "\r[" not in output.text]
    assert complaints == []
    assert sum("image/png" in output.get("data", {}) for output in outputs) == pictures
