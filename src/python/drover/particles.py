"""drover/particles.py: a run of particles read back from its archive: bodies, spheres, series, summary and the scene."""
from dataclasses import dataclass
from pathlib import Path

import h5py
import numpy
import xarray
from xarray.core import indexing

from drover.error import DroverError
from drover.stored import Held, Store, StoredArray, attributes_of, check_dataset, group_dataset

# Groups of the file: what their arrays are called here, and the axis of their particles.
BODIES = {"bodies/beads": ("bead_", "bead"), "bodies/rods": ("rod_", "rod")}
SPHERES, SERIES = "particles/spheres", "series"
COMPONENTS = ["x", "y", "z"]


@dataclass(frozen=True)
class ParticleRun(Held):
    """One run of particles.  Arrays stay in the file until they are used; close() it, or open it by `with`.

    Of a run that is going on this holds the rows that were there when it was opened: open it again for more.
    """

    path: Path
    frames: xarray.Dataset          # bead_position, rod_position, rod_axis, ... over (time, bead or rod, component), not wrapped
    spheres: xarray.Dataset         # position in the box, image, velocity, radius, species, body of every sphere
    observables: xarray.Dataset     # series over time
    summary: xarray.Dataset | None  # means with errors; None until the run has reached its end
    scene: dict                     # every key with its value: scene["rods"]["count"]
    attributes: dict                # where it came from: version, commit, seed, host, ...
    store: Store


def is_of_particles(scene):
    return "cell" in scene


def read_particles(store, path, attributes, scene):
    """The run in an open archive of particles."""
    spheres = trajectory(store, path, SPHERES, "", "sphere")
    frames = xarray.Dataset(coords={"time": spheres["time"], "step": spheres["step"]})
    for group, (start, axis) in BODIES.items():
        if group in store.file:
            frames = frames.merge(trajectory(store, path, group, start, axis), join="inner")
    if frames.sizes.get("time", 0) == 0:
        raise DroverError(f"{path} holds no frame; its run ended before it began: run its scene again")
    summary = group_dataset(store, "/summary") if "summary" in store.file else None
    return ParticleRun(path, frames, spheres, group_dataset(store, f"/{SERIES}"), summary, scene, attributes, store)


def trajectory(store, path, name, start, axis):
    """A group of H5MD as a dataset: what grows with time, and what stands once."""
    group = store.file.get(name)
    if not isinstance(group, h5py.Group):
        raise DroverError(f"{path} holds no group {name}; expected one in an archive of particles: the file is damaged, or of "
                          "another version")
    variables, times = {}, None
    for key in group:
        link = group.get(key, getlink=True)
        if not isinstance(link, h5py.HardLink):
            raise DroverError(f"{path}: {name}/{key} is a link to elsewhere; expected the data itself, links are not followed")
        item = group[key]
        if isinstance(item, h5py.Group) and key != "box":
            if times is None:
                times = {part: whole(item, part, path) for part in ("time", "step")}
                rows = min(map(len, times.values()))
            variables[start + key] = stored(store, path, item, "value", ("time", axis, "component"), rows)
        elif isinstance(item, h5py.Dataset):
            dims = (axis, f"{axis}_sphere")[:item.ndim]
            variables[start + key] = stored(store, path, group, key, dims)
    if times is None:
        raise DroverError(f"{path}: {name} holds no positions; the file is damaged: take another copy of it")
    coordinates = {part: ("time", values[:rows]) for part, values in times.items()}
    coordinates["time"] = ("time", times["time"][:rows], {"units": "s"})
    return xarray.Dataset(variables, {**coordinates, "component": COMPONENTS})


def whole(group, name, path):
    if not isinstance(group.get(name), h5py.Dataset) or group[name].ndim != 1:
        raise DroverError(f"{path}: {group.name} has no {name}; the file is damaged: take another copy of it")
    check_dataset(group[name], path, "fi")
    return group[name][:]


def stored(store, path, group, name, dims, rows=None):
    """A dataset that is read where it is indexed; of one that grows, as many rows as there were times."""
    dataset = group.get(name)
    sound = isinstance(dataset, h5py.Dataset) and dataset.ndim == len(dims) and (rows is None or (
        dataset.shape[0] >= rows and dataset.shape[2] == len(COMPONENTS)))
    if not sound:
        raise DroverError(f"{path}: {group.name}/{name} is not an array over {', '.join(dims)}; the file is damaged, or of "
                          "another version")
    check_dataset(dataset, path, "fi")
    shape = dataset.shape if rows is None else (rows, *dataset.shape[1:])
    return xarray.Variable(dims, indexing.LazilyIndexedArray(StoredArray(store, dataset, shape)), attributes_of(dataset))


def sides_of(run):
    """Sides of the rectangle about the cell, which is centred on x = y = 0 [mm]."""
    edges = run.store.read(f"/{SPHERES}/box/edges/value", (0,))
    return numpy.diag(edges)[:2]
