#!/usr/bin/python3
"""tests/bench/methods/work_precision.py: error against cost of every time stepper on three scenes without noise.

    work_precision.py --drover PROGRAM --output FOLDER [--figure FILE]

runs each scene by each method at several steps or tolerances and writes FOLDER/work_precision.csv: right-hand sides,
user CPU seconds of the process (start-up included) and the largest relative error of any field at the end, beside a
reference: etdrk4-krogstad at a 512th of a second, for stiff beads cvode-bdf at a tolerance of 1e-12.  A run of more
than 20 s is given up, and so are finer ones of its method.  Rows that exist are kept: re-run to resume.  --figure draws
error against right-hand sides, one panel per scene.
"""
import argparse
import csv
import json
import os
import re
import subprocess
import sys
import tempfile
from pathlib import Path

import h5py
import numpy

sys.path.insert(0, str(Path(__file__).resolve().parents[2]))
from studies import KeptTable, settings_of  # noqa: E402

MODELS = Path(__file__).resolve().parents[3] / "models"
FIELDS = (("bead_density",), ("rod_density",), ("bead_velocity_x", "bead_velocity_y"),
          ("polar_order_x", "polar_order_y"))
COLUMNS = ("scene", "method", "dt", "tolerance", "right_hand_sides", "cpu_seconds", "error")
SUNDIALS = ("cvode-bdf", "cvode-adams", "arkode-ark324l2sa", "arkode-ark436l2sa", "arkode-ark437l2sa",
            "arkode-ark548l2sa", "arkode-ark548l2sab")
OWN = ("exponential-euler", "etdrk2", "etdrk4", "etdrk4-krogstad", "etd-abm3", "etd-abm4", "etd-abm5", "etd-abm6")
TOLERANCES = (1e-3, 1e-4, 1e-5, 1e-6, 1e-7, 1e-8, 1e-9, 1e-10)
FLOCK = {"noise.order": 0.0, "grid.nx": 64, "grid.ny": 64, "grid.lx": 64.0, "grid.ly": 64.0, "initial.amplitude": 0.0,
         "initial.polar_order_x": "0.5 + 0.2 * cos(2*pi*y/64 + 0.4) + 0.1 * sin(2*pi*(x + y)/64)",
         "initial.polar_order_y": "0.2 * sin(2*pi*x/64) + 0.1 * cos(2*pi*(2*x - y)/64)",
         "initial.bead_velocity_x": "0.5"}
# Scene, its settings, interval of outputs, end, and method, step and tolerance of the reference.
SCENES = {
    "band": ("band.toml", {"grid.nx": 256, "grid.ny": 1,
                           "initial.rod_density": "1.02 + 0.2 * (tanh((x - 32) / 6) - tanh((x - 80) / 4) - 1)",
                           "initial.polar_order_x": "0.25 * (tanh((x - 32) / 6) - tanh((x - 80) / 4))"},
             1.0, 20.0, ("etdrk4-krogstad", 1 / 512, 0.0)),
    "flock": ("flock.toml", FLOCK, 1.0, 10.0, ("etdrk4-krogstad", 1 / 512, 0.0)),
    "stiff beads": ("flock.toml", {**FLOCK, "drag.coefficient": 3360.0, "driving.strength": 3360.0,
                                   "viscosity.shear": 6720.0, "stiffness.beads": 1680.0, "stiffness.rods": 4200.0,
                                   "initial.bead_density": "0.8 + 0.3 * cos(2*pi*(x + y)/64)"},
                    1.0, 10.0, ("cvode-bdf", 1.0, 1e-12)),
}


def run(program, folder, scene, method, dt, tolerance, limit=20.0):
    """The final fields, the right-hand sides and the user CPU seconds of a run; the reason if it fails."""
    name, keys, _, end, _ = SCENES[scene]
    keys = {**keys, "time.stepper": method, "time.dt": dt, "time.end": end, "time.tolerance": tolerance,
            "time.max_error": 0.0, "output.frame_every": 0.0, "output.sample_every": 0.0, "run.threads": 1,
            "analysis.warm_up": 0.0}
    archive = folder / "run.h5"
    before = os.times().children_user
    try:
        ended = subprocess.run([program, "run", MODELS / name, *settings_of(keys), "-o", archive, "--overwrite"],
                               check=False, capture_output=True, text=True, timeout=limit)
    except subprocess.TimeoutExpired:
        return "too slow"
    seconds = os.times().children_user - before
    if ended.returncode == 2:
        raise SystemExit(ended.stderr)
    if ended.returncode != 0:
        return "failed"
    with h5py.File(archive) as file:
        fields = [numpy.array([file[name][-1] for name in names]) for names in FIELDS if names[0] in file]
    taken = re.search(r"(\d+) steps taken, (\d+) rejected(?:, (\d+) right-hand sides)?", ended.stderr)
    if taken and taken.group(3):
        return fields, int(taken.group(3)), seconds
    explained = json.loads(subprocess.run([program, "explain", MODELS / name, *settings_of(keys), "--json"], check=True,
                                          capture_output=True, text=True).stdout)
    steps = int(taken.group(1)) + int(taken.group(2)) if taken else round(end / dt)
    return fields, steps * explained["right_hand_sides_per_step"], seconds


def error(fields, exact):
    return max(float(numpy.sqrt(numpy.sum((a - b)**2) / max(numpy.sum(b**2), 1e-300))) for a, b in zip(fields, exact))


def settings():
    """Scene, method, dt, tolerance of every row."""
    for scene, (_, _, interval, *_) in SCENES.items():
        for method in OWN:
            for halvings in range(1, 9 if method == "etdrk4-krogstad" else 10):
                yield scene, method, interval / 2**halvings, 0.0
        for method in ("etdrk2", "etdrk4-krogstad"):
            for tolerance in TOLERANCES[:5 if method == "etdrk2" else 8]:
                yield scene, method, interval, tolerance
        for method in SUNDIALS:
            for tolerance in TOLERANCES[:6 if method == "arkode-ark324l2sa" else 8]:
                yield scene, method, interval, tolerance


def measure(program, table):
    kept = KeptTable(table, COLUMNS)
    done = {(row["scene"], row["method"], float(row["dt"]), float(row["tolerance"])) for row in kept.rows}
    exact = {}
    too_slow = {(row["scene"], row["method"], float(row["tolerance"]) > 0.0)
                for row in kept.rows if row["error"] == "too slow"}
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        for scene, method, dt, tolerance in settings():
            series = (scene, method, tolerance > 0.0)
            if (scene, method, dt, tolerance) in done or series in too_slow:
                continue
            if scene not in exact:
                exact[scene] = run(program, folder, scene, *SCENES[scene][4], limit=None)[0]
            found = run(program, folder, scene, method, dt, tolerance)
            row = {"scene": scene, "method": method, "dt": f"{dt:.12g}", "tolerance": f"{tolerance:g}"}
            if isinstance(found, str):
                row["error"] = found
                if found == "too slow":
                    too_slow.add(series)
            else:
                row |= {"right_hand_sides": found[1], "cpu_seconds": f"{found[2]:.2f}",
                        "error": f"{error(found[0], exact[scene]):.3g}"}
            kept.add(row)


def draw(table, figure):
    import matplotlib
    matplotlib.use("Agg")
    import matplotlib.pyplot as pyplot
    rows = [row for row in csv.DictReader(table.open()) if row["right_hand_sides"]]
    _, axes = pyplot.subplots(1, len(SCENES), figsize=(5 * len(SCENES), 4.5), sharey=True)
    colours = pyplot.get_cmap("tab20").colors
    for panel, scene in zip(axes, SCENES):
        for number, method in enumerate((*OWN, *SUNDIALS)):
            for adaptive, line in ((False, "o-"), (True, "s--" if method in OWN else "^-")):
                points = [(float(row["right_hand_sides"]), float(row["error"])) for row in rows
                          if (row["scene"], row["method"]) == (scene, method) and
                          (float(row["tolerance"]) > 0.0) == adaptive and 0.0 < float(row["error"]) < 1.0]
                if points:
                    panel.loglog(*zip(*points), line, color=colours[number], markersize=3, linewidth=1,
                                 label=method + (", tolerance" if adaptive and method in OWN else ""))
        panel.set(title=scene, xlabel="right-hand sides")
        panel.grid(alpha=0.3)
    axes[0].set_ylabel("relative error at the end")
    axes[0].legend(fontsize=5, loc="lower left")
    pyplot.tight_layout()
    pyplot.savefig(figure, dpi=150)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--drover", required=True)
    parser.add_argument("--output", required=True, type=Path)
    parser.add_argument("--figure", type=Path)
    words = parser.parse_args()
    words.output.mkdir(parents=True, exist_ok=True)
    table = words.output / "work_precision.csv"
    measure(words.drover, table)
    if words.figure:
        draw(table, words.figure)


if __name__ == "__main__":
    main()
