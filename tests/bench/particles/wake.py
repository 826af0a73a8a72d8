"""tests/bench/particles/wake.py: the flow of beads around one moving rod, in its frame.

Usage: wake.py --drover PROGRAM --output FOLDER [--rods matched | printed] [--seconds S]

Runs one rod of rod-in-beads.toml in a cell of 27 mm at three area fractions of beads; the mean velocity of the beads is
held at zero, since these plates do not stop a flow that one rod keeps up.  FOLDER/wake-BEADS.csv gets the mean velocity
of the beads at each place of the frame of the rod [mm, mm/s] (flow_velocity_along and flow_velocity_across of the
archive), where there were beads.  A table that is there is not made again, and a run that was stopped goes on.
"""
import argparse
import sys
from pathlib import Path

import h5py
import numpy as np
from flocks import RODS, Stopped, keep

BEADS = (0.5, 0.6, 0.7)


def flow(archive):
    """Rows: place ahead of the rod and to its left, velocity along and across it."""
    with h5py.File(archive) as file:
        summary = file["summary"]
        along, across = (summary[f"flow_velocity_{part}"] for part in ("along", "across"))
        axes = [along.dims[axis][0][()] for axis in (0, 1)]
        x, y = np.meshgrid(*axes, indexing="ij")
        columns = np.column_stack([part.ravel() for part in (x, y, along[()], across[()])])
    return [["ahead_mm", "left_mm", "along_mm_s", "across_mm_s"], *columns[np.isfinite(columns).all(axis=1)]]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--drover", required=True, help="the program")
    parser.add_argument("--output", required=True, type=Path, help="folder of the tables")
    parser.add_argument("--rods", default="matched", choices=RODS)
    parser.add_argument("--seconds", type=float, default=200.0)
    arguments = parser.parse_args()
    arguments.output.mkdir(parents=True, exist_ok=True)
    for beads in BEADS:
        table = arguments.output / f"wake-{beads}.csv"
        if table.exists():
            continue
        settings = {"beads.area_fraction": beads, "cell.lx": 27.0, "cell.ly": 27.0, "forces.hold_beads": True,
                    "time.end": arguments.seconds, "output.frame_every": 0.1, "output.sample_every": 0.1,
                    **RODS[arguments.rods]}
        try:
            keep(arguments.drover, table, "rod-in-beads", settings, flow)
        except Stopped:
            return 3
    return 0


if __name__ == "__main__":
    sys.exit(main())
