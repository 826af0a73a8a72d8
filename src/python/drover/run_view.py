"""drover/run_view.py: what a figure needs of a run, from an archive, an open run or a run in memory."""
import os
from pathlib import Path

import numpy

from drover.archive import Run
from drover.error import Error
from drover.particles import ParticleRun


def run_of(thing):
    """A Run or ParticleRun of a path, an open run or a Simulation, which has one frame: the present one."""
    if isinstance(thing, (str, os.PathLike)):
        from drover.theory import open_any
        thing = open_any(thing)
    if hasattr(thing, "observables") and hasattr(thing, "every"):
        return present(thing)
    if isinstance(thing, (Run, ParticleRun)):
        return thing
    name = getattr(thing, "path", thing)
    raise Error(f"{name} is not a run; expected a path of an archive, an open run, or scene.start()")


def present(simulation):
    """A run in memory as if it were an open archive."""
    frame = simulation.frame
    dataset = frame.to_xarray()
    moving = [name for name, array in dataset.items() if array.dims in (("y", "x"), ("bead", "component"),
                                                                        ("rod", "component"))]
    frames = dataset[moving].expand_dims("time").merge(dataset.drop_vars([*moving, "time"]))
    scene = simulation.scene
    attributes = {"scene_file": Path(scene.name).name, "seed": scene["run.seed"], "scene": scene.to_toml(),
                  "in_memory": "ended" if simulation.step >= simulation.steps else "going on"}
    parts = (Path(scene.name), frames)
    if scene.kind != "particles":
        return Run(*parts, simulation.observables, None, scene.values, attributes, None)
    attributes["sides"] = numpy.diag(frame.box)[:2]
    return ParticleRun(*parts, None, simulation.observables, None, scene.values, attributes, None)
