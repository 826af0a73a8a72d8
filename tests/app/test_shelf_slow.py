"""tests/app/test_shelf_slow.py: exponents of scenes of models/ with their own fields, which need large grids."""
import h5py
import numpy as np
from support import MODELS, drover, settings


def observed(folder, scene, seed, keys, name):
    """Times and values of an observable of one run."""
    archive = folder / f"{seed}.h5"
    drover(folder, "run", MODELS / f"{scene}.toml", "--overwrite", "--quiet", "-o", archive, seconds=3600,
           *settings([*keys, f"run.seed={seed}", "output.frame_every=0"]))
    with h5py.File(archive) as file:
        return file["observables/time"][()], file[f"observables/{name}"][()]


def test_an_interface_of_kardar_parisi_and_zhang_roughens_with_exponent_one_third(tmp_path):
    # A strong nonlinearity: the width crosses over from t^(1/4) at t of order nu^5/(lambda^4 D^2), here 0.01.
    keys = ["grid.nx=8192", "grid.lx=8192", "coefficients.lambda=3", "time.dt=0.02", "time.end=400",
            "output.sample_every=4"]
    runs = [observed(tmp_path, "kpz", seed, keys, "variance_height") for seed in range(1, 9)]
    times = runs[0][0]
    variance = np.mean([values for _, values in runs], axis=0)
    late = (times >= 20.0) & (times <= 400.0)
    exponent = 0.5 * np.polyfit(np.log(times[late]), np.log(variance[late]), 1)[0]
    # The correlation length at the end is some 100: 8 runs hold some 600 independent pieces, whose variances scatter by
    # 5 %, 0.01 of the exponent; corrections to scaling at 20 are of the same order.
    assert abs(exponent - 1.0 / 3.0) < 0.025


def test_domains_of_cahn_and_hilliard_coarsen_with_exponent_one_third(tmp_path):
    keys = ["grid.nx=512", "grid.ny=512", "grid.lx=512", "grid.ly=512", "time.dt=0.2", "time.end=3000",
            "output.sample_every=20"]
    archive = tmp_path / "1.h5"
    times, factors = observed(tmp_path, "cahn-hilliard", 1, keys, "structure_factor_composition")
    with h5py.File(archive) as file:
        wavenumbers = file["observables/wavenumber"][()]
    modes = wavenumbers * np.gradient(wavenumbers)  # of a shell, in proportion
    length = 2.0 * np.pi * (factors * modes).sum(axis=1) / (factors * modes * wavenumbers).sum(axis=1)
    late = times >= 300.0
    exponent = np.polyfit(np.log(times[late]), np.log(length[late]), 1)[0]
    # The exponent rises to 1/3 from below as walls become thin beside domains (Huse, Phys. Rev. B 34, 7845 (1986)).
    assert 0.28 < exponent < 0.36
