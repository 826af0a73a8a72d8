"""drover/sweeping.py: many runs of one scene, and their table."""
import os
import tempfile
import warnings
from collections.abc import Mapping
from pathlib import Path

from drover.campaign import folder_for_jobs, submit
from drover.error import ArgumentError, Error, require_scene
from drover.toml import value_text
from drover.worker import call


PLAIN = {"share": 1, "shares": 1, "collect": False}  # one process does all


class Sweep:
    """The table of a sweep.

    `data` is an xarray Dataset over the varied keys (and the branch of a ramp) with every observable, also structure
    factors, spectra and number fluctuations over their own axes, and units.  Beside each mean over the seeds is
    <name>_error; with several seeds <name>_of_runs has each run, along the axis `seed`.  A sweep in a folder keeps it
    as table.nc there: xarray.open_dataset("noise.sweep/table.nc").
    """

    def __init__(self, result, values=None, data=None):
        self.values = values                # of the scene: {section: {key: value}}
        self.keys = result["keys"]
        self.rows = result["rows"]          # one dict for each point
        self.warnings = result["warnings"]  # "point-0000-seed-7: ..."
        self.failed = result["failed"]      # number of failed jobs
        self.failures = result["failures"]  # why they failed: "point-0000-seed-7: ..."
        self.text = result["text"]
        self.data = data

    def __repr__(self):
        return self.text + "".join(f"failed: {reason}\n" for reason in self.failures)

    def __getattr__(self, name):
        if name.startswith("_") or self.data is None:
            raise AttributeError(name)
        try:
            return self.data[name]
        except KeyError:
            raise AttributeError(f"the sweep has no {name}; expected one of {', '.join(map(str, self.data))}") from None

    def plot(self, name, axes=None):
        """Draws an observable over the varied key, with errors; of two keys a map; of a spectrum, or another observable
        with an axis of its own, a line for each value of the key.  Returns the matplotlib axes."""
        from drover.figures.sweep_panels import draw_sweep
        return draw_sweep(self, name, axes)


def sweep(scene, vary, *, seeds=1, want=None, max_seeds=64, refine=None, refine_levels=3, ramp="none", keep="archives",
          workers=0, folder=None, slurm=0, quiet=True):
    """Runs a scene over the values of some keys, as `drover sweep`; returns a Sweep.

    `vary` is {"relaxation.rate": [0.5, 1, 2]} or {"relaxation.rate": "0.5:2:11"} (first:last:count); several keys make
    a grid. `folder` keeps an archive of each run, or with `keep="table"` the results alone; by default nothing is kept.
    The same call resumes; one with other values, more seeds or another refinement adds the runs that are not there.
    `want={"polar_order": "2%"}` adds seeds at each point until the mean there has this standard error, up to
    `max_seeds`, beyond which a warning names it. `refine={"polar_order": 0.1}` adds points between neighbours that
    differ by more than 0.1, and by more than twice their standard error, `refine_levels` times at most: then all
    results are along one axis, `point`. `ramp` ("up", "up-down") starts each point from the end of the one before; of
    several keys the last is ramped. `workers` is the number of simultaneous runs. Runs that fail leave a gap in the
    table, and a Python warning that says why; `failures` lists the reasons. `slurm=40` submits 40 jobs to Slurm
    instead, and returns a SlurmSweep at once.

    >>> from drover import Scene
    >>> scene = Scene.from_dict({"grid": {"nx": 16, "ny": 16}, "time": {"dt": 0.1, "end": 1.0}})
    >>> sweep(scene, {"relaxation.rate": [0.5, 1.0]}).polar_order.dims
    ('relaxation.rate',)
    """
    require_scene(scene)
    for name, value in (("vary", vary), ("want", want or {}), ("refine", refine or {})):
        if not isinstance(value, Mapping):
            raise ArgumentError(f"{name} = {value!r}; expected a dict: {{key: values}} of vary, {{observable: change}} "
                                "of the others")
    varied = [f"{key} = {values_text(key, values)}" for key, values in vary.items()]
    changes = {"sweep.vary": varied, "sweep.seeds": seeds, "sweep.ramp": ramp, "sweep.keep": keep}
    if want:
        changes |= {"sweep.want": [f"{name}={error}" for name, error in want.items()], "sweep.max_seeds": max_seeds}
    if refine:
        changes |= {"sweep.refine": [f"{name} = {change}" for name, change in refine.items()],
                    "sweep.refine_levels": refine_levels}
    if workers:
        changes["sweep.workers"] = workers
    scene = scene.set(changes)
    if slurm:
        folder = folder_for_jobs(folder)
        return SlurmSweep(submit("sweep", scene, folder, slurm), folder)
    if folder is not None:
        return finished(scene, os.path.abspath(folder), {**PLAIN, "quiet": quiet})
    with tempfile.TemporaryDirectory(prefix="drover-sweep-") as scratch:
        return finished(scene, os.path.join(scratch, "sweep"), {**PLAIN, "quiet": quiet})


class SlurmSweep(Sweep):
    """A sweep whose runs are jobs of Slurm, without a table of its own: see status() and collect()."""

    def __init__(self, scene, folder):
        super().__init__({"keys": [], "rows": [], "warnings": [], "failed": 0, "failures": [], "text": ""},
                         scene.values)
        self.scene = scene
        self.folder = folder

    def __repr__(self):
        return self.status()

    def status(self):
        """One line: runs done, failed, running, their rate and the time left."""
        from drover import _drover
        if not os.path.isdir(self.folder):
            return "no share has started yet"
        return _drover.sweep_status(self.scene._native, self.folder)

    def collect(self):
        """The Sweep of the runs that have ended."""
        return finished(self.scene, self.folder, {**PLAIN, "collect": True, "quiet": True})


def values_text(key, values):
    """The values of one key, as the program takes them."""
    if isinstance(values, str):
        return values
    if not hasattr(values, "__iter__"):
        raise Error(f'{key} = {values!r}; expected a list of values, or a text "first:last:count": to run one value, '
                    f'write {{"{key}": [{values!r}]}}')
    return value_text(list(values))[1:-1]


def finished(scene, folder, options):
    """Runs what is missing, or collects; the Sweep."""
    result = call("sweep", scene, folder=folder, **options)
    if not any(row["seeds"] for row in result["rows"]):
        reasons = "; ".join(result["failures"]) or result["log"].strip()[-2000:]
        raise Error(f"no run of the sweep ended: {reasons}", fault="run")
    found = Sweep(result, scene.values, dataset_of(Path(folder, "table.nc"), result["keys"]))
    if found.failed:
        warnings.warn(f"{found.failed} jobs of the sweep failed: {'; '.join(found.failures)}",
                      stacklevel=3)
    return found


def dataset_of(file, keys):
    """A table.nc in memory, with the keys of the scene as its axes."""
    from drover.archive import opened
    from drover.hdf5_reader import group_dataset
    store, data = opened(Path(file), lambda store, _: (store, group_dataset(store, "/").load()))
    store.close()
    if "branch" in data.coords:
        data = data.assign_coords(branch=["down" if branch else "up" for branch in data.branch.values])
    data["seeds"] = data.seeds.astype(int)
    names = {key.replace(".", "_"): key for key in keys}
    return data.rename({name: key for name, key in names.items() if name in data.variables})
