"""drover/tradeoffs.py: speed for accuracy, measured on a scene."""
import os
import tempfile

from drover import _drover
from drover.campaign import Submitted, folder_for_jobs, submit
from drover.error import ArgumentError, Error, require_scene
from drover.worker import call


class Tradeoff:
    """What drover tradeoff found.

    `front`: the cheapest settings for their error, a list of dicts; `by_model`: those of each model; `levels`: what
    each step, grid and model does alone; `wishes`: the wanted numbers.  `recommended`: a Scene, or None, and then
    `refusal` says why; `reasons`: of the recommendation.
    """

    def __init__(self, result, scene):
        found = result["found"]
        self.front, self.by_model, self.levels, self.wishes = (found[name] for name in
                                                               ("front", "by_model", "levels", "wishes"))
        self.text, self.reasons, self.refusal = result["text"], result["reasons"], result["refusal"]
        self.recommended = type(scene).parse(result["recommended"], scene.name) if result["recommended"] else None
        self.seconds = result["seconds"]  # of a core, for the recommended run

    def __repr__(self):
        return self.text

    def plot(self, axes=None):
        """Draws error against work, one colour a model.  Returns the matplotlib axes."""
        from drover.figures.trade_panel import draw_trade
        return draw_trade({"by_model": self.by_model, "front": self.front}, axes)


def tradeoff(scene, want, budget="20min", *, folder=None, workers=0, collect=False, slurm=0, quiet=True):
    """Measures what accuracy costs on a scene, as `drover tradeoff`; returns a Tradeoff.

    `want`: wanted time means and their errors, "polar_order=1%" or a list of such texts.  `budget`: core time of the
    trials, and of the recommended run.  `folder` keeps the trials, and the same call resumes; by default they are not
    kept.  `collect` runs nothing, and gives the result of the trials that have ended.  `slurm=8` submits 8 processes
    that share the trials to Slurm instead, and returns at once an object with status() and collect().

    >>> from drover import Scene
    >>> scene = Scene.from_dict({"relaxation": {"rate": -0.5, "saturation": 1.0}, "noise.order": 0.05,
    ...                          "grid": {"nx": 8, "ny": 8}, "time": {"dt": 0.5, "end": 100.0},
    ...                          "initial": {"kind": "formula", "polar_order_x": "0.7"}, "output.sample_every": 1.0})
    >>> found = tradeoff(scene, "polar_order=20%", "5s")
    >>> found.recommended["time.end"] >= 100.0
    True
    """
    require_scene(scene)
    targets = [want] if isinstance(want, str) else list(want)
    if not isinstance(budget, str):
        raise ArgumentError(f'budget = {budget!r}; expected a time, such as "20min"')
    if slurm:
        folder = folder_for_jobs(folder)
        options = [word for target in targets for word in ("--want", target)]
        scene = submit("tradeoff", scene, folder, slurm, [*options, "--budget", budget])
        return Submitted(folder, lambda: _drover.tradeoff_status(scene._native, folder),
                         lambda: tradeoff(scene, want, budget, folder=folder, collect=True))
    with tempfile.TemporaryDirectory(prefix="drover-tradeoff-") as scratch:
        kept = os.path.join(scratch, "trials") if folder is None else os.path.abspath(folder)
        result = call("tradeoff", scene, want=targets, budget=budget, folder=kept, workers=workers, collect=collect,
                      quiet=quiet)
    return Tradeoff(result, scene)


def with_accuracy(scene, want, quiet=True):
    """The scene of the cheapest run with these errors, as `drover run --accuracy` finds it."""
    targets = [want] if isinstance(want, str) else list(want)
    result = call("with_accuracy", scene, want=targets, quiet=quiet)
    if "scene" not in result:
        raise Error("the trials gave no scene", fault="run")
    return type(scene).parse(result["scene"], scene.name)
