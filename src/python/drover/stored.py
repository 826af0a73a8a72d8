"""drover/stored.py: groups of an HDF5 archive as lazily read xarray datasets.

Files are not trusted: links, filters that load plugins, and arrays larger than their stored bytes allow are rejected.
(Certain damaged metadata can still crash HDF5 itself, and the process with it.)
"""
import errno
import fcntl
import io
import os
import struct
import time

import h5py
import numpy
import xarray
from xarray.backends import BackendArray
from xarray.core import indexing

from drover.error import DroverError
from drover.locks import require_usable_hdf5

COMMIT_SECONDS = 2.0    # much longer than a commit of a run in progress
PATIENCE_SECONDS = 0.2  # for which a commit waits for readers that hold its lock
COMMIT_BYTE = 1 << 62   # of a file: readers lock it, and a run locks it while it overwrites others
QUIET_SECONDS = 0.1     # a file unmodified for this long is not being written to (file times are coarse)
BROKEN = (OSError, RuntimeError, LookupError, TypeError, ValueError, AttributeError)  # raised by h5py on such files
MAX_INFLATION = 1032    # largest compression ratio of deflate
MIN_CHUNK = 1 << 20     # bytes that a chunk may always occupy
FILTERS = (h5py.h5z.FILTER_DEFLATE, h5py.h5z.FILTER_SHUFFLE, h5py.h5z.FILTER_FLETCHER32)
NETCDF_NAMES = ("CLASS", "NAME", "REFERENCE_LIST", "DIMENSION_LIST")  # attributes of the format itself


class CheckedStream(io.FileIO):
    """A file for HDF5.  An exception within a call of HDF5 1.10 may damage its memory: a failed read gives zeros
    instead, as does every later one, and check() raises an Error after the call.
    """

    failure = None  # a text: HDF5 holds this stream, and an exception would hold objects that must be closed first

    def readinto(self, buffer):
        view, done = memoryview(buffer).cast("B"), 0
        try:
            while not self.failure and done < len(view) and (count := super().readinto(view[done:])):
                done += count
        except OSError as failure:
            self.failure = failure.strerror
        if self.failure:
            view[done:] = bytes(len(view) - done)
            return len(view)
        return done

    def check(self):
        if self.failure:
            raise DroverError(f"the disk reports a failure: read: {self.failure}; nothing was changed; check "
                              "the disk, then run the same command again", str(self.name), "environment")


class Store:
    """An archive open for reading, while its run may continue to write.

    Existing rows never change, but HDF5 caches where they are, and later commits write other arrays there, which no
    checksum detects.  So while a file is being written it is opened again for each reading, with a lock for which
    commits wait a little.  Where that is not enough, or cannot be had, two readings must agree.
    """

    def __init__(self, path):
        self.path, self.file, self.stream, self.state, self.quiet = path, None, None, None, False
        self.process, self.locked = None, None
        self.open()

    def open(self):
        """Opens the file, locked until unlock() if it may be being written."""
        require_usable_hdf5()
        deadline = time.monotonic() + COMMIT_SECONDS
        while True:
            wait_for_journal(self.path)
            self.state, self.process = state_of(self.path), os.getpid()
            self.quiet = is_quiet(self.state)
            # A separate stream: HDF5 would share its cache with other uses of this file in the process.
            self.stream = CheckedStream(self.path)
            self.locked = lock(self.stream, deadline)
            # A commit that has begun since waits for the lock, or was killed.
            if self.locked is None or not journal_of(self.path).exists() or time.monotonic() > deadline:
                break
            self.stream.close()
        try:
            self.file = h5py.File(self.stream, "r")
        except BaseException:
            self.stream.close()
            self.stream.check()  # the cause
            raise
        self.check()

    def check(self):
        """Raises an Error if a read has failed, and lets no later one use what HDF5 has cached."""
        if self.stream.failure:
            self.close()
            self.stream.check()

    def close(self):
        if self.file is not None:
            self.file.close()
            self.stream.close()
        self.file, self.locked = None, None

    def unlock(self):
        if self.locked is not None:
            fcntl.fcntl(self.stream, fcntl.F_OFD_SETLK, lock_request(fcntl.F_UNLCK))
        self.locked = None

    def is_sound(self):
        """Whether no commit has changed what was read since the file was opened."""
        now = state_of(self.path)
        is_locked = self.locked is not None
        return ((now == self.state and (self.quiet or is_locked))
                or (is_locked and time.monotonic() - self.locked < PATIENCE_SECONDS)
                or now is None or now[0] != self.state[0])  # a deleted or replaced file no longer changes

    def require_sound(self):
        """Raises DroverError if a commit may have changed what was read; not on a file system without locks."""
        if self.locked is not None and not self.is_sound():
            raise DroverError(f"{self.path} is being written faster than it can be read; try again, or wait for the "
                              "end of its run")

    def read(self, name, key):
        if self.file is None:
            raise DroverError(f"{self.path} is closed and {name} had not been read; open it again with drover.open_run")
        require_usable_hdf5()
        is_of_parent = self.process != os.getpid()  # after a fork: the stream has one position for both
        if is_of_parent or (self.locked is None and not self.is_sound()):
            self.close()
            self.open()
        deadline = time.monotonic() + COMMIT_SECONDS
        before = None
        while True:
            try:
                values = self.file[name][key]
                self.check()
                if self.is_sound():
                    self.unlock()
                    return values
                if before is not None and numpy.array_equal(values, before, equal_nan=True):
                    self.unlock()
                    return values
                if before is not None and time.monotonic() > deadline:
                    raise OSError(f"two readings of {name} did not agree")
                before = values
            except BROKEN:
                self.check()  # the cause
                if self.is_sound() or time.monotonic() > deadline:
                    self.unlock()
                    raise
            self.close()
            self.open()


class StoreOwner:
    """Base of classes that read from a store until close() or the end of `with`."""

    def close(self):
        self.store.close()

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.close()


class StoredArray(BackendArray):
    """One dataset of a store, restricted to a shape and read when it is indexed."""

    def __init__(self, store, dataset, shape):
        self.store, self.name, self.shape, self.dtype = store, dataset.name, shape, dataset.dtype

    def __getitem__(self, key):
        return indexing.explicit_indexing_adapter(key, self.shape, indexing.IndexingSupport.OUTER_1VECTOR, self.read)

    def read(self, key):
        # The run may have appended rows: open slices end at the original shape.
        key = tuple(slice(*part.indices(size)) if isinstance(part, slice) else part
                    for part, size in zip(key, self.shape))
        return self.store.read(self.name, key)


def state_of(path):
    """State that changes when a file is written or replaced: inode, size, time; None if the file is gone."""
    try:
        state = os.stat(path)
    except OSError:
        return None
    return state.st_ino, state.st_size, state.st_mtime_ns


def is_quiet(state):
    """Whether the file has not been modified recently."""
    return state is not None and time.time() - 1e-9 * state[2] > QUIET_SECONDS


def lock_request(kind):
    """struct flock of fcntl for COMMIT_BYTE."""
    return struct.pack("@hhqqi0q", kind, os.SEEK_SET, COMMIT_BYTE, 1, 0)


def lock(stream, deadline):
    """Makes commits wait for this reader, for PATIENCE_SECONDS: the time at which they began to, or None on a file
    system without locks, or when a run was stopped within a commit."""
    while True:
        begin = time.monotonic()
        try:
            fcntl.fcntl(stream, fcntl.F_OFD_SETLK, lock_request(fcntl.F_RDLCK))
            return begin
        except OSError as error:
            if error.errno not in (errno.EAGAIN, errno.EACCES) or time.monotonic() > deadline:
                return None
        time.sleep(0.001)


def journal_of(path):
    return path.with_name(path.name + ".journal")


def wait_for_journal(path):
    """Waits until the last commit is complete: a journal exists until then."""
    journal = journal_of(path)
    deadline = time.monotonic() + COMMIT_SECONDS
    while journal.exists():
        if time.monotonic() > deadline:
            raise DroverError(f"{path}: its run was interrupted while writing (the journal {journal.name} exists); "
                              f"repair it first: drover info {path}")
        time.sleep(0.01)


def group_dataset(store, group):
    """Reads a group as a dataset; raises DroverError for damaged groups."""
    file, path = store.file, store.path
    if not isinstance(file.get(group), h5py.Group):
        raise DroverError(f"{path} has no group {group}; the file is damaged, "
                          "or from another version of drover")
    names = valid_datasets(file[group], path)
    variables, axes = {}, {name: file[group][name].shape[0] for name in names if is_axis(file[group][name])}
    for name in names:
        dataset = file[group][name]
        dims = (name,) if name in axes else dimensions(dataset, path)
        shape = tuple(axes.get(axis) for axis in dims)
        # The run may have appended rows since its times were read.
        grown = not store.quiet and dims[:1] == ("time",) and dataset.shape[1:] == shape[1:]
        if dataset.shape != shape and not (grown and dataset.shape[0] > shape[0]):
            raise DroverError(f"{path}: {dataset.name} has the shape {dataset.shape}, but its axes {dims} have "
                              f"{shape}; the file is "
                              "damaged: use another copy")
        data = (dataset[:shape[0]] if name in axes else
                indexing.LazilyIndexedArray(StoredArray(store, dataset, shape)))
        if name in axes and not (numpy.isfinite(data).all() and (numpy.diff(data) > 0.0).all()):
            raise DroverError(f"{path}: {dataset.name} is not ascending; the file is damaged, or its run is writing to "
                              "it: try again, then use another copy")
        variables[name] = xarray.Variable(dims, data, attributes_of(dataset))
    return xarray.Dataset({name: variables[name] for name in names if name not in axes},
                          {name: variables[name] for name in axes})


def is_axis(dataset):
    return dataset.ndim == 1 and h5py.h5ds.is_scale(dataset.id)


def dimensions(dataset, path):
    """Names of the axes of a dataset."""
    if not all(len(scales) == 1 for scales in dataset.dims):
        raise DroverError(f"{path}: {dataset.name} has no axis names; the file is damaged: use another "
                          "copy")
    return tuple(scales[0].name.split("/")[-1] for scales in dataset.dims)


def attributes_of(item):
    """Scalar attributes: numbers and texts."""
    attributes = {}
    for name in item.attrs:
        if name in NETCDF_NAMES or item.attrs.get_id(name).shape != ():
            continue
        value = item.attrs[name]
        value = value.item() if hasattr(value, "item") else value
        attributes[name] = value.decode(errors="replace") if isinstance(value, bytes) else value
    return attributes


def names_of(group):
    """Names in a group, in the order of their creation if it is known.

    HDF5 1.10 sorts names in a table, which it frees before it is filled if a read fails; so they are sorted here.
    """
    names = []
    group.id.links.iterate(names.append, order=h5py.h5.ITER_NATIVE)

    def rank(name):
        link = group.id.links.get_info(name)
        return link.corder if link.corder_valid else 0, name
    return [name.decode() for name in sorted(names, key=rank)]


def valid_datasets(group, path):
    """Names of the datasets of a group, all checked."""
    names = []
    for name in names_of(group):
        if not isinstance(group.get(name, getlink=True), h5py.HardLink):
            raise DroverError(f"{path}: {name} is a link; expected the data itself, since links are not "
                              "followed")
        item = group[name]
        if isinstance(item, h5py.Dataset):
            check_dataset(item, path)
            names.append(name)
    return names


def check_dataset(dataset, path, kinds="f"):
    if dataset.is_virtual or dataset.external:
        raise DroverError(f"{path}: {dataset.name} stores its data in other files; expected the data in this file")
    filters = dataset.id.get_create_plist()
    for code in (filters.get_filter(i)[0] for i in range(filters.get_nfilters())):
        if code not in FILTERS:
            raise DroverError(f"{path}: {dataset.name} is stored with the HDF5 filter {code}; expected deflate, "
                              "shuffle or fletcher32, or none")
    if dataset.dtype.kind not in kinds:
        raise DroverError(f"{path}: {dataset.name} is of type {dataset.dtype}; expected real numbers: the file is "
                          "damaged")
    most = MAX_INFLATION * dataset.id.get_storage_size()
    chunk = int(numpy.prod(dataset.chunks or (0,), dtype=object)) * dataset.dtype.itemsize
    if dataset.nbytes > most or chunk > max(most, MIN_CHUNK):
        raise DroverError(f"{path}: {dataset.name} claims {dataset.nbytes} bytes but stores "
                          f"{dataset.id.get_storage_size()}; the file is damaged: use another copy")
