"""drover/figures/particle_motion.py: panels of how particles move: paths, flow, wake, memory of direction, several
series."""
import numpy
from matplotlib.collections import LineCollection
from matplotlib.patches import Polygon
from matplotlib.ticker import MaxNLocator

from . import particle_panels as panels
from drover.archive import loaded
from drover.figures.panels import (BLUE, GREEN, GREY, MAX_ARROWS, STEPS, VERMILLION, draw_arrow_key, make_room_above,
                                   shade_warm_up, with_error, with_unit)

LOOKS = (BLUE, VERMILLION, GREEN)
FEW_RODS = 3             # of which whole paths are drawn
PATH_PART = 0.5          # of the shorter side of the cell: the mean length of other paths
BEADS_PER_ARROW = 12     # at least, on average
LEAST_DENSITY = 0.5      # of beads around a rod, relative to the median: bins with less lie in the rod
MAX_LAGS = 60            # of the memory of direction, up to this part of the run
LONGEST_LAG = 0.3
SPEED_POINTS = 80        # of the speed along the axis


def paths(run, frame, sides):
    """Positions of the rods up to a frame, not wrapped: (frame, rod, 2)."""
    last = range(run.frames.sizes["time"])[frame]
    places = run.frames["rod_position"]
    first = 0
    if run.frames.sizes["rod"] > FEW_RODS and last > 0:
        step = [panels.frame_of(run, "rod_position", k)[:, :2] for k in (last - 1, last)]
        length = float(numpy.hypot(*(step[1] - step[0]).T).mean())
        first = max(0, last - max(1, int(PATH_PART * min(sides) / max(length, 1e-12))))
    return loaded(places.isel(time=slice(first, last + 1)), run.path).values[..., :2]


def view_in(run, places, sides):
    """That of view_of() for rods alone in a periodic cell; else None."""
    return view_of(places, sides) if panels.is_periodic(run) and "bead" not in run.frames.sizes else None


def view_of(places, sides):
    """Left, right, bottom and top of the paths of few rods in a cell that is much larger; None for the whole cell."""
    low, high = places.min(axis=(0, 1)), places.max(axis=(0, 1))
    side = 1.15 * (high - low).max() + 8.0  # mm around the ends
    if places.shape[1] > FEW_RODS or 2.0 * side > min(sides):
        return None
    (left, bottom), (right, top) = 0.5 * (low + high) - 0.5 * side, 0.5 * (low + high) + 0.5 * side
    return numpy.array([left, right, bottom, top])


def draw_paths(axes, run, places, frame, sides, periodic):
    """Draws the paths of the rods, fading into the past, in the colour of their direction."""
    if len(places) < 2:
        return
    steps = numpy.diff(places, axis=0)
    starts, ends = places[:-1], places[1:]
    if periodic:
        starts = starts - sides * numpy.floor(starts / sides + 0.5)
        ends = ends - sides * numpy.floor(ends / sides + 0.5)
    n = panels.frame_of(run, "rod_axis", frame)
    colours = 0.8 * panels.direction_colours(numpy.arctan2(n[:, 1], n[:, 0]))
    fade = numpy.linspace(1.0, 0.15, len(steps))[::-1]
    rgba = numpy.concatenate([numpy.broadcast_to(colours, (len(steps), *colours.shape)),
                              numpy.broadcast_to(fade[:, None, None], (*steps.shape[:2], 1))], axis=2).reshape(-1, 4)
    # A step that crosses the edge of a periodic cell is drawn at both of its ends.
    for one, other in ((starts, starts + steps), (ends - steps, ends)) if periodic else ((starts, ends),):
        lines = LineCollection(numpy.stack([one.reshape(-1, 2), other.reshape(-1, 2)], axis=1), colors=rgba,
                               linewidths=1.0, zorder=2.5)
        axes.add_collection(lines, autolim=False)
        if periodic:
            panels.clip(lines, axes, run, sides)


def mean_flow(run, frame, sides):
    """Displacements of the beads since the frame before, divided by that time and averaged over blocks [mm/s]; mean
    places; the size of a block; the time; the mean number of beads in a block."""
    last = max(1, range(run.frames.sizes["time"])[frame])
    before, now = (panels.frame_of(run, "bead_position", k)[:, :2] for k in (last - 1, last))
    time = float(run.frames["time"][last] - run.frames["time"][last - 1])
    longer = numpy.clip(numpy.sqrt(len(now) / BEADS_PER_ARROW * max(sides) / min(sides)), 2, MAX_ARROWS)
    counts = numpy.maximum(1, numpy.rint(longer * sides / max(sides))).astype(int)
    middle = 0.5 * (before + now)
    if panels.is_periodic(run):
        middle = middle - sides * numpy.floor(middle / sides + 0.5)
    edges = [numpy.linspace(-0.5 * side, 0.5 * side, count + 1) for side, count in zip(sides, counts)]
    number, *_ = numpy.histogram2d(*middle.T, edges)
    full = number >= BEADS_PER_ARROW / 3
    flow, place = ([numpy.histogram2d(*middle.T, edges, weights=part)[0][full] / number[full] for part in parts]
                   for parts in (((now - before) / time).T, middle.T))
    return flow, place, min(sides / counts), time, number[full].mean()


def draw_flow(axes, run, frame, sides):
    """Draws arrows of the mean velocity of the beads since the frame before; returns that time and beads per arrow."""
    if run.frames.sizes["time"] < 2 or "bead_position" not in run.frames:
        return None
    flow, place, block, time, beads = mean_flow(run, frame, sides)
    longest = float(numpy.hypot(*flow).max(initial=0.0))
    if not longest > 0.0:
        return None
    arrows = axes.quiver(*place, *flow, color="black", edgecolor="white", linewidth=0.4,
                         pivot="mid", angles="xy", scale_units="xy", scale=longest / block, units="inches", width=0.02,
                         headwidth=4, headlength=4, headaxislength=3.5, zorder=5)
    value = float(f"{longest:.0e}")
    inches = min(axes.get_figure().get_size_inches() * axes.get_position().size)
    line = 0.0 if inches > 4.0 else 0.2 / inches  # below the bar of the scale where both do not fit beside each other
    right, low = 0.5 * sides[0], -0.5 * sides[1] - (0.035 + line) * max(sides)
    draw_arrow_key(axes, arrows, (right - value * block / longest, low), value,
                   rf"beads: $|\mathbf{{v}}|={value:g}$ mm s$^{{-1}}$", "data")
    return time, beads


def draw_wake(axes, run, bar_axes=None):
    """Draws the mean velocity of the beads in the frame of a rod: along it as colours, both components as arrows."""
    along, across = (loaded(run.summary[f"flow_velocity_{part}"], run.path) for part in ("along", "across"))
    x, y = along["along_rod"].values, along["across_rod"].values
    along, across = (part.transpose("across_rod", "along_rod").values for part in (along, across))
    density = loaded(run.summary["flow_density"], run.path).transpose("across_rod", "along_rod").values
    is_rod = ~(density > LEAST_DENSITY * numpy.nanmedian(density))  # of few beads there, or none
    along, across = (numpy.ma.array(part, mask=is_rod | ~numpy.isfinite(part)) for part in (along, across))
    most = (float(numpy.quantile(numpy.abs(along).compressed(), 0.99)) if along.count() else 0.0) or 1.0
    image = axes.pcolormesh(x, y, along, cmap="RdBu_r", vmin=-most, vmax=most, shading="nearest", rasterized=True)
    stride = max(1, len(x) // 9)
    axes.quiver(x[::stride], y[::stride], along[::stride, ::stride], across[::stride, ::stride], color="black",
                pivot="mid", angles="xy", scale_units="xy", scale=most / (stride * (x[1] - x[0])), units="inches",
                width=0.012)
    at, radius = (loaded(run.frames[name], run.path).values[0] for name in ("rod_sphere_at", "rod_sphere_radius"))
    z, half = panels.outline(at, radius)
    axes.add_patch(Polygon(numpy.concatenate([numpy.column_stack([z, half]), numpy.column_stack([z, -half])[::-1]]),
                           facecolor="white", edgecolor="black", linewidth=0.8, zorder=4))
    axes.set_aspect("equal")
    axes.set_xlabel("ahead of a rod [mm]")
    axes.set_ylabel("to its left [mm]")
    for axis in (axes.xaxis, axes.yaxis):
        axis.set_major_locator(MaxNLocator(4, steps=STEPS))
    bar = axes.figure.colorbar(image, cax=bar_axes, ax=None if bar_axes is not None else axes, extend="both")
    bar.set_label(r"$v_\parallel$ [mm s$^{-1}$]")
    bar.locator = MaxNLocator(5, steps=STEPS)


def memory_of(run):
    """C(t) = <cos(theta(t0 + t) - theta(t0))> over rods and times t0, after the warm-up: lags [s] and C."""
    times = run.frames["time"].values
    warm_up = float(run.summary["warm_up"]) if run.summary is not None else 0.0
    n = loaded(run.frames["rod_axis"].isel(time=slice(int(numpy.searchsorted(times, warm_up)), None)), run.path)
    n = n.values[..., :2] / numpy.linalg.norm(n.values[..., :2], axis=-1, keepdims=True)
    most = max(1, int(LONGEST_LAG * len(n)))
    lags = numpy.unique(numpy.linspace(0, min(most, len(n) - 1), min(MAX_LAGS, most + 1)).astype(int))
    return lags * (times[-1] - times[0]) / max(1, len(times) - 1), numpy.array(
        [(n[lag:] * n[:len(n) - lag]).sum(-1).mean() for lag in lags])


def draw_memory(axes, run):
    """Draws how long rods keep their direction, with the exponential of the measured rotational diffusion."""
    lags, memory = memory_of(run)
    axes.plot(lags, memory, "o", color=BLUE, markersize=3, label="this run", clip_on=False)  # also at the edges
    if run.summary is not None and "rotational_diffusion" in run.summary:
        rate, error = (float(loaded(run.summary[f"rotational_diffusion{end}"], run.path)) for end in ("", "_error"))
        if rate > 0.0:
            known = rf" $\pm$ {error / rate**2:.1g} s" if error > 0.0 else " s, error unknown"
            axes.plot(lags, numpy.exp(-rate * lags), color=VERMILLION,
                      label=rf"$e^{{-D_r t}}$, $1/D_r$ = {1.0 / rate:.3g}{known}")
    axes.axhline(0.0, color=GREY, linewidth=0.7, zorder=0)
    low = min(0.0, float(memory.min()))
    axes.set_ylim(1.1 * low, 1.0)
    make_room_above(axes, 1)
    axes.set_xlim(0.0, lags[-1] if len(lags) > 1 else 1.0)
    axes.set_xlabel("time lag [s]")
    axes.set_ylabel(r"$\langle\cos\Delta\theta\rangle$")
    finish(axes)


def finish(axes):
    axes.legend(loc="upper right", ncols=2, columnspacing=1.0, handlelength=1.4)
    axes.xaxis.set_major_locator(MaxNLocator(5, steps=STEPS))
    axes.yaxis.set_major_locator(MaxNLocator(4, steps=STEPS))


def draw_speed(axes, run, now):
    """Draws the velocity of the rods along their axes: displacements between frames, averaged over rods and time."""
    places, n = (loaded(run.frames[name], run.path).values[..., :2] for name in ("rod_position", "rod_axis"))
    times = run.frames["time"].values
    n = n[:-1] / numpy.linalg.norm(n[:-1], axis=-1, keepdims=True)
    speed = ((places[1:] - places[:-1]) * n).sum(-1).mean(axis=1) / numpy.diff(times)
    group = max(1, len(speed) // SPEED_POINTS)
    count = len(speed) // group
    middle = 0.5 * (times[:-1] + times[1:])
    axes.plot(middle[:count * group].reshape(count, group).mean(1), speed[:count * group].reshape(count, group).mean(1),
              color=BLUE, linewidth=0.9)
    begin = shade_warm_up(axes, run, times)
    if run.summary is not None and "rod_speed" in run.summary:
        mean, error = (float(loaded(run.summary[f"rod_speed{end}"], run.path)) for end in ("", "_error"))
        axes.plot([begin, times[-1]], [mean, mean], color=VERMILLION, linestyle="--",
                  label=f"mean {with_error(mean, error)}")
    axes.axvline(now, color="#b0b0b0", linewidth=0.7, zorder=0)
    frame_series(axes, times)
    axes.set_ylabel(r"$\mathbf{v}\cdot\mathbf{n}$ [mm s$^{-1}$]")


def frame_series(axes, times):
    """Limits, legend and ticks of panels over time; there is space above the curves for the legend."""
    values = numpy.concatenate([line.get_ydata() for line in axes.lines if len(line.get_ydata()) != 2 or
                                line.get_linestyle() == "--"])
    low, high = min(0.0, float(numpy.nanmin(values))), max(0.0, float(numpy.nanmax(values)))
    size = high - low or 1.0
    axes.set_ylim(low - 0.05 * size * (low < 0.0), low + size)
    entries = len(axes.get_legend_handles_labels()[0])
    make_room_above(axes, entries)
    if entries:
        axes.legend(loc="upper right")
    axes.set_xlim(times[0], times[-1] if len(times) > 1 else times[0] + 1.0)
    axes.set_xlabel("time $t$ [s]")
    axes.xaxis.set_major_locator(MaxNLocator(5, steps=STEPS))
    axes.yaxis.set_major_locator(MaxNLocator(4, steps=STEPS))


def draw_several(axes, run, names, now, label):
    """Draws several observables of one unit over time, with their means in the legend: {name: words}."""
    for (name, words), colour in zip(names.items(), LOOKS):
        series = loaded(run.observables[name], run.path)
        axes.plot(series["time"], series.values, color=colour, linewidth=0.9, label=words + mean_words(run, name))
    axes.axvline(now, color="#b0b0b0", linewidth=0.7, zorder=0)
    shade_warm_up(axes, run, series["time"].values)
    frame_series(axes, series["time"].values)
    axes.set_ylabel(with_unit(label, series))


def draw_temperatures(axes, run, now):
    """Draws the temperatures of the beads over time, on a logarithmic axis: they differ by a factor."""
    names = {"bead_temperature_horizontal": "in the plane", "bead_temperature_vertical": "vertical"}
    draw_several(axes, run, names, now, "temperature")
    values = numpy.concatenate([run.observables[name].values for name in names])
    positive = values[values > 0.0]
    if positive.size:
        low, high = positive.min(), positive.max()
        axes.set_yscale("log")
        axes.set_ylim(0.5 * low, 2.0 * high * (high / low)**0.8)  # space for the legend


def mean_words(run, name):
    """The mean of a finished run, for a legend."""
    if run.summary is None or f"{name}_error" not in run.summary:
        return ""
    return ": " + with_error(*(float(loaded(run.summary[f"{name}{end}"], run.path)) for end in ("", "_error")))


def draw_pairs(axes, run):
    """Draws the pair correlation g(r) of the beads: of a finished run its mean, else of all samples."""
    name = "pair_correlation_beads"
    found = run.summary[name] if run.summary is not None else run.observables[name].mean("time")
    g = loaded(found, run.path)
    r = g["bead_separation"].values
    axes.plot(r, g.values, color=BLUE, linewidth=1.2)
    axes.axhline(1.0, color=GREY, linestyle=":", linewidth=0.9)
    axes.set_xlim(0.0, r[-1])
    axes.set_ylim(0.0, None)
    axes.set_xlabel("separation $r$ [mm]")
    axes.set_ylabel("$g(r)$")
