"""drover/theory.py: reads archives of drover stability, drover boundary (of scenes and tables) and drover states."""
from dataclasses import dataclass
from pathlib import Path

from drover.archive import check_is_no_table, kind_of, opened, read_head, read_run
from drover.attributes import about
from drover.error import DroverError
from drover.hdf5_reader import Store, StoreOwner, group_dataset

BRANCH, SLOW, BAND = ("angle", "wavenumber", "branch"), ("angle", "slow_mode"), ("band_line", "band_y", "band_x")
# Required arrays with their axes, by command or, for drover boundary, by group.
NEEDED = {"stability": {"growth_rate": BRANCH},
          "boundary": {name: ("vertex",) for name in ("line", "limit", "closed", "x", "y", "angle")},
          "band": {"deviation": BAND, "limit": BAND[:1]},
          "curves": {name: ("rod_fraction", "bead_fraction") for name in ("drag", "drag_error", "threshold",
                                                                          "threshold_error")},
          "line": {name: ("line_rod_fraction",) for name in ("mean", "mean_error", "mean_share", "single_rod",
                                                             "single_rod_error", "single_rod_share")},
          "crossings": {name: ("crossing",) for name in ("crossing_rod_fraction", "convention", "bead_area_fraction",
                                                         "low", "high")},
          "field": {f"{name}_{what}": ("rod_fraction", "bead_fraction") for name in ("mean", "single_rod")
                    for what in ("excess", "deviation")},
          "cells": {name: ("cell",) for name in ("bead_area_fraction", "rod_area_fraction", "order")},
          "map": {"regime": ("map_y", "map_x")}}
# The same of drover boundary for a model of its own.
OF_MODEL = {"boundary": {name: ("vertex",) for name in ("line", "state", "closed", "x", "y", "angle", "wavenumber",
                                                        "wave_frequency")},
            "band": {"deviation": BAND, "state": BAND[:1]},
            "map": {"stable_states": ("map_y", "map_x")}}
# Optional arrays with their axes.
KNOWN = {"frequency": BRANCH, "slow_speed": SLOW, "slow_growth": SLOW, "slow_damping": SLOW}
FACTORS = {"structure_factor_": ("angle", "wavenumber"), "dynamic_structure_factor_": ("angle", "frequency_axis")}


# The first of these groups that is there.
MAIN = ("ordered", "along_the_field", "isotropic", "boundary", "line", "state")


@dataclass(frozen=True)
class Theory(StoreOwner):
    """Linear theory, computed or in an archive: theory.growth_rate is an array of its main group.

    The arrays of an archive are read when they are used; close() it, or open it using `with`.
    """

    path: Path        # of the archive, or the name of the scene
    kind: str         # "stability", "boundary", "onset" (drover boundary TABLE) or "states"
    groups: dict      # name -> xarray.Dataset: states ("ordered", ...), "boundary" and "map", "curves" and "line";
                      # of drover states "state", "curve" and "frames"
    scene: dict       # all keys with their values: scene["relaxation"]["rate"]
    attributes: dict  # provenance: version, commit, host, ...
    store: Store | None = None   # None if computed
    text: str = ""               # tables for people, as the command prints them; "" from an archive
    values: dict | None = None   # the same as data, as with --json

    def close(self):
        if self.store is not None:
            self.store.close()

    @property
    def main(self):
        """The group of the most ordered state, or of the lines."""
        return self.groups[next((name for name in MAIN if name in self.groups), next(iter(self.groups)))]

    def __getattr__(self, name):
        if name.startswith("_") or not self.groups or name not in self.main:
            raise AttributeError(f"this theory has no {name}; see groups")
        return self.main[name]

    def __repr__(self):
        return self.text or f"<drover.Theory {self.kind} of {self.path}: {', '.join(self.groups)}>"

    def plot(self, state=None):
        """The figure of python3 -P -m drover.figure; `state` chooses a uniform state of a stability analysis."""
        from drover.figures.theory_figures import draw_theory
        return draw_theory(self, state)


def open_theory(path):
    """Opens an archive of drover stability, boundary or states.  Raises DroverError if it is not one, or is damaged."""
    return opened(Path(path), read_theory)


def open_any(path):
    """Opens a Run, a Theory or, as one without groups, a table of coefficients.  Raises DroverError if the file is not
    an archive, or is damaged."""
    def read(store, path):
        attributes, scene = read_head(store, path)
        if (kind := kind_of(attributes)) == "calibrate":
            return Theory(path, kind, {}, scene, attributes, store)
        return read_run(store, path) if kind == "run" else read_theory(store, path)

    return opened(Path(path), read)


def read_theory(store, path):
    attributes, scene = read_head(store, path)
    kind = kind_of(attributes)
    if kind == "run":
        raise DroverError(f"{path} is a run; expected an archive written by drover stability or drover boundary: open "
                          f"it with "
                          "drover.open_run")
    check_is_no_table(path, kind)
    if kind == "states":
        groups = {name: group_dataset(store, name) for name in ("state", "curve") if f"/{name}" in store.groups}
        check_states(path, groups)
        groups["frames"] = of_states(group_dataset(store, "/").rename(time="state"))
        return Theory(path, kind, groups, scene, attributes, store)
    groups = {name: group_dataset(store, name) for name in store.groups_in("/")
              if kind == "stability" or name in NEEDED}
    of_model = any("state" in group or "stable_states" in group for group in groups.values())
    needed = {**NEEDED, **OF_MODEL} if of_model else NEEDED
    for name, group in groups.items():
        check_group(path, name, group, needed["stability" if kind == "stability" else name])
    return Theory(path, kind, groups, scene, attributes, store)


def of_states(frames):
    """Frames of states, whose axis is their number."""
    frames["state"].attrs = about("state", "1", "number of the state, from 0")
    return frames


def check_states(path, groups):
    for group, needed in (("state", ("speed", "growth_rate", "residual")),
                          ("curve", ("curve_parameter", "curve_fold", "curve_growth_rate"))):
        missing = [name for name in needed if name not in groups.get(group, needed)]
        if missing or "state" not in groups:
            raise DroverError(f"{path}: the group {group} has no {missing[0] if missing else 'speed'}; the file is "
                              "from another version of drover, or damaged")


def check_group(path, group, dataset, needed):
    factors = {name: axes for name in dataset for start, axes in FACTORS.items() if str(name).startswith(start)}
    for name, axes in {**KNOWN, **factors, **needed}.items():
        missing = name not in dataset and name in needed
        if missing or (name in dataset and dataset[name].dims != axes):
            raise DroverError(f"{path}: the group {group} has no {name} over {', '.join(axes)}; the file is from "
                              "another version of drover, or damaged")
