"""drover/pair_figure.py: two runs of any kind side by side: their maps, and their order over time."""
import matplotlib

from drover import panels
from drover.archive import loaded
from drover.moments import run_of
from drover.paper import STYLE, add_axes, new_figure, write_title_and_caption
from drover.particles import ParticleRun

MAPS = ((0.8, 3.1, 3.75, 3.75), (6.5, 3.1, 3.75, 3.75))  # inches
SERIES = (0.8, 1.2, 10.6, 1.2)
COLOURS = (panels.BLUE, panels.VERMILLION)


@matplotlib.rc_context(STYLE)
def draw(first, second, labels=None, frame=-1):
    """Draws two runs as a matplotlib Figure."""
    from drover import plot
    runs = [run_of(first), run_of(second)]
    labels = labels or names_of(runs)
    figure = new_figure()
    for letter, run, label, box in zip("ab", runs, labels, MAPS):
        axes = add_axes(figure, box)
        plot.map(run, axes, frame)
        axes.set_title(f"({letter}) {label}", loc="left")
    axes = add_axes(figure, SERIES)
    most = draw_orders(axes, runs, labels)
    axes.margins(x=0.0)
    axes.set_ylim(0.0, 1.5 * most if most > panels.NO_ORDER else 1.0)  # space for the legend
    axes.set_title("(c) polar order", loc="left")
    axes.set_xlabel("time $t$ [s]")
    axes.set_ylabel("polar order")
    axes.legend(loc="upper right", ncols=2)
    write_title_and_caption(figure, f"{labels[0]} and {labels[1]}", "(c) Dashed: means after the warm-up, with "
                            "standard errors where the runs are long enough.")
    return figure


def draw_orders(axes, runs, labels):
    """Draws the polar orders and their means; returns the largest."""
    most = 0.0
    for run, label, colour in zip(runs, labels, COLOURS):
        order = loaded(run.observables["polar_order"], run.path)
        most = max(most, float(order.max()))
        words = label
        if run.summary is not None and "polar_order" in run.summary:
            mean, error = (float(loaded(run.summary[name], run.path)) for name in ("polar_order", "polar_order_error"))
            words += f": {mean:.3g}" + (rf" $\pm$ {error:.1g}" if error > 0.0 else "")
            axes.plot(order["time"][[0, -1]], [mean, mean], color=colour, linestyle="--", linewidth=0.9)
        axes.plot(order["time"], order, color=colour, linewidth=0.9, label=words)
    return most


def names_of(runs):
    """The names of the archives, or of the kinds of two runs of one scene."""
    names = [run.path.stem for run in runs]
    if names[0] == names[1]:
        kinds = ["particles" if isinstance(run, ParticleRun) else "fields" for run in runs]
        names = kinds if kinds[0] != kinds[1] else [f"{name} {i}" for i, name in enumerate(names, 1)]
    return names
