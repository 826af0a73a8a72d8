"""tests/app/test_unusual_errors.py: estimates and their errors where fields have means, runs are too short, one wave
is alone, or means are rounding."""
from support import drover as program, drover_json

import drover

SCENE = """
field = [{fields}]
grid = {{nx = {nx}, ny = {ny}, lx = {lx}, ly = {ly}}}
time = {{end = {end}{dt}}}
initial = {{{initial}}}
output = {{frame_every = {frames}, sample_every = 0.5}}
{more}
[equations]
{equations}
[coefficients]
{coefficients}
"""
RELAXING = 'u = "k (u0 - u) + D lap u"'


def write(folder, fields, equations, coefficients, dt=", dt = 0.5", end=200.0, initial='kind = "stationary"',
          frames=0.5, nx=16, ny=16, lx=16.0, ly=16.0, more=""):
    (folder / "own.toml").write_text(SCENE.format(**locals()))
    return "own.toml"


def fitted(folder, *words):
    return {row["key"].removeprefix("coefficients."): row
            for row in drover_json(folder, "fit", "run.h5", *words)["coefficients"]}


def test_coefficients_of_a_field_with_a_mean_are_those_without(tmp_path):
    scene = write(tmp_path, '{symbol = "u", noise = "2 T", reference = "u0"}', RELAXING,
                  "k = 1.0\nD = 1.0\nT = 0.1\nu0 = 3.0")
    program(tmp_path, "run", scene, "-q", "-o", "run.h5")
    found = fitted(tmp_path, "k", "D", "T")
    for key, truth in (("k", 1.0), ("D", 1.0), ("T", 0.1)):  # the mean as a wave would make k 5e-4
        assert abs(found[key]["value"] - truth) < 3.5 * found[key]["error"] < 0.4 * truth, key
    far = fitted(tmp_path, "D", "T", "--set", "coefficients.T=5")  # whose steps pass T = 0
    assert abs(far["T"]["value"] - 0.1) < 3.5 * far["T"]["error"]


def test_the_error_of_a_coefficient_is_that_of_the_model_where_the_start_holds_the_information(tmp_path):
    scene = write(tmp_path, '{symbol = "u", noise = "0.02"}', RELAXING, "k = 0.5\nD = 1.0\nu0 = 0.0", end=100.0,
                  initial='kind = "formula", u = "sin(2 pi x/16)"')
    program(tmp_path, "run", scene, "-q", "-o", "run.h5")
    found = fitted(tmp_path, "k", "D")
    assert all(found[key]["error"] >= found[key]["error_of_model"] for key in found)
    assert abs(found["k"]["value"] - 0.5) < 3.5 * found["k"]["error"]


def test_a_mean_momentum_that_is_rounding_is_no_order(tmp_path):
    scene = write(tmp_path, '{symbol = "v", rank = "vector", solenoidal = true, noise = "2 nu T", '
                  'conserved_noise = true}', 'v = "nu lap v - v.grad v"', "nu = 1.0\nT = 0.01", dt=", dt = 0.1",
                  end=100.0)
    for seed in (2, 4):  # whose rounding has a mean that looks neither like order nor like none
        program(tmp_path, "run", scene, "-q", "-o", "run.h5", "--overwrite", "--set", f"run.seed={seed}")
        found = fitted(tmp_path, "nu")
        assert abs(found["nu"]["value"] - 1.0) < 3.5 * found["nu"]["error"]


def test_a_step_is_chosen_where_a_mean_is_rounding(tmp_path):
    scene = write(tmp_path, '{symbol = "v", rank = "vector", solenoidal = true, noise = "2 nu T", '
                  'conserved_noise = true}', 'v = "nu lap v - v.grad v"', "nu = 1.0\nT = 0.01", dt="", nx=8, ny=8,
                  lx=8.0, ly=8.0, end=1.0)
    program(tmp_path, "run", scene, "-q", "-o", "run.h5")
    with drover.open_run(tmp_path / "run.h5") as run:
        assert run.scene["time"]["dt"] > 1e-3  # rates are of order 1 per time


def test_one_noisy_wave_in_the_tail_is_no_lack_of_points(tmp_path):
    scene = write(tmp_path, '{symbol = "u", noise = "0.04"}', 'u = "-u - 0.001 u^3 + lap u"', "", dt=", dt = 0.05",
                  ny=1, lx=8.0, ly=1.0, end=400.0, frames=100.0, initial='kind = "random", amplitude = 0.1')
    assert "does not resolve" not in program(tmp_path, "run", scene, "-q", "-o", "run.h5").stdout


def test_the_start_of_a_mean_is_part_of_the_warm_up(tmp_path):
    scene = write(tmp_path, '{symbol = "u", noise = "0.001", reference = "u0"}', RELAXING,
                  "k = 0.1\nD = 3.0\nu0 = 1.0", end=2000.0, frames=0.0, initial='kind = "formula", u = "0"')
    result = drover_json(tmp_path, "run", scene, "-o", "run.h5")
    # The field forgets its start in 1/k = 10; the fluctuations over the cell, which D smooths, in less than 1.
    assert result["warm_up_samples"] * 0.5 > 40.0
    mean = result["results"]["mean_u"]
    assert abs(mean["mean"] - 1.0) < 3.5 * mean["error"]


def test_seeds_of_runs_that_are_too_short_do_not_meet_a_target_in_silence(tmp_path):
    scene = write(tmp_path, '{symbol = "u", noise = "0.001", reference = "u0"}', RELAXING,
                  "k = 0.05\nD = 3.0\nu0 = 1.0", end=50.0, frames=0.0, initial='kind = "formula", u = "0"')
    for words in (["--want", "mean_u=20%"], ["--seeds", "4"]):
        text = program(tmp_path, "sweep", scene, "-q", "--workers", "1", "-o", words[0].strip("-"), *words).stdout
        assert "too short for an error estimate" in text
    # The mean over all times is what is asked for where the warm-up is given.
    text = program(tmp_path, "sweep", scene, "-q", "--workers", "1", "-o", "whole", "--seeds", "4", "--set",
                   "analysis.warm_up=0").stdout
    assert "too short" not in text


def test_all_uniform_states_are_found_where_fields_are_exactly_zero(tmp_path):
    names = [f"s{k}" for k in range(5)]  # each of the 32 sets of species that may live together
    among = {one: " - ".join(("" if one == other else "0.5 ") + other for other in names) for one in names}
    equations = "\n".join(f'{one} = "{one} (1 - {others}) + lap {one}"' for one, others in among.items())
    scene = write(tmp_path, ", ".join(f'{{symbol = "{one}", reference = 0.4}}' for one in names), equations, "",
                  initial='kind = "random", amplitude = 0.01')
    assert len(drover_json(tmp_path, "stability", scene)["states"]) == 32


def test_a_balance_of_conserved_fields_is_determined_beside_noise_that_multiplies_one(tmp_path):
    ions = ", ".join(f'{{symbol = "{one}", conserved = true, reference = 20.0}}' for one in "pm")
    scene = write(tmp_path, ions + ', {symbol = "V", balance = true}',
                  'p = "lap p + div(p grad V) + div(sqrt(2 p) j)"\nm = "lap m - div(m grad V)"\nV = "10 lap V + p - m"',
                  "", initial='kind = "uniform"', more='[[white_noise]]\nsymbol = "j"\nrank = "vector"')
    assert "valid" in program(tmp_path, "check", scene).stdout
