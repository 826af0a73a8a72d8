"""drover/figures/calibration_figure.py: the figure of a table of coefficients over the area fractions."""
import math

import matplotlib
from matplotlib.ticker import MaxNLocator

from drover.error import DroverError
from drover.figures.panels import BLUE, GREY, STEPS, bracket
from drover.figures.paper import STYLE, add_axes, new_figure, write_title_and_caption
from drover.lookup import info, schema
from drover.text import drawable, scene_name

COLUMNS, ROWS = 4, 3
LEFT, TOP, WIDTH, HEIGHT, ACROSS, DOWN = 0.8, 5.45, 1.9, 1.45, 2.75, 2.05  # inches: the first panel, and to the next
COLOURS = (BLUE, "#E69F00", "#009E73", "#D55E00", "#CC79A7", "black")
SHORT = ("short", "closure")
KNOWN = {"bead_area_fraction", "rod_area_fraction", "value", "error", "origin", "remark", "trials"}


def coefficients_of(table):
    """{name: coefficient} of the numbers that scenes take, without those that are 0 everywhere."""
    keys = {f"{part['name']}_{row['name']}" for part in schema("fields") for row in part["rows"]}
    keys |= {part["name"] for part in schema("fields")}
    return {name: one for name, one in info(table)["coefficients"].items()
            if name in keys and any(point["value"] for point in one["points"])}


def draw(theory):
    """Draws a table of drover calibrate as a matplotlib Figure.  Raises DroverError for one that varies more than both
    area fractions."""
    table = theory.path
    found = list(coefficients_of(table).items())[:COLUMNS * ROWS]
    others = {key for _, one in found for point in one["points"] for key in point} - KNOWN
    if others:
        raise DroverError(f"{table}: the table varies {others.pop()} beside the area fractions; draw its arrays, as "
                          "xarray.open_dataset has them")
    with matplotlib.rc_context(STYLE):
        figure = new_figure()
        labels = {}
        for place, (name, one) in enumerate(found):
            row, column = divmod(place, COLUMNS)
            axes = add_axes(figure, (LEFT + column * ACROSS, TOP - row * DOWN, WIDTH, HEIGHT))
            labels |= draw_coefficient(axes, one)
            words = drawable(name.replace("_", " ")) + bracket(one["unit"])
            axes.set_title(f"({chr(ord('a') + place)}) {words}", loc="left", fontsize=9)
            if place + COLUMNS >= len(found):
                axes.set_xlabel(r"area fraction of beads $\Phi_b$")
        if labels:
            figure.legend(labels.values(), labels.keys(), loc="lower right", ncols=len(labels), frameon=False,
                          bbox_to_anchor=(0.99, 0.015))
        write_title_and_caption(figure, f"{scene_name(theory)}: coefficients of the equations",
                                "Points with standard errors; open: a larger error than requested, or of a closure. "
                                "Lines guide the eye. All coefficients with their formulas: drover.info(table).")
    return figure


def draw_coefficient(axes, coefficient):
    """Draws a line for each area fraction of rods; returns its handles by label."""
    labels = {}
    rods = sorted({point.get("rod_area_fraction", math.nan) for point in coefficient["points"]})
    alone = math.isnan(rods[0])
    for colour, of_rods in zip(COLOURS * len(rods), rods):
        points = [point for point in coefficient["points"]
                  if (alone or point["rod_area_fraction"] == of_rods) and point["value"] is not None]
        colour = GREY if alone else colour
        places, values = ([point[key] for point in points] for key in ("bead_area_fraction", "value"))
        axes.errorbar(places, values, [point["error"] or 0.0 for point in points], color=colour, linewidth=0.8)
        for is_open in (False, True):
            chosen = [k for k, point in enumerate(points) if (point["origin"] in SHORT) == is_open]
            drawn, = axes.plot([places[k] for k in chosen], [values[k] for k in chosen], "o", color=colour,
                               markersize=4, markerfacecolor="white" if is_open else colour)
            if not alone:
                labels.setdefault(rf"$\Phi_r = {of_rods:g}$", drawn)
    axes.axhline(0.0, color="0.8", linewidth=0.6, zorder=0)
    axes.yaxis.set_major_locator(MaxNLocator(4, steps=STEPS))
    axes.xaxis.set_major_locator(MaxNLocator(4, steps=STEPS))
    return labels
