"""drover/figures/particle_figure.py: figure of a particle run: bodies from above, and panels by what the scene
shows."""
from functools import partial

import matplotlib

from .. import results
from . import particle_motion as motion, particle_panels as panels
from drover.figures.paper import STYLE, add_axes, new_figure, require_frame, write_title_and_caption
from drover.particles import sides_of
from drover.text import drawable, scene_name

MAP, WHEEL, BESIDE = (0.7, 1.15, 6.3, 5.85), (7.55, 5.15, 1.75, 1.75), (7.45, 5.5, 1.05, 1.05)  # inches
WAKE, BAR = (9.4, 5.45, 1.25, 1.25), (10.75, 5.45, 0.1, 1.25)
SERIES = ((7.95, 3.35, 3.4, 1.3), (7.95, 1.25, 3.4, 1.3))
TALL_SERIES = ((7.95, 4.65, 3.4, 2.3), (7.95, 1.25, 3.4, 2.3))  # without a colour wheel
TITLE_AT = 0.016  # of the width of the map: above the edge of the cell
FLOW = ("bead_velocity_order", "bead_velocity_size", "energy_kinetic")  # the first available is drawn


@matplotlib.rc_context(STYLE)
def draw(run, frame=-1):
    """Draws a frame as a matplotlib Figure.  Raises DroverError if there is no such frame."""
    require_frame(run, frame)
    figure = new_figure()
    axes = add_axes(figure, MAP)
    about = draw_map(axes, run, frame)
    axes.set_title("(a) " + " and ".join(f"{name}{'s' * (count(run, name) > 1)}" for name in ("rod", "bead")
                                      if count(run, name)), loc="left", x=TITLE_AT)
    has_wake = run.summary is not None and "flow_velocity_along" in run.summary
    if count(run, "rod"):
        box = BESIDE if has_wake else WHEEL
        panels.draw_wheel(figure, tuple(part / side for part, side in zip(box, (*figure.get_size_inches(),) * 2)))
    if has_wake:
        wake = add_axes(figure, WAKE)
        motion.draw_wake(wake, run, add_axes(figure, BAR))
        wake.set_title("(b) beads around a rod", loc="left")
    boxes = SERIES if count(run, "rod") else TALL_SERIES
    for letter, (words, its_draw), box in zip("cd" if has_wake else "bc", chosen(run, frame), boxes):
        panel = add_axes(figure, box)
        its_draw(panel)
        panel.set_title(f"({letter}) {words}", loc="left")
    write_title_and_caption(figure, title(run, frame), caption(run, about))
    return figure


def draw_map(axes, run, frame):
    """Draws the cell from above, with paths or the flow; returns what the caption says of it."""
    sides, view, about = sides_of(run), None, []
    rods, beads, periodic = count(run, "rod"), count(run, "bead"), panels.is_periodic(run)
    if rods and (rods <= motion.FEW_RODS or not beads):
        places = motion.paths(run, frame, sides)
        view = motion.view_in(run, places, sides)
        motion.draw_paths(axes, run, places, frame, sides, periodic and view is None)
        about += ["Lines are paths of rods."] * (len(places) > 1)
    shown = panels.draw_cell(axes, run, sides, view)
    panels.draw_beads(axes, run, frame, sides)
    panels.draw_rods(axes, run, frame, sides, periodic and view is None)
    if beads and rods > motion.FEW_RODS:
        drawn = motion.draw_flow(axes, run, frame, sides)
        about += ["Arrows are displacements of beads in {:.3g} s, divided by this time and averaged over about {:.0f} "
                  "of them.".format(*drawn)] if drawn else []
    panels.draw_scale(axes, shown)
    if view is not None:
        about.append("The periodic cell is larger than what is shown.")
    else:
        about.append("Dashed line: edge of the periodic cell." if periodic else "Black line: side wall.")
    return about


def chosen(run, frame):
    """The two panels below the colour wheel, by what the run is about: titles, and functions of the axes."""
    now, found = float(run.frames["time"][frame]), run.observables
    is_path, flow = run.frames.sizes["time"] > 2, next((name for name in FLOW if name in found), None)
    if not count(run, "rod"):
        first = "temperatures of the beads", partial(motion.draw_temperatures, run=run, now=now)
    elif "polar_order_local" in found:
        first = "polar order about the centre", partial(motion.draw_several, run=run, now=now, label="order", names={
            "polar_order_local": "size", "polar_order_azimuthal": "azimuthal"})
    elif count(run, "rod") == 1 and is_path:
        first = "velocity of the rod along its axis", partial(motion.draw_speed, run=run, now=now)
    else:
        first = "polar order", partial(panels.draw_series, run=run, name="polar_order", now=now)
    if not count(run, "rod") and "pair_correlation_beads" in found:
        return first, ("pair correlation of the beads", partial(motion.draw_pairs, run=run))
    if is_path and count(run, "rod") and (count(run, "rod") <= motion.FEW_RODS or not count(run, "bead")):
        return first, ("memory of the direction", partial(motion.draw_memory, run=run))
    return first, (panels.words_of(flow), partial(panels.draw_series, run=run, name=flow, now=now))


def count(run, body):
    return run.frames.sizes.get(body, 0)


def title(run, frame):
    counts = " and ".join(f"{count(run, name)} {name}{'s' * (count(run, name) > 1)}" for name in ("bead", "rod")
                          if count(run, name))
    seed = drawable(run.attributes.get("seed", "?"))
    return f"{scene_name(run)} at $t$ = {float(run.frames['time'][frame]):g} s   ({counts}, seed {seed})"


def caption(run, about):
    """Explains the figure to a reader."""
    words = []
    if count(run, "rod"):
        words.append("(a) Rods, seen from above, are drawn as the smooth hull of their spheres, coloured by the "
                     "direction from tail to head (colour wheel).")
    if count(run, "bead"):
        words.append("Beads are grey.")
    words += about
    if run.summary is None:
        words.append(f"{results.without_means(run)}: there are no means.")
    elif "flow_velocity_along" in run.summary:
        words.append("(b) Mean velocity of the beads in the frame of a rod, which points to the right; colours show "
                     "its component along the rod.")
    if run.summary is not None and float(run.summary.get("warm_up", 0.0)) > 0.0:
        words.append("Grey times: warm-up, left out of means.")
    return " ".join(words)
