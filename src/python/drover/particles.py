"""drover/particles.py: reads the archive of a particle run: bodies, spheres, series, summary and scene."""
from dataclasses import dataclass
from pathlib import Path

import h5py
import numpy
import xarray
from xarray.core import indexing

from drover.error import DroverError
from drover.stored import Store, StoreOwner, StoredArray, attributes_of, check_dataset, group_dataset, names_of

# Groups of the file: prefix of their arrays in the dataset, and the particle dimension.
BODIES = {"bodies/beads": ("bead_", "bead"), "bodies/rods": ("rod_", "rod")}
SPHERES, SERIES = "particles/spheres", "series"
COMPONENTS = ["x", "y", "z"]
ORDER = "polar_order"  # the series of the order of the rods


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
    spheres = trajectory(store, path, SPHERES, "", "sphere")
    frames = xarray.Dataset(coords={"time": spheres["time"], "step": spheres["step"]})
    for group, (start, axis) in BODIES.items():
        if group in store.file:
            frames = frames.merge(trajectory(store, path, group, start, axis), join="inner")
    if frames.sizes.get("time", 0) == 0:
        raise DroverError(f"{path} contains no frames: its run ended at the start; run its scene again")
    if SERIES not in store.file:
        raise DroverError(f"{path} holds frames without series: a start for other runs, not a run; run a scene with "
                          f'packing.kind = "file" and packing.file = "{path.name}"')
    summary = group_dataset(store, "/summary") if "summary" in store.file else None
    return ParticleRun(path, frames, spheres, group_dataset(store, f"/{SERIES}"), summary, scene, attributes, store)


def trajectory(store, path, name, start, axis):
    """Reads an H5MD group as a dataset: time-dependent and fixed arrays."""
    group = store.file.get(name)
    if not isinstance(group, h5py.Group):
        raise DroverError(f"{path} has no group {name}, which a particle run has: the file is damaged, or from "
                          "another version of drover")
    variables, times = {}, None
    for key in names_of(group):
        link = group.get(key, getlink=True)
        if not isinstance(link, h5py.HardLink):
            raise DroverError(f"{path}: {name}/{key} is a link; expected the data itself, since links are not followed")
        item = group[key]
        if isinstance(item, h5py.Group) and key != "box":
            if times is None:
                times = {part: read_times(item, part, path) for part in ("time", "step")}
                rows = min(map(len, times.values()))
            variables[start + key] = stored(store, path, item, "value", ("time", axis, "component"), rows)
        elif isinstance(item, h5py.Dataset):
            dims = (axis, f"{axis}_sphere")[:item.ndim]
            variables[start + key] = stored(store, path, group, key, dims)
    if times is None:
        raise DroverError(f"{path}: {name} contains no positions; the file is damaged: use another copy")
    coordinates = {part: ("time", values[:rows]) for part, values in times.items()}
    coordinates["time"] = ("time", times["time"][:rows], {"units": "s"})
    return xarray.Dataset(variables, {**coordinates, "component": COMPONENTS})


def read_times(group, name, path):
    if not isinstance(group.get(name), h5py.Dataset) or group[name].ndim != 1:
        raise DroverError(f"{path}: {group.name} has no {name}; the file is damaged: use another copy")
    check_dataset(group[name], path, "fi")
    return group[name][:]


def stored(store, path, group, name, dims, rows=None):
    """A lazily read dataset; for a time-dependent one, the rows up to the recorded times."""
    dataset = group.get(name)
    sound = isinstance(dataset, h5py.Dataset) and dataset.ndim == len(dims) and (rows is None or (
        dataset.shape[0] >= rows and dataset.shape[2] == len(COMPONENTS)))
    if not sound:
        raise DroverError(f"{path}: {group.name}/{name} is not an array over {', '.join(dims)}; the file is damaged, "
                          f"or from "
                          "another version of drover")
    check_dataset(dataset, path, "fi")
    shape = dataset.shape if rows is None else (rows, *dataset.shape[1:])
    return xarray.Variable(dims, indexing.LazilyIndexedArray(StoredArray(store, dataset, shape)),
                           attributes_of(dataset))


def sides_of(run):
    """Sides of the bounding rectangle of the cell, which is centred on x = y = 0 [mm]."""
    if run.store is None:  # in memory
        return run.attributes["sides"]
    edges = run.store.read(f"/{SPHERES}/box/edges/value", (0,))
    return numpy.diag(edges)[:2]
