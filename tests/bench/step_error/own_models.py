"""tests/bench/step_error/own_models.py: the estimated error of shipped models without noise beside the true one.

Runs each model as it is shipped, and with an eighth of its step by etdrk4-krogstad, and compares the fields at ten
frames: the largest root mean square difference of a field, relative to its fluctuation, beside step_error, with the
default effort and with a large one.  Frames where the fields have parted (a true error above a half) do not count, nor
do those where the error is not resolved.

    DROVER=build/release/drover /usr/bin/python3 tests/bench/step_error/own_models.py --output FILE.csv

Rows that exist are kept: re-run to resume.
"""
import argparse
import os
import subprocess
import sys
import tempfile
import tomllib
from pathlib import Path

import h5py
import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[2]))
from studies import KeptTable, settings_of  # noqa: E402

ROOT = Path(__file__).resolve().parents[3]
DROVER = str(Path(os.environ.get("DROVER", "build/release/drover")).absolute())
COLUMNS = ("model", "effort", "frames", "least_ratio", "largest_ratio")
EFFORTS = (0.05, 2.0)
MODELS = ("active-nematic", "brusselator", "cahn-hilliard", "ginzburg-landau", "keller-segel", "swift-hohenberg")


def run(folder, model, archive, keys):
    command = [DROVER, "run", str(ROOT / "models" / f"{model}.toml"), "--quiet", "--overwrite", "-o", archive]
    ended = subprocess.run([*command, *settings_of({"run.threads": 1, **keys})], cwd=folder, check=False,
                           capture_output=True, text=True)
    if ended.returncode != 0:
        raise RuntimeError(ended.stderr)


def true_error(run, fine, frame):
    """The largest of any field, relative to its fluctuation over the cell and the time so far."""
    worst = 0.0
    for name in (name for name, item in fine.items() if isinstance(item, h5py.Dataset) and item.ndim == 3):
        so_far, now = fine[name][: frame + 1], fine[name][frame]
        fluctuation = max(np.std(so_far), np.std(now))
        worst = max(worst, np.sqrt(np.mean((run[name][frame] - now) ** 2)) / fluctuation)
    return worst


def row_of(folder, model, effort):
    time = tomllib.loads((ROOT / "models" / f"{model}.toml").read_text())["time"]
    every = {"output.frame_every": time["end"] / 10}
    run(folder, model, "run.h5", {**every, "accuracy.effort": effort})
    run(folder, model, "fine.h5", {**every, "time.dt": time["dt"] / 8, "time.stepper": "etdrk4-krogstad"})
    ratios = []
    with h5py.File(folder / "run.h5") as coarse, h5py.File(folder / "fine.h5") as fine:
        times, told = coarse["observables/time"][:], coarse["observables/step_error"][:]
        for frame in range(1, 11):
            true = true_error(coarse, fine, frame)
            estimate = told[np.argmin(np.abs(times - coarse["time"][frame]))]
            if 0.0 < true < 0.5 and np.isfinite(estimate):  # NaN: not resolved
                ratios.append(estimate / true)
    return {"model": model, "effort": effort, "frames": len(ratios),
            "least_ratio": f"{min(ratios, default=np.nan):.2f}", "largest_ratio": f"{max(ratios, default=np.nan):.2f}"}


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--output", type=Path, required=True)
    options = parser.parse_args()
    table = KeptTable(options.output, COLUMNS)
    known = {(row["model"], float(row["effort"])) for row in table.rows}
    with tempfile.TemporaryDirectory() as name:
        for model in MODELS:
            for effort in EFFORTS:
                if (model, effort) not in known:
                    table.add(row_of(Path(name), model, effort))
    for row in table.rows:
        print(*(f"{name} {row[name]}" for name in COLUMNS))


if __name__ == "__main__":
    main()
