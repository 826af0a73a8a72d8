"""drover/figures/smooth_panels.py: panels of runs without noise: profiles over time, growth, and the length of the
pattern."""
import matplotlib
import numpy
from matplotlib.ticker import MaxNLocator

from . import panels
from drover.archive import loaded
from drover.exact import exact_of
from drover.fields import has_noise
from drover.figures.model_panels import ENDS, draw_deviations, parts_of
from drover.figures.panels import BLUE, STEPS
from drover.roles import ZERO, roles_of
from drover.spectra import shells_of
from drover.typeset import named, spaced

PROFILES, WIDEST = 4, 3.0  # frames drawn, and the width of the first: all show where they coincide
LEGEND_COLUMN = 1.6  # inches
LEAST_SPREAD = 1e-6  # relative, of a density that is not uniform


def is_smooth(run):
    """Whether a run has no noise, and frames to compare."""
    return not has_noise(run.scene) and run.frames.sizes["time"] > 2


def varying_field(run):
    """The field that profiles show: the first that is not uniform, scalars first and flows last; its component that
    varies most."""
    roles, found = roles_of(run), None
    for role in sorted(roles, key=lambda role: (role.spin != 0, role.is_flow)):
        parts = [(loaded(run.frames[name], run.path), role.symbol + end)
                 for name, end in zip(role.components, parts_of(role))]
        field, symbol = max(parts, key=lambda part: float(part[0].std()))
        found = found or (field, symbol)
        if float(field.std()) > max(LEAST_SPREAD * abs(float(field.mean())), ZERO):
            return field, symbol
    return found


def draw_profiles(axes, run, exact=None):
    """Draws a field along x through the middle of the cell at several times, and what is known exactly, dotted.

    `exact` is a function of x and t; without it the solution of Barenblatt, or the start where it moves unchanged.
    Returns words for what is dotted, or "".
    """
    field, symbol = varying_field(run)
    row = field.isel(y=field.sizes["y"] // 2)
    known = (exact, "exact") if exact is not None else exact_of(run, field, row)
    chosen = numpy.unique(numpy.linspace(0, row.sizes["time"] - 1, PROFILES).round().astype(int))
    colours = matplotlib.colormaps["viridis"](numpy.linspace(0.0, 0.85, len(chosen)))
    widths = numpy.linspace(WIDEST, 1.2, len(chosen))
    x, unit = row["x"].values, spaced(named("s", run.scene))
    for frame, colour, width in zip(chosen, colours, widths):
        time = float(row["time"][frame])
        axes.plot(x, row.values[frame], color=colour, linewidth=width, label=f"{time:g}{unit}")
        if known is not None:
            axes.plot(x, known[0](x, time), color="black", linewidth=0.8, linestyle=":",
                      label=known[1] if frame == chosen[-1] else None)
    axes.set_xlim(x[0], x[-1] + (x[1] - x[0]))
    columns = max(2, int(axes.get_position().width * axes.figure.get_size_inches()[0] / LEGEND_COLUMN))
    panels.make_room_above(axes, -(-len(axes.get_legend_handles_labels()[0]) // columns))
    axes.legend(loc="upper right", ncols=columns, frameon=False, handlelength=1.4, columnspacing=1.0)
    axes.xaxis.set_major_locator(MaxNLocator(8 if columns > PROFILES else 6, steps=STEPS))  # as that of a wide map
    axes.yaxis.set_major_locator(MaxNLocator(5, steps=STEPS))
    axes.set_xlabel(panels.with_unit("$x$", field["x"]))
    axes.set_ylabel(panels.with_unit(f"${symbol}$", field))
    if known is None or not known[1].startswith("start"):
        return "" if known is None else "the exact solution"
    return "the start" + (", moved at this speed" if "rest" not in known[1] else "")


def draw_growth(axes, run):
    """Draws standard deviations of the fields over time, densities relative to their means."""
    # A field in balance has none in archives of earlier versions of the shipped model.
    roles = [role for role in roles_of(run) if f"variance_{role.name}" in run.observables]
    if draw_deviations(axes, run, sorted(roles, key=lambda role: not role.is_density)):
        rows, is_log = -(-len(axes.lines) // 2), axes.get_yscale() == "log"
        (panels.make_room_below if is_log else panels.make_room_above)(axes, rows)
        axes.legend(loc="lower right" if is_log else "upper right", ncols=2, frameon=False, handlelength=1.2,
                    columnspacing=1.0)
        of_time(axes, run)


def of_time(axes, run):
    axes.set_xlim(float(run.observables["time"][0]), float(run.observables["time"][-1]))
    axes.xaxis.set_major_locator(MaxNLocator(4, steps=STEPS))
    axes.set_xlabel(panels.with_unit("time $t$", run.observables["time"]))


def spectra_of(run):
    """Structure factors of the first field that is not uniform; densities last, and flows, which follow a pattern."""
    for role in sorted(roles_of(run), key=lambda role: (role.is_flow, role.is_density)):
        names = [f"structure_factor_{role.short or role.name}{end}" for end in (ENDS if role.spin else ("",))]
        names = [name for name in names if name in run.observables]
        powers = [loaded(run.observables[name], run.path) for name in names]
        if powers and max(float(power.max()) for power in powers) > 0.0:
            return powers
    return []


def modes_of_shells(grid, count):
    """Numbers of the modes in the first shells of |q|, of each pair q and -q one; on a line each shell has one."""
    if grid["ny"] == 1:
        return numpy.ones(count)
    sides = numpy.array([grid["lx"], grid["ly"]])
    return numpy.bincount(shells_of(sides, count * 2.0 * numpy.pi / max(sides)).shell, minlength=count)


def draw_length(axes, run):
    """Draws the length of the pattern over time, 2 pi over the mean wavenumber of the spectrum of a field."""
    powers = spectra_of(run)
    if not powers:
        panels.write_instead(axes, "uniform fields")
        return
    q, total = powers[0]["wavenumber"].values, sum(power.values for power in powers)
    weight = modes_of_shells(run.scene["grid"], len(q))
    with numpy.errstate(divide="ignore", invalid="ignore"):
        length = 2.0 * numpy.pi * (total @ weight) / (total @ (weight * q))
    axes.plot(powers[0]["time"], length, color=BLUE, linewidth=1.2)
    axes.set_ylim(0.0, 1.15 * numpy.nanmax(length))
    of_time(axes, run)
    axes.yaxis.set_major_locator(MaxNLocator(4, steps=STEPS))
    axes.set_ylabel(panels.with_unit(r"$2\pi/\langle q\rangle$", run.frames["x"]))
