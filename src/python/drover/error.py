"""drover/error.py: the one exception of the package."""


class DroverError(Exception):
    """Invalid input.  The message is one sentence: location, value found, remedy."""
