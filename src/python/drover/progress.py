"""drover/progress.py: one live line of progress, on a terminal or in a notebook."""
import sys
import time

from .text import duration

DELAY, PERIOD = 2.0, 0.5  # s before the first line and between lines
WIDTH = 30


class Progress:
    """Shows how far a run is; `shown` None: where somebody watches, after two seconds."""

    def __init__(self, first, last, shown=None):
        self.first, self.last = first, max(last, first + 1)
        watched = sys.stderr is not None and (sys.stderr.isatty() or "ipykernel" in sys.modules)
        self.is_shown = watched if shown is None else shown
        self.start = time.monotonic()
        self.next = self.start + (DELAY if shown is None else 0.0)
        self.is_open = False

    def report(self, step, text):
        now = time.monotonic()
        if not self.is_shown or now < self.next:
            return
        self.next, self.is_open = now + PERIOD, True
        part = min(1.0, (step - self.first) / (self.last - self.first))
        left = (now - self.start) * (1.0 / part - 1.0) if part > 0.0 else float("inf")
        bar = "#" * int(WIDTH * part)
        print(f"\r[{bar:<{WIDTH}}] {100 * part:3.0f} %  {text}  {duration(left)} left ", end="",
              file=sys.stderr, flush=True)

    def close(self):
        if self.is_open:
            print(file=sys.stderr)
        self.is_open = False
