"""drover/figures/stability_panels.py: panels of the figure of the stability of a uniform state, drawn on given axes."""
import re
from dataclasses import dataclass

import numpy
from matplotlib.colors import SymLogNorm
from matplotlib.ticker import FixedLocator, FuncFormatter, MaxNLocator, NullLocator

from drover.archive import loaded
from drover.fields import fields_of, shipped_fields
from drover.figures.model_panels import colour_of
from drover.figures.panels import (BLUE, GREEN, GREY, PURPLE, ROUNDING, STEPS, VERMILLION, key_of, log_axes,
                                   make_room_below, minor_ticks, with_unit)
from drover.typeset import symbol_text

LINES = (("-", BLUE), ("--", VERMILLION), ("-.", GREEN), (":", PURPLE))  # by angle or slow mode
STATES = ("ordered", "along_the_field", "isotropic")  # the most ordered first
SLOW_MODES = {1: ("slow mode",), 2: ("slower", "faster"), 3: ("slowest", "middle", "fastest")}  # by their speeds
OF_STATES = ("free_direction", "stable", "fastest_rate", "fastest_wavenumber", "direction_diffusion_times_area",
             "sound_wavenumber")  # numbers that are no fields
COMPONENT = re.compile(r"_(x|y|xx|xy|1|2)$")
DECADES = 5           # of growth rates on the larger side of a symmetric logarithmic axis
SPIKE = 4.0           # curves are clipped at this multiple of their typical range


@dataclass(frozen=True)
class State:
    """One uniform state: its group of the archive, with queries for the panels."""

    name: str
    data: object  # xarray.Dataset
    path: object
    scene: dict

    @property
    def is_isotropic(self):
        return self.name.startswith("isotropic") or self.data.sizes["angle"] == 1

    @property
    def words(self):
        """The state for a reader; of a model of one's own with its fields: "isotropic, cells = 1, signal = 1"."""
        own = re.fullmatch(r"(isotropic|ordered)(__.*)?_\d+", self.name)
        if not own:
            return self.name.replace("_", " ")
        sizes = {}
        for name, value in self.data.data_vars.items():
            if value.ndim == 0 and name not in OF_STATES:
                stem = COMPONENT.sub("", str(name))
                sizes.setdefault(stem, []).append(float(value) + 0.0)  # no -0
        fields = [f"{stem.replace('_', ' ')} = {parts[0]:.3g}" if len(parts) == 1 else
                  f"|{stem.replace('_', ' ')}| = {numpy.hypot(*parts):.3g}"
                  for stem, parts in sizes.items() if any(parts) or len(parts) == 1]
        is_zero = not any(any(parts) for parts in sizes.values())
        return f"{own[1]}, all fields 0" if is_zero else ", ".join([own[1], *fields])

    def array(self, name):
        return loaded(self.data[name], self.path)

    def holds(self, name):
        """Whether an array has non-zero values."""
        return name in self.data and bool((numpy.nan_to_num(self.array(name).values) != 0.0).any())

    def is_defined(self, name):
        return name in self.data and bool(numpy.isfinite(self.array(name).values).any())

    @property
    def fastest(self):
        """Growth rate, wavenumber and angle of the fastest growing wave of the map; None if none grows."""
        rates = self.array("growth_rate")
        most = rates.max("branch")
        place = most.argmax(("angle", "wavenumber"))
        rate = float(most[place])
        if not rate > ROUNDING * float(abs(rates).max()):
            return None
        return rate, float(most["wavenumber"][place["wavenumber"]]), float(most["angle"][place["angle"]])

    def angles(self, more=()):
        """Angles of the curves in degrees: those of the map nearest to 0, to its middle and to its end, or to 180 if it
        covers the full circle."""
        if self.is_isotropic:
            return [float(self.data["angle"][0])]
        end = min(180.0, float(self.data["angle"][-1]))
        chosen = [float(self.data["angle"].sel(angle=wanted, method="nearest")) for wanted in (0.0, end / 2.0, end)]
        return sorted({*chosen, *more})

    def parts(self, start):
        """(name, label, words, style) of the structure factors that are positive at the angles drawn."""
        rows = [row for row in part_rows(self.scene) if start + row[0] in self.data]
        return [(*row, (LINES[number % len(LINES)][0], colour_of(number))) for number, row in enumerate(rows)
                if bool((self.array(start + row[0]).sel(angle=self.angles()) > 0.0).any())]


def part_rows(scene):
    """(name, label without order, words for a panel that shows it alone) of the structure factors of a scene.

    Parts of a vector are along and across q; of the shipped model along and across the order where there is one.
    """
    own, rows = "field" in scene, []
    fields = ([(part, part.symbol) for field in fields_of(scene) for part in field.parts] if own else
              shipped_fields().items())
    for field, stem in fields:
        symbol = f"${symbol_text(field.symbol, field.spin)}$"
        words = symbol if own else f"{stem} {symbol}"
        rows += [(stem, words, words)] if not field.spin else [
            (f"{stem}_{end}" + ("" if own else "_p0"), rf"{words} {end} $\mathbf{{q}}$",
             f"{words} {end} " + (r"$\mathbf{q}$" if own else r"$\mathbf{p}_0$")) for end in ("along", "across")]
    return rows


def angle_text(angle):
    return f"{angle:.3g}°"


def angle_axis(axis, array):
    low, high = (float(array["angle"][place]) for place in (0, -1))
    axis.set_major_locator(FixedLocator(numpy.arange(low, high + 1e-9, 90.0 if high > 100.0 else 15.0)))
    axis.axes.margins(x=0.0)


def symmetric_log(axis, values, linear):
    """Sets a symmetric logarithmic axis with few enough ticks to be legible."""
    axis.axes.set_yscale("asinh", linear_width=linear)  # without the kinks of "symlog"
    low, high = values
    axis.axes.set_ylim(low, high)
    axis.set_major_locator(FixedLocator(symmetric_ticks(low, high, linear)))
    axis.set_major_formatter(FuncFormatter(lambda value, _: power_text(value)))
    axis.set_minor_locator(NullLocator())


def symmetric_ticks(low, high, linear):
    first, last = numpy.log10(linear), numpy.log10(max(-low, high, 10.0 * linear))
    step = max(1, int(numpy.ceil((last - first) / 4.0)))

    def powers(most):
        """Of ten up to `most`, which is on the axis; those near `linear` would touch the 0."""
        top = numpy.floor(numpy.log10(most)) if most > linear else first
        return 10.0 ** numpy.arange(top, first + 0.5, -step)
    return [*(-powers(-low)), 0.0, *powers(high)[::-1]]


def power_text(value):
    if value == 0.0:
        return "$0$"
    power = round(numpy.log10(abs(value)))
    return rf"${'-' if value < 0.0 else ''}10^{{{power}}}$"


def linear_range(rates, fastest):
    """The power of ten below which a symmetric logarithmic axis is linear."""
    most = float(abs(rates).max())
    least = max(most * 10.0 ** -DECADES, 0.1 * float(abs(rates).min()))
    if fastest is not None:
        least = min(0.1 * fastest[0], 1e-2 * most)
    return 10.0 ** numpy.floor(numpy.log10(least)) if least > 0.0 else 1e-6


def draw_growth_map(axes, bar_axes, state):
    """Draws the rate of the fastest mode over |q| and angle, its zero line, and the fastest growing wave."""
    rates, fastest = state.array("growth_rate").max("branch"), state.fastest
    most, linear = float(abs(rates).max()) or 1.0, linear_range(rates, fastest)
    norm = SymLogNorm(linear, linscale=1.0, vmin=-most, vmax=most)
    image = axes.pcolormesh(rates["wavenumber"], rates["angle"], rates.values, cmap="RdBu_r", norm=norm,
                            shading="gouraud", rasterized=True)
    log_axes(axes, x_only=True)
    axes.set_xlim(float(rates["wavenumber"][0]), float(rates["wavenumber"][-1]))
    axes.set_ylim(float(rates["angle"][0]), float(rates["angle"][-1]))
    angle_axis(axes.yaxis, rates)
    if fastest is not None:
        if float(rates.min()) < 0.0:
            axes.contour(rates["wavenumber"], rates["angle"], rates.values, levels=[0.0], colors="black",
                         linewidths=1.2)
        axes.plot(*fastest[1:], marker="*", markersize=11, color="black", markeredgecolor="white", clip_on=False,
                  zorder=5)
    axes.set_xlabel(with_unit(r"wavenumber $|\mathbf{q}|$", rates["wavenumber"]))
    axes.set_ylabel(r"angle of $\mathbf{q}$ to the order [degrees]")
    bar = axes.figure.colorbar(image, cax=bar_axes, ticks=symmetric_ticks(-most, most, linear),
                               format=FuncFormatter(lambda value, _: power_text(value)))
    bar.ax.yaxis.set_minor_locator(NullLocator())


def draw_branches(axes, state):
    """Draws growth rates of all modes over |q|, at a few angles."""
    rates, fastest = state.array("growth_rate"), state.fastest
    angles = state.angles(() if fastest is None or state.is_isotropic else (fastest[2],))
    if len(angles) > 3:  # the fastest is more important than the middle
        angles.remove(next(angle for angle in angles[1:-1] if angle != fastest[2]))
    for angle, (line, colour) in zip(angles, LINES):
        at = rates.sel(angle=angle)
        axes.plot(at["wavenumber"], at.values, color=colour, linestyle=line, linewidth=1.1)
    axes.axhline(0.0, color="black", linewidth=0.7, zorder=1)
    log_axes(axes, x_only=True)
    axes.set_xlim(float(rates["wavenumber"][0]), float(rates["wavenumber"][-1]))
    linear = linear_range(rates, fastest)
    symmetric_log(axes.yaxis,
                  (-1.5 * float(max(-rates.min(), linear)), 3.0 * max(fastest[0] if fastest else 0.0, linear)),
                  linear)
    axes.set_xlabel(with_unit(r"wavenumber $|\mathbf{q}|$", rates["wavenumber"]))
    axes.set_ylabel(with_unit(r"growth rate Re $s$", rates))
    if not state.is_isotropic:
        legend_below(axes, angle_keys(angles, fastest))


def legend_below(axes, keys):
    """Draws a legend at the bottom, with as many columns as fit."""
    width = axes.get_position().width * axes.figure.get_size_inches()[0]
    longest = 0.5 + 0.065 * max(len(re.sub(r"\\math\w+|[${}^\\]", "", key.get_label())) for key in keys)
    columns = max(1, min(len(keys), int(width / longest)))
    make_room_below(axes, -(-len(keys) // columns))
    axes.legend(handles=keys, loc="lower left", handlelength=2.0, ncol=columns, columnspacing=1.0, borderaxespad=0.3)


def draw_frequencies(axes, state):
    """Draws angular frequencies of all modes over |q|, at the first angle."""
    # Modes of equal growth have no order of their own: each curve keeps its place among the frequencies.
    array = state.array("frequency")[0]
    axes.plot(array["wavenumber"], numpy.sort(array.values, axis=1), color=BLUE, linewidth=1.1)
    log_axes(axes, x_only=True)
    axes.set_xlim(float(array["wavenumber"][0]), float(array["wavenumber"][-1]))
    most = float(abs(array).max())
    axes.set_ylim(-1.1 * most, 1.1 * most)
    axes.yaxis.set_major_locator(MaxNLocator(6, steps=STEPS))
    axes.set_xlabel(with_unit(r"wavenumber $|\mathbf{q}|$", array["wavenumber"]))
    axes.set_ylabel(with_unit(r"frequency $\omega = -$Im $s$", array))


def angle_keys(angles, fastest=None):
    notes = {fastest[2]: " (fastest)"} if fastest else {}
    return [key_of(angle_text(angle) + notes.get(angle, ""), colour, line=line)
            for angle, (line, colour) in zip(angles, LINES)]


def draw_slow(axes, state, name):
    """Draws speeds or damping of the slow modes over the angle, with growth if a speed is complex."""
    array = state.array(name)
    modes = array["slow_mode"].values
    names = SLOW_MODES.get(len(modes), [f"mode {i + 1}" for i in range(len(modes))])
    for mode, words, (line, colour) in zip(modes, names, LINES * len(modes)):
        axes.plot(array["angle"], array.sel(slow_mode=mode).values, color=colour, linestyle=line, linewidth=1.3,
                  label=words)
    shown = [array.values]
    if name == "slow_speed" and state.holds("slow_growth"):
        growth = state.array("slow_growth")
        shown.append(growth.values)
        axes.plot(growth["angle"], growth.values, color="black", linewidth=0.9, zorder=1)
        axes.legend(handles=[key_of("Re $u$", BLUE, line="-"),
                             key_of("Im $u$ (growth if positive)", "black", line="-")])
    axes.axhline(0.0, color=GREY, linewidth=0.7, zorder=1)
    axes.set_ylim(*range_without_spikes(numpy.concatenate([values.ravel() for values in shown])))
    if name == "slow_damping" and len(modes) > 1:
        make_room_below(axes, 1)
        axes.legend(loc="lower left", ncols=len(modes), columnspacing=1.0)
    angle_axis(axes.xaxis, array)
    axes.yaxis.set_major_locator(MaxNLocator(6, steps=STEPS))
    axes.set_xlabel(r"angle of $\mathbf{q}$ to the order [degrees]")
    axes.set_ylabel(with_unit("speed $u$" if name == "slow_speed" else r"damping $\gamma$", array))


def range_without_spikes(values):
    """Axis limits without outliers: damping has poles where speeds coincide."""
    values = values[numpy.isfinite(values)]
    low, high = numpy.quantile(values, (0.05, 0.95))
    width = max(high, 0.0) - min(low, 0.0) or 1.0
    low = min(0.0, max(values.min(), low - SPIKE * width))
    high = max(0.0, min(values.max(), high + SPIKE * width))
    margin = 0.06 * ((high - low) or 1.0)
    return low - margin, high + margin


def factor_curves(state, start):
    """Curves of a panel of structure factors (label, style, array), and whether all have the same unit."""
    if not state.is_isotropic:
        array = state.array(start + preferred(state, start)[0])
        return [(angle_text(angle), style, array.sel(angle=angle)) for angle, style in zip(state.angles(), LINES)], True
    parts = state.parts(start)
    arrays = [state.array(start + part[0]) for part in parts]
    alike = len({array.attrs.get("units") for array in arrays}) == 1
    return [(label if alike else with_unit(label, array), style, array[0])
            for (_, label, _, style), array in zip(parts, arrays)], alike


def preferred(state, start):
    """The part that is drawn at several angles: a scalar, or what is across the order."""
    return min(state.parts(start), key=lambda part: ("_along" in part[0], "_across" in part[0]))


def factor_title(state, start):
    words = r"$S(\mathbf{q}, \omega)$" if start.startswith("dynamic") else r"$S(\mathbf{q})$"
    return words if state.is_isotropic else f"{words} of {preferred(state, start)[2]}"


def draw_factor(axes, state, start):
    """Draws structure factors over |q| ("structure_factor_") or frequency ("dynamic_structure_factor_")."""
    curves, alike = factor_curves(state, start)
    dynamic, keys = start.startswith("dynamic"), []
    for label, (line, colour), array in curves:
        values = numpy.where(array.values > 0.0, array.values, numpy.nan)
        if not numpy.isfinite(values).any():
            continue
        axes.plot(array[array.dims[0]], values, color=colour, linestyle=line, linewidth=1.3)
        keys.append(key_of(label, colour, line=line))
    array = curves[0][2]
    axis = array[array.dims[0]]
    if dynamic:
        axes.set_yscale("log")
        minor_ticks(axes.yaxis)
        axes.xaxis.set_major_locator(MaxNLocator(6, steps=STEPS))
        axes.set_xlabel(with_unit(r"frequency $\omega$", axis))
    else:
        log_axes(axes)
        axes.set_xlabel(with_unit(r"wavenumber $|\mathbf{q}|$", axis))
    low, high = axes.get_ylim()
    axes.set_ylim(min(low, 0.15 * high), high)  # show at least a factor of several on the logarithmic axis
    label = "dynamic structure factor" if dynamic else "structure factor"
    axes.set_xlim(float(axis[0]), float(axis[-1]))
    axes.set_ylabel(with_unit(label, array) if alike else label)
    legend_below(axes, keys)


def sound_wavenumber(state):
    """|q| of the dynamic structure factor as text, or None."""
    return f"{float(state.data['sound_wavenumber']):.4g}" if "sound_wavenumber" in state.data else None
