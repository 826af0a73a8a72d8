"""drover/lookup.py: what files hold, and what scenes may hold."""
import json
import os

from drover import _drover
from drover.error import Error
from drover.locks import hdf5


def info(file):
    """What an archive, a table of coefficients or an XYZ file holds, as `drover info --json`: a dict.

    `attributes` is the provenance, with the scene; `results` the means with errors and linear theory.

    >>> from drover import Scene
    >>> Scene.from_dict({"grid": {"nx": 16, "ny": 16}, "time": {"dt": 0.1, "end": 1.0}}).run("means.h5").close()
    >>> info("means.h5")["results"]["polar_order"]["unit"]
    '1'
    """
    with hdf5():
        return json.loads(_drover.info(os.fspath(file)))


def diff(one, other):
    """The keys in which two scenes differ, as `drover diff`: {key: (value in one, value in other)}, values as TOML.

    Each is a file of a scene, or an archive for the scene that it stores.  None: the scene has no such key.

    >>> from drover import Scene
    >>> scene = Scene.from_dict({"grid": {"nx": 16, "ny": 16}, "time": {"dt": 0.1, "end": 1.0}})
    >>> scene.run("one.h5").close()
    >>> scene.set({"time.end": 2.0}).run("other.h5").close()
    >>> diff("one.h5", "other.h5")["time.end"]
    ('1.0', '2.0')
    """
    with hdf5():
        return _drover.differences(os.fspath(one), os.fspath(other))


def schema(kind=""):
    """All sections of scenes with their keys, units, ranges, defaults and meaning; of one kind if it is given.

    >>> [row["unit"] for part in schema("fields") if part["name"] == "grid" for row in part["rows"] if "unit" in row]
    ['mm', 'mm']
    """
    if kind not in ("", "fields", "particles", "model"):
        raise Error(f'kind = "{kind}"; expected "fields", "particles", "model", or "" for all')
    return json.loads(_drover.schema(kind))


def coefficients():
    """The coefficients of the equations as a table in Markdown."""
    return _drover.coefficients()
