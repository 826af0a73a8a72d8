"""tests/app/pictures.py: checks of figures: colours that occur, parts that overlap."""
import itertools

import numpy
from matplotlib.legend import Legend
from matplotlib.quiver import QuiverKey
from matplotlib.text import Text


def share_of(picture, colour):
    wanted = numpy.array([int(colour[i:i + 2], 16) / 255 for i in (1, 3, 5)])
    return (abs(picture[:, :, :3] - wanted).max(axis=2) < 0.02).mean()


def pieces(axes, renderer):
    """The area that a panel covers: its frame, its axes with their labels, and its texts."""
    texts = [child for child in axes.get_children() if isinstance(child, Text) and child.get_text()]
    texts += [child.text for child in axes.get_children() if isinstance(child, QuiverKey)]
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
