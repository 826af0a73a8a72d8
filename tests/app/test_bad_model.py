"""tests/app/test_bad_model.py: invalid models, each reported with its place and a remedy; runs that fail half-way."""
import re

import h5py
import numpy as np
import pytest
from rejection import rejected
from support import checkpoint_step, checkpoints, drover, scene_text

BEADS = '[fields]\nbead_density = true\nbead_velocity = "dynamic"\n'      # 3 lines
SLAVED = '[fields]\nbead_density = true\nbead_velocity = "slaved"\n'

# An invalid model: its text, and what the message must contain, the place first.
MODELS = {
    "pressure of beads without beads": ("[pressure]\nbeads = 1\n",
                                        ["bad.toml:2:1", "pressure.beads", "fields.bead_density", "set it to 0"]),
    "pressure of rods without rods": ("[fields]\nrod_density = false\n[pressure]\nrods = 1\n",
                                      ["bad.toml:4:1", "pressure.rods", "fields.rod_density", "include the field"]),
    "stiffness without beads": ('[fields]\nbead_velocity = "dynamic"\n[stiffness]\nbeads = 1\n',
                                      ["bad.toml:4:1", "stiffness.beads", "fields.bead_density"]),
    "stiffness without a velocity": ("[fields]\nbead_density = true\n[stiffness]\nbeads = 1\n",
                                           ["bad.toml:4:1", "stiffness.beads", "fields.bead_velocity"]),
    "rods pressing on no velocity": ("[stiffness]\nrods = 1\n",
                                     ["bad.toml:2:1", "stiffness.rods", "fields.bead_velocity"]),
    "diffusion of no beads": ("[diffusion]\nbeads = 1\n", ["bad.toml:2:1", "diffusion.beads", "fields.bead_density"]),
    "diffusion of no rods": ("[fields]\nrod_density = false\n[diffusion]\nrods = 1\n",
                             ["bad.toml:4:1", "diffusion.rods", "fields.rod_density"]),
    "noise on no beads": ("[noise]\nbeads = 1\n", ["bad.toml:2:1", "noise.beads", "fields.bead_density"]),
    "noise on no rods": ("[fields]\nrod_density = false\n[noise]\nrods = 1\n",
                         ["bad.toml:4:1", "noise.rods", "fields.rod_density"]),
    "a current of no rods": ("[fields]\nrod_density = false\n[current]\nspeed = 1\n",
                             ["bad.toml:4:1", "current.speed", "fields.rod_density"]),
    "drag on no velocity": ("[drag]\ncoefficient = 1\n", ["bad.toml:2:1", "drag.coefficient", "fields.bead_velocity"]),
    "driving of no velocity": ("[driving]\nstrength = 1\n",
                               ["bad.toml:2:1", "driving.strength", "fields.bead_velocity"]),
    "weathercocks without wind": ("[weathercock]\nstrength = 1\n",
                                  ["bad.toml:2:1", "weathercock.strength", "fields.bead_velocity"]),
    "shear viscosity of nothing": ("[viscosity]\nshear = 1\n",
                                   ["bad.toml:2:1", "viscosity.shear", "fields.bead_velocity"]),
    "bulk viscosity of nothing": ("[viscosity]\nbulk = 1\n",
                                  ["bad.toml:2:1", "viscosity.bulk", "fields.bead_velocity"]),
    "a force on no velocity": ('[force]\nkind = "uniform"\nx = 1\n',
                               ["bad.toml:2:1", "force.kind", "fields.bead_velocity"]),
    "advection of a slaved velocity": (SLAVED + "[drag]\ncoefficient = 1\n[inertia]\nadvection = true\n",
                                       ["bad.toml:7:1", "inertia.advection", "fields.bead_velocity"]),
    "a rate by beads without beads": ('[relaxation]\nrate_terms = ["-1 rho"]\n',
                                      ["bad.toml:2:1", "relaxation.rate", "bead density", "include the field"]),
    "a rate by rods without rods": ('[fields]\nrod_density = false\n[relaxation]\nrate_terms = ["-1 sigma"]\n',
                                    ["bad.toml:4:1", "relaxation.rate", "rod density", "include the field"]),
    "a monomial of another density": ('[relaxation]\nrate_terms = ["-1 tau"]\n',
                                      ["bad.toml:2:1", "-1 tau", "expected"]),
    "a monomial with a root": ('[relaxation]\nrate_terms = ["1 sigma^0.5"]\n',
                               ["bad.toml:2:1", "1 sigma^0.5", "expected"]),
    "an empty monomial": ('[relaxation]\nrate_terms = [""]\n',
                          ["bad.toml:2:1", "not a polynomial term", "expected a number"]),
    "a slaved velocity with viscosity and varying drag": (
        SLAVED + '[viscosity]\nshear = 1\n[drag]\ncoefficient = 1\ncoefficient_terms = ["1 rho"]\n',
        ["bad.toml:8:1", "slaved", "viscosity.shear", "dynamic"]),
    "a slaved velocity with viscosity and cubic driving": (
        SLAVED + '[viscosity]\nbulk = 1\n[drag]\ncoefficient = 1\n[driving]\ncubic = 1\n',
        ["bad.toml:9:1", "slaved", "driving.cubic", "dynamic"]),
    "noise of a slaved velocity": (SLAVED + "[drag]\ncoefficient = 1\n[noise]\nvelocity = 1\n",
                                   ["bad.toml:7:1", "noise.velocity", "fields.bead_velocity"]),
    "a slaved velocity with viscosity and varying driving": (
        SLAVED + '[viscosity]\nbulk = 1\n[drag]\ncoefficient = 1\n[driving]\nstrength_terms = ["1 rho"]\n',
        ["bad.toml:9:1", "slaved", "viscosity.bulk", "dynamic"]),
    "a slaved velocity without drag": (SLAVED + "[viscosity]\nshear = 1\n",
                                       ["bad.toml", "drag.coefficient is 0", "expected > 0"]),
    "a slaved velocity pushed by its drag": (
        SLAVED + '[uniform]\nbead_density = 2\n[drag]\ncoefficient = 1\ncoefficient_terms = ["-1 rho"]\n',
        ["bad.toml:7:1", "drag.coefficient is -1", "expected > 0"]),
    "beads that nothing moves": ("[fields]\nbead_density = true\n",
                                 ["bad.toml:2:1", "fields.bead_density", "changes the bead density", "give one"]),
    "a table and monomials": (
        '[relaxation]\nrate_terms = ["1 sigma"]\n[table]\nrod_density = [0.5, 2]\nrelaxation_rate = [1, 2]\n',
        ["bad.toml:2:1", "relaxation.rate_terms", "table.relaxation_rate", "expected one"]),
    "a table of too few values": (
        "[table]\nrod_density = [0.5, 1, 2]\nrelaxation_rate = [1, 2]\n",
        ["bad.toml:3:1", "table.relaxation_rate", "expected"]),
    "a table that does not ascend": (
        "[table]\nrod_density = [2, 0.5]\nrelaxation_rate = [1, 2]\n",
        ["bad.toml:3:1", "table.relaxation_rate", "ascend"]),
    "a table of beads without beads": (
        "[table]\nbead_density = [0.5, 2]\nrelaxation_rate = [1, 2]\n",
        ["bad.toml", "bead density", "include the field"]),
    "a table without the uniform state": (
        "[uniform]\nrod_density = 3\n[table]\nrod_density = [0.5, 2]\nrelaxation_rate = [1, 2]\n",
        ["bad.toml:2:1", "relaxation.rate", "outside its table", 'table.outside = "hold"']),
    "a tolerance without an estimate": ('[time]\ntolerance = 1e-3\nstepper = "exponential-euler"\n',
                                        ["bad.toml:2:1", "time.tolerance", "no embedded error estimate",
                                         "choose etdrk2"]),
    "a method of SUNDIALS without a tolerance": ('[time]\nstepper = "cvode-bdf"\n',
                                                 ["bad.toml:2:1", "time.stepper", "expected a tolerance"]),
    "a method of SUNDIALS with noise": ('[time]\ntolerance = 1e-6\nstepper = "arkode-ark548l2sa"\n[noise]\norder = 1\n',
                                        ["bad.toml:3:1", "time.stepper", "with noise", "choose etdrk2"]),
    "a multistep method with noise": ('[time]\nstepper = "etd-abm4"\n[noise]\norder = 1\n',
                                      ["bad.toml:2:1", "time.stepper", "with noise", "choose etdrk2"]),
    "a multistep method with a tolerance": ('[time]\ntolerance = 1e-3\nstepper = "etd-abm4"\n',
                                            ["bad.toml:2:1", "time.tolerance", "multistep", "choose etdrk2"]),
    "a formula for another start": ('[initial]\npolar_order_x = "1"\n',
                                    ["bad.toml:2:1", "initial.polar_order_x", 'expected "formula"']),
    "a formula for a field that is not there": (
        '[initial]\nkind = "formula"\nbead_density = "1"\n',
        ["bad.toml:3:1", "initial.bead_density", "expected one of rod_density"]),
    "a formula that is none": ('[initial]\nkind = "formula"\nrod_density = "1 + (x"\n',
                               ["bad.toml:3:22: ", "1 + (x", "its end at character 7", "expected"]),
    "a formula of unknown words": ('[initial]\nkind = "formula"\nrod_density = "cosine(x)"\n',
                                   ["bad.toml:3:16: ", "cosine", "expected"]),
}


@pytest.mark.parametrize("name", MODELS)
def test_a_model_is_rejected_with(name, tmp_path):
    text, says = MODELS[name]
    (tmp_path / "bad.toml").write_text(text)
    for command in ("run", "check", "explain"):
        rejected(tmp_path, [command, "bad.toml"], says)


@pytest.mark.parametrize("formula", ["1 / x", "1 + 0 * (1 / x)"])
def test_a_run_rejects_a_formula_that_is_infinite_in_a_cell(formula, tmp_path):
    (tmp_path / "bad.toml").write_text(f'[initial]\nkind = "formula"\nrod_density = "{formula}"\n')
    rejected(tmp_path, ["run", "bad.toml"],
             ["initial.rod_density", formula, "in cell (0, 0)", "expected a finite number"])


# --- runs that fail half-way

SMALL_GRID = {"grid.nx": 16, "grid.ny": 16, "grid.lx": 16.0, "grid.ly": 16.0, "output.frame_every": 0.5,
              "output.sample_every": 0.5}

# Order grows where rods are dense, -1 sigma, and nothing saturates it: p' = (sigma - 0.5) p with a current that gathers
# rods.
BLOWING_UP = {"uniform.rod_density": 1.0, "relaxation.rate": 0.5, "relaxation.rate_terms": ["-1 sigma"],
              "relaxation.saturation": 0.0, "current.speed": 1.0, "time.dt": 0.05, "time.end": 100.0,
              "initial.kind": "random", "initial.amplitude": 0.1, "output.checkpoint_minutes": 0.0, **SMALL_GRID}


def test_unsaturated_growth_stops_the_run_with_its_cause_and_a_checkpoint(tmp_path):
    (tmp_path / "flock.toml").write_text(scene_text(BLOWING_UP))
    ended = drover(tmp_path, "run", "flock.toml", "--quiet", status=1)
    assert len(ended.stderr.splitlines()) == 1 and ended.stderr.startswith("error: ") and ended.stdout == ""
    told = re.search(r"at or before step (\d+) \(t = (\S+) s\): (?:the root mean square of )?(\w+).*dt = 0.05;.*"
                     r"likely cause: (.*)", ended.stderr)
    assert told, ended.stderr
    step = int(told[1])
    assert told[3] in ("rod_density", "polar_order_x", "polar_order_y")
    for part in ("grows at 0.5 /s", "relaxation.saturation = 0", "checkpoint is still valid"):
        assert part in told[4]
    # It stops within ten steps of losing its meaning: the last good checkpoint is that near, and valid.
    good = max(checkpoint_step(file) for file in checkpoints(tmp_path / "flock.h5"))
    assert step - 10 <= good < step
    with h5py.File(tmp_path / "flock.h5") as file:
        for name in ("rod_density", "polar_order_x", "polar_order_y", "observables/polar_order_largest"):
            assert np.isfinite(file[name][()]).all(), name
    again = drover(tmp_path, "restart", "flock.h5", "--quiet", status=1)
    assert "became NaN or infinite" in again.stderr or "the run diverged" in again.stderr, again.stderr


# Beads with inertia, pushed out of a region until it is empty.
EMPTYING = {"fields.bead_density": True, "fields.bead_velocity": "dynamic", "fields.rod_density": False,
            "inertia.bead_mass": 1.0, "drag.coefficient": 1.0, "driving.strength": 10.0, "relaxation.rate": 0.0,
            "time.dt": 0.01, "time.end": 100.0, "initial.kind": "mode", "initial.field": "polar_order_x",
            "initial.amplitude": 1.0, "output.checkpoint_minutes": 0.0, **SMALL_GRID}


def test_a_vacuum_of_beads_with_inertia_stops_the_run_with_an_error(tmp_path):
    (tmp_path / "beads.toml").write_text(scene_text(EMPTYING))
    ended = drover(tmp_path, "run", "beads.toml", "--quiet", status=1)
    assert len(ended.stderr.splitlines()) == 1 and ended.stdout == ""
    for words in ("the bead density reached -", "vacuum", 'fields.bead_velocity = "slaved"', "smaller dt"):
        assert words in ended.stderr
    assert any(file.exists() for file in checkpoints(tmp_path / "beads.h5"))


def test_a_density_outside_its_table_stops_the_run_with_an_error(tmp_path):
    keys = {"relaxation.saturation": 1.0, "table.rod_density": [0.9, 1.0, 1.1],
            "table.relaxation_rate": [0.0, -0.5, -1.0], "current.speed": 1.0, "time.dt": 0.05, "time.end": 100.0,
            "initial.kind": "random", "initial.amplitude": 0.01, **SMALL_GRID}
    (tmp_path / "table.toml").write_text(scene_text(keys))
    ended = drover(tmp_path, "run", "table.toml", "--quiet", status=1)
    for words in ("outside the table of relaxation.rate", "0.9 to 1.1", 'table.outside = "hold"'):
        assert words in ended.stderr
    drover(tmp_path, "run", "table.toml", "--quiet", "--overwrite", "--set", 'table.outside="hold"',
           "--set", "time.end=5")


def test_a_step_that_no_division_makes_accurate_stops_the_run_with_an_error(tmp_path):
    # With saturation the same scene runs, with as many steps as it needs.
    scene = {**BLOWING_UP, "time.tolerance": 1e-3, "time.dt": 0.5}
    (tmp_path / "flock.toml").write_text(scene_text(scene))
    ended = drover(tmp_path, "run", "flock.toml", "--quiet", status=1)
    assert any(words in ended.stderr for words in ("time.tolerance", "became NaN", "the run diverged")), ended.stderr
    drover(tmp_path, "run", "flock.toml", "--quiet", "--overwrite", "--set", "relaxation.saturation=1",
           "--set", "time.end=20")
