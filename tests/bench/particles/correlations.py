"""tests/bench/particles/correlations.py: correlations of directions and fluctuations of the number of rods in a cell of
20 rod lengths, kept as small tables.

Usage: correlations.py --drover PROGRAM --output FOLDER [--rods matched | printed] [--beads FRACTION ...] [--seconds T]

Each area fraction of beads is a run of models/bead-flock.toml in a cell of 90 mm, with the rods of RODS in flocks.py.
FOLDER/correlations-FRACTION.csv gets the summary of its archive: a row for each number, with its place (a separation of
rods or the side of a box [mm]; empty for numbers of the whole cell) and its standard error, after the warm-up that the
summary leaves out.  A table that is there is not made again, and a run that was stopped goes on.  10 to 25 minutes of
one core each with matched rods, half an hour to an hour with those as printed. """
import argparse
import sys
from pathlib import Path

import h5py
import numpy as np
from flocks import RODS, Stopped, keep

BEADS = (0.2, 0.4, 0.6)
WHOLE = ("polar_order", "polar_order_binder", "polar_order_susceptibility", "bead_velocity_along_order")
PLACES = {"rod_separation": ("polar_correlation", "polar_correlation_total"),
          "box_side": ("rod_number", "rod_number_deviation", "bead_number", "bead_number_deviation")}


def rows_of(archive):
    """Rows of the table, from the summary of an archive."""
    with h5py.File(archive) as file:
        summary = file["summary"]
        yield ["quantity", "place_mm", "value", "error"]
        yield ["warm_up_s", "", float(summary["warm_up"][()]), 0.0]
        for name in WHOLE:
            yield [name, "", float(summary[name][()]), float(summary[name + "_error"][()])]
        for places, names in PLACES.items():
            for name in names:
                for row in zip(summary[places][()], summary[name][()], summary[name + "_error"][()]):
                    if np.isfinite(row[1]):
                        yield [name, *map(float, row)]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--drover", required=True, help="the program")
    parser.add_argument("--output", required=True, type=Path, help="folder of the tables")
    parser.add_argument("--rods", default="matched", choices=RODS)
    parser.add_argument("--beads", nargs="*", type=float, default=BEADS, help="area fractions")
    parser.add_argument("--seconds", type=float, default=200.0)
    arguments = parser.parse_args()
    arguments.output.mkdir(parents=True, exist_ok=True)
    for beads in arguments.beads:
        table = arguments.output / f"correlations-{beads}.csv"
        if table.exists():
            continue
        settings = {"beads.area_fraction": beads, "cell.lx": 90.0, "cell.ly": 90.0,
                    "time.end": arguments.seconds, "output.frame_every": 10.0, "output.sample_every": 0.1025,
                    **RODS[arguments.rods]}
        try:
            keep(arguments.drover, table, "bead-flock", settings, rows_of)
        except Stopped:
            return 3
    return 0


if __name__ == "__main__":
    sys.exit(main())
