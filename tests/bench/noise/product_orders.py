#!/usr/bin/python3
"""tests/bench/noise/product_orders.py: the order of the error that steps make with noise that multiplies fields.

Paths of dt and dt/2 share their noise: of many seeds the differences of the mean square of a field (weak) and the root
mean square difference of the fields (strong), each relative to the mean square and the root mean square.  A method of
order n divides them by 2^n from one step to its half.

    PYTHONPATH=build/release/python /usr/bin/python3 -P tests/bench/noise/product_orders.py --output FILE.csv

Rows that exist are kept: re-run to resume.
"""
import argparse
import sys
from pathlib import Path

import numpy as np

import drover

sys.path.insert(0, str(Path(__file__).resolve().parents[2]))
from studies import KeptTable  # noqa: E402

COLUMNS = ("model", "dt", "seeds", "weak", "weak_error", "strong")
XI, J = drover.Noise("xi"), drover.Noise("j", spin=1)
MODELS = {  # the model, its start, the field that is measured
    "growth": (drover.Model([drover.Field("u", "-k u + D lap u + s u xi")], noises=[XI], k=0.3, D=0.2, s=0.8),
               {"u": 1.0}, "u"),
    "walkers": (drover.Model([drover.Field("c", "D lap c + div(sqrt(2 D max(c, 0)) j)", reference=20.0)], noises=[J],
                             D=1.0), {}, "c"),
    "coupled": (drover.Model([drover.Field("u", "-u + 2 v + lap u"), drover.Field("v", "-u - v + (1 + u / 2) xi")],
                             noises=[XI]), {"u": 1.0}, "u")}
STEPS, END, SEEDS = (0.5, 0.25, 0.125, 0.0625, 0.03125), 2.0, 2000


def ends(model, start, field, dt, seed):
    run = model.start(points=8, side=6.0, dt=dt, seed=seed)
    if start:
        run.set(**start)
    return run.advance(END).fields[field].values


def row_of(name, dt):
    model, start, field = MODELS[name]
    about = model.state()[0]
    weak, strong, size = [], [], []
    for seed in range(1, SEEDS + 1):
        one, half = (ends(model, start, field, step, seed) - about for step in (dt, dt / 2))
        weak.append(np.mean(one**2 - half**2))
        strong.append(np.mean((one - half)**2))
        size.append(np.mean(half**2))
    scale = np.mean(size)
    return {"model": name, "dt": dt, "seeds": SEEDS, "weak": f"{np.mean(weak) / scale:.5f}",
            "weak_error": f"{np.std(weak) / SEEDS**0.5 / scale:.5f}", "strong": f"{(np.mean(strong) / scale)**0.5:.5f}"}


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--output", type=Path, required=True)
    table = KeptTable(parser.parse_args().output, COLUMNS)
    known = {(row["model"], float(row["dt"])) for row in table.rows}
    for name in MODELS:
        for dt in STEPS:
            if (name, dt) not in known:
                table.add(row_of(name, dt))
                print(table.rows[-1], flush=True)


if __name__ == "__main__":
    main()
