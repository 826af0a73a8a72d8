"""drover/figures/theory_figures.py: figures of archives other than runs: theory, sweeps, tables of coefficients."""
from drover.error import DroverError
from drover.figures import (boundary_figure, calibration_figure, onset_figure, stability_figure, states_figure,
                            sweep_figure)

# Functions that draw archives other than runs, by the kind of archive, with the options that apply to them.
FIGURES = {"boundary": (boundary_figure.draw, ()), "onset": (onset_figure.draw, ()), "sweep": (sweep_figure.draw, ()),
           "stability": (stability_figure.draw, ("state",)), "states": (states_figure.draw, ("frame",)),
           "calibrate": (calibration_figure.draw, ())}


def draw_theory(theory, state=None, frame=None):
    """Draws an archive other than a run; `state` applies to a stability analysis, `frame` to states."""
    if theory.kind not in FIGURES:
        raise DroverError(f"{theory.path}: there is no figure of drover {theory.kind}; draw an array of it by .plot()")
    its_draw, options = FIGURES[theory.kind]
    return its_draw(theory, *({"state": state, "frame": frame}[option] for option in options))
