"""drover/particle_figure.py: figure of a particle run: rods coloured by direction, beads, two time series."""
import matplotlib
import numpy

from drover import particle_panels as panels
from drover.error import DroverError
from drover.paper import STYLE, add_axes, new_figure, write_title_and_caption
from drover.particles import sides_of

MAP, WHEEL = (0.7, 1.15, 6.3, 5.85), (7.55, 5.15, 1.75, 1.75)  # inches
SERIES = ((7.95, 3.25, 3.4, 1.35), (7.95, 1.25, 3.4, 1.35))
# The first series is the polar order, the second the first available of these.
FIRST, SECOND = "polar_order", ("bead_velocity_order", "bead_velocity_size", "energy_kinetic")


@matplotlib.rc_context(STYLE)
def draw(run, frame=-1):
    """Draws a frame as a matplotlib Figure.  Raises DroverError if there is no such frame."""
    frames = run.frames.sizes["time"]
    if not -frames <= frame < frames:
        raise DroverError(f"{run.path}: has no frame {frame}; expected 0 to {frames - 1}, or a negative number counted "
                          "from the end")
    figure = new_figure()
    axes = add_axes(figure, MAP)
    sides = sides_of(run)
    panels.draw_cell(axes, run, sides)
    has_beads, has_rods = panels.draw_beads(axes, run, frame, sides), panels.draw_rods(axes, run, frame, sides)
    panels.draw_scale(axes, sides)
    axes.set_title("(a) " + " and ".join(name for name, there in (("rods", has_rods), ("beads", has_beads)) if there),
                   loc="left")
    if has_rods:
        panels.draw_wheel(figure, tuple(part / side for part, side in zip(WHEEL, (*figure.get_size_inches(),) * 2)))
    chosen = [name for name in (FIRST, next((name for name in SECOND if name in run.observables), None))
              if name in run.observables]
    for letter, name, box in zip("bc", chosen, SERIES):
        panel = add_axes(figure, box)
        panels.draw_series(panel, run, name, float(run.frames["time"][frame]))
        panel.set_title(f"({letter}) {panels.words_of(name)}", loc="left")
    write_title_and_caption(figure, title(run, frame), caption(run, has_beads, has_rods))
    return figure


def title(run, frame):
    counts = " and ".join(f"{run.frames.sizes[name]} {name}s" for name in ("bead", "rod") if name in run.frames.sizes)
    name, seed = (run.attributes.get(key, "?") for key in ("scene_file", "seed"))
    return f"{name} at $t$ = {float(run.frames['time'][frame]):g} s   ({counts}, seed {seed})"


def caption(run, has_beads, has_rods):
    """Explains the figure to a reader."""
    words = []
    if has_rods:
        words.append("(a) Rods, seen from above, are drawn as the smooth hull of their spheres, coloured by the "
                     "direction from "
                     "tail to head (colour wheel).")
    if has_beads:
        words.append("Beads are grey.")
    words.append({"periodic": "Dashed line: edge of the periodic cell."}.get(
        run.scene["cell"].get("shape", "periodic"), "Black line: side wall."))
    if run.summary is None:
        words.append("The run is not finished: there are no means yet.")
    return " ".join(words)
