"""drover/error.py: the one exception of the package."""


class Error(Exception):
    """Invalid input, or a failed run.  The message is one sentence: place, finding, remedy.

    >>> Error("grid.nx = 7; expected an even number", "flock.toml:3:1").place
    'flock.toml:3:1'
    """

    def __init__(self, message, place="", fault="input"):
        super().__init__(f"{place}: {message}" if place else message)
        self.place = place    # "flock.toml:3:1", "--set grid.nx=7"; "" if there is none
        self.fault = fault    # "input", or "run" for a run that failed
        self.finding, _, self.remedy = message.partition("; ")


DroverError = Error  # its name in the modules that read archives
