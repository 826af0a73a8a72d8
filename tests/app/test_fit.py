"""tests/app/test_fit.py: drover fit finds the coefficients of runs of fields, and the waves of runs of particles."""
import h5py
import numpy as np
import pytest
from support import MODELS, drover, drover_json, settings, write_scene

LINEAR = {"uniform.rod_density": 1.0, "current.speed": 0.8, "relaxation.rate": 0.4, "elasticity.stiffness": 0.3,
          "pressure.rods": 0.5, "diffusion.rods": 0.1, "noise.order": 0.3, "noise.rods": 0.1, "grid.nx": 12,
          "grid.ny": 12, "grid.lx": 12.0, "grid.ly": 12.0, "time.dt": 0.5, "time.end": 1000.0,
          "initial.kind": "stationary", "output.frame_every": 0.5, "output.sample_every": 10.0, "run.threads": 1}
KEYS = ["relaxation.rate", "elasticity.stiffness", "current.speed", "pressure.rods", "noise.order", "noise.rods"]


def overrides(keys):
    """--set for each."""
    return settings(f"{key}={value}" for key, value in keys.items())


def found_in(folder, *words):
    """The estimates by key."""
    result = drover_json(folder, "fit", *words)
    return {row["key"]: row for row in result["coefficients"]}, result


@pytest.fixture(scope="module", name="linear")
def linear_run(tmp_path_factory):
    folder = tmp_path_factory.mktemp("linear")
    write_scene(folder, LINEAR, base={})
    drover(folder, "run", "flock.toml", "--quiet", "-o", "linear.h5")
    return folder


def test_a_linear_run_gives_its_coefficients_back_from_other_starting_values(linear):
    other = overrides({"relaxation.rate": 0.8, "current.speed": 0.4, "pressure.rods": 1.0, "noise.order": 0.1})
    found, result = found_in(linear, "linear.h5", *KEYS, *other)
    for key in KEYS:
        # 3.5 errors of one of six: 0.3 %; errors themselves are known to 13 %.
        assert abs(found[key]["value"] - LINEAR[key]) < 3.5 * found[key]["error"], key
        assert found[key]["error"] == pytest.approx(found[key]["error_of_model"], rel=0.6), key
        assert abs(found[key]["at_twice_the_spacing"] - found[key]["value"]) < 3.0 * found[key]["error"], key
        assert found[key]["error"] < 0.2 * LINEAR[key], key
    assert result["about"] == "the state without order" and result["remarks"] == []
    assert result["frames"] == 2001 and result["spacing"] == pytest.approx(0.5)
    assert result["waves"] == 15  # the mean, and half of the 28 integer vectors up to 3


def test_a_conserved_field_alone_gives_its_coefficients_back(tmp_path):
    drover(tmp_path, "run", str(MODELS / "model-b.toml"), "--quiet", "-o", "b.h5", *overrides(
        {"coefficients.u": 0.0, "grid.nx": 32, "grid.ny": 32, "output.frame_every": 1, "time.end": 5000}))
    found, _ = found_in(tmp_path, "b.h5", "coefficients.r")
    assert abs(found["coefficients.r"]["value"] - 0.1) < 3.5 * found["coefficients.r"]["error"] < 0.1


def test_more_waves_and_more_frames_give_smaller_errors(linear):
    errors = [found_in(linear, "linear.h5", "relaxation.rate", "elasticity.stiffness", *words)[0] for words in
              (["--max-wavenumber", "1.1"], ["--max-wavenumber", "2.1"], ["--max-wavenumber", "2.1", "--to", "250"])]
    some, more, short = (one["elasticity.stiffness"]["error_of_model"] for one in errors)
    assert more < 0.7 * some  # q^2 is four times as large, on four times as many waves
    assert short == pytest.approx(2.0 * more, rel=0.2)  # a quarter of the frames


def test_the_text_warns_where_the_equations_are_not_those_of_the_run(linear):
    text = drover(linear, "fit", "linear.h5", "relaxation.rate", "noise.order", "--set", "pressure.rods=0.9",
                  "--every", "2").stdout
    assert "waves of linear.h5 about the state without order: 15 up to 1.571 /mm, in 1001 frames 1 s apart" in text
    assert "noise.order depends on the spacing of the frames" in text


def test_waves_that_the_run_does_not_keep_are_left_out(linear, tmp_path):
    assert found_in(linear, "linear.h5", "relaxation.rate", "--max-wavenumber", "4.5")[1]["waves"] == 61  # |k| < 6
    write_scene(tmp_path, {**LINEAR, "relaxation.saturation": 0.01, "time.end": 100.0}, base={})
    drover(tmp_path, "run", "flock.toml", "--quiet", "-o", "cubic.h5")
    assert found_in(tmp_path, "cubic.h5", "relaxation.rate")[1]["waves"] == 13  # (3, 0) and (0, 3) are cut: |k| < 12/4


def test_without_a_strength_among_the_keys_the_noise_is_free(linear):
    """Starting values of the strengths then do not matter."""
    keys = ["relaxation.rate", "current.speed"]
    free = [found_in(linear, "linear.h5", *keys, *overrides({"noise.order": strength}))[0] for strength in (0.3, 0.6)]
    for key in keys:
        assert free[0][key]["value"] == free[1][key]["value"]
        assert abs(free[0][key]["value"] - LINEAR[key]) < 3.5 * free[0][key]["error"]


def test_the_mean_alone_gives_the_decay_of_the_order(linear):
    found, result = found_in(linear, "linear.h5", "relaxation.rate", "noise.order", "--max-wavenumber", "0.1")
    assert result["waves"] == 1
    for key in found:
        assert abs(found[key]["value"] - LINEAR[key]) < 3.5 * found[key]["error"], key


def test_a_noisy_flock_gives_its_coefficients_back(tmp_path):
    weak = {"relaxation.rate": -0.4, "relaxation.saturation": 0.9, "pressure.rods": 0.2, "noise.order": 3e-5,
            "noise.rods": 1e-5, "orienting_field.x": 0.05, "initial.kind": "formula",
            "initial.polar_order_x": "0.7", "time.dt": 0.1, "time.stepper": "etdrk4-krogstad"}
    write_scene(tmp_path, {**LINEAR, **weak}, base={})
    drover(tmp_path, "run", "flock.toml", "--quiet", "-o", "flock.h5")
    keys = ["relaxation.saturation", "elasticity.stiffness", "current.speed", "noise.order"]
    found, result = found_in(tmp_path, "flock.h5", *keys, "--from", "50", "--set", "relaxation.saturation=0.5")
    assert result["about"] == "an ordered state" and result["polar_order_x"] > 0.6
    for key in keys:
        assert abs(found[key]["value"] - {**LINEAR, **weak}[key]) < 4.0 * found[key]["error"], key
    mean = ["--from", "50", "--max-wavenumber", "0.1"]
    refused = drover(tmp_path, "fit", "flock.h5", "relaxation.rate", *mean, status=2)
    assert "of a flock, whose mean is no wave" in refused.stderr


FLOW = """
model = {name = "order in a flow"}
field = [
  {symbol = "v", name = "flow", rank = "vector", solenoidal = true, noise = 0.2},
  {symbol = "p", name = "order", rank = "vector", noise = "D"},
]
grid = {nx = 12, ny = 12, lx = 12.0, ly = 12.0}
time = {dt = 0.5, end = 1000.0}
initial = {kind = "stationary"}
output = {frame_every = 0.5, sample_every = 10.0}
[equations]
v = "-gamma v + nu lap v + beta p"
p = "-a p + K lap p + kappa v"
[coefficients]
gamma = 0.4
nu = 0.5
beta = 0.2
a = 0.5
K = 0.3
kappa = 0.3
D = 0.1
"""


def test_a_divergence_free_flow_gives_its_coefficients_back(tmp_path):
    (tmp_path / "flow.toml").write_text(FLOW)
    drover(tmp_path, "run", "flow.toml", "--quiet", "-o", "flow.h5")
    exact = {"gamma": 0.4, "nu": 0.5, "beta": 0.2, "a": 0.5, "K": 0.3, "kappa": 0.3, "D": 0.1}
    found, result = found_in(tmp_path, "flow.h5", *exact, *overrides({"coefficients.nu": 0.3, "coefficients.K": 0.5}))
    for name, value in exact.items():
        row = found[f"coefficients.{name}"]
        # 3.5 errors of one of seven: 0.4 %; beta and kappa are seen by the part across q alone.
        assert abs(row["value"] - value) < 3.5 * row["error"] and row["error"] < 0.15 * value, (name, row)
        assert row["error"] == pytest.approx(row["error_of_model"], rel=0.6), name
    assert result["waves"] == 14  # as of any model, without the mean
    refused = drover(tmp_path, "fit", "flow.h5", "a", "--max-wavenumber", "0.1", status=2)
    assert "of a divergence-free field, whose mean is no wave" in refused.stderr


def test_waves_of_particles_are_sums_over_bodies(tmp_path):
    """The fit of P alone is that of a vector that is read here: its mean over rods, d_t P = -a P + noise."""
    words = overrides({"cell.lx": 12.0, "cell.ly": 12.0, "beads.area_fraction": 0.0, "rods.area_fraction": 0.1,
                      "time.end": 4.0, "output.frame_every": 0.05, "output.sample_every": 0.1, "run.threads": 1,
                      "time.dt": 5e-5, "contacts.substep": 5e-5})
    drover(tmp_path, "run", MODELS / "rods-alone.toml", *words, "--quiet", "-o", "rods.h5")
    write_scene(tmp_path, {"fields.rod_density": False, "current.speed": 0.0, "relaxation.rate": 0.5,
                           "noise.order": 1.0, "grid.lx": 12.0, "grid.ly": 12.0}, base={}, name="polar.toml")
    found, result = found_in(tmp_path, "rods.h5", "relaxation.rate", "noise.order", "--scene", "polar.toml",
                             "--max-wavenumber", "0.6")
    assert result["frames"] == 81
    with h5py.File(tmp_path / "rods.h5") as file:
        axes, places = (file[f"bodies/rods/{name}/value"][()] for name in ("axis", "position"))
    waves = [np.mean(axes[:, :, :2] * np.exp(-2j * np.pi / 12.0 * (places[:, :, :2] @ n))[:, :, None], axis=1)
             for n in ([0, 0], [1, 0], [0, 1])]
    weights = (0.5, 1.0, 1.0)
    if result["about"] == "an ordered state":  # these few rods keep their mean direction, which is then no wave
        waves, weights = waves[1:], weights[1:]
    assert result["waves"] == len(waves)
    # The maximum of the likelihood of a' = r a + f, real at q = 0: r = sum w Re(a* a')/sum w |a|^2, and the variance.
    square = sum(w * np.sum(np.abs(a[:-1])**2) for w, a in zip(weights, waves))
    kept = sum(w * np.sum((a[:-1].conj() * a[1:]).real) for w, a in zip(weights, waves)) / square
    left = sum(w * np.sum(np.abs(a[1:] - kept * a[:-1])**2) for w, a in zip(weights, waves))
    variance = left / sum(w * 2 * 80 for w in weights)
    rate = -np.log(kept) / 0.05
    assert found["relaxation.rate"]["value"] == pytest.approx(rate, rel=1e-5)
    assert found["noise.order"]["value"] == pytest.approx(variance * 144.0 * 2.0 * rate / (1.0 - kept**2), rel=1e-5)
    with h5py.File(tmp_path / "rods.h5", "a") as file:
        del file["bodies/rods/axis/value"]
        file["bodies/rods/axis/value"] = axes[:, :1]
    damaged = drover(tmp_path, "fit", "rods.h5", "relaxation.rate", "--scene", "polar.toml", status=2)
    assert "1 axes of rods; it is damaged" in damaged.stderr


REFUSED = {
    "an unknown number": (["relaxation.rat"], "did you mean relaxation.rate?"),
    "a number twice": (["relaxation.rate", "relaxation.rate"], "relaxation.rate is given twice"),
    "a number without effect": (["relaxation.saturation"], "the waves do not depend on relaxation.saturation"),
    "numbers that act alike": (["relaxation.rate", "relaxation.contact"], "only a combination of relaxation.rate and"),
    "too few frames": (["relaxation.rate", "--to", "20"], "has 41 frames from 0 s to 20 s"),
    "too many waves": (["relaxation.rate", "--max-wavenumber", "100"], "at most 400 waves"),
    "a density": (["uniform.rod_density"], "expected a coefficient of the equations"),
    "no noise": (["noise.order", "--set", "noise.order=0", "--set", "noise.rods=0", "--set",
                  "initial.kind=uniform"], "has no noise that reaches"),
}


@pytest.mark.parametrize("case", REFUSED)
def test_what_cannot_be_fitted_is_refused_by_name(linear, case):
    words, expected = REFUSED[case]
    ended = drover(linear, "fit", "linear.h5", *words, status=2)
    assert expected in ended.stderr and ended.stdout == ""


def test_particles_without_a_model_are_refused(tmp_path):
    words = overrides({"time.end": 0.02, "output.frame_every": 0.01, "output.sample_every": 0.01})
    drover(tmp_path, "run", MODELS / "rod.toml", *words, "--quiet", "-o", "rod.h5")
    assert "expected a scene of fields to fit" in drover(tmp_path, "fit", "rod.h5", "relaxation.rate", status=2).stderr


@pytest.mark.parametrize("length, size", [(1e-3, 1.0), (1e-7, 1.0), (1.0, 1e9), (1e-7, 1e-6)])
def test_units_change_no_fit(tmp_path, length, size):
    def found(unit, of_field):
        """A field that decays and diffuses, from values that are 1.3 times too large."""
        (tmp_path / "decay.toml").write_text(f"""
field = [{{symbol = "n", noise = "N"}}]
equations = {{n = "D lap n - a n"}}
coefficients = {{D = {unit**2!r}, a = 0.2, N = {0.05 * (unit * of_field)**2!r}}}
grid = {{nx = 16, ny = 16, lx = {20 * unit!r}, ly = {20 * unit!r}}}
time = {{dt = 0.5, end = 100.0}}
initial = {{kind = "stationary"}}
output = {{frame_every = 0.5, sample_every = 1.0}}
""")
        drover(tmp_path, "run", "decay.toml", "--overwrite", "-o", "decay.h5")
        fits = []
        for keys in ({"D": unit**2, "a": 0.2}, {"D": unit**2, "N": 0.05 * (unit * of_field)**2}):
            fit, _ = found_in(tmp_path, "decay.h5", *(f"coefficients.{key}" for key in keys),
                              *overrides({f"coefficients.{key}": 1.3 * value for key, value in keys.items()}))
            fits += [fit[f"coefficients.{key}"][name] / value for key, value in keys.items()
                     for name in ("value", "error")]
        return fits

    # Runs differ by rounding; a fit ends within 1e-4 of its error.
    assert found(length, size) == pytest.approx(found(1.0, 1.0), rel=1e-3)
