"""drover/model_film.py: pictures of a film of a run with fields of its own: a map of each field, or profiles."""
import numpy
import xarray

from drover import model_panels as panels
from drover.model_figure import columns_of, map_title
from drover.panels import STEPS, nearest_divisor, refined_values, time_text, with_unit
from drover.pictures import block_values

WIDTH, TITLE, EDGE, BAR = 7.2, 0.35, 0.6, 0.75   # inches: of the picture; above; left and below; colour bar and labels
GAP = 0.1
SHORTEST, TALLEST = 0.8, 5.0                     # inches of a panel
SAMPLED, ARROW, SHAFT = 24, 0.25, 0.022          # frames that set the colours; inches for an arrow, and its width


def layout_of(run, roles):
    """Columns, and the width and height of a panel in inches."""
    grid, columns = run.scene["grid"], columns_of(run, roles)
    bar = 0.0 if grid["ny"] == 1 else BAR
    width = (WIDTH - columns * (EDGE + bar) - GAP) / columns
    if grid["ny"] == 1:
        return columns, width, max(SHORTEST, 3.0 / len(roles))
    ratio = grid["lx"] / grid["ly"]
    height = float(numpy.clip(width / ratio, SHORTEST, TALLEST))
    return columns, min(width, max(height * ratio, SHORTEST)), height


def size_of(run, roles):
    """Inches of the picture."""
    columns, _, height = layout_of(run, roles)
    return WIDTH, TITLE + -(-len(roles) // columns) * (height + TITLE + EDGE)


def shown(figure, run, frames, roles, name):
    """Draws the panels; returns a function that shows a frame, {array: values} with its time."""
    columns, width, height = layout_of(run, roles)
    page, is_line = figure.get_size_inches(), run.scene["grid"]["ny"] == 1
    sampled, updates = frames[::max(1, len(frames) // SAMPLED)], []
    for number, role in enumerate(roles):
        left = EDGE + number % columns * ((WIDTH - GAP) / columns)
        bottom = page[1] - TITLE - (number // columns + 1) * (TITLE + height + EDGE) + EDGE
        axes = figure.add_axes((left / page[0], bottom / page[1], width / page[0], height / page[1]))
        if is_line:
            updates.append(line_shown(axes, run, role, sampled))
            axes.set_ylabel(f"${role.symbol}$" + panels.bracket(role.unit))
        else:
            bar = figure.add_axes(((left + width + 0.08) / page[0], bottom / page[1], 0.12 / page[0],
                                   height / page[1]))
            updates.append(map_shown(axes, bar, run, role, sampled))
        axes.set_title(role.title_words if is_line else map_title("", role, columns), loc="left", fontsize=10)
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


def map_shown(axes, bar_axes, run, role, sampled):
    """Colours for the value or size of a field, with limits of all frames, and its directions."""
    grid = run.scene["grid"]
    pixels = pixels_of(run, role, sampled[len(sampled) // 2])

    def size(frame, finer=lambda values: values):
        return role.size({part: finer(frame[part]) if pixels == [1, 1] else block_values(frame[part], pixels)
                          for part in role.components})

    def drawn(frame):
        return size(frame, refined_values)

    colours, low, high, extend = panels.colours_for(role, numpy.stack([size(frame) for frame in sampled]))
    image = axes.imshow(drawn(sampled[0]), origin="lower", extent=(0.0, grid["lx"], 0.0, grid["ly"]), cmap=colours,
                        vmin=low, vmax=high, interpolation="nearest", aspect="auto")
    axes.figure.colorbar(image, cax=bar_axes, extend=extend)
    axes.set(xlabel=with_unit("$x$", run.frames["x"]), ylabel=with_unit("$y$", run.frames["y"]))
    for axis in (axes.xaxis, axes.yaxis):
        axis.get_major_locator().set_params(nbins=6, steps=STEPS)
    panels.plain_ticks(bar_axes.yaxis, 6)
    if role.spin not in (1, 2):
        return lambda frame: image.set_data(drawn(frame))
    inches = axes.get_position().size * axes.figure.get_size_inches()
    side = ARROW * max(grid["lx"], grid["ly"]) / max(inches)
    steps = [nearest_divisor(grid[count], side * grid[count] / grid[length]) for count, length in
             (("ny", "ly"), ("nx", "lx"))]

    x, y = (block_values(array, steps) for array in numpy.meshgrid(run.frames["x"].values, run.frames["y"].values))
    length = 0.95 * min(steps[0] * grid["ly"] / grid["ny"], steps[1] * grid["lx"] / grid["nx"])
    def directions(frame):
        return panels.directions_of(role, *(block_values(frame[name], steps) for name in role.components))

    # One scale for the whole film.
    longest = max(float(numpy.hypot(*directions(frame)).max()) for frame in sampled) or 1.0
    arrows = panels.quiver_of(axes, role, x, y, numpy.ones_like(x), numpy.zeros_like(x), length, SHAFT)

    def update(frame):
        image.set_data(drawn(frame))
        arrows.set_UVC(*(part / longest for part in directions(frame)))
    return update
