"""drover/stored.py: groups of an HDF5 archive as xarray datasets, whose arrays stay in the file until they are used.

A file from elsewhere is not trusted: no link may lead out of it, no filter may load a plugin, and no array may claim
more than its bytes can hold.  (Metadata that are damaged just so still break HDF5 itself, and with it the process.)
"""
import os
import time

import h5py
import numpy
import xarray
from xarray.backends import BackendArray
from xarray.core import indexing

from drover.error import DroverError

COMMIT_SECONDS = 2.0    # a commit of a run that is going on takes far less
QUIET_SECONDS = 0.1     # a file that was written to before that long is not being written to: clocks of files tick slowly
BROKEN = (OSError, RuntimeError, LookupError, TypeError, ValueError, AttributeError)  # raised by h5py on such files
INFLATION_MOST = 1032   # deflate cannot make more bytes than this of one
CHUNK_LEAST = 1 << 20   # bytes that a chunk may take however little it holds
FILTERS = (h5py.h5z.FILTER_DEFLATE, h5py.h5z.FILTER_SHUFFLE, h5py.h5z.FILTER_FLETCHER32)
NETCDF_NAMES = ("CLASS", "NAME", "REFERENCE_LIST", "DIMENSION_LIST")  # of attributes that belong to the format


class Store:
    """An archive that is open for reading.  Its run may go on writing: rows that are there stay, but HDF5 remembers
    where they were, so what cannot be read any more is read from the file opened anew.  Another array of the same size
    may stand in that place by now, and no checksum tells; so of a file that is written to, two readings must agree."""

    def __init__(self, path):
        self.path, self.file, self.stream, self.state, self.quiet = path, None, None, None, False
        self.open()

    def open(self):
        wait_for_journal(self.path)
        self.state = state_of(self.path)
        self.quiet = is_quiet(self.state)
        # By a stream of its own: HDF5 would share what it remembers with any other use of this file in the process.
        self.stream = open(self.path, "rb")
        try:
            self.file = h5py.File(self.stream, "r")
        except BaseException:
            self.stream.close()
            raise

    def close(self):
        if self.file is not None:
            self.file.close()
            self.stream.close()
        self.file = None

    def read(self, name, key):
        if self.file is None:
            raise DroverError(f"{self.path} is closed and {name} was not read before; open it again by drover.open_run")
        deadline = time.monotonic() + COMMIT_SECONDS
        before = None
        while True:
            try:
                values = self.file[name][key]
                now = state_of(self.path)
                # A file that is gone or replaced stays as it was.
                if (self.quiet and now == self.state) or now is None or now[0] != self.state[0]:
                    return values
                if before is not None and numpy.array_equal(values, before, equal_nan=True):
                    return values
                if before is not None and time.monotonic() > deadline:
                    raise OSError(f"two readings of {name} did not agree")
                before = values
            except BROKEN:
                now = state_of(self.path)
                if now == self.state or now is None or now[0] != self.state[0] or time.monotonic() > deadline:
                    raise
            self.close()
            self.open()


class Held:
    """What reads from a store until it is closed, by close() or at the end of `with`."""

    def close(self):
        self.store.close()

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.close()


class StoredArray(BackendArray):
    """One dataset of a store, of a shape that lies in it, read where it is indexed."""

    def __init__(self, store, dataset, shape):
        self.store, self.name, self.shape, self.dtype = store, dataset.name, shape, dataset.dtype

    def __getitem__(self, key):
        return indexing.explicit_indexing_adapter(key, self.shape, indexing.IndexingSupport.OUTER_1VECTOR, self.read)

    def read(self, key):
        # The run may have appended since: an open end is the end that there was.
        key = tuple(slice(*part.indices(size)) if isinstance(part, slice) else part
                    for part, size in zip(key, self.shape))
        return self.store.read(self.name, key)


def state_of(path):
    """What changes when a file is written or replaced; None when it is gone.  Its first part is the file's number."""
    try:
        state = os.stat(path)
    except OSError:
        return None
    return state.st_ino, state.st_size, state.st_mtime_ns


def is_quiet(state):
    """Whether a file of this state has not been written to for a while."""
    return state is not None and time.time() - 1e-9 * state[2] > QUIET_SECONDS


def wait_for_journal(path):
    """While a journal stands beside an archive its last commit is not whole in the file."""
    journal = path.with_name(path.name + ".journal")
    deadline = time.monotonic() + COMMIT_SECONDS
    while journal.exists():
        if time.monotonic() > deadline:
            raise DroverError(f"{path}: its run was cut off while it wrote (the journal {journal.name} stands beside "
                              f"it); mend it first: drover info {path}")
        time.sleep(0.01)


def group_dataset(store, group):
    """A group as a dataset; raises DroverError for what is not sound."""
    file, path = store.file, store.path
    if not isinstance(file.get(group), h5py.Group):
        raise DroverError(f"{path} holds no group {group}; expected one in an archive of drover: the file is damaged, "
                          "or of another version")
    names = sound_datasets(file[group], path)
    variables, axes = {}, {name: file[group][name].shape[0] for name in names if is_axis(file[group][name])}
    for name in names:
        dataset = file[group][name]
        dims = (name,) if name in axes else dimensions(dataset, path)
        shape = tuple(axes.get(axis) for axis in dims)
        # The run may have appended rows since its times were counted.
        grown = not store.quiet and dims[:1] == ("time",) and dataset.shape[1:] == shape[1:]
        if dataset.shape != shape and not (grown and dataset.shape[0] > shape[0]):
            raise DroverError(f"{path}: {dataset.name} has the shape {dataset.shape} over {dims}, of {shape}; the file is "
                              "damaged: take another copy of it")
        data = (dataset[:shape[0]] if name in axes else
                indexing.LazilyIndexedArray(StoredArray(store, dataset, shape)))
        if name in axes and not (numpy.diff(data) > 0.0).all():
            raise DroverError(f"{path}: {dataset.name} does not ascend; the file is damaged, or its run wrote to it just "
                              "now: try again, then take another copy of it")
        variables[name] = xarray.Variable(dims, data, attributes_of(dataset))
    return xarray.Dataset({name: variables[name] for name in names if name not in axes},
                          {name: variables[name] for name in axes})


def is_axis(dataset):
    return dataset.ndim == 1 and h5py.h5ds.is_scale(dataset.id)


def dimensions(dataset, path):
    """Names of the axes of a dataset."""
    if not all(len(scales) == 1 for scales in dataset.dims):
        raise DroverError(f"{path}: {dataset.name} lacks the names of its axes; the file is damaged: take another copy "
                          "of it")
    return tuple(scales[0].name.split("/")[-1] for scales in dataset.dims)


def attributes_of(item):
    """Attributes that are one number or one text."""
    attributes = {}
    for name in item.attrs:
        if name in NETCDF_NAMES or item.attrs.get_id(name).shape != ():
            continue
        value = item.attrs[name]
        value = value.item() if hasattr(value, "item") else value
        attributes[name] = value.decode(errors="replace") if isinstance(value, bytes) else value
    return attributes


def sound_datasets(group, path):
    """Names of the datasets of a group, each of which may be read."""
    names = []
    for name in group:
        if not isinstance(group.get(name, getlink=True), h5py.HardLink):
            raise DroverError(f"{path}: {name} is a link to elsewhere; expected the data itself, links are not "
                              "followed")
        item = group[name]
        if isinstance(item, h5py.Dataset):
            check_dataset(item, path)
            names.append(name)
    return names


def check_dataset(dataset, path, kinds="f"):
    if dataset.is_virtual or dataset.external:
        raise DroverError(f"{path}: {dataset.name} keeps its data in other files; expected the data itself")
    filters = dataset.id.get_create_plist()
    for code in (filters.get_filter(i)[0] for i in range(filters.get_nfilters())):
        if code not in FILTERS:
            raise DroverError(f"{path}: {dataset.name} is stored with the HDF5 filter {code}; expected deflate, "
                              "shuffle or fletcher32, or none")
    if dataset.dtype.kind not in kinds:
        raise DroverError(f"{path}: {dataset.name} is of type {dataset.dtype}; expected real numbers: the file is "
                          "damaged")
    most = INFLATION_MOST * dataset.id.get_storage_size()
    chunk = int(numpy.prod(dataset.chunks or (0,), dtype=object)) * dataset.dtype.itemsize
    if dataset.nbytes > most or chunk > max(most, CHUNK_LEAST):
        raise DroverError(f"{path}: {dataset.name} claims {dataset.nbytes} bytes and holds "
                          f"{dataset.id.get_storage_size()}; the file is damaged: take another copy of it")
