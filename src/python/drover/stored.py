"""drover/stored.py: groups of an HDF5 archive as xarray datasets, whose arrays stay in the file until they are used.

A file from elsewhere is not trusted: no link may lead out of it, no filter may load a plugin, and no array may claim more
than its bytes can hold.  (Metadata that are damaged just so still break HDF5 itself, and with it the process.)
"""
import h5py
import numpy
import xarray
from xarray.backends import BackendArray
from xarray.core import indexing

from drover.error import DroverError

INFLATION_MOST = 1032   # deflate cannot make more bytes than this of one
CHUNK_LEAST = 1 << 20   # bytes that a chunk may take however little it holds
FILTERS = (h5py.h5z.FILTER_DEFLATE, h5py.h5z.FILTER_SHUFFLE, h5py.h5z.FILTER_FLETCHER32)
NETCDF_NAMES = ("CLASS", "NAME", "REFERENCE_LIST", "DIMENSION_LIST")  # of attributes that belong to the format


class StoredArray(BackendArray):
    """One dataset of a file, read where it is indexed."""

    def __init__(self, dataset):
        self.dataset, self.shape, self.dtype = dataset, dataset.shape, dataset.dtype

    def __getitem__(self, key):
        return indexing.explicit_indexing_adapter(key, self.shape, indexing.IndexingSupport.OUTER_1VECTOR,
                                                  self.dataset.__getitem__)


def group_dataset(file, group, path):
    """A group as a dataset; raises DroverError for what is not sound."""
    if not isinstance(file.get(group), h5py.Group):
        raise DroverError(f"{path} holds no group {group}; expected one in an archive of drover: the file is damaged, "
                          "or of another version")
    names = sound_datasets(file[group], path)
    variables, axes = {}, {name: file[group][name].shape[0] for name in names if is_axis(file[group][name])}
    for name in names:
        dataset = file[group][name]
        dims = (name,) if name in axes else dimensions(dataset, path)
        if dataset.shape != tuple(axes.get(axis) for axis in dims):
            raise DroverError(f"{path}: {dataset.name} has the shape {dataset.shape} over {dims}, of "
                              f"{tuple(axes.get(axis) for axis in dims)}; the file is damaged: take another copy of it")
        data = dataset[()] if name in axes else indexing.LazilyIndexedArray(StoredArray(dataset))
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


def check_dataset(dataset, path):
    if dataset.is_virtual or dataset.external:
        raise DroverError(f"{path}: {dataset.name} keeps its data in other files; expected the data itself")
    filters = dataset.id.get_create_plist()
    for code in (filters.get_filter(i)[0] for i in range(filters.get_nfilters())):
        if code not in FILTERS:
            raise DroverError(f"{path}: {dataset.name} is stored with the HDF5 filter {code}; expected deflate, "
                              "shuffle or fletcher32, or none")
    if dataset.dtype.kind != "f":
        raise DroverError(f"{path}: {dataset.name} is of type {dataset.dtype}; expected real numbers: the file is "
                          "damaged")
    most = INFLATION_MOST * dataset.id.get_storage_size()
    chunk = int(numpy.prod(dataset.chunks or (0,), dtype=object)) * dataset.dtype.itemsize
    if dataset.nbytes > most or chunk > max(most, CHUNK_LEAST):
        raise DroverError(f"{path}: {dataset.name} claims {dataset.nbytes} bytes and holds "
                          f"{dataset.id.get_storage_size()}; the file is damaged: take another copy of it")
