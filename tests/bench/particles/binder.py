"""tests/bench/particles/binder.py: Binder cumulants 1 - <P^4>/(3 <P^2>^2) of the order, from kept tables of flocks.py.

Usage: binder.py TABLE.csv ...

A line for each case, of one table or of its seeds, NAME-SEED.csv: mean order and cumulant over the second half of
all of them, with the error from leaving out each of eight parts of each in turn. 2/3 in a flock, 1/3 in directions
without order, and 1 - pi/6 at the onset of the mean field, where P^2 has half of a normal distribution."""
import csv
import sys
from pathlib import Path

import numpy as np

PARTS = 8


def cumulant(order):
    return 1.0 - (order**4).mean() / (3.0 * (order**2).mean()**2)


def second_half(path):
    """The order in the second half of a table."""
    with open(path, encoding="utf-8") as file:
        rows = list(csv.DictReader(line for line in file if not line.startswith("#")))
    time, order = (np.array([float(one[name]) for one in rows]) for name in ("time", "polar_order"))
    return order[time > 0.5 * time[-1]]


def row(paths):
    """Mean order, cumulant and its error of tables."""
    parts = [part for path in paths for part in np.array_split(second_half(path), PARTS)]
    left_out = np.array([cumulant(np.concatenate(parts[:k] + parts[k + 1:])) for k in range(len(parts))])
    order = np.concatenate(parts)
    return order.mean(), cumulant(order), np.sqrt((len(parts) - 1) * left_out.var())


if __name__ == "__main__":
    cases = {}
    for path in sys.argv[1:] or sys.exit(__doc__):
        name, _, seed = Path(path).stem.rpartition("-")
        cases.setdefault(name if seed.isdigit() else Path(path).stem, []).append(path)
    for name, paths in cases.items():
        mean, found, error = row(paths)
        print(f"{name}: P = {mean:.2f}, cumulant {found:.3f} +- {error:.3f} of {len(paths)}")
