"""tests/bench/step_error/cost.py: what the error of the steps and the biases by them cost.

Runs a flock with noise and one without, with 13 to 2000 steps, with neither estimate (time.max_error = 0,
accuracy.effort = 0), with the error of the fields alone, and with the biases too, in turns: the least core seconds of
the whole process over several turns.

    DROVER=build/release/drover /usr/bin/python3 tests/bench/step_error/cost.py --points 64 --output FILE.csv

Rows that exist are kept: re-run to resume.
"""
import argparse
import os
import sys
import tempfile
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[2]))
from studies import KeptTable, settings_of, timed  # noqa: E402

DROVER = str(Path(os.environ.get("DROVER", "build/release/drover")).absolute())
COLUMNS = ("points", "noise", "steps", "neither", "error", "error_and_biases", "cost_of_error", "cost_of_biases")
SCENE = {"uniform.rod_density": 1.0, "current.speed": 1.0, "pressure.rods": 0.5, "diffusion.rods": 0.5,
         "relaxation.rate": -0.5, "relaxation.saturation": 1.0, "elasticity.stiffness": 1.0, "advection.strength": 0.5,
         "initial.kind": "formula", "time.stepper": "etdrk2", "time.dt": 0.05, "output.frame_every": 0.0,
         "run.threads": 1}
WAYS = {"neither": {"time.max_error": 0.0, "accuracy.effort": 0.0}, "error": {"accuracy.effort": 0.0},
        "error_and_biases": {}}


def seconds_of(folder, keys):
    """Core seconds of a whole run."""
    ended, seconds = timed(DROVER, "run", "empty.toml", "--quiet", "--overwrite", *settings_of(keys), cwd=folder)
    if ended.returncode != 0:
        raise RuntimeError(ended.stderr)
    return seconds


def row_of(folder, points, noisy, steps, turns):
    side = float(points)
    keys = {**SCENE, "grid.nx": points, "grid.ny": points, "grid.lx": side, "grid.ly": side,
            "time.end": round(0.05 * steps, 6), "output.sample_every": 0.05 if steps < 100 else 0.25,
            "initial.polar_order_x": f"0.7 + 0.1*sin(2*pi*x/{side})"}
    if noisy:
        keys |= {"noise.order": 0.02, "noise.rods": 0.02}
    turned = [{name: seconds_of(folder, {**keys, **way}) for name, way in WAYS.items()} for _ in range(turns)]
    found = {name: min(turn[name] for turn in turned) for name in WAYS}
    return {"points": points, "noise": noisy, "steps": steps, **{name: f"{one:.4f}" for name, one in found.items()},
            "cost_of_error": f"{(found['error'] - found['neither']) / found['neither']:.3f}",
            "cost_of_biases": f"{(found['error_and_biases'] - found['error']) / found['neither']:.3f}"}


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--points", type=int, default=64)
    parser.add_argument("--steps", type=int, nargs="+", default=(13, 27, 80, 240, 2000))
    parser.add_argument("--turns", type=int, default=7)
    parser.add_argument("--output", type=Path, required=True)
    options = parser.parse_args()
    table = KeptTable(options.output, COLUMNS)
    known = {(int(row["points"]), row["noise"], int(row["steps"])) for row in table.rows}
    with tempfile.TemporaryDirectory() as name:
        (Path(name) / "empty.toml").write_text("")
        for steps in options.steps:
            for noisy in (False, True):
                if (options.points, str(noisy), steps) not in known:
                    table.add(row_of(Path(name), options.points, noisy, steps, options.turns))
    for row in table.rows:
        print(*(f"{name} {row[name]}" for name in COLUMNS))


if __name__ == "__main__":
    main()
