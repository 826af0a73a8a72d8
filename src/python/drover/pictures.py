"""drover/pictures.py: what a page shows of a run: fields on at most 128 by 128 points, series, a spectrum, bodies."""
from dataclasses import dataclass, field

import numpy

MAX_POINTS = 128   # along a side of a picture
MAX_ARROWS = 20    # along the longer side
MAX_SERIES = 2000  # points of a curve


@dataclass
class Picture:
    """One state of a run.  Arrays are copies."""

    time: float = 0.0                              # [s]
    fields: dict = field(default_factory=dict)     # name -> array over (y, x)
    step: tuple = (1, 1)                           # points of the grid for one of a picture, in y and in x
    is_mean: bool = True                           # over these points, or one of them
    side: tuple = (1.0, 1.0)                       # of the cell, x and y [mm]
    bodies: dict = field(default_factory=dict)     # "beads": rows (x, y, radius); "rods": (x, y, axis x, axis y)
    units: dict = field(default_factory=dict)      # of each field


def block_values(array, steps):
    """Averages (y, x) over blocks of steps[0] by steps[1] points; points beyond the last whole block are left out."""
    rows, columns = (count // step * step for count, step in zip(array.shape, steps))
    return array[:rows, :columns].reshape(rows // steps[0], steps[0], -1, steps[1]).mean(axis=(1, 3))


def reduced(array):
    """At most MAX_POINTS along each side: means over blocks where they divide the grid, else one point of each block.

    Returns the array, points in a block in y and x, and whether it holds means.

    >>> means, step, is_mean = reduced(numpy.arange(4.0 * 512).reshape(4, 512))
    >>> means.shape, step, is_mean, float(means[0, 0])
    ((4, 128), (1, 4), True, 1.5)
    >>> reduced(numpy.zeros((131, 4)))[0].shape
    (66, 4)
    """
    step = tuple(-(-size // MAX_POINTS) for size in array.shape)
    if any(size % width for size, width in zip(array.shape, step)):
        return array[::step[0], ::step[1]].copy(), step, False
    return block_values(array, step), step, True


def picture_of(time, arrays, side, units):
    """Of the fields or the bodies of a frame, arrays by name, with the units of the fields."""
    if any(name in arrays for name in ("bead_position", "rod_position")):
        return picture_of_bodies(time, arrays, side)
    return picture_of_fields(time, arrays, side, units)


def picture_of_fields(time, arrays, side, units):
    """Of arrays over (y, x) by name."""
    picture = Picture(time=time, side=side, units=units)
    for name, values in arrays.items():
        picture.fields[name], picture.step, picture.is_mean = reduced(values)
    return picture


def picture_of_bodies(time, arrays, side):
    """Of bead_position, bead_radius, rod_position, rod_axis, ... by name; places from the lower left corner."""
    picture = Picture(time=time, side=tuple(map(float, side)))
    if "bead_position" in arrays:
        places = numpy.mod(arrays["bead_position"][:, :2] + 0.5 * numpy.array(side), side)
        picture.bodies["beads"] = numpy.column_stack([places, arrays["bead_radius"]])
    if "rod_position" in arrays:
        reach = numpy.abs(arrays["rod_sphere_at"]).max(axis=1, keepdims=True)
        places = numpy.mod(arrays["rod_position"][:, :2] + 0.5 * numpy.array(side), side)
        picture.bodies["rods"] = numpy.column_stack([places, arrays["rod_axis"][:, :2] * reach])
    return picture


PAIRS = (("_x", "_y"), ("_xx", "_xy"))  # components of a vector, and of a nematic


def pairs_of(names):
    """Vectors and nematics whose components are among these, with them: polar_order of polar_order_x and _y."""
    return {name[:-len(first)]: (name, name[:-len(first)] + second) for first, second in PAIRS for name in names
            if name.endswith(first) and name[:-len(first)] + second in names}


def maps_of(names):
    """What colours can show: scalars, and magnitudes of vectors and nematics."""
    pairs = pairs_of(names)
    parts = {part for both in pairs.values() for part in both}
    return [name for name in names if name not in parts] + [f"|{name}|" for name in pairs]


def map_of(picture, name):
    """The array over (y, x) of one of maps_of()."""
    if not name.startswith("|"):
        return picture.fields[name]
    return numpy.hypot(*(picture.fields[part] for part in pairs_of(picture.fields)[name.strip("|")]))


def arrows_of(picture, name):
    """Of a vector: rows (x, y, component x, component y) of means over blocks, x and y as parts of the sides.

    Of a nematic: along its director, as long as its magnitude.
    """
    names = pairs_of(picture.fields)[name]
    shape = picture.fields[names[0]].shape
    width = -(-max(shape) // MAX_ARROWS)
    starts = [numpy.arange(0, size, width) for size in shape]
    sizes = [numpy.diff([*start, size]) for start, size in zip(starts, shape)]
    means = [numpy.add.reduceat(numpy.add.reduceat(picture.fields[part], starts[0], 0), starts[1], 1)
             / numpy.outer(*sizes) for part in names]
    y, x = ((start + 0.5 * size) / side for start, size, side in zip(starts, sizes, shape))
    arrows = numpy.stack([*numpy.meshgrid(x, y), *means], axis=-1).reshape(-1, 4)
    if names[0].endswith("_xx"):
        size, angle = numpy.hypot(arrows[:, 2], arrows[:, 3]), 0.5 * numpy.arctan2(arrows[:, 3], arrows[:, 2])
        arrows[:, 2:] = numpy.column_stack([size * numpy.cos(angle), size * numpy.sin(angle)])
    return arrows


def curves_of(observables):
    """Names of the series of numbers, and of the structure factors, of observables."""
    numbers = [name for name, values in observables.data_vars.items() if values.dims == ("time",)]
    spectra = [name for name, values in observables.data_vars.items() if values.dims == ("time", "wavenumber")]
    return numbers, sorted(spectra, key=lambda name: name.endswith("_cross"))  # which has both signs


def curve_of(observables, name):
    """A series of a number: times and values, thinned to at most MAX_SERIES points."""
    every = -(-observables.sizes["time"] // MAX_SERIES)
    return observables["time"].values[::every], observables[name].values[::every]


def spectrum_of(observables, name):
    """The mean of a structure factor over the last half of its samples: wavenumbers and values."""
    values = observables[name].values
    return observables["wavenumber"].values, values[len(values) // 2:].mean(axis=0)
