"""drover/archive.py: opens the archive of a run: frames, observables, summary and scene."""
import os
import time
import tomllib
from dataclasses import dataclass
from pathlib import Path

import numpy
import xarray

from drover.error import DroverError
from drover.fields import fields_of
from drover.particles import is_of_particles, read_particles, rows_of
from drover.hdf5_reader import Store, StoreOwner, group_dataset

FIRST_FRAME = 2.0   # s in which a run that has begun writes its first frame
JUST_WRITTEN = 0.1  # s


@dataclass(frozen=True)
class Run(StoreOwner):
    """One run.  Arrays are read when they are used; close() it, or open it using `with`.

    For a run in progress it contains the rows present when it was opened: open it again for more.
    """

    path: Path
    frames: xarray.Dataset          # fields over (time, y, x)
    observables: xarray.Dataset     # series over time
    summary: xarray.Dataset | None  # means with errors and linear theory; None until the run has finished
    scene: dict                     # all keys with their values: scene["relaxation"]["rate"]
    attributes: dict                # provenance: version, commit, seed, host, ...
    store: Store

    def __repr__(self):
        return f"<drover.Run {self.path.name}: {', '.join(map(str, self.frames.data_vars))}, {rows_of(self)}>"


def open_run(path):
    """Opens an archive written by `drover run`: returns a Run (fields) or a ParticleRun.

    Raises DroverError if the file is not such an archive, or is damaged.
    """
    return opened(Path(path), read_run)


def loaded(array, path):
    """Loads an array of a run into memory; raises DroverError if the file is damaged, or a frame is not finite."""
    array.load()
    is_of_frames = {"x", "y"} <= set(array.dims) or "component" in array.dims
    if is_of_frames and not numpy.isfinite(array.values).all():
        raise DroverError(f"{path}: {array.name} has values that are not finite, which drover never writes; the file "
                          "is damaged: use another copy")
    return array


def opened(path, read):
    """Opens an archive and returns the result of a reader; waits a little for a run that has just begun."""
    deadline = time.monotonic() + FIRST_FRAME
    while True:
        check_is_file(path)
        begun = time.time() - path.stat().st_mtime < JUST_WRITTEN
        store = None
        try:
            store = Store(path)
            return read(store, path)
        except BaseException as error:
            if store is not None:
                store.close()
            if not (begun and isinstance(error, DroverError)) or time.monotonic() > deadline:
                raise
        time.sleep(0.01)


def read_head(store, path):
    """Attributes of an archive and its scene."""
    attributes = store.attributes
    if "drover_version" not in attributes or not isinstance(attributes.get("scene"), str):
        raise DroverError(f"{path} is HDF5 but not a drover archive (its root has no attributes drover_version and "
                          "scene); expected an archive written by drover run")
    try:
        return attributes, tomllib.loads(attributes["scene"])
    except tomllib.TOMLDecodeError as error:
        raise DroverError(f"{path}: its scene is not TOML ({error}); the file is damaged: use another copy") from error


def kind_of(attributes):
    """What made an archive: "run", "stability", "boundary", "onset" (boundary of a table), "states", "sweep" or
    "calibrate"."""
    words = str(attributes.get("title", "")).split()
    others = ("stability", "boundary", "onset", "states", "sweep", "calibrate")
    return words[1] if words[:1] == ["drover"] and len(words) > 1 and words[1] in others else "run"


def command_of(kind):
    """The command that writes archives of a kind."""
    return "boundary" if kind == "onset" else kind


def read_run(store, path):
    attributes, scene = read_head(store, path)
    kind = kind_of(attributes)
    check_is_no_table(path, kind)
    if kind != "run":
        raise DroverError(f"{path} is not a run: drover {command_of(kind)} wrote it; open it with drover.open_theory, "
                          f'or a group of it with xarray.open_dataset("{path}", group="{example_group(store)}")')
    if is_of_particles(scene):
        return read_particles(store, path, attributes, scene)
    frames, observables = (group_dataset(store, group) for group in ("/", "/observables"))
    summary = group_dataset(store, "/summary") if "/summary" in store.groups else None
    for name in (name for field in fields_of(scene) for name in field.components):
        if name not in frames or frames[name].dims != ("time", "y", "x"):
            raise DroverError(f"{path} has no field {name} over time, y and x; expected one for this form: the file "
                              f"is from another "
                              "version of drover, or damaged")
    if 0 in frames.sizes.values():
        raise DroverError(f"{path} contains no frames: its run ended at the start; run its scene again")
    return Run(path, frames, observables, summary, scene, attributes, store)


def check_is_no_table(path, kind):
    if kind == "calibrate":
        raise DroverError(f'{path} is a table of coefficients; read it with drover.info("{path}")["coefficients"], or '
                          f"compute its flocking threshold: drover boundary {path} -o onset.h5")


def example_group(store):
    return store.groups[-1].strip("/") or "map"


def check_is_file(path):
    if path.is_dir():
        raise DroverError(f"{path} is a folder; expected an archive, such as isotropic.h5")
    if not path.exists():
        raise DroverError(f"{path} does not exist; expected an archive: drover run SCENE writes one")
    if not path.is_file():
        raise DroverError(f"{path} is not a plain file; expected an archive, such as isotropic.h5")
    if not os.access(path, os.R_OK):
        raise DroverError(f"{path} cannot be read: permission denied; check the permissions of the file")
    if path.suffix == ".toml":
        raise DroverError(f"{path} is a scene; expected an archive: drover run {path} writes one")
    if path.stat().st_size == 0:
        raise DroverError(f"{path} is empty; expected an archive, such as isotropic.h5: run its scene again with "
                          "drover run")
