"""drover/spectra.py: structure factors of density and orientation, equally defined for fields and particles."""
from dataclasses import dataclass

import numpy

from drover.archive import loaded
from drover.series_statistics import mean_and_error
from drover.particles import ParticleRun, sides_of
from drover.results import Result
from drover.roles import roles_of
from drover.typeset import order_unit


@dataclass(frozen=True)
class Shells:
    """Modes of a periodic cell, one of each pair q and -q, in shells of |q|/dq in [n + 1/2, n + 3/2).

    dq = 2 pi/longest side.
    """

    numbers: numpy.ndarray  # (modes, 2): integer wavenumbers along x and y
    shell: numpy.ndarray    # (modes,)
    q: numpy.ndarray        # mean over each shell [1/mm]

    def means(self, values):
        """Shell averages of one number per mode."""
        return numpy.bincount(self.shell, values) / numpy.bincount(self.shell)


def shells_of(sides, most):
    """The complete shells below a wavenumber; none if the first is above it."""
    step = 2.0 * numpy.pi / max(sides)
    count = int(most / step * (1.0 + 1e-9))
    reach = [int((count + 0.5) * step * side / (2.0 * numpy.pi)) for side in sides]
    x, y = numpy.meshgrid(numpy.arange(reach[0] + 1), numpy.arange(-reach[1], reach[1] + 1))
    numbers = numpy.column_stack([x.ravel(), y.ravel()])
    size = 2.0 * numpy.pi * numpy.hypot(*(numbers / sides).T)
    shell = numpy.floor(size / step * (1.0 + 1e-12) + 0.5).astype(int) - 1
    kept = (shell >= 0) & (shell < count) & ((numbers[:, 0] > 0) | (numbers[:, 1] > 0))
    shells = Shells(numbers[kept], shell[kept], numpy.zeros(count))
    return Shells(shells.numbers, shells.shell, shells.means(size[kept])) if count else shells


def structure_factors(run, most):
    """Structure factors of density and orientation below a wavenumber, as two Results.

    Averages over the second half of the frames of |sum exp(-i q r)|^2/N and |sum n exp(-i q r)|^2/N, with unit vectors
    n in the plane: both are 1 for independent rods.  For fields the sums are integrals over sigma and sigma p.
    """
    sides = sides_of(run) if isinstance(run,
                                        ParticleRun) else numpy.array([run.scene["grid"]["lx"],
                                                                       run.scene["grid"]["ly"]])
    shells, count = shells_of(sides, most), run.frames.sizes["time"]
    factors_of = particle_factors if isinstance(run, ParticleRun) else field_factors
    frames = numpy.array([[shells.means(factor) for factor in factors_of(run, frame, sides, shells.numbers)]
                          for frame in range(count // 2, count)])
    nothing = numpy.full(len(shells.q), numpy.nan)
    return tuple(Result(shells.q, *numpy.reshape([mean_and_error(series) for series in part.T], (-1, 2)).T, nothing)
                 for part in frames.transpose(1, 0, 2))


def field_factors(run, frame, sides, numbers):
    """Structure factors of one frame at integer wavenumbers: of the first scalar, and of the first vector.

    A vector that is a pure number is the mean orientation; otherwise it is sigma times the orientation.
    """
    roles = roles_of(run)
    scalar, vector = (next(role for role in roles if role.spin == spin) for spin in (0, 1))
    density, *order = (loaded(run.frames[name].isel(time=frame), run.path).values
                       for name in (*scalar.components, *vector.components))
    weight = density if order_unit(f"[{vector.key}]", run.scene) == "1" else 1.0
    at = (numbers[:, 1] % density.shape[0], numbers[:, 0] % density.shape[1])
    parts = [numpy.abs(numpy.fft.fft2(part)[at] / density.size) ** 2
             for part in (density, *(weight * part for part in order))]
    scale = sides[0] * sides[1] / density.mean()
    return scale * parts[0], scale * (parts[1] + parts[2])


def particle_factors(run, frame, sides, numbers):
    """Structure factors of one frame at integer wavenumbers."""
    places, axes = (loaded(run.frames[name].isel(time=frame), run.path).values[:, :2]
                    for name in ("rod_position", "rod_axis"))
    return body_factors(places, axes, sides, numbers)


def body_factors(places, axes, sides, numbers):
    """Direct sums over rods, using the product of waves along x and y."""
    directions = axes / numpy.maximum(numpy.hypot(*axes.T), numpy.finfo(float).tiny)[:, None]
    reach = numpy.abs(numbers).max(axis=0, initial=0)
    along = [numpy.exp(-2j * numpy.pi * numpy.outer(numpy.arange(-most, most + 1), places[:, i] / sides[i]))
             for i, most in enumerate(reach)]
    parts = [numpy.abs(((weight * along[0]) @ along[1].T)[numbers[:, 0] + reach[0], numbers[:, 1] + reach[1]]) ** 2
             / len(places)
             for weight in (numpy.ones(len(places)), *directions.T)]
    return parts[0], parts[1] + parts[2]
