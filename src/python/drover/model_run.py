"""drover/model_run.py: a run of declared fields in memory."""
import warnings
from numbers import Integral

import numpy as np

from drover.error import Error

MAX_VARIANCE_CUT = 1e-3  # of a start, as in scenes


def pair_of(name, given):
    """One number, or two along x and y, as an array of two."""
    if np.shape(given) not in ((), (2,)):
        raise Error(f"{name} = {given}; expected one number, or two along x and y")
    return np.broadcast_to(given, 2)


def on_grid(name, given, fields):
    """The values of a DataArray over y and x, whatever the order of its dimensions."""
    if {*given.dims} != {"y", "x"} and given.ndim:
        raise Error(f"{name} has the dimensions {', '.join(map(str, given.dims))}; expected y and x")
    for axis in set(given.coords) & {"x", "y"}:
        if given[axis].shape != fields[axis].shape or not np.allclose(given[axis], fields[axis], rtol=1e-9):
            raise Error(f"{name} has other values of {axis} than this run; expected those of its fields")
    return given.transpose("y", "x").values if given.ndim else given.values


class ModelRun:
    """A run of a model in memory; made by Model.start()."""

    def __init__(self, model, points, side, dt, method, seed, threads):
        from drover._drover import Evolution

        model._require_no_grid()
        if any(count % 1 != 0 for count in points):
            raise Error(f"points = {', '.join(map(str, points))}; expected whole numbers")
        if not isinstance(method, str) or not isinstance(threads, Integral) or not 1 <= threads <= 1024:
            raise Error(f"method = {method!r}, threads = {threads!r}; expected a text and an integer from 1 to 1024")
        if not isinstance(seed, Integral) or not 0 <= seed < 2**63:
            raise Error(f"seed = {seed}; expected an integer from 0 to 2^63 - 1")
        self.model, self.dt, self.side = model, dt, tuple(map(float, side))
        self._evolution = Evolution(model._equations, *map(int, points), *self.side, dt, method, seed, threads)
        names, kept = model._equations.components(), model._equations.state_components()
        self._names = [names[k] for k in kept]
        self._balanced = [name for k, name in enumerate(names) if k not in kept]

    @property
    def time(self):
        """The time reached."""
        return self._evolution.time()

    def advance(self, duration):
        """Advances by a duration, a whole number of steps; returns the run."""
        if not np.isfinite(duration):
            raise Error(f"duration = {duration}; expected a finite number")
        steps = round(duration / self.dt)
        if abs(steps * self.dt - duration) > 1e-9 * abs(duration):
            raise Error(f"duration = {duration} is {duration / self.dt:.6g} steps of dt = {self.dt}; expected a whole "
                        "number of steps")
        self._evolution.advance(steps)
        return self

    @property
    def fields(self):
        """The fields now, those in balance too, a dataset of arrays (y, x) by component."""
        import xarray

        values = self._evolution.fields()
        axes = {name: np.arange(size) * (side / size)
                for name, size, side in zip(("x", "y"), values.shape[:0:-1], self.side)}
        arrays = dict(zip(self._names, values))
        if self._balanced:
            arrays |= zip(self._balanced, self._evolution.balanced())
        return xarray.Dataset({name: (("y", "x"), array) for name, array in arrays.items()}, axes,
                              {"time": self.time})

    def __copy__(self):
        raise TypeError("a run cannot be copied: its copy would be the same run; expected another run of its model")

    def set(self, /, **arrays):
        """Replaces components, or fields, by arrays (y, x), functions of x and y, or numbers; returns the run.

        Waves beyond those that the run keeps are cut off, with a warning from a thousandth of the variance on.

        A complex field has complex values, any other field of two components a pair of values.

        run.set(phi=lambda x, y: 0.1 * np.cos(2 * np.pi * x / 8.0), A=1.0 + 0.5j, p=(0.5, 0.0))
        """
        import xarray

        now = self.fields
        values = np.array([now[name].values for name in self._names])
        x, y = np.meshgrid(now.x, now.y)
        fields = {name: field for field in self.model.fields for name in (field.symbol, field.name)}
        set_parts = []
        for name, given in arrays.items():
            parts = fields[name].components if name in fields and name not in self._names else (name,)
            if not set(parts) <= set(self._names):
                raise Error(f"{name} is not a component of this run with a rate; expected one of "
                            + ", ".join(self._names))
            given = given(x, y) if callable(given) else given
            if isinstance(given, xarray.DataArray):
                given = on_grid(name, given, now)
            if len(parts) == 2:
                given = (np.real(given), np.imag(given)) if fields[name].complex else given
                if np.isscalar(given) or len(given) != 2:
                    raise Error(f"{name} has two components, {' and '.join(parts)}; expected a pair of values")
            for part, value in zip(parts, given if len(parts) == 2 else (given,)):
                if np.iscomplexobj(value):
                    raise Error(f"{part} has complex values; expected real ones")
                if np.ma.is_masked(value):
                    raise Error(f"{part} has masked values; expected a number in every cell, as by .filled(0.0)")
                try:
                    values[self._names.index(part)] = value
                except ValueError:
                    raise Error(f"{part} has values of shape {np.shape(value)}; expected a number, or an array (y, x) "
                                f"of shape {x.shape}") from None
                set_parts.append(part)
        self._evolution.set_fields(values)
        for part in set_parts:
            self._warn_of_cut(part, values[self._names.index(part)])
        return self

    def _power(self, values):
        """(|a_q|^2, whether the run keeps q, wavenumbers along y and x) of an array (y, x)."""
        power = np.abs(np.fft.fft2(values) / values.size) ** 2
        number = [np.abs(np.fft.fftfreq(size, 1 / size)) for size in values.shape]
        degree = self.model._equations.degree()
        is_kept = np.logical_and.outer(*(k * (degree + 1) < max(k.size, 2) for k in number))
        wave = [2 * np.pi * np.fft.fftfreq(size, side / size) for size, side in zip(values.shape, self.side[::-1])]
        return power, is_kept, wave

    def _warn_of_cut(self, name, values):
        power, is_kept, _ = self._power(values)
        variance, cut = power.sum() - power[0, 0], power[~is_kept].sum()
        if cut > MAX_VARIANCE_CUT * variance and variance > 1e-24 * power[0, 0]:
            warnings.warn(f"{name}: the run cuts off {cut / variance:.2g} of its variance, waves of "
                          f"|k| >= N/{self.model._equations.degree() + 1} on an axis; expected less than "
                          f"{MAX_VARIANCE_CUT}: choose more points, or make it smoother", stacklevel=3)

    def structure_factor(self, name):
        """|a_q|^2 times the area, averaged over shells of the width of the smallest |q|, by wavenumber.

        Of the modes that the run keeps: |k| < N/(degree + 1) on each axis, by the degree of the products.
        """
        import xarray

        if name not in self._names:
            raise Error(f"{name} is not a component of this run; expected one of {', '.join(self._names)}")
        power, is_kept, wave = self._power(self.fields[name].values)
        power *= self.side[0] * self.side[1]
        q = np.hypot(*np.meshgrid(*wave, indexing="ij"))
        width = 2 * np.pi / max(self.side)
        shell = np.rint(q[is_kept] / width).astype(int)
        count, total, mean_q = (np.bincount(shell, weights) for weights in (None, power[is_kept], q[is_kept]))
        kept = np.flatnonzero(count)[1:]
        return xarray.DataArray(total[kept] / count[kept], dims="wavenumber",
                                coords={"wavenumber": mean_q[kept] / count[kept]}, name=f"structure_factor_{name}")

    def __repr__(self):
        return f"<run of {', '.join(field.symbol for field in self.model.fields)} at t = {self.time:.6g}>"
