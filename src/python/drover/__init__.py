"""drover: the hydrodynamics of flocks carried by a passive medium; runs read back as xarray datasets.

    import drover
    with drover.open_run("isotropic.h5") as run:
        run.frames.rod_density.isel(time=-1).plot()
        run.summary.structure_factor_rods.plot(xscale="log", yscale="log")

    with drover.open_theory("flock.h5") as theory:      # what drover stability or drover boundary wrote
        theory.groups["ordered"].growth_rate.max("branch").plot(xscale="log")

    with drover.open_run("tapered.h5") as run:          # of particles
        run.frames.rod_axis.isel(time=-1), run.spheres.position, run.observables.polar_order.plot()

    with drover.open_theory("onset.h5") as theory:      # what drover boundary TABLE wrote
        theory.groups["line"]["mean"].plot()

`python3 -m drover.figure isotropic.h5` draws one picture of an archive of any kind.
`python3 -m drover.compare fields.h5 particles.h5` sets a run of fields on a table of coefficients beside one of particles.
"""
from drover.archive import Run, open_run
from drover.error import DroverError
from drover.particles import ParticleRun
from drover.theory import Theory, open_theory

__all__ = ["DroverError", "ParticleRun", "Run", "Theory", "open_run", "open_theory"]
