"""drover/figures/dynamics_figure.py: S(q, omega) of a run of fields: maps measured and predicted, cuts at some
wavenumbers."""
import matplotlib
import numpy
from matplotlib.colors import LogNorm
from matplotlib.ticker import MaxNLocator

from drover.dynamics import dynamic_structure_factor, kept_modes
from drover.figures.panels import BLUE, STEPS, VERMILLION, edges_of, minor_ticks, with_unit, write_instead
from drover.figures.paper import STYLE, add_axes, bar_box, new_figure, write_title_and_caption
from drover.text import drawable, scene_name
from drover.typeset import spaced

MODES = 12          # of a figure, where the run keeps so many
DECADES = 1e-4      # of S(q, omega), relative to the largest value
SHOWN = 1e-3        # frequencies are shown to where S is below this part of its largest value, at every q
MEASURED, PREDICTED = (0.9, 4.1, 4.3, 2.75), (6.0, 4.1, 4.3, 2.75)
CUTS = tuple((left, 1.45, 2.75, 1.85) for left in (0.9, 4.75, 8.6))


def found_of(run, field, along="x", modes=None):
    """The dataset of dynamic_structure_factor, with as many modes as a map needs."""
    most = max(1, kept_modes(run, along)) if along in run.frames.sizes else 1
    return dynamic_structure_factor(run, field, along=along, modes=min(MODES, most) if modes is None else modes)


def arrays_of(found):
    """S(q, omega) measured, its error and that of the linear theory."""
    name = next(str(name) for name in found if not str(name).endswith(("_error", "_linear")))
    return found[name], found[f"{name}_error"], found[f"{name}_linear"]


def norm_of(*arrays):
    """One logarithmic scale of colours for all."""
    most = max((float(array.max()) for array in arrays if bool(numpy.isfinite(array).any())), default=1.0)
    return LogNorm(DECADES * most, most) if most > 0.0 else LogNorm(0.1, 1.0)


def last_frequency(*arrays):
    """The frequency up to which something is to be seen."""
    reach = 0.0
    for array in arrays:
        if bool(numpy.isfinite(array).any()):
            seen = (array > SHOWN * float(array.max())).any("wavenumber").values
            reach = max(reach, float(abs(array["frequency"].values[seen]).max(initial=0.0)))
    return 1.1 * reach if reach > 0.0 else float(arrays[0]["frequency"].max())


def draw_map(axes, array, norm, reach):
    """Draws S(q, omega) over q and omega; returns the image, or None without values."""
    if not bool(numpy.isfinite(array).any()):
        write_instead(axes, "no linear theory")
        return None
    q = array["wavenumber"].values
    image = axes.pcolormesh(edges_of(q), edges_of(array["frequency"].values), numpy.maximum(array.values.T, norm.vmin),
                            cmap="viridis", norm=norm, rasterized=True)
    axes.set_ylim(-reach, reach)
    axes.set_xlabel(with_unit("wavenumber $q$", array["wavenumber"]))
    axes.set_ylabel(with_unit(r"frequency $\omega$", array["frequency"]))
    for axis in (axes.xaxis, axes.yaxis):
        axis.set_major_locator(MaxNLocator(6, steps=STEPS))
    return image


def draw_cut(axes, found, number, reach):
    """Draws S(q, omega) over omega at one of the wavenumbers, with errors, and the linear theory as a line."""
    measured, error, linear = (array.isel(wavenumber=number) for array in arrays_of(found))
    omega = measured["frequency"].values
    inside = abs(omega) <= reach
    axes.errorbar(omega[inside], measured.values[inside], error.values[inside], color=BLUE, marker="o", markersize=2.5,
                  linestyle="none", elinewidth=0.7)
    axes.plot(omega[inside], linear.values[inside], color=VERMILLION, linewidth=1.2, zorder=3)
    values = measured.values[inside]
    top = float(numpy.nanmax([values.max(), numpy.nanmax(linear.values[inside], initial=0.0)]))
    axes.set_yscale("log")
    axes.set_ylim(max(0.5 * float(values[values > 0.0].min(initial=top)), DECADES * top), 2.0 * top)
    minor_ticks(axes.yaxis)
    axes.set_xlim(-1.03 * reach, 1.03 * reach)  # points at the ends are whole
    axes.xaxis.set_major_locator(MaxNLocator(5, steps=STEPS))
    axes.set_xlabel(with_unit(r"frequency $\omega$", measured["frequency"]))


@matplotlib.rc_context(STYLE)
def draw(run, field, along="x"):
    """Draws S(q, omega) of a field of a run as a matplotlib Figure."""
    found = found_of(run, field, along)
    measured, _, linear = arrays_of(found)
    norm, reach = norm_of(measured, linear), last_frequency(measured, linear)
    figure = new_figure()
    for box, array, words in ((MEASURED, measured, "(a) measured"), (PREDICTED, linear, "(b) linear theory")):
        axes = add_axes(figure, box)
        image = draw_map(axes, array, norm, reach)
        axes.set_title(words, loc="left")
        if box is MEASURED:
            bar = figure.colorbar(image, cax=add_axes(figure, bar_box(PREDICTED)), extend="min")
            bar.set_label(with_unit(r"$S(q, \omega)$", array))
        else:
            axes.set_ylabel("")
    modes = found.sizes["wavenumber"]
    chosen = sorted({0, modes // 2, modes - 1})
    for letter, number, box in zip("cde", chosen, CUTS):
        axes = add_axes(figure, box)
        draw_cut(axes, found, number, reach)
        q = found["wavenumber"][number]
        axes.set_title(f"({letter}) at $q$ = {float(q):.3g}{spaced(q.attrs.get('units', '1'))}", loc="left")
        if letter == "c":
            axes.set_ylabel(with_unit(r"$S(q, \omega)$", measured))
    words = drawable(field.replace("_", " "))
    write_title_and_caption(figure, f"{scene_name(run)}: dynamic structure factor of {words}, waves along ${along}$",
                            caption(measured, linear))
    return figure


def caption(measured, linear):
    """Explains the figure to a reader."""
    shown = bool(numpy.isfinite(linear).any())
    return ("Measured by Welch's method in the second half of the run; a wave exp(i q x \N{MINUS SIGN} i ω t) is at q "
            "and ω, and the integral of S(q, ω) over ω/2π is S(q). Points with standard errors of the scatter of the "
            "segments"
            + (f"; lines: {drawable(linear.comment.removeprefix('S(q, omega) of the '))}." if shown else
               f"; {drawable(linear.comment)}."))
