"""drover/figures/model_film.py: pictures of a film of a run of fields: maps, or profiles."""
import numpy
import xarray

from . import model_panels as panels
from drover.figures.model_figure import columns_of, map_title
from drover.figures.panels import STEPS, add_arrow_key, nearest_divisor, refined_values, time_text, with_unit
from drover.pictures import block_values
from drover.roles import arrows_of
from drover.typeset import bracket

WIDTH, TITLE, EDGE, BAR = 7.2, 0.35, 0.7, 0.75   # inches: of the picture; above; left and below; colour bar and labels
GAP = 0.1
SHORTEST, TALLEST = 0.8, 5.0                     # inches of a panel
SAMPLED, ARROW, SHAFT = 24, 0.32, 0.022          # frames that set the colours; inches for an arrow, and its width
KEY_AT = 0.14                                    # inches above the lower edge: the scale of arrows


def layout_of(run, maps):
    """Columns, and the width and height of a panel in inches."""
    grid, columns = run.scene["grid"], columns_of(run, maps)
    bar = 0.0 if grid["ny"] == 1 else BAR
    width = (WIDTH - columns * (EDGE + bar) - GAP) / columns
    if grid["ny"] == 1:
        return columns, width, max(SHORTEST, 3.0 / len(maps))
    ratio = grid["lx"] / grid["ly"]
    height = float(numpy.clip(width / ratio, SHORTEST, TALLEST))
    return columns, min(width, max(height * ratio, SHORTEST)), height


def size_of(run, maps):
    """Inches of the picture."""
    columns, _, height = layout_of(run, maps)
    return WIDTH, TITLE + -(-len(maps) // columns) * (height + TITLE + EDGE)


def shown(figure, run, frames, maps, name):
    """Draws the panels of roles.maps_of(); returns a function that shows a frame, {array: values} with its time."""
    columns, width, height = layout_of(run, maps)
    page, is_line = figure.get_size_inches(), run.scene["grid"]["ny"] == 1
    sampled, updates = frames[::max(1, len(frames) // SAMPLED)], []
    for number, (role, others) in enumerate(maps):
        left = EDGE + number % columns * ((WIDTH - GAP) / columns)
        bottom = page[1] - TITLE - (number // columns + 1) * (TITLE + height + EDGE) + EDGE
        axes = figure.add_axes((left / page[0], bottom / page[1], width / page[0], height / page[1]))
        if is_line:
            updates.append(line_shown(axes, run, role, sampled))
        else:
            bar = figure.add_axes(((left + width + 0.08) / page[0], bottom / page[1], 0.12 / page[0],
                                   height / page[1]))
            updates.append(map_shown(axes, bar, run, role, arrows_of(others, frames[-1]), sampled))
        words = f"{role.title_words} ${role.symbol}$".lstrip() + bracket(role.unit)
        axes.set_title(words if is_line else map_title("", role, columns), loc="left", fontsize=10)
    title = figure.text(0.1 / page[0], 1.0 - 0.08 / page[1], "", va="top", fontsize=11)

    def show(frame):
        for update in updates:
            update(frame)
        title.set_text(f"{name}   {time_text(format(frame['time'], '.4g'), run)}")
    return show


def line_shown(axes, run, role, sampled):
    """The components of a field over x."""
    x, values = run.frames["x"].values, [numpy.stack([frame[name] for frame in sampled]) for name in role.components]
    lines = [axes.plot(x, array[0][0], color=colour, label=f"${role.symbol}{end}$")[0]
             for array, colour, end in zip(values, panels.COLOURS, panels.parts_of(role))]
    axes.set_xlim(x[0], x[-1] + (x[1] - x[0]))
    low, high = min(float(array.min()) for array in values), max(float(array.max()) for array in values)
    reach = 0.05 * (high - low) if high - low > panels.UNIFORM * abs(high) else 0.1 * abs(high) or 1.0
    axes.set_ylim(low - reach, high + reach)
    axes.set_xlabel(with_unit("$x$", run.frames["x"]))
    if role.spin:
        axes.legend(loc="lower right", bbox_to_anchor=(1.0, 1.0), ncols=2, frameon=False, borderaxespad=0.1)

    def update(frame):
        for line, name in zip(lines, role.components):
            line.set_ydata(frame[name][0])
    return update


def pixels_of(run, role, frame):
    """Points along y and x of the averages that the figure of a noisy field shows; 1 and 1 of a smooth one."""
    places = {axis: run.frames[axis].values for axis in "yx"}
    pixel = panels.averages_of(role, {name: xarray.DataArray(frame[name], places, ("y", "x"))
                                      for name in role.components})[1]
    return [max(1, round(side / float(place[1] - place[0]))) for side, place in zip(pixel[::-1], places.values())]


def map_shown(axes, bar_axes, run, role, other, sampled):
    """Colours for the value or size of a field, with limits of all frames, and the directions of another or the same.
    """
    grid = run.scene["grid"]
    pixels = pixels_of(run, role, sampled[len(sampled) // 2])

    def size(frame, finer=lambda values: values):
        return role.size({part: finer(frame[part]) if pixels == [1, 1] else block_values(frame[part], pixels)
                          for part in role.components})

    def drawn(frame):
        return size(frame, refined_values)

    colours, low, high, extend = panels.colours_for(role, numpy.stack([size(frame) for frame in sampled]))
    first = drawn(sampled[0])
    # Half a point before the first one, which is at 0: of the finer ones where there is no average.
    y, x = (0.5 * grid[length] / (count if pixels == [1, 1] else grid[points])
            for length, count, points in (("ly", first.shape[0], "ny"), ("lx", first.shape[1], "nx")))
    image = axes.imshow(first, origin="lower", extent=(-x, grid["lx"] - x, -y, grid["ly"] - y), cmap=colours, vmin=low,
                        vmax=high, interpolation="nearest", aspect="auto")
    axes.figure.colorbar(image, cax=bar_axes, extend=extend)
    axes.set(xlabel=with_unit("$x$", run.frames["x"]), ylabel=with_unit("$y$", run.frames["y"]))
    for axis in (axes.xaxis, axes.yaxis):
        axis.get_major_locator().set_params(nbins=6, steps=STEPS)
    panels.plain_ticks(bar_axes.yaxis, 6)
    if other is None:
        return lambda frame: image.set_data(drawn(frame))
    inches = axes.get_position().size * axes.figure.get_size_inches()
    side = ARROW * max(grid["lx"], grid["ly"]) / max(inches)
    steps = [nearest_divisor(grid[count], side * grid[count] / grid[length]) for count, length in
             (("ny", "ly"), ("nx", "lx"))]

    x, y = (block_values(array, steps) for array in numpy.meshgrid(run.frames["x"].values, run.frames["y"].values))
    length = 0.95 * min(steps[0] * grid["ly"] / grid["ny"], steps[1] * grid["lx"] / grid["nx"])
    def directions(frame):
        return panels.directions_of(other, *(block_values(frame[name], steps) for name in other.components))

    # One scale for the whole film.
    longest = max(float(numpy.hypot(*directions(frame)).max()) for frame in sampled) or 1.0
    arrows = panels.quiver_of(axes, other, x, y, numpy.full_like(x, longest), numpy.zeros_like(x), length, SHAFT)
    if other != role:
        add_arrow_key(axes, arrows, longest, length, other.symbol, run.frames[other.components[0]], KEY_AT)

    def update(frame):
        image.set_data(drawn(frame))
        arrows.set_UVC(*directions(frame))
    return update
