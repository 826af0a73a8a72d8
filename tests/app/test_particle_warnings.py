"""tests/app/test_particle_warnings.py: runs of particles warn of absorbing states and of energy gained in impacts."""
import pytest
from support import drover, drover_json, write_scene

BEADS = {
    "cell.lx": 8.0,
    "cell.ly": 8.0,
    "beads.area_fraction": 0.5,
    "time.end": 0.4,
    "output.frame_every": 0.2,
    "output.sample_every": 0.01,
    "run.seed": 1,
}
ELASTIC = {f"restitution.{pair}": 1.0 for pair in ("bead_bead", "bead_plate")}


def warnings_of(folder, changes):
    write_scene(folder, changes, base=BEADS, name="beads.toml")
    return drover_json(folder, "run", "beads.toml", "-q", "--overwrite", "-o", "beads.h5")["warnings"]


def test_a_shaken_bed_of_beads_has_no_warning(tmp_path):
    assert warnings_of(tmp_path, {}) == []


def test_beads_that_never_meet_are_reported_as_at_rest_in_the_plane_from_the_start(tmp_path):
    changes = {"beads.area_fraction": 0.0, "beads.count": 3, "cell.lx": 40.0, "cell.ly": 40.0}
    [warning] = [w for w in warnings_of(tmp_path, changes) if "in the plane" in w]
    assert warning.startswith("all 3 beads are at rest") and "from t = 0 s to the end" in warning
    assert "choose a larger plates.amplitude" in warning


def test_beads_on_plates_at_rest_are_reported_with_the_time_since_when(tmp_path):
    warnings = warnings_of(tmp_path, {"plates.amplitude": 0.0, "time.end": 3.0, "restitution.bead_plate": 0.0})
    [warning] = [w for w in warnings if "rest on a plate" in w]
    since = float(warning.split("from t = ")[1].split()[0])
    assert 0.0 < since < 3.0 and "bead_temperature_vertical is " in warning


def test_one_body_has_no_temperature_and_no_warning_of_it(tmp_path):
    assert warnings_of(tmp_path, {"beads.area_fraction": 0.0, "beads.count": 1}) == []


@pytest.mark.parametrize("changes, said", [
    ({"plates.amplitude": 4e-5}, "no body leaves the bottom plate"),  # metres
    ({"plates.frequency": 0.2}, "no body leaves the bottom plate"),  # per millisecond
    ({"plates.amplitude": 40.0, "plates.gap": 1200.0}, "exceeds the diameter of the smallest body"),  # micrometres
    ({}, None)])
def test_plates_in_other_units_are_reported_before_a_run(tmp_path, changes, said):
    write_scene(tmp_path, changes, base=BEADS, name="beads.toml")
    warned = drover(tmp_path, "check", "beads.toml").stderr
    assert said in warned if said else "plates." not in warned


@pytest.mark.parametrize("key, value", [("simultaneity_gap", 0.1), ("inelastic_threshold", 0.5), ("substep", 1e-4)])
def test_a_setting_of_contacts_outside_what_was_studied_is_reported(tmp_path, key, value):
    changes = {f"contacts.{key}": value, "rods.count": 1, "beads.area_fraction": 0.1, "time.end": 0.01,
               "output.frame_every": 0.01, "output.sample_every": 0.005}
    [warning] = [w for w in warnings_of(tmp_path, changes) if "time-step study" in w]
    assert warning.startswith(f"contacts.{key} = {value}") and "half the step" in warning


def test_gaps_between_the_spheres_of_a_rod_are_reported_with_the_length_that_closes_them(tmp_path):
    changes = {"rods.count": 1, "rods.diameters": [1.0, 0.8, 0.5], "rods.length": 4.5}
    # Centres are (4.5 - 0.75)/2 = 1.875 apart; the last two spheres reach 0.65, and touch at a spacing of that.
    for length, said in ((4.5, "1.23 mm apart"), (2.06, "0.005 mm apart"), (2.05, None)):
        write_scene(tmp_path, {**changes, "rods.length": length}, base=BEADS, name="rods.toml")
        warned = drover(tmp_path, "check", "rods.toml").stderr
        assert said in warned and "rods.length <= 2.05 mm" in warned if said else "apart" not in warned


def test_frames_between_which_rods_turn_are_reported(tmp_path):
    # Strong kicks turn rods about within frames of 0.2 s, and hardly within those of 0.002 s.
    changes = {"rods.count": 3, "beads.area_fraction": 0.0, "kick.strength": 0.1, "analysis.warm_up": 0.0}
    [warning] = [w for w in warnings_of(tmp_path, changes) if "rods turn between frames" in w]
    assert "of 0.2 s" in warning and "reduce output.frame_every" in warning
    often = {**changes, "output.frame_every": 0.002, "output.sample_every": 0.002, "time.end": 0.1}
    assert not [w for w in warnings_of(tmp_path, often) if "rods turn between frames" in w]


def test_steps_of_the_pairwise_law_that_change_the_gait_of_a_rod_are_reported(tmp_path):
    changes = {"contacts.law": "pairwise", "rods.bearing": "all", "rods.count": 1, "beads.area_fraction": 0.1,
               "time.dt": 1e-5, "time.end": 0.01, "output.frame_every": 0.01, "output.sample_every": 0.005}
    assert not [w for w in warnings_of(tmp_path, changes) if "pairwise" in w]
    [warning] = [w for w in warnings_of(tmp_path, {**changes, "contacts.rod_step": 5e-6}) if "pairwise" in w]
    assert warning.startswith("contacts.rod_step = 5e-06 s") and "converged" in warning


@pytest.mark.parametrize("law, count", [("kinematic", 1), ("energetic", 0)])
def test_a_law_that_creates_energy_in_impacts_is_reported(tmp_path, law, count):
    changes = {**ELASTIC, "rods.count": 2, "beads.area_fraction": 0.2, "restitution.rod_plate": 1.0,
               "friction.rod_plate": 1.0, "contacts.restitution": law, "contacts.max_overlap": 0.5, "time.end": 0.2}
    assert len([w for w in warnings_of(tmp_path, changes) if "impacts gained" in w]) == count


# Ten beads in free flight: gravity presses them to the lid, and in the last tenth of a second they do not meet.
FLIGHT = {"beads.area_fraction": 0.0, "beads.count": 10, "cell.lx": 10.0, "cell.ly": 10.0, "time.end": 0.2,
          "gravity.z": 9810.0}


def test_a_mean_that_is_constant_only_since_the_warm_up_has_no_error(tmp_path):
    write_scene(tmp_path, FLIGHT, base=BEADS, name="beads.toml")
    results = drover_json(tmp_path, "run", "beads.toml", "-q")["results"]
    order = results["bead_direction_order"]
    assert order["error"] is None and "constant in the last 0.11 s, but not before" in order["refusal"]


def test_check_warns_of_an_archive_that_is_larger_than_the_disk(tmp_path):
    write_scene(tmp_path, {}, base=BEADS, name="beads.toml")
    often = ["--set", "time.end=1e6", "--set", "output.frame_every=2e-5", "--set", "output.sample_every=2e-5"]
    assert "the archive may need" in drover(tmp_path, "check", "beads.toml", *often).stderr
    assert "the archive may need" not in drover(tmp_path, "check", "beads.toml").stderr
