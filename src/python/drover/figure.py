"""drover/figure.py: draws a figure of an archive.

    python3 -P -m drover.figure tradeoff.json [--output PNG]
    python3 -P -m drover.figure ARCHIVE [--output PNG] [--frame N | --state NAME | --dynamics FIELD]
    python3 -P -m drover.figure ARCHIVE --watch
"""
import argparse
import io
import sys
from pathlib import Path

import matplotlib
import numpy

from drover import live, new_file, results
from drover.figures import (dynamics_figure, model_figure, model_panels, panels, particle_figure, smooth_panels,
                            trade_panel)
from drover.archive import Run, command_of
from drover.error import DroverError, status_of
from drover.figures.paper import STYLE, add_axes, bar_box, fitted, new_figure, require_frame, write_title_and_caption
from drover.figures.theory_figures import draw_theory
from drover.particles import ParticleRun
from drover.roles import has_own_fields, maps_of
from drover.hdf5_reader import state_of
from drover.text import drawable, printable, scene_name
from drover.theory import open_any

WATCH_EVERY = 0.5  # s
# Boxes of panels by shape of the cell: left, bottom, width, height in inches; the map is fitted into its box.
SQUARE = {"map": (0.8, 3.2, 3.75, 3.75), "structure": (6.4, 3.2, 2.1, 3.75), "numbers": (9.3, 4.95, 2.1, 2.0),
          "exponents": (9.3, 3.2, 2.1, 1.4), "order": (0.8, 1.2, 10.6, 1.1)}
WIDE = {"map": (0.8, 5.3, 9.5, 1.65), "structure": (0.9, 1.25, 2.8, 2.95), "numbers": (4.6, 2.75, 2.8, 1.45),
        "exponents": (4.6, 1.25, 2.8, 1.15), "order": (8.4, 1.25, 3.0, 2.95)}
TALL = {**SQUARE, "map": (0.8, 1.6, 3.3, 5.35), "order": (6.35, 1.2, 5.05, 1.1)}
WIDE_FROM, TALL_FROM = 2.0, 0.62  # ratio of the sides of the cell, x to y
TITLES = {"map": "(a) {}", "structure": "(b) structure factors",
          "numbers": "(c) number fluctuations", "exponents": "(d) local exponent of (c)",
          "order": "(e) order of the cell"}
# Parts of the height that a flat map leaves: by how much panels below a wide one move up, and grow.
STRETCH = {"profiles": (0.0, 1.0), "structure": (0.0, 1.0), "numbers": (0.45, 0.55), "exponents": (0.0, 0.45)}
# Of runs without noise, which have no fluctuations: boxes of panels by shape of the cell, and titles.
SMOOTH_BOXES = {"profiles": (6.55, 5.3, 4.85, 1.65), "growth": (6.55, 3.2, 2.0, 1.35), "length": (9.4, 3.2, 2.0, 1.35)}
SMOOTH_WIDE = {"profiles": (0.8, 3.05, 9.5, 1.25), "growth": (0.9, 1.25, 2.8, 1.0), "length": (4.6, 1.25, 2.8, 1.0),
               "order": (8.4, 1.25, 3.0, 1.0)}
# Of runs without order, such as of beads alone: the panels below have its place.
DISORDERED_BOXES = {"map": (0.8, 2.9, 4.05, 4.05), "profiles": (6.55, 4.4, 4.85, 2.55),
                    "growth": (6.55, 1.45, 1.9, 2.1), "length": (9.5, 1.45, 1.9, 2.1)}
DISORDERED_WIDE = {**SMOOTH_WIDE, "growth": (0.9, 1.25, 4.3, 1.0), "length": (6.7, 1.25, 4.3, 1.0)}
SMOOTH_TITLES = {"map": "(a) {}", "profiles": "(b) along $x$ through the middle", "growth": "(c) deviations",
                 "length": "(d) length of the pattern", "order": "(e) order of the cell"}


def draw(run, frame=-1):
    """Draws a run as a matplotlib Figure.  Raises DroverError if there is no such frame."""
    if has_own_fields(run):
        return model_figure.draw(run, frame)
    require_frame(run, frame)
    ratio = run.scene["grid"]["lx"] / run.scene["grid"]["ly"]
    one_row = run.scene["grid"]["ny"] == 1
    is_wide = one_row or ratio > WIDE_FROM
    layout = WIDE if is_wide else TALL if ratio < TALL_FROM else SQUARE
    smooth = smooth_panels.is_smooth(run)
    if smooth:
        layout = {"map": layout["map"], "order": layout["order"],
                  **(SMOOTH_WIDE if is_wide else SMOOTH_BOXES)}
        if not model_panels.has_order(run):
            layout.update(DISORDERED_WIDE if is_wide else DISORDERED_BOXES if layout["map"] is SQUARE["map"] else {})
            del layout["order"]
    with matplotlib.rc_context(STYLE):
        figure = new_figure()
        boxes = {**layout, "map": layout["map"] if one_row else fitted(layout["map"], ratio)}
        if is_wide and not one_row:
            boxes = stretched(boxes, layout["map"][3] - boxes["map"][3], smooth)
        axes = {name: add_axes(figure, box) for name, box in boxes.items()}
        bar = None if one_row else add_axes(figure, bar_box(boxes["map"]))
        blocks = model_panels.draw_map_with_arrows(axes["map"], bar, run, frame)
        drawn = [] if smooth else model_panels.draw_structure_with_keys(axes["structure"], run)
        dotted = ""
        if smooth:
            dotted = smooth_panels.draw_profiles(axes["profiles"], run)
            smooth_panels.draw_growth(axes["growth"], run)
            smooth_panels.draw_length(axes["length"], run)
        else:
            drawn += panels.draw_numbers(axes["numbers"], axes["exponents"], run)
        if "order" in axes:
            model_panels.draw_order(axes["order"], run)
        map_title = model_panels.map_title(run, frame)
        for name, words in (SMOOTH_TITLES if smooth else TITLES).items():
            if name in axes:
                axes[name].set_title(words.format(map_title), loc="left")
        write_title_and_caption(figure, title(run, frame), smooth_caption(run, dotted, blocks) if smooth else
                                caption(run, drawn, blocks))
    return figure


def stretched(boxes, height, smooth):
    """Boxes of a wide layout whose map has left some height to the panels below."""
    stretch = STRETCH if smooth else {**STRETCH, "order": (0.0, 1.0)}
    moved = {name: (left, bottom + stretch[name][0] * height, width, tall + stretch[name][1] * height)
             for name, (left, bottom, width, tall) in boxes.items() if name in stretch}
    return {**boxes, **moved}


def draw_file(path, frame=None, state=None, dynamics=None):
    """Draws an archive of any kind; `frame` applies to runs and states, `state` to archives of drover stability, and
    `dynamics`, a field whose S(q, omega) is drawn, to runs of fields."""
    if Path(path).suffix == ".json":
        if (frame, state, dynamics) != (None, None, None):
            raise DroverError(f"{path}: --frame, --state and --dynamics do not apply to a trade-off: omit them")
        return trade_panel.draw(path)
    with open_any(path) as opened:
        return draw_opened(opened, {"--frame": frame, "--state": state, "--dynamics": dynamics})


def draw_opened(opened, options):
    """Draws an open run or a Theory with these options, of which it rejects those that do not apply."""
    kind = "run" if isinstance(opened, (Run, ParticleRun)) else opened.kind
    frame, state, dynamics = options.values()
    for (option, value), its_kinds in zip(options.items(), (("run", "states"), ("stability",), ("run",))):
        if value is not None and kind not in its_kinds:
            raise DroverError(f"{opened.path}: {option} {value} does not apply, since drover {command_of(kind)} wrote "
                              f"this archive; only archives of drover {' and '.join(its_kinds)} have one: omit the "
                              "option")
    if dynamics is not None:
        if frame is not None:
            raise DroverError("--frame does not apply to --dynamics, which is of many frames: omit one of them")
        return dynamics_figure.draw(opened, dynamics)
    if kind == "run":
        its_draw = particle_figure.draw if isinstance(opened, ParticleRun) else draw
        return its_draw(opened, -1 if frame is None else frame)
    return draw_theory(opened, state, frame)


def title(run, frame):
    grid, time = run.scene["grid"], float(run.frames["time"][frame])
    seed = drawable(run.attributes.get("seed", "?"))
    return (f"{scene_name(run)} at {panels.time_text(f'{time:g}', run)}   ({grid['nx']} × {grid['ny']} points, "
            f"{grid['lx']:g} × {grid['ly']:g}{panels.length_text(run)}, seed {seed})")


def negative_words(run):
    """Says why a density is below 0, where a map shows that."""
    role = maps_of(run)[0][0]
    if role.spin or float(panels.shown_means(run.frames[role.name].isel(time=-1))[0].min()) >= 0.0:
        return ""
    return " (a density of few particles, linear in its equations, may be below 0)"


def block_words(run, blocks):
    """What the colours and arrows of a map are averages over."""
    unit = panels.length_text(run)
    pixel, arrow = (side and f"{side[0]:.3g} × {side[1]:.3g}{unit}" for side in blocks)
    colours = "the field itself" if panels.is_resolved(run, blocks[0]) else f"averages over {pixel}"
    return f"Colours are {colours}, " + (f"arrows over {arrow}" if arrow else "lines follow the flow")


def smooth_caption(run, dotted, blocks):
    """Explains the figure of a run without noise."""
    words = [] if blocks is None else [f"(a) {block_words(run, blocks)}."]
    words.append(f"(b) Dotted: {dotted}. " * bool(dotted) + "(c) Standard deviations over the cell; those of densities "
                 "are relative to their means. (d) 2π over the mean wavenumber of the spectrum of the order, or of a "
                 "density where there is none.")
    if run.summary is None:
        words.append(f"{results.without_means(run)}.")
    words.append("Without noise there are no fluctuations to compare with linear theory.")
    return " ".join(words)


def caption(run, drawn, blocks):
    """Explains the figure to a reader.  Without blocks panel (a) is a profile."""
    has_numbers = results.number_fluctuations(run) is not None
    boxes = ("(c) segments of the line; (d) between each segment and the next longer one" if blocks is None else
             "(c) boxes with equal numbers of grid cells along x and y; (d) between each box and the next larger one")
    words = [*([f"(a) {block_words(run, blocks)}{negative_words(run)}"] if blocks is not None else []),
             *([boxes] if has_numbers else [])]
    words = ["; ".join(words) + "."] if words else []
    if run.summary is None:
        words.append(f"{results.without_means(run)}: points are means over all samples so far, including the warm-up, "
                     "without errors and theory.")
    elif drawn:
        words.append("Points are time means after the warm-up with standard errors"
                     + ("." if all(numpy.isfinite(result.error).all() for result in drawn)
                        else "; open symbols: the run is too short for an error estimate."))
        words.append("Lines: exact linear theory for the same grid, shells and boxes."
                     if any(result.has_linear for result in drawn)
                     else "There is no linear theory for this scene, since it has no stationary state.")
    return " ".join(words)


def write(figure, path):
    """Writes the complete figure or nothing."""
    kind = path.suffix.lstrip(".").lower()
    if kind not in ("png", "pdf", "svg"):
        raise DroverError(f'{path}: the extension "{path.suffix}" is not supported; expected .png, .pdf '
                          "or .svg")
    picture = io.BytesIO()
    figure.savefig(picture, format=kind)
    try:
        new_file.write(path, picture.getvalue())
    except OSError as error:
        raise DroverError(f"{path} cannot be written ({error.strerror}); choose another path with --output") from error


def watch(path):
    """Shows the figure of a run in a window, redrawn when the run has written more, until the window is closed."""
    screen, shown = live.screen(), None
    while screen.is_open:
        now = state_of(path)
        if now != shown:
            screen.show(draw_file(path))
            shown = now
        screen.wait(WATCH_EVERY)


def main(arguments=None):
    parser = argparse.ArgumentParser(prog="python3 -P -m drover.figure", description="Draws a figure of an archive: a "
                                     "run, the "
                                     "stability of a scene, its phase boundaries, or the flocking threshold predicted "
                                     "by a table.")
    parser.add_argument("archive", type=Path, help="file written by drover run, stability or boundary, such as "
                                                   "isotropic.h5, tradeoff.json of a study, or table.nc of a sweep")
    parser.add_argument("-o", "--output", type=Path,
                        help="figure file (.png, .pdf or .svg); default: the name of the archive with .png")
    parser.add_argument("--frame", type=int, help="for runs and states: number of the frame or state from 0; -1, the "
                        "default for runs, is the last")
    parser.add_argument("--state", help="for drover stability: the uniform state, such as isotropic; default: the most "
                        "ordered one")
    parser.add_argument("--dynamics", metavar="FIELD", help="for runs of fields: draw S(q, omega) of this field, such "
                        "as a density, measured in the frames and of linear theory")
    parser.add_argument("--watch", action="store_true", help="show the figure in a window and redraw it while the run "
                        "writes the file; writes nothing")
    options = parser.parse_args(arguments)
    output = options.output or options.archive.with_suffix(".png")

    def act():
        if options.watch:
            watch(options.archive)
            return
        write(draw_file(options.archive, options.frame, options.state, options.dynamics), output)
        print(printable(output))
    return status_of(act)


if __name__ == "__main__":
    sys.exit(main())
