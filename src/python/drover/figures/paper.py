"""drover/figures/paper.py: common layout of figures: style, size, axes in inches, title and caption."""
import io
import textwrap

from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from drover.error import DroverError

STYLE = {"font.size": 9, "axes.titlesize": 10, "axes.labelsize": 9.5, "legend.fontsize": 8.5, "legend.framealpha": 0.85,
         "axes.spines.top": False, "axes.spines.right": False, "figure.dpi": 200, "text.usetex": False}
SIZE = (11.6, 7.7)  # inches
PAGE_FROM = 6.0     # inches: narrower figures are of one column


class Shown(Figure):
    """A figure that a notebook shows, also before pyplot is used."""

    def _repr_png_(self):
        picture = io.BytesIO()
        self.savefig(picture, format="png", dpi=100 if self.get_figwidth() > PAGE_FROM else 200)
        return picture.getvalue()


def require_frame(run, frame):
    """Raises DroverError if a run has no such frame."""
    frames = run.frames.sizes["time"]
    if not -frames <= frame < frames:
        raise DroverError(f"{run.path}: has no frame {frame}; expected 0 to {frames - 1}, or a negative number counted "
                          "from the end")


def new_figure(size=SIZE):
    figure = Shown(figsize=size)
    FigureCanvasAgg(figure)
    return figure


def add_axes(figure, box):
    """Adds axes in a box: left, bottom, width, height in inches."""
    left, bottom, width, height = box
    page = figure.get_size_inches()
    return figure.add_axes((left / page[0], bottom / page[1], width / page[0], height / page[1]))


def bar_box(box):
    """Box of the colour bar to the right of a box."""
    left, bottom, width, height = box
    tall = max(height, 1.1)
    return left + width + 0.1, bottom + height - tall, 0.14, tall


def fitted(box, ratio):
    """The largest box with this aspect ratio inside a box, at its upper left."""
    left, bottom, width, height = box
    fitted_width = min(width, height * ratio)
    return left, bottom + height - fitted_width / ratio, fitted_width, fitted_width / ratio


def write_title_and_caption(figure, title, caption):
    """A title that would cross the edge of the page becomes smaller."""
    written = figure.text(0.8 / SIZE[0], 1.0 - 0.32 / SIZE[1], title, fontsize=12, va="center")
    page, extent = figure.bbox.x1, written.get_window_extent(figure.canvas.get_renderer())
    written.set_fontsize(12.0 * min(1.0, 0.99 * (page - extent.x0) / extent.width))
    figure.text(0.8 / SIZE[0], 0.66 / SIZE[1], "\n".join(textwrap.wrap(caption, 172)), fontsize=8.5, va="top",
                linespacing=1.3)
