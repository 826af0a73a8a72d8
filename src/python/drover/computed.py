"""drover/computed.py: results of the library in memory as xarray datasets, like those of an archive."""
import json
from pathlib import Path

import xarray

from drover.attributes import about
from drover.theory import NEEDED, Theory, of_states


def dataset_of(parts, first=None):
    """A dataset of {axes, arrays}; `first`: name, values and unit of an axis before the others."""
    axes = [(name, values, about(name, unit, meaning)) for name, unit, meaning, values in parts["axes"]]
    lead = () if first is None else (first[0],)
    variables = {name: (lead + tuple(dims), values, about(name, unit, meaning))
                 for name, (unit, meaning, dims, values) in parts["arrays"].items()}
    coordinates = {name: (name, values, words) for name, values, words in axes}
    if first is not None:
        coordinates[first[0]] = first
    return xarray.Dataset(variables, coordinates)


def theory_of(result, scene_file):
    """The Theory of a result that has not been written."""
    tables = {table["group"].strip("/"): dataset_of(table) for table in result.tables()}
    kept = {name: table for name, table in tables.items() if result.kind in ("stability", "states") or name in NEEDED}
    frames = result.frames()
    if frames is not None:
        count = len(next(iter(frames["arrays"].values()))[3])
        kept["frames"] = of_states(dataset_of(frames, ("state", range(count))))
    scene = result.scene
    attributes = {"title": f"drover {result.kind}", "scene_file": scene_file, **dict(result.attributes)}
    import tomllib
    return Theory(Path(scene_file), result.kind, kept, tomllib.loads(scene.text), attributes, None, result.text,
                  json.loads(result.json))
