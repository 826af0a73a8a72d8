"""tests/app/test_remedies.py: what a message recommends is allowed, and leads on."""
import json
import re

import numpy
import pytest
from support import MODELS, SMALL, drover, write_scene

import drover as module

TABLE = MODELS / "matched.calibration" / "table.h5"
START = MODELS / "bead-flock-start.h5"


NEGATIVE = {**SMALL, "current.kind": "density-order", "initial.kind": "uniform", "noise.rods": 0.0, "noise.order": 20.0,
            "diffusion.rods": 0.05, "time.dt": 0.01, "time.end": 2.0}


@pytest.mark.parametrize("points, names_grid", [(64, True), (16, False)])
def test_the_warning_of_negative_densities_recommends_no_noise_below_zero_and_no_grid_without_waves(
        points, names_grid, tmp_path):
    scene = write_scene(tmp_path, {"grid.nx": points, "grid.ny": points, "grid.lx": 16.0 * points / 16,
                                   "grid.ly": 16.0 * points / 16}, base=NEGATIVE)
    found = drover(tmp_path, "run", scene, "--quiet").stdout
    assert "rod_density is negative" in found and "below 0" not in found
    assert ("grid.nx = " in found) == names_grid and ("choose a larger mean" in found) != names_grid, found


def test_a_time_step_that_is_recommended_divides_the_durations(tmp_path):
    scene = write_scene(tmp_path, {"time.dt": 0.1, "time.end": 0.05})
    ended = drover(tmp_path, "check", scene, status=2)
    assert ended.stderr.rstrip().endswith("choose 0.1")  # 0 is no duration
    chosen = re.search(r"choose (\S+) or (\S+)", drover(tmp_path, "check", scene, "--set", "time.end=0.25",
                                                        status=2).stderr)
    for end in chosen.groups():
        drover(tmp_path, "check", scene, "--set", f"time.end={end}")


def test_the_longest_time_step_of_soft_contacts_that_is_recommended_is_allowed(tmp_path):
    for stiffness in (1.2345e6, 3.217e7, 7.77e8):  # other digits, which are rounded up or down
        words = ["check", MODELS / "bead-gas.toml", "--set", "contacts.model=spring-dashpot", "--set",
                 f"contacts.stiffness={stiffness}", "--set"]
        step = re.search(r"choose time.dt <= ([^,]+),", drover(tmp_path, *words, "time.dt=0.01", status=2).stderr)[1]
        ended = drover(tmp_path, *words, f"time.dt={step}", status=None)
        assert "of the shortest contact" not in ended.stderr


def test_a_start_that_is_shipped_is_described_and_no_run(tmp_path):
    text = drover(tmp_path, "info", START).stdout
    assert re.search(r"^frames +1, t = ", text, re.M) and "other runs start from these frames" in text
    assert json.loads(drover(tmp_path, "info", START, "--json").stdout)["results"] == {}
    with pytest.raises(module.Error, match="a start for other runs") as caught:
        module.open_run(START)
    assert "damaged" not in str(caught.value)


@pytest.mark.parametrize("opened", [module.open_run, module.open_theory])
def test_a_table_is_not_called_a_run_or_a_theory_or_damaged(opened):
    with pytest.raises(module.Error, match="is a table of coefficients") as caught:
        opened(TABLE)
    assert "open_" not in str(caught.value) and "damaged" not in str(caught.value)
    assert module.info(TABLE)["coefficients"]  # what the message recommends


def test_states_are_not_called_a_run_or_damaged(tmp_path):
    module.Scene.load(MODELS / "band.toml").states(wave="x", output=tmp_path / "states.h5")
    with pytest.raises(module.Error, match="drover states wrote") as caught:
        module.open_run(tmp_path / "states.h5")
    assert "xarray.open_dataset" in str(caught.value) and "open_theory" in str(caught.value)
    with module.open_theory(tmp_path / "states.h5") as theory:
        assert theory.kind == "states" and theory.groups["frames"].rod_density.dims == ("state", "y", "x")


@pytest.mark.parametrize("changes, words", [
    ({"boundary.x": "relaxation.rate = 1:0.5", "boundary.y": "current.speed = 1:2"}, "expected the smaller number"),
    ({"boundary.x": "relaxation.rate = 0.5:1", "boundary.y": "noise.order = 0.1:1"}, "does not affect phase bound"),
    ({"boundary.x": "relaxation.rate = 0.5:1", "boundary.y": "current.speed = 1:2", "boundary.lines": ["binodal"]},
     "expected the mean density of a field as one axis")])
def test_check_rejects_a_plane_that_boundary_rejects(changes, words, tmp_path):
    scene = write_scene(tmp_path, changes)
    errors = {drover(tmp_path, command, scene, status=2).stderr for command in ("check", "boundary")}
    assert len(errors) == 1 and words in errors.pop()
    with pytest.raises(module.Error, match=words):
        module.Scene.load(tmp_path / scene).check()


def test_check_passes_the_planes_of_the_models(tmp_path):
    with_plane = [path for path in sorted(MODELS.glob("*.toml")) if "\n[boundary]" in path.read_text(encoding="utf-8")]
    assert with_plane
    for path in with_plane:
        drover(tmp_path, "check", path)


def test_a_grid_that_cuts_growing_waves_is_told_with_one_that_keeps_them(tmp_path):
    (tmp_path / "own.toml").write_text("""
field = [{symbol = "phi"}]
grid = {nx = 8, ny = 8, lx = 40.0, ly = 40.0}
time = {dt = 0.1, end = 1.0}
initial = {kind = "random", amplitude = 0.1}
output = {frame_every = 1.0, sample_every = 0.1}
equations = {phi = "phi + lap phi - phi^3"}
""")
    # Waves grow for q < 1; three factors keep q < 2 pi/40 * 8/4.
    said = drover(tmp_path, "check", "own.toml").stderr
    found = re.search(r"waves down to a length of (\S+) mm grow .* no waves shorter than 20 mm: choose (grid.nx = \d+) "
                      r"and (grid.ny = \d+)", said)
    assert found and abs(float(found[1]) / (2 * numpy.pi) - 1) < 0.03, said  # the search has 32 places for a factor 2
    remedy = [word for keys in found.groups()[1:] for word in ("--set", keys.replace(" ", ""))]
    assert "waves" not in drover(tmp_path, "check", "own.toml", *remedy).stderr
    said = drover(tmp_path, "check", "own.toml", "--set", "equations.phi=phi - lap phi - phi^3").stderr
    assert "waves of any length, however short, grow" in said, said


@pytest.mark.parametrize("values", [0.001, 3, None, numpy.float64(0.5)])
def test_a_sweep_over_one_number_is_rejected_with_a_remedy(values):
    scene = module.Scene.from_dict({"grid": {"nx": 16, "ny": 16}, "time": {"dt": 0.1, "end": 1.0}})
    with pytest.raises(module.Error, match="expected a list of values"):
        module.sweep(scene, {"noise.order": values})
