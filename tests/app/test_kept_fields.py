"""tests/app/test_kept_fields.py: fields after 200 steps, beside those of the version that had the equations in C++.

kept_fields.json was written by drover 0.1.0 at commit e78c4075, the last version whose terms of rods and beads were
functions in C++: DROVER=that/program tests/app/test_kept_fields.py writes it.
"""
import json
from pathlib import Path

import h5py
import numpy as np
import pytest
from support import MODELS, drover, settings

KEPT = Path(__file__).parent / "kept_fields.json"
SQUARE = ["grid.nx=32", "grid.ny=32"]
# In short steps noise of the order reaches the velocity as the cube of a step: the square root of its covariance has
# half of the digits, and the fields agree to 1e-8 at dt = .005 (test_flock_as_equations.py).
QUIET = [*SQUARE, "noise.order=0.0"]
VARYING = ['relaxation.rate_terms=["-0.5 sigma"]', 'driving.strength_terms=["0.2 rho sigma"]',
           'drag.coefficient_terms=["0.3 rho"]', 'weathercock.strength_terms=["-0.1 rho"]']
CASES = {  # scene, step, settings
    "flock": ("flock", 0.02, QUIET),
    "noisy flock": ("noisy-flock", 0.25, SQUARE),
    "coefficients of the densities": ("flock", 0.02, QUIET + VARYING),
    "slaved beads": ("flock", 0.02, QUIET + ['fields.bead_velocity="slaved"', 'initial.bead_velocity_x=""']),
    "slaved beads, coefficients of the densities": (
        "flock", 0.02, QUIET + VARYING + ['fields.bead_velocity="slaved"', 'initial.bead_velocity_x=""',
                                           "viscosity.shear=0.0", "driving.cubic=-1.0"]),
    "carried momentum and cubic terms": (
        "flock", 0.02, QUIET + ["inertia.advection=true", "driving.cubic=-2.0", "advection.strength=0.7",
                                 "advection.divergence=0.2", "advection.gradient=0.1", "elasticity.splay=0.4",
                                 "elasticity.bilaplacian=0.01", "viscosity.bulk=3.0", "orienting_field.x=0.01"]),
    "band": ("band", 0.05, []),
    "kink": ("kink", 0.05, []),
    "edge of beads": ("barenblatt", 0.025, []),
    "force at a point": ("point-force", 0.05, SQUARE),
    "force at a point that moves": ("point-force-moving", 0.05, SQUARE),
    "coefficients from a table": ("calibrated-flock", 0.05, SQUARE + ["approximation.counterterm=false"]),
}


def modes_of(folder, case):
    """The largest value of each field, and some of its Fourier coefficients."""
    scene, dt, changes = CASES[case]
    path = Path(folder) / "run.h5"
    end = 200 * dt
    drover(folder, "run", MODELS / f"{scene}.toml", "--quiet", "--overwrite", "--output", path,
           *settings(['time.stepper="etdrk2"', f"time.dt={dt}", "time.tolerance=0.0", f"time.end={end}",
                      f"output.frame_every={end}", f"output.sample_every={end / 4}", "analysis.warm_up=0.0",
                      "run.threads=1", *changes]))
    result = {}
    with h5py.File(path) as run:
        for name, values in run.items():
            if not isinstance(values, h5py.Dataset) or values.ndim != 3:
                continue
            field = values[-1]
            spectrum = np.fft.fft2(field) / field.size
            chosen = [spectrum[j % field.shape[0], i] for j, i in ((0, 0), (0, 1), (1, 0), (1, 1), (-2, 3))]
            result[name] = [np.abs(field).max(), *(float(part) for z in chosen for part in (z.real, z.imag))]
    return result


@pytest.mark.parametrize("case", CASES)
def test_fields_are_those_of_the_version_with_terms_in_cpp(tmp_path, case):
    kept, found = json.loads(KEPT.read_text(encoding="utf-8"))[case], modes_of(tmp_path, case)
    assert set(kept) == set(found)
    # Rounding of 200 steps.  A field that nothing drives is rounding itself: 1e-14 of the others.
    largest = max(values[0] for values in kept.values())
    for name, values in kept.items():
        assert np.abs(np.subtract(values, found[name])).max() <= 1e-12 * values[0] + 1e-14 * largest, name


if __name__ == "__main__":
    import tempfile
    with tempfile.TemporaryDirectory() as scratch:
        KEPT.write_text(json.dumps({case: modes_of(scratch, case) for case in CASES}, indent=0) + "\n",
                        encoding="utf-8")
