"""drover/calibration.py: coefficients of the equations measured on particles."""
import os
from numbers import Integral
from pathlib import Path

from drover import _drover
from drover.campaign import Submitted, folder_for_jobs, submit
from drover.error import Error, require_scene
from drover.worker import call


class Calibration:
    """The outcome of a calibration."""

    def __init__(self, result):
        self.file = Path(result["file"]) if result["file"] else None  # of the table; none for a share
        self.coefficients = result.get("coefficients")  # {name: {unit, formula, points: [{value, error, ...}]}}
        self.trials_run, self.trials_found = result["trials_run"], result["trials_found"]
        self.failed, self.unfinished, self.unmet = result["failed"], result["unfinished"], result["unmet"]
        self.want = result.get("want")  # wanted numbers, what their errors come from, and core seconds
        self.text = result["text"]

    def __repr__(self):
        return self.text or f"<drover.Calibration: {self.trials_run} trials>"

    def onset(self, varied=None):
        """The flocking threshold that the table predicts."""
        from drover.commands import onset
        return onset(self.file, varied=varied)


def calibrate(scene, folder=None, *, want=(), budget="", workers=0, share=(1, 1), collect=False, slurm=0, quiet=True):
    """Measures the coefficients of a scene with [calibrate], as `drover calibrate`; the same call resumes.

    `folder` holds the trials and the table; default: the name of the scene with .calibration.  Any number of calls, on
    any machines, share the work in one folder; `share` = (2, 8) is the second of eight, and only the last makes the
    table; `collect` runs nothing and makes the table of what has ended.  `slurm=40` submits 40 shares to Slurm instead,
    and returns at once an object with status() and collect().
    `want`: "onset=5%" or a list of such texts: trials are spread so that these numbers reach their standard errors at
    the least cost, in a core time of `budget` ("2h").
    """
    require_scene(scene)
    if workers:
        scene = scene.set("calibrate.workers", workers)
    first, shares = share
    targets = [want] if isinstance(want, str) else list(want)
    if slurm:
        folder = folder_for_jobs(folder)
        options = [word for target in targets for word in ("--want", target)] + (["--budget", budget] if budget else [])
        scene = submit("calibrate", scene, folder, slurm, options)
        return Submitted(folder, lambda: _drover.calibration_status(scene._native, folder, targets, budget),
                         lambda: calibrate(scene, folder, want=want, budget=budget, collect=True))
    return Calibration(call("calibrate", scene, folder=folder_of(scene, folder), share=first, shares=shares,
                            collect=collect, want=targets, budget=budget, quiet=quiet))


def slurm_script(scene, shares, folder=None):
    """A shell script that runs a calibration as `shares` array tasks of Slurm, as `drover calibrate --slurm`.

    >>> from drover import Scene
    >>> scene = Scene.from_dict({"cell": {"lx": 9.0, "ly": 9.0}, "calibrate.bead_area_fractions": [0.2]})
    >>> slurm_script(scene, 8).splitlines()[0]
    '#!/bin/sh'
    """
    require_scene(scene)
    if not isinstance(shares, Integral) or not 1 <= shares <= 100000:
        raise Error(f"shares = {shares!r}; expected a whole number from 1 to 100000")
    return _drover.slurm_script("calibrate", scene.name, list(scene.settings), folder_of(scene, folder), shares, [])


def folder_of(scene, folder):
    return os.path.abspath(Path(scene.name).stem + ".calibration" if folder is None else folder)
