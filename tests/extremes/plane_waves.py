"""tests/extremes/plane_waves.py: extreme scenes of linear theory, beside the same modes to 60 digits."""
import json
import random

import h5py
import mpmath
import waves
from program import call, failure, has_non_finite

mpmath.mp.dps = 60
WRONG = 1e-3  # of the growth rate of the mode that grows fastest


def scene(number):
    """Keys of scene `number`, and what is extreme in it."""
    draw = random.Random(7919 + number)
    keys = waves.natural(draw)
    for name in [key for key in keys if key.split(".")[0] in ("initial", "time")]:
        del keys[name]
    del keys["steps"]
    keys |= {"pressure.beads": waves.log(draw, 0.01, 0.5), "elasticity.splay": waves.log(draw, 0.05, 0.5)}
    if keys.get("fields.bead_velocity") is None:
        del keys["pressure.beads"]
    else:
        keys |= {"stiffness.rods": waves.log(draw, 0.1, 1.0), "viscosity.bulk": waves.log(draw, 0.1, 1.0)}
    changed = []
    for _ in range(draw.choice([1, 1, 2, 3])):
        name = draw.choice(sorted(key for key, value in keys.items() if isinstance(value, float)))
        keys[name] *= 10.0**draw.choice([-12, -6, -3, -1, 1, 3, 6, 12])
        changed.append(f"{name} = {keys[name]:.3g}")
    keys |= {"stability.wavenumbers": 9, "stability.angles": 5}
    return keys, "; ".join(changed)


def matrix(keys, order, q, angle):
    """M of d(rho, sigma, v, p)/dt = M (rho, sigma, v, p) about a uniform state with the order along x.

    The momentum equation is solved for v where beads have no inertia; fields that the model lacks are left out.
    """
    value = lambda name, default=0.0: mpmath.mpf(keys.get(name, default))  # noqa: E731
    i, qx, qy = mpmath.mpc(0, 1), q * mpmath.cos(angle), q * mpmath.sin(angle)
    velocity = keys.get("fields.bead_velocity")
    rho, mass = value("uniform.bead_density", 1.0), value("inertia.bead_mass", 1.0)
    gamma, alpha, weathercock = (value(name) for name in ("drag.coefficient", "driving.strength",
                                                          "weathercock.strength"))
    eta, zeta, e, f = (value(name) for name in ("viscosity.shear", "viscosity.bulk", "stiffness.beads",
                                                "stiffness.rods"))
    splay, stiffness, w = (value(name) for name in ("elasticity.splay", "elasticity.stiffness", "advection.strength"))
    a, b, drift = value("relaxation.rate"), value("relaxation.saturation"), alpha * order / gamma if velocity else 0
    m = mpmath.zeros(6)
    m[0, 0] = -i * drift * qx - value("diffusion.beads") * q**2
    m[0, 2], m[0, 3] = -i * rho * qx, -i * rho * qy
    m[1, 1] = -value("diffusion.rods") * q**2
    m[1, 4], m[1, 5] = -i * value("current.speed") * qx, -i * value("current.speed") * qy
    for row, along in ((2, qx), (3, qy)):
        m[row, 0], m[row, 1], m[row, row + 2] = -i * e * along, -i * f * along, alpha
        m[row, 2] = -(gamma + eta * q**2) * (row == 2) - zeta * qx * along
        m[row, 3] = -(gamma + eta * q**2) * (row == 3) - zeta * qy * along
    for row, along in ((4, qx), (5, qy)):
        m[row, 0], m[row, 1], m[row, row - 2] = -i * value("pressure.beads") * along, \
            -i * value("pressure.rods") * along, weathercock
        m[row, 4] = -splay * qx * along
        m[row, 5] = -splay * qy * along
        m[row, row] -= a + b * order**2 * (3 if row == 4 else 1) + i * w * order * qx + stiffness * q**2
    has_rods = keys.get("fields.rod_density", True)
    if velocity == "dynamic":
        for row in (2, 3):
            m[row, :] /= mass * rho
            if keys.get("inertia.advection"):
                m[row, row] -= i * drift * qx
        kept = [0] + [1] * has_rods + [2, 3, 4, 5]
    else:
        if velocity == "slaved":
            balance = mpmath.inverse(m[2:4, 2:4])
            for row in (0, 1, 4, 5):
                for column in (0, 1, 4, 5):
                    m[row, column] -= (m[row, 2:4] * balance * m[2:4, column])[0]
        kept = ([0] if velocity else []) + [1] * has_rods + [4, 5]
    return mpmath.matrix([[m[row, column] for column in kept] for row in kept])


def judge(program, folder, keys):
    """Outcome, error and message of a scene."""
    status, output, errors = call(program, folder, "stability", keys, "--json", "--output", "maps.h5")
    if (failed := failure(status, errors)) is not None:
        return failed
    result = json.loads(output)
    if has_non_finite(result):
        return "SILENT", "", "not finite"
    worst, named = mpmath.mpf(0), ""
    with h5py.File(folder / "maps.h5") as file:
        for state in result["states"]:
            maps = file[state["name"]]
            order = mpmath.hypot(*(mpmath.mpf(part) for part in state["order"]))
            for j, angle in enumerate(maps["angle"][:]):
                for k, q in enumerate(maps["wavenumber"][:]):
                    modes = mpmath.eig(matrix(keys, order, mpmath.mpf(q), mpmath.radians(mpmath.mpf(angle))),
                                       left=False, right=False)
                    exact, found = max(mode.real for mode in modes), max(maps["growth_rate"][j, k, :])
                    # A mode that neither grows nor decays within 1e-9 of its frequency is neutral, and so is one
                    # within the rounding of the order, which a number of double precision holds.
                    size = max(abs(exact), mpmath.mpf(1e-9) * max(abs(mode) for mode in modes if mode.real == exact),
                               mpmath.mpf(1e-10) * abs(keys["relaxation.rate"]) * (order > 0))
                    if size > 0 and abs(found - exact) / size > worst:
                        worst = abs(found - exact) / size
                        named = (f"{state['name']}, q = {q:.3g}, {angle:.3g} degrees: {found:.6g}, exact "
                                 f"{float(exact):.6g}")
    if worst > WRONG and result["notes"]:
        return "warned", f"{float(worst):.2g}", result["notes"][0]
    return "SILENT" if worst > WRONG else "right", f"{float(worst):.2g}", named
