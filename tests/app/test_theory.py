"""tests/app/test_theory.py: drover stability and drover boundary, and linear theory compared with runs of a flock."""
import math

import h5py
import numpy as np
import pytest
from rejection import rejected
from support import MODELS, SMALL, drover, drover_json, scene_text, settings, write_scene

FLOCK = MODELS / "flock.toml"


def state_named(report, name):
    return next(state for state in report["states"] if state["name"] == name)


# --- stability

def test_stability_of_a_flock_agrees_with_its_closed_forms(tmp_path):
    report = drover_json(tmp_path, "stability", FLOCK)
    # models/flock.toml: sigma = 0.02, rho = 0.8, m = 2.1, u = 3.6, Gamma = alpha = 33.6, E = 168, F = 420, a = b = 0.4,
    # lambda = 0.6, A = 1, B = 40.
    gain, u, sigma, rho, p0 = 0.6, 3.6, 0.02, 0.8, math.sqrt(0.5)
    chi, abar_a, bbar = 1.0 + 2.1 * rho * gain / 33.6, 1.0 + 0.6 * 168.0 / 33.6, 40.0 + 0.6 * 420.0 / 33.6
    found = report["coefficients"]
    for key, expected in {"inertia": chi, "relaxation": -0.2, "pressure_beads": abar_a, "pressure_rods": bbar,
                          "sound_stiffness": u * sigma * bbar + rho * abar_a}.items():
        assert found[key] == pytest.approx(expected, rel=1e-12)
    flock = state_named(report, "ordered")
    assert flock["stable"] and np.hypot(*flock["order"]) == pytest.approx(p0, rel=1e-12)
    across = [mode["speed"] for mode in flock["slow_modes"] if mode["angle"] == 90.0]
    assert sorted(across) == pytest.approx([-math.sqrt(found["sound_stiffness"] / chi), 0.0,
                                            math.sqrt(found["sound_stiffness"] / chi)],
                                           abs=1e-12)
    isotropic = state_named(report, "isotropic")
    assert [one["name"] for one in isotropic["instabilities"]] == ["order"]
    assert isotropic["instabilities"][0]["grows_to"] == pytest.approx(found["neutral_wavenumber"], rel=1e-9)
    text = drover(tmp_path, "stability", FLOCK).stdout
    for words in ("abar", "chi", "state: isotropic", "state: ordered, |p| = 0.707107", "stable against all waves",
                  "shot noise"):
        assert words in text


def test_stability_writes_its_maps_with_axes_and_provenance(tmp_path):
    drover(tmp_path, "stability", MODELS / "banding.toml", "--output", "maps.h5", *settings(["stability.angles=19"]))
    with h5py.File(tmp_path / "maps.h5") as file:
        assert file.attrs["scene_file"].decode() == "banding.toml" and b"drover stability" in file.attrs["title"]
        growth = file["ordered/growth_rate"]
        assert growth.shape == (19, 96, 3) and growth.attrs["units"] == b"s-1"
        q, angle = file["ordered/wavenumber"][:], file["ordered/angle"][:]
        # Along p0 the branches are those of [[0, -iq], [nu p0' - i B q, -nu - i w p0 q - K q^2]] and of p across.
        p0, nu = math.sqrt(0.1), 0.2
        for k in (0, 40, 95):
            m = np.array([[0, -1j * q[k]], [nu / (2 * p0) - 1j * q[k], -nu - 1j * p0 * q[k] - q[k]**2]])
            expected = np.append(np.linalg.eigvals(m), -q[k]**2 - 1j * p0 * q[k])
            found = growth[0, k, :] - 1j * file["ordered/frequency"][0, k, :]
            assert np.abs(found[:, None] - expected[None, :]).min(axis=1).max() < 1e-12
        assert angle[0] == 0.0 and angle[-1] == 90.0
    rejected(tmp_path, ["stability", MODELS / "banding.toml", "--output", "maps.h5"], ["maps.h5", "exists"])
    drover(tmp_path, "stability", MODELS / "banding.toml", "--output", "maps.h5", "--overwrite")


@pytest.mark.parametrize("keys, words", [
    (["drag.coefficient=0"], "drag.coefficient is 0: driven beads accelerate without limit"),
    (["relaxation.saturation=0"], "relaxation.saturation is 0: order grows without bound"),
    (["relaxation.rate=2"], "is not below 0"),
    (["relaxation.rate=0.6"], "is not below 0"),
])
def test_stability_at_extreme_parameters_reports_what_is_undefined(tmp_path, keys, words):
    ended = drover(tmp_path, "stability", FLOCK, *settings(keys))
    assert words in ended.stdout and ended.stderr == "" and "nan" not in ended.stdout
    assert state_named(drover_json(tmp_path, "stability", FLOCK, *settings(keys)), "isotropic")


def test_an_empty_range_of_wavenumbers_is_rejected(tmp_path):
    rejected(tmp_path, ["stability", FLOCK, *settings(["stability.min_wavenumber=9", "stability.max_wavenumber=2"])],
             ["stability.min_wavenumber", "expected stability.min_wavenumber below stability.max_wavenumber"])


# --- boundary

TABLE = """
[fields]
bead_density = true
bead_velocity = "dynamic"
[uniform]
bead_area = 0.5
rod_area = 4.0
rod_density = 0.03
[drag]
coefficient = 1
[relaxation]
saturation = 1
[table]
bead_density = [0.4, 1.0, 1.6]
rod_density = [0.01, 0.05]
relaxation_rate = [1.0, 1.0, 1.0, 1.0, 1.0, 1.0]
driving_strength = [0.4, 0.4, 1.0, 1.0, 1.6, 1.6]
driving_strength_error = [0.04, 0.04, 0.04, 0.04, 0.04, 0.04]
[weathercock]
strength = 1.0
"""


def test_the_onset_of_rods_with_drag_is_at_a_gain_of_two(tmp_path):
    # A single rod turns with lambda_s and rotational diffusion a: order begins at lambda_s alpha/(Gamma a) = 2, for
    # lambda at half of it.
    report = drover_json(tmp_path, "boundary", FLOCK, "--x", "weathercock.strength = 0.2:2",
                         "--y", "relaxation.rate = 0.1:1",
                       "--convention", "mean", "--convention", "single-rod", *settings(['boundary.lines=["onset"]']))
    assert [(one["limit"], one["convention"]) for one in report["traced"]] == [("onset", "mean"),
                                                                               ("onset", "single-rod")]
    for one, gain in zip(report["traced"], (1.0, 2.0)):
        (line,) = one["lines"]
        points = np.array([[point["x"], point["y"]] for point in line["points"]])
        assert np.abs(points[:, 0] - gain * points[:, 1]).max() < 1e-8 * 2.0


@pytest.mark.parametrize("strengths, rates, side", [("1:2", "0.1:0.5", "unstable"), ("0.1:0.2", "0.5:1", "stable")])
def test_a_plane_without_lines_is_stable_or_unstable(tmp_path, strengths, rates, side):
    # Order begins at a strength equal to the rate (the mean convention).
    (one,) = drover_json(tmp_path, "boundary", FLOCK, "--x", f"weathercock.strength = {strengths}",
                         "--y", f"relaxation.rate = {rates}", "--convention", "mean",
                         *settings(['boundary.lines=["onset"]']))["traced"]
    assert one["lines"] == []
    assert one[f"share_{side}"] == 1.0 and one["share_stable"] + one["share_unstable"] == 1.0


def test_boundary_of_a_table_in_area_fractions_has_its_error_band(tmp_path):
    (tmp_path / "table.toml").write_text(TABLE)
    report = drover_json(tmp_path, "boundary", "table.toml", "--x", "bead_area_fraction = 0.1:0.9",
                         "--y", "rod_area_fraction = 0.03:0.25", "--draws", "400", "--set", "boundary.map=24",
                         "--set", 'boundary.lines=["onset"]', "--output", "plane.h5")
    onset = next(one for one in report["traced"] if one["limit"] == "onset")
    (line,) = onset["lines"]
    assert not line["closed"]
    for point in line["points"]:
        assert point["x"] == pytest.approx(0.5, abs=1e-8)  # alpha = rho = 1 at an area fraction of 0.5
        assert 0.04 - 1e-9 <= point["y"] <= 0.2 + 1e-9  # the table's rods
        # The error of alpha is between that of one node and of two with equal weights: dx = 0.5 dalpha.  Half of a
        # distance of quantiles is known to 5 % from 400 draws, and straight lines between points 0.02 apart to 10 %.
        if point["x_low"] is not None:
            half = 0.5 * (point["x_high"] - point["x_low"])
            assert 0.8 * 0.5 * 0.04 / math.sqrt(2) <= half <= 1.2 * 0.5 * 0.04
    assert sum(point["x_low"] is not None for point in line["points"]) > 0.8 * len(line["points"])
    assert onset["share_with_line"] == 1.0 and onset["share_with_more"] == 0.0
    with h5py.File(tmp_path / "plane.h5") as file:
        assert file.attrs["boundary_x"] == b"bead_area_fraction"
        regime = file["map/regime"][:]
        x = file["map/map_x"][:]
        covered = regime[12]
        assert (covered[x < 0.2] == -1).all() and (covered[(x > 0.21) & (x < 0.49)] == 0).all()
        assert (covered[x > 0.81] == -1).all()


@pytest.mark.parametrize("arguments, names", [
    ([], ["boundary.x is not given", "--x"]),
    (["--x", "driving.strenth = 1:2", "--y", "relaxation.rate = 0:1"], ["did you mean driving.strength?"]),
    (["--x", "driving.strength = 2:1", "--y", "relaxation.rate = 0:1"], ["expected the smaller number first"]),
    (["--x", "driving.strength = 1", "--y", "relaxation.rate = 0:1"], ["expected first:last"]),
    (["--x", "driving.strength = 1:two", "--y", "relaxation.rate = 0:1"], ['"two"', "expected numbers"]),
    (["--x", "drag.coefficient = -1:2", "--y", "relaxation.rate = 0:1"], ["out of the range"]),
    (["--x", "driving.strength = 1:2", "--y", "driving.strength = 0:1"], ["expected two different numbers"]),
    (["--x", "rod_area_fraction = 0.1:0.2", "--y", "relaxation.rate = 0:1"], ["uniform.rod_area = 0", "expected > 0"]),
    (["--x", "driving.strength = 1:2", "--y", "relaxation.rate = 0:1",
      "--set", 'boundary.errors=["relaxation.rate = 0"]'],
     ["expected a standard error > 0"]),
    (["--x", "driving.strength = 1:2", "--y", "relaxation.rate = 0:1", "--set", 'boundary.lines=["onsets"]'],
     ['did you mean "onset"?']),
])
def test_an_invalid_plane_is_rejected(tmp_path, arguments, names):
    rejected(tmp_path, ["boundary", FLOCK, *arguments], names)


def test_an_axis_that_a_table_replaces_is_rejected(tmp_path):
    (tmp_path / "table.toml").write_text(TABLE)
    rejected(tmp_path, ["boundary", "table.toml", "--x", "driving.strength = 1:2", "--y", "drag.coefficient = 0.5:1"],
             ["driving.strength", "takes from its table"])


# --- compared with runs

def test_fluctuations_of_a_flock_in_the_linear_regime_are_those_of_its_theory(tmp_path):
    # The scene of giant fluctuations with a millionth of its noise: corrections are a thousandth of the linear theory.
    # dt = 0.1:
    # the rates of the flock, 1 /s, then have an error of (rate dt)^2/12 = 1e-3.
    quiet = ["noise.order=32e-6", "noise.rods=9.6e-6", "grid.nx=32", "grid.ny=32", "time.dt=0.1", "time.end=2400",
             "output.frame_every=0"]
    report = drover_json(tmp_path, "run", MODELS / "number-fluctuations.toml", "--quiet", *settings(quiet))
    assert report["linear_about"].startswith('the state "ordered", |p| = 11.31')
    deviations = []
    for what in ("rod", "bead"):
        for shape in ("", "_long_x", "_long_y"):
            for result in ("deviation", "exponent"):
                row = report["results"][f"{what}_number_{result}{shape}"]
                for value, linear in zip(row["values"], row["linear"]):
                    if linear is None:
                        continue  # the largest box
                    assert value["error"] is not None, (what, shape, result, value)
                    deviations.append((value["mean"] - linear) / value["error"])
    assert len(deviations) == 58
    # Neighbouring boxes are correlated; all 58 within 4 errors, from about 20 blocks, is consistent with chance.
    assert np.abs(deviations).max() < 4.0, deviations
    assert np.sqrt(np.mean(np.square(deviations))) < 1.6


def test_predictions_turn_with_the_order_of_a_run(tmp_path):
    def boxes(axis):
        write_scene(tmp_path, {"relaxation.rate": -0.5, "relaxation.saturation": 1.0, "noise.order": 1e-6,
                               "initial.kind": "formula", f"initial.polar_order_{axis}": "0.7", "time.end": 20.0},
                    base=SMALL)
        results = drover_json(tmp_path, "run", "flock.toml", "-q", "--overwrite")["results"]
        return [np.array(results[f"rod_number_deviation_long_{side}"]["linear"]) for side in "xy"]

    (along_x, across_x), (across_y, along_y) = boxes("x"), boxes("y")
    # The square cell is its own image.  The noise turns the order by less than a thousandth.
    assert along_y == pytest.approx(along_x, rel=1e-4) and across_y == pytest.approx(across_x, rel=1e-4)
    assert (np.abs(across_x / along_x - 1.0) > 0.01).all()


def test_a_run_of_an_unstable_flock_reports_why_there_is_no_prediction(tmp_path):
    # Beads attract rods: oblique waves grow.
    keys = ["pressure.beads=-40", "time.end=2", "output.frame_every=0", "output.sample_every=0.2", "grid.nx=24",
            "grid.ny=24", "analysis.warm_up=0"]
    report = drover_json(tmp_path, "run", FLOCK, "--quiet", *settings(keys))
    assert report["linear_about"] == "" and 'the state "ordered"' in report["no_prediction"]
    assert "drover stability" in report["no_prediction"]
    unstable = state_named(drover_json(tmp_path, "stability", FLOCK, *settings(keys)), "ordered")
    assert unstable["instabilities"][0]["name"] == "oblique"


def test_a_run_in_a_weak_field_is_compared_with_the_state_along_it(tmp_path):
    # Noise lowers |<p>| below the order of the state against the field; its direction identifies the state.
    keys = {"uniform.rod_density": 1.0, "relaxation.rate": -0.5, "relaxation.saturation": 1.0,
            "orienting_field.x": 0.01, "noise.order": 0.05, "elasticity.stiffness": 0.5,
            "grid.nx": 16, "grid.ny": 16, "grid.lx": 16.0, "grid.ly": 16.0,
            "time.dt": 0.1, "time.end": 60.0, "output.frame_every": 0.0, "output.sample_every": 0.5,
            "initial.kind": "formula", "initial.polar_order_x": "0.7", "analysis.warm_up": 10.0,
            "current.speed": 1.0, "pressure.rods": 0.5}
    (tmp_path / "held.toml").write_text(scene_text(keys))
    report = drover_json(tmp_path, "run", "held.toml", "--quiet")
    assert report["linear_about"].startswith('the state "along the field"')


def test_the_prediction_for_drifting_beads_without_order_is_about_the_drifting_state(tmp_path):
    keys = {"fields.rod_density": False, "fields.bead_density": True, "fields.bead_velocity": "slaved",
            "drag.coefficient": 1.0, "driving.strength": 0.3, "stiffness.beads": 1.0, "relaxation.rate": 1.0,
            "noise.order": 1e-4, "force.kind": "uniform", "force.x": 5.0,
            "grid.nx": 16, "grid.ny": 16, "grid.lx": 16.0, "grid.ly": 16.0, "time.dt": 0.05,
            "time.end": 400.0, "output.frame_every": 0.0, "output.sample_every": 0.5, "analysis.warm_up": 20.0}
    (tmp_path / "drift.toml").write_text(scene_text(keys))
    report = drover_json(tmp_path, "run", "drift.toml", "--quiet")
    assert report["linear_about"].startswith('the state "isotropic", |p| = 0 and |v| = 5')
    row = report["results"]["structure_factor_beads"]
    for value, linear in zip(row["values"], row["linear"]):
        assert abs(value["mean"] - linear) < 5.0 * value["error"]


def test_a_field_along_y_gives_the_rotated_result_of_one_along_x(tmp_path):
    for axis in "xy":
        drover(tmp_path, "stability", FLOCK, "--output", f"{axis}.h5",
               *settings([f"orienting_field.{axis}=0.05", "stability.wavenumbers=12", "stability.angles=7"]))
    with h5py.File(tmp_path / "x.h5") as along, h5py.File(tmp_path / "y.h5") as across:
        for name in ("structure_factor_order_along_p0", "structure_factor_order_across_p0", "structure_factor_rods"):
            a, b = along["along_the_field"][name][:], across["along_the_field"][name][:]
            assert np.allclose(a, b, rtol=1e-9, equal_nan=True), name
