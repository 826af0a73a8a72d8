"""drover: the hydrodynamics of flocks carried by a passive medium; runs read back as xarray datasets.

    import drover
    with drover.open_run("isotropic.h5") as run:
        run.frames.rod_density.isel(time=-1).plot()
        run.summary.structure_factor_rods.plot(xscale="log", yscale="log")

`python3 -m drover.figure isotropic.h5` draws one picture of a run.
"""
from drover.archive import Run, open_run
from drover.error import DroverError

__all__ = ["DroverError", "Run", "open_run"]
