"""tests/bench/particles/binder.py: Binder cumulants 1 - <P^4>/(3 <P^2>^2) of the order, from kept tables of flocks.py.

Usage: binder.py TABLE.csv ...

A line for each table: mean order and cumulant over the second half, with the error from leaving out each of eight parts
of it in turn.  2/3 in a flock, 1/3 in directions without order, and 1 - pi/6 at the onset of the mean field, where P^2
has half of a normal distribution. """
import csv
import sys
from pathlib import Path

import numpy as np

PARTS = 8


def cumulant(order):
    return 1.0 - (order**4).mean() / (3.0 * (order**2).mean()**2)


def row(path):
    """Mean order, cumulant and its error of a table."""
    with open(path, encoding="utf-8") as file:
        rows = list(csv.DictReader(line for line in file if not line.startswith("#")))
    time, order = (np.array([float(one[name]) for one in rows]) for name in ("time", "polar_order"))
    order = order[time > 0.5 * time[-1]]
    parts = np.array_split(np.arange(len(order)), PARTS)
    left_out = np.array([cumulant(np.delete(order, part)) for part in parts])
    return order.mean(), cumulant(order), np.sqrt((PARTS - 1) * left_out.var())


if __name__ == "__main__":
    for path in sys.argv[1:] or sys.exit(__doc__):
        mean, found, error = row(path)
        print(f"{Path(path).stem}: P = {mean:.2f}, cumulant {found:.3f} +- {error:.3f}")
