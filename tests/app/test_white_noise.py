"""tests/app/test_white_noise.py: noises that the equations of a scene name, in commands and in Python."""
import re

import drover as library
import h5py
import numpy as np
import pytest
from rejection import rejected
from support import contents, drover, drover_json, not_sanitized

# Two densities that exchange a random flux, and a current that feels the same flux.
EXCHANGE = """[model]
name = "exchange"
[[field]]
symbol = "n"
conserved = true
[[field]]
symbol = "m"
conserved = true
[[field]]
symbol = "p"
rank = "vector"
[[white_noise]]
symbol = "j"
rank = "vector"
[equations]
n = "D lap n + J"
m = "2 D lap m - J"
p = "-g p + lap p + s j"
[define]
J = "sqrt(2 T) div j"
[coefficients]
D = 1.0
T = 0.1
g = 0.5
s = 0.3
[grid]
nx = 16
ny = 16
lx = 16.0
ly = 16.0
[time]
dt = 0.5
end = 200.0
[output]
sample_every = 0.5
frame_every = 0.5
"""


def write(folder, *changes):
    text = EXCHANGE
    for old, new in changes:
        assert old in text, old
        text = text.replace(old, new, 1)
    (folder / "exchange.toml").write_text(text)
    return "exchange.toml"


def test_a_scene_has_its_noises_in_every_command(tmp_path):
    told = drover_json(tmp_path, "explain", write(tmp_path))
    assert {row["term"] for row in told["terms"]} >= {"+ J", "- J", "+ s j"}
    assert "j, white noise" in [row["name"] for row in told["coefficients"]]
    drover(tmp_path, "run", "exchange.toml", "--quiet", "--threads", "2", "-o", "whole.h5")
    drover(tmp_path, "run", "exchange.toml", "--quiet", "--set", "time.end=60", "-o", "part.h5")
    drover(tmp_path, "restart", "part.h5", "--quiet", "--set", "time.end=200")
    whole, part = contents(tmp_path / "whole.h5"), contents(tmp_path / "part.h5")
    assert [name for name in ("n", "m", "p_x", "p_y") if whole[name] != part[name]] == []
    with h5py.File(tmp_path / "whole.h5") as run:
        n, m = (np.fft.fft2(run[name][40:]) / 256 for name in ("n", "m"))
        measured = 256 * np.mean(n[:, 0, 1] * m[:, 0, 1].conj()).real
    # d_t n = -D q^2 n + f, d_t m = -2 D q^2 m - f with <f f> = 2 T q^2: <n m> = -2 T q^2/(3 D q^2) = -0.0667.  One mode
    # in 180 s with a decay time of 1/q^2 = 6.5 s: 28 independent values, 20 % of the largest correlation that there is.
    assert measured == pytest.approx(-0.2 / 3.0, rel=0.6)
    fitted = drover_json(tmp_path, "fit", "whole.h5", "coefficients.T", "coefficients.s")["coefficients"]
    for found, true in zip(fitted, (0.1, 0.3)):
        assert found["value"] == pytest.approx(true, abs=4 * found["error"])


@not_sanitized  # without the module
def test_a_scene_gives_its_model_and_a_model_its_scene(tmp_path):
    scene = library.Scene.load(str(tmp_path / write(tmp_path)))
    assert scene.model.noises == (library.Noise("j", spin=1),)
    again = scene.model.scene(points=16, side=16.0, dt=0.3, end=3.0)
    assert (again["output.sample_every"], again["output.frame_every"]) == (0.3, 1.2)
    assert again.model.latex == scene.model.latex and again.model.noises == scene.model.noises
    factors = again.model.structure_factors([0.7]).sel(component="n", with_component="m")
    assert factors.values == pytest.approx(-0.2 / 3.0, rel=1e-12)
    assert scene.set({"coefficients.T": 0.2}).model.coefficients["T"] == 0.2


@pytest.mark.parametrize("change, said", [
    (('"-g p + lap p + s j"', '"-g p + lap p + n (s + j.j) j"'), ["exchange.toml:18:19", "noise as a factor, once"]),
    (('"D lap n + J"', '"D lap n + j"'), ["exchange.toml:16:", "a vector", "a scalar"]),
    (('symbol = "j"\n', 'symbol = "n"\n'), ["exchange.toml:12:", "used twice"]),
    (('symbol = "j"\n', ""), ["white_noise[1] has no symbol", "xi"]),
    (('symbol = "j"\n', 'symbol = "j"\nstrength = 2\n'), ["strength", "expected one of"]),
    (('rank = "vector"\n[equations]', 'rank = "tensor"\n[equations]'), ["white_noise[1].rank", "nematic"]),
    (('"D lap n + J"', '"D lap n + d_x j_x"'), ["isotropic noise"]),
])
def test_noises_that_do_not_fit_are_rejected_at_their_place(tmp_path, change, said):
    rejected(tmp_path, ["check", write(tmp_path, change)], said)


WALKERS = """
field = [{symbol = "c", name = "walkers", conserved = true, reference = "c0"}]
white_noise = [{symbol = "j", rank = "vector"}]
grid = {nx = 16, ny = 16, lx = 16, ly = 16}
time = {dt = 0.1, end = 200}
output = {frame_every = 0, sample_every = 1}
[equations]
c = "D lap c + div(sqrt(2 D max(c, 0)) j)"
[coefficients]
D = 1
"""


@pytest.mark.parametrize("term", ["s/xi", "log(xi)", "xi^2/xi"])
def test_noise_in_a_divisor_is_rejected_at_its_place(term):
    with pytest.raises(library.Error, match=r"s\.equation:1:4: .*is not proportional to its noise"):
        library.Model([library.Field("s", f"-s + {term}")], noises=[library.Noise("xi")])


def test_noise_without_a_value_in_a_state_is_said():
    model = library.Model([library.Field("s", "-s + lap s + sqrt(s) xi")], noises=[library.Noise("xi")])
    assert model.structure_factors([1.0], state={"s": 0.5}).item() == pytest.approx(0.5 / 4)  # s/(2 (1 + q^2))
    with pytest.raises(library.Error, match="the noise of the model is not finite in this uniform state"):
        model.structure_factors([1.0], state={"s": -0.5})


@pytest.mark.parametrize("density", [40.0, 1.0])
def test_a_density_of_few_particles_for_each_mode_is_said(tmp_path, density):
    """Fluctuations of independent particles: c0 area/modes = 5.2 c0 for 7 by 7 modes in a cell of 256."""
    (tmp_path / "walkers.toml").write_text(WALKERS + f"c0 = {density}\n")
    told = drover(tmp_path, "run", "walkers.toml").stderr
    found = re.search(r"fluctuate like (\S+) particles for each kept mode", told)
    assert (found is None) == (density * 256.0 / 49.0 > 10.0), told
    if found:  # 200 samples of the shortest waves, which relax within one: a few per cent; max(c, 0) adds to them
        assert float(found[1]) == pytest.approx(density * 256.0 / 49.0, rel=0.15)
        assert "it is below 0 somewhere in" in told and "choose a coarser grid or a larger density" in told


TURNING = """
model = {name = "angles", calculus = "stratonovich"}
field = [{symbol = "p", rank = "vector"}]
white_noise = [{symbol = "eta", parity = "odd"}]
equations = {p = "-k p + sqrt(2 D) perp(p) eta"}
coefficients = {k = 0.1, D = 0.5}
grid = {nx = 12, ny = 12, lx = 6.0, ly = 6.0}
time = {dt = 0.01, end = 1.0}
initial = {kind = "formula", p_x = "1"}
output = {sample_every = 0.1, frame_every = 0.5}
"""


def test_a_drift_of_stratonovich_is_a_term_whose_number_is_printed(tmp_path):
    """Of the angle that noise turns the drift is -D M p, M the kept modes per area: |k| < 12/3 of products of two."""
    (tmp_path / "angles.toml").write_text(TURNING)
    modes = 7 * 7 / 36.0
    told = drover_json(tmp_path, "explain", "angles.toml")
    assert told["noise_modes_per_area"] == pytest.approx(modes, rel=1e-14)
    assert "drift of sqrt(2 D) perp(p) eta" in [row["term"] for row in told["terms"]]
    state = drover_json(tmp_path, "stability", "angles.toml")["states"][0]
    ito = drover_json(tmp_path, "stability", "angles.toml", "--set", "model.calculus=ito")["states"][0]
    assert "0.780" in str(state) and "0.780" not in str(ito)  # 0.1 + 0.5 modes
    finer = drover_json(tmp_path, "explain", "angles.toml", "--set", "grid.nx=24", "--set", "grid.ny=24")
    assert finer["noise_modes_per_area"] == pytest.approx(15 * 15 / 36.0, rel=1e-14)
    drover(tmp_path, "run", "angles.toml", "--quiet")
    with h5py.File(tmp_path / "angles.h5") as file:
        size = np.hypot(file["p_x"][:], file["p_y"][:])
        decay = np.exp(-0.1 * file["time"][:])
    # Products lose the modes beyond the kept ones, so the length is kept on average over the cell alone.
    assert np.sqrt((size[-1] ** 2).mean()) == pytest.approx(decay[-1], rel=0.2)
    scene = library.Scene.load(tmp_path / "angles.toml")
    assert scene.model.calculus == "stratonovich"
    with pytest.raises(library.Error, match="depends on the grid; expected a scene"):
        scene.model.growth_rates([0.0])
    with pytest.raises(library.Error, match="expected 'ito' or 'stratonovich'"):
        library.Model([library.Field("u", "-u")], calculus="stratonowich")
    again = scene.model.scene(points=12, side=6.0, dt=0.1, end=0.2)
    assert again["model.calculus"] == "stratonovich"


PLACED = """field = [{symbol = "a"}]
white_noise = [{symbol = "xi"}]
grid = {nx = 16, ny = 16, lx = 8.0, ly = 8.0}
time = {dt = 0.1, end = 5.0}
equations = {a = "-a + lap a + (1 + 0.5 cos(2 pi x / 8)) xi"}
"""


def test_the_prediction_is_about_the_conserved_mean_of_the_start(tmp_path):
    """A start of 40 where the reference is 20: S(q) = 40, exactly, in every direction and at every |q|."""
    (tmp_path / "walkers.toml").write_text(WALKERS + "c0 = 20\n")
    found = drover_json(tmp_path, "run", "walkers.toml", "--set", "initial.kind=formula",
                        "--set", "initial.walkers=\"40\"", "--quiet")
    factor = found["results"]["structure_factor_walkers"]
    assert np.allclose(factor["linear"], 40.0, rtol=1e-12)
    deviations = [(value["mean"] - 40.0) / value["error"] for value in factor["values"] if value["error"]]
    assert len(deviations) >= 3 and np.abs(deviations).max() < 4.0  # standard errors


def test_the_step_that_is_recommended_with_noise_that_multiplies_fields_is_of_order_a_half(tmp_path):
    """No method is of a higher order along a path, so that none is recommended in its place."""
    (tmp_path / "walkers.toml").write_text(WALKERS + "c0 = 40\n")
    said = drover(tmp_path, "run", "walkers.toml", "--set", "time.dt=0.5").stderr
    error, better = map(float, re.search(r"estimated error is (\S+) of .* choose time.dt = ([\d.]+)", said).groups())
    assert better <= 0.5 * (0.01 / error)**2 * 1.1  # the error that is printed is rounded
    assert "etdrk4-krogstad" not in said


def test_noise_that_depends_on_the_place_has_no_prediction_and_all_else(tmp_path):
    (tmp_path / "placed.toml").write_text(PLACED)
    ended = drover(tmp_path, "run", "placed.toml")
    assert "variance_a" in ended.stdout
    assert "depends on position or time, so that no uniform state has it" in ended.stdout
    drover(tmp_path, "restart", "placed.h5", "--set", "time.end=6")
    assert "variance_a" in drover(tmp_path, "info", "placed.h5").stdout
    drover(tmp_path, "stability", "placed.toml", "-o", "stability.h5")
    with h5py.File(tmp_path / "stability.h5") as file:
        names = []
        file.visit(names.append)
    assert not [name for name in names if "structure_factor" in name]


def noisy(strength, dt, end, points=(32, 32), **more):
    """The mean square of phi at the end of six runs from 0, phi' = -0.3 phi + g xi, over that of the kept modes for
    g = 1, with their warnings."""
    model = library.Model([library.Field("phi", f"-0.3 phi + ({strength}) xi")], noises=[library.Noise("xi")], **more)
    squares = []
    for seed in range(6):
        run = model.scene(points=points, side=points, dt=dt, end=end).set("run.seed", seed).start()
        run.advance()
        squares.append(float((run.frame.phi**2).mean()))
    modes = np.abs(np.fft.fft2(run.frame.phi))
    kept = np.count_nonzero(modes > 1e-9 * modes.max()) / modes.size
    return np.mean(squares) / kept, np.std(squares) / np.sqrt(5.0) / kept, run.warnings


def test_noise_begins_at_the_step_at_which_its_strength_does():
    found, error, warnings = noisy("step(t - 2)", 0.5, 4.0)
    assert abs(found - (1.0 - np.exp(-0.6 * 2.0)) / 0.6) < 4.0 * error and warnings == []


@pytest.mark.parametrize("strength, is_told", [
    ("1 + 20 exp(-((t - 3.2)/0.05)^2)", True), ("1 + 3 cos(8 pi t)", True), ("1 + 0.8 cos(t)", False)])
def test_the_step_is_compared_with_the_strength_of_noise(strength, is_told):
    _, _, warnings = noisy(strength, 0.5, 10.0, (8, 8))
    assert bool([one for one in warnings if "does not resolve the time dependence" in one]) == is_told, warnings


@pytest.mark.parametrize("strength, is_told", [
    ("1 + 3 exp(-((x - 8.5)/0.2)^2)", True), ("1 + 3 cos(2 pi x)", True), ("1 + 0.8 cos(2 pi x/16)", False)])
def test_the_grid_is_compared_with_the_strength_of_noise(strength, is_told):
    _, _, warnings = noisy(strength, 0.5, 2.0, (16, 16))
    assert bool([one for one in warnings if "relative error of the noise of phi" in one]) == is_told, warnings


def test_no_tolerance_is_advised_where_noise_multiplies():
    model = library.Model([library.Field("phi", "-0.3 phi + 0.8 phi xi + 0.1 xi")], noises=[library.Noise("xi")])
    scene = model.scene(points=16, side=16.0, dt=0.5, end=5.0, initial={"phi": "1"})
    run = scene.set({"time.tolerance": 1e-3}).start()
    run.advance()
    assert [one for one in run.warnings if "choose time.dt" in one]
    assert not [one for one in run.warnings if "choose time.tolerance" in one]


@pytest.mark.parametrize("points", [(64, 1), (24, 1), (12, 12)])
def test_noise_that_does_not_drive_a_field_is_no_alarm(points):
    # In one dimension j_y drives nothing, and xi drives phi alone: rounding errors on either grid.
    walkers = library.Model(
        [library.Field("c", "D lap c + div(0.3 c grad(cos(q x))) + div(sqrt(2 D max(c, 0)) j)", conserved=True,
                       reference=40.0), library.Field("phi", "-phi + (1 + 0.5 cos(q x)) phi xi")],
        noises=[library.Noise("j", spin=1), library.Noise("xi")], D=1.0, q=2.0 * np.pi / 12.0)
    run = walkers.scene(points=points, side=(12.0, 12.0 * points[1] / points[0]), dt=0.01, end=0.05).start()
    run.advance()
    assert not [one for one in run.warnings if "relative error" in one], run.warnings


def test_noise_without_a_value_in_the_smooth_state_hides_no_other_term():
    model = library.Model([library.Field("a", "2 - a + 50 exp(-((t - 2.03)/0.01)^2) + sqrt(a - 1) xi")],
                          noises=[library.Noise("xi")])
    scene = model.scene(points=8, side=8.0, dt=0.1, end=4.0, initial={"a": "20"})
    assert [one for one in scene.check() if "does not resolve the time dependence" in one]
