"""drover/figure.py: one picture of a run:  python3 -m drover.figure ARCHIVE [--output PNG] [--frame N]"""
import argparse
import io
import sys
import textwrap
from pathlib import Path

import matplotlib
import numpy
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from drover import panels
from drover.archive import open_run, settled
from drover.error import DroverError

STYLE = {"font.size": 9, "axes.titlesize": 10, "axes.labelsize": 9.5, "legend.fontsize": 8.5, "legend.framealpha": 0.85,
         "axes.spines.top": False, "axes.spines.right": False, "figure.dpi": 200}
SIZE = (11.6, 7.7)  # inches
# Where panels go, by the shape of the cell: left, bottom, width, height in inches; the map is fitted into its own.
SQUARE = {"map": (0.8, 3.2, 3.75, 3.75), "structure": (6.35, 3.2, 2.15, 3.75), "numbers": (9.3, 4.95, 2.1, 2.0),
          "exponents": (9.3, 3.2, 2.1, 1.4), "order": (0.8, 1.2, 10.6, 1.1)}
WIDE = {"map": (0.8, 5.3, 9.5, 1.65), "structure": (0.9, 1.25, 2.8, 2.95), "numbers": (4.6, 2.75, 2.8, 1.45),
        "exponents": (4.6, 1.25, 2.8, 1.15), "order": (8.4, 1.25, 3.0, 2.95)}
TALL = {**SQUARE, "map": (0.8, 1.6, 3.3, 5.35), "order": (6.35, 1.2, 5.05, 1.1)}
WIDE_FROM, TALL_FROM = 2.0, 0.62  # ratio of the sides of the cell, x to y
TITLES = {"map": "(a) {}", "structure": "(b) structure factors",
          "numbers": "(c) number fluctuations", "exponents": "(d) their local exponent",
          "order": "(e) polar order of the whole cell"}


def draw(run, frame=-1):
    """The picture of a run, a matplotlib Figure.  Raises DroverError when there is no such frame."""
    frames = run.frames.sizes["time"]
    if not -frames <= frame < frames:
        raise DroverError(f"{run.path}: frame {frame} is asked for; it has the frames 0 to {frames - 1}: choose "
                          "one of these")
    ratio = run.scene["grid"]["lx"] / run.scene["grid"]["ly"]
    layout = WIDE if ratio > WIDE_FROM else TALL if ratio < TALL_FROM else SQUARE
    with matplotlib.rc_context(STYLE):
        figure = Figure(figsize=SIZE)
        FigureCanvasAgg(figure)
        boxes = {**layout, "map": fitted(layout["map"], ratio)}
        axes = {name: add_axes(figure, box) for name, box in boxes.items()}
        blocks = panels.draw_map(axes["map"], add_axes(figure, bar_box(boxes["map"])), run, frame)
        drawn = panels.draw_structure(axes["structure"], run)
        drawn += panels.draw_numbers(axes["numbers"], axes["exponents"], run)
        panels.draw_order(axes["order"], run, columns=1 if layout is WIDE else 2)
        for name, words in TITLES.items():
            axes[name].set_title(words.format(panels.map_title(run, frame)) if name == "map" else words, loc="left")
        figure.text(0.8 / SIZE[0], 1.0 - 0.32 / SIZE[1], title(run, frame), fontsize=12, va="center")
        words = textwrap.wrap(caption(run, drawn, blocks), 172)
        figure.text(0.8 / SIZE[0], 0.66 / SIZE[1], "\n".join(words), fontsize=8.5, va="top", linespacing=1.3)
    return figure


def draw_file(path, frame):
    with open_run(path) as run:
        return draw(run, frame)


def fitted(box, ratio):
    """The largest box of a ratio of sides that is in a box, at its upper left."""
    left, bottom, width, height = box
    fitted_width = min(width, height * ratio)
    return left, bottom + height - fitted_width / ratio, fitted_width, fitted_width / ratio


def bar_box(box):
    """Room for the colour bar on the right of a box."""
    left, bottom, width, height = box
    tall = max(height, 1.1)
    return left + width + 0.1, bottom + height - tall, 0.14, tall


def add_axes(figure, box):
    left, bottom, width, height = box
    return figure.add_axes((left / SIZE[0], bottom / SIZE[1], width / SIZE[0], height / SIZE[1]))


def title(run, frame):
    grid, time = run.scene["grid"], float(run.frames["time"][frame])
    name, seed = (run.attributes.get(key, "?") for key in ("scene_file", "seed"))
    return (f"{name} at $t$ = {time:g} s   ({grid['nx']} × {grid['ny']} points, {grid['lx']:g} × {grid['ly']:g} mm, "
            f"seed {seed})")


def caption(run, drawn, blocks):
    """What a stranger needs to read the picture."""
    pixel, arrow = (f"{side[0]:.3g} × {side[1]:.3g} mm" for side in blocks)
    words = [f"(a) Colours, centred at their mean, are means over {pixel}, arrows over {arrow}; (c) boxes with "
             "as many cells along y as along x; (d) from each box to the next larger one."]
    if run.summary is None:
        words.append("The run has not reached its end: points are means over all samples so far, the warm-up among "
                     "them, without errors and without theory.")
    elif drawn:
        words.append("Points are time means after the warm-up with standard errors"
                     + ("." if all(numpy.isfinite(result.error).all() for result in drawn)
                        else "; hollow ones have none: it was refused, since the run is too short for it."))
        words.append("Lines are the exact linear theory on the same grid, shells and boxes."
                     if any(result.has_linear for result in drawn)
                     else "There is no linear theory beside them: it has no stationary state for this scene.")
    return " ".join(words)


def write(figure, path):
    """Writes the whole picture or nothing."""
    kind = path.suffix.lstrip(".").lower()
    if kind not in ("png", "pdf", "svg"):
        raise DroverError(f'{path}: the ending "{path.suffix}" is no picture that is known here; expected .png, .pdf '
                          "or .svg")
    picture = io.BytesIO()
    figure.savefig(picture, format=kind)
    try:
        path.write_bytes(picture.getvalue())
    except OSError as error:
        raise DroverError(f"{path} cannot be written ({error.strerror}); name another place by --output") from error


def main(arguments=None):
    parser = argparse.ArgumentParser(prog="python3 -m drover.figure", description="One picture of a run.")
    parser.add_argument("archive", type=Path, help="the archive of the run, such as isotropic.h5")
    parser.add_argument("--output", type=Path,
                        help="the picture (.png, .pdf or .svg); by default the archive's name with .png")
    parser.add_argument("--frame", type=int, default=-1,
                        help="number of the frame from 0; -1, the default, is the last")
    options = parser.parse_args(arguments)
    output = options.output or options.archive.with_suffix(".png")
    try:
        write(settled(options.archive, lambda: draw_file(options.archive, options.frame)), output)
    except DroverError as error:
        print(f"drover.figure: {error}", file=sys.stderr)
        return 2
    print(output)
    return 0


if __name__ == "__main__":
    sys.exit(main())
