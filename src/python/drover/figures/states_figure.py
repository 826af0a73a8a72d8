"""drover/figures/states_figure.py: figure of the states of drover states: their fields along x, and the curve they
are on."""
import matplotlib
import numpy
from matplotlib.ticker import MaxNLocator

from drover.error import DroverError
from drover.figures.panels import BLUE, GREY, STEPS, VERMILLION, key_of, make_room_above, with_unit
from drover.figures.paper import STYLE, add_axes, new_figure, write_title_and_caption
from drover.text import drawable, scene_name
from drover.typeset import unit_text

SHOWN = 5             # states of a curve whose fields are drawn
ROUNDING = 1e-9       # of a component, relative to the largest: it is zero
FIELDS = 4            # panels of fields at most
NEUTRAL = 1e-9        # of growth rates, relative to the largest: neither growth nor decay
WIDE, LEFT, RIGHT = (0.95, 9.9), (0.95, 5.4), (7.55, 3.5)  # left edge and width of columns [inches]
BOTTOM, TOP, GAP = 1.45, 6.95, 0.35
TURNS = {"curve_fold": "D", "curve_pitchfork": "^"}  # flags of the states where a curve turns, and their markers
# Numbers of a curve that are drawn first, by parts of their names.
PREFERRED = ("speed", "max_", "size_", "high", "max")


def arrays_of(frames):
    """Names of the arrays that are not zero everywhere, at most FIELDS of them."""
    names = [str(name) for name, array in frames.data_vars.items() if {"state", "x"} <= set(array.dims)]
    sizes = {name: float(abs(frames[name]).max()) for name in names}
    most = max(sizes.values(), default=0.0)
    return [name for name in names if sizes[name] > ROUNDING * most][:FIELDS]


def chosen_states(count, frame=None):
    """Numbers of the states whose fields are drawn: one, or some along a curve with both ends."""
    if frame is not None:
        return [frame]
    return sorted({int(k) for k in numpy.linspace(0, count - 1, min(SHOWN, count)).round()})


def colours_of(count):
    """One colour for each state along a curve; a single one is blue."""
    if count == 1:
        return [BLUE]
    return [matplotlib.colormaps["viridis"](part) for part in numpy.linspace(0.0, 0.9, count)]


def draw_profiles(axes, frames, name, states):
    """Draws an array of the states over x."""
    x = frames["x"].values
    for state, colour in zip(states, colours_of(len(states))):
        axes.plot(x, frames[name].isel(state=state, y=0).values, color=colour, linewidth=1.3)
    axes.set_xlim(x[0], x[-1] + (x[1] - x[0]))
    axes.margins(y=0.1)
    axes.set_xlabel(with_unit("$x$", frames["x"]))
    axes.set_ylabel(with_unit(drawable(name.replace("_", " ")), frames[name]))
    axes.yaxis.set_major_locator(MaxNLocator(4, steps=STEPS))
    axes.xaxis.set_major_locator(MaxNLocator(8, steps=STEPS))


def is_unstable(curve):
    """Of each state of a curve, whether a perturbation grows."""
    growth = curve["curve_growth_rate"].values
    return growth > NEUTRAL * numpy.nanmax(abs(growth), initial=0.0)


def numbers_of(curve):
    """Two numbers of the states that vary along the curve."""
    names = [str(name) for name in curve if curve[name].dims == ("point",) and str(name).startswith("curve_")
             and str(name) not in ("curve_parameter", *TURNS, "curve_growth_rate")
             and float(curve[name].max() - curve[name].min()) > ROUNDING * float(abs(curve[name]).max())]
    best = [name for part in PREFERRED for name in names if part in name.removeprefix("curve_")]
    return list(dict.fromkeys([*best, *names]))[:2]


def words_of(name):
    """A number of a curve in words."""
    words = name.removeprefix("curve_").replace("_", " ")
    return drawable(words.replace("max ", "largest ", 1) if words.startswith("max ") else words)


def draw_curve(axes, curve, name, states=()):
    """Draws a number of the states over the followed one: unstable ones open, those whose fields are drawn coloured."""
    parameter, values, unstable = curve["curve_parameter"], curve[name].values, is_unstable(curve)
    axes.plot(parameter, values, color=GREY, linewidth=0.8, zorder=1)
    for some, fill in ((~unstable, BLUE), (unstable, "white")):
        axes.plot(parameter.values[some], values[some], "o", color=BLUE, markerfacecolor=fill, markersize=3.5, zorder=2)
    for state, colour in zip(states, colours_of(len(states))):
        axes.plot(parameter.values[state], values[state], "s", color=colour, markeredgecolor="black", markersize=6,
                  markeredgewidth=0.6, zorder=3)
    turns = {kind: curve[kind].values > 0.0 for kind in TURNS if kind in curve}
    for kind, here in turns.items():
        axes.plot(parameter.values[here], values[here], TURNS[kind], color=VERMILLION, markersize=5, zorder=4)
    axes.margins(0.06)
    axes.set_xlabel(with_unit(drawable(parameter.attrs.get("comment", "parameter")), parameter))
    axes.set_ylabel(with_unit(words_of(name), curve[name]))
    for axis in (axes.xaxis, axes.yaxis):
        axis.set_major_locator(MaxNLocator(5, steps=STEPS))
    axes.ticklabel_format(axis="y", useOffset=False)
    keys = [key_of("stable", BLUE, "o")] if not unstable.all() else []
    keys += [key_of("unstable", BLUE, "o", fill="white")] if unstable.any() else []
    keys += [key_of(words_of(kind), VERMILLION, TURNS[kind]) for kind, here in turns.items() if here.any()]
    make_room_above(axes, 1)
    axes.legend(handles=keys, loc="upper right", ncols=len(keys), columnspacing=1.0)


def boxes_of(count, column):
    """Boxes from the top down."""
    gap = GAP + 0.35
    height = (TOP - BOTTOM - (count - 1) * gap) / max(count, 1)
    return [(*column[:1], TOP - (k + 1) * height - k * gap, column[1], height) for k in range(count)]


@matplotlib.rc_context(STYLE)
def draw(theory, frame=None):
    """Draws states as a matplotlib Figure: all along a curve, or one `frame`.  Raises DroverError without it."""
    frames, curve = theory.groups["frames"], theory.groups.get("curve")
    count = frames.sizes["state"]
    if frame is not None and not -count <= frame < count:
        raise DroverError(f"{theory.path}: has no state {frame}; expected 0 to {count - 1}, or a negative number "
                          "counted from the end")
    states = chosen_states(count, None if frame is None else frame % count)
    names = arrays_of(frames)
    figure = new_figure()
    for letter, name, box in zip("abcd", names, boxes_of(len(names), WIDE if curve is None else LEFT)):
        axes = add_axes(figure, box)
        draw_profiles(axes, frames, name, states)
        axes.set_title(f"({letter}) {drawable(name.replace('_', ' '))}", loc="left")
        if name != names[-1]:
            axes.set_xlabel("")
    shown = [] if curve is None else numbers_of(curve)
    for letter, name, box in zip("abcdef"[len(names):], shown, boxes_of(len(shown), RIGHT)):
        axes = add_axes(figure, box)
        draw_curve(axes, curve, name, states)
        axes.set_title(f"({letter}) {words_of(name)}", loc="left")
        if name != shown[-1]:
            axes.set_xlabel("")
    write_title_and_caption(figure, title(theory), caption(theory, states, curve))
    return figure


def title(theory):
    speed = theory.groups["state"]["speed"]
    moves = "standing" if abs(float(speed)) < 1e-12 else (f"travelling at {float(speed):.6g} "
                                                          f"{unit_text(speed.attrs['units'])}")
    return f"{scene_name(theory)}: a state along $x$, {moves}"


def caption(theory, states, curve):
    """Explains the figure to a reader."""
    state = theory.groups["state"]
    growth = float(state["growth_rate"])
    words = [f"The state has the residual {float(state['residual']):.2g}."]
    if numpy.isfinite(growth):
        words.append(f"Its fastest perturbation that depends on x alone {'grows' if growth > 0.0 else 'decays'} at "
                     f"{abs(growth):.4g}\u00a0{unit_text(state['growth_rate'].attrs['units'])}.")
    if curve is not None:
        drawn = "Square: the state whose fields are drawn" if len(states) == 1 else (
            f"Squares: the {len(states)} states whose fields are drawn, in the same colours")
        words.append(f"{drawn}, of {curve.sizes['point']} along the curve; open circles: a perturbation along x grows.")
    return " ".join(words)
