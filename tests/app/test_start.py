"""tests/app/test_start.py: initial formulas that the grid cuts, or that jump at a periodic edge, and frames on other
points."""
import h5py
import numpy as np
import pytest
from rejection import rejected
from support import drover, drover_json, scene_text, write_scene

GRID = {"grid.nx": 32, "grid.ny": 32, "grid.lx": 32.0, "grid.ly": 32.0, "relaxation.rate": 1.0,
        "relaxation.saturation": 1.0, "time.end": 0.1, "initial.kind": "formula"}  # cubic: modes below 8 are kept


def check(folder, formula, **changes):
    """What `check` writes to standard error for an initial density."""
    (folder / "start.toml").write_text(scene_text({**GRID, "initial.rod_density": formula, **changes}))
    return drover(folder, "check", "start.toml").stderr


@pytest.mark.parametrize("formula", [
    "1 + 0.1*cos(2*pi*20*x/32)",  # between the cut and the points
    "1 + 0.1*cos(2*pi*33*x/32)",  # looks like mode 1 on the points
    "1 + 0.1*cos(2*pi*12*y/32)",
    "1 + exp(-((x - 16.5)^2 + (y - 16.5)^2)/0.1)",
])
def test_a_formula_of_which_the_grid_cuts_more_than_half_is_rejected(tmp_path, formula):
    (tmp_path / "start.toml").write_text(scene_text({**GRID, "initial.rod_density": formula}))
    for command in ("run", "check"):
        rejected(tmp_path, [command, "start.toml"], ["initial.rod_density", "the grid cuts", "choose grid.n"])


@pytest.mark.parametrize("formula", ["2 + 0.01*log(x)", "1 + 0.1/y", "sqrt(20 - x)"])
def test_a_formula_that_is_not_finite_in_a_cell_is_rejected_before_a_run(tmp_path, formula):
    (tmp_path / "start.toml").write_text(scene_text({**GRID, "initial.rod_density": formula}))
    for command in ("check", "explain", "run"):
        rejected(tmp_path, [command, "start.toml"], ["initial.rod_density", formula, "in cell (", "finite number"])


def test_formulas_with_another_kind_of_start_are_rejected_with_the_settings_that_clear_them(tmp_path):
    (tmp_path / "start.toml").write_text(scene_text({**GRID, "initial.rod_density": "1", "initial.polar_order_x": "1"}))
    words = ["check", "start.toml", "--set", "initial.kind=random"]
    clear = ["--set", 'initial.rod_density=""', "--set", 'initial.polar_order_x=""']
    rejected(tmp_path, words, ['initial.rod_density, initial.polar_order_x are given with initial.kind = "random"',
                               """--set 'initial.rod_density=""' --set 'initial.polar_order_x=""'"""])
    drover(tmp_path, *words, *clear)


def test_a_start_by_formulas_without_one_warns(tmp_path):
    assert 'initial.kind = "formula" without a formula: every field starts at its reference' in check(tmp_path, "")
    assert check(tmp_path, "1") == ""


def test_the_grid_that_a_rejection_names_is_accepted_without_a_warning(tmp_path):
    formula = "1 + 0.1*cos(2*pi*20*x/32)"
    (tmp_path / "start.toml").write_text(scene_text({**GRID, "initial.rod_density": formula}))
    message = drover(tmp_path, "check", "start.toml", status=2).stderr
    assert "choose grid.nx = 128 or" in message
    assert check(tmp_path, formula, **{"grid.nx": 128}) == ""


def test_a_formula_that_the_grid_cuts_a_little_warns(tmp_path):
    bump = "1 + exp(-((x - 16)^2 + (y - 16)^2)/3)"
    warning = check(tmp_path, bump)
    assert "initial.rod_density" in warning and "the grid cuts off 0.0" in warning
    assert "choose grid.nx = 64 and grid.ny = 64 or make it smoother" in warning
    assert check(tmp_path, bump, **{"grid.nx": 64, "grid.ny": 64}) == ""
    assert any("the grid cuts" in text for text in drover_json(tmp_path, "run", "start.toml", "-q",
               "--set", "grid.nx=32", "--set", "grid.ny=32")["warnings"])


def test_a_formula_that_jumps_at_a_periodic_edge_warns_with_place_and_size(tmp_path):
    warning = check(tmp_path, "1 + 0.5*tanh((x - 16)/4)")
    assert "jumps by 0.999 mm-2 at the periodic edge x = 0" in warning
    warning = check(tmp_path, "1 + 0.02*y")
    assert "jumps by 0.64 mm-2 at the periodic edge y = 0" in warning


@pytest.mark.parametrize("formula", ["2", "1 + 0.5*cos(2*pi*3*x/32 + 1)*sin(2*pi*y/32)",
                                     "1 + 0.5*exp(-((x - 12)^2 + (y - 12)^2)/16)"])
def test_a_formula_that_the_grid_keeps_does_not_warn(tmp_path, formula):
    assert check(tmp_path, formula) == ""


@pytest.mark.parametrize("named, written", [("1 + 0.25*cos(2*pi*x/lx)", "1 + 0.25*cos(2*pi*x/32)"),
                                            ("1 + 0.25*cos(2*pi*y/ly)*lx", "1 + 0.25*cos(2*pi*y/24)*32"),
                                            ("lx/ly", "32/24")])
def test_the_sides_of_the_cell_are_known_by_their_names(tmp_path, named, written):
    for name, formula in (("named", named), ("written", written)):
        (tmp_path / f"{name}.toml").write_text(scene_text({**GRID, "grid.ly": 24.0, "grid.ny": 24, "time.dt": 0.05,
                                                           "initial.rod_density": formula, "initial.amplitude": 0.01}))
        drover(tmp_path, "run", f"{name}.toml", "-q")
    starts = [frames(tmp_path / f"{name}.h5") for name in ("named", "written")]
    assert starts[0].tobytes() == starts[1].tobytes()


def test_a_formula_in_the_sides_of_the_cell_follows_them(tmp_path):
    formula = "1 + 0.1*cos(2*pi*x/lx)"
    assert check(tmp_path, formula) == "" == check(tmp_path, formula, **{"grid.lx": 40.0})
    assert "jumps" in check(tmp_path, "1 + 0.1*cos(2*pi*x/32)", **{"grid.lx": 40.0})


def frames(archive):
    with h5py.File(archive) as file:
        return file["rod_density"][:]


# Mode 1 along x, and an oblique one that 8 points do not have.
WAVES = "2 + 0.2 cos(2 pi x / 32) + 0.1 sin(2 pi (3 x + 2 y) / 32)"


def waves_on(nx, ny, oblique):
    x, y = np.meshgrid(32.0 * np.arange(nx) / nx, 32.0 * np.arange(ny) / ny)
    return 2.0 + 0.2 * np.cos(2 * np.pi * x / 32) + oblique * np.sin(2 * np.pi * (3 * x + 2 * y) / 32)


@pytest.mark.parametrize("nx, ny, oblique", [(48, 64, 0.1), (16, 128, 0.1), (8, 64, 0.0), (64, 1, 0.0)])
def test_a_frame_on_other_points_is_taken_by_its_modes(tmp_path, nx, ny, oblique):
    (tmp_path / "first.toml").write_text(scene_text({**GRID, "initial.rod_density": WAVES}))
    drover(tmp_path, "run", "first.toml", "--quiet")
    keys = {key: value for key, value in GRID.items() if key != "initial.kind"}
    (tmp_path / "second.toml").write_text(scene_text({
        **keys, "grid.nx": nx, "grid.ny": ny, "initial.kind": "file", "initial.file": "first.h5", "initial.frame": 0}))
    told = drover(tmp_path, "run", "second.toml").stderr
    with h5py.File(tmp_path / "second.h5") as archive:
        found = archive["rod_density"][0]
    assert np.abs(found - waves_on(nx, ny, oblique)).max() < 1e-13  # rounding of two transforms
    assert f"32 by 32 points; the fields are taken on {nx} by {ny}" in told
    lost = "20 % of the variance of rod_density is in waves that"  # 0.1^2/(0.1^2 + 0.2^2)
    assert (lost in told) == (oblique == 0.0), told


def test_a_stationary_start_of_an_own_model_needs_every_mode_to_decay(tmp_path):
    (tmp_path / "own.toml").write_text("""
field = [{symbol = "u", noise = 0.1}]
equations = {u = "a u + lap u"}
coefficients = {a = -0.1}
grid = {nx = 16, ny = 16, lx = 8.0, ly = 8.0}
time = {dt = 0.1, end = 1.0}
initial = {kind = "stationary"}
""")
    drover(tmp_path, "check", "own.toml")
    rejected(tmp_path, ["check", "own.toml", "--set", "coefficients.a=0.1"],
             ["there is no stationary state: a linear mode grows at the rate 0.1 at |q| = 0"])


def test_a_stationary_start_may_be_driven_by_the_noise_of_the_densities_alone(tmp_path):
    keys = {**{key: value for key, value in GRID.items() if key != "initial.kind"}, "initial.kind": "stationary",
            "noise.rods": 0.1, "diffusion.rods": 0.1}
    (tmp_path / "start.toml").write_text(scene_text(keys))
    drover(tmp_path, "run", "start.toml", "--quiet")
    with h5py.File(tmp_path / "start.h5") as file:
        # 2 D sigma_q = Delta: the variance of a mode is Delta/(2 D)/area, of all kept ones 15^2 - 1 of these.
        variance = file["rod_density"][0].var()
        assert variance == pytest.approx(0.5 / 1024 * 224, rel=4 * (2 / 224)**0.5)
        assert np.abs(file["polar_order_x"][0]).max() == 0.0


OWN = """
field = [{symbol = "u"}, {symbol = "w"}]
equations = {u = "-u + lap u", w = "u - w"}
grid = {nx = 16, ny = 16, lx = 8.0, ly = 8.0}
time = {dt = 0.1, end = 1.0}
initial = {kind = "formula", w = "cos(2 pi x / lx)", u = 2}
"""


def test_formulas_of_an_own_model_are_taken_back_by_empty_ones(tmp_path):
    (tmp_path / "own.toml").write_text(OWN)
    rejected(tmp_path, ["check", "own.toml", "--set", "initial.kind=random"],
             ['initial.u, initial.w are given with initial.kind = "random"; expected "formula"',
              """--set 'initial.u=""' --set 'initial.w=""'"""])
    drover(tmp_path, "check", "own.toml", "--set", "initial.kind=random", "--set", 'initial.u=""', "--set",
           'initial.w=""')


DEMIXING = """
model = {name = "model B"}
field = [{symbol = "phi", conserved = true}, {symbol = "u"}]
equations = {phi = "lap(phi^3 - phi - lap phi)", u = "phi - u"}
grid = {nx = 32, ny = 32, lx = 40.0, ly = 40.0}
time = {dt = 0.05, end = 1.0}
initial = {kind = "formula", phi = "0.8 + 0.3 cos(2 pi x/lx)", u = "5"}
"""


def test_stability_is_that_of_the_conserved_means_of_the_start(tmp_path):
    (tmp_path / "b.toml").write_text(DEMIXING)
    state = drover_json(tmp_path, "stability", "b.toml")["states"]
    assert [(one["phi"], one["u"]) for one in state] == [(pytest.approx(0.8, rel=1e-14), pytest.approx(0.8, rel=1e-14))]
    assert state[0]["instabilities"] == []  # 3 phi^2 - 1 > 0
    footer = "the conserved means of the start differ from the references (phi = 0.8 for 0)"
    assert footer in drover(tmp_path, "explain", "b.toml").stdout
    state = drover_json(tmp_path, "stability", "b.toml", "--set", "initial.phi=0.1*cos(2*pi*x/lx)")["states"]
    assert state[0]["phi"] == 0.0 and state[0]["instabilities"][0]["rate"] == pytest.approx(0.25, rel=1e-12)
    assert footer[:30] not in drover(tmp_path, "explain", "b.toml", "--set", "initial.phi=0.1*cos(2*pi*x/lx)").stdout


NOT_FINITE = """
model = {name = "beyond the references"}
field = [{symbol = "c", conserved = true}, {symbol = "u"}]
equations = {c = "lap c", u = "log(u - 50) - u + lap u"}
grid = {nx = 16, ny = 1, lx = 40.0, ly = 1.0}
time = {dt = 0.005, end = 0.1}
initial = {kind = "formula", c = "1", u = "60"}
"""


def test_explain_needs_no_finite_rates_about_the_references(tmp_path):
    (tmp_path / "far.toml").write_text(NOT_FINITE)
    footer = "the conserved means of the start differ from the references (c = 1 for 0)"
    assert footer in drover(tmp_path, "explain", "far.toml").stdout


def test_a_file_that_a_run_starts_from_is_checked_with_the_scene(tmp_path):
    start = {**GRID, "initial.kind": "file", "initial.file": "wave.h5"}
    (tmp_path / "start.toml").write_text(scene_text(start))
    rejected(tmp_path, ["check", "start.toml"], ["wave.h5"])
    (tmp_path / "wave.toml").write_text(scene_text({**GRID, "initial.rod_density": "1", "grid.lx": 16.0}))
    drover(tmp_path, "run", "wave.toml", "--quiet")
    rejected(tmp_path, ["check", "start.toml"], ["initial.file", "has another cell"])
    drover(tmp_path, "run", "wave.toml", "--quiet", "--overwrite", "--set", "grid.lx=32.0")
    drover(tmp_path, "check", "start.toml")


def test_a_start_from_a_run_with_the_same_noise_is_reported(tmp_path):
    write_scene(tmp_path, {"noise.order": 0.1, "time.end": 1.0})
    drover(tmp_path, "run", "flock.toml", "-o", "first.h5", "--quiet")
    start = ["run", "flock.toml", "-o", "next.h5", "--overwrite", "--quiet", "--set", "initial.kind=file", "--set",
             "initial.file=first.h5", "--set"]
    assert "choose another run.seed" in drover(tmp_path, *start, "run.seed=7").stderr
    assert "run.seed" not in drover(tmp_path, *start, "run.seed=8").stderr
    assert "run.seed" not in drover(tmp_path, *start, "noise.order=0", "--set", "noise.rods=0").stderr


def test_a_run_that_has_not_reached_its_end_is_told_from_one_that_has(tmp_path):
    scene = write_scene(tmp_path, {**GRID, "time.end": 1e6, "initial.kind": "random", "output.frame_every": 1.0})
    drover(tmp_path, "run", scene, "-o", "cut.h5", "--max-time", "0:01", status=3)
    words = ["run", scene, "--set", "time.end=1", "--set", "initial.kind=file", "--set", "initial.file=cut.h5"]
    assert "has not reached its end" in drover(tmp_path, *words, "-o", "whole.h5").stderr  # its last frame
    assert "reached its end" not in drover(tmp_path, *words, "-o", "first.h5", "--set", "initial.frame=0").stderr
    for name, is_finished in (("cut.h5", False), ("whole.h5", True)):
        assert drover_json(tmp_path, "info", name)["is_finished"] == is_finished
        assert ("not finished" in drover(tmp_path, "info", name).stdout) != is_finished
