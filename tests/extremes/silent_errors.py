"""tests/extremes/silent_errors.py: how often a run is wrong by a tenth in silence, and how often a warning is false.

Draws scenes of fields that are hard for the time step or the grid (one step, dt at the interval of outputs, all
methods, forces of x and t between the points and steps, weak waves on a flock, starts in an unstable state), runs each,
and compares its fields at every step with those of steps of etdrk4-krogstad 64 times shorter, on twice the points where
a text of x acts.  An error is relative to the deviation of the fields from their mean over cell and time.

    DROVER=build/release/drover /usr/bin/python3 tests/extremes/silent_errors.py --scenes 200 --seed 1 --output FILE.csv
"""
import argparse
import csv
import json
import os
import random
import re
import subprocess
import tempfile
from pathlib import Path

import h5py
import numpy as np

DROVER = str(Path(os.environ.get("DROVER", "build/release/drover")).absolute())
FIELDS = (("bead_density",), ("rod_density",), ("bead_velocity_x", "bead_velocity_y"),
          ("polar_order_x", "polar_order_y"))
FIXED = ("exponential-euler", "etdrk2", "etdrk4", "etdrk4-krogstad", "etd-abm3", "etd-abm4", "etd-abm5",
         "arkode-ark436l2sa")
CONTROLLED = ("etdrk2", "etdrk4-krogstad", "cvode-bdf", "cvode-adams", "arkode-ark437l2sa")
LARGE = 0.1  # an error


def rounded(value):
    """Two digits, as a user writes numbers."""
    return float(f"{value:.2g}")


def draw(number, seed):
    """A scene: its kind, sections, and texts of a force on the order."""
    rng = random.Random(f"{seed}-{number}")
    kind = ("one step", "outputs", "force of t", "force of x", "weak wave", "unstable start", "long steps")[number % 7]
    rate = -rounded(rng.uniform(0.3, 2.0))
    keys = {"uniform": {"rod_density": 1.0}, "current": {"speed": rounded(rng.uniform(0.0, 2.0))},
            "pressure": {"rods": rounded(rng.uniform(0.1, 1.0))}, "diffusion": {"rods": rounded(rng.uniform(0.1, 1.0))},
            "relaxation": {"rate": rate, "saturation": rounded(rng.uniform(0.5, 3.0))},
            "elasticity": {"stiffness": rounded(rng.uniform(0.3, 1.0))},
            "advection": {"strength": rounded(rng.uniform(0.0, 1.0))},
            "grid": {"nx": 32, "ny": 4, "lx": 16.0, "ly": 2.0},
            "initial": {"kind": "formula", "polar_order_x": f"{rounded(rng.uniform(0.05, 0.8))} + 0.05*sin(2*pi*x/16)",
                        "polar_order_y": "0.05*cos(2*pi*x/16)"}}
    steps, dt = rng.randint(20, 100), rounded(rng.uniform(0.02, 0.2))
    time = {"stepper": rng.choice(FIXED)}
    force = None
    if kind == "one step":
        steps, dt = 1, rounded(rng.uniform(0.5, 6.0))
    elif kind == "outputs":
        steps, dt = rng.randint(1, 5), rounded(rng.uniform(1.0, 10.0))
        time = {"stepper": rng.choice(CONTROLLED), "tolerance": rounded(10 ** rng.uniform(-6.0, -1.0))}
    elif kind == "force of t":
        at = rounded(steps * dt * rng.uniform(0.3, 0.7))
        frequency = rounded(2.0 * np.pi / dt * rng.uniform(0.05, 1.1))
        force = rng.choice((f"{rounded(rng.uniform(0.2, 2.0))}*sin({frequency}*t)",
                            f"0.5*sin(pi*t/{dt})^2", f"2*exp(-(t-{at})^2/(2*{rounded(dt * rng.uniform(0.1, 4.0))}^2))",
                            f"0.5*step(t-{at})"))
    elif kind == "force of x":
        wave = rng.choice((rng.randint(1, 8), rng.randint(16, 40)))
        force = rng.choice((f"0.5*cos(2*pi*{wave}*x/16)",
                            f"exp(-(x-8.1)^2/(2*{rounded(rng.uniform(0.05, 2.0))}^2))", "0.3*step(x-8)"))
    elif kind == "weak wave":
        order = rounded((-rate / keys["relaxation"]["saturation"]) ** 0.5)
        size = rounded(10 ** rng.uniform(-5.0, -2.0))
        keys["initial"] = {"kind": "formula", "rod_density": f"1 + {size}*cos(2*pi*x/16)", "polar_order_x": str(order)}
    elif kind == "unstable start":
        keys["initial"] = rng.choice(({"kind": "uniform"}, {"kind": "random", "amplitude": 1e-6},
                                      {"kind": "random", "amplitude": 0.01}))
    else:
        dt = rounded(rng.uniform(0.2, 0.8))
    end = float(f"{steps * dt:.9g}")
    keys["time"] = {"dt": dt, "end": end, **time}
    keys["output"] = {"sample_every": dt, "frame_every": dt}
    return kind, keys, force


def run(folder, name, keys, force):
    """Runs a scene: its result, or None where it ends with an error."""
    lines = [line for section, values in keys.items()
             for line in (f"[{section}]", *(f"{key} = {json.dumps(value)}" for key, value in values.items()))]
    if force:
        lines += ["[[terms]]", 'of = "order"', f'value = ["{force}", "0"]']
    (folder / f"{name}.toml").write_text("\n".join(lines) + "\n")
    done = subprocess.run([DROVER, "run", f"{name}.toml", "--json", "--quiet", "--overwrite"], cwd=folder, check=False,
                          capture_output=True, text=True)
    return json.loads(done.stdout) if done.returncode == 0 else None


def error_of(archive, exact, coarser):
    """The largest error of a field at any frame, over its fluctuation."""
    worst = 0.0
    with h5py.File(archive) as a, h5py.File(exact) as b:
        for group in FIELDS:
            if group[0] not in a:
                continue
            true = [b[name][:, :, ::coarser] for name in group]
            wrong = max(sum((a[name][...] - field)**2 for name, field in zip(group, true)).mean(axis=(1, 2)))
            spread = sum(field.var() for field in true)
            size = max(spread, 1e-10 * max((field**2).mean() for field in true), 1e-300)
            worst = max(worst, (wrong / size)**0.5 if wrong > 1e-24 else 0.0)
    return min(worst, 1e6)


def said(warnings):
    """The largest error that warnings state; 1 where they state none."""
    numbers = [float(found[1]) for warning in warnings
               if (found := re.search(r"(?:error is|wrong by) ([0-9.e+-]+[0-9])", warning))]
    return max(numbers, default=1.0)


def judge(number, seed, folder):
    """One row of the table."""
    kind, keys, force = draw(number, seed)
    result = run(folder, "given", keys, force)
    row = {"scene": number, "kind": kind, "method": keys["time"]["stepper"], "dt": keys["time"]["dt"],
           "force": force or ""}
    if result is None:
        return {**row, "outcome": "stopped", "error": "", "said": "", "warning": ""}
    fine = json.loads(json.dumps(keys))
    parts = 64 if keys["time"]["dt"] < 1.0 else 512
    fine["time"] = {"dt": keys["time"]["dt"] / parts, "end": keys["time"]["end"], "stepper": "etdrk4-krogstad"}
    fine["accuracy"] = {"effort": 0.0}
    coarser = 4 if kind == "force of x" else 1
    fine["grid"]["nx"] *= coarser
    if kind == "unstable start" and keys["initial"]["kind"] == "uniform":
        growth = -keys["relaxation"]["rate"] * keys["time"]["end"]
        error = 1.0 if growth > 1.0 else 0.0  # it stays in a state that any perturbation leaves
    else:
        run(folder, "exact", fine, force)
        error = error_of(folder / "given.h5", folder / "exact.h5", coarser)
    warnings = result["warnings"]
    claimed = said(warnings) if warnings else 0.0
    if error > LARGE:
        outcome = "warned" if warnings else "silent"
    else:
        outcome = "false alarm" if error < 0.1 * claimed else "warned, right" if warnings else "right"
    return {**row, "outcome": outcome, "error": f"{error:.3g}", "said": f"{claimed:.3g}",
            "warning": warnings[0][:100] if warnings else ""}


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--scenes", type=int, default=200)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--output", type=Path, required=True)
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder, options.output.open("w", newline="") as file:
        table = None
        counts = {}
        for number in range(options.scenes):
            row = judge(number, options.seed, Path(folder))
            if table is None:
                table = csv.DictWriter(file, row.keys(), lineterminator="\n")
                table.writeheader()
            table.writerow(row)
            file.flush()
            counts[row["outcome"]] = counts.get(row["outcome"], 0) + 1
    print(f"{options.scenes} scenes, seed {options.seed}:",
          ", ".join(f"{count} {name}" for name, count in sorted(counts.items())))


if __name__ == "__main__":
    main()
