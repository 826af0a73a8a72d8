#!/usr/bin/python3
"""tests/bench/tradeoff/band.py: what a travelling band costs along one line, and in two dimensions.

    band.py --drover PROGRAM

runs the exact band of models/band.toml, whose speed is sqrt(4/3) mm/s, in a square cell of 192 mm with 512 by 512
points, where its fronts do not feel each other, and on one line of 512.  The speed is that of the longest wave between
the first and the last frame.  Costs are core seconds of whole processes, less those of a process that takes one step.
"""
import argparse
import sys
import tempfile
from pathlib import Path

import h5py
import numpy

sys.path.insert(0, str(Path(__file__).resolve().parents[2]))
from studies import settings_of, timed  # noqa: E402

BAND = Path(__file__).resolve().parents[3] / "models" / "band.toml"
SIDE, STEP, STEPS = 192.0, 0.05, 40
FRONTS = "(1 / (1 + exp((x - 144) / sqrt(3))) + 1 / (1 + exp(-(x - 48) / sqrt(12))) - 1)"


def run(program, archive, rows, steps):
    """Core seconds of a run."""
    end = STEP * steps
    keys = {"grid.ny": rows, "grid.lx": SIDE, "grid.ly": SIDE, "initial.rod_density": f"5/6 + 0.5 * {FRONTS}",
            "initial.polar_order_x": f"1 / sqrt(3) * {FRONTS}", "time.stepper": "etdrk4-krogstad", "time.dt": STEP,
            "time.end": end, "output.frame_every": end, "output.sample_every": end, "run.threads": 1}
    ended, seconds = timed(program, "run", BAND, "--quiet", "--overwrite", "-o", archive, *settings_of(keys))
    if ended.returncode != 0:
        raise SystemExit(ended.stderr)
    return seconds


def speed_of(archive):
    with h5py.File(archive) as file:
        first, last = (file["rod_density"][frame].mean(axis=0) for frame in (0, -1))
        duration = file["time"][-1] - file["time"][0]
    turn = numpy.angle(numpy.fft.rfft(first)[1] / numpy.fft.rfft(last)[1])
    return turn * SIDE / (2.0 * numpy.pi * duration)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--drover", default="drover")
    program = parser.parse_args().drover
    costs = {}
    with tempfile.TemporaryDirectory() as folder:
        archive = Path(folder) / "band.h5"
        # Both last about as long: the line takes more steps.
        for rows, steps in ((512, STEPS), (1, 50 * STEPS)):
            costs[rows] = (run(program, archive, rows, steps) - run(program, archive, rows, 1)) / (steps - 1)
            run(program, archive, rows, STEPS)
            speed = speed_of(archive)
            print(f"512 by {rows}: {1e3 * costs[rows]:.3g} ms of a core for a step; speed {speed:.9f} mm/s, "
                  f"{speed - (4 / 3)**0.5:+.1e} from the exact one")
    print(f"the line costs {costs[512] / costs[1]:.0f} times less")


if __name__ == "__main__":
    main()
