"""drover/boundary_figure.py: one picture of phase boundaries: the plane of two numbers with its regimes and its lines."""
import matplotlib
import numpy
from matplotlib.ticker import MaxNLocator

from drover import boundary_panels as panels
from drover.archive import loaded
from drover.error import DroverError
from drover.panels import STEPS, with_unit
from drover.paper import SIZE, STYLE, add_axes, sheet, write_words

PLANE, KEYS_LEFT = (0.9, 1.35, 7.3, 5.6), 8.5  # inches


@matplotlib.rc_context(STYLE)
def draw(theory):
    """The picture of the lines and the map of an archive of drover boundary, a matplotlib Figure."""
    groups = {name: group.map(lambda array: loaded(array, theory.path)) for name, group in theory.groups.items()}
    lines = panels.lines_of(groups["boundary"]) if "boundary" in groups else []
    if any(not 0 <= line.limit < len(panels.LIMITS) or line.convention not in (0, 1) for line in lines):
        raise DroverError(f"{theory.path}: a line is of a kind or a convention that is not known here; the file is of "
                          "another version of drover, or damaged")
    conventions, (origin, sides) = conventions_of(theory, lines), plane_of(theory)
    figure = sheet()
    axes = add_axes(figure, PLANE)
    codes = panels.draw_regimes(axes, groups["map"].regime, numpy.ravel(
        numpy.column_stack([origin, origin + sides]))) if "map" in groups else []
    for line in lines:
        if line.has_errors:
            panels.draw_ribbon(axes, line, sides)
        panels.draw_line(axes, line, dashed=line.convention != conventions[0])
    axes.set_xlim(origin[0], origin[0] + sides[0])
    axes.set_ylim(origin[1], origin[1] + sides[1])
    angles = panels.write_angles(axes, lines, origin, sides)
    for axis, name in zip((axes.xaxis, axes.yaxis), "xy"):
        axis.set_major_locator(MaxNLocator(8, steps=STEPS))
        axis.set_label_text(label_of(theory, groups, name))
    if not lines:
        axes.text(0.5, 0.5, "no line in this plane", ha="center", va="center", transform=axes.transAxes)
    write_keys(figure, codes, lines, conventions)
    write_words(figure, f"{theory.attributes.get('scene_file', '?')}: phase boundaries of its uniform states",
                caption(theory, codes, lines, conventions, angles))
    return figure


def conventions_of(theory, lines):
    """Numbers of the conventions that were traced, in their order: the map is of the first, whose lines are solid."""
    names = theory.scene.get("boundary", {}).get("conventions") or [
        theory.scene.get("weathercock", {}).get("convention", panels.CONVENTIONS[0])]
    known = [panels.CONVENTIONS.index(name) for name in names if name in panels.CONVENTIONS]
    return list(dict.fromkeys([*known, *(line.convention for line in lines)]))


def plane_of(theory):
    """Lower ends and lengths of both sides of the plane."""
    try:
        ranges = [theory.scene["boundary"][axis].split("=")[1].split(":") for axis in "xy"]
        (left, right), (low, high) = ((float(end) for end in ends) for ends in ranges)
    except (KeyError, IndexError, ValueError, AttributeError) as error:
        raise DroverError(f"{theory.path}: its scene does not say what plane it is of (boundary.x, boundary.y); the file "
                          "is damaged: take another copy of it") from error
    return numpy.array([left, low]), numpy.array([right - left, high - low])


def label_of(theory, groups, axis):
    name = str(theory.attributes.get(f"boundary_{axis}", axis))
    name = name if "." in name else name.replace("_", " ")  # area fractions are no keys of a scene
    if "boundary" in groups:
        return with_unit(name, groups["boundary"][axis])
    return with_unit(name, groups["map"][f"map_{axis}"]) if "map" in groups else name


def write_keys(figure, codes, lines, conventions):
    """Legends on the right of the plane."""
    top = (PLANE[1] + PLANE[3]) / SIZE[1]
    first = panels.CONVENTIONS[conventions[0]]
    for title, keys in ((f"regimes ({first} convention)" if len(conventions) > 1 else "regimes", panels.regime_keys(codes)),
                        ("lines", panels.line_keys(lines, conventions))):
        if keys:
            legend = figure.legend(handles=keys, title=title, loc="upper left", bbox_to_anchor=(KEYS_LEFT / SIZE[0], top),
                                   frameon=False, borderaxespad=0.0, borderpad=0.0, alignment="left", handlelength=2.6)
            top -= (0.2 * len(keys) + 0.55) / SIZE[1]
            legend.get_title().set_fontsize(9.5)


def caption(theory, codes, lines, conventions, angles):
    """What a stranger needs to read the picture."""
    words = ["Lines on which a uniform state loses stability against long waves, q → 0, by linear theory"
             + ("; where two run together the narrow one lies on the wide one." if len({line.limit for line in lines}) > 1 else ".")]
    if codes:
        words.append(f"Colours: what the uniform state is, on {theory.scene['boundary'].get('map', '?')} points along each "
                     "side.")
    if len(conventions) > 1:
        words.append("Conventions: weathercock.strength is λ (mean) or 2 λ (single-rod).")
    if any(line.has_errors for line in lines):
        words.append("Ribbons: standard errors of where lines run, from those of the scene's numbers.")
    if angles:
        words.append("Degrees beside the oblique lines: the angle to the order of the wave that grows first.")
    return " ".join(words)
