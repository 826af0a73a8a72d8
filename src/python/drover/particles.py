"""drover/particles.py: reads the archive of a particle run: bodies, spheres, series, summary and scene."""
from dataclasses import dataclass
from pathlib import Path

import numpy
import xarray
from xarray.core import indexing

from drover.error import DroverError
from drover.hdf5_reader import Store, StoreOwner, StoredArray, group_dataset

# Groups of the file: prefix of their arrays in the dataset, and the particle dimension.
BODIES = {"/bodies/beads": ("bead_", "bead"), "/bodies/rods": ("rod_", "rod")}
SPHERES, SERIES = "/particles/spheres", "/series"
COMPONENTS = ["x", "y", "z"]
ORDER = "polar_order"  # the series of the order of the rods
BEAD_ORDER = "bead_velocity_order"  # the same of the velocities of beads


@dataclass(frozen=True)
class ParticleRun(StoreOwner):
    """One particle run.  Arrays are read when they are used; close() it, or open it using `with`.

    For a run in progress it contains the rows present when it was opened: open it again for more.
    """

    path: Path
    frames: xarray.Dataset          # bead_position, rod_axis, ... over (time, bead or rod, component), not wrapped
    spheres: xarray.Dataset         # position in the box, image, velocity, radius, species, body of every sphere
    observables: xarray.Dataset     # series over time
    summary: xarray.Dataset | None  # means with errors; None until the run has finished
    scene: dict                     # all keys with their values: scene["rods"]["count"]
    attributes: dict                # provenance: version, commit, seed, host, ...
    store: Store

    def __repr__(self):
        sizes = self.frames.sizes
        counts = ", ".join(f"{sizes[name]} {name}s" for name in ("bead", "rod") if name in sizes)
        return f"<drover.ParticleRun {self.path.name}: {counts}, {rows_of(self)}>"


def rows_of(run):
    """What an open run holds, in a few words."""
    return (f"{run.frames.sizes['time']} frames, {run.observables.sizes.get('time', 0)} samples"
            + (", not finished" if run.summary is None else ""))


def is_of_particles(scene):
    return "cell" in scene


def read_particles(store, path, attributes, scene):
    """Reads a particle run from an open archive."""
    if SERIES in store.groups and not {SPHERES, *BODIES} & set(store.groups):
        raise DroverError(f"{path} holds a run without beads and rods, and nothing to read; give the scene "
                          "beads.area_fraction or rods.area_fraction")
    spheres = trajectory(store, path, SPHERES, "", "sphere")
    frames = xarray.Dataset(coords={"time": spheres["time"], "step": spheres["step"]})
    for group, (start, axis) in BODIES.items():
        if group in store.groups:
            frames = frames.merge(trajectory(store, path, group, start, axis), join="inner")
    if frames.sizes.get("time", 0) == 0:
        raise DroverError(f"{path} contains no frames: its run ended at the start; run its scene again")
    if SERIES not in store.groups:
        raise DroverError(f"{path} holds frames without series: a start for other runs, not a run; run a scene with "
                          f'packing.kind = "file" and packing.file = "{path.name}"')
    summary = group_dataset(store, "/summary") if "/summary" in store.groups else None
    return ParticleRun(path, frames, spheres, group_dataset(store, SERIES), summary, scene, attributes, store)


def trajectory(store, path, group, start, axis):
    """Reads an H5MD group as a dataset: time-dependent and fixed arrays."""
    if group not in store.groups:
        raise DroverError(f"{path} has no group {group}, which a particle run has: the file is damaged, or from "
                          "another version of drover")
    elements = [name for name in store.groups_in(group) if name != "box"]
    if not elements:
        raise DroverError(f"{path}: {group} contains no positions; the file is damaged: use another copy")
    times = {part: store.read(array_of(store, f"{group}/{elements[0]}/{part}", 1)) for part in ("time", "step")}
    rows = min(map(len, times.values()))
    variables = {}
    for name in elements:
        array = array_of(store, f"{group}/{name}/value", 3)
        if array.shape[0] < rows or array.shape[2] != len(COMPONENTS):
            raise DroverError(f"{path}: {array.path} has the shape {array.shape}; expected {rows} rows of three "
                              "components: the file is damaged")
        variables[start + name] = lazy(store, array, ("time", axis, "component"), (rows, *array.shape[1:]))
    for array in store.arrays_in(group):
        variables[start + array.name] = lazy(store, array, (axis, f"{axis}_sphere")[:len(array.shape)], array.shape)
    coordinates = {part: ("time", values[:rows]) for part, values in times.items()}
    coordinates["time"] = ("time", times["time"][:rows], {"units": "s"})
    return xarray.Dataset(variables, {**coordinates, "component": COMPONENTS})


def array_of(store, name, rank):
    """An array of the file with this number of axes."""
    array = store.arrays.get(name)
    if array is None or len(array.shape) != rank:
        raise DroverError(f"{store.path} has no array {name} over {rank} axes; the file is damaged, or from another "
                          "version of drover")
    return array


def lazy(store, array, dims, shape):
    return xarray.Variable(dims, indexing.LazilyIndexedArray(StoredArray(store, array, shape)), array.attributes)


def sides_of(run):
    """Sides of the bounding rectangle of the cell, which is centred on x = y = 0 [mm]."""
    if run.store is None:  # in memory
        return run.attributes["sides"]
    edges = run.store.read(array_of(run.store, f"{SPHERES}/box/edges/value", 3), (0, 1))
    return numpy.diag(edges[0])[:2]
