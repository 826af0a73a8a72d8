"""drover/series_statistics.py: means of correlated series with errors from blocks, as in the summary of a run."""
import math

from drover import _drover


def mean_and_error(values):
    """Mean of equidistant samples and its standard error.

    The error is NaN (not available) for fewer than eight blocks of ten autocorrelation times.
    """
    mean, error, _ = _drover.mean_of(values, 1.0, 0)
    return mean, math.nan if error is None else error
