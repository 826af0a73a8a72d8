"""drover/dynamics.py: the dynamic structure factor of a run of fields, as linear theory defines it."""
import json

import numpy

from drover.archive import loaded
from drover.attributes import about
from drover.error import ArgumentError, Error
from drover.typeset import named

NUMBERS_AT_ONCE = 1 << 22
FRAMES_OF_STATE = 16  # whose means choose the uniform state of the theory
OVERLAP_LOSS = 1.0 + 2.0 / 36.0  # of the variance of means over segments that overlap by half, with windows of Hann


def dynamic_structure_factor(run, field, *, along="x", modes=1, begin=None, segments=8):
    """S(q, omega) of one field of a run, a Dataset over wavenumber and frequency.

    The integral over omega/(2 pi) of S(q, omega) is S(q), and a wave exp(i q x - i omega t) is at q and omega, as in
    `drover stability`.  `run`: an open archive of fields; `field`: one of run.frames, such as "rod_density".  q lies
    along "x" or "y", with 1 to `modes` waves in the cell.  Frames from `begin` [s] (default: the second half) are cut
    into `segments` that overlap by half (Welch's method, windows of Hann); the standard error, `..._error`, is that of
    their scatter, and at least that of Gaussian noise, powers of which scatter by S.  Frequencies go to pi over the
    interval of the frames: faster waves appear at lower ones.
    `..._linear` is the mean that linear theory about the uniform state nearest to the frames has for this measurement,
    of frames at this interval in windows of this length; NaN where there is none, as for waves that the run does not
    keep (see kept_modes).

    >>> from drover import Scene
    >>> scene = Scene.from_dict({"grid": {"nx": 16, "ny": 16}, "time": {"dt": 0.1, "end": 200.0},
    ...                          "relaxation": {"rate": 1.0}, "noise": {"order": 0.1}, "output": {"frame_every": 0.2}})
    >>> with scene.run("waves.h5") as run:
    ...     found = dynamic_structure_factor(run, "polar_order_x")
    >>> dict(found.sizes)
    {'wavenumber': 1, 'frequency': 111}
    """
    if along not in ("x", "y"):
        raise ArgumentError(f'along = "{along}"; expected "x" or "y"')
    if not hasattr(run, "frames"):
        raise ArgumentError(f"the run is {run!r}; expected an open one, such as drover.open_run(\"flock.h5\")")
    fields = [name for name, values in run.frames.data_vars.items() if {"x", "y"} <= set(values.dims)]
    if not fields:
        raise ArgumentError(f"{run.path} is a run of particles; expected one of fields")
    if field not in fields:
        raise ArgumentError(f'field = "{field}"; expected one of the fields of the run: {", ".join(fields)}')
    frames, interval = frames_on_schedule(run, begin)
    length = 2 * len(frames) // (segments + 1)
    if segments < 2 or length < 8:
        raise ArgumentError(f"{len(frames)} frames in {segments} segments; expected 2 segments or more of 8 frames or "
                            "more: choose fewer, an earlier begin, or a run with more frames")
    points = run.frames.sizes[along]
    if not 1 <= modes < (points + 1) // 2:
        raise ArgumentError(f"modes = {modes}; expected 1 to {(points - 1) // 2}, half the points along {along}")
    values = numpy.concatenate([amplitudes(run, field, along, modes, part) for part in parts_of(run, field, frames)])
    side = run.scene["grid"][f"l{along}"]
    area = run.scene["grid"]["lx"] * run.scene["grid"]["ly"]
    window = numpy.hanning(length + 1)[:-1]
    powers = segment_powers(values * area, window, interval) / area
    frequency = 2.0 * numpy.pi * numpy.fft.fftshift(numpy.fft.fftfreq(length, interval))
    wavenumber = 2.0 * numpy.pi / side * numpy.arange(1, modes + 1)
    found = dataset(run.frames[field], wavenumber, frequency, powers, run.scene)
    name = f"dynamic_structure_factor_{field}"
    values, words = predicted(run, field, along, wavenumber, frames, interval, window)
    values[kept_modes(run, along):] = numpy.nan
    found[f"{name}_linear"] = found[name].dims, values, about(f"{name}_linear", found[name].units, words)
    return found


def kept_modes(run, along):
    """The most waves along an axis among the modes that a run keeps; without its equations, of those on its grid."""
    from drover import _drover
    from drover.locks import hdf5
    try:
        with hdf5():
            explained = _drover.explain(_drover.Scene.parse(run.attributes["scene"], run.path.name, []))
    except Error:  # such as a term that is a function of Python, which an archive does not hold
        return (run.frames.sizes[along] - 1) // 2
    return json.loads(explained)["largest_mode_kept"][along]


def predicted(run, field, along, wavenumber, frames, interval, window):
    """The mean of segment_powers() in linear theory, and about which state it is, or why it is NaN."""
    from drover import _drover
    from drover.locks import hdf5
    nothing = numpy.full((len(wavenumber), len(window)), numpy.nan)
    some = frames[::max(1, len(frames) // FRAMES_OF_STATE)]
    means = {name: float(loaded(values.isel(time=some), run.path).mean())
             for name, values in run.frames.data_vars.items() if {"x", "y"} <= set(values.dims)}
    waves = [(q, 0.0) if along == "x" else (0.0, q) for q in wavenumber]
    try:
        with hdf5():
            state, lagged, why_none = _drover.lagged_waves(
                _drover.Scene.parse(run.attributes["scene"], run.path.name, []), means, field, waves, float(interval),
                len(window))
    except Error as error:  # such as a term that is a function of Python, which an archive does not hold
        return nothing, f"no linear theory: {error}"
    if why_none and not numpy.isfinite(lagged).any():
        return nothing, f"no linear theory: {why_none}"
    unit = named("s", run.scene)
    unit = "" if unit == "1" else f" {unit}"
    words = f"S(q, omega) of the linear theory about the state \"{state}\", of frames {interval:g}{unit} apart in " \
            f"windows of {interval * len(window):g}{unit}"
    return windowed(lagged, window, interval), words + (f"; NaN: {why_none}" if why_none else "")


def frames_on_schedule(run, begin):
    """Numbers of the frames from a time on, and their interval [s]; the last frame may be off the schedule."""
    times = run.frames.time.values
    if len(times) < 3:
        raise Error(f"{run.path} has {len(times)} frames; expected an archive with at least three "
                    "(output.frame_every > 0)")
    interval = times[1] - times[0]
    kept = numpy.isclose(times, interval * numpy.arange(len(times)), rtol=0.0, atol=1e-6 * interval)
    kept &= times >= (0.5 * times[-1] if begin is None else begin)
    return numpy.flatnonzero(kept), interval


def parts_of(run, field, frames):
    """Slices of successive frames that are read at once."""
    size = run.frames[field].isel(time=0).size
    count = max(1, NUMBERS_AT_ONCE // size)
    return [slice(first, min(first + count, frames[-1] + 1)) for first in range(frames[0], frames[-1] + 1, count)]


def amplitudes(run, field, along, modes, frames):
    """Means of the field times exp(-i q x) over the cell, for 1 to `modes` waves: (frame, mode)."""
    values = loaded(run.frames[field].isel(time=frames), run.path).mean("y" if along == "x" else "x").values
    return numpy.fft.fft(values)[:, 1:modes + 1] / values.shape[1]


def windowed(lagged, window, interval):
    """The mean of segment_powers() for amplitudes whose correlations over 0, 1, ... intervals are `lagged`."""
    overlaps = numpy.correlate(window, window, "full")[len(window) - 1:] / (window ** 2).sum()
    folded = overlaps * lagged
    folded[:, 1:] += folded[:, :0:-1].conj()  # lags of -n are lags of length - n, by the frequencies of a segment
    return interval * numpy.fft.fftshift(numpy.fft.ifft(folded, axis=1) * len(window), axes=1).real


def segment_powers(values, window, interval):
    """|int a exp(i omega t) dt|^2 over the time, of each segment: (segment, mode, frequency)."""
    length, scale = len(window), interval / (window ** 2).sum()
    parts = []
    for first in range(0, len(values) - length + 1, length // 2):
        part = values[first:first + length]
        waves = numpy.fft.ifft(part * window[:, None], axis=0) * length  # exp(+i omega t)
        parts.append(scale * numpy.abs(numpy.fft.fftshift(waves, axes=0).T) ** 2)
    return numpy.array(parts)


def dataset(array, wavenumber, frequency, powers, scene):
    import xarray
    name = f"dynamic_structure_factor_{array.name}"
    unit = array.attrs.get("units", "1")
    area = named("mm2 s", scene)
    units = area if unit == "1" else f"({unit})^2" + ("" if area == "1" else f" {area}")
    mean = powers.mean(axis=0)
    error = numpy.sqrt(OVERLAP_LOSS / len(powers)) * numpy.maximum(powers.std(axis=0, ddof=1), mean)
    dims = ("wavenumber", "frequency")
    return xarray.Dataset(
        {name: (dims, mean, about(name, units, "S(q, omega)")),
         f"{name}_error": (dims, error, about(f"{name}_error", units, f"standard error of {name}"))},
        {"wavenumber": ("wavenumber", wavenumber, about("wavenumber", named("mm-1", scene), "wavenumber |q|")),
         "frequency": ("frequency", frequency, about("frequency", named("s-1", scene), "angular frequency omega"))})
