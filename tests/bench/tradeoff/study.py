#!/usr/bin/python3
"""tests/bench/tradeoff/study.py: what drover tradeoff recommends, against finer runs and an exhaustive search.

    study.py --drover PROGRAM --output FOLDER [--count N] [--first N]

draws scenes (number n is the same for everyone): without noise, with noise, and every fifteenth of particles; from
number 100 on, of the models of models/, even ones without noise.  For wishes of 10, 1 and 0.1 per cent of a time mean
it asks `drover tradeoff` for the cheapest run, makes that run, and compares its mean with that of a reference: the full
model by etdrk4-krogstad with a tenth of the step and twice the points along each axis; with noise a quarter of the
step, and the same points where the study says that they are part of the model; for particles 0.4 of the step and four
times the duration.  A search over methods, steps and grids of the full model, with the shortest duration that suffices,
gives the cheapest run that meets the wish.  Costs are core seconds of whole processes.  FOLDER/study.csv has a row for
each wish; rows that exist are kept: re-run to resume.
"""
import argparse
import json
import math
import os
import random
import sys
import tempfile
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[2]))
from studies import KeptTable, settings_of, timed  # noqa: E402

MODELS = Path(__file__).resolve().parents[3] / "models"
COLUMNS = ("scene", "kind", "observable", "wish", "outcome", "mean", "reference", "reference_error", "allowed", "error",
           "meets", "cost", "cheapest", "ratio", "trials", "production", "recommended", "cheapest_run", "settings")
WISHES = (0.1, 0.01, 0.001)
LONGEST = 1800.0  # s, of a process
REFERENCE_SECONDS = 20.0  # of a core, for a reference with statistical errors


def field_scene(number):
    draw = random.Random(31415 + number)
    log = lambda low, high: math.exp(draw.uniform(math.log(low), math.log(high)))  # noqa: E731
    noisy = number % 2 == 1
    kind = draw.choice(["order", "order with density", "dynamic", "slaved"])
    points = draw.choice([16, 24] if noisy else [48, 64])
    length = 16.0
    keys = {"grid.nx": points, "grid.ny": points, "grid.lx": length, "grid.ly": length, "run.seed": number,
            "relaxation.rate": -log(0.2, 1.0), "relaxation.saturation": log(0.5, 2.0),
            "elasticity.stiffness": log(0.3, 1.5), "advection.strength": draw.choice([0.0, log(0.1, 0.8)]),
            "current.speed": log(0.3, 1.2), "diffusion.rods": log(0.1, 0.5)}
    if kind == "order":
        keys["current.kind"] = "order"
    else:
        keys["pressure.rods"] = log(0.1, 0.8)
    if kind in ("dynamic", "slaved"):
        keys |= {"fields.bead_density": True, "fields.bead_velocity": kind, "drag.coefficient": log(1.0, 10.0),
                 "driving.strength": log(0.5, 4.0), "stiffness.beads": log(0.5, 4.0), "diffusion.beads": log(0.1, 0.5),
                 "weathercock.strength": log(0.2, 1.5), "viscosity.shear": log(0.3, 2.0),
                 "relaxation.rate": draw.choice([-1.0, 1.0]) * log(0.1, 0.5)}
        if kind == "dynamic":
            keys["inertia.bead_mass"] = log(0.1, 1.0)
    dt = draw.choice([0.02, 0.05, 0.1])
    steps = draw.choice([400, 800])
    keys |= {"time.dt": dt, "time.end": round(dt * steps, 6), "output.sample_every": dt * 2}
    if noisy:
        keys |= {"noise.order": log(1e-4, 3e-2), "noise.rods": log(1e-4, 1e-2), "time.end": 400.0}
    else:
        keys |= {"initial.kind": "formula", "analysis.warm_up": 0.0} | {
            f"initial.polar_order_{axis}":
                f"{draw.uniform(0.1, 0.4):.3f} * sin(2*pi*({draw.randint(0, 2)}*x + {draw.randint(0, 2)}*y)/16 + "
                f"{draw.uniform(0, 6):.2f}) + {draw.uniform(-0.6, 0.6):.3f}" for axis in "xy"}
    keys["output.frame_every"] = keys["time.end"]
    wanted = ["polar_order", "variance_rod_density"]
    if kind in ("dynamic", "slaved"):
        wanted += ["variance_bead_density", "variance_bead_velocity"]
    observable = draw.choice(wanted)
    if kind == "slaved" and observable == "variance_bead_velocity":
        observable = "variance_bead_density"  # a slaved velocity has no variance of its own
    return kind + (", noise" if noisy else ""), keys, observable


def particle_scene(number):
    draw = random.Random(27182 + number)
    keys = {"cell.lx": 8.0, "cell.ly": 8.0, "beads.area_fraction": draw.choice([0.3, 0.5]), "run.seed": number,
            "time.dt": 2e-5, "time.end": 4.0, "plates.amplitude": draw.choice([0.03, 0.04]),
            "output.sample_every": 0.0125, "output.frame_every": 4.0}
    if draw.random() < 0.5:
        keys["rods.count"] = 2
    return "particles", keys, draw.choice(["bead_temperature_horizontal", "bead_speed"])


FIRST_OF_MODELS = 100
# A model of the shelf: its components with their means, ranges of coefficients, points, distance of points, step, end,
# and the numbers that may be wanted.
SHELF = {
    "burgers": ({"velocity": 0.0}, {"nu": (0.05, 0.2)}, [(64, 1), (128, 1)], None, 0.01, 4.0,
                ["variance_velocity", "max_velocity"]),
    "swift-hohenberg": ({"pattern": 0.0}, {"r": (0.1, 0.5)}, [(32, 32), (48, 48)], math.pi / 4.0, 0.1, 50.0,
                        ["variance_pattern"]),
    "cahn-hilliard": ({"composition": 0.0}, {"kappa": (0.7, 1.5)}, [(32, 32), (48, 48)], 0.75, 0.1, 40.0,
                      ["variance_composition"]),
    "keller-segel": ({"cells": 1.0}, {"chi": (2.8, 3.5)}, [(32, 32), (48, 48)], 0.5, 0.05, 20.0,
                     ["variance_cells", "max_cells"]),
    "brusselator": ({"activator": 3.0, "inhibitor": 3.0}, {"b": (7.0, 9.5)}, [(32, 32), (48, 48)], 0.75, 0.025, 10.0,
                    ["variance_activator", "mean_inhibitor"]),
    "ginzburg-landau": ({"amplitude_re": 0.5, "amplitude_im": 0.0}, {"b": (0.2, 0.6)}, [(32, 32), (48, 48)], 0.75, 0.05,
                        20.0, ["variance_amplitude_re"]),
    "model-b, noise": ({}, {"T": (0.02, 0.2), "r": (0.3, 1.0), "u": (0.1, 1.0)}, [(16, 16), (24, 24)], 0.75, 0.1, 400.0,
                       ["variance_composition"]),
    "kpz, noise": ({}, {"lambda": (0.3, 2.0), "D": (0.2, 1.0)}, [(32, 1), (64, 1)], 1.0, 0.1, 400.0,
                   ["variance_height"]),
    "active-model-b, noise": ({}, {"D": (0.02, 0.1), "lambda": (0.3, 0.8), "phi0": (-1.2, -1.0)}, [(16, 16), (24, 24)],
                              0.75, 0.05, 400.0, ["variance_composition"]),
    "swift-hohenberg, noise": ({}, {"r": (-0.3, -0.1), "field[1].noise": (0.01, 0.1)}, [(16, 16), (24, 24)],
                               math.pi / 4.0, 0.1, 400.0, ["variance_pattern"]),
    "keller-segel, noise": ({}, {"chi": (1.0, 2.0), "field[1].noise": (1e-4, 1e-3)}, [(16, 16), (24, 24)], 0.75, 0.05,
                            400.0, ["variance_cells"]),
}


def model_scene(number):
    """The name of a model file, with its keys.  Starts are formulas, which are the same on every grid."""
    draw = random.Random(16180 + number)
    noisy = number % 2 == 1
    kind = draw.choice([name for name in SHELF if name.endswith("noise") == noisy])
    means, coefficients, sizes, distance, dt, end, wanted = SHELF[kind]
    nx, ny = draw.choice(sizes)
    lx, ly = (nx * distance, ny * distance) if distance else (2.0 * math.pi, 1.0)
    keys = {"grid.nx": nx, "grid.ny": ny, "grid.lx": lx, "grid.ly": ly, "time.dt": dt, "time.end": end,
            "time.stepper": "etdrk2", "output.sample_every": 2 * dt, "output.frame_every": end, "run.seed": number,
            "initial.amplitude": 0.0, "initial.kind": "uniform" if noisy else "formula"}
    if "field[1].noise" in coefficients and kind.startswith("keller-segel"):
        keys["field[1].conserved_noise"] = True
    for name, (low, high) in coefficients.items():
        key = name if "." in name else f"coefficients.{name}"
        keys[key] = draw.uniform(low, high)
    if not noisy:
        keys["analysis.warm_up"] = 0.0
        for name, mean in means.items():
            wave = f"{draw.randint(1, 2)} * x / lx + {draw.randint(0, 2) if ny > 1 else 0} * y / ly"
            keys[f"initial.{name}"] = (f"{mean} + {draw.uniform(0.1, 0.4):.3f} * sin(2 * pi * ({wave}) + "
                                       f"{draw.uniform(0, 6):.2f}) + {draw.uniform(0.02, 0.1):.3f} * "
                                       f"cos(2 * pi * {draw.randint(2, 4)} * x / lx)")
    return kind, keys, draw.choice(wanted)


def scene(number):
    if number >= FIRST_OF_MODELS:
        return model_scene(number)
    return particle_scene(number) if number % 15 == 14 else field_scene(number)


class Bench:
    def __init__(self, program, folder, keys, observable, text=""):
        self.program, self.folder, self.keys, self.observable = program, folder, keys, observable
        self.given = folder / "scene.toml"
        self.given.write_text(text)

    def run(self, scene, keys):
        """Mean, its error, correlation time and cost of a run; None where it fails."""
        archive = self.folder / "run.h5"
        ended, seconds = timed(self.program, "run", scene, "--quiet", "--overwrite", "--json",
                               *settings_of({**keys, "output.file": str(archive), "run.threads": 1}), timeout=LONGEST)
        if ended.returncode != 0:
            return None
        found = json.loads(ended.stdout)["results"][self.observable]
        return {"mean": found["mean"], "error": found["error"], "tau": found["autocorrelation_time"],
                "warm_up": found.get("warm_up") or 0.0, "cost": seconds}

    def full(self, method, times, refine, **more):
        """The scene's full model with another step and grid."""
        keys = {**self.keys, **more}
        keys |= {"time.stepper": method, "time.dt": self.keys["time.dt"] * times,
                 "grid.nx": round(self.keys["grid.nx"] * refine),
                 "grid.ny": 1 if self.keys["grid.ny"] == 1 else round(self.keys["grid.ny"] * refine)}
        keys["output.sample_every"] = max(keys["output.sample_every"], keys["time.dt"])
        return self.run(self.given, keys)


def recommended(bench, wish):
    command = [bench.program, "tradeoff", bench.given, "--want", f"{bench.observable}={100 * wish}%", "--budget", "60s",
               "--workers", "1", "--json", "--output", bench.folder / "study", *settings_of(bench.keys)]
    return timed(*command, timeout=LONGEST)


def refusal_of(ended):
    """The last sentence of a study that recommends nothing."""
    return ((ended.stderr.strip() or ended.stdout.strip()).splitlines() or ["no word"])[-1][:300]


def reference_of(bench, noisy, particles, refine, longest):
    """The scene, ten times finer; with statistical errors for as long as its cost allows."""
    if particles:
        dt = bench.keys.get("time.dt", 5e-5)
        return bench.run(bench.given, {**bench.keys, "time.dt": dt / 2.5, "contacts.substep": dt / 25.0,
                                       "time.end": 4.0 * bench.keys["time.end"]})
    if not noisy:
        return bench.full("etdrk4-krogstad", 0.1, 2)
    short = bench.full("etdrk4-krogstad", 0.25, refine, **{"time.end": 40.0})
    if short is None:
        return None
    affordable = 40.0 * REFERENCE_SECONDS / short["cost"]
    end = max(80.0, round(min(longest, affordable) / 40) * 40)
    found = bench.full("etdrk4-krogstad", 0.25, refine, **{"time.end": end})
    return found and {**found, "end": end}


def search(bench, noisy, reference):
    """Runs of all methods, steps and grids: name, bias, cost (with noise per second), and what was found."""
    span = {"time.end": 200.0} if noisy else {}
    exact = bench.full("etdrk4-krogstad", 0.5, 1, **span) if noisy else reference  # on the same noise path
    runs = []
    for refine in (0.5, 1):
        for method in ("etdrk2", "etdrk4-krogstad"):
            for power in range(4 if noisy else 5, -1 if noisy else -2, -1):
                found = bench.full(method, 2.0**power, refine, **span)
                if found and exact and found["mean"] is not None and math.isfinite(found["mean"]):
                    runs.append((f"{method}, dt times {2.0**power:g}, {refine} of the points",
                                 found["mean"] - exact["mean"], found["cost"] / span.get("time.end", 1.0), found))
    return runs


def cheapest(runs, noisy, reference, allowed):
    """The cheapest of a search that meets the wish, with the shortest duration that suffices."""
    best = None
    for name, bias, cost, run in runs:
        if abs(bias) >= allowed:
            continue
        if noisy:
            known, span = (run, 200.0) if run["error"] is not None else (reference, reference["end"])
            statistics = (span - known["warm_up"]) * (2.0 * known["error"] / (allowed - abs(bias)))**2
            own = 80.0 * max(run["tau"], known["tau"])  # a run tells its error from eight blocks of ten times
            cost *= known["warm_up"] + max(statistics, own)
        if best is None or cost < best[1]:
            best = (name, cost)
    return best


def rows_of(program, number):
    kind, keys, observable = scene(number)
    noisy, particles = "noise" in kind or kind == "particles", kind == "particles"
    with tempfile.TemporaryDirectory() as name:
        model = MODELS / f"{kind.partition(',')[0]}.toml" if number >= FIRST_OF_MODELS else None
        bench = Bench(program, Path(name), keys, observable, model.read_text() if model else "")
        known = {}  # reference and search, by refinement
        for wish in WISHES:
            row = {"scene": number, "kind": kind, "observable": observable, "wish": wish, "settings": json.dumps(keys)}
            ended, trials = recommended(bench, wish)
            row["trials"] = f"{trials:.3g}"
            if ended.returncode != 0:
                yield {**row, "outcome": refusal_of(ended)}
                continue
            text = (bench.folder / "study" / "recommended.toml").read_text()
            row["recommended"] = "; ".join(line[4:] for line in text.splitlines() if line.startswith("# - "))[:600]
            found = bench.run(bench.folder / "study" / "recommended.toml", {})
            given = bench.full("etdrk2", 1, 1) if not particles else None
            # Where noise reaches the shortest waves, the study takes the grid as part of the model, and says so.
            refine = 1 if "part of the model" in text else 2
            if refine not in known:
                reference = reference_of(bench, noisy, particles, refine, 20000.0)
                if reference and noisy and reference["error"] is None:
                    reference = None
                known[refine] = reference, search(bench, noisy, reference) if reference and not particles else []
            reference, runs = known[refine]
            if not found or not reference:
                yield {**row, "outcome": "the recommended run fails" if not found else "no reference"}
                continue
            allowed = wish * abs(reference["mean"])
            error = found["mean"] - reference["mean"]
            limit = math.hypot(allowed, 2.0 * (reference["error"] or 0.0) if noisy else 0.0)
            row |= {"outcome": "run", "mean": f"{found['mean']:.6g}", "reference": f"{reference['mean']:.6g}",
                    "reference_error": f"{reference['error'] or 0.0:.2g}" if noisy else "0",
                    "allowed": f"{allowed:.3g}", "error": f"{error:.3g}", "cost": f"{found['cost']:.3g}",
                    "meets": "not judged" if noisy and 2.0 * reference["error"] > 2.0 * allowed else
                             abs(error) <= limit, "production": f"{given['cost']:.3g}" if given else ""}
            best = cheapest(runs, noisy, reference, allowed)
            if best:
                row |= {"cheapest_run": best[0], "cheapest": f"{best[1]:.3g}",
                        "ratio": f"{found['cost'] / best[1]:.3g}"}
            yield row


def summary(rows):
    judged = [row for row in rows if row["outcome"] == "run" and row["meets"] in ("True", "False", True, False)]
    met = sum(str(row["meets"]) == "True" for row in judged)
    ratios = sorted(float(row["ratio"]) for row in rows if row.get("ratio"))
    near = sum(ratio <= 1.5 for ratio in ratios)
    print(f"{len({row['scene'] for row in rows})} scenes, {len(rows)} wishes: {len(judged)} judged, {met} met; "
          f"cost at most 1.5 times the cheapest in {near} of {len(ratios)}"
          + (f", median {ratios[len(ratios) // 2]:.2g}" if ratios else "")
          + f"; {sum(row['outcome'] not in ('run',) for row in rows)} refused")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--drover", default="drover")
    parser.add_argument("--output", type=Path, required=True)
    parser.add_argument("--count", type=int, default=60)
    parser.add_argument("--first", type=int, default=0)
    options = parser.parse_args()
    table = KeptTable(options.output / "study.csv", COLUMNS)
    done = {int(row["scene"]) for row in table.rows}
    for number in range(options.first, options.first + options.count):
        if number not in done:
            table.add(*rows_of(os.path.abspath(options.drover), number))
    summary(table.rows)


if __name__ == "__main__":
    main()
