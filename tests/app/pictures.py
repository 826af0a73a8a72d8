"""tests/app/pictures.py: checks of figures: colours that occur, parts that overlap."""
import itertools

import numpy
from matplotlib.path import Path
from matplotlib.legend import Legend
from matplotlib.text import Text


def share_of(picture, colour):
    wanted = numpy.array([int(colour[i:i + 2], 16) / 255 for i in (1, 3, 5)])
    return (abs(picture[:, :, :3] - wanted).max(axis=2) < 0.02).mean()


def pieces(axes, renderer):
    """The area that a panel covers: its frame, its axes with their labels, and its texts."""
    texts = [child for child in axes.get_children() if isinstance(child, Text) and child.get_text()]
    boxes = [axis.get_tightbbox(renderer) for axis in (axes.xaxis, axes.yaxis)]
    boxes += [text.get_window_extent(renderer) for text in texts]
    return [axes.get_window_extent(renderer), *(box for box in boxes if box is not None)]


def overlaps(picture):
    """Parts (panel, title, caption or legend) that overlap another part or cross the edge of the figure."""
    picture.canvas.draw()
    renderer = picture.canvas.get_renderer()
    parts = [pieces(axes, renderer) for axes in picture.axes]
    alone = [child for child in picture.get_children() if isinstance(child, (Text, Legend))]
    parts += [[child.get_window_extent(renderer)] for child in alone]
    beyond = [box for box in itertools.chain(*parts)
              if box.x0 < 0 or box.y0 < 0 or box.x1 > picture.bbox.x1 or box.y1 > picture.bbox.y1]
    pairs = (pair for these, those in itertools.combinations(parts, 2) for pair in itertools.product(these, those))
    return beyond + [pair for pair in pairs if pair[0].overlaps(pair[1])]


def covered(picture):
    """Curves and points that pass below the legend of their panel; lines across a panel (axhline) may."""
    picture.canvas.draw()
    renderer = picture.canvas.get_renderer()
    found = []
    for axes in picture.axes:
        box = None if axes.get_legend() is None else axes.get_legend().get_window_extent(renderer)
        for line in axes.lines if box is not None else []:
            data = numpy.asarray(line.get_xydata(), dtype=float)
            if line.get_transform() != axes.transData or len(data) == 0:
                continue
            places = axes.transData.transform(data)
            places = places[numpy.isfinite(places).all(axis=1)]
            is_curve = line.get_linestyle() not in ("None", ":") and len(places) > 1
            if is_curve and Path(places).intersects_bbox(box, filled=False):
                found.append((axes.get_title(loc="left"), line.get_label()))
            elif line.get_marker() not in ("", "None", None) and any(box.contains(*place) for place in places):
                found.append((axes.get_title(loc="left"), line.get_label()))
    return found


def odd_ticks(picture):
    """Axes whose tick labels an offset completes, or mix plain numbers with powers of ten; or with fewer than two."""
    picture.canvas.draw()
    found = []
    for axes in picture.axes:
        for axis in (axes.xaxis, axes.yaxis) if axes.axison and axes.get_visible() else ():
            low, high = sorted(axis.get_view_interval())
            texts = [tick.label1.get_text() for tick in [*axis.get_major_ticks(), *axis.get_minor_ticks()]
                     if low <= tick.get_loc() <= high and (tick.label1.get_visible() or tick.label2.get_visible())]
            texts = [text for text in texts if text]
            powers = sum("10^" in text for text in texts)
            if axis.get_offset_text().get_text() or 0 < powers < len(texts) or (
                    axis.get_scale() == "log" and high > 10.0 * low and len(texts) < 2):
                found.append((axes.get_title(loc="left") or axes.get_ylabel(), texts))
    return found


def unlabelled(picture):
    """Panels with curves and without labels; number fluctuations share the x axis of the panel below them."""
    return [axes.get_title(loc="left") for axes in picture.axes if axes.lines and axes.axison
            and not (axes.get_ylabel() and (axes.get_xlabel() or "number fluctuations" in axes.get_title(loc="left")))]
