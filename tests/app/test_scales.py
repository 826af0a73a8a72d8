"""tests/app/test_scales.py: the table of a run shows each number to its digits, whatever the size of any other."""
import h5py
import pytest
from support import drover

LOGISTIC_AND_DECAY = """model = {{name = "two scales"}}
field = [{{symbol = "n", reference = "N"}}, {{symbol = "c", noise = {noise}}}]
grid = {{nx = 32, ny = 1, lx = 20.0, ly = 1.0}}
time = {{dt = 0.1, end = 60.0}}
initial = {{kind = "formula", n = "{size}*(1+0.3*cos(2 pi x/20))", c = "2e-6*(1+0.2*cos(2 pi x/20))"}}
output = {{sample_every = 0.5}}
[equations]
n = "n (1 - n/N) + lap n"
c = "k (1e-6 - c) + 0.01 lap c"
[coefficients]
N = {size}
k = 0.05
"""


def shown(text):
    """The means of the scalars in the table of a run, by name."""
    lines = text.splitlines()
    first = next(n for n, line in enumerate(lines) if line.startswith("observable"))
    rows = (line.split() for line in lines[first + 1:lines.index("", first)])
    return {row[0]: float(row[2]) for row in rows}


@pytest.mark.parametrize("size", [1.0, 1e8, 1e15])
@pytest.mark.parametrize("noise", [0.0, 1e-14])
def test_a_small_field_is_shown_beside_a_large_one(size, noise, tmp_path):
    (tmp_path / "two.toml").write_text(LOGISTIC_AND_DECAY.format(size=size, noise=noise))
    table = shown(drover(tmp_path, "run", "two.toml", "--quiet").stdout)
    of_c = [name for name in table if name.endswith("_c") and not name.startswith("spectral_tail")]
    assert len(of_c) == 4
    with h5py.File(tmp_path / "two.h5") as archive:
        for name in [*of_c, "mean_n", "max_n", "step_error"]:
            # Five digits, or where there is an error two of its own.
            mean, error = (archive["summary"][key][()] for key in (name, f"{name}_error"))
            assert table[name] == pytest.approx(mean, rel=1e-4, abs=error if error > 0 else 0.0) != 0, name
