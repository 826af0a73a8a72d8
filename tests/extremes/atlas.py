#!/usr/bin/python3
"""tests/extremes/atlas.py: what drover answers at the extremes of its scenes.

    atlas.py fields|theory|particles --drover PROGRAM --output FOLDER [--count N] [--first N] [--seconds S]

draws scenes (number n is the same for everyone) in which one to three keys have extreme values: coefficients times
1e-12 to 1e12, grids of 1 to 2048 points, steps times 1e-12 to 1e6, vacua, noise from 0 to huge, impacts without loss or
without bounce.  Each scene is run, and each answer that was given without a warning is compared with one that is
finer (fields), of 60 digits (theory), or with what must hold for any bodies (particles).  FOLDER/KIND.csv has the
outcome of each scene:

    right      no warning, and right
    warned     done, with a warning
    stopped    the run failed with a sentence (status 1)
    refused    the scene was rejected with a sentence (status 2)
    undecided  no warning, but what it would be compared with failed
    SILENT     no warning, and wrong
    slow       no end within a minute (--seconds)
    CRASH      any other end: a signal, no sentence

Rows that exist are kept: re-run to resume.  The status is 1 when an outcome is SILENT or CRASH.
"""
import argparse
import collections
import sys
import tempfile
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
import bodies  # noqa: E402
import plane_waves  # noqa: E402
import program  # noqa: E402
import waves  # noqa: E402
from studies import KeptTable  # noqa: E402

KINDS = {"fields": waves, "theory": plane_waves, "particles": bodies}
COLUMNS = ("scene", "outcome", "measure", "what", "message")


def row_of(kind, drover, number):
    with tempfile.TemporaryDirectory() as folder:
        keys, changed = KINDS[kind].scene(number)
        outcome, measure, message = KINDS[kind].judge(drover, Path(folder), keys)
    return {"scene": number, "outcome": outcome, "measure": measure, "what": changed,
            "message": " ".join(message[:160].split())}


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("kind", choices=KINDS)
    parser.add_argument("--drover", default="drover")
    parser.add_argument("--output", type=Path, required=True)
    parser.add_argument("--count", type=int, default=100)
    parser.add_argument("--first", type=int, default=0)
    parser.add_argument("--seconds", type=float, default=program.limit["seconds"], help="of a run of the program")
    options = parser.parse_args()
    program.limit["seconds"] = options.seconds
    table = KeptTable(options.output / f"{options.kind}.csv", COLUMNS)
    known = {int(row["scene"]) for row in table.rows}
    outcomes = collections.Counter()
    for number in range(options.first, options.first + options.count):
        if number in known:
            continue
        row = row_of(options.kind, options.drover, number)
        table.add(row)
        outcomes[row["outcome"]] += 1
        if row["outcome"].isupper():
            print(number, row["outcome"], row["measure"], row["what"], row["message"], flush=True)
    print(dict(outcomes))
    return 1 if outcomes["SILENT"] or outcomes["CRASH"] else 0


if __name__ == "__main__":
    sys.exit(main())
