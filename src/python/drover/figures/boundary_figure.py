"""drover/figures/boundary_figure.py: figure of phase boundaries: regimes and lines in the plane of two parameters."""
import matplotlib
import numpy
from matplotlib.ticker import MaxNLocator

from . import boundary_panels as panels
from drover.archive import loaded
from drover.error import DroverError
from drover.fields import key_of
from drover.figures.panels import STEPS, with_unit
from drover.figures.paper import SIZE, STYLE, add_axes, new_figure, write_title_and_caption
from drover.text import drawable, scene_name
from drover.typeset import symbol_text

PLANE, KEYS_LEFT = (0.9, 1.35, 7.3, 5.6), 8.5  # inches
AREA_FRACTIONS = {"bead_area_fraction": r"area fraction of beads $\Phi_b$",
                  "rod_area_fraction": r"area fraction of rods $\Phi_r$"}  # axes of a plane that are not scene keys


@matplotlib.rc_context(STYLE)
def draw(theory):
    """Draws the lines and the map of an archive of drover boundary as a matplotlib Figure."""
    groups = {name: group.map(lambda array: loaded(array, theory.path)) for name, group in theory.groups.items()}
    lines = panels.lines_of(groups["boundary"]) if "boundary" in groups else []
    if any(not 0 <= line.limit < len(panels.LIMITS) or line.convention not in (0, 1) for line in lines):
        raise DroverError(f"{theory.path}: a line has an unknown kind or convention; the file is from "
                          "another version of drover, or damaged")
    conventions, (origin, sides) = conventions_of(theory, lines), plane_of(theory)
    figure = new_figure()
    axes = add_axes(figure, PLANE)
    regimes = groups["map"].get("regime", groups["map"].get("stable_states")) if "map" in groups else None
    regime_keys = panels.draw_regimes(axes, regimes, numpy.ravel(
        numpy.column_stack([origin, origin + sides]))) if regimes is not None else []
    bands = panels.bands_of(groups["band"]) if "band" in groups else []
    has_bands = [panels.draw_band(axes, band) for band in bands].count(True) > 0
    for line in lines:
        panels.draw_line(axes, line, dashed=line.convention != conventions[0])
    axes.set_xlim(origin[0], origin[0] + sides[0])
    axes.set_ylim(origin[1], origin[1] + sides[1])
    angles = panels.write_angles(axes, lines, origin, sides)
    for axis, name in zip((axes.xaxis, axes.yaxis), "xy"):
        axis.set_major_locator(MaxNLocator(8, steps=STEPS))
        axis.set_label_text(label_of(theory, groups, name))
    if not lines:
        axes.text(0.5, 0.5, "no line in this plane", ha="center", va="center", transform=axes.transAxes)
    write_keys(figure, regime_keys, lines, conventions, has_bands)
    write_title_and_caption(figure, f"{scene_name(theory)}: phase boundaries of its uniform states",
                caption(theory, bool(regime_keys), lines, conventions, angles, has_bands))
    return figure


def conventions_of(theory, lines):
    """Indices of the traced conventions, in order: the map uses the first, whose lines are solid."""
    names = theory.scene.get("boundary", {}).get("conventions") or [
        theory.scene.get(key_of("lambda")[0], {}).get("convention", panels.CONVENTIONS[0])]
    known = [panels.CONVENTIONS.index(name) for name in names if name in panels.CONVENTIONS]
    return list(dict.fromkeys([*known, *(line.convention for line in lines)]))


def plane_of(theory):
    """Lower limits and lengths of both axes of the plane."""
    try:
        ranges = [theory.scene["boundary"][axis].split("=")[1].split(":") for axis in "xy"]
        (left, right), (low, high) = ((float(end) for end in ends) for ends in ranges)
    except (KeyError, IndexError, ValueError, AttributeError) as error:
        raise DroverError(f"{theory.path}: its scene does not define the plane (boundary.x, boundary.y); the file "
                          "is damaged: use another copy") from error
    return numpy.array([left, low]), numpy.array([right - left, high - low])


def label_of(theory, groups, axis):
    name = drawable(theory.attributes.get(f"boundary_{axis}", axis))
    own = name.removeprefix("coefficients.")
    name = AREA_FRACTIONS.get(name, name) if own == name else f"${symbol_text(own, 0)}$"
    if "boundary" in groups:
        return with_unit(name, groups["boundary"][axis])
    return with_unit(name, groups["map"][f"map_{axis}"]) if "map" in groups else name


def write_keys(figure, regime_keys, lines, conventions, has_bands):
    """Draws the legends to the right of the plane."""
    top = (PLANE[1] + PLANE[3]) / SIZE[1]
    first = panels.CONVENTIONS[conventions[0]]
    for title, keys in (("uniform states" if of_own_model(lines)
                         else f"regimes ({first} convention)" if len(conventions) > 1 else "regimes", regime_keys),
                        ("lines", panels.line_keys(lines, conventions, has_bands))):
        if keys:
            legend = figure.legend(handles=keys, title=title, loc="upper left",
                                   bbox_to_anchor=(KEYS_LEFT / SIZE[0], top),
                                   frameon=False, borderaxespad=0.0, borderpad=0.0, alignment="left", handlelength=2.6)
            top -= (0.2 * len(keys) + 0.55) / SIZE[1]
            legend.get_title().set_fontsize(9.5)


def of_own_model(lines):
    return any(line.limit >= panels.OF_MODEL for line in lines)


def caption(theory, has_map, lines, conventions, angles, has_bands):
    """Explains the figure to a reader."""
    of_model = of_own_model(lines)
    words = ["Lines where a uniform state becomes unstable to " + ("any wave" if of_model else "long waves, q → 0")
             + ", from linear theory"
             + ("; binodal: the densities of two phases that travel or stand side by side"
                if any(line.limit == panels.BINODAL for line in lines) else "")
             + ("; where two coincide, the narrow line is drawn on the wide one."
                if len({line.limit for line in lines}) > 1 else ".")]
    if has_map:
        words.append(f"Colours: {'stable uniform states' if of_model else 'regime of the uniform state'}, on "
                     f"{theory.scene['boundary'].get('map', '?')} points along each axis.")
    if len(conventions) > 1:
        words.append(f"Conventions: {'.'.join(key_of('lambda'))} is λ (mean) or 2 λ (single-rod).")
    if has_bands:
        words.append(f"Bands: between 16 and 84 % of {theory.scene['boundary'].get('draws', '?')} draws of all numbers "
                     "within their errors, a point is unstable; no band where fewer than half of them have the state.")
    elif "error_x" in theory.groups.get("boundary", {}):
        words.append("Errors of earlier versions of drover, which this file has, are not drawn.")
    if angles:
        words.append(f"Degrees on {'lines of the ordered state' if of_model else 'oblique lines'}: angle between the "
                     "order and the wave that becomes unstable first.")
    return " ".join(words)
