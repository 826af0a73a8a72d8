"""drover/onset_figure.py: one picture of where the coefficients of a table say that flocks begin, with their errors."""
import matplotlib
import numpy
from matplotlib.patches import Patch
from matplotlib.patheffects import withStroke
from matplotlib.ticker import MaxNLocator

from drover import boundary_panels
from drover.archive import loaded
from drover.error import DroverError
from drover.panels import GREY, STEPS, key_of, with_unit
from drover.paper import SIZE, STYLE, add_axes, sheet, write_words

CURVES, PLANE = (0.9, 2.6, 4.75, 4.3), (6.5, 2.6, 4.75, 4.3)  # inches
KEYS_TOP = 1.95                                               # inches: of the legends, below the panels
KEYS_MOST, KEYS_A_COLUMN = 10, 5                              # of area fractions of rods in the legend
FLOCK = boundary_panels.PALE[3]
DASHED = (0, (4, 1.6))
ROOM = 2.5        # the axis of speeds ends at so many times the largest alpha/Gamma
FAR = 100.0       # lengths of that axis at which curves are cut: a/lambda has poles
NAMED_FROM = 0.1  # part of the plane that a region must be wide to be named in it
SURE = 0.95       # of redrawn tables: where fewer cross, the caption says so
# Names in the archive with their words, how lines and points look, and what they multiply a/lambda by.
CONVENTIONS = (("mean", r"$\lambda = \lambda_s/2$", "-", "black", 1.0),
               ("single_rod", r"$\lambda_s$ taken for $\lambda$", DASHED, "white", 0.5))
# Phi_b + 2 Phi_r at which monolayers of brass rods among beads began to flock: Kumar et al., Nat. Commun. 5, 4688 (2014).
EXPERIMENT = 0.65


@matplotlib.rc_context(STYLE)
def draw(theory):
    """The picture of an archive of drover boundary TABLE, a matplotlib Figure."""
    missing = [name for name in ("curves", "line") if name not in theory.groups]
    if missing:
        raise DroverError(f"{theory.path} holds no group {missing[0]}; expected curves and line in what drover boundary TABLE "
                          "wrote: the file is damaged, or of another version")
    curves, line = (theory.groups[name].map(lambda array: loaded(array, theory.path)) for name in ("curves", "line"))
    figure = sheet()
    left, right = add_axes(figure, CURVES), add_axes(figure, PLANE)
    draw_curves(left, curves, line)
    draw_plane(right, curves, line)
    for axes, words, keys in ((left, "(a) speed of beads that rods drag, and what flocks need", curve_keys(curves)),
                              (right, "(b) where flocks begin", plane_keys(right))):
        axes.set_title(words, loc="left")
        axes.xaxis.set_major_locator(MaxNLocator(7, steps=STEPS))
        axes.yaxis.set_major_locator(MaxNLocator(7, steps=STEPS))
        axes.set_xlabel(r"area fraction of beads $\Phi_b$")
        figure.legend(handles=keys, loc="upper left", ncol=-(-len(keys) // KEYS_A_COLUMN), frameon=False, borderpad=0.0, borderaxespad=0.0,
                      bbox_to_anchor=(axes.get_position().x0, KEYS_TOP / SIZE[1]))
    name = theory.attributes.get("scene_file", "?").removesuffix(" (its scene)")
    write_words(figure, f"{name}: where its coefficients say that flocks begin", caption(curves, line))
    return figure


def colours_of(curves):
    """One of each area fraction of rods, dark to light."""
    return matplotlib.colormaps["viridis"](numpy.linspace(0.0, 0.82, curves.sizes["rod_fraction"]))


def draw_curves(axes, curves, line):
    """alpha/Gamma of each area fraction of rods, a/lambda of both conventions, and where they cross."""
    beads, drag = curves["bead_fraction"].values, curves["drag"].values
    low, high = speeds_shown(drag, curves["drag_error"].values)
    threshold, error = curves["threshold"].values[0], curves["threshold_error"].values[0]  # rods do not matter for it
    needed = numpy.where((threshold > 0.0) & numpy.isfinite(threshold), threshold, numpy.nan)
    for _, _, style, _, part in CONVENTIONS:
        axes.plot(beads, cut(part * needed, high), color="black", linestyle=style, linewidth=1.4, zorder=3)
        draw_band(axes.fill_between, beads, part * needed, part * error, "black", high)
    for colour, values, errors in zip(colours_of(curves), drag, curves["drag_error"].values):
        axes.plot(beads, cut(values, high), color=colour, linewidth=1.4, zorder=4)
        draw_band(axes.fill_between, beads, values, errors, colour, high)
    for colour, rods, values in zip(colours_of(curves), curves["rod_fraction"].values, drag):
        draw_crossings(axes, line, rods, colour, lambda place, values=values: numpy.interp(place, beads, values))
    axes.set_xlim(beads[0], beads[-1])
    axes.set_ylim(low, high)
    axes.set_ylabel(with_unit("speed", curves["drag"]))


def speeds_shown(drag, error):
    """Ends of the axis of speeds: what alpha/Gamma needs, whatever a/lambda does."""
    most = float(numpy.nanmax(drag, initial=0.0))
    least = float(numpy.nanmin(drag - numpy.nan_to_num(error), initial=0.0))
    return 1.1 * least, ROOM * most if most > 0.0 else 0.5 * abs(least) or 1.0


def cut(values, high):
    """What lies so far beyond the axis that the drawing of it would overflow stays beyond it."""
    return numpy.clip(values, -FAR * high, FAR * high)


def draw_band(fill, along, values, errors, colour, high):
    fill(along, cut(values - errors, high), cut(values + errors, high), color=colour, alpha=0.18, linewidth=0, zorder=1)


def draw_crossings(axes, line, rods, colour, height_of):
    """Marks at one area fraction of rods, where the table has crossings there."""
    at = numpy.flatnonzero(numpy.isclose(line["line_rod_fraction"].values, rods, rtol=1e-9, atol=0.0))
    for name, _, _, fill, _ in CONVENTIONS:
        for place, error in zip(line[name].values[at], line[f"{name}_error"].values[at]):
            if numpy.isfinite(place):
                axes.errorbar(place, height_of(place), xerr=error if numpy.isfinite(error) else None, color=colour, marker="o",
                              markersize=5, markerfacecolor=colour if fill == "black" else fill, capsize=2.5, zorder=5)


def draw_plane(axes, curves, line):
    """The lines of both conventions with their errors, the region of flocks, and the line of the experiment."""
    beads, rods = curves["bead_fraction"].values, line["line_rod_fraction"].values
    room = 0.05 if len(rods) == 1 else 0.0
    axes.set_xlim(beads[0], beads[-1])
    axes.set_ylim(rods[0] - room, rods[-1] + room)
    for name, _, style, fill, _ in CONVENTIONS:
        place, error = line[name].values, line[f"{name}_error"].values
        axes.plot(place, rods, color="black", linestyle=style, linewidth=1.6, zorder=3)
        draw_band(axes.fill_betweenx, rods, place, error, "black", 1.0)
        lone = alone(place)
        axes.errorbar(place[lone], rods[lone], xerr=numpy.nan_to_num(error[lone]), color="black", marker="o", linestyle="none",
                      markersize=4.5, markerfacecolor=fill, capsize=2.5, zorder=4)
    axes.plot(EXPERIMENT - 2.0 * numpy.array(axes.get_ylim()), axes.get_ylim(), color=GREY, linewidth=0.7, zorder=2)
    axes.set_ylabel(r"area fraction of rods $\Phi_r$")
    name_regions(axes, line, rods)
    if not any(numpy.isfinite(line[name].values).any() for name, *_ in CONVENTIONS):
        axes.text(0.5, 0.5, without_crossing(curves), ha="center", va="center", transform=axes.transAxes,
                  bbox={"facecolor": "white", "edgecolor": "none", "alpha": 0.9})


def alone(values):
    """Numbers of the finite values between two that are not: a line shows none of them."""
    there = numpy.concatenate([[False], numpy.isfinite(values), [False]])
    return numpy.flatnonzero(there[1:-1] & ~there[:-2] & ~there[2:])


def name_regions(axes, line, rods):
    """Flocks are on the side of many beads, or everywhere; names stand where there is room for them."""
    place = line["mean"].values
    everywhere = ~numpy.isfinite(place) & (line["mean_above"].values > 0)
    axes.fill_betweenx(rods, numpy.where(everywhere, axes.get_xlim()[0], place), axes.get_xlim()[1], color=FLOCK, linewidth=0, zorder=0)
    finite = numpy.flatnonzero(numpy.isfinite(place))
    if len(finite) < 2:
        return
    top, (low, high) = finite[-1], axes.get_xlim()
    for words, side, width in (("flocks", "right", high - place[top]), ("no flocks", "left", place[top] - low)):
        if width > NAMED_FROM * (high - low):
            axes.annotate(words, (high if side == "right" else low, rods[top]), (-6 if side == "right" else 6, -6),
                          textcoords="offset points", fontsize=10, ha=side, va="top", style="italic", zorder=6,
                          path_effects=[withStroke(linewidth=2.5, foreground="white" if side == "left" else FLOCK)])


def without_crossing(curves):
    """Why there is no line."""
    first = curves["threshold"].values[:, 0]
    above = (first > 0.0) & (curves["drag"].values[:, 0] >= first)
    if above.all():
        return "no crossing in this table:\nflocks from the least " + r"$\Phi_b$" + " on"
    return "no crossing in this table" + ("" if above.any() else ":\nno flocks are expected in it")


def curve_keys(curves):
    colours, rods = colours_of(curves), curves["rod_fraction"].values
    told = numpy.unique(numpy.linspace(0, len(rods) - 1, min(len(rods), KEYS_MOST)).astype(int))
    keys = [key_of(rf"$\alpha/\Gamma$ at $\Phi_r$ = {rods[i]:.3g}", colours[i], line="-") for i in told]
    keys += [key_of(r"$a/\lambda$, $\lambda = \lambda_s/2$", "black", line="-"),
             key_of(r"$a/\lambda_s$", "black", line=DASHED), key_of("crossing", marker="o"),
             key_of(r"crossing with $a/\lambda_s$", marker="o", fill="white")]
    return [*keys, Patch(facecolor=GREY, alpha=0.3, linewidth=0, label="± one standard error")]


def plane_keys(axes):
    keys = [key_of(words, "black", line=style) for _, words, style, _, _ in CONVENTIONS]
    ends = EXPERIMENT - 2.0 * numpy.array(axes.get_ylim())
    beyond = "" if ends.min() < axes.get_xlim()[1] and ends.max() > axes.get_xlim()[0] else " (beyond this plane)"
    keys.append(key_of(rf"experiment, $\Phi_b + 2\,\Phi_r$ = {EXPERIMENT:g}{beyond}", line="-"))
    keys[-1].set_linewidth(0.7)
    return [*keys, Patch(facecolor=FLOCK, label=r"flocks expected ($\lambda = \lambda_s/2$)"),
            Patch(facecolor=GREY, alpha=0.3, linewidth=0, label="± one standard error")]


def caption(curves, line):
    """What a stranger needs to read the picture."""
    words = ["(a) α/Γ: speed of the beads at P = 1; a/λ: what it has to exceed for a flock. λ = λs/2 is the equations' convention; "
             "λs, of one rod, is twice that."]
    if (curves["threshold"].values <= 0.0).any():
        words.append("Where a/λ is not positive it is left out.")
    for name, *_ in CONVENTIONS:
        holes, count = int((~numpy.isfinite(line[name].values)).sum()), line.sizes["line_rod_fraction"]
        title = "λ\u00a0=\u00a0λs/2" if name == "mean" else "λs taken for λ"
        if holes:
            words.append(f"{title}: no crossing within the table at {holes} of {count} area fractions of rods; nothing is drawn there.")
        share = float(line[f"{name}_share"].values[numpy.isfinite(line[name].values)].min(initial=1.0))
        if share < SURE:
            words.append(f"{title}: errors are of those tables redrawn within their errors that cross, at least {100 * share:.0f} % "
                         "of them.")
    words.append("Experiment: Kumar et al., Nat. Commun. 5, 4688 (2014).")
    return " ".join(words)
