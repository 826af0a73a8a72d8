"""tests/app/test_calibrate_slow.py: a calibration killed twenty times at random times (see calibration.py), and the
complete workflow from particles to fields."""
import math
import random
import time
import tomllib

import h5py
from calibration import kill_repeatedly, write_tiny
from support import MODELS, drover, drover_json, scene_text


def test_a_calibration_killed_twenty_times_ends_with_the_same_bytes(tmp_path):
    # More trials than in the fast tests, so that twenty kills hit it while running.
    scene = write_tiny(tmp_path, {"calibrate.relative_error": 0.1, "calibrate.max_trials": 48})
    began = time.monotonic()
    drover(tmp_path, "calibrate", scene, "-o", "whole", "--quiet")
    took = time.monotonic() - began
    assert kill_repeatedly(tmp_path, scene, tmp_path / "whole", 20, random.Random(11), took / 8.0) >= 15


def test_the_workflow_from_particles_to_a_boundary_and_to_fields(tmp_path):
    drover(tmp_path, "calibrate", MODELS / "calibrate-small.toml", "--quiet", "-o", "small")
    coefficients = drover_json(tmp_path, "info", "small/table.h5")["coefficients"]
    # Errors are large on purpose.  Rods must drag beads, beads must turn rods, and all numbers for fields must exist.
    for name in ("drag", "relaxation_rate", "propulsion", "viscosity_kinematic", "stiffness", "damping_rate"):
        for point in coefficients[name]["points"]:
            assert point["origin"] in ("measured", "short") and point["value"] > 0.0, (name, point)
    output = drover_json(tmp_path, "boundary", "small/table.h5", "-o", "onset.h5")
    assert len(output["curves"]) == 2 and all(math.isfinite(point["threshold"]) for curve in output["curves"]
                                            for point in curve["points"])
    (tmp_path / "flock.toml").write_text(scene_text({
        "fields.bead_density": True, "fields.bead_velocity": "dynamic", "current.kind": "density-order",
                                                     "calibrated.table": "small/table.h5",
        "calibrated.bead_area_fraction": 0.65, "calibrated.rod_area_fraction": 0.2, "grid.nx": 32, "grid.ny": 32,
                                                     "grid.lx": 13.5, "grid.ly": 13.5,
        "time.dt": 0.02, "time.end": 20.0}))
    drover(tmp_path, "run", "flock.toml", "--quiet")
    with h5py.File(tmp_path / "flock.h5") as file:
        scene = tomllib.loads(file.attrs["scene"].decode())
        order = file["observables/polar_order"][()]
    values = {name: coefficients[name]["points"][-1]["value"] for name in ("friction", "relaxation_rate")}
    assert math.isclose(scene["relaxation"]["rate"], values["relaxation_rate"], rel_tol=1e-9)
    assert math.isclose(scene["drag"]["coefficient"], values["friction"], rel_tol=1e-9)
    assert len(scene["calibrated"]["filled"]) > 15 and len(order) > 10
