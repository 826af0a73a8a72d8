"""drover/model_panels.py: panels of a run with fields of its own: maps, profiles, series and spectra of any field."""
import numpy
from matplotlib.colors import Normalize
from matplotlib.ticker import FuncFormatter, MaxNLocator

from drover import panels, results
from drover.archive import loaded
from drover.panels import BLUE, GREEN, PURPLE, STEPS, VERMILLION, block_means, plain, shown_means
from drover.roles import arrays_at
from drover.typeset import simple_unit, unit_text

COLOURS = (BLUE, VERMILLION, GREEN, PURPLE, "#E69F00", "#56B4E9", "#000000")
LINES = ("-", "--", ":", "-.")        # of fields beyond the number of colours
SEQUENTIAL, DIVERGING = "viridis", "RdBu_r"
ARROW_SPACE, ARROWS = 0.11, (6, 16)   # inches of a map for an arrow; their number along the longer side
UNIFORM = 1e-9                        # relative to the size of a field: smaller means are rounding errors
LOG_FROM = 10.0                       # ratio of values from which an axis is logarithmic
DECADES = 1e-20                       # of variances, relative to the largest: smaller ones are rounding errors
ALIKE = 0.05                          # relative difference of curves that hide each other
WARM_UP = "#e0e0e0"
MARKERS = {"": "o", "_along": "s", "_across": "^"}
MARKED = (("_along", r"along $\mathbf{q}$"), ("_across", r"across $\mathbf{q}$"))


def colour_of(number):
    return COLOURS[number % len(COLOURS)]


def excess(values, later):
    """Points by which a curve, or its markers, are larger, so that they show below those which are drawn later."""
    hidden = sum((abs(values - other) <= ALIKE * (abs(values) + abs(other))).mean() > 0.5 for other in later)
    return 1.2 * min(hidden, 2)


def line_of(number):
    return LINES[number // len(COLOURS) % len(LINES)]


def bracket(unit):
    """A unit for a label: " [mm$^{-2}$]", or nothing."""
    unit = simple_unit(unit)
    return "" if unit == "1" else f" [{unit_text(unit)}]"


def plain_ticks(axis, count):
    axis.set_major_locator(MaxNLocator(count, steps=STEPS))
    axis.set_major_formatter(FuncFormatter(plain))


def averages_of(role, arrays):
    """What a map shows, block averages of a noisy field and every point of a smooth one, and the size of a pixel."""
    if not role.spin:
        array = arrays[role.components[0]]
        return shown_means(array, role.is_density and role.centre(array.values) is None)
    means = {name: block_means(array, panels.MAX_PIXELS) for name, array in arrays.items()}
    lost = sum(float(array.var()) for array, _ in means.values()) < (1.0 - panels.MAX_LOST) * sum(
        float(array.var()) for array in arrays.values())
    if lost and any(map(panels.is_noisy, arrays.values())):
        return role.size({name: array for name, (array, _) in means.items()}), means[role.components[0]][1]
    return role.size(arrays), panels.steps_of(arrays[role.components[0]])


def colours_for(role, values):
    """Colour map, limits and the ends that values exceed: diverging about the centre of a signed field."""
    centre = role.centre(values)
    if centre is None:
        low, high, extend = panels.colour_range(values)
        return SEQUENTIAL, low, high, extend
    reach = float(numpy.quantile(abs(values - centre), panels.COLOUR_PART))
    reach = reach if reach > 0.0 else float(abs(values - centre).max())
    return DIVERGING, centre - reach, centre + reach, "both"


def draw_map(axes, bar_axes, run, role, frame):
    """Draws one field: colours for its value or size, arrows of a vector, lines of a nematic.  Returns the pixel."""
    arrays = arrays_at(run, role, frame)
    shown, pixel = averages_of(role, arrays)
    colours, low, high, extend = colours_for(role, shown.values)
    drawn, size = shown, pixel
    if panels.is_resolved(run, pixel):
        arrays = {name: panels.refined(array)[0] for name, array in arrays.items()}
        drawn, size = role.size(arrays), panels.steps_of(arrays[role.components[0]])
    image = axes.imshow(drawn.values, origin="lower", cmap=colours, norm=Normalize(low, high), aspect="auto",
                        extent=panels.extent_of(drawn, size), interpolation="nearest")
    inches = axes.get_position().size * axes.figure.get_size_inches()
    for axis, name, length in ((axes.xaxis, "x", inches[0]), (axes.yaxis, "y", inches[1])):
        axis.set_major_locator(MaxNLocator(int(numpy.clip(length / 0.3, 1, 8)), steps=STEPS))
        axis.set_label_text(panels.with_unit(f"${name}$", run.frames[name]))
    bar = axes.figure.colorbar(image, cax=bar_axes, ax=None if bar_axes is not None else axes, extend=extend)
    plain_ticks(bar.ax.yaxis, int(numpy.clip(inches[1] / 0.2, 1, 5)))
    if role.spin in (1, 2):
        draw_directions(axes, role, arrays, int(numpy.clip(max(inches) / ARROW_SPACE, *ARROWS)))
    return pixel


def directions_of(role, first, second):
    """Components of what is drawn at each place: the vector, or the director of a nematic with its size."""
    if role.spin == 1:
        return first, second
    size, angle = numpy.hypot(first, second), 0.5 * numpy.arctan2(second, first)
    return size * numpy.cos(angle), size * numpy.sin(angle)


def quiver_of(axes, role, x, y, first, second, length, width=0.011):
    """Arrows, or lines without heads, whose longest has this length [mm]."""
    longest = float(numpy.hypot(first, second).max())
    head = {"headwidth": 4, "headlength": 4, "headaxislength": 3.5} if role.spin == 1 else {
        "headwidth": 0, "headlength": 0, "headaxislength": 0}
    return axes.quiver(x, y, first, second, color="white", edgecolor="black", linewidth=0.3, pivot="mid", angles="xy",
                       scale_units="xy", scale=(longest or 1.0) / length, units="inches",
                       width=width if role.spin == 1 else 1.5 * width, **head)


def draw_directions(axes, role, arrays, count):
    """Draws block averages of a vector as arrows, of a nematic as directors."""
    (first, block), (second, _) = (block_means(arrays[name], count) for name in role.components)
    parts = directions_of(role, first.values, second.values)
    if numpy.hypot(*parts).max() > 0.0:
        quiver_of(axes, role, first["x"], first["y"], *parts, 0.95 * min(block))


def draw_profile(axes, run, role, frame):
    """Draws the components of one field of a one-dimensional run over x."""
    arrays = arrays_at(run, role, frame)
    for array, colour, end in zip(arrays.values(), (BLUE, VERMILLION), parts_of(role)):
        axes.plot(array["x"], array.values[0], color=colour, linewidth=1.0, label=f"${role.symbol}{end}$")
    x = next(iter(arrays.values()))["x"].values
    axes.set_xlim(x[0], x[-1] + (x[1] - x[0]))
    axes.set_xlabel(panels.with_unit("$x$", run.frames["x"]))
    axes.set_ylabel(f"${role.symbol}$" + bracket(role.unit))
    keep_off_rounding(axes)
    plain_ticks(axes.yaxis, 4)
    if role.spin:
        axes.legend(loc="lower right", bbox_to_anchor=(1.0, 1.0), ncols=2, frameon=False, borderaxespad=0.1)


def parts_of(role):
    return {0: ("",), 1: ("_x", "_y"), 2: ("_{xx}", "_{xy}")}.get(role.spin, ("_1", "_2"))


def draw_means(axes, run, roles, numbers):
    """Draws means over time of fields with one unit: of a scalar with a band of one standard deviation.

    `numbers`: of their colours.
    """
    most = 0.0
    means = [loaded(run.observables[("size_mean_" if role.spin else "mean_") + role.name], run.path) for role in roles]
    for place, (role, number, mean) in enumerate(zip(roles, numbers, means)):
        style = {"color": colour_of(number), "linestyle": line_of(number)}
        deviation = numpy.sqrt(numpy.maximum(loaded(run.observables[f"variance_{role.name}"], run.path).values, 0.0))
        values = numpy.where(abs(mean.values) > UNIFORM * deviation, mean.values, 0.0)
        if not role.spin:
            axes.fill_between(mean["time"], values - deviation, values + deviation, color=style["color"], alpha=0.25,
                              linewidth=0)
        wide = excess(mean.values, [other.values for other in means[place + 1:]])
        axes.plot(mean["time"], values, linewidth=1.1 + wide, **style, label=rf"$|\langle {role.symbol}\rangle|$"
                  if role.spin else rf"$\langle {role.symbol}\rangle$")
        most = max(most, float(deviation.max()))
    keep_off_rounding(axes, most)
    if all(role.spin for role in roles):
        axes.set_ylim(bottom=0.0)
    axes.set_ylabel(bracket(roles[0].unit).strip())
    plain_ticks(axes.yaxis, 3)
    of_time(axes, run)


def keep_off_rounding(axes, scale=0.0):
    """Lets an axis of values that differ by rounding errors alone show them as equal; `scale`: of values near 0."""
    low, high = axes.dataLim.intervaly
    if high - low <= UNIFORM * max(abs(low), abs(high)):
        reach = 0.1 * abs(high) or scale or 1.0
        axes.set_ylim(low - reach, high + reach)


def variance_labels(run, roles):
    """Symbols, with the units of variances unless all share one."""
    shared = len({role.unit for role in roles}) == 1
    return [f"${role.symbol}$" + ("" if shared else
                                  bracket(run.observables[f"variance_{role.name}"].attrs.get("units", "1")))
            for role in roles]


def draw_variances(axes, run, roles):
    """Draws variances over time; returns whether there are any."""
    series = [loaded(run.observables[f"variance_{role.name}"], run.path) for role in roles]
    most = [float(array.max()) for array in series]
    shared = len({role.unit for role in roles}) == 1
    least = numpy.inf
    for number, (label, array, high) in enumerate(zip(variance_labels(run, roles), series, most)):
        shown = numpy.where(array.values > DECADES * high, array.values, numpy.nan) if high > 0.0 else None
        if shown is None:
            continue
        least = min(least, float(numpy.nanmin(shown)))
        axes.plot(array["time"], shown, color=colour_of(number), linestyle=line_of(number), label=label,
                  linewidth=1.1 + excess(shown, [other.values for other in series[number + 1:]]))
    axes.set_ylabel("variance" + (bracket(series[0].attrs.get("units", "1")) if shared else ""))
    if not max(most) > 0.0:
        panels.write_instead(axes, "uniform fields")
        return False
    if max(most) > LOG_FROM * least:
        axes.set_yscale("log")
        panels.minor_ticks(axes.yaxis)
    else:
        axes.set_ylim(0.0, 1.1 * max(most))
        plain_ticks(axes.yaxis, 3)
    of_time(axes, run)
    return True


def of_time(axes, run):
    """The axis of time, with the warm-up in grey."""
    times = run.observables["time"].values
    if run.summary is not None and float(run.summary.get("warm_up", 0.0)) > 0.0:
        axes.axvspan(times[0], times[0] + float(run.summary["warm_up"]), color=WARM_UP, linewidth=0, zorder=0)
    axes.set_xlim(times[0], times[-1] if len(times) > 1 else times[0] + 1.0)
    axes.xaxis.set_major_locator(MaxNLocator(6, steps=STEPS))
    axes.set_xlabel(panels.with_unit("time $t$", run.observables["time"]))


def structure_parts(run, roles):
    """(number of the field, its label, unit, marker, result) of the structure factors that are not zero."""
    found = []
    for number, role in enumerate(roles):
        for end in ("_along", "_across") if role.spin else ("",):
            result = results.structure_factor(run, role.name + end)
            if panels.is_drawable(result):
                unit = run.observables[f"structure_factor_{role.name}{end}"].attrs.get("units", "1")
                found.append((number, f"${role.symbol}$", simple_unit(unit), MARKERS[end], result))
    most = max((result.mean.max() for *_, result in found), default=0.0)
    return [part for part in found if part[-1].mean.max() > panels.DECADES_SHOWN * most]


def structure_unit(parts):
    """The unit that all structure factors share, or None."""
    units = {unit for _, _, unit, _, _ in parts}
    return units.pop() if len(units) == 1 else None


def structure_keys(parts):
    """Keys of a legend: fields by colour, markers of parts along and across q, theory."""
    labels = {number: label + ("" if structure_unit(parts) else bracket(unit)) for number, label, unit, _, _ in parts}
    markers = {marker for _, _, _, marker, _ in parts}
    only = markers.pop() if len(markers) == 1 else ""
    keys = [panels.key_of(label, colour_of(number), only, "" if only else "-") for number, label in labels.items()]
    keys += [panels.key_of(words, marker=MARKERS[end]) for end, words in MARKED if MARKERS[end] in {*markers, only}]
    if any(result.has_linear for *_, result in parts):
        keys.append(panels.key_of("linear theory", line="-", colour="black"))
    return keys


def draw_structure(axes, run, roles):
    """Draws structure factors with errors and linear theory, and returns structure_parts()."""
    parts = structure_parts(run, roles)
    if not parts:
        panels.write_instead(axes, "uniform fields: every $S(q)$ is zero")
        return parts
    most = max(result.mean.max() for *_, result in parts)
    for number, _, _, marker, result in parts:
        later = [other.mean for place, *_, kind, other in parts if place > number and kind == marker]
        panels.draw_result(axes, panels.above_rounding(result, most), colour_of(number), marker,
                           panels.spread_shells(result.x), excess(result.mean, later))
    panels.log_axes(axes)
    axes.set_xlabel(panels.with_unit("wavenumber $q$", run.observables["wavenumber"]))
    axes.set_ylabel("$S(q)$" + bracket(structure_unit(parts) or "1"))
    return parts
