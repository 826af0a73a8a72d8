"""drover/commands.py: the commands that start from an archive or a table."""
import json
import os
from numbers import Integral
from pathlib import Path

from drover import _drover
from drover.error import ArgumentError, require_scene
from drover.locks import hdf5


def restart(archive, *, end=None, checkpoint_minutes=None, threads=0, functions=(), quiet=True):
    """Resumes a run from its latest valid checkpoint, as `drover restart`; returns the open archive.

    `end` [s] is a later time.end; `functions`: the Python functions that are terms of the scene, by their names.

    >>> from drover import Scene
    >>> scene = Scene.from_dict({"grid": {"nx": 16, "ny": 16}, "time": {"dt": 0.1, "end": 1.0}})
    >>> scene.run("longer.h5").close()
    >>> with restart("longer.h5", end=2.0) as run:
    ...     float(run.frames.time[-1])
    2.0
    """
    from drover.archive import open_run
    from drover.toml import value_text
    changes = {"time.end": end, "output.checkpoint_minutes": checkpoint_minutes, "run.threads": threads or None}
    settings = [f"{key}={value_text(value)}" for key, value in changes.items() if value is not None]
    given = {}
    if functions:
        from drover.functions import functions_by_number
        with open_run(archive) as run:
            given = functions_by_number(run.scene.get("terms", []), functions)
    if given:
        with hdf5():
            done = _drover.restart_run(os.fspath(archive), settings, given, quiet)
    else:
        from drover.worker import call
        done = call("restart_run", archive=os.fspath(archive), settings=settings, functions={}, quiet=quiet)
    return open_run(done["archive"])


def onset(table, *, varied=None, cell=None, points=(), draws=400, output=None, overwrite=False):
    """The flocking threshold that a table of coefficients predicts, as `drover boundary TABLE`: a Theory.

    `cell`: also the order of the rods of a square cell of this side [mm], at `points`, pairs of the area fractions of
    beads and rods, or at the nodes of the table.  `draws`: of the table within its errors, for the error bands.
    """
    from drover.computed import theory_of
    if draws < 20:
        raise ArgumentError(f"draws = {draws}; expected at least 20, which errors need")
    if not hasattr(points, "__len__"):
        raise ArgumentError(f"points = {points!r}; expected pairs of area fractions, [(0.5, 0.1)]")
    if len(points) and cell is None:
        raise ArgumentError("points apply to a cell; expected its side, cell [mm], or no points")
    with hdf5():
        result = _drover.onset(os.fspath(table), varied, cell, [tuple(point) for point in points], draws)
        if output is not None:
            result.write(os.fspath(output), overwrite)
    return theory_of(result, os.path.basename(os.fspath(table)))


def fit(archive, keys, *, scene=None, max_wavenumber=None, begin=0.0, end=None, every=1):
    """Coefficients of the field equations from the waves of a run, as `drover fit --json`: a dict.

    `keys`: the numbers of the model to fit.  `scene`: a Scene of fields with the equations, starting values and all
    other numbers; that of the archive if it is not given.  `max_wavenumber` [1/mm], frames from `begin` to `end` [s],
    one in `every`.

    >>> from drover import Scene
    >>> scene = Scene.from_dict({"grid": {"nx": 16, "ny": 16}, "time": {"dt": 0.5, "end": 100.0},
    ...                          "relaxation": {"rate": 0.5}, "noise": {"order": 0.1},
    ...                          "output": {"frame_every": 0.5, "sample_every": 0.5}})
    >>> scene.run("waves.h5").close()
    >>> found = fit("waves.h5", ["relaxation.rate", "noise.order"])["coefficients"][0]
    >>> abs(found["value"] - 0.5) < 5.0 * found["error"]
    True
    """
    if scene is not None:
        require_scene(scene)
    native = None if scene is None else scene._native
    if not isinstance(keys, (str, list, tuple)):
        raise ArgumentError(f'keys = {keys!r}; expected names of numbers of the model, ["section.key"]')
    keys = [keys] if isinstance(keys, str) else list(keys)
    with hdf5():
        return json.loads(_drover.fit(os.fspath(archive), keys, native, max_wavenumber, begin, end, every))


def export(archive, output, *, frame=None, every=1, bodies=False, overwrite=False):
    """Writes frames for viewers, as `drover export`; returns the files.

    Particles as extended XYZ (`output` ends in .xyz; `bodies`: one line per body), fields as VTK images (.vtk, a
    numbered file for each frame unless one `frame` is chosen, from 0 or, below 0, from the end) or as one table (.csv).

    >>> from drover import Scene
    >>> scene = Scene.from_dict({"grid": {"nx": 16, "ny": 16}, "time": {"dt": 0.1, "end": 1.0}})
    >>> scene.run("flock.h5").close()
    >>> [path.name for path in export("flock.h5", "flock.vtk")]
    ['flock-0000.vtk', 'flock-0001.vtk']
    """
    names = os.fspath(archive), os.fspath(output)
    if frame is not None and not isinstance(frame, Integral):
        raise ArgumentError(f"frame = {frame!r}; expected the number of one frame, or None: all")
    if frame is not None and every != 1:
        raise ArgumentError(f"frame = {frame} and every = {every}; expected one of them")
    kind = Path(output).suffix
    if kind not in (".vtk", ".csv", ".xyz", ".extxyz"):
        raise ArgumentError(f'{output}: the name ends with "{kind}"; expected .xyz of particles, or .vtk or .csv of '
                            "fields")
    chosen = -1 if frame is None else from_start(archive, frame) if frame < 0 else frame  # -1: all
    with hdf5():
        if not names[1].endswith((".vtk", ".csv")):
            _drover.export_xyz(*names, chosen, every, bodies, overwrite)
            return [Path(output)]
        if bodies:
            raise ArgumentError(f"bodies applies to particles, and {output} is of fields; expected a .xyz or no bodies")
        return list(_drover.export_fields(*names, chosen, every, overwrite))


def from_start(archive, frame):
    """The number of a frame that is counted from the end of an archive, from -1."""
    from drover.theory import Theory, open_any
    with open_any(archive) as found:
        frames = found.groups.get("frames") if isinstance(found, Theory) else found.frames
        count = 0 if frames is None else frames.sizes["state" if isinstance(found, Theory) else "time"]
    if count == 0:
        raise ArgumentError(f"{archive} has no frames; expected an archive that has")
    if -frame > count:
        raise ArgumentError(f"{archive} has no frame {frame}; expected 0 to {count - 1}, or a negative number counted "
                            "from the end")
    return count + frame
