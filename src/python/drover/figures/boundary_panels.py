"""drover/figures/boundary_panels.py: regimes, stability lines and their errors in the plane of two parameters."""
from dataclasses import dataclass

import numpy
from matplotlib.colors import ListedColormap
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from matplotlib.patheffects import withStroke

from drover.figures.panels import BLUE, GREEN, GREY, PURPLE, VERMILLION

# Names and pale colours of the codes of the map, from -1.
REGIMES = ("not defined", "isotropic", "isotropic, phase separation", "flock", "flock, banding",
           "flock, oblique instability")
PALE = ("#ffffff", "#e4e4e4", "#ecd2e1", "#cfe3f2", "#f8d5bf", "#c4e8da")
# The same of the codes of a map of a model of its own.
STABLE = ("no uniform state", "none stable", "isotropic state stable", "ordered state stable", "both states stable")
PALE_STABLE = ("#ffffff", "#f8d5bf", "#e4e4e4", "#cfe3f2", "#ecd2e1")
# Names, colours and widths of lines by instability; wide lines are drawn below, so coinciding lines remain visible.
LIMITS = (("onset of a flock", "#000000", 1.8), ("phase separation", PURPLE, 1.8),
          ("banding: waves along p0", VERMILLION, 1.4),
          ("oblique: waves at an angle to p0", GREEN, 3.0),
          ("binodal: phases that coexist", BLUE, 1.4),
          ("isotropic state becomes unstable", "#000000", 1.8),  # of a model of its own, from here on
          ("ordered state becomes unstable", VERMILLION, 1.4))
OBLIQUE, BINODAL, OF_MODEL, ORDERED = 3, 4, 5, 6
CONVENTIONS = ("mean", "single-rod")
ANGLES_AT = (0.08, 0.36, 0.64, 0.92)  # fractions of the length of an oblique line where its angle is written
ANGLES_APART = 0.07                   # relative to the side of the plane


@dataclass(frozen=True)
class Line:
    """One line of the plane; a closed line ends at its first vertex."""

    limit: int
    convention: int
    closed: bool
    places: numpy.ndarray  # (vertices, 2)
    angles: numpy.ndarray  # of the first unstable wave [degrees from p0]


@dataclass(frozen=True)
class Band:
    """The margin of one kind of line over its error, on a grid: the error band is where it is between -1 and 1."""

    limit: int
    convention: int
    x: numpy.ndarray
    y: numpy.ndarray
    deviation: numpy.ndarray  # (y, x)


def lines_of(vertices):
    """Lines from a table of vertices."""
    columns = {name: vertices[name].values for name in vertices.data_vars}
    limits = columns["limit"] if "limit" in columns else OF_MODEL + columns["state"]
    conventions = columns.get("convention", numpy.zeros(len(limits)))
    lines = []
    for number in numpy.unique(columns["line"]):
        chosen = numpy.flatnonzero(columns["line"] == number)
        closed = bool(columns["closed"][chosen[0]])
        if closed and any(columns[name][chosen[0]] != columns[name][chosen[-1]] for name in "xy"):
            chosen = numpy.append(chosen, chosen[0])
        places = numpy.column_stack([columns[axis][chosen] for axis in "xy"])
        lines.append(Line(int(limits[chosen[0]]), int(conventions[chosen[0]]), closed, places,
                          columns["angle"][chosen]))
    return lines


def bands_of(fields):
    """Error bands from the group of fields of draws."""
    columns = {name: fields[name].values for name in fields.data_vars}
    limits = columns["limit"] if "limit" in columns else OF_MODEL + columns["state"]
    conventions = columns.get("convention", numpy.zeros(len(limits)))
    return [Band(int(limit), int(convention), fields["band_x"].values, fields["band_y"].values, deviation)
            for limit, convention, deviation in zip(limits, conventions, columns["deviation"])]


def draw_regimes(axes, regimes, extent):
    """Draws the map in pale colours; returns the legend entries of the codes in it."""
    names, pale = (STABLE, PALE_STABLE) if regimes.name == "stable_states" else (REGIMES, PALE)
    axes.imshow(regimes.values, origin="lower", extent=extent, aspect="auto", interpolation="nearest", zorder=0,
                cmap=ListedColormap(pale), vmin=-1.5, vmax=len(pale) - 1.5)
    codes = sorted({int(code) for code in numpy.unique(regimes.values) if -1 <= code < len(pale) - 1})
    if -1 in codes:
        axes.contourf(regimes["map_x"], regimes["map_y"], regimes.values == -1.0, levels=[0.5, 1.5], colors="none",
                      hatches=["////"], zorder=0)
    return [Patch(facecolor=pale[code + 1], edgecolor=GREY, linewidth=0.6, label=names[code + 1],
                  hatch="////" if code == -1 else None) for code in codes]


def draw_line(axes, line, dashed):
    _, colour, width = LIMITS[line.limit]
    axes.plot(*line.places.T, color=colour, linewidth=width, linestyle=(0, (4, 1.6)) if dashed else "-",
              zorder=5.0 - 0.5 * width, solid_capstyle="butt", dash_capstyle="butt")


def draw_band(axes, band):
    """Fills where 16 to 84 % of the draws are unstable; returns whether that is anywhere in the plane."""
    inside = numpy.abs(band.deviation) <= 1.0
    crosses = [numpy.signbit(band.deviation), numpy.isfinite(band.deviation)]
    if not inside.any() and len(numpy.unique(crosses[0][crosses[1]])) < 2:
        return False
    colour = LIMITS[band.limit][1]
    deviation = numpy.ma.masked_invalid(band.deviation)
    axes.contourf(band.x, band.y, deviation, levels=[-1.0, 1.0], colors=[colour], alpha=0.2, zorder=1.5)
    axes.contour(band.x, band.y, deviation, levels=[-1.0, 1.0], colors=[colour], alpha=0.6, linewidths=0.5,
                 linestyles="-", zorder=1.6)
    return True


def apart(angle):
    """The angle between two lines: a wave at 120 degrees is the one at 60 degrees on the other side."""
    return min(angle % 180.0, 180.0 - angle % 180.0)


def write_angles(axes, lines, origin, sides):
    """Writes the angle of the first unstable wave at a few points of each oblique line; returns whether any was."""
    written = []
    for line in (line for line in lines if line.limit in (OBLIQUE, ORDERED) and len(line.places) > 1):
        places = (line.places - origin) / sides
        lengths = numpy.append(0.0, numpy.cumsum(numpy.hypot(*numpy.diff(places, axis=0).T)))
        for part in ANGLES_AT:
            n = int(numpy.searchsorted(lengths, part * lengths[-1]))
            n = min(n, len(places) - 1)
            near = [other for other in written if numpy.hypot(*(places[n] - other)) < ANGLES_APART]
            if near or not 0.5 <= line.angles[n] or not ((places[n] > 0.04) & (places[n] < 0.96)).all():
                continue
            along = places[min(n + 1, len(places) - 1)] - places[max(n - 1, 0)]
            aside = numpy.array([abs(along[1]), -numpy.copysign(1.0, along[1]) * along[0]])  # to the right
            offset = 9.0 * aside / (numpy.hypot(*aside) or 1.0)
            axes.annotate(f"{apart(line.angles[n]):.0f}°", line.places[n], offset, textcoords="offset points",
                          ha="left", va="center", fontsize=8, color="#00664a", zorder=6,
                          path_effects=[withStroke(linewidth=2, foreground="white")])
            written.append(places[n])
    return bool(written)


def line_keys(lines, conventions, has_bands):
    """Legend entries of lines, of dashes if there are two conventions, and of error bands."""
    keys = [Line2D([], [], color=colour, linewidth=width, label=words)
            for limit, (words, colour, width) in enumerate(LIMITS) if any(line.limit == limit for line in lines)]
    if len(conventions) > 1:
        keys += [Line2D([], [], color=GREY, linewidth=1.6, linestyle=style, label=f"{CONVENTIONS[convention]} "
                        f"convention")
                 for convention, style in zip(conventions, ("-", (0, (4, 1.6))))]
    if has_bands:
        keys.append(Patch(facecolor=GREY, alpha=0.35, linewidth=0, label="error: 16 to 84 % of the draws"))
    return keys
