"""drover/hdf5_reader.py: groups of an archive as lazily read xarray datasets.

The library reads the file: it trusts none, and what it returns is of one commit of a run in progress.
"""
import os
from dataclasses import dataclass
from pathlib import Path

import numpy
import xarray
from xarray.backends import BackendArray
from xarray.core import indexing

from drover import _drover
from drover.error import DroverError
from drover.locks import hdf5

WHOLE = 1 << 28  # bytes up to which the rows between the first and the last that are wanted are read at once
NETCDF_NAMES = ("CLASS", "NAME", "REFERENCE_LIST", "DIMENSION_LIST")  # attributes of the format itself


@dataclass(frozen=True)
class Stored:
    """What a file says of one array."""

    path: str         # "/observables/polar_order"
    shape: tuple
    is_integer: bool
    axes: tuple       # names of its dimension scales, its own if it is one; () without them
    attributes: dict

    @property
    def name(self):
        return self.path.rsplit("/", 1)[1]

    @property
    def is_axis(self):
        return self.axes == (self.name,)


class Store:
    """An archive open for reading, while its run may continue to write: its contents when it was opened."""

    def __init__(self, path):
        self.path, self.absolute = path, Path(path).absolute()
        self.open(path)
        with hdf5():
            attributes, groups, arrays = self.reader.contents()
        self.attributes = without_format(attributes)
        self.groups = ["/", *groups]
        self.arrays = {row[0]: Stored(*row[:-1], without_format(row[-1])) for row in arrays}

    def open(self, path):
        with hdf5():
            self.reader, self.process = _drover.Archive(os.fspath(path)), os.getpid()

    def close(self):
        self.reader = None

    def __deepcopy__(self, memo):
        """A copy of what is lazily read from a file reads the same file, until it is closed by itself."""
        copy = memo[id(self)] = Store.__new__(Store)
        copy.__setstate__(self.__getstate__())
        return copy

    def __getstate__(self):
        return {**self.__dict__, "reader": self.reader is not None}

    def __setstate__(self, state):
        self.__dict__.update(state)
        if self.reader:
            self.open(self.absolute)
        else:
            self.close()

    def arrays_in(self, group):
        """The arrays of a group, without those of groups in it."""
        start = group.rstrip("/") + "/"
        return [array for path, array in self.arrays.items() if path == start + array.name]

    def groups_in(self, group):
        """The names of the groups in a group, in the order of their creation."""
        start = group.rstrip("/") + "/"
        names = [path.removeprefix(start) for path in self.groups if path.startswith(start)]
        return [name for name in names if name and "/" not in name]

    def read(self, array, rows=None):
        """The values of an array, or of (first, count) of its rows."""
        if self.reader is None:
            raise DroverError(f"{self.path} is closed and {array.path} had not been read; open it again with "
                              "drover.open_run")
        if self.process != os.getpid():  # after a fork: the file has one position and one lock for both
            self.open(self.absolute)
        with hdf5():
            values = self.reader.read(array.path, rows)
        return values.astype(numpy.int64) if array.is_integer else values


class StoreOwner:
    """Base of classes that read from a store until close() or the end of `with`."""

    def close(self):
        self.store.close()

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.close()


class StoredArray(BackendArray):
    """One array of a store, up to a number of rows, and read when it is indexed."""

    def __init__(self, store, array, shape):
        self.store, self.array, self.shape = store, array, shape
        self.dtype = numpy.dtype(numpy.int64 if array.is_integer else numpy.float64)

    def __getitem__(self, key):
        return indexing.explicit_indexing_adapter(key, self.shape, indexing.IndexingSupport.OUTER_1VECTOR, self.read)

    def read(self, key):
        if not self.shape:
            return self.store.read(self.array)[key]
        wanted = numpy.arange(self.shape[0])[key[0]]
        rows = numpy.atleast_1d(wanted)
        if not rows.size:
            return numpy.empty((0, *self.shape[1:]), self.dtype)[(slice(None), *key[1:])]
        first, count = int(rows.min()), int(rows.max() - rows.min()) + 1
        if count * self.dtype.itemsize * int(numpy.prod(self.shape[1:], dtype=object)) <= WHOLE or count == len(rows):
            values = self.store.read(self.array, (first, count))[rows - first]
        else:
            values = numpy.concatenate([self.store.read(self.array, (int(row), 1)) for row in rows])
        return (values if wanted.ndim else values[0])[(slice(None), *key[1:]) if wanted.ndim else key[1:]]


def without_format(attributes):
    return {name: value for name, value in attributes.items() if name not in NETCDF_NAMES}


def state_of(path):
    """State that changes when a file is written or replaced: inode, size, time; None if the file is gone."""
    try:
        state = os.stat(path)
    except OSError:
        return None
    return state.st_ino, state.st_size, state.st_mtime_ns


def group_dataset(store, group):
    """A group of the file as a dataset; raises DroverError for damaged groups."""
    group = "/" + group.strip("/")
    if group not in store.groups:
        raise DroverError(f"{store.path} has no group {group}; the file is damaged, or from another version of drover")
    arrays = store.arrays_in(group)
    sizes = {array.name: array.shape[0] for array in arrays if array.is_axis}
    variables = {}
    for array in arrays:
        if len(array.axes) != len(array.shape):
            raise DroverError(f"{store.path}: {array.path} has no axis names; the file is damaged: use another copy")
        shape = tuple(map(sizes.get, array.axes))
        if array.shape != shape:
            raise DroverError(f"{store.path}: {array.path} has the shape {array.shape}, but its axes {array.axes} have "
                              f"{shape}; the file is damaged: use another copy")
        data = (store.read(array, (0, shape[0])) if array.is_axis else
                indexing.LazilyIndexedArray(StoredArray(store, array, shape)))
        if array.is_axis and not (numpy.isfinite(data).all() and (numpy.diff(data) > 0.0).all()):
            raise DroverError(f"{store.path}: {array.path} is not ascending; the file is damaged: use another copy")
        variables[array.name] = xarray.Variable(array.axes, data, array.attributes)
    return xarray.Dataset({name: found for name, found in variables.items() if name not in sizes},
                          {name: variables[name] for name in sizes})
