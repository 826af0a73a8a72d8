"""drover/blocks.py: means of correlated series with errors from blocks, as in the summary of a run."""
import numpy

WINDOW_PER_TIME = 5.0        # window of the autocorrelation sum, in autocorrelation times
TIMES_PER_BLOCK = 10.0       # autocorrelation times
MIN_BLOCKS, MAX_BLOCKS = 8, 64
ROUNDING_SPREAD = 1e-12      # relative to the largest value: a smaller spread counts as constant


def mean_and_error(values):
    """Mean of equidistant samples and its standard error.

    The error is NaN (not available) for fewer than eight blocks of ten autocorrelation times.
    """
    values = numpy.asarray(values, dtype=float)
    if len(values) == 0 or not numpy.isfinite(values).all():
        return numpy.nan, numpy.nan
    if len(values) > 1 and is_constant(values):
        return float(values.mean()), 0.0
    time = autocorrelation_time(values)
    blocks = int(min(len(values) / (TIMES_PER_BLOCK * time), MAX_BLOCKS))
    if blocks < MIN_BLOCKS:
        return float(values.mean()), numpy.nan
    length = len(values) // blocks
    means = values[len(values) - blocks * length:].reshape(blocks, length).mean(axis=1)
    # Adjacent blocks are correlated; this correction is exact for exponential correlations.
    lost = (time - 0.25 / time) / length
    return float(means.mean()), float(means.std(ddof=1) / numpy.sqrt(blocks * (1.0 - lost)))


def is_constant(values):
    return numpy.ptp(values) <= ROUNDING_SPREAD * numpy.abs(values).max()


def autocorrelation_time(values):
    """Integrated autocorrelation time in samples, at least 1/2, with a window of five times itself."""
    if len(values) < 2 or is_constant(values):
        return 0.5
    count, deviations = len(values), values - values.mean()
    products = numpy.fft.irfft(numpy.abs(numpy.fft.rfft(deviations, 2 * count)) ** 2)[:count]
    time, window = 0.5, 0
    while window < count // 2 and window < WINDOW_PER_TIME * time:
        window += 1
        time += products[window] / products[0] * count / (count - window)
    # Corrects the bias from subtracting the sample mean.
    return max(0.5, time * (1.0 + (2.0 * window + 1.0) / count))
