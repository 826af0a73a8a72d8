"""drover/plot.py: figures, and their panels as functions that draw on given axes and return them.

    import drover
    drover.plot.figure("flock.h5").savefig("flock.pdf")
    drover.plot.map("flock.h5", frame=-1)

A run is the path of an archive, an open run, or a run in memory.  Without axes each function makes a figure for them.
"""
from drover.error import Error
from drover.run_view import run_of

# Inches: a panel alone, the left and lower edge of its axes, and what is right of them, for a bar or a second axis too.
PAGE, CORNER, RIGHT, BESIDE, ABOVE = (5.0, 4.0), (0.9, 0.75), 0.2, 0.95, 0.35


def figure(thing, frame=None, state=None):
    """The figure of python3 -P -m drover.figure: of a run or of drover states (at a frame), or of linear theory (of a
    state).

    >>> import drover
    >>> run = drover.Scene.from_dict({"grid": {"nx": 16, "ny": 16}, "time": {"dt": 0.1, "end": 1.0}}).start()
    >>> len(figure(run).axes) > 4
    True
    """
    from drover.figure import draw_opened
    from drover.theory import Theory, open_any
    if hasattr(thing, "joinpath") or isinstance(thing, str):
        thing = open_any(thing)
    thing = thing if isinstance(thing, Theory) else run_of(thing)
    return draw_opened(thing, {"frame =": frame, "state =": state, "dynamics =": None})


def compare(first, second, labels=None, frame=-1):
    """Two runs side by side, fields or particles: their maps, and the order of the first vector with its means."""
    from drover.figures.pair_figure import draw
    return draw(first, second, labels, frame)


def map(run, axes=None, frame=-1, field=None):
    """Fields: a density with arrows of the order or the flow; profiles of one row.  Particles: the cell from above.

    Of a scene with fields of its own the first.  One `field`, by name or symbol, with its own directions.
    """
    from drover.figures import model_panels, particle_figure
    from drover.particles import ParticleRun
    from drover.figures.paper import require_frame
    from drover.roles import chosen, has_own_fields
    from drover.typeset import bracket
    run = run_of(run)
    require_frame(run, frame)
    bar = None
    if axes is None and "grid" in run.scene and run.frames.sizes["y"] > 1:
        axes, bar = map_axes(run.scene["grid"]["lx"] / run.scene["grid"]["ly"])
    axes = axes_of(axes, RIGHT if isinstance(run, ParticleRun) else BESIDE)
    if isinstance(run, ParticleRun):
        if field is not None:
            raise Error(f'field = "{field}" of a run of particles; expected none')
        particle_figure.draw_map(axes, run, frame)
        return axes
    if field is None and not has_own_fields(run):
        model_panels.draw_map_with_arrows(axes, bar, run, frame)
        return axes
    role = chosen(run, field)[0]
    model_panels.draw_map(axes, bar, run, role, frame)
    axes.set_title(f"{role.title_words} ${role.size_symbol}$".strip() + bracket(role.unit), loc="left")
    return axes


def means(run, axes=None, field=None):
    """Means over the cell of fields of a scene's own: of one `field`, or of all that have the unit of the first.

    Of vectors and nematics the size of the mean; of scalars with a band of one standard deviation.
    """
    from drover.figures import model_panels
    from drover.roles import chosen
    run, axes = fields_of(run), axes_of(axes)
    roles = chosen(run, field)
    alike = [role for role in roles if role.unit == roles[0].unit and model_panels.mean_name(role) in run.observables]
    if not alike:
        raise Error(f"this run has no series of the mean {roles[0].words}; expected fields of the scene's own: see "
                    "drover.plot.order and drover.plot.series")
    model_panels.draw_means(axes, run, alike, range(len(alike)))
    axes.legend()
    return axes


def structure(run, axes=None):
    """Structure factors S(q) with errors and linear theory."""
    from drover.figures.model_panels import draw_structure_with_keys
    return panel(draw_structure_with_keys, fields_of(run), axes)


def dynamics(run, field, axes=None, *, along="x", modes=None, linear=False):
    """S(q, omega) of a field of an archive over wavenumber and frequency, measured or of the linear theory."""
    from drover.figures import dynamics_figure as figures
    run, axes = fields_of(run), axes_of(axes, BESIDE)
    measured, _, theory = figures.arrays_of(figures.found_of(run, field, along, modes))
    norm, reach = figures.norm_of(measured, theory), figures.last_frequency(measured, theory)
    image = figures.draw_map(axes, theory if linear else measured, norm, reach)
    if image is not None:
        from drover.figures.panels import with_unit
        axes.figure.colorbar(image, ax=axes, extend="min").set_label(with_unit(r"$S(q, \omega)$", measured))
    return axes


def numbers(run, axes=None, exponents=None):
    """Number fluctuations with errors and linear theory; on the axes `exponents` their local exponents."""
    run, axes = fields_of(run), axes_of(axes)
    from drover.figures import panels
    hidden = exponents if exponents is not None else axes.figure.add_axes((0, 0, 0.1, 0.1), visible=False)
    panels.draw_numbers(axes, hidden, run)
    if exponents is None:
        axes.set_xlabel(hidden.get_xlabel())
        axes.tick_params(which="both", labelbottom=True)
        hidden.remove()
    return axes


def order(run, axes=None):
    """The order of vectors and nematics over time, with the mean of the first."""
    from drover.figures.model_panels import draw_order
    return panel(draw_order, fields_of(run), axes)


def profiles(run, axes=None, exact=None):
    """A field of a run without noise along x, at several times; `exact`, a function of x [mm] and t [s], is dotted."""
    from drover.figures.smooth_panels import draw_profiles
    run, axes = fields_of(run), axes_of(axes)
    draw_profiles(axes, run, exact)
    return axes


def growth(run, axes=None):
    """Standard deviations over time, of densities relative to their means."""
    from drover.figures.smooth_panels import draw_growth
    return panel(draw_growth, fields_of(run), axes)


def length(run, axes=None):
    """The length of the pattern over time: 2 pi over the mean wavenumber of the spectrum of the order or a density."""
    from drover.figures.smooth_panels import draw_length
    return panel(draw_length, fields_of(run), axes)


def series(run, name, axes=None):
    """An observable over time, with its mean and error."""
    run, axes = run_of(run), axes_of(axes)
    if name not in run.observables or run.observables[name].dims != ("time",):
        known = [key for key, array in run.observables.items() if array.dims == ("time",)]
        raise Error(f"the run has no series {name}; expected one of {', '.join(known)}")
    from drover.figures.particle_panels import draw_series, words_of
    draw_series(axes, run, name, float(run.frames["time"][-1]))
    axes.set_ylabel(axes.get_ylabel().replace(name, words_of(name)))
    return axes


def sweep(table, name, axes=None):
    """An observable of a sweep over the varied key, with errors; of two keys a map."""
    return table.plot(name, axes)


def paths(run, axes=None, frame=-1):
    """The paths of the rods up to a frame, with the cell and the rods; of few rods in a large cell what is around them.
    """
    from drover.figures import particle_motion, particle_panels
    from drover.figures.paper import require_frame
    from drover.particles import sides_of
    run = particles_of(run)
    require_frame(run, frame)
    axes = axes_of(axes)
    sides, places = sides_of(run), particle_motion.paths(run, frame, sides_of(run))
    view = particle_motion.view_in(run, places, sides)
    periodic = particle_panels.is_periodic(run) and view is None
    shown = particle_panels.draw_cell(axes, run, sides, view)
    particle_motion.draw_paths(axes, run, places, frame, sides, periodic)
    particle_panels.draw_rods(axes, run, frame, sides, periodic)
    particle_panels.draw_scale(axes, shown)
    return axes


def wake(run, axes=None):
    """The mean velocity of the beads in the frame of a rod, of a finished run of rods and beads."""
    from drover.figures.particle_motion import draw_wake
    run, axes = particles_of(run), axes_of(axes, BESIDE)
    if run.summary is None or "flow_velocity_along" not in run.summary:
        raise Error("the run has no mean flow of beads around a rod; expected a finished run of rods and beads")
    draw_wake(axes, run)
    return axes


def memory(run, axes=None):
    """How long rods keep their direction: the autocorrelation of it, with the fit of rotational diffusion."""
    from drover.figures import particle_motion
    return panel(particle_motion.draw_memory, particles_of(run), axes)


def panel(draw, run, axes):
    axes = axes_of(axes)
    draw(axes, run)
    return axes


def particles_of(run):
    run = run_of(run)
    if "rod_axis" not in run.frames:
        raise Error("this run has no rods; expected a run of particles with rods: see drover.plot.map")
    return run


def fields_of(run):
    run = run_of(run)
    if "grid" not in run.scene:
        raise Error("this is a run of particles; expected one of fields: see drover.plot.map and drover.plot.series")
    return run


def map_axes(ratio):
    """Axes of a map with this ratio of its sides, and of its colour bar, in a new figure."""
    from matplotlib import pyplot
    from drover.figures.paper import add_axes, bar_box, fitted
    box, figure = fitted(inner_box(BESIDE), ratio), pyplot.figure(figsize=PAGE)
    return add_axes(figure, box), add_axes(figure, bar_box(box))


def inner_box(right):
    return (*CORNER, PAGE[0] - CORNER[0] - right, PAGE[1] - CORNER[1] - ABOVE)


def axes_of(axes, right=RIGHT):
    """The axes, or those of a new figure, with inches on their right for a second axis or a bar."""
    if axes is not None:
        return axes
    from matplotlib import pyplot
    from drover.figures.paper import add_axes
    return add_axes(pyplot.figure(figsize=PAGE), inner_box(right))
