"""tests/app/test_calibrated.py: uses of a table of coefficients: calibrated scenes and the flocking threshold."""
import json
import math
import re
import tomllib

import h5py
import numpy as np
import pytest
import xarray
from calibration import write_plausible
from rejection import make_archive, rejected
from support import MODELS, SMALL, drover, drover_json, scene_text, settings

SCENE = {
    "fields.bead_density": True,
    "fields.bead_velocity": "dynamic",
    "current.kind": "density-order",
    "calibrated.table": "table.h5",
    "calibrated.bead_area_fraction": 0.5,
    "calibrated.rod_area_fraction": 0.08,
    "grid.nx": 16,
    "grid.ny": 16,
    "grid.lx": 45.0,
    "grid.ly": 45.0,
    "time.dt": 0.05,
    "time.end": 1.0,
    "output.frame_every": 0.5,
    "output.sample_every": 0.1,
}


@pytest.fixture(name="folder")
def folder_with_a_table(tmp_path):
    write_plausible(tmp_path / "table.h5")
    (tmp_path / "flock.toml").write_text(scene_text(SCENE))
    return tmp_path


def resolved(folder, scene="flock.toml", *changes):
    return tomllib.loads(drover(folder, "check", "--resolved", scene, *settings(changes)).stdout)


def model_of(scene):
    """The sections that the table can fill in."""
    return {name: scene[name]
            for name in ("uniform", "current", "inertia", "drag", "viscosity", "driving", "stiffness", "relaxation",
                         "elasticity", "weathercock", "advection", "pressure", "noise")}


# --- calibrated scenes

def test_a_flow_that_bends_has_its_cubic_in_the_scene(folder):
    line = next(line for line in resolved(folder)["calibrated"]["filled"] if line.startswith("driving.cubic"))
    assert line == "driving.cubic: set, 0"  # the table has a straight line
    write_plausible(folder / "table.h5", also={"drag_cubic": lambda beads, rods: 1.2})
    straight, bent = 0.7 / 2.0, resolved(folder)
    assert bent["driving"]["cubic"] == pytest.approx(1.2 * straight, rel=1e-9)
    # Of particles without noise: the uniform flock of the fields has the order and the flow of the prediction.
    assert dict(line.split(": ", 1) for line in bent["calibrated"]["filled"])["driving.cubic"].startswith("measured")
    expected = dict(line.split(" = ", 1) for line in bent["calibrated"]["expected"])
    order = float(expected["order"].split()[0])
    assert float(expected["bead_velocity"].split()[0]) == pytest.approx((3.8 + 1.2 * order**2) * order, rel=1e-3)
    a, b, alpha, gamma = (bent[section][key] for section, key in (
        ("relaxation", "rate"), ("relaxation", "saturation"), ("driving", "strength"), ("drag", "coefficient")))
    flow = (alpha + bent["driving"]["cubic"] * order**2) / gamma
    assert a + b * order**2 == pytest.approx(0.1 * flow, rel=1e-3)


def test_a_calibrated_scene_has_the_numbers_of_the_table_with_origins_and_errors(folder):
    scene = resolved(folder)
    sigma, rho, drag, g = 0.08 / 4.0, 0.5 / 0.5, 1.0 + 2.0 + 0.8, 2.0 * 0.1 * 3.8 / 0.3
    gamma = 0.7 * rho / 2.0
    for key, value in {"uniform.rod_density": sigma, "uniform.bead_density": rho, "drag.coefficient": gamma,
                       "driving.strength": drag * gamma,
                       "viscosity.shear": 5.0 * 0.7 * rho, "stiffness.beads": 400.0, "relaxation.rate": 0.3,
                       "weathercock.strength": 0.1,
                       "elasticity.stiffness": 9.0 / (16.0 * 0.3), "pressure.rods": 1.5 / sigma,
                       "noise.order": 0.3 / sigma,
                       "current.speed": 3.0, "inertia.bead_mass": 0.7}.items():
        section, name = key.split(".")
        assert math.isclose(scene[section][name], value, rel_tol=1e-12), key
    filled = dict(line.split(": ", 1) for line in scene["calibrated"]["filled"])
    assert filled["relaxation.rate"] == "measured, 0.3 +- 0.006" and filled["pressure.beads"] == "set, 0"
    assert filled["noise.order"].startswith("closure, 15 +- 0.3") and filled["uniform.rod_density"].startswith("set")
    expected = dict(line.split(" = ", 1) for line in scene["calibrated"]["expected"])
    # lambda and a to 2 % each, and the drag of one node: g to 3.5 %; the spread of 200 redrawn tables is known to 9 %.
    found, _, error = expected["alignment"].split()[:3]
    assert float(found) == pytest.approx(g, rel=1e-3) and float(error) == pytest.approx(0.035 * g, rel=0.27)
    order = float(expected["order"].split()[0])
    assert math.isclose(float(expected["bead_velocity"].split()[0]), drag * order, rel_tol=1e-3)


def test_values_in_the_scene_override_the_table(folder):
    given = resolved(folder, "flock.toml", "relaxation.rate=0.7")
    # The mean field of the table does not apply to this scene.
    assert given["relaxation"]["rate"] == 0.7 and given["calibrated"]["expected"] == []
    assert resolved(folder, "flock.toml",
                    "weathercock.convention=single-rod")["weathercock"]["strength"] == pytest.approx(0.2, rel=1e-12)
    # Missing values are allowed where they are not needed.
    write_plausible(folder / "table.h5", holes=[("stiffness", 1)])
    assert resolved(folder, "flock.toml", "stiffness.beads=100.0")["stiffness"]["beads"] == 100.0


def test_a_value_of_the_varied_key_can_be_selected_including_zero(folder):
    write_plausible(folder / "table.h5", kicks=[0.0, 0.5])
    for kick in (0.0, 0.5):
        assert resolved(folder, "flock.toml",
                        f"calibrated.varied={kick}")["relaxation"]["rate"] == pytest.approx(0.3 + kick, rel=1e-12)
    rejected(folder, ["check", "flock.toml"],
            ["the table also varies kick.strength; expected calibrated.varied with one of 0, 0.5"])
    rejected(folder, ["check", "flock.toml", "--set", "calibrated.varied=0.1"],
            ["calibrated.varied = 0.1", "expected one of 0, 0.5"])


def test_both_normalisations_give_the_same_model(folder):
    orientation, density = resolved(folder), resolved(folder, "flock.toml", "current.kind=order")
    sigma = orientation["uniform"]["rod_density"]
    for section, key, power in (("driving", "strength", -1), ("weathercock", "strength", 1),
                                ("relaxation", "saturation", -2),
                                ("pressure", "rods", 1), ("noise", "order", 2), ("relaxation", "rate", 0)):
        assert math.isclose(density[section][key], orientation[section][key] * sigma**power, rel_tol=1e-12)
    reports = []
    for kind in ("order", "density-order"):
        text = drover(folder, "explain", "flock.toml", *settings([f"current.kind={kind}"])).stdout
        reports.append(re.search(r"growth rate +([0-9.e-]+) s-1", text)[1])
    assert reports[0] == reports[1]


def test_lambda_of_one_rod_gives_the_same_flock(folder):
    """lambda_s = 2 lambda, for constant and for local coefficients."""
    for more in ([], ["calibrated.coefficients=local"]):
        reports = [re.search(r"growth rate +([0-9.e-]+) s-1",
                             drover(folder, "explain", "flock.toml",
                                    *settings([f"weathercock.convention={one}", *more])).stdout)[1]
                   for one in ("mean", "single-rod")]
        assert reports[0] == reports[1]


def test_forms_with_fewer_fields_use_the_coefficients_that_apply(folder):
    alone = resolved(folder, "flock.toml", "fields.bead_density=false", "fields.bead_velocity=absent")
    assert alone["drag"]["coefficient"] == 0.0 and alone["relaxation"]["rate"] == pytest.approx(0.3)
    assert alone["calibrated"]["expected"] == []
    # Without rod density p is the mean orientation, for any current.kind.
    dilute = resolved(folder, "flock.toml", "fields.rod_density=false", "current.kind=order")
    assert dilute["weathercock"]["strength"] == pytest.approx(0.1) and dilute["current"]["speed"] == 0.0


def test_a_resolved_scene_needs_the_table_only_for_another_state(folder):
    (folder / "whole.toml").write_text(drover(folder, "check", "--resolved", "flock.toml").stdout)
    elsewhere = ["calibrated.bead_area_fraction=0.6", "calibrated.rod_area_fraction=0.1"]
    fresh = resolved(folder, "flock.toml", *elsewhere)
    assert model_of(resolved(folder, "whole.toml", *elsewhere)) == model_of(fresh) != model_of(resolved(folder))
    # Keys that change the meaning of p or lambda need the table; values set by hand are not attributed to it.
    assert model_of(resolved(folder, "whole.toml", "current.kind=order")) == model_of(resolved(folder, "flock.toml",
                                                                                               "current.kind=order"))
    assert resolved(folder, "whole.toml", "calibrated.coefficients=local")["table"]["relaxation_rate"] != []
    by_hand = resolved(folder, "whole.toml", "relaxation.rate=0.7")["calibrated"]["filled"]
    assert len(by_hand) == len(fresh["calibrated"]["filled"]) - 1 and not any(name.startswith("relaxation.rate:")
                                                                              for name in by_hand)
    (folder / "table.h5").unlink()
    assert resolved(folder, "whole.toml") == tomllib.loads((folder / "whole.toml").read_text())
    rejected(folder, ["check", "whole.toml", "--set", elsewhere[0]], ["whole.toml", "table.h5: does not exist"])


def test_a_run_stores_the_origins_and_a_sweep_uses_the_table_at_each_point(folder):
    drover(folder, "run", "flock.toml", "--quiet", *settings(["time.end=0.5"]))
    with h5py.File(folder / "flock.h5") as file:
        calibrated = tomllib.loads(file.attrs["scene"].decode())["calibrated"]
        assert "relaxation.rate: measured, 0.3 +- 0.006" in calibrated["filled"]
    drover(folder, "sweep", "flock.toml", "--quiet",
           *settings(["sweep.vary=[\"calibrated.rod_area_fraction = 0.05, 0.1\"]"]))
    densities = []
    for path in sorted((folder / "flock.sweep").glob("*.h5")):
        with h5py.File(path) as file:
            densities.append(tomllib.loads(file.attrs["scene"].decode())["uniform"]["rod_density"])
    assert sorted(densities) == pytest.approx([0.05 / 4.0, 0.1 / 4.0])


# --- flocking threshold

def test_the_boundary_of_a_linear_table_is_its_exact_crossing(folder):
    write_plausible(folder / "table.h5", relative_error=0.01)
    output = drover_json(folder, "boundary", "table.h5")
    assert [curve["rod_area_fraction"] for curve in output["curves"]] == [0.05, 0.08, 0.11]
    for point in [*output["curves"], *output["line"]]:
        assert point["mean"]["bead_area_fraction"] == pytest.approx(0.5 - 2.5 * point["rod_area_fraction"], abs=1e-9)
        assert 0.002 < point["mean"]["error"] < 0.03 and point["mean"]["share"] > 0.9
        assert point["mean"]["low"] < point["mean"]["bead_area_fraction"] < point["mean"]["high"]
        assert point["mean"]["crossings"] == 1
        assert point["single-rod"]["bead_area_fraction"] is None and point["single-rod"]["above_all"]
    text = drover(folder, "boundary", "table.h5", "-o", "onset.h5").stdout
    assert "flocks begin at Phi_b = 0.375 (0.3" in text and "are predicted at the smallest Phi_b of the table" in text
    with h5py.File(folder / "onset.h5") as file:
        assert np.allclose(file["line/mean"][()], 0.5 - 2.5 * file["line/line_rod_fraction"][()])
        assert file["curves/drag"].shape == (3, 31) and np.allclose(file["curves/threshold"][()], 3.0)
        assert file.attrs["title"].decode() == "drover onset of " + "table.h5 (its scene)"


def test_the_boundary_has_the_order_of_the_few_rods_of_a_cell(folder):
    cells = drover_json(folder, "boundary", "table.h5", "--cell", "40", "--point", "0.5,0.08")["cells"]
    (cell,) = cells
    # g = 2 lambda (alpha/Gamma)/a = 2 * 0.1 * 3.8/0.3; 0.08 * 40^2/4 rods.
    assert cell["rods"] == round(0.08 * 40.0**2 / 4.0) and math.isclose(cell["alignment"], 0.76 / 0.3, rel_tol=1e-9)
    assert cell["order_low"] < cell["order"] < cell["order_high"] and 0.3 < cell["order_line"] < cell["order"]
    assert len(drover_json(folder, "boundary", "table.h5", "--cell", "40")["cells"]) == 12
    rejected(folder, ["boundary", "table.h5", "--cell", "40", "--point", "0.5"], ["--point 0.5", "such as"])
    rejected(folder, ["boundary", "table.h5", "--point", "0.5,0.1"], ["--cell"])


def test_the_boundary_of_a_scene_with_local_coefficients_is_that_of_its_table(folder):
    """The scene traces abar = 0 in the plane, the table a/lambda = alpha/Gamma along the beads."""
    report = drover_json(folder, "boundary", "flock.toml", "--x", "bead_area_fraction = 0.2:0.7", "--y",
                         "rod_area_fraction = 0.05:0.11",
                         *settings(["calibrated.coefficients=local", "boundary.lines=[\"onset\"]", "boundary.map=0"]))
    assert report["draws"] == 100
    (line,) = report["traced"][0]["lines"]
    # alpha and Gamma are interpolated apart.  Splines through the nodes of the table alone are off by 6e-3, through
    # nodes at quarters of their distances by (1/4)^4 of that, and by more, up to (1/4)^2, beside the ends.
    for point in line["points"]:
        assert point["x"] == pytest.approx(0.5 - 2.5 * point["y"], abs=1e-4)
        for axis in "xy":
            low, high = point[f"{axis}_low"], point[f"{axis}_high"]
            assert low is None or low < point[axis]
            assert high is None or point[axis] < high


def test_the_error_band_of_the_shipped_table_is_that_of_brute_force_draws(tmp_path):
    """At the nodes of the table, where nothing is interpolated: the share of draws with a - c sigma < lambda
    alpha/Gamma, c being the weighted mean over area fractions of rods of (a S + D - 2 lambda alpha/Gamma)/(2 sigma)
    from the alignment S + D/a of many rods; see the manual."""
    with xarray.open_dataset(MODELS / "matched.calibration" / "table.h5") as opened:
        table = opened.load()
    generator, draws = np.random.default_rng(5), 20000
    beads, rods = table.bead_area_fraction.values, table.rod_area_fraction.values

    def drawn(name):
        values, errors = table[name].values, table[f"{name}_error"].values
        return values + errors * generator.standard_normal((draws, *values.shape))

    sigma = rods / table.rod_area.values[0]
    a, turning, flow = (drawn(name) for name in ("relaxation_rate", "weathercock", "drag"))
    steady, drift = table.alignment_steady.values, table.alignment_drift.values

    def contact(a, turning, flow):
        return (a[..., None] * steady + drift - 2.0 * turning[..., None] * flow) / (2.0 * sigma)

    measured = [table[name].values for name in ("relaxation_rate", "weathercock", "drag")]
    # The errors of S and D are correlated: that of S + reference D is measured, reference = 10 s.
    own, slope, reference = (table[f"alignment_{name}_error"].values for name in ("steady", "drift", "reference"))
    covariance = (reference**2 - own**2 - (10.0 * slope)**2) / 10.0
    rate = measured[0][:, None]
    error = np.hypot(rate * np.sqrt(own**2 + slope**2 / rate**2 + covariance / rate),
                     2.0 * measured[1][:, None] * table.drag_error.values) / (2.0 * sigma)
    weight = error**-2
    mean = (weight * contact(*measured)).sum(1) / weight.sum(1)
    squares = (weight * (contact(*measured) - mean[:, None])**2).sum(1) / (len(rods) - 1)
    # The part of its error that the flow makes is drawn with the flow.
    by_flow = weight / weight.sum(1)[:, None] * measured[1][:, None] / sigma * table.drag_error.values
    alone = np.sqrt(np.maximum(np.maximum(squares, 1.0) / weight.sum(1) - (by_flow**2).sum(1), 0.0))
    assert mean == pytest.approx(table.contact_alignment.values, rel=1e-6)
    c = (weight * contact(a, turning, flow)).sum(2) / weight.sum(1) + alone * generator.standard_normal(a.shape)
    unstable = a[..., None] - c[..., None] * sigma < turning[..., None] * flow
    scene = {**SCENE, "calibrated.table": str(MODELS / "matched.calibration" / "table.h5"),
             "calibrated.coefficients": "local", "calibrated.outside": "hold", "boundary.lines": ["onset"],
             "boundary.map": 0, "boundary.cells": 20,
             "boundary.chord": 0.01, "boundary.x": "bead_area_fraction = 0.2:0.7",
             "boundary.y": "rod_area_fraction = 0.05:0.11"}
    (tmp_path / "local.toml").write_text(scene_text(scene))
    drover(tmp_path, "boundary", "local.toml", "--draws", "400", "-o", "plane.h5")
    with h5py.File(tmp_path / "plane.h5") as file:
        share = file["band/share"][0]
        x, y = file["band/band_x"][()], file["band/band_y"][()]
    columns, rows = (np.abs(axis[:, None] - nodes).argmin(0) for axis, nodes in ((x, beads), (y, rods)))
    # Shares of 400 draws and of 20000: 3.5 deviations at 18 points, and half a draw.
    expected = unstable.mean(0)
    allowed = 3.5 * np.sqrt(expected * (1.0 - expected) * (1.0 / 400 + 1.0 / draws)) + 0.00125
    assert (np.abs(share[np.ix_(rows, columns)].T - expected) < allowed).all()


def test_a_resolved_scene_without_its_table_has_a_boundary_but_no_errors(folder):
    (folder / "resolved.toml").write_text(drover(folder, "check", "--resolved", "flock.toml").stdout)
    (folder / "table.h5").rename(folder / "moved.h5")
    plane = ["resolved.toml", "--x", "weathercock.strength = 0.05:0.2", "--y", "relaxation.rate = 0.2:0.4",
             *settings(["boundary.map=0", "boundary.lines=[\"onset\"]"])]
    rejected(folder, ["boundary", *plane], ["no file table.h5", "put it there", "boundary.draws = 0"])
    assert drover_json(folder, "boundary", *plane, "--draws", "0")["draws"] == 0


# --- errors

def test_invalid_calibrated_scenes_are_rejected(folder):
    def check_rejected(says, *changes):
        rejected(folder, ["check", "flock.toml", *settings(changes)], says)

    check_rejected(["missing.h5: does not exist", "expected"], "calibrated.table=missing.h5")
    check_rejected(["bead area fraction of 0.8: the table covers 0.2 to 0.7", "measure there"],
             "calibrated.bead_area_fraction=0.8")
    check_rejected(["rod area fraction of 0.2", "the table covers 0.05 to 0.11"], "calibrated.rod_area_fraction=0.2")
    check_rejected(["calibrated.rod_area_fraction is not given"], "calibrated.rod_area_fraction=0.0")
    check_rejected(["calibrated.varied = 0.02", "varies no key"], "calibrated.varied=0.02")
    check_rejected(["calibrated.outside", "refuse"], "calibrated.outside=extrapolate")
    assert resolved(folder, "flock.toml", "calibrated.bead_area_fraction=0.8",
                    "calibrated.outside=hold")["relaxation"]["rate"] == pytest.approx(0.3)
    write_plausible(folder / "table.h5", holes=[("drag", 4)])
    check_rejected(["no value of drag", "drag at bead area fraction 0.3, rod area fraction 0.08"])
    rejected(folder, ["boundary", "table.h5"], ["no value of drag", "drag at bead area fraction 0.3"])
    write_plausible(folder / "table.h5")
    with h5py.File(folder / "table.h5", "r+") as file:
        file["calibration/viscosity_kinematic"][...] *= -1.0
    check_rejected(["viscosity.shear = -3.5 +- 0.07 from the table",
                    "expected >= 0: measure more, or set it in the scene"])
    make_archive(folder, "run.h5")
    check_rejected(["run.h5", "not a table of coefficients"], "calibrated.table=run.h5")
    rejected(folder, ["boundary", "run.h5"], ["not a table of coefficients"])
    (folder / "text.h5").write_text("not a table")
    check_rejected(["text.h5"], "calibrated.table=text.h5")


def test_options_of_the_other_kind_are_rejected(folder):
    rejected(folder, ["boundary", "table.h5", "--x", "relaxation.rate = 0:1"], ["apply to scenes"])
    rejected(folder, ["boundary", "table.h5", "--varied", "0.02"], ["varies no key"])
    rejected(folder, ["boundary", "flock.toml", "--varied", "0.02"], ["applies to a table"])
    plane = ["--x", "bead_area_fraction = 0.2:0.7", "--y", "rod_area_fraction = 0.05:0.11"]
    rejected(folder, ["boundary", "flock.toml", *plane, "--convention", "single-rod"],
            ["from a table", "choose by weathercock.convention"])
    (folder / "onset.h5").write_bytes(b"")
    rejected(folder, ["boundary", "table.h5", "-o", "onset.h5"], ["onset.h5"])


def test_a_table_with_negative_errors_is_rejected(folder):
    with h5py.File(folder / "table.h5", "r+") as file:
        file["calibration/drag_error"][1, 1] = -0.1
    rejected(folder, ["check", "flock.toml"],
            ["drag at bead area fraction 0.3, rod area fraction 0.08 has the standard error -0.1"])


def test_particle_scenes_have_no_section_calibrated(folder):
    (folder / "rods.toml").write_text(scene_text({"cell.lx": 10.0, "calibrated.table": "table.h5"}))
    rejected(folder, ["check", "rods.toml"], ["[calibrated]", "belongs to a scene of fields"])


def test_a_scene_without_a_table_is_unchanged(folder):
    (folder / "small.toml").write_text(scene_text(SMALL))
    scene = resolved(folder, "small.toml")
    assert scene["calibrated"]["table"] == "" and scene["calibrated"]["filled"] == []
    assert scene["relaxation"]["rate"] == 0.5
    assert json.dumps(scene["calibrated"]["expected"]) == "[]"
