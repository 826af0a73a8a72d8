"""drover/figures/particle_panels.py: panels of the figure of a particle run, drawn on given axes."""
import numpy
from matplotlib.collections import PatchCollection, PolyCollection
from matplotlib.colors import ListedColormap
from matplotlib.lines import Line2D
from matplotlib.patches import Circle, Rectangle
from matplotlib.ticker import MaxNLocator

from drover.archive import loaded
from drover.figures.panels import BLUE, ROUNDING, STEPS, draw_mean, with_unit

BEAD, BEAD_EDGE, LIGHTNESS, CHROMA = "#d4d4d4", "#9a9a9a", 66.0, 40.0
WORDS = {"polar_order": ("polar order", r"$|\langle\mathbf{n}\rangle|$"),
         "energy_kinetic": ("kinetic energy", r"energy"),
         "bead_velocity_order": ("bead velocity order", r"order"),
         "bead_velocity_size": ("mean bead velocity", r"$|\langle\mathbf{v}\rangle|$")}


def words_of(name):
    return WORDS.get(name, (name.replace("_", " "), ""))[0]


def direction_colours(angles):
    """Colours of directions [rad]: hues of equal lightness and chroma (CIE LCh)."""
    angles = numpy.asarray(angles, dtype=float)
    fy = (LIGHTNESS + 16.0) / 116.0
    fx, fz = fy + CHROMA * numpy.cos(angles) / 500.0, fy - CHROMA * numpy.sin(angles) / 200.0
    cubed = [numpy.where(f > 6 / 29, f**3, 3 * (6 / 29)**2 * (f - 4 / 29)) for f in (fx, numpy.full_like(fx, fy), fz)]
    xyz = numpy.stack(cubed, axis=-1) * (0.95047, 1.0, 1.08883)  # D65
    linear = xyz @ numpy.array([[3.2406, -0.9689, 0.0557], [-1.5372, 1.8758, -0.2040], [-0.4986, 0.0415, 1.0570]])
    linear = numpy.clip(linear, 0.0, 1.0)
    return numpy.where(linear <= 0.0031308, 12.92 * linear, 1.055 * linear**(1 / 2.4) - 0.055)


def outline(at, radius, points=72):
    """Union of the hulls of neighbouring spheres on an axis: positions along the axis and half widths."""
    inner = numpy.linspace(0.0, numpy.pi, points)
    low, high = (at - radius).min(), (at + radius).max()
    z = 0.5 * (low + high) - 0.5 * (high - low) * numpy.cos(inner)  # denser at the round tips
    half = numpy.sqrt(numpy.maximum(0.0, radius[:, None]**2 - (z - at[:, None])**2)).max(axis=0)
    for i in range(len(at) - 1):
        gap = at[i + 1] - at[i]
        sine = (radius[i] - radius[i + 1]) / gap if gap > 0.0 else 1.0
        if abs(sine) >= 1.0:
            continue
        cosine = numpy.sqrt(1.0 - sine**2)
        ends = at[i:i + 2] + radius[i:i + 2] * sine
        line = (radius[i] - (z - at[i]) * sine) / cosine
        inside = (z >= ends[0]) & (z <= ends[1])
        half[inside] = numpy.maximum(half, line)[inside]
    return z, half


def shifted(places, reach, sides, periodic):
    """Indices of bodies and their positions; in a periodic cell with images of bodies that cross an edge."""
    half = 0.5 * sides
    wrapped = places - sides * numpy.floor(places / sides + 0.5) if periodic else places
    which, where = [numpy.arange(len(places))], [wrapped]
    for shift in [(i, j) for i in (-1, 0, 1) for j in (-1, 0, 1) if (i, j) != (0, 0)] if periodic else []:
        moved = wrapped + sides * numpy.array(shift)
        seen = (numpy.abs(moved) < half + reach[:, None]).all(axis=1)
        which.append(numpy.flatnonzero(seen))
        where.append(moved[seen])
    return numpy.concatenate(which), numpy.concatenate(where)


def is_periodic(run):
    return run.scene["cell"].get("shape", "periodic") == "periodic"


def frame_of(run, name, frame):
    return loaded(run.frames[name].isel(time=frame), run.path).values


def fixed_of(run, name):
    return loaded(run.frames[name], run.path).values


def draw_beads(axes, run, frame, sides):
    """Draws beads, if any, as discs."""
    if "bead_position" not in run.frames:
        return
    places, radius = frame_of(run, "bead_position", frame)[:, :2], fixed_of(run, "bead_radius")
    which, where = shifted(places, radius, sides, is_periodic(run))
    discs = PatchCollection([Circle(place, radius[bead]) for bead, place in zip(which, where)], facecolor=BEAD,
                            edgecolor=BEAD_EDGE, linewidth=0.3, zorder=2)
    axes.add_collection(discs)
    clip(discs, axes, run, sides)


def draw_rods(axes, run, frame, sides, periodic):
    """Draws rods, if any, as outlines coloured by direction, in a periodic cell with images."""
    if "rod_position" not in run.frames:
        return
    places, axis = (frame_of(run, name, frame) for name in ("rod_position", "rod_axis"))
    at, radius = fixed_of(run, "rod_sphere_at"), fixed_of(run, "rod_sphere_radius")
    polygons, colours = rod_outlines(places, axis, at, radius, sides, periodic)
    drawn = PolyCollection(polygons, facecolors=colours, edgecolors="#303030", linewidths=0.4, zorder=3)
    axes.add_collection(drawn)
    if periodic:
        clip(drawn, axes, run, sides)


def rod_outlines(places, axis, at, radius, sides, periodic):
    """Outlines of rods seen from above, with images of those that cross an edge, and their colours."""
    reach = numpy.abs(at).max(axis=1) + radius.max(axis=1)
    flat = axis[:, :2]
    colours = direction_colours(numpy.arctan2(flat[:, 1], flat[:, 0]))
    shapes = {}
    for rod in range(len(places)):
        key = (at[rod].tobytes(), radius[rod].tobytes())
        shapes.setdefault(key, outline(at[rod], radius[rod]))
    which, where = shifted(places[:, :2], reach, sides, periodic)
    polygons = []
    for rod, place in zip(which, where):
        z, half = shapes[at[rod].tobytes(), radius[rod].tobytes()]
        along, size = flat[rod], numpy.hypot(*flat[rod])  # a tilted rod is shorter when seen from above
        across = numpy.array([-along[1], along[0]]) / size if size > 0.0 else numpy.array([0.0, 1.0])
        sides_of_rod = [place + numpy.outer(z, along) + sign * numpy.outer(half, across) for sign in (1.0, -1.0)]
        polygons.append(numpy.concatenate([sides_of_rod[0], sides_of_rod[1][::-1]]))
    return polygons, colours[which]


def clip(drawn, axes, run, sides):
    if is_periodic(run):
        drawn.set_clip_path(Rectangle(-0.5 * sides, *sides, transform=axes.transData))


def wall_line(cell, sides):
    """The wall of a cell as a closed line."""
    shape = cell.get("shape", "periodic")
    if shape in ("periodic", "rectangle"):
        return numpy.array([(-1, -1), (1, -1), (1, 1), (-1, 1), (-1, -1)]) * 0.5 * sides
    if shape == "circle":
        turn = numpy.linspace(0.0, 2.0 * numpy.pi, 361)
        return cell["radius"] * numpy.column_stack([numpy.cos(turn), numpy.sin(turn)])
    half_turn, arc = numpy.pi / cell["petals"], cell["petal_radius"]
    chord = cell["radius"] * numpy.sin(half_turn)
    centre = cell["radius"] * numpy.cos(half_turn) - numpy.sqrt(max(0.0, arc**2 - chord**2))
    turn = numpy.linspace(-1.0, 1.0, 41) * numpy.arcsin(min(1.0, chord / arc))
    points = []
    for petal in range(int(cell["petals"])):
        c, s = numpy.cos(2 * half_turn * petal), numpy.sin(2 * half_turn * petal)
        x, y = centre + arc * numpy.cos(turn), arc * numpy.sin(turn)
        points.append(numpy.column_stack([c * x - s * y, s * x + c * y]))
    return numpy.concatenate([*points, points[0][:1]])


def draw_cell(axes, run, sides, view=None):
    """Draws the wall or the edge of the cell, or sets limits for a view of part of it; returns the view (left, right,
    bottom, top)."""
    periodic = is_periodic(run)
    if view is None:
        line = wall_line(run.scene["cell"], sides)
        axes.plot(line[:, 0], line[:, 1], color="#808080" if periodic else "black",
                  linewidth=0.8 if periodic else 1.4, linestyle=(0, (4, 3)) if periodic else "-", zorder=4,
                  clip_on=False)
        view = whole(sides)
    left, right, bottom, top = view
    margin = 0.015 * max(right - left, top - bottom)
    axes.set_xlim(left - margin, right + margin)
    axes.set_ylim(bottom - margin - 0.05 * max(right - left, top - bottom), top + margin)
    axes.set_aspect("equal", anchor="NW")
    axes.set_axis_off()
    return view


def whole(sides):
    """The view of the whole cell: left, right, bottom, top [mm]."""
    return numpy.array([-0.5 * sides[0], 0.5 * sides[0], -0.5 * sides[1], 0.5 * sides[1]])


def draw_scale(axes, view):
    """Draws a scale bar below a view, about a fifth of it."""
    left, right, bottom, top = view
    side = max(right - left, top - bottom)
    decade = 10.0 ** numpy.floor(numpy.log10(side / 5.0))
    length = max(step for step in (decade, 2 * decade, 5 * decade) if step <= side / 5.0 * 1.0001)
    x, y = left, bottom - 0.035 * side
    axes.add_line(Line2D([x, x + length], [y, y], color="black", linewidth=2.2, solid_capstyle="butt"))
    axes.text(x + length + 0.012 * side, y, f"{length:g} mm", va="center", ha="left")


def draw_wheel(figure, box, labels=True):
    """Draws the colour wheel of directions; a small one without the words in it."""
    axes = figure.add_axes(box, projection="polar")
    angles = numpy.linspace(0.0, 2.0 * numpy.pi, 181)
    hues = ListedColormap(direction_colours(0.5 * (angles[1:] + angles[:-1])))
    axes.grid(False)
    axes.pcolormesh(angles, [0.55, 1.0], numpy.arange(180)[None, :], cmap=hues, edgecolors="face", linewidth=0.3)
    axes.set_ylim(0.0, 1.0)
    axes.set_yticks([])
    axes.spines["polar"].set_visible(False)
    if not labels:
        axes.set_xticks([])
        return
    axes.set_xticks(numpy.radians([0, 90, 180, 270]), ["0°", "90°", "180°", "270°"])
    axes.tick_params(pad=-1)
    for label, side in zip(axes.get_xticklabels(), ("left", "center", "right", "center")):
        label.set_horizontalalignment(side)
    axes.text(0.0, 0.0, "direction\nof rods", ha="center", va="center", fontsize=7.5)


def draw_series(axes, run, name, now):
    """Draws an observable over time: warm-up shaded, mean as a line, time of the frame as a thin line."""
    series = loaded(run.observables[name], run.path)
    times = series["time"].values
    axes.plot(times, series.values, color=BLUE, linewidth=0.9)
    axes.axvline(now, color="#b0b0b0", linewidth=0.7, zorder=0)
    if run.summary is not None and name in run.summary:
        draw_mean(axes, run, series)
        axes.legend(loc="upper right")
    most = float(numpy.nanmax(numpy.abs(series.values))) if series.size else 1.0
    axes.set_ylim(0.0 if (series.values >= 0.0).all() else -1.1 * most, 1.45 * (most if most > ROUNDING else 1.0))
    axes.set_xlim(times[0], times[-1] if len(times) > 1 else times[0] + 1.0)
    axes.xaxis.set_major_locator(MaxNLocator(5, steps=STEPS))
    axes.yaxis.set_major_locator(MaxNLocator(4, steps=STEPS))
    label = WORDS.get(name, (name, name))[1] if "cell" in run.scene else words_of(name)  # n is of rods
    axes.set_ylabel(with_unit(label, series))
    axes.set_xlabel(with_unit("time $t$", run.observables["time"]))
