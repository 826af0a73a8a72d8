"""tests/bench/particles/closure.py: whether flow and contacts are all that aligns rods, and add.

Usage: closure.py --table TABLE.h5 --flocks FOLDER/flocks.json [FOLDER/flocks.json ...]

From flocks.py: the order of rods among beads that move freely (cases point-...) and among beads whose mean velocity is
held at zero (held-...).  Each mean order is turned into g, that of which as few rods in mean field have it: g_total
and g_held.  g_flow = lambda_s alpha/(Gamma D_r) is from the assays of the table, on single rods and in strong fields.
The test: g_total - g_held = g_flow at each point, with chi^2.  c by contacts is a g_held/(2 sigma).

Near the threshold runs differ by more than the errors of their correlated series.  So the error of a run is a share of
the deviation of P in time that the same mean field predicts; the share is that of the repeated runs of all points.
"""
import argparse
import json

import h5py
import numpy as np


def orders_of_rods(rods, alignments):
    """Mean and deviation of the order of as many rods with the weight exp(g N P^2/2), by a saddle point."""
    angle = (np.arange(4096) + 0.5) * np.pi / 4096
    pull = np.linspace(1e-3, 80.0, 4000)
    weight = np.exp(pull[:, None] * (np.cos(angle) - 1.0))
    partition = weight.mean(axis=1)
    order = (weight * np.cos(angle)).mean(axis=1) / partition
    slope = np.gradient(order, pull)
    entropy = np.log(partition) + pull * (1.0 - order)
    log_density = np.log(order) - 0.5 * np.log(order / pull * slope) + np.log(slope)  # of P, on the nodes of pull
    found = []
    for g in alignments:
        exponent = log_density + rods * (entropy + 0.5 * g * order**2)
        density = np.exp(exponent - exponent.max())
        mean = (density * order).sum() / density.sum()
        found.append((mean, np.sqrt((density * (order - mean)**2).sum() / density.sum())))
    return np.array(found).T


class Law:
    """g of a mean order, for a number of rods."""

    def __init__(self, rods):
        self.alignment = np.linspace(-4.0, 12.0, 641)
        self.order, self.deviation = orders_of_rods(rods, self.alignment)

    def deviation_of(self, order):
        """The deviation of P in time where its mean is this."""
        return np.interp(order, self.order, self.deviation)

    def alignment_of(self, order, error):
        """g and its error; half the distance of the two g whose orders are one error away."""
        low, middle, high = np.interp([order - error, order, order + error], self.order, self.alignment)
        return middle, 0.5 * (high - low)


def share_of_scatter(samples):
    """Scatter of repeated runs over the deviation of P in time, from pairs of a law and the orders of its runs."""
    squares = [orders.var(ddof=1) / law.deviation_of(orders.mean())**2 for law, orders in samples if len(orders) > 1]
    return np.sqrt(np.mean(squares))


def flow_of(path):
    """By area fractions: g_flow, its error, and c for g_held = 1, a/(2 sigma)."""
    with h5py.File(path) as file:
        group = file.get("calibration", file)  # tables of earlier versions have a group
        beads, rods = group["bead_area_fraction"][()], group["rod_area_fraction"][()]
        value, error = group["alignment_by_flow"][()], group["alignment_by_flow_error"][()]
        unit = 0.5 * group["relaxation_rate"][()] * group["rod_area"][()]
    return {(bead, rod): (value[i, k], error[i, k], unit[i] / rod)
            for i, bead in enumerate(beads) for k, rod in enumerate(rods)}


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--table", required=True, help="table of coefficients (HDF5)")
    parser.add_argument("--flocks", required=True, nargs="+", help="files flocks.json of flocks.py")
    arguments = parser.parse_args()
    runs = {}
    for path in arguments.flocks:
        with open(path) as file:
            for name, row in json.load(file).items():
                kind, *numbers = name.split("-")
                if kind in ("point", "held"):
                    runs.setdefault((float(numbers[0]), float(numbers[1])), {}).setdefault(kind, []).append(row)
    flow = flow_of(arguments.table)
    print("| Phi_b | Phi_r | runs, free and held | P, free | P, held | g_total | g_held | g_flow | "
          "g_total - g_held - g_flow | c by contacts [mm^2/s] |\n|---|---|---|---|---|---|---|---|---|---|")
    points = [point for point in sorted(runs) if len(runs[point]) == 2 and point in flow]
    laws = {rods: Law(rods) for rods in {int(runs[point]["held"][0]["rods"]) for point in points}}
    samples = {(point, kind): (laws[int(runs[point][kind][0]["rods"])],
                               np.array([float(run["order_mean_second_half"]) for run in runs[point][kind]]))
               for point in points for kind in ("point", "held")}
    share = share_of_scatter(samples.values())
    square, count = 0.0, 0
    for point in points:
        orders = {}
        for kind in ("point", "held"):
            law, values = samples[point, kind]
            orders[kind] = values.mean(), share * law.deviation_of(values.mean()) / np.sqrt(len(values))
        total, held = (samples[point, kind][0].alignment_of(*orders[kind]) for kind in ("point", "held"))
        *by_flow, unit = flow[point]
        rest, error = total[0] - held[0] - by_flow[0], np.sqrt(total[1]**2 + held[1]**2 + by_flow[1]**2)
        square, count = square + (rest / error)**2, count + 1
        cells = [f"{value:.2f}({error:.2f})"
                 for value, error in (orders["point"], orders["held"], total, held, by_flow)]
        print(f"| {point[0]:g} | {point[1]:g} | {len(runs[point]['point'])}, {len(runs[point]['held'])} | "
              f"{' | '.join(cells)} | {rest:+.2f}({error:.2f}) | {unit * held[0]:.1f}({unit * held[1]:.1f}) |")
    print(f"\nchi^2 = {square:.1f} of {count} points; scatter of runs: {share:.2f} of the deviation in time")


if __name__ == "__main__":
    main()
