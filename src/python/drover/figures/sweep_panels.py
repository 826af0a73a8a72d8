"""drover/figures/sweep_panels.py: an observable of a sweep, drawn on given axes."""
import numpy

from drover.error import Error
from drover.figures.panels import BLUE, GREEN, PURPLE, VERMILLION, edges_of, with_unit
from drover.typeset import bracket, named, order_unit, unit_text

COLOURS, MARKERS = (BLUE, VERMILLION, GREEN, PURPLE), "osD^"
MAX_TICKS = 7  # of a map: ticks at the values of a key that has at most so many


def own_axes(sweep, name):
    """The axes of an observable beside the varied keys or points, the branch of a ramp and the seed."""
    return [axis for axis in sweep.data[name].dims if axis not in (*sweep.keys, "point", "branch", "seed")]


def draw_sweep(sweep, name, axes=None, bar_axes=None):
    """Draws an observable over the varied key with its errors, a line for each branch; of two keys a map; over an axis
    of its own a line for each value of the key."""
    if name not in sweep.data or f"{name}_error" not in sweep.data:
        known = [key for key in sweep.data if f"{key}_error" in sweep.data]
        raise Error(f"the sweep has no observable {name}; expected one of {', '.join(known)}")
    if axes is None:
        from matplotlib import pyplot
        axes = pyplot.figure(layout="constrained").gca()
    own = own_axes(sweep, name)
    if len(sweep.keys) == 1 and not own:
        draw_lines(axes, sweep, name)
    elif len(sweep.keys) == 1 and len(own) == 1:
        draw_family(axes, bar_axes, sweep, name, own[0])
    elif len(sweep.keys) == 2 and not own:
        draw_plane(axes, bar_axes, sweep, name)
    elif own:
        raise Error(f"{name} has the axes {', '.join(map(str, own))} beside {', '.join(sweep.keys)}; expected one axis "
                    f"and one key: choose values of the others, as in "
                    f'sweep.data.{name}.sel({{"{own[-1]}": ...}}).plot()')
    else:
        raise Error(f"the sweep varies {len(sweep.keys)} keys; expected one or two: choose values of the others, as in "
                    f'sweep.data.{name}.sel({{"{sweep.keys[-1]}": ...}}).plot()')
    return axes


def label(sweep, name):
    return with_unit(name.replace("_", " "), sweep.data[name])


def key_label(key, values=None):
    """A key of the scene with its unit, as in drover schema; the values of the scene give the unit of the order."""
    from drover.lookup import schema
    section, _, name = key.partition(".")
    rows = [row for part in schema() if part["name"] == section for row in part["rows"] if row["name"] == name]
    unit = rows[0].get("unit", "1") if rows else "1"
    if unit in ("", "1"):
        return key
    if "[" in unit and values is None:
        return f"{key} ({unit_text(unit)})"
    if "[" in unit:
        unit = order_unit(unit, values)
    if values is not None and named(unit, values) != named(unit, {}):
        unit = named(unit, values)
    return key + bracket(unit)


def draw_lines(axes, sweep, name):
    """Means with errors over the key, a line for each branch; open: no error estimate."""
    mean, error = (in_order(sweep, sweep.data[key]) for key in (name, f"{name}_error"))
    branches = list(mean["branch"].values) if "branch" in mean.dims else [None]
    for branch, colour, marker in zip(branches, COLOURS, MARKERS):
        y, bar = (array if branch is None else array.sel(branch=branch) for array in (mean, error))
        x = y[sweep.keys[0]].values
        axes.errorbar(x, y.values, numpy.nan_to_num(bar.values), color=colour, capsize=2, marker="none", linewidth=1)
        known = numpy.isfinite(bar.values)
        for part, face in ((known, colour), (~known, "white")):
            axes.plot(x[part], y.values[part], marker, color=colour, markerfacecolor=face, markersize=5)
        if branch is not None:
            axes.plot([], [], marker + "-", color=colour, label=branch)
    if branches != [None]:
        axes.legend(title="branch")
    axes.set_xlabel(key_label(sweep.keys[0], sweep.values))
    axes.set_ylabel(label(sweep, name))


def draw_family(axes, bar_axes, sweep, name, own):
    """A line for each value of the key, coloured by it, with errors; open: no error estimate.

    Where points have other wavenumbers, or other sides of boxes, the axis counts, and each line has its own places.
    """
    from matplotlib.cm import ScalarMappable
    from matplotlib.colors import LogNorm, Normalize
    [key] = sweep.keys
    mean, error = (first_branch(axes, in_order(sweep, sweep.data[part])) for part in (name, f"{name}_error"))
    places = in_order(sweep, sweep.data.get(f"{own}_values", mean[own]))
    if "branch" in places.dims:
        places = places.isel(branch=0)
    values = numpy.asarray(mean[key].values, float)
    spread = values.min() > 0.0 and values.max() > 30.0 * values.min()
    colours = ScalarMappable((LogNorm if spread else Normalize)(values.min(), values.max()), "viridis")
    for value in values:
        x, y, bar = ((array.sel({key: value}) if key in array.dims else array).values
                     for array in (places, mean, error))
        colour, known = colours.to_rgba(value), numpy.isfinite(bar)
        axes.errorbar(x, y, numpy.nan_to_num(bar), color=colour, marker="none", linewidth=1, elinewidth=0.7)
        for part, face in ((known, colour), (~known, "white")):
            axes.plot(x[part], y[part], "o", color=colour, markerfacecolor=face, markersize=2.5)
    for axis, drawn in ((axes.set_xscale, places.values), (axes.set_yscale, mean.values)):
        known = drawn[numpy.isfinite(drawn)]
        if known.size and known.min() > 0.0 and known.max() > 30.0 * known.min():
            axis("log")
    bar = axes.figure.colorbar(colours, cax=bar_axes, ax=None if bar_axes is not None else axes,
                               label=key_label(key, sweep.values))
    if len(values) <= MAX_TICKS:
        bar.set_ticks(values, labels=[f"{value:g}" for value in values])
    axes.set_xlabel(with_unit(own.replace("_", " "), places))
    axes.set_ylabel(label(sweep, name))


def draw_plane(axes, bar_axes, sweep, name):
    mean = first_branch(axes, sweep.data[name])
    y, x = sweep.keys
    if "point" in mean.dims:
        draw_points(axes, bar_axes, sweep, name, mean)
        return
    image = axes.pcolormesh(edges_of(mean[x].values), edges_of(mean[y].values), mean.transpose(y, x).values,
                            cmap="viridis")
    axes.figure.colorbar(image, cax=bar_axes, ax=None if bar_axes is not None else axes, label=label(sweep, name))
    for axis, key in ((axes.xaxis, x), (axes.yaxis, y)):
        if mean.sizes[key] <= MAX_TICKS:
            axis.set_ticks(mean[key].values)
    label_plane(axes, sweep)


def first_branch(axes, array):
    """Of a ramp the first branch, which the title names."""
    if "branch" not in array.dims:
        return array
    axes.set_title(f"branch {array['branch'].values[0]}", loc="right")
    return array.isel(branch=0)


def label_plane(axes, sweep):
    y, x = sweep.keys
    axes.set_xlabel(key_label(x, sweep.values))
    axes.set_ylabel(key_label(y, sweep.values))


def draw_points(axes, bar_axes, sweep, name, mean):
    """A refined plane: linear between its points, which are dots."""
    known = numpy.isfinite(mean.values)
    y, x = (sweep.data[key].values[known] for key in sweep.keys)
    if len(set(x)) < 2 or len(set(y)) < 2 or len(x) < 3:
        raise Error(f"{len(x)} points with a value of {name}, which span no plane; expected more of them")
    # Both axes to the same length: the triangles are those of what is seen.
    from matplotlib.tri import Triangulation
    cells = Triangulation(*((values - values.min()) / numpy.ptp(values) for values in (x, y)))
    image = axes.tripcolor(Triangulation(x, y, cells.triangles), mean.values[known], shading="gouraud", cmap="viridis")
    axes.plot(x, y, ".", color="white", markeredgecolor="black", markeredgewidth=0.3, markersize=3.5, clip_on=False)
    axes.margins(0)
    axes.figure.colorbar(image, cax=bar_axes, ax=None if bar_axes is not None else axes, label=label(sweep, name))
    label_plane(axes, sweep)


def in_order(sweep, array):
    """Along the axis of the one key, which a refined sweep has beside its points."""
    if "point" not in array.dims:
        return array
    key = sweep.keys[0]
    return array.assign_coords({key: ("point", sweep.data[key].values)}).swap_dims(point=key).sortby(key)
