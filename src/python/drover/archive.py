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
from drover.stored import (BROKEN, COMMIT_SECONDS, Store, StoreOwner, attributes_of, group_dataset, is_quiet, names_of,
                           state_of)


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
    path = Path(path)
    return settled(path, lambda: open_once(path, read_run))


def loaded(array, path):
    """Loads an array of a run into memory; raises DroverError if the file is damaged, or a frame is not finite."""
    try:
        array.load()
    except BROKEN as error:
        raise DroverError(damaged(path, f"{array.name} cannot be read", error)) from error
    is_of_frames = {"x", "y"} <= set(array.dims) or "component" in array.dims
    if is_of_frames and not numpy.isfinite(array.values).all():
        raise DroverError(f"{path}: {array.name} has values that are not finite, which drover never writes; the file "
                          "is damaged: use another copy")
    return array


def settled(path, action):
    """Result of an action on a file, which is repeated if the run wrote to the file meanwhile."""
    deadline = time.monotonic() + COMMIT_SECONDS
    while True:
        before = state_of(path)
        try:
            return action()
        except DroverError:
            now = state_of(path)
            if now is None or (now == before and is_quiet(now)) or time.monotonic() > deadline:
                raise
            time.sleep(0.01)


def open_once(path, read):
    """Opens an archive and returns the result of a reader."""
    check_is_file(path)
    try:
        store = Store(path)
    except BROKEN as error:
        raise DroverError(not_hdf5(path, error)) from error
    try:
        result = read(store, path)
        store.check()
        store.require_sound()
        store.unlock()
        return result
    except (*BROKEN, DroverError) as error:
        store.close()
        store.check()  # the cause
        if isinstance(error, DroverError):
            raise
        raise DroverError(damaged(path, "cannot be read", error)) from error


def read_head(store, path):
    """Attributes of an archive and its scene."""
    attributes = attributes_of(store.file)
    if "drover_version" not in attributes or not isinstance(attributes.get("scene"), str):
        raise DroverError(f"{path} is HDF5 but not a drover archive (its root has no attributes drover_version and "
                          "scene); expected an archive written by drover run")
    try:
        return attributes, tomllib.loads(attributes["scene"])
    except tomllib.TOMLDecodeError as error:
        raise DroverError(damaged(path, "its scene is not TOML", error)) from error


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
    summary = group_dataset(store, "/summary") if "summary" in store.file else None
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
    return next(reversed(names_of(store.file)), "map")


def check_is_file(path):
    if path.is_dir():
        raise DroverError(f"{path} is a folder; expected an archive, such as isotropic.h5")
    if not path.exists():
        raise DroverError(f"{path} does not exist; expected an archive: drover run SCENE writes one")
    if not path.is_file():
        raise DroverError(f"{path} is not a plain file; expected an archive, such as isotropic.h5")
    if not os.access(path, os.R_OK):
        raise DroverError(f"{path} cannot be read: permission denied; check the permissions of the file")


def not_hdf5(path, error):
    """Message for a file that HDF5 cannot open."""
    reason, size = one_line(error), path.stat().st_size if path.exists() else 0
    if path.suffix == ".toml":
        return f"{path} is a scene; expected an archive: drover run {path} writes one"
    if size == 0:
        return f"{path} is empty; expected an archive, such as isotropic.h5: run its scene again with drover run"
    if "truncated" in reason:
        return f"{path} is truncated: it has only {size} bytes; copy it again, or run its scene again"
    if "signature" in reason:
        return f"{path} is not an HDF5 file; expected an archive, such as isotropic.h5, which drover run writes"
    return damaged(path, "cannot be read as HDF5", error)


def damaged(path, what, error):
    return (f"{path}: {what} ({one_line(error)}); the file is damaged, or its run is writing to it: try again, "
            "then use another copy")


def one_line(error):
    return " ".join(str(error).split())
