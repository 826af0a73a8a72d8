"""drover/results.py: means with errors and linear theory, of finished and unfinished runs."""
from dataclasses import dataclass

import numpy

from drover.archive import loaded


@dataclass(frozen=True)
class Result:
    """Means at points x; error is NaN where not available, linear is NaN without a prediction."""

    x: numpy.ndarray
    mean: numpy.ndarray
    error: numpy.ndarray
    linear: numpy.ndarray

    @property
    def has_linear(self):
        return bool(numpy.isfinite(self.linear).any())


def without_means(run):
    """Why a run has no means: it has not ended, or it is in memory, where only archives have them."""
    if run.attributes.get("in_memory") == "ended":
        return "A run in memory"
    return "The run is not finished"


def structure_factor(run, part):
    """S(q) of a field over |q|, of a vector along or across q; None if the run did not measure it."""
    name = f"structure_factor_{part}"
    if name not in run.observables:
        return None
    q = loaded(run.observables["wavenumber"], run.path).values
    if run.summary is not None:
        return summarised(run, name, q)
    return bare(q, loaded(run.observables[name], run.path).mean("time").values)


def counted(run):
    """What number fluctuations count: bodies, such as "rod", a density of the scene's own, or None."""
    ending = "_number_variance"
    names = [name.removesuffix(ending) for name in map(str, run.observables) if name.endswith(ending)]
    return next(iter(names), None)


def counted_bodies(run):
    """The same where the run measured their number in the cell, and None otherwise."""
    what = counted(run)
    return what if f"{what}s_total" in run.observables else None


def counted_words(run):
    bodies = counted_bodies(run)
    return f"number $N$ of {bodies}s" if bodies else f"amount $N$ of {counted(run).replace('_', ' ')}"


def number_fluctuations(run):
    """Deviation DN of the number of rods (or beads) in a box over its mean N; None if the run did not measure it."""
    what = counted(run)
    if what is None:
        return None
    if run.summary is not None:
        return summarised(run, f"{what}_number_deviation", loaded(run.summary[f"{what}_number"], run.path).values)
    variance = loaded(run.observables[f"{what}_number_variance"], run.path).mean("time").values
    side = run.observables["box_side"].values  # of a square with the area of the box
    area = run.scene["grid"]["lx"] * run.scene["grid"]["ly"]
    if counted_bodies(run):
        total = loaded(run.observables[f"{what}s_total"], run.path).mean().item()
    else:
        total = area * loaded(run.observables[f"mean_{what}"], run.path).mean().item()
    return bare(total * side**2 / area, numpy.sqrt(variance))


def number_exponents(run, numbers):
    """Local exponents d ln DN/d ln N between adjacent boxes, over the geometric mean of their N."""
    middle = numpy.sqrt(numbers.x[1:] * numbers.x[:-1])
    if run.summary is not None:
        exponents = summarised(run, f"{counted(run)}_number_exponent",
                               numbers.x)  # the last is NaN: there is no larger box
        return Result(middle, exponents.mean[:-1], exponents.error[:-1], exponents.linear[:-1])
    with numpy.errstate(divide="ignore", invalid="ignore"):
        return bare(middle, numpy.diff(numpy.log(numbers.mean)) / numpy.diff(numpy.log(numbers.x)))


def summarised(run, name, x):
    def values(ending):
        key = name + ending
        return loaded(run.summary[key], run.path).values if key in run.summary else numpy.full(len(x), numpy.nan)

    return Result(x, values(""), values("_error"), values("_linear"))


def bare(x, mean):
    nothing = numpy.full(len(x), numpy.nan)
    return Result(x, mean, nothing, nothing)
