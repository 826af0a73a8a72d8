"""tests/app/test_same_bytes.py: one scene gives the same bytes again, on more threads, and after a stop and a restart.

Every dataset of every group is compared, byte by byte.
"""
import signal
from pathlib import Path

import h5py
import numpy as np
import pytest
from support import assert_same_bytes, contents, drover, end_group, frame_count, start, wait_until, write_scene

# Grids and cells: nx != ny either way, lx != ly either way, and one that is cut for several threads (64 x 64).
GRIDS = {
    "16 by 16": {},
    "24 by 16 in 30 by 8": {"grid.nx": 24, "grid.lx": 30.0, "grid.ly": 8.0},
    "12 by 40 in 16 by 16": {"grid.nx": 12, "grid.ny": 40},
    "4 by 6 in 1 by 5": {"grid.nx": 4, "grid.ny": 6, "grid.lx": 1.0, "grid.ly": 5.0},
    "64 by 64 in 20 by 50": {"grid.nx": 64, "grid.ny": 64, "grid.lx": 20.0, "grid.ly": 50.0},
}
RANDOM = {"initial.kind": "random", "initial.amplitude": 0.3}  # in place of the stationary state


def run(folder, output, *words, **changes):
    """Runs the small scene with some keys changed and returns its archive."""
    scene = write_scene(folder, changes, name=output + ".toml")
    drover(folder, "run", scene, "--quiet", *words)
    return folder / (output + ".h5")


@pytest.mark.parametrize("keys", [*GRIDS.values(), RANDOM], ids=[*GRIDS, "a random start"])
def test_400_steps_equal_200_steps_and_a_restart_to_400(keys, tmp_path):
    whole = run(tmp_path, "whole", **keys)
    parts = run(tmp_path, "parts", **{**keys, "time.end": 20.0})
    assert frame_count(whole) == 9 and frame_count(parts) == 5
    drover(tmp_path, "restart", parts, "--set", "time.end=40.0", "--quiet")
    assert_same_bytes(whole, parts)


def test_an_end_between_outputs_does_not_change_a_longer_run(tmp_path):
    whole = run(tmp_path, "whole")
    parts = run(tmp_path, "parts", **{"time.end": 18.3})  # neither a frame nor a sample is due at 18.3
    with h5py.File(parts) as file:
        assert file["time"][-1] == pytest.approx(18.3) and file["observables/time"][-1] == pytest.approx(18.3)
    drover(tmp_path, "restart", parts, "--set", "time.end=40.0", "--quiet")
    assert_same_bytes(whole, parts)


def test_a_restart_at_the_end_changes_nothing(tmp_path):
    whole, again = run(tmp_path, "whole"), run(tmp_path, "again")
    drover(tmp_path, "restart", again, "--quiet")
    assert_same_bytes(whole, again)


@pytest.mark.parametrize("grid", GRIDS)
def test_any_number_of_threads_gives_the_same_bytes(grid, tmp_path):
    one = run(tmp_path, "one", **GRIDS[grid], **{"run.threads": 1})
    two = run(tmp_path, "two", **GRIDS[grid], **{"run.threads": 2})
    five = run(tmp_path, "five", "--threads", "5", **GRIDS[grid])
    with h5py.File(two) as file:
        assert file.attrs["threads"] == 2
    assert_same_bytes(one, two)
    assert_same_bytes(one, five)


def test_a_restart_on_other_threads_gives_the_same_bytes(tmp_path):
    keys = GRIDS["64 by 64 in 20 by 50"]
    whole = run(tmp_path, "whole", **keys, **{"run.threads": 2})
    parts = run(tmp_path, "parts", **keys, **{"run.threads": 1, "time.end": 20.0})
    drover(tmp_path, "restart", parts, "--set", "time.end=40.0", "--threads", "3", "--quiet")
    assert_same_bytes(whole, parts)


@pytest.mark.parametrize("stepper", ["exponential-euler", "etdrk2", "etdrk4", "etdrk4-krogstad"])
def test_each_stepper_restarts_to_the_same_bytes(stepper, tmp_path):
    whole = run(tmp_path, "whole", **{"time.stepper": stepper})
    parts = run(tmp_path, "parts", **{"time.stepper": stepper, "time.end": 20.0})
    drover(tmp_path, "restart", parts, "--set", "time.end=40.0", "--quiet")
    assert_same_bytes(whole, parts)


# Rods and beads without noise: a wave of order drives beads apart, to half of their density and less, and they return.
BEADS = {
    "fields.bead_density": True, "fields.bead_velocity": "dynamic", "uniform.rod_density": 1.0,
    "inertia.bead_mass": 0.5,
    "drag.coefficient": 1.0, "viscosity.shear": 0.2, "driving.strength": 1.2, "stiffness.beads": 1.0,
    "stiffness.rods": 0.3, "current.speed": 0.5, "relaxation.rate": 0.15, "relaxation.rate_terms": ["0.05 rho"],
    "relaxation.saturation": 0.5, "elasticity.stiffness": 0.1, "weathercock.strength": 0.2, "pressure.rods": 0.3,
    "advection.strength": 0.3, "diffusion.rods": 0.1, "diffusion.beads": 0.05,
    "grid.nx": 32, "grid.ny": 16, "grid.lx": 16.0, "grid.ly": 8.0, "time.dt": 0.1, "time.end": 40.0,
    "initial.kind": "formula", "initial.polar_order_x": "sin(2 * pi * x / 16)", "initial.amplitude": 0.01,
    "output.frame_every": 5.0, "output.sample_every": 0.5, "run.seed": 11,
}
EVOLUTIONS = {
    "references that change": {},
    "an adaptive step": {"time.tolerance": 1e-5},
    "an adaptive step of fourth order": {"time.tolerance": 1e-6, "time.stepper": "etdrk4-krogstad"},
    "an adaptive step with noise": {"time.tolerance": 1e-2, "noise.order": 1e-4},
    "a multistep method": {"time.stepper": "etd-abm4"},
    "a slaved velocity": {"fields.bead_velocity": "slaved", "time.tolerance": 1e-4},
    "powers": {"output.powers": True},
}


def run_beads(folder, output, *words, **changes):
    scene = write_scene(folder, changes, name=output + ".toml", base=BEADS)
    drover(folder, "run", scene, "--quiet", *words)
    return folder / (output + ".h5")


@pytest.mark.parametrize("evolution", EVOLUTIONS)
def test_rods_and_beads_restart_to_the_same_bytes_with(evolution, tmp_path):
    keys = EVOLUTIONS[evolution]
    whole = run_beads(tmp_path, "whole", **keys)
    for end in (0.5, 20.0):  # in the start of a multistep method, and after it
        parts = run_beads(tmp_path, f"parts-{end:g}", **{**keys, "time.end": end})
        drover(tmp_path, "restart", parts, "--set", "time.end=40.0", "--quiet")
        assert_same_bytes(whole, parts)
    two = run_beads(tmp_path, "two", **keys, **{"run.threads": 2})
    assert_same_bytes(whole, two)
    with h5py.File(whole) as file:
        lowest, highest = (file[f"observables/{end}_bead_density"][()] for end in ("min", "max"))
    # The reference is at most 1.7 times the minimum density (slaved: at least 1/1.7 of the maximum): it changes and
    # changes back.
    if evolution == "a slaved velocity":
        assert highest[0] < 1.1 and highest.max() > 1.75
    else:
        assert lowest[0] > 0.9 and lowest.min() < 0.5 and lowest[-1] > 0.9


@pytest.mark.parametrize("stepper", ["cvode-bdf", "arkode-ark437l2sa"])
def test_a_method_of_sundials_restarts_to_the_same_bytes(stepper, tmp_path):
    keys = {"time.tolerance": 1e-4, "time.stepper": stepper}
    whole = run_beads(tmp_path, "whole", **keys)
    parts = run_beads(tmp_path, "parts", **{**keys, "time.end": 12.3})
    drover(tmp_path, "restart", parts, "--set", "time.end=40.0", "--threads", "2", "--quiet")
    assert_same_bytes(whole, parts)


def test_an_adaptive_stepper_changes_its_step(tmp_path):
    fixed, adaptive = run_beads(tmp_path, "fixed"), run_beads(tmp_path, "adaptive", **{"time.tolerance": 1e-5})
    with h5py.File(fixed) as a, h5py.File(adaptive) as b:
        difference = np.abs(a["polar_order_x"][-1] - b["polar_order_x"][-1]).max()
    assert 1e-9 < difference < 0.1


def rows_at(path, group, times):
    """The raw bytes of every array of a group at some of its times."""
    found = {}
    with h5py.File(path) as file:
        all_times = file[group + "/time"][()]
        rows = [int(np.flatnonzero(np.abs(all_times - time) < 1e-9)[0]) for time in times]
        for name, item in file[group or "/"].items():
            if isinstance(item, h5py.Dataset) and item.shape and (
                    name == "time" or any(scale.name.endswith("/time") for scale in item.dims[0].values())):
                found[name] = item[()][rows].tobytes()
    return found


def test_output_intervals_do_not_change_the_output_values(tmp_path):
    often = run(tmp_path, "often", **{"output.frame_every": 1.0, "output.sample_every": 0.1})
    seldom = run(tmp_path, "seldom", **{"output.frame_every": 8.0, "output.sample_every": 2.0})
    never = run(tmp_path, "never", **{"output.frame_every": 0.0, "output.sample_every": 0.0})
    for other, frames, samples in ((seldom, range(0, 41, 8), range(0, 41, 2)), (never, (0, 40), (0, 40))):
        for group, times in (("", frames), ("observables", samples)):
            a, b = rows_at(often, group, times), rows_at(other, group, times)
            assert a == b and len(a) >= 4, group


def test_the_same_seed_gives_the_same_bytes_and_another_seed_different_bytes(tmp_path):
    first, again = run(tmp_path, "first"), run(tmp_path, "again")
    assert_same_bytes(first, again)
    a, other = contents(first), contents(run(tmp_path, "other", **{"run.seed": 8}))
    # The number of rods is conserved, and times and axes are the scene's; all fluctuating values differ.
    for name in ("rod_density", "polar_order_x", "polar_order_y", "observables/polar_order",
                 "observables/rod_number_variance",
                 "observables/structure_factor_rods", "summary/polar_order_susceptibility"):
        assert a[name] != other[name], name
    for name in ("time", "x", "y", "observables/time", "observables/wavenumber"):
        assert a[name] == other[name], name


LONG = {"time.end": 2000.0, "output.frame_every": 25.0}  # a second or two: long enough for a signal half-way


def stopped(folder, name, sent):
    """Starts a long run, sends it a signal as soon as it has three frames, and returns its status and log."""
    process = start(folder, "run", write_scene(folder, LONG, name=name + ".toml"))
    archive = folder / (name + ".h5")

    def has_three_frames():
        try:
            return frame_count(archive) >= 3
        except (OSError, KeyError):  # not written yet, or in the middle of a write
            return False

    try:
        wait_until(has_three_frames, "three frames", process=process)
        process.send_signal(sent)
        out, log = process.communicate(timeout=10)  # a stop takes 10 s at most
    finally:
        end_group(process)
    return process.returncode, out, log


@pytest.fixture(scope="module")
def whole_run(tmp_path_factory):
    folder = tmp_path_factory.mktemp("whole")
    drover(folder, "run", write_scene(folder, LONG, name="whole.toml"), "--quiet")
    return folder / "whole.h5"


@pytest.mark.parametrize("sent", [signal.SIGTERM, signal.SIGINT, signal.SIGUSR1])
def test_a_run_stopped_by_a_signal_resumes_to_the_same_bytes(sent, tmp_path, whole_run):
    status, out, log = stopped(tmp_path, "parts", sent)
    assert status == 3 and out == "", log
    assert f"stopped by signal {int(sent)} " in log and "drover restart parts.h5" in log
    assert 3 <= frame_count(tmp_path / "parts.h5") < frame_count(whole_run)
    drover(tmp_path, "restart", "parts.h5", "--quiet")
    assert_same_bytes(whole_run, tmp_path / "parts.h5")


def test_a_sweep_stopped_by_a_signal_resumes_to_the_same_table(tmp_path):
    scene = write_scene(tmp_path, {"time.end": 500.0, "output.frame_every": 25.0})
    words = ["sweep", scene, "--vary", "relaxation.rate = 0.5, 1, 2", "--seeds", "2", "--workers", "2"]
    drover(tmp_path, *words, "--quiet", "-o", "whole")
    process = start(tmp_path, *words, "-o", "parts")
    try:
        wait_until(lambda: len(list(Path(tmp_path / "parts").glob("*.h5"))) >= 3, "a third run", process=process)
        process.send_signal(signal.SIGTERM)
        _, log = process.communicate(timeout=10)
    finally:
        end_group(process)
    assert process.returncode == 3 and "re-run the same command to resume" in log, log
    assert (tmp_path / "parts" / "table.csv").read_bytes() != (tmp_path / "whole" / "table.csv").read_bytes()
    drover(tmp_path, *words, "--quiet", "-o", "parts")
    assert (tmp_path / "parts" / "table.csv").read_bytes() == (tmp_path / "whole" / "table.csv").read_bytes()
    for archive in (tmp_path / "whole").glob("*.h5"):
        assert_same_bytes(archive, tmp_path / "parts" / archive.name)
