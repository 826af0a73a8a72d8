"""drover/figures/model_panels.py: panels of a run of fields: maps, profiles, series and spectra, by what the fields
are."""
from typing import NamedTuple

import numpy
from matplotlib.colors import Normalize
from matplotlib import rcParams
from matplotlib.ticker import FuncFormatter, MaxNLocator

from .. import results
from . import panels
from drover.archive import loaded
from drover.fields import has_noise
from drover.figures.panels import BLUE, GREEN, PURPLE, STEPS, VERMILLION, block_means, plain, shown_means
from drover.roles import arrays_at, arrows_of, has_own_fields, maps_of, roles_first, roles_of
from drover.typeset import bracket, simple_unit

COLOURS = (BLUE, VERMILLION, GREEN, PURPLE, "#E69F00", "#56B4E9", "#000000")
LINES = ("-", "--", ":", "-.")        # of fields beyond the number of colours
SEQUENTIAL, DIVERGING = "viridis", "RdBu_r"
ARROW_SPACE, ARROWS = 0.11, (6, 16)   # inches of a map for an arrow; their number along the longer side
UNIFORM = 1e-9                        # relative to the size of a field: smaller means are rounding errors
LOG_FROM = 10.0                       # ratio of values from which an axis is logarithmic
DECADES, ROUNDING = 1e-10, 1e-13      # of deviations, relative to the largest and to means: smaller ones are rounding
ALIKE = 0.05                          # relative difference of curves that hide each other
WARM_UP = "#e0e0e0"
MARKERS = {"": "o", "_along": "s", "_across": "^"}
ENDS = ("_along", "_across")          # of structure factors of vectors and nematics
APART = ("o", "s", "^", "D")          # of curves with a colour each
TICK_ROOM = 0.043                     # inches of an axis for a tick, in sizes of the font
STREAM_FROM, STREAM_TO = 1e-3, 0.1    # of the longest arrow: medians between are of a flow around one place, as lines
NO_ORDER = 1e-6                       # order below is rounding
LEGEND_COLUMN, BESIDE_TITLE_FROM = 2.2, 8.0  # inches; wider panels of the order have their legend beside the title
MARKED = (("_along", r"along $\mathbf{q}$"), ("_across", r"across $\mathbf{q}$"))


def colour_of(number):
    return COLOURS[number % len(COLOURS)]


def excess(values, later):
    """Points by which a curve, or its markers, are larger, so that they show below those which are drawn later."""
    hidden = sum((abs(values - other) <= ALIKE * (abs(values) + abs(other))).mean() > 0.5 for other in later)
    return 1.2 * min(hidden, 2)


def line_of(number):
    return LINES[number // len(COLOURS) % len(LINES)]


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
    """Draws one field: colours for its value or size, arrows of a vector, lines of a nematic; of one row its profile.
    """
    if run.frames.sizes["y"] == 1:
        draw_profile(axes, run, role, frame)
        return
    arrays = draw_colours(axes, bar_axes, run, role, frame)[0]
    inches = axes.get_position().size * axes.figure.get_size_inches()
    if role.spin in (1, 2):
        draw_directions(axes, role, arrays, int(numpy.clip(max(inches) / ARROW_SPACE, *ARROWS)))


def draw_colours(axes, bar_axes, run, role, frame):
    """Draws one field by colours; returns its arrays as they are drawn, the size of a pixel and the colour bar."""
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
        count = int(numpy.clip(length / (TICK_ROOM * rcParams["font.size"]), 1, 8))
        axis.set_major_locator(MaxNLocator(count, steps=STEPS))
        axis.set_label_text(panels.with_unit(f"${name}$", run.frames[name]))
    bar = axes.figure.colorbar(image, cax=bar_axes, ax=None if bar_axes is not None else axes, extend=extend)
    plain_ticks(bar.ax.yaxis, int(numpy.clip(inches[1] / 0.2, 1, 5)))
    return arrays, pixel, bar


def map_title(run, frame):
    """Of a map of a density with arrows."""
    role, arrows = shown_at(run, frame)
    if role == arrows:
        return f"{role.words} and its magnitude"
    return f"{role.size_words} and {arrows.words}"


def shown_at(run, frame):
    """The field by colours and that by arrows of the first map of a run."""
    role, others = maps_of(run)[0]
    arrays = {name: array for other in others for name, array in arrays_at(run, other, frame).items()}
    return role, arrows_of(others, arrays)


def draw_map_with_arrows(axes, bar_axes, run, frame):
    """Draws a density with arrows of the order or the flow, and their scale; of one row profiles of both.

    Returns the block sizes of both, without that of the arrows where lines follow the flow; of one row nothing.
    """
    if run.frames.sizes["y"] == 1:
        return draw_profile_with_arrows(axes, run, frame)
    role, other = shown_at(run, frame)
    arrays, pixel, bar = draw_colours(axes, bar_axes, run, role, frame)
    axes.set_aspect("equal")
    bar.set_label(f"{role.size_words} ${role.size_symbol}$" + bracket(role.unit))
    if other is None:
        return pixel, None
    # Also where the grid has few points the arrows of a resolved field are within the cell.
    finer = panels.refined if panels.is_resolved(run, pixel) else lambda array: (array, None)
    parts = [finer(array)[0] for array in arrays_at(run, other, frame).values()]
    (first, block), (second, _) = (block_means(part, panels.MAX_ARROWS) for part in parts)
    directions = directions_of(other, first.values, second.values)
    lengths = numpy.hypot(*directions)
    longest = float(lengths.max())
    if other.is_flow and STREAM_FROM * longest < numpy.median(lengths) < STREAM_TO * longest:
        limits = {"xlim": axes.get_xlim(), "ylim": axes.get_ylim()}
        axes.streamplot(parts[0]["x"].values, parts[0]["y"].values, *(part.values for part in parts), color="white",
                        linewidth=0.6, arrowsize=0.7, density=1.4)
        axes.set(**limits)
        return pixel, None
    if longest > 0.0:
        length = 0.95 * min(block)
        arrows = quiver_of(axes, other, first["x"], first["y"], *directions, length, 0.018)
        panels.add_arrow_key(axes, arrows, longest, length, other.symbol, first)
    return pixel, block


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
    draw_curves(axes, run, role, frame, (BLUE, VERMILLION))
    axes.set_ylabel(f"${role.symbol}$" + bracket(role.unit))
    keep_off_rounding(axes)
    plain_ticks(axes.yaxis, 4)
    if role.spin:
        axes.legend(loc="lower right", bbox_to_anchor=(1.0, 1.0), ncols=2, frameon=False, borderaxespad=0.1)


def draw_curves(axes, run, role, frame, colours):
    """Draws the components of one field over x; returns the lines."""
    x = run.frames["x"].values
    lines = [axes.plot(x, array.values[0], color=colour, linewidth=1.0, label=f"${role.symbol}{end}$")[0]
             for array, colour, end in zip(arrays_at(run, role, frame).values(), colours, parts_of(role))]
    axes.set_xlim(x[0], x[-1] + (x[1] - x[0]))
    axes.set_xlabel(panels.with_unit("$x$", run.frames["x"]))
    return lines


def draw_profile_with_arrows(axes, run, frame):
    """Draws a density of a one-dimensional run over x, and on the right the order or the flow."""
    role, other = shown_at(run, frame)
    right = axes.twinx()
    right.grid(False)
    lines = []
    for one, on, colours in ((role, axes, (BLUE, PURPLE)), (other, right, (VERMILLION, GREEN))):
        if one is not role or other != role:
            lines += draw_curves(on, run, one, frame, colours)
        on.set_ylabel(f"{one.words} ${one.symbol}$" + bracket(one.unit))
    axes.margins(y=0.35)  # two curves of one shape would hide each other
    axes.legend(handles=lines, loc="lower right", bbox_to_anchor=(1.0, 1.0), ncols=3, frameon=False, borderaxespad=0.2)


def parts_of(role):
    return {0: ("",), 1: ("_x", "_y"), 2: ("_{xx}", "_{xy}")}.get(role.spin, ("_1", "_2"))


def mean_name(role):
    """The series of its mean over the cell."""
    return ("size_mean_" if role.spin else "mean_") + role.name


def draw_means(axes, run, roles, numbers):
    """Draws means over time of fields with one unit: of a scalar with a band of one standard deviation.

    `numbers`: of their colours.
    """
    most = 0.0
    means = [loaded(run.observables[mean_name(role)], run.path) for role in roles]
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


def density_mean(run, role):
    """The mean of a density, to which its deviations are relative; None of a field that has both signs."""
    if not role.is_density:
        return None
    values = loaded(run.frames[role.name].isel(time=[0, -1]), run.path).values
    mean = float(values[0].mean())
    return mean if mean > UNIFORM * abs(values).max() and role.centre(values) is None else None


def deviation_label(run, role):
    label = rf"\delta {role.symbol}"
    return f"${label}$" + bracket(role.unit) if density_mean(run, role) is None else f"${label}/{role.symbol}$"


def draw_deviations(axes, run, roles):
    """Draws standard deviations over time, of densities above 0 relative to their means; returns whether there are any.
    """
    drawn = []
    for role in roles:
        values = numpy.sqrt(numpy.maximum(loaded(run.observables[f"variance_{role.name}"], run.path).values, 0.0))
        mean = density_mean(run, role)
        values = values if mean is None else values / mean
        if values.max() > (0.0 if mean is None else ROUNDING):
            drawn.append((role, numpy.where(values > DECADES * values.max(), values, numpy.nan)))
    axes.set_ylabel("deviation")
    if not drawn:
        panels.write_instead(axes, "uniform fields")
        return False
    for place, (role, values) in enumerate(drawn):
        wide = excess(values, [other for _, other in drawn[place + 1:]])
        axes.plot(run.observables["time"], values, color=colour_of(role.number), linestyle=line_of(role.number),
                  linewidth=1.1 + wide, label=deviation_label(run, role))
    most, least = (extreme([extreme(values) for _, values in drawn]) for extreme in (numpy.nanmax, numpy.nanmin))
    if most > LOG_FROM * least:
        axes.set_yscale("log")
        panels.minor_ticks(axes.yaxis)
    else:
        axes.set_ylim(0.0, 1.1 * most)
        plain_ticks(axes.yaxis, 3)
    return True


def of_time(axes, run):
    """The axis of time, with the warm-up in grey."""
    times = run.observables["time"].values
    if run.summary is not None and float(run.summary.get("warm_up", 0.0)) > 0.0:
        axes.axvspan(times[0], times[0] + float(run.summary["warm_up"]), color=WARM_UP, linewidth=0, zorder=0)
    axes.set_xlim(times[0], times[-1] if len(times) > 1 else times[0] + 1.0)
    axes.xaxis.set_major_locator(MaxNLocator(6, steps=STEPS))
    axes.set_xlabel(panels.with_unit("time $t$", run.observables["time"]))


class Curve(NamedTuple):
    """A structure factor that is drawn."""

    number: int  # of its colour
    label: str
    unit: str
    end: str     # "_along", "_across", or "" where the label says it
    marker: str
    result: results.Result


def structure_parts(run, roles, apart=False):
    """The Curves of the structure factors that are not zero; `apart`: with a colour each."""
    found = []
    for role in roles:
        for end in ENDS if role.spin else ("",):
            name = (role.short or role.name) + end
            result = results.structure_factor(run, name)
            if not panels.is_drawable(result):
                continue
            unit = simple_unit(run.observables[f"structure_factor_{name}"].attrs.get("units", "1"))
            if apart:
                number = 1 + ENDS.index(end) if end else role.number
                label = f"{role.label} {dict(MARKED).get(end, '')}".rstrip()
                found.append(Curve(number, label, unit, "", APART[number % len(APART)], result))
            else:
                found.append(Curve(role.number, role.label, unit, end, MARKERS[end], result))
    most = max((curve.result.mean.max() for curve in found), default=0.0)
    return [curve for curve in found if curve.result.mean.max() > panels.DECADES_SHOWN * most]


def structure_unit(parts):
    """The unit that all structure factors share, or None."""
    units = {curve.unit for curve in parts}
    return units.pop() if len(units) == 1 else None


def structure_keys(parts):
    """Keys of a legend: fields by colour, markers of parts along and across q, theory."""
    by_number = {curve.number: [other for other in parts if other.number == curve.number] for curve in parts}
    shared = structure_unit(parts)
    keys = []
    for number, (curve, *others) in by_number.items():
        label = curve.label + ("" if shared else bracket(curve.unit))
        keys.append(panels.key_of(label, colour_of(number), "" if others else curve.marker, "-" if others else ""))
    keys += [panels.key_of(words, marker=MARKERS[end]) for end, words in MARKED if end in {part.end for part in parts}]
    if any(curve.result.has_linear for curve in parts):
        keys.append(panels.key_of("linear theory", line="-", colour="black"))
    return keys


def draw_structure(axes, run, roles, apart=False):
    """Draws structure factors with errors and linear theory, and returns structure_parts()."""
    parts = structure_parts(run, roles, apart)
    if not parts:
        panels.write_instead(axes, "uniform fields:\nevery $S(q)$ is zero")
        return parts
    most = max(curve.result.mean.max() for curve in parts)
    for curve in parts:
        later = [other.result.mean for other in parts if other.number > curve.number and other.marker == curve.marker]
        panels.draw_result(axes, panels.above_rounding(curve.result, most), colour_of(curve.number), curve.marker,
                           panels.spread_shells(curve.result.x), excess(curve.result.mean, later))
    panels.log_axes(axes)
    axes.set_xlabel(panels.with_unit("wavenumber $q$", run.observables["wavenumber"]))
    axes.set_ylabel("$S(q)$" + bracket(structure_unit(parts) or "1"))
    return parts


def draw_structure_with_keys(axes, run):
    """Draws the structure factors of all fields or, of a map with arrows, of scalars and of what the arrows show.

    Returns the results that are drawn.
    """
    roles, apart = roles_of(run), not has_own_fields(run)
    if apart:
        roles = [role for role in roles if not role.spin or role == shown_at(run, -1)[1]]
    parts = draw_structure(axes, run, roles, apart)
    if parts:
        axes.set_ylabel(f"structure factor {axes.get_ylabel()}")
        keys, columns = structure_keys(parts), 1 if apart else 2
        panels.make_room_below(axes, -(-len(keys) // columns))
        axes.legend(handles=keys, loc="lower left", ncols=columns)
    return [curve.result for curve in parts]


def orders_of(run):
    """(label, symbol, series) of the order of each vector and nematic of a run that has one."""
    roles, found = roles_of(run), []
    for role in roles:
        names = (role.name, f"{role.name}_order", f"size_mean_{role.name}") if role.spin else ()
        name = next((name for name in names if name in run.observables), None)
        if name is None:
            continue
        series = loaded(run.observables[name], run.path)
        symbol = "order" if name.endswith("_order") and name != role.name else rf"$|\langle{role.symbol}\rangle|$"
        if name == role.name and series.attrs.get("units", "1") != role.unit:  # the mean over particles
            symbol = symbol.removesuffix("$") + rf"/\langle{roles_first(roles).symbol}\rangle$"
        label = symbol if name.startswith("size_mean_") else series.attrs["long_name"]
        found.append((label, symbol + bracket(simple_unit(series.attrs.get("units", "1"))), series))
    return found


def has_order(run):
    """Whether the particles or the flow have any, beyond rounding."""
    return any(float(series.max()) > NO_ORDER for *_, series in orders_of(run))


def draw_order(axes, run):
    """Draws the order of vectors and nematics over time; of a noisy run the warm-up, shaded, and the mean of the first.
    """
    orders = orders_of(run)
    drawn = [order for order in orders if float(order[-1].max()) > NO_ORDER]
    if not drawn:
        panels.write_instead(axes, f"no order: {orders[0][0]} is zero" if orders else "no vector or nematic")
        return
    for number, (label, _, series) in enumerate(drawn):
        axes.plot(series["time"], series.values, color=(BLUE, GREEN, PURPLE)[number % 3], linewidth=0.9,
                  zorder=2.0 - 0.1 * number, label=label)
    _, symbol, first = drawn[0]
    times = first["time"].values
    if run.summary is not None and has_noise(run.scene):
        panels.draw_mean(axes, run, first, "warm-up, excluded")
    width, height = axes.get_position().size * axes.figure.get_size_inches()
    columns, entries = max(1, int(width / LEGEND_COLUMN)), len(axes.get_legend_handles_labels()[0])
    axes.set_xlim(times[0], times[-1] if len(times) > 1 else times[0] + 1.0)
    axes.set_ylim(0.0, 1.05 * max(float(series.max()) for *_, series in drawn))
    if width > BESIDE_TITLE_FROM:
        axes.legend(loc="lower right", bbox_to_anchor=(1.0, 1.0), ncol=entries, frameon=False, borderaxespad=0.1)
    elif entries > 1:
        axes.legend(loc="upper right", ncol=columns)
        panels.make_room_above(axes, -(-entries // columns))
    axes.xaxis.set_major_locator(MaxNLocator(max(4, int(width)), steps=STEPS))
    axes.yaxis.set_major_locator(MaxNLocator(4, steps=STEPS))
    axes.set_xlabel(panels.with_unit("time $t$", first["time"]))
    is_named = height > LEGEND_COLUMN and not symbol.startswith(drawn[0][0])
    axes.set_ylabel("order" if len(drawn) > 1 else f"{drawn[0][0]} {symbol}" if is_named else symbol)
