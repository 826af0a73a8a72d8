"""tests/app/test_tradeoff_slow.py: what a trade of speed for accuracy predicts of errors, against true errors."""
import sys
from pathlib import Path

import pytest
from test_tradeoff import NOISY, WAVES, mean, scene, tradeoff

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "bench" / "tradeoff"))
import study  # noqa: E402


def keys_of(step, grid, model):
    """The settings of levels of each axis."""
    nx, ny = grid.split(" by ")
    method, dt = step.split(", dt = ")
    dt = float(dt.removesuffix(" s"))
    keys = [f"grid.nx={nx}", f"grid.ny={ny}", f"time.stepper={method}", f"time.dt={dt}", "output.frame_every=0.0",
            f"output.sample_every={max(dt, 1.0)}"]  # that of both scenes, or the step
    keys += [f"{model.removeprefix('without ')}=0.0"] if model.startswith("without ") else []
    return [word for key in keys for word in ("--set", key)]


def test_the_parts_of_the_error_add_up_to_the_true_one_where_each_dominates(tmp_path):
    found = tradeoff(tmp_path, scene(tmp_path, WAVES), "--want", "polar_order=0.001%", "--budget", "2min")
    exact = mean(tmp_path, "s.toml", "polar_order", "--set", "time.stepper=etdrk4-krogstad", "--set", "time.dt=0.05",
                 "--set", "grid.nx=64", "--set", "grid.ny=64")
    fine = "etdrk4-krogstad, dt = 0.0625 s"
    for levels in (("etdrk2, dt = 0.5 s", "32 by 32", "full"), (fine, "16 by 16", "full"),
                   (fine, "32 by 32", "without pressure.rods")):
        parts = [abs(row["bias"]) + 2 * row["error"] for row in found["levels"] if row["level"] in levels]
        assert len(parts) == 3 and max(parts) > 10 * (sum(parts) - max(parts))
        error = abs(mean(tmp_path, "s.toml", "polar_order", *keys_of(*levels)) - exact)
        assert 0.5 * error < sum(parts) < 2.0 * error, levels


def test_the_statistical_error_is_the_scatter_of_runs_with_other_seeds(tmp_path):
    """Twelve runs tell a scatter to a fifth; the standard error of the trials is as uncertain."""
    found = tradeoff(tmp_path, scene(tmp_path, NOISY), "--want", "polar_order=3%", "--budget", "1min")
    row = next(row for row in found["by_model"] if row["model"] == "full" and ", dt = " in row["step"])
    keys = keys_of(row["step"], row["grid"], row["model"])
    end = float(row["duration"].removesuffix(" s"))
    means = [mean(tmp_path, "s.toml", "polar_order", *keys, "--set", f"time.end={end}", "--set",
                  f"run.seed={seed}") for seed in range(1, 13)]
    average = sum(means) / 12
    scatter = (sum((one - average)**2 for one in means) / 11)**0.5
    assert 0.5 * scatter < row["statistics_error"] / 2 < 2.0 * scatter


def test_shorter_trials_in_the_folder_of_longer_ones_use_them(tmp_path):
    long = tradeoff(tmp_path, scene(tmp_path, NOISY), "--want", "polar_order=2%", "--budget", "1min")["wishes"][0]
    short = tradeoff(tmp_path, "s.toml", "--want", "polar_order=4%", "--budget", "5s")["wishes"][0]
    assert short["expected"] < 2.0 * short["allowed"] and short["value"][:3] == long["value"][:3]


@pytest.mark.parametrize("number, per_cent", [(36, 10), (42, 0.1)])
def test_a_flow_that_dies_away_is_not_taken_for_chaos(tmp_path, number, per_cent):
    """A less accurate method differs from the others by more than what is left of the flow at the end."""
    _, keys, observable = study.scene(number)
    (tmp_path / "s.toml").write_text("")
    found = tradeoff(tmp_path, "s.toml", *study.words_of(keys), "--want", f"{observable}={per_cent}%", "--budget",
                     "1min")
    assert {row["duration"] for row in found["front"] if row["step"] != "-"} == {"as given"}
