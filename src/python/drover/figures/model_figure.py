"""drover/figures/model_figure.py: figure of a run with fields of its own, one column wide: maps, series, structure
factors."""
import re
import textwrap
from dataclasses import dataclass

import matplotlib
import numpy

from .. import results
from . import model_panels as panels
from drover.figures.panels import is_resolved, length_text, time_text
from drover.figures.paper import add_axes, new_figure, require_frame
from drover.roles import arrays_at, roles_of
from drover.text import drawable, scene_name
from drover.typeset import bracket

STYLE = {"font.size": 7, "axes.titlesize": 7.5, "axes.labelsize": 7, "axes.labelpad": 2, "xtick.labelsize": 6.5,
         "ytick.labelsize": 6.5, "legend.fontsize": 6.5, "xtick.major.pad": 2, "ytick.major.pad": 2,
         "xtick.major.size": 2.5, "ytick.major.size": 2.5, "xtick.minor.size": 1.5, "ytick.minor.size": 1.5,
         "axes.linewidth": 0.6, "lines.markersize": 3, "axes.spines.top": False, "axes.spines.right": False,
         "figure.dpi": 300, "text.usetex": False}
# Inches.
WIDTH, LEFT, BAR_GAP, BAR, BAR_LABELS, MAP_GAP = 3.5, 0.57, 0.05, 0.07, 0.4, 0.03
GAP, LABELS_AT = 0.06, 0.41  # between panels of means; labels left of the axes
RIGHT, LINE, LEGEND_LINE, CAPTION_LINE = 0.12, 0.165, 0.15, 0.112
TICKS, LABELLED = 0.2, 0.36        # below axes: with ticks, with a label too
MEAN, DEVIATION, STRUCTURE, PROFILE = 0.46, 0.7, 1.4, 0.75  # heights of panels
TALLEST, LOWEST = 2.2, 0.5          # of a map
WIDE_FROM, TALL_FROM = 2.0, 0.55    # ratio of the sides of the cell, x to y: one map in a row, or three
TITLE_LETTERS, CAPTION_LETTERS, MAP_LETTERS = 60, 74, (0, 44, 25, 13)  # in a line; of maps by their columns


@dataclass
class Page:
    """Axes from the top down; heights are added first, and drawn when the figure has its height."""

    figure: object = None
    top: float = 0.0
    letter: int = 0

    def next_letter(self):
        self.letter += 1
        return f"({chr(96 + self.letter)})" if self.letter <= 26 else f"({self.letter})"

    def axes(self, left, width, height, title="", above=0.0, lines=1):
        """Axes whose title, of as many lines as its neighbours' at most, and a legend have `above` inches."""
        axes = add_axes(self.figure, (left, self.top - above - height, width, height))
        axes.yaxis.set_label_coords(-LABELS_AT / width, 0.5)
        if title:
            page = self.figure.get_size_inches()
            down = LINE * (lines - 1 - title.count("\n"))
            self.figure.text((left - 0.02) / page[0], (self.top - 0.01 - down) / page[1], title, va="top",
                             fontsize=STYLE["axes.titlesize"], linespacing=1.15)
        return axes


@matplotlib.rc_context(STYLE)
def draw(run, frame=-1):
    """Draws a run as a matplotlib Figure.  Raises DroverError if there is no such frame."""
    require_frame(run, frame)
    roles = roles_of(run)
    groups = groups_of(roles)
    structure = panels.structure_parts(run, roles)
    lines = textwrap.wrap(title(run, frame), TITLE_LETTERS)
    words = textwrap.wrap(caption(run, roles, structure, frame), CAPTION_LETTERS)
    boxes = map_boxes(run, roles)
    above = [LINE + LEGEND_LINE * rows_of(labels) for labels in
             ([role.symbol for role in roles], [panels.deviation_label(run, role) for role in roles],
              [key.get_label() for key in panels.structure_keys(structure)])]
    height = (0.08 + LINE * len(lines) + sum(box[-1] for box in boxes) + sum(above) + len(groups) * (MEAN + GAP)
              + DEVIATION + STRUCTURE + 3 * LABELLED + CAPTION_LINE * len(words) + 0.14)
    page = Page(new_figure((WIDTH, height)), height - 0.05)
    page.figure.text(0.06 / WIDTH, page.top / height, "\n".join(lines), va="top", fontsize=7.5)
    page.top -= LINE * len(lines) + 0.03
    draw_fields(page, run, roles, boxes, frame)
    draw_means(page, run, roles, groups, above[0], frame)
    draw_deviations(page, run, roles, above[1], frame)
    axes = page.axes(LEFT, WIDTH - LEFT - RIGHT, STRUCTURE, f"{page.next_letter()} structure factors", above[2])
    add_legend(axes, panels.structure_keys(panels.draw_structure(axes, run, roles)))
    page.figure.text(0.06 / WIDTH, (CAPTION_LINE * len(words) + 0.06) / height, "\n".join(words), va="top",
                     fontsize=6.3, linespacing=1.25)
    return page.figure


def columns_in(labels):
    """Columns of a legend: three where labels have units."""
    return 3 if any("[" in label for label in labels) else 4


def rows_of(labels):
    """Rows of a legend."""
    return -(-len(labels) // columns_in(labels))


def letters_of(fields):
    """Letters of the panels after the maps: means, deviations, structure factors."""
    return [f"({chr(97 + fields + number)})" for number in range(3)]


def groups_of(roles):
    """Numbers of the fields that share a unit."""
    groups = {}
    for number, role in enumerate(roles):
        groups.setdefault(role.unit, []).append(number)
    return list(groups.values())


def columns_of(run, roles):
    """Maps in a row."""
    grid = run.scene["grid"]
    ratio = grid["lx"] / grid["ly"]
    if grid["ny"] == 1 or ratio > WIDE_FROM:
        return 1
    return min(len(roles), 3 if ratio < TALL_FROM else 2)


def map_title(letter, role, columns):
    """Name, symbol and unit of a field, in two lines where one is too short."""
    most, words = MAP_LETTERS[columns], role.title_words
    words = words if len(words) <= most else words[:most - 3] + "..."
    value = f"${role.size_symbol}$" + bracket(role.unit)
    first = f"{letter} {words}".strip()
    letters = len(first) + len(re.sub(r"\\[A-Za-z]+", "x", re.sub(r"\\math[a-z]+|[{}$^_]", "", value)))
    return f"{first}{chr(10) if letters > most else ' '}{value}".lstrip()


def title_lines(roles, number, columns):
    """Lines of the longest title in the row of a map."""
    first = number - number % columns
    return max(map_title("(a)", role, columns).count("\n") + 1 for role in roles[first:first + columns])


def title_height(lines):
    return LINE * lines + 0.03


def map_boxes(run, roles):
    """(left, width, height of the map, whether x and y are labelled, height of its row or 0 inside a row)."""
    grid, columns = run.scene["grid"], columns_of(run, roles)
    above = [title_height(title_lines(roles, number, columns)) for number in range(len(roles))]
    if grid["ny"] == 1:
        return [(LEFT, WIDTH - LEFT - RIGHT, PROFILE, role is roles[-1], True,
                 above[number] + PROFILE + (LABELLED if role is roles[-1] else TICKS))
                for number, role in enumerate(roles)]
    ratio = grid["lx"] / grid["ly"]
    beside = BAR_GAP + BAR + BAR_LABELS
    width = (WIDTH - LEFT - columns * beside - (columns - 1) * MAP_GAP) / columns
    height = float(numpy.clip(width / ratio, LOWEST, TALLEST))
    drawn = min(width, height * ratio) if ratio <= WIDE_FROM else width
    boxes = []
    for number in range(len(roles)):
        column, is_last = number % columns, number + columns >= len(roles)
        last_of_row = number - column + columns - 1
        row = above[number] + height + (LABELLED if last_of_row + columns >= len(roles) else TICKS)
        boxes.append((LEFT + column * (width + beside + MAP_GAP), drawn, height, is_last, column == 0,
                      0.0 if column else row))
    return boxes


def draw_fields(page, run, roles, boxes, frame):
    row, columns = 0.0, columns_of(run, roles)
    for number, (role, (left, width, height, has_x, has_y, new_row)) in enumerate(zip(roles, boxes)):
        if new_row:
            page.top -= row
            row = new_row
        lines = title_lines(roles, number, columns)
        above = title_height(lines)
        axes = page.axes(left, width, height, map_title(page.next_letter(), role, columns), above, lines)
        bar = None if run.scene["grid"]["ny"] == 1 else add_axes(
            page.figure, (left + width + BAR_GAP, page.top - above - height, BAR, height))
        panels.draw_map(axes, bar, run, role, frame)
        if not has_x:
            axes.set_xlabel("")
        if not has_y:
            axes.set_ylabel("")
            axes.tick_params(labelleft=False)
    page.top -= row


def draw_means(page, run, roles, groups, above, frame):
    now, width = float(run.frames["time"][frame]), WIDTH - LEFT - RIGHT
    first, drawn = f"{page.next_letter()} means over the cell", []
    for number, group in enumerate(groups):
        axes = page.axes(LEFT, width, MEAN, first if number == 0 else "", above if number == 0 else 0.0)
        panels.draw_means(axes, run, [roles[i] for i in group], group)
        axes.axvline(now, color="#909090", linewidth=0.5, zorder=0)
        page.top -= MEAN + GAP + (above if number == 0 else 0.0)
        drawn.append(axes)
        if number + 1 < len(groups):
            axes.set_xlabel("")
            axes.tick_params(labelbottom=False)
    add_legend(drawn[0], [line for axes in drawn for line in axes.get_legend_handles_labels()[0]])
    page.top -= LABELLED


def draw_deviations(page, run, roles, above, frame):
    axes = page.axes(LEFT, WIDTH - LEFT - RIGHT, DEVIATION, f"{page.next_letter()} deviations in the cell", above)
    if panels.draw_deviations(axes, run, roles):
        panels.of_time(axes, run)
        axes.axvline(float(run.frames["time"][frame]), color="#909090", linewidth=0.5, zorder=0)
        add_legend(axes, axes.get_legend_handles_labels()[0])
    page.top -= above + DEVIATION + LABELLED


def add_legend(axes, handles):
    """A legend above axes, below their title."""
    if handles:
        columns = columns_in([handle.get_label() for handle in handles])
        axes.legend(handles=handles, loc="lower left", bbox_to_anchor=(0.0, 1.0), ncols=columns, frameon=False,
                    borderaxespad=0.0, borderpad=0.2, handlelength=1.6, columnspacing=1.2, labelspacing=0.25)


def title(run, frame):
    name = drawable(run.scene.get("model", {}).get("name") or scene_name(run))
    return f"{name}, {time_text(format(float(run.frames['time'][frame]), 'g'), run)}"


def averaged_words(run, roles, frame):
    """Which maps show averages over blocks."""
    averaged = [number for number, role in enumerate(roles)
                if not is_resolved(run, panels.averages_of(role, arrays_at(run, role, frame))[1])]
    if not averaged:
        return "."
    letters = "" if len(averaged) == len(roles) else " ".join(f"({chr(97 + number)})" for number in averaged)
    return f"; {letters or 'maps'} {'are' if len(averaged) > 1 or not letters else 'is'} averaged over blocks."


def caption(run, roles, structure, frame):
    """Explains the figure to a reader."""
    words, grid, letters = [], run.scene["grid"], letters_of(len(roles))
    if grid["ny"] > 1:
        directions = {1: "arrows show vectors", 2: "lines without heads the directors of nematics"}
        drawn = [directions[spin] for spin in (1, 2) if any(role.spin == spin for role in roles)]
        words.append(f"Colours of maps show {'values and sizes' if any(role.spin for role in roles) else 'values'}"
                     + "".join(f", {part}" for part in drawn) + averaged_words(run, roles, frame))
    bands = "" if all(role.spin for role in roles) else "Bands: one standard deviation of the field in the cell. "
    words.append(f"{letters[0]} {bands}Thin line: time of the {'maps' if grid['ny'] > 1 else 'profiles'}.")
    shows_warm_up = run.summary is not None and float(run.summary.get("warm_up", 0.0)) > 0.0
    if shows_warm_up:
        words.append("Grey times: warm-up, left out of means.")
    if run.summary is None:
        words.append(f"{results.without_means(run)}: {letters[2]} shows means over all samples so far, without errors.")
    elif structure:
        has_linear = any(part[-1].has_linear for part in structure)
        is_sure = all(numpy.isfinite(part[-1].error).all() for part in structure)
        words.append(f"{letters[2]} Points: time means with standard errors"
                     + ("" if is_sure else " (open: the run is too short for an error estimate)")
                     + (", lines: linear theory." if has_linear else "."))
    sides = (f"{grid[one]:g}\xa0×\xa0{grid[other]:g}" for one, other in (("nx", "ny"), ("lx", "ly")))
    words.append("{} points, {}{}, seed\xa0{}.".format(*sides, length_text(run),
                                                    drawable(run.attributes.get("seed", "?"))))
    return " ".join(words)
