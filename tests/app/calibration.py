"""tests/app/calibration.py: a calibration of two by two points that takes seconds, and helpers for its folder."""
import json
import re
import subprocess
import tomllib
from pathlib import Path

import h5py
import numpy as np
from support import drover, end_group, group_is_alive, start, wait_until, write_scene

# Cells of a hundred bodies and trials of a tenth of a second: the results have no physical meaning.
TINY = {
    "cell.lx": 10.0,
    "cell.ly": 10.0,
    "plates.amplitude": 0.05,
    "plates.gap": 1.268,
    "contacts.max_overlap": 0.2,  # since steps are long
    "time.dt": 5e-5,
    "run.seed": 3,
    "calibrate.bead_area_fractions": [0.2, 0.4],
    "calibrate.rod_area_fractions": [0.1, 0.2],
    "calibrate.relative_error": 0.5,
    "calibrate.round": 4,
    "calibrate.max_trials": 8,
    "calibrate.relaxation.warm_up": 0.05,
    "calibrate.relaxation.frame": 0.005,
    "calibrate.relaxation.time": 0.2,
    "calibrate.relaxation.max_lag": 0.1,
    "calibrate.weathercock.speeds": [10.0, 20.0],
    "calibrate.weathercock.max_window": 0.1,
    "calibrate.weathercock.warm_up": 0.05,
    "calibrate.weathercock.align": 0.05,
    "calibrate.drag.torques": [2000.0, 20000.0],
    "calibrate.drag.warm_up": 0.05,
    "calibrate.drag.time": 0.1,
    "calibrate.drag.windows": 2,
    "calibrate.drag.frame": 0.005,
    "calibrate.damping.warm_up": 0.05,
    "calibrate.damping.hold": 0.02,
    "calibrate.damping.time": 0.2,
    "calibrate.damping.frame": 0.01,
    "calibrate.shear.waves": [1, 2],
    "calibrate.shear.warm_up": 0.05,
    "calibrate.shear.hold": 0.02,
    "calibrate.shear.releases": 1,
    "calibrate.shear.time": 0.1,
    "calibrate.propulsion.warm_up": 0.05,
    "calibrate.propulsion.time": 0.1,
    "calibrate.stiffness.warm_up": 0.05,
    "calibrate.stiffness.settle": 0.05,
    "calibrate.stiffness.time": 0.1,
    "calibrate.stiffness.pushes": [100.0, 200.0],
    "calibrate.diffusion.warm_up": 0.05,
    "calibrate.diffusion.frame": 0.005,
    "calibrate.diffusion.time": 0.1,
    "calibrate.diffusion.min_lag": 0.01,
    "calibrate.diffusion.max_lag": 0.05,
    "calibrate.rotation.warm_up": 0.05,
    "calibrate.rotation.frame": 0.005,
    "calibrate.rotation.time": 0.2,
    "calibrate.rotation.min_lag": 0.01,
    "calibrate.rotation.max_lag": 0.05,
    "calibrate.alignment.torques": [2000.0, 20000.0],
    "calibrate.alignment.warm_up": 0.05,
    "calibrate.alignment.time": 0.1,
    "calibrate.alignment.frame": 0.005,
    "calibrate.scattering.cell": 12.0,
    "calibrate.scattering.max_duration": 0.05,
    "calibrate.scattering.warm_up": 0.05,
    "calibrate.scattering.time": 1.6,
    "calibrate.scattering.frame": 0.005,
}
UNITS = 2 * 9 + 2 * 2 * 2  # drag and alignment depend on rods


def write_tiny(folder, changes=None, name="tiny.toml"):
    """Writes the small scene with some keys changed; returns its name."""
    return write_scene(folder, changes, name=name, base=TINY)


def undisturbed(folder):
    """Makes that table in a folder; returns the folder of the trials, the JSON output and the log."""
    ended = drover(folder, "calibrate", write_tiny(folder), "--json", "--workers", "2")
    return folder / "tiny.calibration", json.loads(ended.stdout), ended.stderr


# A table as written by drover calibrate, with flocks at many beads; the threshold a/lambda is 3 mm/s everywhere.
PLAUSIBLE = {
    "relaxation_rate": lambda beads, rods: 0.3,
    "weathercock": lambda beads, rods: 0.1,
    "drag": lambda beads, rods: 1.0 + 4.0 * beads + 10.0 * rods,
    "response_time": lambda beads, rods: 2.0,
    "propulsion": lambda beads, rods: 3.0,
    "viscosity_kinematic": lambda beads, rods: 5.0,
    "stiffness": lambda beads, rods: 400.0,
    "bead_mass": lambda beads, rods: 0.7,
    "bead_area": lambda beads, rods: 0.5,
    "rod_area": lambda beads, rods: 4.0,
}
BY_RODS, SET = {"drag", "response_time"}, {"bead_mass", "bead_area", "rod_area"}


def write_plausible(path, relative_error=0.02, holes=(), kicks=(), also=()):
    """Writes that table.  `holes`: (name, index) of missing values; `kicks`: values of the varied key, each of which is
    added to relaxation_rate; `also`: further rows, which do not depend on rods."""
    rows = {**PLAUSIBLE, **dict(also)}
    beads, rods = [0.2, 0.3, 0.5, 0.7], [0.05, 0.08, 0.11]
    with h5py.File(path, "w") as file:
        file.attrs["coefficients"] = np.bytes_(" ".join(rows))
        file.attrs["varied"] = np.array(b"kick.strength" if kicks else b"", dtype="S13")
        file.attrs["remarks"] = np.array(b"", dtype="S1")
        file.attrs["scene"] = np.bytes_("[cell]\nlx = 45.0\nly = 45.0\n")
        group = file.create_group("calibration")
        group["bead_area_fraction"], group["rod_area_fraction"] = beads, rods
        if kicks:
            group["kick_strength"] = kicks
        for name, value in rows.items():
            values = np.array([[value(bead, rod) for rod in rods] for bead in beads])
            values = values if name in BY_RODS else values[:, 0].copy()
            if kicks:
                values = np.stack([values + (kick if name == "relaxation_rate" else 0.0) for kick in kicks])
            origins = np.full(values.shape, 4.0 if name in SET else 1.0)
            for place in (place for hole, place in holes if hole == name):
                origins.flat[place], values.flat[place] = 0.0, np.nan
            for part, numbers in (("", values), ("_error", (0.0 if name in SET else relative_error) * values),
                                  ("_trials", np.full(values.shape, 20.0)),
                                  ("_origin", origins)):
                group[name + part] = numbers
                group[name + part].attrs["units"] = group[name + part].attrs["long_name"] = np.bytes_("x")
    return path.name


def datasets(path):
    """Every dataset of a table, raw."""
    found = {}

    def take(name, item):
        if isinstance(item, h5py.Dataset):
            found[name] = (item.dtype.str, item.shape, item[()].tobytes())

    with h5py.File(path) as file:
        file.visititems(take)
    assert len(found) > 60
    return found


def trials_in(folder):
    """Complete trials in the records of a folder: measurement -> their numbers."""
    found = {}
    for file in sorted(Path(folder).glob("records/*.records")):
        content, place = file.read_bytes(), 16
        while place + 8 <= len(content):
            length = int.from_bytes(content[place:place + 8], "little")
            record = content[place + 8:place + 8 + length]
            place += 8 + length
            if place > len(content):
                break
            if record[:2] == b"\1\0":  # a unit that is done
                key = record[10:10 + int.from_bytes(record[2:10], "little")].decode()
                name, number = key.rsplit("-trial-", 1)
                found.setdefault(name, []).append(int(number))
    return found


def toml_of(folder):
    return tomllib.loads((Path(folder) / "table.toml").read_text())


def already_done(log):
    """Number of stored trials that a run reported."""
    return int(re.search(r"\((\d+) trials already done\)", log).group(1))


def assert_same_tables(one, other):
    """Compares both files byte by byte."""
    assert datasets(one / "table.h5") == datasets(other / "table.h5")
    for name in ("table.h5", "table.toml"):
        assert (one / name).read_bytes() == (other / name).read_bytes()


def kill_repeatedly(folder, scene, whole, kills, dice, seconds):
    """Kills a calibration `kills` times within this many seconds and resumes it each time: no trial may be lost,
    repeated or changed.  Returns how many kills hit a running calibration."""
    hits, before = 0, 0
    for _ in range(kills):
        process = start(folder, "calibrate", scene, "-o", "parts", "--workers", "2")
        try:
            try:
                process.wait(dice.uniform(0.02, seconds))
            except subprocess.TimeoutExpired:  # still running
                hits += 1
            process.kill()
            _, log = process.communicate()
            wait_until(lambda: not group_is_alive(process.pid), "the end of the workers", 10.0)
        finally:
            end_group(process)
        if "already done" in log:
            assert already_done(log) == before, "exactly the completed trials are stored"
        found = trials_in(folder / "parts")
        assert all(len(set(numbers)) == len(numbers) for numbers in found.values()), found
        before = sum(map(len, found.values()))
    ended = drover(folder, "calibrate", scene, "-o", "parts")
    assert already_done(ended.stderr) == before
    found, undisturbed = trials_in(folder / "parts"), trials_in(whole)
    assert {name: sorted(numbers) for name, numbers in found.items()} == {name: sorted(numbers) for name,
                                                                          numbers in undisturbed.items()}
    assert_same_tables(folder / "parts", whole)
    assert sorted(path.name for path in (folder / "parts").iterdir()) == sorted(path.name for path in whole.iterdir())
    return hits
