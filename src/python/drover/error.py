"""drover/error.py: the one exception of the package, and what its programs make of it."""
import sys

from drover.text import printable


class Error(Exception):
    """Invalid input, or a failure.  The message is one sentence: place, finding, remedy.

    >>> Error("grid.nx = 7; expected an even number", "flock.toml:3:1").place
    'flock.toml:3:1'
    """

    def __init__(self, message, place="", fault="input"):
        super().__init__(f"{place}: {message}" if place else message)
        self.place = place    # "flock.toml:3:1", "--set grid.nx=7"; "" if there is none
        # "input"; "unavailable": a file that may not be used, a machine too small; "run": a run that its scene makes
        # fail; "environment": the disk, memory, limits, a signal; "defect" of drover
        self.fault = fault
        self.finding, _, self.remedy = message.partition("; ")


class ArgumentError(Error, ValueError):
    """An argument with a value that is not allowed."""


def require_scene(scene):
    """Raises Error for anything else than a scene, whose module this one cannot import."""
    if not hasattr(scene, "to_toml"):
        raise Error(f"the scene is {scene!r}; expected a drover.Scene, such as Scene.load(\"flock.toml\")")


def status_of(action):
    """The exit status of a program that takes `action`: 0; else 2 for invalid input and 1 for a failed run or disk,
    with a sentence on standard error.
    """
    try:
        action()
    except Error as error:
        print(printable(f"error: {error}"), file=sys.stderr)
        return 2 if error.fault in ("input", "unavailable") else 1
    except OSError as error:
        print(printable(f"error: {error}; check the folder and the disk"), file=sys.stderr)
        return 1
    return 0


DroverError = Error  # its name in the modules that read archives
