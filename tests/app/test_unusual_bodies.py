"""tests/app/test_unusual_bodies.py: particles that are edited, placed in another gap, or never meet."""
import h5py
import numpy as np
from calibration import write_tiny
from rejection import rejected
from support import MODELS, drover as program, write_scene

import drover

LONE = {"cell.lx": 20.0, "cell.ly": 20.0, "time.dt": 2e-5, "time.end": 0.1, "output.sample_every": 0.01,
        "output.frame_every": 0.01}


def test_the_kicks_of_rods_go_on_after_an_edit():
    run = drover.Scene.from_dict({**LONE, "cell.lx": 60.0, "cell.ly": 60.0, "rods.count": 32,
                                  "kick.strength": 0.02}).start()
    run.advance(0.1)
    names = ("rod_position", "rod_velocity", "rod_axis", "rod_angular_velocity")
    kept = {name: run.frame[name].copy() for name in names}
    spins = []
    for _ in range(2):  # from the same bodies, a whole number of periods of the plates apart
        with run.edit() as bodies:
            for name, values in kept.items():
                bodies[name][...] = values
        run.advance(0.005)
        spins.append(run.frame.rod_angular_velocity[:, 2].copy())
        run.advance(0.095)
    assert np.corrcoef(spins)[0, 1] < 0.9  # other kicks; with the same ones 1


def test_a_start_with_beads_beyond_the_lid_is_rejected(tmp_path):
    write_scene(tmp_path, {**LONE, "beads.count": 3, "rods.count": 0, "plates.lid": False, "plates.gap": 4.0,
                           "time.end": 0.1}, "open.toml", base={})
    program(tmp_path, "run", "open.toml", "-o", "open.h5", "-q")
    with h5py.File(tmp_path / "open.h5") as archive:
        highest = archive["bodies/beads/position/value"][:, :, 2].max(axis=1)
    frame = int(highest.argmax())
    assert highest[frame] > 1.3
    rejected(tmp_path, ["run", "open.toml", "-o", "closed.h5", "--set", "plates.lid=true", "--set", "plates.gap=1.2",
                        "--set", "packing.kind=file", "--set", "packing.file=open.h5", "--set",
                        f"packing.frame={frame}"], ["packing.file", "the lid", "overlap by"])


def test_rods_that_never_meet_have_no_scattering(tmp_path):
    write_tiny(tmp_path, {"calibrate.assays": ["scattering"], "calibrate.bead_area_fractions": [0.2],
                          "calibrate.scattering.time": 0.06, "calibrate.scattering.warm_up": 0.0})
    ended = program(tmp_path, "calibrate", "tiny.toml", status=1)
    assert "missing: contact_scattering" in ended.stdout and "contact_scattering = 0" not in ended.stderr


def test_forces_of_a_scene_have_no_effect_on_a_calibration_and_it_says_so(tmp_path):
    write_tiny(tmp_path, {"calibrate.assays": ["damping"], "calibrate.bead_area_fractions": [0.2],
                          "beads.area_fraction": 0.2, "forces.hold_beads": True, "forces.bead_velocity_x": 5.0})
    assert program(tmp_path, "check", "tiny.toml").stdout == "tiny.toml: valid\n"
    assert "[forces] and [packing] have no effect on drover calibrate" in program(
        tmp_path, "calibrate", "tiny.toml", "--workers", "2").stderr


def test_a_point_beyond_the_table_is_marked():
    cells = drover.onset(MODELS / "matched.calibration" / "table.h5", cell=45.0,
                         points=[(0.95, 0.11), (0.6, 0.11)]).groups["cells"]
    assert list(cells.held.values) == [1.0, 0.0]
