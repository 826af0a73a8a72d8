"""drover: flocks carried by a passive medium: build scenes, run them, compute their theory, read archives, draw.

    import drover
    scene = drover.Scene.load("flock.toml").set("driving.strength", 12)
    run = scene.start()                                  # a run in memory
    for frame in run.every(1.0):
        print(frame.time, frame.rod_density.max())
    run.observables.polar_order.plot()                   # xarray
    scene.stability().growth_rate.max("branch").plot()
    drover.sweep(scene, {"relaxation.rate": [0.1, 0.2, 0.4]}).plot("polar_order")

    with scene.run("flock.h5") as run:                   # an archive, as `drover run` writes it
        run.frames.rod_density.isel(time=-1).plot()
        run.summary.structure_factor_rods.plot(xscale="log", yscale="log")
    with drover.open_run("tapered.h5") as run:           # of particles
        run.frames.rod_axis.isel(time=-1), run.spheres.position, run.observables.polar_order.plot()
    with drover.open_theory("flock.h5") as theory:       # archive of drover stability or drover boundary
        theory.groups["ordered"].growth_rate.max("branch").plot(xscale="log")

    drover.plot.figure(run).savefig("flock.pdf")         # its panels alone: drover.plot.map(run, axes), ...
    drover.plot.compare("flock.h5", "tapered.h5")        # two runs of any kind side by side
    drover.film(run, "flock.mp4")                        # of a run in memory, or an archive
    run.observe(lambda frame: frame.rod_density.max(), "peak", "mm-2")   # an observable of your own

    model = drover.Model([drover.Field("phi", "lap(phi^3 - phi - kappa lap phi)", conserved=True)], kappa=0.5)
    model.growth_rates([0.1, 1.0]), model.start(points=64, side=64.0, dt=0.1).advance(10.0).fields

`python3 -P -m drover.figure isotropic.h5` draws a figure of any archive.
`python3 -P -m drover.film flock.h5`, or `drover film flock.h5`, makes a film of a run.
`python3 -P -m drover.server flock.toml`, or `drover serve flock.toml`, shows a run in a browser, and steers it.
`python3 -P -m drover.demo` makes the page of `make demo`.
`python3 -P -m drover.compare fields.h5 particles.h5` compares a calibrated field run with a particle run.
Nothing writes files unless it is asked to.
"""
from importlib import import_module

# Imported when they are used: the package itself loads in milliseconds.
HOMES = {
    "Calibration": "calibration", "DroverError": "error", "Error": "error", "Field": "model",
    "Frame": "simulation", "Model": "model", "ModelRun": "model_run", "Noise": "model", "Table": "model",
    "ParticleRun": "particles", "Run": "archive", "Scene": "scene", "Simulation": "simulation", "Sweep": "sweeping",
    "Tradeoff": "tradeoffs",
    "Theory": "theory", "calibrate": "calibration", "coefficients": "lookup", "diff": "lookup",
    "dynamic_structure_factor": "dynamics", "export": "commands",
    "film": "film", "fit": "commands",
    "info": "lookup", "onset": "commands", "open_run": "archive", "open_theory": "theory", "restart": "commands",
    "schema": "lookup", "serve": "server", "slurm_script": "calibration", "sweep": "sweeping", "tradeoff": "tradeoffs",
}
__all__ = sorted(HOMES)


def __getattr__(name):
    if name == "__version__":
        return import_module("drover._drover").version()[0]
    if name == "plot":
        return import_module("drover.plot")
    if name not in HOMES:
        raise AttributeError(f"module drover has no attribute {name}")
    value = getattr(import_module(f"drover.{HOMES[name]}"), name)
    globals()[name] = value
    return value


def __dir__():
    return [*globals(), *__all__]
