#!/usr/bin/python3
"""tests/bench/noise/weak_orders.py: the bias of means that the time step causes under noise, for every method.

    weak_orders.py SCENE --drover PROGRAM --output FOLDER [--set key=value]... [--end S] [--seeds N] [--steps DT,DT,...]

runs SCENE with each method and step on the same noise paths (equal seeds), and writes FOLDER/weak_orders.csv: for each
method, step and observable the mean, the difference from the run with half the step, its standard error over blocks of
time and seeds, and the order log2(difference/next difference).  Runs that exist in FOLDER are kept: re-run to resume.

The error of the difference is that of pairs, which is smaller than that of the means: `scatter` is the standard error
that two independent runs of that length would have.
"""
import argparse
import csv
import math
import subprocess
from pathlib import Path

import h5py
import numpy

METHODS = ("exponential-euler", "etdrk2", "etdrk4", "etdrk4-krogstad")
BLOCKS = 10  # of time in each run


def arguments():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("scene", type=Path)
    parser.add_argument("--drover", default="drover")
    parser.add_argument("--output", type=Path, required=True)
    parser.add_argument("--set", action="append", default=[], dest="settings")
    parser.add_argument("--end", type=float, default=1000.0, help="length of a run [s]")
    parser.add_argument("--warm-up", type=float, default=50.0, help="left out of means [s]")
    parser.add_argument("--seeds", type=int, default=2)
    parser.add_argument("--steps", default="0.5,0.25,0.125,0.0625,0.03125,0.015625")
    parser.add_argument("--methods", default=",".join(METHODS))
    return parser.parse_args()


def run(options, method, dt, seed):
    """The archive of one run, made where it is missing."""
    archive = options.output / f"{method}-{dt:g}-{seed}.h5"
    if not archive.exists():
        part = archive.with_suffix(".part.h5")
        settings = [f"time.stepper={method}", f"time.dt={dt!r}", f"time.end={options.end!r}", f"run.seed={seed}",
                    f"output.file={part}", "output.frame_every=0", *options.settings]
        subprocess.run([options.drover, "run", options.scene, "--quiet", "--overwrite",
                        *(word for setting in settings for word in ("--set", setting))],
                       check=True, stdout=subprocess.DEVNULL)
        part.rename(archive)
    return archive


def blocks(archive, warm_up):
    """Means of each observable over blocks of time: name to array."""
    with h5py.File(archive) as file:
        group = file["observables"]
        late = group["time"][()] >= warm_up
        low = group["wavenumber"][()] < 1.0
        sides = group["box_side"][()]
        series = {"polar_order": group["polar_order"][()][late],
                  "structure_factor_rods(q<1)": group["structure_factor_rods"][()][late][:, low].mean(axis=1)}
        largest = int(numpy.searchsorted(sides, 0.5 * sides[-1]))
        series["rod_number_variance"] = group["rod_number_variance"][()][late][:, largest]
    return {name: numpy.array([part.mean() for part in numpy.array_split(values, BLOCKS)])
            for name, values in series.items()}


def mean_and_error(values):
    return values.mean(), values.std(ddof=1) / math.sqrt(len(values))


def main():
    options = arguments()
    options.output.mkdir(parents=True, exist_ok=True)
    steps = [float(word) for word in options.steps.split(",")]
    rows = []
    for method in options.methods.split(","):
        found = {}
        for dt in steps:
            of_seeds = [blocks(run(options, method, dt, seed + 1), options.warm_up) for seed in range(options.seeds)]
            found[dt] = {name: numpy.concatenate([one[name] for one in of_seeds]) for name in of_seeds[0]}
        for name in found[steps[0]]:
            differences = [mean_and_error(found[dt][name] - found[finer][name])
                           for dt, finer in zip(steps, steps[1:])]
            for i, (difference, error) in enumerate(differences):
                mean, scatter = mean_and_error(found[steps[i]][name])
                order = math.nan
                if i + 1 < len(differences) and differences[i + 1][0] * difference > 0.0:
                    order = math.log2(difference / differences[i + 1][0])
                rows.append({"method": method, "observable": name, "dt": steps[i], "mean": f"{mean:.6g}",
                             "difference": f"{difference:.4g}", "error": f"{error:.2g}",
                             "scatter": f"{math.sqrt(2.0) * scatter:.2g}", "order": f"{order:.2f}"})
    with open(options.output / "weak_orders.csv", "w", newline="") as file:
        writer = csv.DictWriter(file, rows[0].keys(), lineterminator="\n")
        writer.writeheader()
        writer.writerows(rows)
    for row in rows:
        print(" ".join(f"{value!s:>12}" for value in row.values()))


if __name__ == "__main__":
    main()
