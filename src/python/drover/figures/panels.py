"""drover/figures/panels.py: what panels of figures share: colours, labels, averages, axes; and number fluctuations."""
from dataclasses import replace

import numpy
from matplotlib.lines import Line2D
from matplotlib.ticker import FuncFormatter, LogFormatterSciNotation, LogLocator

from .. import results
from drover.archive import loaded
from drover.typeset import bracket, named, spaced

# Colours of Okabe and Ito, distinguishable by colour-blind readers and, with the markers, in greyscale.
BLUE, VERMILLION, GREEN, PURPLE, GREY = "#0072B2", "#D55E00", "#009E73", "#CC79A7", "#606060"
FINE = 384                       # pixels along the longer side of a resolved field
MAX_PIXELS, MAX_ARROWS = 64, 16  # along the longer side of the cell, roughly
MAX_LOST = 0.1                     # of the variance, by averaging over pixels: a field that loses less is smooth
SHORTEST, NOISY, KEPT = 2 / 3, 0.01, 1e-20  # part of the waves, of variance in these; of the power of a wave that is
LEAST_KEPT = 0.2                            # per point: products of four factors leave these waves
SHELLS_PER_DECADE = 12             # points drawn of S(q)
STEPS = (1, 2, 2.5, 5, 10)           # of ticks
DECADES_SHOWN = 1e-10              # of S(q), relative to the largest value: smaller values are rounding errors
ROUNDING = 1e-11                   # relative to a number of rods: smaller fluctuations are rounding errors
COLOUR_PART = 0.99                 # fraction of pixels inside the colour range
FROM_ZERO = 0.6                    # colours start at 0 where the least density is below this part of the largest
LONGEST_TICK = 5                   # letters; longer ones are written as 5e-4 where that is shorter
FEW_DECADES, ONE_DECADE = 40.0, 4.0  # ratios of the ends of an axis below which labels are 0.5 and 2, and 3, 4, ... too
DECADE_ROOM = 0.25                 # inches of an axis for each labelled decade
PAGE_EDGE = 0.1                    # inches from the edge of a page to words
LEAST_PIXELS = 12                  # along the longer side, of averages that make a noisy density positive


def with_unit(label, array):
    return label + bracket(array.attrs.get("units", "1"))


def with_error(value, error):
    """A mean with its standard error, to two digits of it; exact means have the error 0.

    >>> with_error(1061.24, 0.82), with_error(0.8113, 0.0049)
    ('1061.24 $\\\\pm$ 0.82', '0.8113 $\\\\pm$ 0.0049')
    """
    if not error > 0.0:
        return f"{value:.3g}" + ("" if error == 0.0 else ", no error estimate")
    digits = 1 - int(numpy.floor(numpy.log10(error)))
    if not 0 <= digits <= 6:
        return rf"{value:.3g} $\pm$ {error:.2g}"
    return rf"{value:.{digits}f} $\pm$ {error:.{digits}f}"


def length_text(run):
    """The unit of length after a number."""
    return spaced(named("mm", run.scene))


def time_text(time, run):
    """ "$t$ = 12.5 s" """
    return f"$t$ = {time}{spaced(named('s', run.scene))}"


def extent_of(array, pixel):
    """The edges of an image of an array: left, right, bottom, top."""
    x, y = array["x"].values, array["y"].values
    return x[0] - pixel[0] / 2, x[-1] + pixel[0] / 2, y[0] - pixel[1] / 2, y[-1] + pixel[1] / 2


def is_resolved(run, pixel):
    """Whether a map shows every point of the grid, and no averages."""
    grid = run.scene["grid"]
    return all(size < 1.01 * side / points for size, side, points in
               zip(pixel, (grid["lx"], grid["ly"]), (grid["nx"], grid["ny"])))


def colour_range(values):
    """Ends of the colours of a density, which start at 0 where it comes near, and the ends that values exceed."""
    low, high = numpy.quantile(values, ((1.0 - COLOUR_PART) / 2, (1.0 + COLOUR_PART) / 2))
    if not high - low > 1e-12 * abs(high):  # nearly all are equal: the ends are those of the few others
        low, high = values.min(), values.max()
        if 0.0 <= low < FROM_ZERO * high:
            return 0.0, high, "neither"
        if high - low > 1e-12 * abs(high):
            return low, high, "neither"
    if not high - low > 1e-12 * abs(high):  # uniform field: middle colour
        return (0.9 * low, 1.1 * high, "neither") if high > 0.0 else (low - 1.0, high + 1.0, "neither")
    if 0.0 <= low < FROM_ZERO * high and values.min() >= 0.0:
        return 0.0, high, "max"
    return low, high, "both"


def edges_of(values):
    """The edges of cells around values along an axis; a single cell is as wide as its value is large, or 1 at 0."""
    values = numpy.asarray(values, float)
    steps = numpy.diff(values) if len(values) > 1 else numpy.array([abs(values[0]) or 1.0])
    return numpy.concatenate([values[:1] - steps[:1] / 2, values[:-1] + numpy.diff(values) / 2,
                              values[-1:] + steps[-1:] / 2])


def add_arrow_key(axes, arrows, longest, length, symbol, array, above=None):
    """The scale of arrows at the lower right of a map, inches above the page or below the axes.

    `longest` is their largest value, drawn with `length`; `array` has the unit.
    """
    inches, box, key = axes.figure.get_size_inches(), axes.get_position(), float(f"{longest:.0e}")
    part = key * length / longest / abs(numpy.diff(axes.get_xlim())[0])
    lift = -0.58 if above is None else above - box.y0 * inches[1]
    place = 1.0 - part - 0.05 / (box.width * inches[0]), lift / (box.height * inches[1])
    drawn, words = draw_arrow_key(axes, arrows, place, key,
                                  rf"arrow: $|{symbol}|={key:g}$" + spaced(array.attrs.get("units", "1")))
    cut = PAGE_EDGE - words.get_window_extent().x0 / axes.figure.dpi  # below a narrow map words are wider than it
    if cut > 0.0:
        drawn.X = place[0] + cut / (box.width * inches[0])
        words.xy = drawn.X, place[1]


def draw_arrow_key(axes, arrows, place, value, words, coordinates="axes"):
    """A key of arrows and the words on its left, which a notebook keeps when it cuts the margins of a page."""
    key = axes.quiverkey(arrows, *place, value, "", labelpos="W", coordinates=coordinates, color="black")
    text = axes.annotate(words, place, (-0.6, 0.0), {"axes": "axes fraction"}.get(coordinates, coordinates),
                         "offset fontsize", horizontalalignment="right", verticalalignment="center",
                         annotation_clip=False)
    return key, text


def shown_means(array, is_density=True):
    """What a map shows: block averages of a noisy field, every point of a smooth one; and the size of a pixel.

    The noise of few bodies in a cell of the grid makes their density negative there: blocks grow until none is.
    """
    shown, pixel = array, steps_of(array)
    pixels = MAX_PIXELS
    while pixels == MAX_PIXELS or (
            is_density and float(shown.min()) < 0.0 < float(shown.mean()) and pixels >= LEAST_PIXELS):
        means, block = block_means(array, pixels)
        pixels /= 2
        lost = float(shown.var()) - float(means.var())
        if lost > MAX_LOST * float(shown.var()) and lost > (ROUNDING * float(shown.mean()))**2 and is_noisy(array):
            shown, pixel = means, block
    return shown, pixel


def refined(array):
    """A periodic field on FINE points or more along the longer side, by its Fourier series, with the size of a pixel.

    The waves that a run keeps define the field between the points of the grid: nothing is smoothed away.
    """
    factor = -(-FINE // max(array.sizes["x"], array.sizes["y"]))
    steps = {axis: float(array[axis][1] - array[axis][0]) / (factor if array.sizes[axis] > 1 else 1) for axis in "xy"}
    fine = refined_values(array.transpose("y", "x").values)
    places = {name: float(array[name][0]) + steps[name] * numpy.arange(fine.shape[axis])
              for axis, name in enumerate(("y", "x"))}
    drawn = type(array)(fine, places, ("y", "x"), attrs=array.attrs)
    for axis in "xy":
        drawn[axis].attrs.update(array[axis].attrs)
    return drawn, (steps["x"], steps["y"])


def is_noisy(array):
    """Whether the shortest waves that a field has hold variance, as those of noise do and those of a pattern do not."""
    values = array.transpose("y", "x").values
    power = abs(numpy.fft.fft2(values - values.mean()))**2
    waves = numpy.maximum(*numpy.meshgrid(*(abs(numpy.fft.fftfreq(size)) for size in values.shape), indexing="ij"))
    kept = max(waves[power > KEPT * power.max()].max(), LEAST_KEPT)
    return bool(power[waves > SHORTEST * kept].sum() > NOISY * power.sum())


def steps_of(array):
    """The spacing of its points along x and y."""
    return tuple(float(array[axis][1] - array[axis][0]) for axis in "xy")


def refined_values(values):
    """The values (y, x) of refined()."""
    factor = -(-FINE // max(values.shape))
    for axis in (0, 1):
        if values.shape[axis] > 1 and factor > 1:
            values = fourier_series(values, axis, factor)
    return values


def fourier_series(values, axis, factor):
    """Values of a periodic array on `factor` times as many points along an axis."""
    count = values.shape[axis]
    waves = numpy.fft.rfft(values, axis=axis)
    if count % 2 == 0:  # the wave of two points has half of its weight on either side
        waves[(slice(None),) * axis + (-1,)] *= 0.5
    return factor * numpy.fft.irfft(waves, count * factor, axis=axis)


def block_means(array, count):
    """Averages over blocks, about `count` along the longer side of the cell, and the size of a block."""
    steps = dict(zip("xy", steps_of(array)))
    side = max(steps[axis] * array.sizes[axis] for axis in "xy") / count
    cells = {axis: nearest_divisor(array.sizes[axis], side / steps[axis]) for axis in "xy"}
    means = array.coarsen(cells).mean(keep_attrs=True)
    for axis in "xy":
        means[axis].attrs.update(array[axis].attrs)
    return means, tuple(cells[axis] * steps[axis] for axis in "xy")


def nearest_divisor(points, wanted):
    """The divisor of a number of points whose ratio to the wanted number is closest to 1."""
    divisors = [n for n in range(1, points + 1) if points % n == 0]
    return min(divisors, key=lambda n: abs(numpy.log(n / wanted)))


def draw_result(axes, result, colour, marker, shown=slice(None), excess=0.0):
    """Draws points with error bars (open symbols without), and the theory as a line; `excess` in size, in points."""
    x, mean, error = result.x[shown], result.mean[shown], result.error[shown]
    sure = numpy.isfinite(error)
    style = {"color": colour, "marker": marker, "linestyle": "none", "markersize": 4.5 + excess, "zorder": 3}
    axes.errorbar(x[sure], mean[sure], error[sure], capsize=2, elinewidth=1, **style)
    axes.plot(x[~sure], mean[~sure], markerfacecolor="white", **style)
    axes.plot(result.x, result.linear, color=colour, linewidth=1.2, zorder=2, marker="_" if len(result.x) == 1 else "")


def key_of(label, colour=GREY, marker="", line="", fill=None):
    return Line2D([], [], color=colour, marker=marker, linestyle=line, markersize=4.5, markerfacecolor=fill or colour,
                  label=label)


def log_axes(axes, x_only=False):
    axes.set_xscale("log")
    if not x_only:
        axes.set_yscale("log")
    for axis in (axes.xaxis,) if x_only else (axes.xaxis, axes.yaxis):
        minor_ticks(axis)


def minor_ticks(axis):
    """Ticks of a logarithmic axis: powers of ten or, where it spans few decades, plain numbers between them too."""
    box, inches = axis.axes.get_position(), axis.axes.figure.get_size_inches()
    room = box.width * inches[0] / 2.0 if axis.axis_name == "x" else box.height * inches[1]
    axis.set_major_locator(LogLocator(numticks=max(3, int(room / DECADE_ROOM))))
    axis.set_minor_locator(LogLocator(subs=range(2, 10), numticks=20))
    powers = LogFormatterSciNotation()
    powers.set_axis(axis)
    axis.set_major_formatter(FuncFormatter(
        lambda value, place: plain(value, place) if span_of(axis) < FEW_DECADES else powers(value, place)))
    axis.set_minor_formatter(FuncFormatter(lambda value, place: minor_label(value, place, axis)))


def span_of(axis):
    low, high = axis.get_view_interval()
    return high / low if low > 0.0 else numpy.inf


def minor_label(value, place, axis):
    """Labels 2 and 5 of each decade on axes that span few decades, and all where they span less than one."""
    span = span_of(axis)
    labelled = span < ONE_DECADE or (span < FEW_DECADES and f"{value:.3e}"[:5] in ("2.000", "5.000"))
    return plain(value, place) if labelled else ""


def plain(value, _):
    """A tick without the offset of matplotlib, which other texts would cover."""
    text = f"{round(value, 15):.10g}"
    if len(text) > LONGEST_TICK:
        mantissa, _, power = f"{value:.3e}".partition("e")
        short = f"{float(mantissa):g}e{int(power)}"
        text = short if len(short) < len(text) and float(short) == float(text) else text
    return text.replace("-", "\N{MINUS SIGN}")


def make_room_below(axes, entries):
    """Extends axes of any scale at the bottom for a legend with this many entries."""
    part = (0.25 + 0.21 * entries) / (axes.get_position().height * axes.figure.get_size_inches()[1])
    scale = axes.yaxis.get_transform()
    bottom, top = scale.transform(axes.get_ylim())
    lower = scale.inverted().transform([bottom - (top - bottom) * part / (1.0 - part)])[0]
    axes.set_ylim(lower, axes.get_ylim()[1])


def make_room_above(axes, rows):
    """Extends linear axes at the top for a legend with this many rows."""
    part = (0.22 + 0.19 * rows) / (axes.get_position().height * axes.figure.get_size_inches()[1])
    bottom, top = axes.get_ylim()
    axes.set_ylim(bottom, bottom + (top - bottom) / max(0.2, 1.0 - part))


def write_instead(axes, message):
    """Writes why a panel has no data."""
    axes.set_xticks([])
    axes.set_yticks([])
    axes.text(0.5, 0.5, message, ha="center", va="center", transform=axes.transAxes, color=GREY)


def is_drawable(result):
    return result is not None and bool((result.mean > 0.0).any())


def above_rounding(result, most):
    """A structure factor without the values that are rounding errors of the largest of all that are drawn."""
    kept = result.mean > DECADES_SHOWN * most
    return replace(result, mean=numpy.where(kept, result.mean, numpy.nan),
                   linear=numpy.where(kept, result.linear, numpy.nan))


def spread_shells(q):
    """Indices of shells evenly spaced on a logarithmic axis."""
    if len(q) == 0:
        return numpy.array([], dtype=int)
    steps = numpy.unique(numpy.rint(SHELLS_PER_DECADE * numpy.log10(q / q[0])), return_index=True)[1]
    return numpy.unique(numpy.append(steps, len(q) - 1))


def draw_numbers(upper, lower, run):
    """Draws number fluctuations above, their local exponents below; returns the results drawn."""
    numbers, bodies = results.number_fluctuations(run), results.counted_bodies(run)
    if not is_drawable(numbers) or not (numbers.mean > ROUNDING * numbers.x).any():
        for axes in (upper, lower):
            write_instead(axes, "no fluctuations\nof " + (f"the number of {bodies}s" if bodies else "a number"))
        return []
    draw_result(upper, numbers, BLUE, "o")
    upper.plot(numbers.x, numpy.sqrt(numbers.x), color=GREY, linestyle=":")
    log_axes(upper)
    upper.set_ylabel(r"deviation $\Delta N$")
    upper.tick_params(which="both", labelbottom=False)
    keys = number_keys(numbers, bodies or "particle")
    make_room_below(upper, len(keys) - 1)  # the points ascend, which leaves some space
    upper.legend(handles=keys, loc="lower right")
    exponents = results.number_exponents(run, numbers)
    draw_result(lower, exponents, BLUE, "o")
    lower.axhline(0.5, color=GREY, linestyle=":")
    log_axes(lower, x_only=True)
    lower.set_xlim(upper.get_xlim())
    lower.set_xlabel(f"mean {results.counted_words(run)} in a box")
    lower.set_ylabel(r"d ln $\Delta N$ / d ln $N$")
    return [numbers, exponents]


def number_keys(numbers, what):
    theory = [key_of("linear theory", BLUE, line="-")] if numbers.has_linear else []
    return [key_of("this run", BLUE, "o"), *theory, key_of(rf"independent {what}s, $\sqrt{{N}}$", line=":")]


def draw_mean(axes, run, series, words=""):
    """Draws the warm-up, shaded, and the mean of a series after it; `words`: of the warm-up in a legend."""
    mean, error = (float(loaded(run.summary[name], run.path)) for name in (series.name, f"{series.name}_error"))
    times = series["time"].values
    axes.plot([shade_warm_up(axes, run, times, words), times[-1]], [mean, mean], color=VERMILLION, linestyle="--",
              label=f"mean {with_error(mean, error)}")


def shade_warm_up(axes, run, times, words=""):
    """Shades the times that means leave out; returns their end."""
    warm_up = 0.0 if run.summary is None else float(loaded(run.summary["warm_up"], run.path))
    if warm_up > 0.0:
        axes.axvspan(times[0], times[0] + warm_up, color="#d9d9d9", linewidth=0, zorder=0, label=words)
    return times[0] + warm_up
