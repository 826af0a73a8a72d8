"""tests/app/test_shelf_slow.py: the growth exponent of kpz.toml, which needs a long line."""
import h5py
import numpy as np
from support import MODELS, drover, settings


def test_an_interface_of_kardar_parisi_and_zhang_roughens_with_exponent_one_third(tmp_path):
    keys = ["grid.nx=8192", "grid.lx=8192", "coefficients.lambda=3", "time.end=400", "output.sample_every=4",
            "output.frame_every=0"]
    runs = []
    for seed in range(1, 9):
        drover(tmp_path, "run", MODELS / "kpz.toml", "--quiet", "-o", f"{seed}.h5", seconds=3600,
               *settings([*keys, f"run.seed={seed}"]))
        with h5py.File(tmp_path / f"{seed}.h5") as file:
            runs.append([file[f"observables/{name}"][()] for name in ("time", "variance_height")])
    times, variance = np.mean(runs, axis=0)
    late = times >= 20.0
    exponent = 0.5 * np.polyfit(np.log(times[late]), np.log(variance[late]), 1)[0]
    # Single runs scatter by 0.026, so that the mean of eight has an error of 0.01; without lambda it is 1/4.
    assert abs(exponent - 1.0 / 3.0) < 0.03
