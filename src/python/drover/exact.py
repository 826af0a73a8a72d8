"""drover/exact.py: what is known exactly of a run without noise that starts from formulas: a profile in x and time."""
import numpy

from drover.error import Error
from drover.typeset import named, spaced

LARGEST_ERROR = 0.02     # of the range of the profile: a start that moves unchanged agrees to this
ROUNDING = 1e-9          # relative, of rates of waves
LEAST_STRUCTURE = 1e-3   # of the mean: the range of a profile that is not uniform


def exact_of(run, field, row):
    """A function of x and t and its label; None where nothing is known.  `row` is the field along x at every frame."""
    if run.scene.get("initial", {}).get("kind") != "formula":
        return None
    return spreading(run, field, row) or travelling(row, run.scene)


def travelling(row, scene):
    """The start, displaced at a constant speed, if the field moves unchanged; the speed is that of the second frame."""
    x, times, values = row["x"].values, row["time"].values, row.values
    size = float(numpy.ptp(values[0]))
    if not size > LEAST_STRUCTURE * abs(float(values[0].mean())) or not times[-1] > times[0]:
        return None
    side = len(x) * (x[1] - x[0])
    spectra = numpy.fft.rfft(values, axis=1)
    wavenumbers = 2.0 * numpy.pi * numpy.fft.rfftfreq(len(x), x[1] - x[0])

    def moved(distance):
        return numpy.fft.irfft(spectra[0] * numpy.exp(-1j * wavenumbers * distance), len(x))

    speed = 0.0
    for frame in range(1, len(times)):  # each frame refines the speed, which predicts the next within half a cell
        guess = speed * (times[frame] - times[0])
        shift = guess + (shift_of(spectra[0], spectra[frame], side) - guess + 0.5 * side) % side - 0.5 * side
        if abs(moved(shift) - values[frame]).max() > LARGEST_ERROR * size:
            return None
        speed = shift / (times[frame] - times[0])
    speed = 0.0 if abs(speed) * (times[-1] - times[0]) < 0.01 * (x[1] - x[0]) else speed
    words = "start, at rest" if speed == 0.0 else f"start, {speed:.4g}{spaced(named('mm/s', scene))}"
    return (lambda points, time: numpy.interp(points, x, moved(speed * (time - times[0])), period=side)), words


def shift_of(first, other, side):
    """The displacement from one spectrum of a row to another: the peak of their correlation on a fine mesh."""
    cross = other * numpy.conj(first)
    count = 64 * (len(first) - 1)
    return side / count * int(numpy.fft.irfft(cross, count).argmax())


def spreading(run, field, row):
    """Barenblatt's solution of d_t n = k div(n grad n): of a paraboloid at the start, or a parabola along x alone."""
    start, x, begin = row.values[0], row["x"].values, float(row["time"][0])  # a run in memory has its last frame alone
    peak, inside = float(start.max()), start > 0.1 * start.max()
    if not peak > 0.0 or inside.sum() < 4:
        return None
    curvature, slope, height = numpy.polyfit(x[inside], start[inside], 2)
    if not curvature < 0.0 or abs(numpy.polyval((curvature, slope, height), x[inside]) - start[inside]).max() > (
            LARGEST_ERROR * peak):
        return None
    rate = rate_of_spreading(run, field.name)
    if rate is None:
        return None
    middle = -0.5 * slope / curvature
    height = float(numpy.polyval((curvature, slope, height), middle))
    radius_squared = -height / curvature
    dimensions = dimensions_of(run.frames[field.name][0], middle, height, radius_squared)
    if dimensions is None:
        return None
    power = 1.0 / (dimensions + 2)
    age = power * radius_squared / (2.0 * rate * height)  # since all was at one point

    def profile(points, time):
        radius = (1.0 + (time - begin) / age)**power  # over that of the start
        return numpy.maximum(0.0, height / radius**dimensions * (1.0 - (points - middle)**2
                                                                 / (radius_squared * radius**2)))
    return profile, "exact (Barenblatt)"


def dimensions_of(start, middle, height, radius_squared):
    """1 of a start that is a parabola along x at every y, 2 of a paraboloid, else None."""
    y, values = start["y"].values, start.values
    row = values.argmax() // values.shape[1]
    if numpy.ptp(values, axis=0).max() <= LARGEST_ERROR * height:
        return 1
    away = (start["x"].values - middle)**2 + ((y - y[row])**2)[:, None]
    expected = numpy.maximum(0.0, height * (1.0 - away / radius_squared))
    cell = y[1] - y[0]  # the peak may lie between points along y
    slope = 2.0 * height * cell / numpy.sqrt(radius_squared)
    return 2 if abs(values - expected).max() <= LARGEST_ERROR * height + slope else None


def rate_of_spreading(run, name):
    """k of d_t n = k div(n grad n) for the field n of this name; None where its equation is another.

    Waves of small amplitude about a uniform n decay at the rate k n q^2, and no other field drives them.
    """
    from drover import _drover
    from drover.locks import hdf5
    try:
        with hdf5():
            equations = _drover.Scene.parse(run.attributes["scene"], "scene.toml", []).equations
    except (Error, KeyError):  # such as a term that is a function of Python, which an archive does not hold
        return None
    at, rates = equations.components().index(name), []
    for value, q in ((1.0, 1.0), (2.0, 1.0), (1.0, 2.0), (2.0, 3.0)):
        state = numpy.array(equations.reference())
        state[at] = value
        found = equations.symbol(state, q, 0.0)[at] / -(value * q**2)
        if abs(numpy.delete(found, at)).max(initial=0.0) > 0.0:
            return None
        rates.append(found[at])
    same = numpy.ptp(numpy.real(rates)) <= ROUNDING * abs(rates[0]) and not numpy.imag(rates).any()
    return float(numpy.real(rates[0])) if same and numpy.real(rates[0]) > 0.0 else None
