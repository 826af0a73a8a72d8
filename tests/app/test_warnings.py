"""tests/app/test_warnings.py: warnings of a run are the same in its output, in its log and in its archive."""
import json

import h5py
import pytest
from support import SMALL, drover, drover_json, write_scene

# Waves of the order that steepen: far too steep for 64 points.
STEEP = {
    "uniform.rod_density": 1.0,
    "current.speed": 0.5,
    "relaxation.rate": -0.5,
    "relaxation.saturation": 2.0,
    "elasticity.stiffness": 0.05,
    "advection.strength": 20.0,
    "pressure.rods": 0.25,
    "diffusion.rods": 0.01,
    "grid.nx": 64,
    "grid.ny": 4,
    "grid.lx": 32.0,
    "grid.ly": 4.0,
    "time.dt": 0.0025,
    "time.end": 5.0,
    "initial.kind": "formula",
    "initial.polar_order_x": "0.4 + 0.1*cos(2*pi*x/32) + 0.05*sin(4*pi*x/32)",
    "initial.polar_order_y": "0.2*sin(2*pi*x/32)",
    "output.frame_every": 5.0,
    "output.sample_every": 0.5,
}


def stored_warnings(archive):
    """The warnings in the summary of an archive."""
    with h5py.File(archive, "r") as file:
        return [text.decode() for text in file["summary"].attrs.get("warnings", [])]


def warnings_of(folder, base, changes=None):
    """The warnings of a short run."""
    write_scene(folder, changes, base=base)
    return drover_json(folder, "run", "flock.toml", "-q", "--overwrite", "-o", "flock.h5")["warnings"]


def printed(text):
    return [line.removeprefix("warning: ") for line in text.splitlines() if line.startswith("warning: ")]


def test_a_run_that_the_grid_does_not_resolve_warns_in_every_output(tmp_path):
    write_scene(tmp_path, base=STEEP)
    ended = drover(tmp_path, "run", "flock.toml", "-o", "flock.h5")
    warnings = printed(ended.stdout)
    assert len(warnings) == 1 and "does not resolve polar_order" in warnings[0] and "choose grid.nx = " in warnings[0]
    assert f"warning: {warnings[0]}\n" in ended.stderr
    assert printed(drover(tmp_path, "info", "flock.h5").stdout) == warnings
    assert drover_json(tmp_path, "info", "flock.h5")["warnings"] == warnings
    assert stored_warnings(tmp_path / "flock.h5") == warnings
    again = drover(tmp_path, "restart", "flock.h5", "--json", "-q", "--set", "time.end=6.0")
    assert [warning.split(":")[0] for warning in json.loads(again.stdout)["warnings"]] == [warnings[0].split(":")[0]]


def test_the_grid_that_a_warning_names_resolves_the_run(tmp_path):
    warning = warnings_of(tmp_path, STEEP)[0]
    points = int(warning.split("choose grid.nx = ")[1].split()[0])
    assert points > 64
    # With half of the step, which the warning names, too: the error of the steps of a steepening wave, 0.2 %, is told
    # as 1.2 %.
    assert warnings_of(tmp_path, STEEP, {"grid.nx": points, "time.dt": 0.5 * STEEP["time.dt"]}) == []
    assert stored_warnings(tmp_path / "flock.h5") == []


@pytest.mark.parametrize("changes", [
    {},                                                                    # linear: exact on any grid
    {"relaxation.saturation": 0.05, "initial.kind": "uniform"},            # noise that is white on the grid
    {"relaxation.saturation": 0.05, "noise.order": 0.0, "noise.rods": 0.0, "initial.kind": "mode",
     "initial.mode_x": 3, "initial.amplitude": 1e-6},                      # one small wave near the cut: linear theory
    {"relaxation.saturation": 0.05, "noise.order": 0.0, "noise.rods": 0.0, "initial.kind": "random",
     "initial.amplitude": 0.01},                                           # short waves of the start that decay
])
def test_a_field_with_short_waves_that_are_physical_does_not_warn(tmp_path, changes):
    assert warnings_of(tmp_path, SMALL, changes) == []


def test_a_sweep_lists_the_warnings_of_its_runs(tmp_path):
    write_scene(tmp_path, base=STEEP)
    ended = drover(tmp_path, "sweep", "flock.toml", "--vary", "elasticity.stiffness = 0.05, 5", "-q")
    # Short runs say more: that their warm-up may not have ended.
    assert [text.split(": ")[:2] for text in printed(ended.stdout) if "warm-up" not in text] == [
        ["point-0000-seed-1", "the grid does not resolve polar_order with grid.nx = 64 and grid.ny = 4"]]


def test_the_note_names_the_observable_that_needs_the_longest_run(tmp_path):
    # 40 samples are enough for observables that forget at once, and not for slow ones.
    scene = write_scene(tmp_path, {"time.end": 25.0, "relaxation.rate": 0.05})
    said = drover(tmp_path, "run", scene, "-o", "x.h5").stdout
    rows = [line.split() for line in said.split("\n\n")[0].splitlines() if line.count(" n/a ") == 1]
    taus = {row[0]: float(row[row.index("n/a") + 1]) for row in rows}
    assert len(set(taus.values())) > 1 and f"note: {max(taus, key=taus.get)}: no error estimate" in said


def test_a_cell_without_bodies_is_warned_of(tmp_path):
    warnings = warnings_of(tmp_path, {"cell.lx": 10.0, "cell.ly": 10.0, "time.end": 0.001,
                                      "output.sample_every": 0.001, "output.frame_every": 0.0})
    assert [warning.split(":")[0] for warning in warnings] == ["the cell has neither beads nor rods"]


def test_the_stationary_start_of_linear_equations_has_no_warm_up(tmp_path):
    linear = {"relaxation.rate": 0.1, "elasticity.stiffness": 1.0, "noise.order": 0.1, "grid.nx": 4, "grid.ny": 4,
              "grid.lx": 1.0, "grid.ly": 1.0, "uniform.rod_density": 1.0, "diffusion.rods": 1.0, "noise.rods": 0.1,
              "time.dt": 0.5, "time.end": 300.0, "initial.kind": "stationary", "output.frame_every": 0.0,
              "output.sample_every": 0.5}
    for seed in range(1, 5):  # of most, the search for a warm-up takes a fluctuation for one
        write_scene(tmp_path, {"run.seed": seed}, base=linear)
        drover(tmp_path, "run", "flock.toml", "-q", "--overwrite", "-o", "flock.h5")
        with h5py.File(tmp_path / "flock.h5", "r") as file:
            assert file["summary/warm_up"][()] == 0.0
