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


@pytest.mark.parametrize("density", [40.0, 1.0])
def test_a_density_of_few_particles_for_each_mode_is_said(tmp_path, density):
    """Fluctuations of independent particles: c0 area/modes = 5.2 c0 for 7 by 7 modes in a cell of 256."""
    (tmp_path / "walkers.toml").write_text(WALKERS + f"c0 = {density}\n")
    told = drover(tmp_path, "run", "walkers.toml").stderr
    found = re.search(r"fluctuate as with (\S+) particles for each kept mode", told)
    assert (found is None) == (density * 256.0 / 49.0 > 10.0), told
    if found:  # 200 samples of the shortest waves, which relax within one: a few per cent; max(c, 0) adds to them
        assert float(found[1]) == pytest.approx(density * 256.0 / 49.0, rel=0.15)
        assert "it is below 0 somewhere in" in told and "choose a coarser grid or a larger density" in told
