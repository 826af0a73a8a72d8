"""drover/error.py: the one exception of the package."""


class DroverError(Exception):
    """What is wrong with what was given, as one sentence that says where, what was found and what to do."""
