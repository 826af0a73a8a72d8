"""tests/app/test_own_balance.py: fields in balance are recorded and measured as those with a rate are."""
import h5py
import numpy as np
import pytest
from support import drover

SCENE = """
[[field]]
symbol = "n"
name = "density"
conserved = true
reference = 1.0
noise = "0.01"
conserved_noise = true
[[field]]
symbol = "v"
name = "flow"
rank = "vector"
balance = true
unit = "mm/s"
[[field]]
symbol = "w"
name = "drift"
rank = "vector"
balance = true
[equations]
n = "-div(n v) + D lap n"
v = "eta lap v - G v - E grad n"
w = "-2 w - n grad n"
[coefficients]
D = 0.5
eta = 0.8
G = 1.5
E = 0.7
[grid]
nx = 32
ny = 24
lx = 24.0
ly = 16.0
[time]
dt = 0.02
end = 4.0
[output]
frame_every = 2.0
sample_every = 0.5
"""
GRID = (24, 32)
QX = 2 * np.pi * np.fft.rfftfreq(32, 24.0 / 32)
QY = 2 * np.pi * np.fft.fftfreq(24, 16.0 / 24)[:, None]


@pytest.fixture(name="archive")
def archive_of(tmp_path):
    (tmp_path / "own.toml").write_text(SCENE)
    drover(tmp_path, "run", "own.toml", "-o", "own.h5", "--quiet")
    with h5py.File(tmp_path / "own.h5") as file:
        yield file


def test_frames_hold_the_flow_that_balances_the_forces(archive):
    assert archive["flow_x"].attrs["units"] in (b"mm/s", "mm/s", "mm s-1", b"mm s-1")
    for frame in range(3):
        n = np.fft.rfft2(archive["density"][frame])
        square = QX ** 2 + QY ** 2
        # eta lap v - G v - E grad n = 0, wave by wave; the shortest waves of rfft2 are not kept.
        for name, q in (("flow_x", QX), ("flow_y", QY)):
            flow = np.fft.rfft2(archive[name][frame])
            assert abs(flow + 1j * q * 0.7 * n / (1.5 + 0.8 * square)).max() < 1e-12 * abs(n).max()
        # A balance without derivatives of its field holds at every point, products included.
        for name, q in (("drift_x", QX), ("drift_y", QY)):
            slope = np.fft.irfft2(1j * q * n, GRID)
            assert archive[name][frame] == pytest.approx(-archive["density"][frame] * slope / 2.0, abs=1e-12)


def test_observables_of_the_flow_are_those_of_its_frames_and_of_the_linear_theory(archive):
    samples = archive["observables"]
    for frame, sample in ((1, 4), (2, 8)):
        flow = [archive[f"flow_{axis}"][frame] for axis in "xy"]
        assert samples["variance_flow"][sample] == pytest.approx(sum(part.var() for part in flow), rel=1e-10)
        assert samples["largest_flow"][sample] == pytest.approx(np.hypot(*flow).max(), rel=1e-10)
    # Every wave of the flow is that of the density times i q E/(G + eta q^2), along q.
    of_density, of_flow = samples["structure_factor_density"][8], samples["structure_factor_flow_along"][8]
    summary = archive["summary"]
    q = summary["wavenumber"][:]
    ratio = summary["structure_factor_flow_along_linear"][:] / summary["structure_factor_density_linear"][:]
    # Shells mix waves whose |q| differ by a step of the grid, 2 pi/24.
    response = (0.7 * q / (1.5 + 0.8 * q ** 2)) ** 2
    assert ratio == pytest.approx(response, rel=0.15) and of_flow / of_density == pytest.approx(response, rel=0.5)
    assert np.all(summary["structure_factor_flow_across_linear"][:] < 1e-20)


def test_a_run_starts_from_such_frames_and_resumes_with_the_same_bytes(archive, tmp_path):
    drover(tmp_path, "run", "own.toml", "-o", "next.h5", "--quiet", "--set", "initial.kind=file", "--set",
           "initial.file=own.h5", "--set", "initial.frame=2")
    drover(tmp_path, "run", "own.toml", "-o", "half.h5", "--quiet", "--set", "time.end=2.0")
    with h5py.File(tmp_path / "next.h5") as after, h5py.File(tmp_path / "half.h5") as half:
        # The start goes through transforms there and back.
        assert after["flow_y"][0] == pytest.approx(archive["flow_y"][2], abs=1e-12)
        assert np.array_equal(half["flow_x"][1], archive["flow_x"][1])


def test_a_field_in_balance_that_is_not_finite_keeps_the_results_of_the_others(tmp_path):
    (tmp_path / "scene.toml").write_text("""
field = [{symbol = "u", noise = 0.1}, {symbol = "w", balance = true}]
grid = {nx = 8, ny = 8, lx = 8.0, ly = 8.0}
time = {dt = 0.1, end = 5.0}
output = {frame_every = 0.0, sample_every = 0.5}
[equations]
u = "-0.01 u + lap u"
w = "-w + 1e308 u + 1e308 u^2"
""")
    ended = drover(tmp_path, "run", "scene.toml", "-q", "-o", "run.h5")
    assert "variance_u" in ended.stdout and "not finite in at least one sample: variance_w" in ended.stdout
