#!/usr/bin/python3
"""tests/bench/step_error/random_scenes.py: the step error that runs estimate beside their true one, on random scenes.

    random_scenes.py --drover PROGRAM --output FOLDER [--count N] [--first N]

draws scenes of all forms (number n is the same for everyone), runs each with its own step and with a step 16 times
shorter by etdrk4-krogstad, and writes FOLDER/step_error.csv: for each scene the estimate at its end (the observable
step_error), the true error (the largest of any field of the state, relative to its fluctuation as step_error is), their
ratio, and whether the run warned.  With noise both runs follow the same path, and
errors of the direction of the mean order are left out, as in the estimate.  Rows that exist are kept: re-run to resume.
"""
import argparse
import json
import math
import random
import subprocess
import sys
import tempfile
from pathlib import Path

import h5py

TESTS = Path(__file__).resolve().parents[2]
sys.path[:0] = [str(TESTS), str(TESTS / "extremes")]
from field_error import FIELDS, frame_of, size_of, without_direction  # noqa: E402
from studies import KeptTable, settings_of  # noqa: E402

COLUMNS = ("scene", "kind", "method", "dt", "noise", "ended", "estimate", "true", "ratio", "field", "warned",
           "settings")


def scene(number):
    """Keys of scene `number`, and what it is."""
    draw = random.Random(20141 + number)
    log = lambda low, high: math.exp(draw.uniform(math.log(low), math.log(high)))  # noqa: E731
    kind = draw.choice(["order", "order with density", "dynamic", "dynamic", "dynamic", "slaved"])
    points = draw.choice([32, 48, 64])
    noisy = draw.random() < 0.3
    keys = {"grid.nx": points, "grid.ny": points, "grid.lx": 16.0, "grid.ly": 16.0,
            "relaxation.rate": draw.choice([-1.0, 1.0]) * log(0.1, 1.0), "relaxation.saturation": log(0.3, 3.0),
            "elasticity.stiffness": log(0.1, 1.0), "advection.strength": draw.choice([0.0, log(0.05, 1.0)]),
            "current.speed": log(0.2, 1.5), "diffusion.rods": log(0.05, 0.5), "pressure.rods": log(0.05, 1.0),
            "initial.amplitude": log(0.01, 0.2), "run.seed": number,
            "time.stepper": draw.choice(["etdrk2", "etdrk2", "etdrk4", "etdrk4-krogstad"])}
    if kind in ("dynamic", "slaved"):
        keys |= {"fields.bead_density": True, "fields.bead_velocity": kind, "drag.coefficient": log(2.0, 20.0),
                 "driving.strength": log(1.0, 8.0), "stiffness.beads": log(0.5, 5.0),
                 "weathercock.strength": log(0.2, 2.0), "viscosity.shear": log(0.2, 2.0),
                 "diffusion.beads": log(0.05, 0.5)}
        if kind == "dynamic":
            keys["inertia.bead_mass"] = log(0.1, 2.0)
    steps = draw.choice([40, 100, 250, 600])
    dt = round(log(0.01, 0.3), 3)
    keys |= {"time.dt": dt, "time.end": dt * steps, "output.frame_every": 0.0, "output.sample_every": dt}
    if noisy:
        keys["noise.order"] = log(1e-4, 1e-2)
        keys["noise.rods"] = log(1e-5, 1e-3)
    start = {name: f"{draw.uniform(0.05, 0.4):.3f} * sin(2*pi*({draw.randint(0, 2)}*x + {draw.randint(0, 2)}*y)/16 + "
                   f"{draw.uniform(0, 6):.2f}) + {draw.uniform(-0.5, 0.5):.3f}"
             for name in ("polar_order_x", "polar_order_y")}
    keys["initial.kind"] = draw.choice(["formula", "formula", "random"])
    if keys["initial.kind"] == "formula":
        keys |= {f"initial.{name}": text for name, text in start.items()}
    return kind + (", noise" if noisy else ""), keys


def fluctuations(start, observables, slaved):
    """Of each field of the state: the root mean square deviation from its mean over the cell and over time, or that
    over the cell now if larger, and at least 1e-5 of the largest root mean square that it has had."""
    found = {}
    for group in FIELDS:
        if group[0] not in start or (slaved and group[0] == "bead_velocity_x"):
            continue
        name = group[0].removesuffix("_x")
        variance = observables[f"variance_{name}"][:]
        squares, change = variance + (start[name].mean()**2 if len(group) == 1 else 0.0), 0.0
        for axis in "xy" if len(group) == 2 else "":
            mean = observables[f"{name}_mean_{axis}"][:]
            squares, change = squares + mean**2, change + mean.var()
        found[group] = math.sqrt(max(variance.mean() + change, variance[-1], 1e-10 * squares.max()))
    return found


def largest_error(frame, exact, noisy, sizes):
    """The largest error of a field, relative to its fluctuation; and its name."""
    wrong = {name: frame[name] - exact[name] for name in frame}
    if noisy:
        wrong = without_direction(wrong, exact)
    return max((size_of(wrong, group) / size if size > 0.0 else 0.0, group[0]) for group, size in sizes.items())


def run(program, folder, name, keys):
    """Status, JSON, and last frame of a run."""
    archive = folder / f"{name}.h5"
    (folder / "empty.toml").write_text("")
    ended = subprocess.run([program, "run", folder / "empty.toml", "--quiet", "--overwrite", "--json",
                            *settings_of({**keys, "output.file": str(archive)})],
                           capture_output=True, text=True, check=False)
    if ended.returncode != 0:
        return ended.returncode, ended.stderr.strip(), None
    with h5py.File(archive) as file:
        observables = file["observables"]
        found = {"estimate": float(observables["step_error"][-1]),
                 "sizes": fluctuations(frame_of(archive, 0), observables, keys.get("fields.bead_velocity") == "slaved")}
    return 0, json.loads(ended.stdout) | found, frame_of(archive)


def row_of(program, number):
    kind, keys = scene(number)
    row = {"scene": number, "kind": kind, "method": keys["time.stepper"], "dt": keys["time.dt"],
           "noise": "noise" in kind, "settings": json.dumps(keys)}
    with tempfile.TemporaryDirectory() as folder:
        status, found, frame = run(program, Path(folder), "run", keys)
        if status != 0:
            return {**row, "ended": found.splitlines()[-1][:200]}
        finer = {**keys, "time.stepper": "etdrk4-krogstad", "time.dt": keys["time.dt"] / 16}
        status, exact, reference = run(program, Path(folder), "exact", finer)
        if status != 0:
            return {**row, "ended": "reference: " + exact.splitlines()[-1][:200]}
    error, field = largest_error(frame, reference, row["noise"], found["sizes"])
    warned = any(warning.startswith("time.dt") for warning in found["warnings"])
    return {**row, "ended": "0", "estimate": f"{found['estimate']:.3g}", "true": f"{error:.3g}",
            "ratio": f"{found['estimate'] / error:.3g}" if error > 0.0 else "nan", "field": field, "warned": warned}


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--drover", default="drover")
    parser.add_argument("--output", type=Path, required=True)
    parser.add_argument("--count", type=int, default=200)
    parser.add_argument("--first", type=int, default=0)
    options = parser.parse_args()
    table = KeptTable(options.output / "step_error.csv", COLUMNS)
    done = {int(row["scene"]) for row in table.rows}
    for number in range(options.first, options.first + options.count):
        if number not in done:
            table.add(row_of(options.drover, number))
    judged = [row for row in table.rows if row["ended"] == "0" and float(row["true"]) > 1e-12]
    ratios = sorted(float(row["ratio"]) for row in judged)
    within = sum(1 / 3 <= ratio <= 3 for ratio in ratios)
    silent = [row["scene"] for row in judged if float(row["ratio"]) < 0.1 and str(row["warned"]) != "True"]
    print(f"{len(table.rows)} scenes, {len(judged)} judged: within a factor of 3: {within} "
          f"({100 * within / len(judged):.0f} %); ratios {ratios[0]:.2g} to {ratios[-1]:.2g}, "
          f"median {ratios[len(ratios) // 2]:.2g}; below a tenth without a warning: {silent or 'none'}")


if __name__ == "__main__":
    main()
