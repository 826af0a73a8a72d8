"""drover: reads results of drover as xarray datasets and draws figures.

    import drover
    with drover.open_run("isotropic.h5") as run:
        run.frames.rod_density.isel(time=-1).plot()
        run.summary.structure_factor_rods.plot(xscale="log", yscale="log")

    with drover.open_theory("flock.h5") as theory:      # archive of drover stability or drover boundary
        theory.groups["ordered"].growth_rate.max("branch").plot(xscale="log")

    with drover.open_run("tapered.h5") as run:          # a particle run
        run.frames.rod_axis.isel(time=-1), run.spheres.position, run.observables.polar_order.plot()

    with drover.open_theory("onset.h5") as theory:      # archive of drover boundary TABLE
        theory.groups["line"]["mean"].plot()

`python3 -m drover.figure isotropic.h5` draws a figure of any archive.
`python3 -m drover.compare fields.h5 particles.h5` compares a calibrated field run with a particle run.
"""
from drover.archive import Run, open_run
from drover.error import DroverError
from drover.particles import ParticleRun
from drover.theory import Theory, open_theory

__all__ = ["DroverError", "ParticleRun", "Run", "Theory", "open_run", "open_theory"]
