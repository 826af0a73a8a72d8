"""tests/extremes/silent_errors.py: how often a run is wrong by a tenth in silence, and how often a warning is false.

Draws small scenes of fields that are hard for the time step or the grid: one step, dt at the interval of outputs, all
methods, forces of x and t between points and steps, weak waves on a flock, drifting means, starts in an unstable state,
ramps through onset, texts without a derivative, beads that flow, and scenes without a step.  Each is run, and its
fields at every output and its means of variances are compared with those of steps of etdrk4-krogstad 64 times shorter
on twice the points (4 times where a text of x acts).  The error of a field is relative to its deviation from its mean
over cell and time.  A ramp, or a uniform start, that ends in an unstable state far below its saturation counts as wrong
by 1.

    DROVER=build/release/drover /usr/bin/python3 tests/extremes/silent_errors.py --scenes 200 --seed 1 --output FILE.csv

Outcomes: right; warned (wrong, and a warning); silent (wrong by more than a tenth, and no warning); false alarm (the
error is below a tenth of the one that the warnings give, 1 where they give none); warned, right (a warning of an error
below a tenth); stopped (an error that ends the run); undecided (the finer run fails).  Rows that exist are kept: re-run
to resume.
"""
import argparse
import collections
import json
import os
import random
import re
import subprocess
import sys
import tempfile
from pathlib import Path

import h5py
import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
from studies import KeptTable  # noqa: E402

DROVER = str(Path(os.environ.get("DROVER", "build/release/drover")).absolute())
FIELDS = (("bead_density",), ("rod_density",), ("bead_velocity_x", "bead_velocity_y"),
          ("polar_order_x", "polar_order_y"))
FIXED = ("exponential-euler", "etdrk2", "etdrk4", "etdrk4-krogstad", "etd-abm3", "etd-abm4", "etd-abm5",
         "arkode-ark436l2sa")
CONTROLLED = ("etdrk2", "etdrk4-krogstad", "cvode-bdf", "cvode-adams", "arkode-ark437l2sa")
KINDS = ("one step", "outputs", "force of t", "force of x", "weak wave", "unstable start", "long steps", "kink", "ramp",
         "drift", "beads", "no step")
LARGE = 0.1  # an error
COLUMNS = ("seed", "scene", "kind", "method", "dt", "text", "outcome", "error", "of", "said", "message")
SIZE = "sqrt(order_x^2 + order_y^2)"


def rounded(value):
    """Two digits, as a user writes numbers."""
    return float(f"{value:.2g}")


def draw(number, seed):
    """A scene: its kind, sections, and the two texts of a term of the order."""
    rng = random.Random(f"{seed}-{number}")
    kind = KINDS[number % len(KINDS)]
    rate = -rounded(rng.uniform(0.3, 2.0))
    saturation = rounded(rng.uniform(0.5, 3.0))
    keys = {"uniform": {"rod_density": 1.0}, "current": {"speed": rounded(rng.uniform(0.0, 2.0))},
            "pressure": {"rods": rounded(rng.uniform(0.1, 1.0))}, "diffusion": {"rods": rounded(rng.uniform(0.1, 1.0))},
            "relaxation": {"rate": rate, "saturation": saturation},
            "elasticity": {"stiffness": rounded(rng.uniform(0.3, 1.0))},
            "advection": {"strength": rounded(rng.uniform(0.0, 1.0))},
            "grid": {"nx": 32, "ny": 4, "lx": 16.0, "ly": 2.0},
            "initial": {"kind": "formula", "polar_order_x": f"{rounded(rng.uniform(0.05, 0.8))} + 0.05*sin(2*pi*x/16)",
                        "polar_order_y": "0.05*cos(2*pi*x/16)"}}
    steps, dt = rng.randint(20, 100), rounded(rng.uniform(0.02, 0.2))
    time = {"stepper": rng.choice(FIXED)}
    order = rounded((-rate / saturation) ** 0.5)
    size = rounded(10 ** rng.uniform(-5.0, -2.0))
    force = None
    if kind == "one step":
        steps, dt = 1, rounded(10 ** rng.uniform(-1.0, 0.8))
    elif kind == "outputs":
        steps, dt = rng.randint(1, 5), rounded(rng.uniform(1.0, 10.0))
        time = {"stepper": rng.choice(CONTROLLED), "tolerance": rounded(10 ** rng.uniform(-6.0, -1.0))}
    elif kind == "force of t":
        at = rounded(steps * dt * rng.uniform(0.3, 0.7))
        frequency = rounded(2.0 * np.pi / dt * rng.uniform(0.05, 1.1))
        force = (rng.choice((f"{rounded(rng.uniform(0.2, 2.0))}*sin({frequency}*t)", f"0.5*sin(pi*t/{dt})^2",
                             f"2*exp(-(t-{at})^2/(2*{rounded(dt * rng.uniform(0.1, 4.0))}^2))",
                             f"0.5*step(t-{at})")), "0")
    elif kind == "force of x":
        wave = rng.choice((rng.randint(1, 8), rng.randint(16, 40)))
        force = (rng.choice((f"0.5*cos(2*pi*{wave}*x/16)",
                             f"exp(-(x-8.1)^2/(2*{rounded(rng.uniform(0.05, 2.0))}^2))", "0.3*step(x-8)")), "0")
    elif kind == "weak wave":
        keys["initial"] = {"kind": "formula", "rod_density": f"1 + {size}*cos(2*pi*x/16)", "polar_order_x": str(order)}
    elif kind == "unstable start":
        keys["initial"] = rng.choice(({"kind": "uniform"}, {"kind": "random", "amplitude": 1e-6},
                                      {"kind": "random", "amplitude": 0.01}))
    elif kind == "long steps":
        dt = rounded(rng.uniform(0.2, 0.8))
    elif kind == "kink":
        strength = rounded(rng.uniform(0.2, 2.0))
        part = rng.choice((f"-{strength}*{SIZE}*order_{{}}", f"{strength}*order_{{}}/{SIZE}",
                           f"-{strength}*order_{{}}/sqrt({SIZE})", f"-{strength}*abs(order_{{}})*order_{{}}"))
        force = tuple(part.replace("{}", axis) for axis in "xy")
        if rng.random() < 0.3:
            keys["initial"] = {"kind": "random", "amplitude": rounded(10 ** rng.uniform(-4.0, -1.0))}
        dt *= rng.choice((1.0, 4.0))
    elif kind == "ramp":
        keys["relaxation"]["rate"] = rounded(rng.uniform(0.3, 1.0))
        steps, dt = rng.randint(40, 100), rounded(rng.uniform(0.1, 0.3))
        ramp = rounded((keys["relaxation"]["rate"] + rng.uniform(0.3, 2.0)) / (steps * dt))
        force = tuple(f"{ramp}*t*order_{axis}" for axis in "xy")
        keys["initial"] = {"kind": "random", "amplitude": rounded(10 ** rng.uniform(-6.0, -1.0))}
    elif kind == "drift":
        keys["initial"] = {"kind": "formula", "rod_density": f"1 + {size}*cos(2*pi*x/16)",
                           "polar_order_x": str(rounded(0.5 * order))}
        force = rng.choice(((str(rounded(rng.uniform(0.1, 1.0))), "0"), (f"{rounded(0.3 / (steps * dt))}*t", "0"),
                            ("-0.7*order_y", "0.7*order_x")))
        dt *= rng.choice((1.0, 3.0))
    elif kind == "beads":
        velocity = rng.choice(("dynamic", "slaved"))
        keys |= {"fields": {"bead_density": True, "bead_velocity": velocity},
                 "uniform": {"rod_density": 1.0, "bead_density": 1.0},
                 "drag": {"coefficient": rounded(10 ** rng.uniform(0.0, 1.5))},
                 "driving": {"strength": rounded(rng.uniform(0.5, 3.0))},
                 "stiffness": {"beads": rounded(10 ** rng.uniform(0.0, 2.0))},
                 "viscosity": {"shear": rounded(rng.uniform(0.5, 2.0))},
                 "weathercock": {"strength": rounded(rng.uniform(0.5, 2.0))},
                 "diffusion": {"rods": 0.5, "beads": 0.5}}
        if velocity == "slaved":
            keys.pop("viscosity")
    elif kind == "no step":
        time, steps, dt = {}, rng.randint(10, 40), rounded(rng.uniform(0.1, 1.0))
        if rng.random() < 0.5:
            keys["initial"] = {"kind": "random", "amplitude": 0.05}
        if rng.random() < 0.3:
            time = {"stepper": rng.choice(FIXED[:4])}
    dt = float(f"{dt:.9g}")
    keys["time"] = {"end": float(f"{steps * dt:.9g}"), **time}
    if kind != "no step":
        keys["time"]["dt"] = dt
    keys["output"] = {"sample_every": dt, "frame_every": dt}
    keys["analysis"] = {"warm_up": 0.0}
    return kind, keys, force


def run(folder, name, keys, force):
    """Runs a scene: its result, or the last line of its message."""
    lines = [line for section, values in keys.items()
             for line in (f"[{section}]", *(f"{key} = {json.dumps(value)}" for key, value in values.items()))]
    if force:
        lines += ["[[terms]]", 'of = "order"', f"value = {json.dumps(force)}"]
    (folder / f"{name}.toml").write_text("\n".join(lines) + "\n")
    done = subprocess.run([DROVER, "run", f"{name}.toml", "--json", "--quiet", "--overwrite", "--threads", "1"],
                          cwd=folder, check=False, capture_output=True, text=True)
    if done.returncode == 0:
        return json.loads(done.stdout), ""
    return None, (done.stderr.strip().splitlines() or ["no message"])[-1]


def finer(kind, keys):
    """The scene with shorter steps and more points, and how many of these along x are one of the scene."""
    fine = json.loads(json.dumps(keys))
    parts = 64 if keys["output"]["frame_every"] < 1.0 else 512
    fine["time"] = {"dt": keys["output"]["frame_every"] / parts, "end": keys["time"]["end"],
                    "stepper": "etdrk4-krogstad", "max_error": 0.0}
    coarser = 4 if kind == "force of x" else 2
    if keys["initial"]["kind"] == "random":
        coarser = 1  # the waves of such a start are those of the grid
    fine["grid"]["nx"] *= coarser
    return fine, coarser


def field_error(archive, exact, coarser):
    """The largest error of a field at any frame, over its fluctuation, and the field."""
    worst = (0.0, "")
    with h5py.File(archive) as a, h5py.File(exact) as b:
        for group in FIELDS:
            if group[0] not in a:
                continue
            true = [b[name][:, :, ::coarser] for name in group]
            wrong = max(sum((a[name][...] - field)**2 for name, field in zip(group, true)).mean(axis=(1, 2)))
            spread = sum(field.var() for field in true)
            size = max(spread, 1e-10 * max((field**2).mean() for field in true), 1e-300)
            worst = max(worst, ((wrong / size)**0.5 if wrong > 1e-24 else 0.0, group[0]))
    return min(worst[0], 1e6), worst[1]


def variance_error(result, exact):
    """The largest relative error of the mean of a variance, and its name."""
    worst = (0.0, "")
    for name, row in exact["results"].items():
        if name.startswith("variance_") and row["mean"] is not None and row["mean"] > 1e-14:
            found = result["results"][name]["mean"]
            error = 1e6 if found is None else abs(found - row["mean"]) / row["mean"]
            worst = max(worst, (error, name))
    return worst


def is_far_below_saturation(keys, force, folder):
    """Whether order should have grown by a factor e^0.5 or more, and is below a tenth of its size at the end."""
    rates = np.full(101, -keys["relaxation"]["rate"])
    if force:  # a ramp
        rates = rates + float(force[0].split("*")[0]) * np.linspace(0.0, keys["time"]["end"], 101)
    if rates[-1] <= 0.0:
        return False
    exponent = rates[rates > 0.0].mean() * (rates > 0.0).mean() * keys["time"]["end"]
    with h5py.File(folder / "given.h5") as file:
        size = np.sqrt(sum((file[name][-1]**2).mean() for name in FIELDS[3]))
    return exponent > 0.5 and size < 0.1 * (rates[-1] / keys["relaxation"]["saturation"])**0.5


def said(warnings):
    """The largest error that warnings state; 1 where they state none."""
    numbers = [float(found[1]) for warning in warnings
               if (found := re.search(r"(?:error is|error of the rate of \S+ is|wrong by) ([0-9.e+-]+[0-9])", warning))]
    return max(numbers, default=1.0)


def judge(number, seed, folder):
    """One row of the table."""
    kind, keys, force = draw(number, seed)
    result, message = run(folder, "given", keys, force)
    row = {"seed": seed, "scene": number, "kind": kind, "method": keys["time"].get("stepper", ""),
           "dt": keys["time"].get("dt", ""), "text": force[0] if force else ""}
    if result is None:
        return {**row, "outcome": "stopped", "message": message[:300]}
    fine, coarser = finer(kind, keys)
    exact, message = run(folder, "exact", fine, force)
    if exact is None:
        return {**row, "outcome": "undecided", "message": message[:300]}
    error, of = max(field_error(folder / "given.h5", folder / "exact.h5", coarser), variance_error(result, exact))
    if (kind == "ramp" or keys["initial"]["kind"] == "uniform") and is_far_below_saturation(keys, force, folder):
        error, of = max((error, of), (1.0, "state"))
    warnings = result["warnings"]
    claimed = said(warnings) if warnings else 0.0
    if error > LARGE:
        outcome = "warned" if warnings else "silent"
    else:
        outcome = "false alarm" if error < 0.1 * claimed else "warned, right" if warnings else "right"
    return {**row, "outcome": outcome, "error": f"{error:.3g}", "of": of, "said": f"{claimed:.3g}",
            "message": warnings[0][:300] if warnings else ""}


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--scenes", type=int, default=200)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--only", choices=KINDS, help="scenes of one kind")
    parser.add_argument("--output", type=Path, required=True)
    options = parser.parse_args()
    table = KeptTable(options.output, COLUMNS)
    known = {(int(row["seed"]), int(row["scene"])) for row in table.rows}
    with tempfile.TemporaryDirectory() as folder:
        for number in range(options.scenes):
            if (options.seed, number) not in known and options.only in (None, KINDS[number % len(KINDS)]):
                table.add(judge(number, options.seed, Path(folder)))
    counts = collections.Counter(row["outcome"] for row in table.rows if int(row["seed"]) == options.seed)
    print(f"seed {options.seed}: {sum(counts.values())} scenes:",
          ", ".join(f"{count} {name}" for name, count in sorted(counts.items())))


if __name__ == "__main__":
    main()
