"""drover/live.py: figures that are redrawn while a run goes on: in a notebook in place, otherwise in a window."""
import io
import sys

import numpy

from drover.error import Error


def screen():
    """Where to show figures: a Notebook or a Window.  Raises Error where there is neither."""
    shell = sys.modules.get("IPython") and sys.modules["IPython"].get_ipython()
    if shell is not None and getattr(shell, "kernel", None) is not None:
        return Notebook()
    from matplotlib import pyplot, rcsetup
    if pyplot.get_backend().lower() not in {name.lower() for name in rcsetup.interactive_bk}:
        raise Error(f"matplotlib has no window here (its backend is {pyplot.get_backend()}); use a notebook or a "
                    "desktop, or make a film: drover.film")
    return Window()


class Notebook:
    """The output of a cell, which is replaced."""

    is_open = True

    def __init__(self):
        self.handle = None

    def show(self, figure):
        from IPython.display import display
        if self.handle is None:
            self.handle = display(figure, display_id=True)
        else:
            self.handle.update(figure)


class Window:
    """A window of matplotlib that shows pictures of figures."""

    def __init__(self):
        from matplotlib import pyplot
        self.pyplot, self.figure, self.image = pyplot, None, None

    @property
    def is_open(self):
        return self.figure is None or self.pyplot.fignum_exists(self.figure.number)

    def show(self, figure):
        stream = io.BytesIO()
        figure.savefig(stream, format="rgba", dpi=100)
        width, height = (round(100 * side) for side in figure.get_size_inches())
        picture = numpy.frombuffer(stream.getvalue(), numpy.uint8).reshape(height, width, 4)
        if self.figure is None:
            self.figure = self.pyplot.figure(figsize=figure.get_size_inches(), num="drover")
            self.image = self.figure.figimage(picture)
            self.pyplot.show(block=False)
        self.image.set_data(picture)
        self.wait(0.01)

    def wait(self, seconds):
        """Lets the window handle its events."""
        self.figure.canvas.draw_idle()
        self.figure.canvas.start_event_loop(seconds)
