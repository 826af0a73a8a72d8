"""tests/extremes/waves.py: extreme scenes of fields, each beside runs with shorter steps and with more points."""
import json
import math
import random

import numpy
from field_error import frame_of, largest_error, size_of
from program import call, failure, has_non_finite

VANISHED, RELAXED = 1e-10, 1e-5  # a smaller field has no size of its own; of that at the start, as for step_error
SHORTEST = 1.5e-8  # [s]: shorter steps under noise share no path with those of an eighth
WRONG = 0.1  # of a field: ten times the error above which a run warns


def log(draw, low, high):
    return math.exp(draw.uniform(math.log(low), math.log(high)))


def natural(draw):
    """A scene whose numbers are all near one."""
    kind = draw.choice(["order", "rods", "dynamic", "dynamic", "slaved"])
    keys = {"grid.nx": 16, "grid.ny": 16, "grid.lx": 16.0, "grid.ly": 16.0,
            "relaxation.rate": draw.choice([-1.0, 1.0]) * log(draw, 0.1, 1.0),
            "relaxation.saturation": log(draw, 0.3, 3.0), "elasticity.stiffness": log(draw, 0.2, 1.0),
            "advection.strength": draw.choice([0.0, log(draw, 0.05, 1.0)]), "current.speed": log(draw, 0.2, 1.0),
            "diffusion.rods": log(draw, 0.1, 0.5), "pressure.rods": log(draw, 0.05, 1.0)}
    if kind == "order":
        keys["fields.rod_density"] = False
        for key in ("current.speed", "diffusion.rods", "pressure.rods"):
            del keys[key]
    if kind in ("dynamic", "slaved"):
        keys |= {"fields.bead_density": True, "fields.bead_velocity": kind, "drag.coefficient": log(draw, 2.0, 20.0),
                 "driving.strength": log(draw, 1.0, 8.0), "stiffness.beads": log(draw, 0.5, 5.0),
                 "weathercock.strength": log(draw, 0.2, 2.0), "viscosity.shear": log(draw, 0.2, 2.0),
                 "diffusion.beads": log(draw, 0.1, 0.5)}
        if kind == "dynamic":
            keys["inertia.bead_mass"] = log(draw, 0.1, 2.0)
            keys["inertia.advection"] = draw.random() < 0.3
    keys |= {"initial.kind": "formula", "initial.polar_order_x": "0.3 + 0.2*sin(2*pi*Y)",
             "initial.polar_order_y": "0.2*cos(2*pi*X)", "time.dt": round(log(draw, 0.01, 0.1), 3), "steps": 40,
             "time.stepper": draw.choice(["etdrk2", "etdrk2", "etdrk4", "etdrk4-krogstad", "exponential-euler"])}
    return keys


def change(draw, keys):
    """Makes one thing extreme; returns its name."""
    power = draw.choice([-12, -6, -3, -2, -1, 1, 2, 3, 6, 12])
    what = draw.choice(["coefficient", "coefficient", "coefficient", "grid", "cell", "step", "noise", "start",
                        "density", "zero", "method"])
    if what in ("coefficient", "zero"):
        names = sorted(key for key, value in keys.items() if isinstance(value, float) and value != 0.0 and
                       key.split(".")[0] not in ("grid", "time", "uniform", "noise"))
        name = draw.choice(names)
        keys[name] = 0.0 if what == "zero" else keys[name] * 10.0**power
        return f"{name} = {keys[name]:.3g}"
    if what == "grid":
        nx, ny = draw.choice([(4, 4), (5, 7), (6, 10), (28, 8), (64, 4), (4, 64), (128, 1), (2048, 1), (16, 1),
                              (8, 1), (48, 48), (62, 62), (1, 16), (2, 2)])
        keys |= {"grid.nx": nx, "grid.ny": ny}
        return f"{nx} by {ny}"
    if what == "cell":
        keys |= {"grid.lx": 16.0 * 10.0**power, "grid.ly": 16.0 * 10.0**draw.choice([power, power, 0])}
        return f"cell {keys['grid.lx']:g} by {keys['grid.ly']:g}"
    if what == "step":
        keys["time.dt"] *= 10.0**draw.choice([-12, -6, -3, 0.5, 1, 1, 2, 3, 6])
        return f"dt = {keys['time.dt']:.3g}"
    if what == "noise":
        for name in ("order", "rods", "beads"):
            if name == "order" or keys.get(f"fields.{name[:-1]}_density", name == "rods"):
                keys[f"noise.{name}"] = log(draw, 1e-4, 1e-2) * 10.0**draw.choice([-9, -3, 0, 0, 1, 2, 4, 9])
        return f"noise {keys['noise.order']:.3g}"
    if what == "start":
        least = draw.choice([0.5, 0.1, 0.01, 1e-3, 1e-6, -0.1])
        dip = f"1 - {1 - least}*exp(-((X-0.5)^2+(Y-0.5)^2)*{draw.choice([8, 32, 200])})"
        if keys.get("fields.bead_density"):
            keys["initial.bead_density"] = dip
            return f"bead dip to {least}"
        keys["initial.polar_order_x"] = draw.choice(["50 + sin(2*pi*Y)", "1e-9*sin(2*pi*Y)", "sin(2*pi*5*X)", "X - 0.5",
                                                     "1e6*sin(2*pi*Y)"])
        return f"start {keys['initial.polar_order_x']}"
    if what == "density":
        name = draw.choice(["uniform.rod_density", "uniform.bead_density"])
        keys[name] = 10.0**power
        return f"{name} = {keys[name]:g}"
    keys |= draw.choice([{"dealiasing.rule": "none"}, {"dealiasing.rule": "two-thirds"}, {"time.tolerance": 1e-1},
                         {"time.tolerance": 1e-4}, {"time.tolerance": 1e-12}, {"current.kind": "density-order"}])
    return "method"


def scene(number):
    """Keys of scene `number`, and what is extreme in it."""
    draw = random.Random(5003 + number)
    keys = natural(draw)
    changed = [change(draw, keys) for _ in range(draw.choice([1, 1, 2, 2, 3]))]
    for name in [key for key in keys if key.startswith("initial.") and key != "initial.kind"]:
        of_y = f"(y/{keys['grid.ly']!r})" if keys["grid.ny"] > 1 else "X"
        keys[name] = keys[name].replace("Y", of_y).replace("X", f"(x/{keys['grid.lx']!r})")
    if keys.get("uniform.bead_density", 1.0) != 1.0 and "initial.bead_density" in keys:
        keys["initial.bead_density"] = f"{keys['uniform.bead_density']!r}*({keys['initial.bead_density']})"
    steps = keys.pop("steps")
    keys |= {"time.end": keys["time.dt"] * steps, "output.frame_every": 0.0, "output.sample_every": keys["time.dt"],
             "run.seed": number, "run.threads": 1}
    return keys, "; ".join(changed)


def run(program, folder, keys, name):
    """Status, standard error, results, and first and last frame of a run."""
    status, output, errors = call(program, folder, "run", {**keys, "output.file": f"{name}.h5"}, "--quiet",
                                  "--overwrite", "--json")
    if status != 0:
        return status, errors, None, None
    return 0, errors, json.loads(output), [frame_of(folder / f"{name}.h5", number) for number in (0, -1)]


def judge(program, folder, keys):
    """Outcome, error and message of a scene."""
    status, errors, result, frames = run(program, folder, keys, "run")
    if (failed := failure(status, errors)) is not None:
        return failed
    start, frame = frames
    warnings = result["warnings"]
    bad = has_non_finite(result) or not all(numpy.isfinite(values).all() for values in frame.values())
    if warnings:
        return "warned", "", warnings[0]
    if bad:
        return "SILENT", "", "not finite"
    is_noisy = any(keys.get(f"noise.{name}", 0.0) > 0.0 for name in ("order", "rods", "beads"))
    finer = {**keys, "time.dt": keys["time.dt"] / 8, "time.stepper": "etdrk4-krogstad", "time.tolerance": 0.0}
    if is_noisy and keys["time.dt"] / 8 < SHORTEST:
        return "undecided", "", "no common noise path"
    references = [("an eighth of the step", finer, (1, 1))]
    if not is_noisy and keys["grid.nx"] * keys["grid.ny"] <= 2048:
        doubled = tuple(2 if keys[name] > 1 else 1 for name in ("grid.ny", "grid.nx"))
        references.append(("twice the points", {**finer, "grid.ny": keys["grid.ny"] * doubled[0],
                                                "grid.nx": keys["grid.nx"] * doubled[1]}, doubled))
    worst, named = 0.0, ""
    for name, settings, coarser in references:
        status, errors, _, exact = run(program, folder, settings, "finer")
        if status != 0:
            return "undecided", "", f"{name}: {errors.strip()[-200:]}"
        exact = {key: values[::coarser[0], ::coarser[1]] for key, values in exact[1].items()}
        error, field = largest_error(frame, exact, is_noisy,
                                     lambda group: max(VANISHED, RELAXED * size_of(start, group)))
        if error > worst:
            worst, named = error, f"{field} beside {name}"
    return "SILENT" if worst > WRONG else "right", f"{worst:.2g}", named
