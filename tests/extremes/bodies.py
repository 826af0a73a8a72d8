"""tests/extremes/bodies.py: extreme scenes of particles, whose answers must obey what holds for any hard bodies."""
import json
import math
import random

import h5py
import numpy
from program import call, failure, has_non_finite

OVERLAP = 0.03    # of a radius, where the scene's own limit is 0.02
ENERGY = 1e-6     # of the energy that has passed through the bodies


def scene(number):
    """Keys of scene `number`, and what is extreme in it."""
    draw = random.Random(104729 + number)
    keys = {"cell.lx": 8.0, "cell.ly": 8.0, "beads.area_fraction": draw.uniform(0.05, 0.5),
            "rods.count": draw.choice([0, 0, 1, 2, 4]), "time.end": 0.02, "output.frame_every": 0.02,
            "output.sample_every": 0.002, "run.seed": number, "run.threads": 1}
    changed = []
    for _ in range(draw.choice([1, 2, 2, 3])):
        what = draw.choice(["restitution", "friction", "both", "amplitude", "density", "step", "size",
                            "gravity", "kick", "crowded", "gap", "law", "force", "substep", "few"])
        pairs = ["bead_bead", "rod_bead", "rod_rod", "bead_plate", "rod_plate"]
        some = draw.sample(pairs, draw.choice([1, 2, 5]))
        if what in ("restitution", "both"):
            keys |= {f"restitution.{pair}": draw.choice([0.0, 0.0, 1.0, 0.999, 1e-9]) for pair in some}
        if what in ("friction", "both"):
            keys |= {f"friction.{pair}": draw.choice([0.0, 0.5, 1.0, 10.0, 100.0]) for pair in some}
        if what == "amplitude":
            keys |= draw.choice([{"plates.amplitude": 0.0}, {"plates.amplitude": 0.6}, {"plates.amplitude": 1e-6},
                                 {"plates.frequency": 2000.0}, {"plates.frequency": 1.0}])
        if what == "density":
            keys |= draw.choice([{"beads.density": 1e-6}, {"beads.density": 1e6}, {"rods.densities": [1e-3]},
                                 {"rods.densities": [1e4]}])
        if what == "step":
            keys["time.dt"] = draw.choice([2e-4, 1e-4, 2e-6, 2e-3])
        if what == "size":
            keys["beads.diameters"] = draw.choice([[0.1], [1.1], [0.2, 1.1], [1e-3]])
            if len(keys["beads.diameters"]) == 2:
                keys["beads.proportions"] = [0.9, 0.1]
            if keys["beads.diameters"][0] < 0.2:
                keys["beads.count"] = 200
                keys["beads.area_fraction"] = 0.0
        if what == "gravity":
            keys["gravity.z"] = draw.choice([0.0, 9810.0, -9.81e5, -1.0])
        if what == "kick":
            keys["kick.strength"] = draw.choice([0.0, 1.0, 100.0])
        if what == "crowded":
            keys["beads.area_fraction"] = draw.choice([0.8, 0.9, 1.2])
        if what == "gap":
            keys["plates.gap"] = draw.choice([1.101, 0.5, 50.0])
        if what == "law":
            keys |= draw.choice([{"contacts.law": "first-to-last"}, {"contacts.restitution": "kinematic"},
                                 {"contacts.model": "spring-dashpot"}, {"contacts.increments": 1},
                                 {"contacts.law": "first-to-last", "contacts.track_slip": False},
                                 {"contacts.law": "pairwise"}, {"contacts.law": "pairwise", "rods.bearing": "all"},
                                 {"contacts.law": "pairwise", "contacts.friction": "decoupled"},
                                 {"contacts.inelastic_threshold": 0.0}])
        if what == "force":
            keys |= draw.choice([{"forces.bead_x": 1e7}, {"forces.rod_x": -1e9}, {"forces.torque": 1e9}])
        if what == "substep":
            keys["contacts.substep"] = draw.choice([2e-4, 2e-7, 1e-3])
        if what == "few":
            keys |= {"beads.area_fraction": 0.0, "beads.count": draw.choice([0, 1, 2])}
        changed.append(what)
    if keys.get("beads.count") and keys["beads.area_fraction"] > 0.0:
        del keys["beads.count"]
    return keys, "; ".join(changed)


def largest_overlap(positions, radii, body, sides):
    """Of spheres of different bodies, in parts of the smaller radius."""
    apart = positions[:, None, :] - positions[None, :, :]
    for axis in (0, 1):
        apart[:, :, axis] -= sides[axis] * numpy.round(apart[:, :, axis] / sides[axis])
    depth = radii[:, None] + radii[None, :] - numpy.sqrt((apart**2).sum(axis=2))
    depth[body[:, None] == body[None, :]] = 0.0
    return (depth / numpy.minimum(radii[:, None], radii[None, :])).max(initial=0.0)


def judge(program, folder, keys):
    """Outcome, measure and message of a scene."""
    status, output, errors = call(program, folder, "run", {**keys, "output.file": "run.h5"}, "--quiet", "--json")
    if (failed := failure(status, errors)) is not None:
        return failed
    result = json.loads(output)
    if result["warnings"]:
        return "warned", "", result["warnings"][0]
    with h5py.File(folder / "run.h5") as file:
        if "particles" not in file:
            return "right", "0", "no bodies"
        spheres = file["particles/spheres"]
        positions, radii, body = spheres["position/value"][-1], spheres["radius"][:], spheres["body"][:]
        velocities = spheres["velocity/value"][-1]
        work = {name: file[f"series/work_{name}"][-1] for name in ("plates", "gravity", "forces", "kicks", "impact",
                                                                   "friction")}
        kinetic = file["series/energy_kinetic"][:]
    if has_non_finite(result) or not (numpy.isfinite(positions).all() and numpy.isfinite(velocities).all()):
        return "SILENT", "", "not finite"
    passed = max([*map(abs, work.values()), *kinetic, 1e-300])
    gained = max(work["impact"], work["friction"]) / passed
    if gained > ENERGY:
        return "SILENT", f"{gained:.2g}", "impacts or friction give energy"
    unbalanced = abs(kinetic[-1] - kinetic[0] - sum(work.values())) / passed
    if unbalanced > ENERGY:
        return "SILENT", f"{unbalanced:.2g}", "the works do not add up to the change of the kinetic energy"
    overlap = largest_overlap(positions, radii, body, (keys["cell.lx"], keys["cell.ly"])) if len(radii) else 0.0
    turn = 2.0 * math.pi * keys.get("plates.frequency", 200.0) * keys["time.end"]
    base = keys.get("plates.amplitude", 0.04) * (1.0 + math.cos(turn))
    beyond = max((base + radii - positions[:, 2]).max(initial=0.0),
                 (positions[:, 2] + radii - base - keys.get("plates.gap", 1.2)).max(initial=0.0))
    beyond /= radii.min(initial=1.0)
    if max(overlap, beyond) > OVERLAP:
        return "SILENT", f"{max(overlap, beyond):.2g}", "bodies overlap" if overlap > beyond else "beyond the plates"
    return "right", f"{max(overlap, beyond, gained, unbalanced):.2g}", ""
