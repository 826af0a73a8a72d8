"""tests/app/test_counterterm.py: approximation.counterterm against its sum over waves and against linear theory."""
import math

import h5py
import numpy as np
import pytest
from support import MODELS, drover, drover_json, write_scene

# Order alone, far from a flock: |p|^2 of the waves is that of linear theory, but for b.
ORDER = {"fields.rod_density": False, "relaxation.rate": 0.5, "relaxation.saturation": 0.5, "elasticity.stiffness": 0.3,
         "elasticity.splay": 0.4, "noise.order": 1.0, "grid.nx": 16, "grid.ny": 12, "grid.lx": 12.0, "grid.ly": 10.0,
         "time.dt": 0.1, "time.end": 6000.0, "output.sample_every": 1.0, "output.frame_every": 0.0,
         "analysis.warm_up": 20.0, "accuracy.effort": 0.0, "run.seed": 5}
ON = {"approximation.counterterm": True}


def waves(scene):
    """The kept waves but q = 0: |k| < N/4 on each axis, since the saturation is cubic."""
    nx, ny = scene["grid.nx"], scene["grid.ny"]
    return [(2.0 * math.pi * i / scene["grid.lx"], 2.0 * math.pi * j / scene["grid.ly"])
            for i in range(-nx, nx) for j in range(-ny, ny) if abs(i) < nx / 4 and abs(j) < ny / 4 and (i or j)]


def fluctuations(scene):
    """s, the sum of <|p_q|^2> over these waves by linear theory: its part along q has the stiffness K3 + K1."""
    squares = [x * x + y * y for x, y in waves(scene)]
    area = scene["grid.lx"] * scene["grid.ly"]
    return sum(scene["noise.order"] / (2.0 * area) / (scene["relaxation.rate"] + stiffness * square)
               for square in squares for stiffness in (scene["elasticity.stiffness"], scene["elasticity.stiffness"]
                                                       + scene["elasticity.splay"]))


def test_the_counterterm_is_its_sum_over_the_kept_waves(tmp_path):
    write_scene(tmp_path, ON, base=ORDER)
    found = drover_json(tmp_path, "explain", "flock.toml")
    assert found["counterterm"] == pytest.approx(2.0 * ORDER["relaxation.saturation"] * fluctuations(ORDER), rel=1e-12)
    # Theory is of the scene as it is.
    rate = drover_json(tmp_path, "stability", "flock.toml")["states"][0]["fastest_rate"]
    assert rate == pytest.approx(-ORDER["relaxation.rate"], rel=1e-9)


def test_with_it_the_mean_order_fluctuates_as_in_linear_theory_and_without_it_less(tmp_path):
    # <|P|^2> = Delta/(a A) of the mean.  Saturation by waves makes a larger by 2 b s, a half of it here; with the
    # counterterm what is left is of second order in b s/a, .06, and of the mean itself, b Delta/(a A)/a, .01.
    linear = ORDER["noise.order"] / (ORDER["relaxation.rate"] * ORDER["grid.lx"] * ORDER["grid.ly"])
    part = 2.0 * ORDER["relaxation.saturation"] * fluctuations(ORDER) / ORDER["relaxation.rate"]
    assert 0.4 < part < 0.6
    found = []
    for changes in ({}, ON):
        write_scene(tmp_path, changes, base=ORDER)
        drover(tmp_path, "run", "flock.toml", "--quiet", "--overwrite")
        with h5py.File(tmp_path / "flock.h5") as file:
            order = file["observables/size_mean_polar_order"][20:]
        found.append(float(np.mean(order**2)) / linear)
    # 6000 s are 3000 autocorrelation times of |P|^2: its mean is known to 1/sqrt(1500), 3 %.
    assert found[0] < 0.83 and found[1] == pytest.approx(1.0, abs=0.15)


def test_fields_of_a_table_warn_without_it(tmp_path):
    flock = MODELS / "calibrated-flock.toml"
    assert "approximation.counterterm" not in drover(tmp_path, "check", flock).stderr
    words = ("check", flock, "--set", "approximation.counterterm=false", "--set", "grid.nx=32", "--set", "grid.ny=32")
    assert "set approximation.counterterm = true" in drover(tmp_path, *words).stderr


def test_a_counterterm_larger_than_the_decay_is_warned_of(tmp_path):
    noise = 1.1 * ORDER["noise.order"] * ORDER["relaxation.rate"] / (2.0 * ORDER["relaxation.saturation"]
                                                                    * fluctuations(ORDER))
    write_scene(tmp_path, {**ON, "noise.order": noise}, base=ORDER)
    assert "subtracts 1.1 times the decay rate of the order" in drover(tmp_path, "check", "flock.toml").stderr
    write_scene(tmp_path, {**ON, "noise.order": noise / 1.2}, base=ORDER)
    assert "the decay rate of the order" not in drover(tmp_path, "check", "flock.toml").stderr


@pytest.mark.parametrize("changes, says", [
    ({"noise.order": 0.0}, "noise.order = 0; expected > 0"),
    ({"relaxation.saturation": 0.0}, "relaxation.saturation = 0; expected > 0"),
    ({"relaxation.rate": -0.1}, "relaxation.rate = -0.1; expected > 0")])
def test_it_is_refused_where_there_is_nothing_to_compensate(tmp_path, changes, says):
    write_scene(tmp_path, {**ON, **changes}, base=ORDER)
    assert says in drover(tmp_path, "check", "flock.toml", status=2).stderr
