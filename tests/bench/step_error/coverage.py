"""tests/bench/step_error/coverage.py: how often the true bias of a number by the time step is within the stated one.

Draws short runs, two thirds of them with noise (all forms of the equations, methods, steps of a twentieth to a half of
a second), runs each as given and with an eighth of its step on the same noise path, and compares the difference of
every number of the table with its stated bias: covered where they differ by at most twice the stated uncertainty and
twice the scatter of the difference itself, from eight blocks of the run.  Numbers that the difference of the two runs
does not know to half of the stated uncertainty are not judged.  A bias is unsaid where it is above a tenth of the
number and above twice its stated uncertainty (beyond three times its scatter) while neither a warning nor the table
tells so.

    DROVER=build/release/drover /usr/bin/python3 tests/bench/step_error/coverage.py --scenes 180 --output FILE.csv
    DROVER=build/release/drover /usr/bin/python3 tests/bench/step_error/coverage.py --models --output FILE.csv

--models: the models of models/ that tests/bench/tradeoff/study.py draws, half of them with noise, in place of forms.

Rows that exist are kept: re-run to resume.
"""
import argparse
import json
import os
import random
import subprocess
import sys
import tempfile
from pathlib import Path

import h5py
import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[2]))
from bench.tradeoff.study import MODELS, model_scene  # noqa: E402
from studies import KeptTable, settings_of  # noqa: E402

DROVER = str(Path(os.environ.get("DROVER", "build/release/drover")).absolute())
COLUMNS = ("seed", "scene", "kind", "method", "dt", "steps", "effort", "outcome", "resolved", "judged", "covered",
           "unresolved", "large", "unsaid", "warned", "misses", "settings")
FINER = 8
LARGE = 0.1  # of a number
PRIMARY_ENDINGS = ("_deviation", "_exponent")


def draw(number, seed):
    """Kind and keys of a scene."""
    rng = random.Random(f"{seed}-{number}")
    noisy = number % 3 != 2
    kind = rng.choice(("rods", "rods", "polar", "dynamic", "slaved"))

    def log(low, high):
        return float(f"{low * (high / low) ** rng.random():.3g}")

    keys = {"relaxation.rate": rng.choice((-1.0, -1.0, 1.0)) * log(0.2, 1.5), "relaxation.saturation": log(0.5, 3.0),
            "elasticity.stiffness": log(0.3, 2.0), "run.threads": 1}
    grid = rng.choice(((16, 16), (24, 8), (32, 1)))
    keys |= {"grid.nx": grid[0], "grid.ny": grid[1], "grid.lx": float(grid[0]), "grid.ly": float(grid[1])}
    if kind != "polar":
        keys |= {"uniform.rod_density": 1.0, "current.speed": log(0.3, 1.5), "pressure.rods": log(0.1, 1.0),
                 "diffusion.rods": log(0.2, 1.0), "advection.strength": log(0.1, 1.0)}
    else:
        keys |= {"fields.rod_density": False, "advection.strength": log(0.3, 2.0)}
    if kind in ("dynamic", "slaved"):
        keys |= {"fields.bead_density": True, "fields.bead_velocity": kind, "uniform.bead_density": 1.0,
                 "drag.coefficient": log(2.0, 8.0), "driving.strength": log(0.5, 3.0), "stiffness.beads": log(0.5, 3.0),
                 "diffusion.beads": 0.3, "weathercock.strength": log(0.3, 1.5)}
    method = rng.choice(("etdrk2", "exponential-euler", "etdrk4-krogstad"))
    dt = rng.choice((0.05, 0.1, 0.2, 0.25, 0.5))
    steps = rng.choice((1000, 2000, 4000)) if noisy else rng.choice((100, 200, 400))
    order = max(0.2, (-keys["relaxation.rate"] / keys["relaxation.saturation"])) ** 0.5
    keys |= {"initial.kind": "formula", "time.stepper": method, "time.dt": dt, "time.end": round(dt * steps, 6),
             "output.frame_every": 0.0, "run.seed": number + 1}
    if noisy:
        keys |= {"noise.order": log(3e-3, 0.1), "output.sample_every": dt * 2, "initial.polar_order_x": f"{order:.3g}",
                 "analysis.warm_up": round(dt * steps * 0.1, 6), "accuracy.effort": rng.choice((0.05, 0.05, 0.2))}
        if kind != "polar":
            keys |= {"noise.rods": log(3e-3, 0.1)}
        if kind in ("dynamic", "slaved"):
            keys |= {"noise.beads": log(3e-3, 0.05)}
    else:
        keys |= {"output.sample_every": dt * 2, "analysis.warm_up": 0.0, "accuracy.effort": rng.choice((0.05, 0.2)),
                 "initial.polar_order_x": f"{order * rng.uniform(0.3, 1.2):.3g} + 0.2*sin(2*pi*x/{grid[0]})",
                 "initial.polar_order_y": f"0.2*cos(2*pi*x/{grid[0]})"}
    return kind + (", noise" if noisy else ""), keys


def draw_model(number, seed):
    """Kind, model file and keys of a model of one's own."""
    rng = random.Random(f"model-{seed}-{number}")
    kind, keys, _ = model_scene(10000 * seed + number)
    keys |= {"run.threads": 1, "output.frame_every": 0.0, "accuracy.effort": rng.choice((0.05, 0.2)),
             "time.stepper": rng.choice(("etdrk2", "exponential-euler", "etdrk4-krogstad")),
             "analysis.warm_up": round(0.1 * keys["time.end"], 6) if "noise" in kind else 0.0}
    return kind, MODELS / f"{kind.partition(',')[0]}.toml", keys


def run(folder, name, keys, scene="empty.toml"):
    done = subprocess.run([DROVER, "run", scene, "--json", "--quiet", "--overwrite", "-o", f"{name}.h5",
                           *settings_of(keys)], cwd=folder, check=False, capture_output=True, text=True)
    if done.returncode == 0:
        return json.loads(done.stdout), ""
    return None, (done.stderr.strip().splitlines() or ["no message"])[-1]


def numbers(result):
    """The numbers of a table by name and component."""
    for name, row in result["results"].items():
        for k, one in enumerate(row.get("values", [row])):
            yield (name, k), one


def differences(folder, warm_up, blocks=8):
    """Of each recorded number: the scatter of the difference of the two runs, from blocks after the warm-up."""
    scatter = {}
    with h5py.File(folder / "given.h5") as a, h5py.File(folder / "fine.h5") as b:
        times = a["observables/time"][...]
        late = times >= warm_up * (1.0 - 1e-9)
        for name, data in a["observables"].items():
            if name == "time" or name not in b["observables"] or data.shape[:1] != times.shape:
                continue
            change = (data[...] - b["observables"][name][...])[late]
            change = change.reshape(len(change), -1)
            length = len(change) // blocks
            if length == 0:
                continue
            means = change[:length * blocks].reshape(blocks, length, -1).mean(axis=1)
            for k, error in enumerate(means.std(axis=0, ddof=1) / blocks**0.5):
                scatter[name, k] = error
    return scatter


def add_of_boxes(result, scatter):
    """Scatter of deviations and exponents, which follow from variances."""
    for (name, k), one in numbers(result):
        if name.endswith(PRIMARY_ENDINGS) or "_deviation_" in name or "_exponent_" in name:
            kind = "deviation" if "_deviation" in name else "exponent"
            variance = name.replace(kind, "variance")
            values = result["results"].get(name.replace(kind, "deviation"), {}).get("values", [])
            if kind == "deviation" and (variance, k) in scatter and one["mean"]:
                scatter[name, k] = scatter[variance, k] / (2.0 * one["mean"])
            elif (variance, k + 1) in scatter and k + 1 < len(values):
                count = result["results"][name.replace("_exponent", "")]["values"]
                ratio = np.log(count[k + 1]["mean"] / count[k]["mean"])
                scatter[name, k] = np.hypot(*(scatter[variance, n] / values[n]["mean"]**2
                                              for n in (k, k + 1))) / (2.0 * ratio)


def judge(number, seed, folder, models=False):
    scene = "empty.toml"
    if models:
        kind, scene, keys = draw_model(number, seed)
    else:
        kind, keys = draw(number, seed)
    noisy = "noise" in kind
    row = {"seed": seed, "scene": number, "kind": kind, "method": keys["time.stepper"], "dt": keys["time.dt"],
           "steps": round(keys["time.end"] / keys["time.dt"]), "effort": keys["accuracy.effort"],
           "settings": json.dumps(keys)}
    given, message = run(folder, "given", keys, scene)
    if given is None:
        return {**row, "outcome": message[:200]}
    fine_keys = {**keys, "time.dt": keys["time.dt"] / FINER, "accuracy.effort": 0.0}
    if not noisy:
        fine_keys |= {"time.stepper": "etdrk4-krogstad"}
    fine, message = run(folder, "fine", fine_keys, scene)
    if fine is None:
        return {**row, "outcome": "no truth: " + message[:200]}
    scatter = differences(folder, keys["analysis.warm_up"])
    if noisy:
        add_of_boxes(given, scatter)
    exact = dict(numbers(fine))
    warned = any("time.dt" in warning or "time step" in warning for warning in given["warnings"])
    counts = dict.fromkeys(("resolved", "judged", "covered", "unresolved", "large"), 0)
    misses, unsaid = [], []
    for (name, k), one in numbers(given):
        other = exact[name, k]
        if name.startswith(("spectral_tail_", "step_error")) or one["mean"] is None or other["mean"] is None:
            continue
        true, bias, error = one["mean"] - other["mean"], one.get("step_bias"), one.get("step_bias_error")
        spread = scatter.get((name, k), np.nan) if noisy else 1e-12 * abs(one["mean"])
        size = max(abs(other["mean"]), 1e-12)
        is_resolved = bias is not None and error is not None
        counts["resolved" if is_resolved else "unresolved"] += 1
        if is_resolved and spread <= max(error, 1e-300) / 2.0 or is_resolved and not noisy:
            counts["judged"] += 1
            if abs(true - bias) <= 2.0 * error + 2.0 * spread:
                counts["covered"] += 1
            else:
                misses.append(f"{name}[{k}]: {bias:.2g} +- {error:.1g}, true {true:.2g} +- {spread:.1g} of {size:.2g}")
        own = one["error"] or 0.0
        if abs(true) - 3.0 * spread > LARGE * size and size > 10.0 * own:
            counts["large"] += 1
            said = warned or is_resolved and abs(bias) >= 0.5 * abs(true)
            if not said and not (is_resolved and abs(true - bias) <= 2.0 * error):
                unsaid.append(f"{name}[{k}]: {true / size:.2g}" + ("" if is_resolved else " not resolved"))
    return {**row, **counts, "outcome": "run", "unsaid": len(unsaid), "warned": warned,
            "misses": "; ".join(misses[:6] + ["UNSAID " + one for one in unsaid[:4]])}


def summary(rows):
    for noise in (True, False):
        some = [row for row in rows if row["outcome"] == "run" and ("noise" in row["kind"]) == noise]
        total = {name: sum(int(row[name]) for row in some)
                 for name in ("resolved", "judged", "covered", "unresolved", "large", "unsaid")}
        part = total["covered"] / max(1, total["judged"])
        print(f"{'noisy' if noise else 'without noise'}: {len(some)} runs; numbers: {total}; covered {part:.3f}; "
              f"runs with an unsaid bias: {sum(int(row['unsaid']) > 0 for row in some)}")
    print("no result:", sum(row["outcome"] != "run" for row in rows))


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--scenes", type=int, default=180)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--models", action="store_true", help="models of one's own")
    parser.add_argument("--only", choices=("noisy", "without-noise"))
    parser.add_argument("--output", type=Path, required=True)
    options = parser.parse_args()
    table = KeptTable(options.output, COLUMNS)
    known = {(int(row["seed"]), int(row["scene"])) for row in table.rows}
    with tempfile.TemporaryDirectory() as name:
        (Path(name) / "empty.toml").write_text("")
        for number in range(options.scenes):
            kind = "without-noise" if number % 3 == 2 else "noisy"
            if (options.seed, number) not in known and options.only in (None, kind):
                table.add(judge(number, options.seed, Path(name), options.models))
    summary([row for row in table.rows if int(row["seed"]) == options.seed])


if __name__ == "__main__":
    main()
