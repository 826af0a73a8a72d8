"""drover/figures/pair_figure.py: two runs of any kind side by side: their maps, and order or variance over time."""
import matplotlib

from . import model_panels, panels, particle_figure
from drover.archive import loaded
from drover.error import Error
from drover.run_view import run_of
from drover.figures.paper import STYLE, add_axes, bar_box, fitted, new_figure, require_frame, write_title_and_caption
from drover.particles import BEAD_ORDER, ORDER, ParticleRun
from drover.roles import has_own_fields, roles_of
from drover.text import drawable

MAPS = ((0.8, 3.25, 3.65, 3.65), (6.5, 3.25, 3.65, 3.65))  # inches
SERIES = (0.8, 1.2, 10.6, 1.2)
MUCH_LONGER = 5.0  # ratio of durations from which times are drawn over them
COLOURS = (panels.BLUE, panels.VERMILLION)


@matplotlib.rc_context(STYLE)
def draw(first, second, labels=None, frame=-1):
    """Draws two runs as a matplotlib Figure."""
    runs = [run_of(first), run_of(second)]
    for run in runs:
        require_frame(run, frame)
    orders = [order_of(run) for run in runs]
    labels = labels or names_of(runs)
    figure = new_figure()
    for letter, run, label, box in zip("ab", runs, labels, MAPS):
        if is_plane(run):
            box = fitted(box, run.scene["grid"]["lx"] / run.scene["grid"]["ly"])
        axes = add_axes(figure, box)
        draw_map(axes, add_axes(figure, bar_box(box)) if is_plane(run) else None, run, frame)
        axes.set_title(f"({letter}) {label}", loc="left")
    axes = add_axes(figure, SERIES)
    ends = [float(run.observables["time"][-1]) for run in runs]
    scaled = max(ends) > MUCH_LONGER * min(ends) > 0.0
    most = draw_orders(axes, runs, orders, labels, ends if scaled else (1.0, 1.0))
    axes.margins(x=0.0)
    words = "order or variance" if orders[0][0] != orders[1][0] else orders[0][0]
    has_range = most > (0.0 if "variance" in words else model_panels.NO_ORDER)
    axes.set_ylim(0.0, 1.5 * most if has_range else 1.0)  # space for the legend
    axes.set_title(f"(c) {words}", loc="left")
    axes.set_xlabel("time over duration $t/T$" if scaled else panels.with_unit("time $t$", runs[0].observables["time"]))
    axes.set_ylabel(words)
    axes.legend(loc="upper right", ncols=2)
    write_title_and_caption(figure, f"{labels[0]} and {labels[1]}", "(c) Dashed: means after the warm-up, with "
                            "standard errors where the runs are long enough.")
    return figure


def draw_map(axes, bar, run, frame):
    if isinstance(run, ParticleRun):
        particle_figure.draw_map(axes, run, frame)
    elif is_plane(run) or not has_own_fields(run):
        model_panels.draw_map_with_arrows(axes, bar, run, frame)
    else:
        model_panels.draw_map(axes, bar, run, roles_of(run)[0], frame)


def is_plane(run):
    return not isinstance(run, ParticleRun) and run.frames.sizes["y"] > 1


def order_of(run):
    """Words for the order of a run, and its series; of a run without order the variance of its first field.

    Beads alone have the order of their velocities.
    """
    if isinstance(run, ParticleRun):
        name = next((name for name in (ORDER, BEAD_ORDER) if name in run.observables), None)
        if name is None:
            raise Error(f"{run.path} has no order over time; expected a run with output.sample_every > 0")
        return name.replace("_", " "), loaded(run.observables[name], run.path)
    label, _, series = next(iter(model_panels.orders_of(run)), (None,) * 3)
    if series is not None:
        return label, series
    variances = [name for name in run.observables.data_vars if str(name).startswith("variance_")]
    if not variances:
        raise Error(f"{run.path} has no order or variance over time; expected a run with output.sample_every > 0")
    return variances[0].replace("_", " of ", 1).replace("_", " "), loaded(run.observables[variances[0]], run.path)


def draw_orders(axes, runs, orders, labels, units):
    """Draws orders and their means over time in these units [s]; returns the largest."""
    most = 0.0
    for run, (_, order), label, colour, unit in zip(runs, orders, labels, COLOURS, units):
        most = max(most, float(order.max()))
        words = label
        if run.summary is not None and order.name in run.summary:
            mean, error = (float(loaded(run.summary[name], run.path)) for name in (order.name, f"{order.name}_error"))
            words += ": " + panels.with_error(mean, error)
            axes.plot(order["time"][[0, -1]] / unit, [mean, mean], color=colour, linestyle="--", linewidth=0.9)
        axes.plot(order["time"] / unit, order, color=colour, linewidth=0.9, label=words)
    return most


def names_of(runs):
    """The names of the archives, or of the kinds of two runs of one scene."""
    names = [drawable(run.path.stem) for run in runs]
    if names[0] == names[1]:
        kinds = ["particles" if isinstance(run, ParticleRun) else "fields" for run in runs]
        names = kinds if kinds[0] != kinds[1] else [f"{name} {i}" for i, name in enumerate(names, 1)]
    return names
