"""tests/bench/step_error/default_step.py: the error and the cost of runs that leave time.dt and time.stepper out.

Draws small scenes without noise (rods alone, or with flowing beads; smooth or random starts) and an error that is asked
for, runs each, and compares its fields at every output with those of an eighth of its step and etdrk4-krogstad.  The
cost, core seconds of the process, is compared with that of the cheapest run whose error is as small, over three methods
and nine steps.

    DROVER=build/release/drover /usr/bin/python3 tests/bench/step_error/default_step.py --scenes 40 --output FILE.csv

Rows that exist are kept: re-run to resume.
"""
import argparse
import json
import os
import random
import sys
import tempfile
import tomllib
from pathlib import Path

import h5py
import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[2]))
from studies import KeptTable, settings_of, timed  # noqa: E402

DROVER = str(Path(os.environ.get("DROVER", "build/release/drover")).absolute())
COLUMNS = ("seed", "scene", "points", "kind", "asked", "outcome", "method", "dt", "error", "starts", "seconds", "best",
           "best_seconds", "settings")
FIELDS = (("bead_density",), ("rod_density",), ("bead_velocity_x", "bead_velocity_y"),
          ("polar_order_x", "polar_order_y"))


def draw(number, seed, is_large):
    rng = random.Random(f"step-{seed}-{number}")

    def log(low, high):
        return float(f"{low * (high / low) ** rng.random():.3g}")

    kind = ("rods", "rods, random start", "dynamic", "slaved")[number % 4]
    points = rng.choice((32, 64))
    nx, ny = (96, 96) if is_large else (points, 16)
    keys = {"uniform.rod_density": 1.0, "current.speed": log(0.3, 2.0), "pressure.rods": log(0.1, 1.0),
            "diffusion.rods": log(0.1, 1.0), "advection.strength": log(0.1, 1.0), "elasticity.stiffness": log(0.3, 1.0),
            "relaxation.rate": -log(0.2, 1.5), "relaxation.saturation": log(0.5, 3.0), "grid.nx": nx,
            "grid.ny": ny, "grid.lx": 16.0, "grid.ly": 8.0, "run.threads": 1}
    if kind in ("dynamic", "slaved"):
        keys |= {"fields.bead_density": True, "fields.bead_velocity": kind, "uniform.bead_density": 1.0,
                 "drag.coefficient": log(2.0, 8.0), "driving.strength": log(0.5, 3.0), "stiffness.beads": log(0.5, 5.0),
                 "diffusion.beads": 0.3, "weathercock.strength": log(0.3, 1.5)}
    if "random" in kind:
        keys |= {"initial.kind": "random", "initial.amplitude": 0.05}
    else:
        keys |= {"initial.kind": "formula", "initial.polar_order_x": f"{log(0.1, 0.8)} + 0.2*sin(2*pi*x/16)",
                 "initial.polar_order_y": "0.2*cos(2*pi*(x + 2*y)/16)"}
    end = float(rng.choice((10, 20, 40)))
    asked = rng.choice((0.05, 0.01, 0.01, 1e-3))
    return kind, keys | {"time.end": end, "output.frame_every": end / 20, "output.sample_every": end / 20,
                         "time.max_error": asked}, asked


def run(folder, name, keys):
    """The messages of a run and its core seconds; None where it fails."""
    ended, seconds = timed(DROVER, "run", "empty.toml", "--overwrite", "-o", f"{name}.h5", *settings_of(keys),
                           cwd=folder)
    return (ended.stderr if ended.returncode == 0 else None), seconds


def least_costs(folder, scenes):
    """Core seconds of each scene, the least of five runs in turn: other work on the machine lengthens some."""
    costs = [[run(folder, "timed", keys)[1] for keys in scenes] for _ in range(5)]
    return [min(of_scene) for of_scene in zip(*costs)]


def error_of(archive, exact):
    """The largest error of a field at any frame, over its deviation from its mean over cell and time."""
    worst = 0.0
    with h5py.File(archive) as a, h5py.File(exact) as b:
        for group in FIELDS:
            if group[0] in a:
                wrong = max(sum((a[name][...] - b[name][...])**2 for name in group).mean(axis=(1, 2)))
                spread = sum(b[name][...].var() for name in group)
                worst = max(worst, (wrong / spread)**0.5 if spread > 1e-20 else 0.0)
    return worst


def judge(number, seed, is_large, folder):
    kind, keys, asked = draw(number, seed, is_large)
    row = {"seed": seed, "scene": number, "points": f"{keys['grid.nx']} by {keys['grid.ny']}", "kind": kind,
           "asked": asked, "settings": json.dumps(keys)}
    said, _ = run(folder, "chosen", keys)
    if said is None:
        return {**row, "outcome": "stopped"}
    with h5py.File(folder / "chosen.h5") as file:
        scene = file.attrs["scene"]
        scene = scene.decode() if isinstance(scene, bytes) else scene
    time = tomllib.loads(scene)["time"]
    fine = {**keys, "time.stepper": "etdrk4-krogstad", "time.max_error": 0.0, "accuracy.effort": 0.0}
    parts = int(np.ceil(keys["output.frame_every"] / time["dt"])) * 8
    run(folder, "exact", {**fine, "time.dt": keys["output.frame_every"] / parts})
    error = error_of(folder / "chosen.h5", folder / "exact.h5")
    limit, right = max(asked, error), []
    for method in ("etdrk2", "etdrk4-krogstad", "etd-abm4"):
        for power in range(9):  # from the longest step: the first that is right is the cheapest
            fixed = {**keys, "time.stepper": method, "time.dt": keys["output.frame_every"] / 2**power}
            found, _ = run(folder, "fixed", fixed)
            if found is not None and error_of(folder / "fixed.h5", folder / "exact.h5") <= limit:
                right.append(fixed)
                break
    seconds, *costs = least_costs(folder, [keys, *right])
    cheapest, least = min(zip(right, costs), key=lambda one: one[1])
    return {**row, "outcome": "run", "method": time["stepper"], "dt": time["dt"], "error": f"{error:.3g}",
            "starts": said.count("doing so now"), "seconds": f"{seconds:.3g}",
            "best": f"{cheapest['time.stepper']}, dt = {cheapest['time.dt']:.4g}", "best_seconds": f"{least:.3g}"}


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--scenes", type=int, default=40)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--large", action="store_true", help="on 96 by 96 points, for some seconds each")
    parser.add_argument("--output", type=Path, required=True)
    options = parser.parse_args()
    table = KeptTable(options.output, COLUMNS)
    known = {(int(row["seed"]), int(row["scene"])) for row in table.rows}
    with tempfile.TemporaryDirectory() as name:
        (Path(name) / "empty.toml").write_text("")
        for number in range(options.scenes):
            if (options.seed, number) not in known:
                table.add(judge(number, options.seed, options.large, Path(name)))
    some = [row for row in table.rows if row["outcome"] == "run"]
    ratio = [float(row["error"]) / float(row["asked"]) for row in some]
    print(f"{len(table.rows)} scenes, {len(some)} run: error at most the one asked in {sum(r <= 1 for r in ratio)}, "
          f"at least a twentieth of it in {sum(r >= 0.05 for r in ratio)}; cost at most 1.5 times the best in "
          f"{sum(float(row['seconds']) <= 1.5 * float(row['best_seconds']) for row in some)}; more than one fresh "
          f"start in {sum(int(row['starts']) > 1 for row in some)}")


if __name__ == "__main__":
    main()
