"""tests/extremes/field_error.py: the error of the fields of a run, beside those of a more precise one."""
import h5py
import numpy

FIELDS = (("bead_density",), ("rod_density",), ("bead_velocity_x", "bead_velocity_y"),
          ("polar_order_x", "polar_order_y"))


def frame_of(archive, number=-1):
    """One frame of an archive, the last unless told: values by name."""
    with h5py.File(archive) as file:
        return {name: file[name][number] for group in FIELDS for name in group if name in file}


def size_of(frame, group):
    """The root mean square of a field."""
    return float(numpy.sqrt(sum((frame[name]**2).mean() for name in group)))


def without_direction(wrong, exact):
    """Errors without those of the direction of the mean order, which noise changes without limit."""
    order = numpy.array([exact["polar_order_x"].mean(), exact["polar_order_y"].mean()])
    across = numpy.array([-order[1], order[0]]) / max(numpy.hypot(*order), 1e-300)
    for pair in FIELDS[2:]:
        if pair[0] in wrong:
            turned = sum(wrong[name].mean() * part for name, part in zip(pair, across))
            wrong = wrong | {name: wrong[name] - turned * part for name, part in zip(pair, across)}
    return wrong


def largest_error(frame, exact, is_noisy, least):
    """The largest error of a field, relative to its root mean square or, if larger, to least(group); and its name."""
    wrong = {name: frame[name] - exact[name] for name in frame}
    if is_noisy:
        wrong = without_direction(wrong, exact)
    worst = (0.0, "")
    for group in FIELDS:
        if group[0] in frame:
            error, size = size_of(wrong, group), max(size_of(exact, group), least(group))
            worst = max(worst, (error / size if size > 0.0 else 0.0, group[0]))
    return worst
