"""drover/figures/onset_figure.py: figure of the flocking threshold predicted by a table, with errors."""
import matplotlib
import numpy
from matplotlib.patches import Patch
from matplotlib.patheffects import withStroke
from matplotlib.ticker import MaxNLocator

from . import boundary_panels
from drover.archive import loaded
from drover.error import DroverError
from drover.figures.panels import BLUE, GREY, STEPS, key_of, with_unit
from drover.figures.paper import SIZE, STYLE, add_axes, new_figure, write_title_and_caption
from drover.text import scene_name

CURVES, PLANE = (0.9, 2.6, 4.75, 4.3), (6.5, 2.6, 4.75, 4.3)  # inches
KEYS_TOP = 1.95                                               # of the legends below the panels [inches]
MAX_KEYS, KEYS_PER_COLUMN = 10, 5                             # area fractions of rods in the legend
FLOCK = boundary_panels.PALE[3]
DASHED = (0, (4, 1.6))
ROOM = 2.5        # upper limit of the speed axis, in units of the largest alpha/Gamma
FAR = 100.0       # curves are clipped at this multiple of that limit: a/lambda has poles
NAMED_FROM = 0.1  # smallest width of a labelled region, relative to the plane
FAR_FROM_ZERO = 4.0  # errors: beyond, a field over its error says no more
BESIDE = 0.03     # of the axis of beads, beside the table
GROUPS = "curves", "field", "crossings"
# Names in the archive, labels, line and marker styles, and factors of a/lambda.
CONVENTIONS = (("mean", r"$\lambda = \lambda_s/2$", "-", "black", 1.0),
               ("single_rod", r"$\lambda = \lambda_s$", DASHED, "white", 0.5))
# Phi_b + 2 Phi_r at the onset of flocking of brass rods among beads: Kumar et al., Nat. Commun. 5, 4688 (2014).
EXPERIMENT = 0.65


@matplotlib.rc_context(STYLE)
def draw(theory):
    """Draws an archive of drover boundary TABLE as a matplotlib Figure."""
    missing = [name for name in GROUPS if name not in theory.groups]
    if missing:
        raise DroverError(f"{theory.path} has no group {missing[0]}, which drover boundary TABLE writes: the file is "
                          f"damaged, or "
                          "from another version of drover")
    curves, field, crossings = (theory.groups[name].map(lambda array: loaded(array, theory.path)) for name in GROUPS)
    figure = new_figure()
    left, right = add_axes(figure, CURVES), add_axes(figure, PLANE)
    draw_curves(left, curves, crossings)
    draw_plane(right, curves, field, crossings)
    for axes, words, keys in ((left, "(a) speed of dragged beads and flocking threshold", curve_keys(curves)),
                              (right, "(b) flocking threshold", plane_keys(right))):
        axes.set_title(words, loc="left")
        axes.xaxis.set_major_locator(MaxNLocator(7, steps=STEPS))
        axes.yaxis.set_major_locator(MaxNLocator(7, steps=STEPS))
        axes.set_xlabel(r"area fraction of beads $\Phi_b$")
        figure.legend(handles=keys, loc="upper left", ncol=-(-len(keys) // KEYS_PER_COLUMN), frameon=False,
                      borderpad=0.0, borderaxespad=0.0,
                      bbox_to_anchor=(axes.get_position().x0, KEYS_TOP / SIZE[1]))
    name = scene_name(theory).removesuffix(" (its scene)")
    write_title_and_caption(figure, f"{name}: predicted flocking threshold", caption(curves, crossings))
    return figure


def colours_of(curves):
    """One colour for each area fraction of rods, dark to light."""
    return matplotlib.colormaps["viridis"](numpy.linspace(0.0, 0.82, curves.sizes["rod_fraction"]))


def draw_curves(axes, curves, crossings):
    """Draws alpha/Gamma at each area fraction of rods, a/lambda in both conventions, and their crossings."""
    beads, drag = curves["bead_fraction"].values, curves["drag"].values
    beside = BESIDE * (beads[-1] - beads[0])  # room for marks at the ends of the table
    axes.set_xlim(beads[0] - beside, beads[-1] + beside)
    low, high = speeds_shown(drag, curves["drag_error"].values)
    needed, errors = curves["threshold"].values, curves["threshold_error"].values
    needed = numpy.where((needed > 0.0) & numpy.isfinite(needed), needed, numpy.nan)
    for _, _, style, _, factor in CONVENTIONS:
        if not has_contacts(curves):  # the same at all area fractions of rods
            axes.plot(beads, clipped(factor * needed[0], high), color="black", linestyle=style, linewidth=1.4, zorder=3)
            draw_band(axes.fill_between, beads, factor * needed[0], factor * errors[0], "black", high)
    if has_contacts(curves):
        for colour, values in zip(colours_of(curves), needed):
            axes.plot(beads, clipped(values, high), color=colour, linestyle=":", linewidth=1.6, zorder=3)
    for colour, values, errors in zip(colours_of(curves), drag, curves["drag_error"].values):
        axes.plot(beads, clipped(values, high), color=colour, linewidth=1.4, zorder=4)
        draw_band(axes.fill_between, beads, values, errors, colour, high)
    for colour, rods, values in zip(colours_of(curves), curves["rod_fraction"].values, drag):
        draw_crossings(axes, crossings, rods, colour, lambda place, values=values: numpy.interp(place, beads, values))
    axes.set_ylim(low, high)
    axes.set_ylabel(with_unit("speed", curves["drag"]))


def has_contacts(curves):
    """Whether rods that touch align, so that the threshold depends on their number."""
    threshold = curves["threshold"].values
    return bool((threshold != threshold[0]).any())


def speeds_shown(drag, error):
    """Ends of the axis of speeds: what alpha/Gamma needs, whatever a/lambda does."""
    most = float(numpy.nanmax(drag, initial=0.0))
    least = float(numpy.nanmin(drag - numpy.nan_to_num(error), initial=0.0))
    return 1.1 * least, ROOM * most if most > 0.0 else 0.5 * abs(least) or 1.0


def clipped(values, high):
    """Clips values far outside the axis, which would overflow in drawing."""
    return numpy.clip(values, -FAR * high, FAR * high)


def draw_band(fill, along, values, errors, colour, high):
    fill(along, clipped(values - errors, high), clipped(values + errors, high), color=colour, alpha=0.18, linewidth=0,
         zorder=1)


def draw_crossings(axes, crossings, rods, colour, height_of):
    """Marks the crossings at one area fraction of rods."""
    near = numpy.isclose(crossings["crossing_rod_fraction"].values, rods, rtol=1e-9, atol=0.0)
    for number, (_, _, _, fill, _) in enumerate(CONVENTIONS):
        for at in numpy.flatnonzero(near & (crossings["convention"].values == number)):
            place, first = float(crossings["bead_area_fraction"][at]), is_first(crossings, at)
            axes.errorbar(place, height_of(place), xerr=bars(crossings, [at], axes.get_xlim()) if first else None,
                          color=colour,
                          marker="o", markersize=5, markerfacecolor=colour if fill == "black" else fill, capsize=2.5,
                          zorder=5)


def is_first(crossings, at):
    """Whether a crossing is the first one in its band: those that share it have one error bar."""
    if at == 0 or any(crossings[name].values[at] != crossings[name].values[at - 1]
                      for name in ("crossing_rod_fraction", "convention")):
        return True
    low = crossings["low"].values[at]
    return bool(numpy.isfinite(low) and low > crossings["bead_area_fraction"].values[at - 1])


def bars(crossings, at, ends):
    """Lengths of the error bars of crossings to the left and right; beyond the table they end with it."""
    places = crossings["bead_area_fraction"].values[at]
    low, high = (numpy.where(numpy.isfinite(crossings[name].values[at]), crossings[name].values[at], end)
                 for name, end in zip(("low", "high"), ends))
    return numpy.maximum([places - low, high - places], 0.0)


def draw_plane(axes, curves, field, crossings):
    """Draws the thresholds of both conventions, the error band of the first, the flocks, and the experimental line."""
    beads, rods = field["bead_fraction"].values, field["rod_fraction"].values
    is_one = len(rods) == 1
    axes.set_xlim(beads[0], beads[-1])
    axes.set_ylim(rods[0] - 0.05 * is_one, rods[-1] + 0.05 * is_one)
    if is_one:
        for number, (_, _, _, fill, _) in enumerate(CONVENTIONS):
            at = numpy.flatnonzero(crossings["convention"].values == number)
            axes.errorbar(crossings["bead_area_fraction"].values[at], rods[0] + 0.0 * at,
                          xerr=bars(crossings, at, axes.get_xlim()), color="black", marker="o", linestyle="none",
                          markersize=4.5, markerfacecolor=fill, capsize=2.5, zorder=4)
    else:
        excess, single = finer(field, "mean_excess"), finer(field, "single_rod_excess")
        if excess[2].max() > 0.0:
            axes.contourf(*excess, levels=[0.0, 2.0 * excess[2].max()], colors=[FLOCK], zorder=0)
        draw_threshold(axes, field, "black", 0.18)
        if changes_sign(single[2]):
            axes.contour(*single, levels=[0.0], colors="black", linestyles=[DASHED], linewidths=1.6, zorder=3)
        if crossings.sizes["crossing"]:
            name_regions(axes, field["mean_excess"].values[-1], beads, rods[-1])
    axes.plot(EXPERIMENT - 2.0 * numpy.array(axes.get_ylim()), axes.get_ylim(), color=GREY, linewidth=0.7, zorder=2)
    axes.set_ylabel(r"area fraction of rods $\Phi_r$")
    if not crossings.sizes["crossing"]:
        axes.text(0.5, 0.5, without_crossing(curves), ha="center", va="center", transform=axes.transAxes,
                  bbox={"facecolor": "white", "edgecolor": "none", "alpha": 0.9})


def draw_threshold(axes, field, colour, alpha):
    """Draws where the excess changes its sign, and the band in which it is within its error."""
    excess, deviation = finer(field, "mean_excess"), finer(field, "mean_deviation")
    if changes_sign(deviation[2] - 1.0) or changes_sign(deviation[2] + 1.0):
        axes.contourf(*deviation, levels=[-1.0, 1.0], colors=[colour], alpha=alpha, zorder=1)
    if changes_sign(excess[2]):
        axes.contour(*excess, levels=[0.0], colors=[colour], linewidths=1.8, zorder=3)


def finer(field, name):
    """Area fractions of beads and of rods, and a field on a mesh so fine that its level lines have no corners."""
    beads, rods, values = field["bead_fraction"].values, field["rod_fraction"].values, field[name].values
    if len(rods) < 2 or not numpy.isfinite(values).all():
        return beads, rods, numpy.ma.masked_invalid(values)
    from scipy.interpolate import RectBivariateSpline
    dense = [numpy.interp(numpy.linspace(0, len(axis) - 1, 4 * len(axis) - 3), numpy.arange(len(axis)), axis)
             for axis in (rods, beads)]
    limited = numpy.clip(values, -FAR_FROM_ZERO, FAR_FROM_ZERO) if name.endswith("deviation") else values
    spline = RectBivariateSpline(rods, beads, limited, kx=min(3, len(rods) - 1), ky=min(3, len(beads) - 1))
    return dense[1], dense[0], spline(*dense)


def changes_sign(values):
    return bool(numpy.ma.min(values) < 0.0 < numpy.ma.max(values))


def draw_onset(axes, field, runs=None):
    """Draws the predicted onset with its error, the line of the experiment, and runs of particles by their order.

    runs: columns "bead_area_fraction", "rod_area_fraction" and "polar_order".  Returns the legend entries, and the
    points for a colour bar (None without runs).
    """
    beads, rods = field["bead_fraction"].values, field["rod_fraction"].values
    if runs is not None:
        rods_shown = min(rods[0], runs["rod_area_fraction"].min()), max(rods[-1], runs["rod_area_fraction"].max())
    else:
        rods_shown = rods[0], rods[-1]
    margin = 0.06 * (rods_shown[1] - rods_shown[0] or 1.0)
    axes.set_xlim(beads[0] - 0.04, beads[-1] + 0.04)
    axes.set_ylim(rods_shown[0] - margin, rods_shown[1] + margin)
    draw_threshold(axes, field, BLUE, 0.2)
    ends = numpy.array(axes.get_ylim())
    axes.plot(EXPERIMENT - 2.0 * ends, ends, color="black", linewidth=1.2, linestyle=DASHED, zorder=2)
    points = None
    if runs is not None:
        points = axes.scatter(runs["bead_area_fraction"], runs["rod_area_fraction"], c=runs["polar_order"], s=44,
                              cmap="viridis", vmin=0.0, vmax=1.0, edgecolor="black", linewidth=0.7, zorder=5)
    axes.set_xlabel(r"area fraction of beads $\Phi_b$")
    axes.set_ylabel(r"area fraction of rods $\Phi_r$")
    keys = [key_of("onset of flocking, predicted from measured coefficients", BLUE, line="-"),
            Patch(facecolor=BLUE, alpha=0.2, linewidth=0, label="its band, 16 to 84 % of the draws"),
            key_of("onset in the experiment (Kumar et al., 2014)", "black", line=DASHED)]
    if runs is not None:
        keys.append(key_of("runs of particles, by their polar order", "black", "o", fill="#3b8c8a"))
    return keys, points


def name_regions(axes, excess, beads, rods):
    """Labels the regions with and without flocks where they are wide enough at the upper edge."""
    for words, side, of_edge in (("flocks", "right", excess[::-1]), ("no flocks", "left", excess)):
        is_other = of_edge < 0.0 if side == "right" else of_edge > 0.0
        width = numpy.argmax(is_other) / len(beads) if is_other.any() else 1.0
        if width > NAMED_FROM:
            axes.annotate(words, (beads[-1] if side == "right" else beads[0], rods),
                          (-6 if side == "right" else 6, -6), textcoords="offset points", fontsize=10, ha=side,
                          va="top", style="italic", zorder=6,
                          path_effects=[withStroke(linewidth=2.5, foreground="white" if side == "left" else FLOCK)])


def without_crossing(curves):
    """Message for a plane without a line."""
    first = curves["threshold"].values[:, 0]
    above = (first > 0.0) & (curves["drag"].values[:, 0] >= first)
    if above.all():
        return "no crossing in this table:\nflocks at all " + r"$\Phi_b$"
    return "no crossing in this table" + ("" if above.any() else ":\nno flocks are predicted")


def curve_keys(curves):
    colours, rods = colours_of(curves), curves["rod_fraction"].values
    shown = numpy.unique(numpy.linspace(0, len(rods) - 1, min(len(rods), MAX_KEYS)).astype(int))
    keys = [key_of(rf"$\alpha/\Gamma$ at $\Phi_r$ = {rods[i]:.3g}", colours[i], line="-") for i in shown]
    keys += ([key_of(r"$(a - c\sigma)/\lambda$, same colour", "black", line=":")] if has_contacts(curves) else
             [key_of(r"$a/\lambda$, $\lambda = \lambda_s/2$", "black", line="-"),
              key_of(r"$a/\lambda_s$", "black", line=DASHED)])
    keys += [key_of(f"crossing, {words}", marker="o", fill=None if fill == "black" else fill)
             for _, words, _, fill, _ in CONVENTIONS]
    return [*keys, Patch(facecolor=GREY, alpha=0.3, linewidth=0, label="± one standard error")]


def plane_keys(axes):
    keys = [key_of(words, "black", line=style) for _, words, style, _, _ in CONVENTIONS]
    ends = EXPERIMENT - 2.0 * numpy.array(axes.get_ylim())
    beyond = "" if ends.min() < axes.get_xlim()[1] and ends.max() > axes.get_xlim()[0] else " (beyond this plane)"
    keys.append(key_of(rf"experiment, $\Phi_b + 2\,\Phi_r$ = {EXPERIMENT:g}{beyond}", line="-"))
    keys[-1].set_linewidth(0.7)
    return [*keys, Patch(facecolor=FLOCK, label=r"flocks predicted ($\lambda = \lambda_s/2$)"),
            Patch(facecolor=GREY, alpha=0.3, linewidth=0, label="16 to 84 % of the draws")]


def caption(curves, crossings):
    """Explains the figure to a reader."""
    threshold = "(a − cσ)/λ" if has_contacts(curves) else "a/λ"
    words = [f"(a) α/Γ: bead speed at P = 1; {threshold}: threshold that it must exceed for a flock. λ = λs/2 is the "
             "convention of the equations; λs of one rod is twice as large."]
    if (curves["threshold"].values <= 0.0).any():
        words.append(f"{threshold} is omitted where it is not positive.")
    of_mean = crossings["convention"].values == 0
    if of_mean.any():
        words.append("Band of (b), error bars: 16 to 84 % of the draws of the table within its errors predict flocks.")
    if "alone" in crossings and (crossings["alone"].values[of_mean] == 0).any():
        words.append("Thresholds within one band are consistent, within errors, with no threshold.")
    words.append("Experiment: Kumar et al., Nat. Commun. 5, 4688 (2014).")
    return " ".join(words)
