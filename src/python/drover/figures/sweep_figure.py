"""drover/figures/sweep_figure.py: the figure of the dataset of a sweep: an observable over the varied keys, and a
spectrum."""
from types import SimpleNamespace

import matplotlib

from drover.error import DroverError
from drover.fields import fields_of
from drover.figures.paper import STYLE, add_axes, bar_box, new_figure, write_title_and_caption
from drover.figures.sweep_panels import draw_sweep, own_axes
from drover.sweeping import dataset_of
from drover.text import drawable, scene_name

PREFERRED = ("nematic_order", "size_mean_", "variance_")  # by the beginnings of names, after vectors
LEFT, RIGHT = (0.9, 1.6, 4.3, 5.2), (7.0, 1.6, 3.4, 5.2)  # boxes of the panels [inches]
ALONE = (0.9, 1.6, 8.8, 5.2)


def chosen(sweep, count):
    """The first preferred observable with so many axes of its own; None if there is none."""
    names = [str(name) for name in sweep.data if f"{name}_error" in sweep.data and "seed" not in sweep.data[name].dims
             and len(own_axes(sweep, name)) == count]
    if count:
        spectra = [name for name in names if name.startswith("structure_factor")]
        return min(spectra, key=lambda name: name.endswith("cross"), default=None)
    vectors = [field.name or field.symbol for field in fields_of(sweep.values) if field.spin]
    best = [name for start in (*vectors, *PREFERRED) for name in names if name.startswith(start)]
    return next(iter([*best, *names]), None)


def draw(table):
    """Draws a table.nc, as open_any() opens it.  Raises DroverError for other than one or two keys."""
    keys = [text.partition("=")[0].strip() for text in table.scene["sweep"]["vary"]]
    sweep = SimpleNamespace(data=dataset_of(table.path, keys), keys=keys, values=table.scene)
    first, second = chosen(sweep, 0), chosen(sweep, 1) if len(sweep.keys) == 1 else None
    if first is None or not 1 <= len(sweep.keys) <= 2:
        raise DroverError(f"{table.path}: a sweep over {len(sweep.keys)} keys; expected one or two and an observable: "
                          "draw an array of it by .plot()")
    with matplotlib.rc_context(STYLE):
        figure = new_figure()
        box = ALONE if second is None else LEFT
        axes = add_axes(figure, box)
        draw_sweep(sweep, first, axes, add_axes(figure, bar_box(box)) if len(sweep.keys) == 2 else None)
        axes.set_title(f"(a) {first.replace('_', ' ')}", loc="left")
        words = "Points are means with standard errors; open: no error estimate." if len(sweep.keys) == 1 else \
            "Colours are means over the seeds" + (", linear between the points that were run."
                                                  if "point" in sweep.data[first].dims else ".")
        if second is not None:
            axes = add_axes(figure, RIGHT)
            draw_sweep(sweep, second, axes, add_axes(figure, bar_box(RIGHT)))
            axes.set_title(f"(b) {second.replace('_', ' ')}", loc="left")
            words += f" (b) A line for each value of {sweep.keys[0]}."
        if any(panel.get_title(loc="right") for panel in figure.axes):
            words += " Of a ramp, the branch that a panel names is shown alone."
        write_title_and_caption(figure, f"{scene_name(table)}: a sweep over {' and '.join(map(drawable, sweep.keys))}",
                                f"{words} Other observables: drover.sweep(...).plot(name), or xarray.open_dataset.")
    return figure
