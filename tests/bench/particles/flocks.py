"""tests/bench/particles/flocks.py: which scenes flock: the order and the flow of beads against time, kept as small
tables.

Usage: flocks.py --drover PROGRAM --output FOLDER [--only NAME ...] [--threads N]

Each case is a scene of models/ with some settings.  FOLDER/NAME.csv gets a row a second; FOLDER/flocks.json one entry
a case: mean and largest order beside those of as many random directions, the first time that the order passes .8, and
the flow of the beads; of a circle the rods at its wall.  A case whose table is there is not run again.  A run of a
periodic cell of 45 mm takes 2 to 5 minutes of one core, one of 90 mm four times as long; all of them an hour and a
half. """
import argparse
import csv
import json
import subprocess
import sys
import tempfile
import tomllib
from pathlib import Path

import h5py
import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[2]))
from studies import settings_of, version_of  # noqa: E402

MODELS = Path(__file__).resolve().parents[3] / "models"
NOMINAL = ["plates.amplitude=0.04", "plates.gap=1.2", "rods.size_tolerance=0.0", "kick.strength=0.015"]
QUICK = ["plates.amplitude=0.04", "plates.gap=1.15", "rods.size_tolerance=0.0",
         "kick.strength=0.015"]  # beyond the second gait
LARGE = ["cell.lx=90.0", "cell.ly=90.0"]
# Matched rods go as fast with steps of 5e-5 s as with 2e-5: 3.16(39) and 3.12(40) mm/s over 40 rods.
COARSE = ["time.dt=5e-5", "contacts.substep=5e-5", "time.end=200.0"]
# Settings of a scene of the matched rods: coarse steps, or what makes its rods those of the paper as printed.
RODS = {
    "matched": {"time.dt": 5e-5, "contacts.substep": 5e-5},
    "printed": {"plates.amplitude": 0.04, "plates.gap": 1.2, "rods.size_tolerance": 0.0, "rods.bearing": "all",
                "kick.strength": 0.015, "contacts.law": "pairwise", "time.dt": 1e-5},
}
POINTS = [*((beads, rods) for beads in (0.2, 0.4, 0.5, 0.6, 0.7) for rods in (0.05, 0.08, 0.11)), (0.3, 0.11),
          (0.35, 0.14), (0.25, 0.11), (0.45, 0.05), (0.55, 0.11)]
CASES = {
    "matched-dense": ("bead-flock", []),
    "matched-dense-2": ("bead-flock", ["run.seed=2"]),
    "matched-dense-3": ("bead-flock", ["run.seed=3"]),
    "matched-poor": ("bead-poor", []),
    "free-matched-dense": ("bead-flock", ["kick.strength=0.0265"]),
    "free-matched-poor": ("bead-poor", ["kick.strength=0.0265"]),
    "nominal-dense": ("bead-flock", NOMINAL),
    "nominal-poor": ("bead-poor", NOMINAL),
    "quick-dense": ("bead-flock", QUICK),
    "rods-alone": ("rods-alone", []),
    "flower-dense": ("flower-flock", []),
    "flower-poor": ("flower-poor", []),
    "circle-dense": ("circle-flock", []),
    "amorphous": ("amorphous", []),
    "matched-dense-90mm": ("bead-flock", LARGE),
    "matched-poor-90mm": ("bead-poor", LARGE),
    "matched-no-beads": ("bead-flock", ["beads.area_fraction=0.0"]),
    # The plane of both area fractions, for the boundary that a table of coefficients predicts (predicted.py).
    **{f"point-{beads}-{rods}": ("bead-flock", [f"beads.area_fraction={beads}", f"rods.area_fraction={rods}", *COARSE])
       for beads, rods in POINTS},
    # More seeds of points near the line, where no single run decides.
    **{f"seed-{beads}-{rods}-{seed}": ("bead-flock", [f"beads.area_fraction={beads}", f"rods.area_fraction={rods}",
                                                      *COARSE, f"run.seed={seed}"])
       for beads, rods in ((0.2, 0.11), (0.5, 0.11), (0.6, 0.05)) for seed in (2, 3, 4)},
    # The same with the mean velocity of the beads held at zero: what is left of the order is due to contacts.
    **{f"held-{beads}-{rods}-{seed}": ("bead-flock", [f"beads.area_fraction={beads}", f"rods.area_fraction={rods}",
                                                      *COARSE, "forces.hold_beads=true", f"run.seed={seed}"])
       for beads in (0.2, 0.3, 0.4, 0.5, 0.6, 0.7) for rods in (0.08, 0.11) for seed in (1, 2)},
    # Which way a flower turns.
    **{f"flower-{seed}": ("flower-flock", [*COARSE[:2], f"run.seed={seed}"]) for seed in range(1, 21)},
}
ROUND = ("flower-flock", "flower-poor", "circle-flock")
SERIES = ["polar_order", "polar_order_local", "bead_velocity_size", "bead_velocity_along_order",
          "bead_velocity_azimuthal",
          "rod_velocity_azimuthal"]
# Instantaneous velocities swing with the plates; means over this many samples do not.
SMOOTHED = 10


def run(arguments, scene, settings, folder):
    """Runs a scene; its archive."""
    archive = Path(folder) / "run.h5"
    words = [arguments.drover, "run", str(MODELS / (scene + ".toml")), "--output", str(archive), "--quiet",
             "--threads", str(arguments.threads)]
    for setting in [*settings, "output.frame_every=10.0", "output.sample_every=0.1025"]:
        words += ["--set", setting]
    subprocess.run(words, check=True, stdout=subprocess.DEVNULL)
    return archive


class Stopped(Exception):
    """The run was stopped by a signal after a checkpoint; the same command goes on."""


def run_or_resume(program, scene, settings, archive):
    """Runs a scene of models/ with settings {key: value}, or takes up its archive where it ended."""
    words = [program, "restart", str(archive), "--quiet"]
    if not archive.exists():
        words = [program, "run", str(MODELS / (scene + ".toml")), "--output", str(archive), "--quiet",
                 *settings_of({**settings, "run.threads": 1, "output.checkpoint_minutes": 5})]
    ended = subprocess.run(words, check=False, stdout=subprocess.DEVNULL).returncode
    if ended == 3:
        raise Stopped
    if ended:
        sys.exit(f"{archive.name}: the run failed with exit status {ended}")


def said(settings):
    """Settings as a line of text."""
    return " ".join(f"{key}={value}" for key, value in settings.items())


def remove(archive):
    """An archive with what lies beside it."""
    for file in (archive, *archive.parent.glob(archive.name + ".*")):
        file.unlink(missing_ok=True)


def means(values):
    """Means of consecutive samples."""
    whole = len(values) // SMOOTHED * SMOOTHED
    return values[:whole].reshape(-1, SMOOTHED).mean(axis=1)


def random_order(rods, samples):
    """Mean of the order of random directions, and the mean of the largest of so many independent ones."""
    drawn = np.random.default_rng(1)
    orders = np.abs(np.exp(2j * np.pi * drawn.random((2000, rods))).mean(axis=1))
    return orders.mean(), drawn.choice(orders, (500, samples)).max(axis=1).mean()


def mean_error(values):
    """Standard error of the mean of a correlated series: sqrt(2 tau/T) of its deviation.  The sum for tau ends where it
    exceeds a fifth of the lag (Sokal); a series of a few tau gives too small an error, and its own mean hides the
    slowest part."""
    left, deviation = values - values.mean(), values.std()
    tau = 0.5
    for lag in range(1, len(values) // 2):
        tau += float((left[lag:] * left[:-lag]).mean()) / deviation**2
        if lag > 5.0 * tau:
            break
    return deviation * np.sqrt(2.0 * max(tau, 0.5) / len(values))


def at_wall(file):
    """The share of rods within a rod length of the wall of a circle over the second half, and that of even places."""
    cell = tomllib.loads(np.bytes_(file.attrs["scene"]).decode())
    radius, length = cell["cell"]["radius"], cell["rods"]["length"]
    place = file["bodies/rods/position/value"][()][..., :2]
    distance = np.hypot(*np.moveaxis(place[len(place) // 2:], -1, 0))
    return {"share_at_wall": (distance > radius - length).mean(), "share_at_wall_even": 1 - (1 - length / radius)**2}


def measure(archive, scene):
    """Columns of the table of a case, and its row of the summary."""
    with h5py.File(archive) as file:
        series = file["series"]
        columns = {"time": means(series["time"][()])}
        columns.update({name: means(series[name][()]) for name in SERIES if name in series})
        rods = file["bodies/rods/position/value"].shape[1]
        overlap = float(series["overlap_largest"][-1])
        near_wall = at_wall(file) if scene == "circle-flock" else {}
    order = columns["polar_order_local" if scene in ROUND else "polar_order"]
    end = columns["time"] > 0.5 * columns["time"][-1]
    passed = columns["time"][order > 0.8]
    mean, largest = random_order(rods, max(1, int(columns["time"][-1] / 5.0)))
    row = {"rods": rods, "seconds": round(float(columns["time"][-1]), 1), "order_mean_second_half": order[end].mean(),
           "order_error": mean_error(order[end]),
           "order_largest": order.max(), "random_mean": mean, "random_largest": largest,
           "passes_0.8_at_s": round(float(passed[0]), 1) if len(passed) else "", "overlap_largest": overlap,
           **near_wall}
    for name in SERIES[2:]:
        if name in columns:
            row[name + "_mm_s"] = columns[name][end].mean()
    return columns, row


def written(value):
    return f"{value:.4g}" if isinstance(value, (float, np.floating)) else value


def write(path, header, rows):
    """A whole table or none."""
    beside = path.with_suffix(".part")
    with beside.open("w", newline="") as file:
        file.write(header)
        table = csv.writer(file, lineterminator="\n")
        table.writerows([written(value) for value in row] for row in rows)
    beside.replace(path)


def keep(program, table, scene, settings, rows_of):
    """Runs a scene, or goes on where it was stopped, and keeps rows_of(archive) as a table in place of the archive."""
    archive = table.with_suffix(".h5")
    run_or_resume(program, scene, settings, archive)
    write(table, f"# {scene}.toml {said(settings)}; {version_of(program)}\n", list(rows_of(archive)))
    remove(archive)
    print(table, flush=True)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--drover", required=True, help="the program")
    parser.add_argument("--output", required=True, type=Path, help="folder of the tables")
    parser.add_argument("--only", nargs="*", default=list(CASES), choices=list(CASES), help="cases to run")
    parser.add_argument("--threads", type=int, default=1)
    arguments = parser.parse_args()
    arguments.output.mkdir(parents=True, exist_ok=True)
    summary = arguments.output / "flocks.json"
    rows = json.loads(summary.read_text()) if summary.exists() else {}
    version = version_of(arguments.drover)
    for name in arguments.only:
        if name in rows and (arguments.output / (name + ".csv")).exists():
            continue
        scene, settings = CASES[name]
        with tempfile.TemporaryDirectory(dir=arguments.output) as folder:
            columns, row = measure(run(arguments, scene, settings, folder), scene)
        write(arguments.output / (name + ".csv"), f"# {scene}.toml {' '.join(settings)}; {version}\n",
              [list(columns), *zip(*columns.values())])
        rows[name] = {key: written(value) for key, value in row.items()}
        summary.write_text(json.dumps(rows, indent=1) + "\n")
        print(name, rows[name], flush=True)
    return 0


if __name__ == "__main__":
    sys.exit(main())
