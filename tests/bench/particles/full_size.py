"""tests/bench/particles/full_size.py: a flock of the paper's rods as printed in a cell of the paper's size.

Usage: full_size.py --drover PROGRAM --output FOLDER [--table-only]

A cell of 247.95 mm, 55 rod lengths, holds 73 385 beads and 1642 rods at (.60, .11).  From disorder, order would have to
grow across the whole cell, for several hundred seconds; so rods are first held along x by a torque for 4 s, in which
beads reach the speed of a flock, and then let go.  FOLDER/full-size.csv gets a row a second of the time after that.
Both parts resume from their checkpoints, so the run may be stopped at any time, and --table-only writes the table of
what there is.  One simulated second takes two and a half minutes of a core.

CRITERION, written before the run: P from 20 to 40 s after the rods are let go is above .6, as in the smaller cells.
By then a rod has lost its direction four times, and the mean flow has decayed and been made again twenty times."""
import argparse
import sys
from pathlib import Path

from flocks import measure, run_or_resume, said, write

sys.path.insert(0, str(Path(__file__).resolve().parents[2]))
from studies import version_of  # noqa: E402

CELL = {"cell.lx": 247.95, "cell.ly": 247.95, "output.sample_every": 0.1025}
HELD = {**CELL, "forces.torque": 300.0, "time.end": 4.0, "output.frame_every": 4.0, "run.seed": 1}
FREE = {**CELL, "packing.kind": "file", "output.frame_every": 5.0, "run.seed": 2, "time.end": 60.0}
CRITERION = {"from": 20.0, "to": 40.0, "above": 0.6}


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--drover", required=True, help="the program")
    parser.add_argument("--output", required=True, type=Path, help="folder of the table and of the archives")
    parser.add_argument("--table-only", action="store_true", help="no runs: the table of the archive that is there")
    arguments = parser.parse_args()
    arguments.output.mkdir(parents=True, exist_ok=True)
    held, free = (arguments.output / f"full-size-{part}.h5" for part in ("held", "free"))
    if not arguments.table_only:
        run_or_resume(arguments.drover, "paper-flock", HELD, held)
        run_or_resume(arguments.drover, "paper-flock", {**FREE, "packing.file": str(held.resolve())}, free)
    columns, _ = measure(free, "paper-flock")
    header = f"# paper-flock.toml {said(FREE)}, after {said(HELD)}; {version_of(arguments.drover)}\n"
    write(arguments.output / "full-size.csv", header, [columns, *zip(*columns.values())])
    until = min(CRITERION["to"], columns["time"][-1])
    after = (columns["time"] > CRITERION["from"]) & (columns["time"] <= until)
    found = columns["polar_order"][after].mean() if after.any() else None
    print(f"P from {CRITERION['from']:g} to {until:.3g} s of {CRITERION['to']:g}: {found}; above {CRITERION['above']} "
          "is expected")
    return 0


if __name__ == "__main__":
    sys.exit(main())
