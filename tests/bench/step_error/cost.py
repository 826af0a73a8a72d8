"""tests/bench/step_error/cost.py: what the error of the steps and the biases by them cost.

Runs a flock with noise and one without, with 13 to 2000 steps, and models of one's own with as many, with neither
estimate (time.max_error = 0, accuracy.effort = 0), with the error of the fields alone, and with the biases too.  The
cost is in instructions of the whole process, counted by valgrind: other work on the machine does not change them.

    DROVER=build/release/drover /usr/bin/python3 tests/bench/step_error/cost.py --points 64 --output FILE.csv
    DROVER=build/release/drover /usr/bin/python3 tests/bench/step_error/cost.py --models --steps 400 --output FILE.csv

Rows that exist are kept: re-run to resume.
"""
import argparse
import os
import re
import subprocess
import sys
import tempfile
import tomllib
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[2]))
from studies import KeptTable, settings_of  # noqa: E402

ROOT = Path(__file__).resolve().parents[3]
DROVER = str(Path(os.environ.get("DROVER", "build/release/drover")).absolute())
COLUMNS = ("scene", "points", "steps", "neither", "error", "error_and_biases", "cost_of_error", "cost_of_biases")
SCENE = {"uniform.rod_density": 1.0, "current.speed": 1.0, "pressure.rods": 0.5, "diffusion.rods": 0.5,
         "relaxation.rate": -0.5, "relaxation.saturation": 1.0, "elasticity.stiffness": 1.0, "advection.strength": 0.5,
         "initial.kind": "formula", "time.stepper": "etdrk2", "time.dt": 0.05}
MODELS = ("active-nematic", "brusselator", "cahn-hilliard", "ginzburg-landau", "keller-segel", "swift-hohenberg")
WAYS = {"neither": {"time.max_error": 0.0, "accuracy.effort": 0.0}, "error": {"accuracy.effort": 0.0},
        "error_and_biases": {}}


def instructions_of(folder, scene, keys):
    """Millions of instructions of a whole run.  Valgrind has a small heap: all of it is taken from elsewhere."""
    ended = subprocess.run(["valgrind", "--tool=callgrind", "--callgrind-out-file=/dev/null", DROVER, "run", scene,
                            "--quiet", "--overwrite", "-o", "run.h5", *settings_of(keys)],
                           cwd=folder, check=False, capture_output=True, text=True,
                           env={**os.environ, "MALLOC_TOP_PAD_": str(2**28)})
    if ended.returncode != 0:
        raise RuntimeError(ended.stderr)
    return int(re.search(r"Collected : ([0-9]+)", ended.stderr)[1]) / 1e6


def flock(points, noisy, steps):
    side = float(points)
    keys = {**SCENE, "grid.nx": points, "grid.ny": points, "grid.lx": side, "grid.ly": side,
            "time.end": round(0.05 * steps, 6), "output.sample_every": 0.05 if steps < 100 else 0.25,
            "initial.polar_order_x": f"0.7 + 0.1*sin(2*pi*x/{side})"}
    return keys | ({"noise.order": 0.02, "noise.rods": 0.02} if noisy else {})


def row_of(folder, name, scene, points, steps, keys):
    keys = {**keys, "output.frame_every": 0.0, "run.threads": 1}
    found = {way: instructions_of(folder, scene, {**keys, **more}) for way, more in WAYS.items()}
    return {"scene": name, "points": points, "steps": steps, **{way: f"{one:.1f}" for way, one in found.items()},
            "cost_of_error": f"{(found['error'] - found['neither']) / found['neither']:.3f}",
            "cost_of_biases": f"{(found['error_and_biases'] - found['error']) / found['neither']:.3f}"}


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--points", type=int, default=64)
    parser.add_argument("--steps", type=int, nargs="+", default=(13, 27, 80, 240, 2000))
    parser.add_argument("--models", action="store_true", help="models of models/, as shipped, instead of the flock")
    parser.add_argument("--output", type=Path, required=True)
    options = parser.parse_args()
    table = KeptTable(options.output, COLUMNS)
    known = {(row["scene"], int(row["points"]), int(row["steps"])) for row in table.rows}
    with tempfile.TemporaryDirectory() as folder:
        (Path(folder) / "empty.toml").write_text("")
        for steps in options.steps:
            scenes = [(f"flock{', noise' if noisy else ''}", "empty.toml", options.points,
                       flock(options.points, noisy, steps)) for noisy in (False, True)]
            if options.models:
                scenes = []
                for name in MODELS:
                    path = ROOT / "models" / f"{name}.toml"
                    given = tomllib.loads(path.read_text())
                    keys = {"time.end": round(given["time"]["dt"] * steps, 6)}
                    scenes.append((name, str(path), given["grid"]["nx"], keys))
            for name, scene, points, keys in scenes:
                if (name, points, steps) not in known:
                    table.add(row_of(folder, name, scene, points, steps, keys))
    for row in table.rows:
        print(*(f"{name} {row[name]}" for name in COLUMNS))


if __name__ == "__main__":
    main()
