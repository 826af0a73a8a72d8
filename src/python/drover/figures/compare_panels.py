"""drover/figures/compare_panels.py: figure of fields and particles: order and bead velocity over time, structure
factors."""
import matplotlib
import numpy
from matplotlib.ticker import MaxNLocator

from . import panels
from drover.figures.panels import BLUE, GREY, ROUNDING, STEPS, VERMILLION, key_of, with_error
from drover.figures.paper import STYLE, add_axes, new_figure, write_title_and_caption

BOXES = ((0.9, 4.5, 4.75, 2.4), (6.5, 4.5, 4.75, 2.4), (0.9, 1.3, 4.75, 2.4), (6.5, 1.3, 4.75, 2.4))  # inches
LOOKS = (("fields", BLUE, "o"), ("particles", VERMILLION, "s"))
SERIES = (("order", "order", "(a) polar order", r"polar order $P$"),
          ("size", "bead_velocity", "(b) mean bead velocity", r"$|\langle\mathbf{v}\rangle|$ [mm s$^{-1}$]"))
FACTORS = (("rods", "(c) density of the rods", r"structure factor $S$"),
           ("order", "(d) orientation of the rods", r"structure factor $S_{pp}$"))


@matplotlib.rc_context(STYLE)
def draw(comparison, title):
    """Draws a comparison as a matplotlib Figure."""
    picture = new_figure()
    axes = [add_axes(picture, box) for box in BOXES]
    for panel, (key, expected, words, label) in zip(axes[:2], SERIES):
        draw_series(panel, comparison, key, comparison.expected[expected])
        panel.set_title(words, loc="left")
        panel.set_ylabel(label)
    for panel, (key, words, label) in zip(axes[2:], FACTORS):
        draw_factors(panel, comparison.factors[key])
        panel.set_title(words, loc="left")
        panel.set_ylabel(label)
    write_title_and_caption(picture, title, caption(comparison))
    return picture


def draw_series(axes, comparison, key, expected):
    """Draws one quantity of both runs over time, and the mean field as a band."""
    value, error = expected
    keys = [key_of(f"mean field {with_error(value, error)}", line="-")]
    axes.axhline(value, color=GREY, linewidth=1.4, zorder=2)
    if error > 0.0:
        axes.axhspan(max(0.0, value - error), value + error, color=GREY, alpha=0.2, linewidth=0, zorder=0)
    most, last = value + numpy.nan_to_num(error), 0.0
    for name, colour, _ in LOOKS:
        side = getattr(comparison, name)
        axes.plot(side.times, side.series[key], color=colour, linewidth=0.9, zorder=3)
        keys.append(key_of(f"{name}, mean {with_error(*side.numbers[key])}", colour, line="-"))
        most, last = max(most, float(numpy.nanmax(side.series[key]))), max(last, float(side.times[-1]))
    axes.set_xlim(0.0, last or 1.0)
    axes.set_ylim(0.0, 1.55 * (most if most > ROUNDING else 1.0))  # space for the legend
    axes.xaxis.set_major_locator(MaxNLocator(7, steps=STEPS))
    axes.yaxis.set_major_locator(MaxNLocator(5, steps=STEPS))
    axes.set_xlabel("time $t$ [s]")
    axes.legend(handles=keys, loc="upper right")


def draw_factors(axes, results):
    """Draws one structure factor of both runs over shells of |q|."""
    drawn = []
    for result, (name, colour, marker) in zip(results, LOOKS):
        if panels.is_drawable(result):
            panels.draw_result(axes, result, colour, marker)
            drawn.append((result, key_of(name, colour, marker)))
    if not drawn:
        panels.write_instead(axes, "every structure factor is zero" if len(results[0].x) else
                           "no shell of |q| is below half of the\nkept wavenumbers: use a finer grid")
        return
    panels.log_axes(axes)
    axes.axhline(1.0, color=GREY, linestyle=":", linewidth=1.0, zorder=1)
    axes.set_xlabel("wavenumber $q$ [mm$^{-1}$]")
    keys = [*(key for _, key in drawn), key_of("independent rods", line=":")]
    if not all(numpy.isfinite(result.error).all() for result, _ in drawn):
        keys.append(key_of("no error estimate", marker="o", fill="white"))
    panels.make_room_below(axes, 2)
    axes.legend(handles=keys, loc="lower left", ncol=2)


def caption(comparison):
    """Explains the figure to a reader."""
    results = [result for pair in comparison.factors.values() for result in pair]
    words = ["(a, b) Grey bands: mean field of the table ± one standard error. (c, d) Shells of |q| up to half of the "
             "wavenumbers "
             "kept by the grid, second half of the frames: S = ⟨|Σ\u00a0exp(−iqr)|²⟩/N, Spp = "
             "⟨|Σ\u00a0n\u00a0exp(−iqr)|²⟩/N over rods; for fields, "
             "integrals over σ and the polarisation. Fields have no shot noise of positions, and none was added."]
    if not all(numpy.isfinite(result.error).all() for result in results):
        words.append("Open symbols: the run is too short for an error estimate.")
    return " ".join(words)
