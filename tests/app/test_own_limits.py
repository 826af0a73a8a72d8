"""tests/app/test_own_limits.py: models of one's own whose texts or fields a grid and a step cannot follow say so."""
import re

import h5py
import numpy
import pytest
from support import drover

SCENE = """
[[field]]
symbol = "u"
reference = 1.0
[[field]]
symbol = "w"
[equations]
u = "lap u + {source}"
w = "-w + w^2"
[grid]
nx = 48
ny = 1
lx = 24.0
ly = 1.0
[time]
stepper = "etdrk2"
dt = {dt}
end = {end}
[output]
frame_every = 0.0
sample_every = 0.0
[initial]
kind = "formula"
w = "{start}"
"""


def checked(folder, source="0", dt=0.1, end=10.0, start="0"):
    (folder / "own.toml").write_text(SCENE.format(source=source, dt=dt, end=end, start=start))
    return drover(folder, "check", "own.toml")


# On 48 points of 24 mm: 4 waves are smooth; 48 waves are the constant 1 at the points; a jump on 48 points is moved by
# up to half a cell.
@pytest.mark.parametrize("source, is_resolved", [
    ("cos(8 pi x / 24)", True), ("cos(96 pi x / 24)", False), ("exp(-(x - 12)^2 / 0.02)", False)])
def test_the_grid_is_compared_with_a_source_of_x(source, is_resolved, tmp_path):
    warning = checked(tmp_path, source).stderr
    assert ("the grid does not resolve a term" in warning and "choose grid.nx = 96" in warning) != is_resolved, warning


# sin^2(10 pi t) is 0 at each multiple of 0.1 and its mean is 1/2: steps of 0.1 s see no source at all.
@pytest.mark.parametrize("source, is_resolved", [("sin(0.5 t)^2", True), ("sin(10 pi t)^2", False)])
def test_the_step_is_compared_with_a_source_of_t(source, is_resolved, tmp_path):
    warning = checked(tmp_path, source).stderr
    assert ("time.dt = 0.1 does not resolve the time dependence" in warning) != is_resolved, warning


def test_a_run_that_diverges_says_which_field_did_and_where(tmp_path):
    # w = 3 for x above 12 mm blows up at t = ln(3/2); u does not feel it.
    checked(tmp_path, start="3 (1 + tanh(4 sin(2 pi (x - 12) / 24))) / 2", dt=0.02, end=2.0)
    ended = drover(tmp_path, "run", "own.toml", "--quiet", "--set", "time.max_error=0", status=1)
    # The size of w is that of the uniform state w = 1, or of its start where that is larger.
    told = re.search(r"the run diverged at or before step (\d+) .*: the root mean square of (\w+) is .*; its largest "
                     r"value is (\S+) in cell \((\d+), 0\)", ended.stderr)
    assert told, ended.stderr
    assert told[2] == "w" and float(told[3]) > 3.0 and 24 < int(told[4]) < 48
    # The numerical solution is infinite within a few steps of the exact one, and checks are ten steps apart.
    assert 0.4055 / 0.02 <= int(told[1]) <= 0.4055 / 0.02 + 20


def test_a_mass_that_vanishes_is_named(tmp_path):
    # d_t n = -1 from 1: n reaches 0 at t = 1, and n d_t v = -v divides by it.
    (tmp_path / "own.toml").write_text("""
field = [{symbol = "n", name = "beads", reference = 1.0}, {symbol = "v", name = "flow", mass = "n"}]
equations = {n = "-1", v = "1 - v"}
grid = {nx = 16, ny = 1, lx = 8.0, ly = 1.0}
time = {stepper = "etdrk2", dt = 0.01, end = 2.0}
output = {frame_every = 0.0, sample_every = 0.0}
""")
    ended = drover(tmp_path, "run", "own.toml", "--quiet", status=1)
    told = re.search(r"beads reached (\S+) on the grid, and the equation of flow divides by it", ended.stderr)
    assert told and -0.02 < float(told[1]) <= 0.0, ended.stderr


# With much effort each piece begins as soon as the one before has ended.
@pytest.mark.parametrize("effort", [0.5, 5.0])
def test_a_restart_of_a_run_that_has_ended_leaves_its_step_biases_as_they_were(effort, tmp_path):
    (tmp_path / "own.toml").write_text(f"""
field = [{{symbol = "f", noise = "0.2"}}]
equations = {{f = "-f - f^3 + lap f"}}
grid = {{nx = 16, ny = 16, lx = 16.0, ly = 16.0}}
time = {{dt = 0.5, end = 400.0}}
output = {{frame_every = 0.0, sample_every = 1.0}}
accuracy = {{effort = {effort}}}
""")
    drover(tmp_path, "run", "own.toml", "--quiet")
    with h5py.File(tmp_path / "own.h5") as file:
        before = {name: file[f"step_bias/{name}"][:] for name in ("early", "late")}
        steps = file["step_bias/steps"][:]
    # The run ends within a piece, which does not count.
    assert (steps[:-1] > 0.0).all() and steps[-1] == 0.0
    assert all((abs(numpy.nan_to_num(rows[:-1])).max(axis=1) > 0.0).all() for rows in before.values())
    drover(tmp_path, "restart", "own.h5", "--quiet")
    with h5py.File(tmp_path / "own.h5") as file:
        for name, rows in before.items():
            assert numpy.array_equal(file[f"step_bias/{name}"][:], rows, equal_nan=True)


# p decays at 0.5 - 0.1 t: its onset is at 5 s, and at 9 s it can have grown by exp(0.1 (9 - 5)^2 / 2) = 2.2, at 0.4 /s,
# where it saturates at sqrt(0.4 / 2) = 0.45.  A flow that follows it changes nothing.
@pytest.mark.parametrize("end, strength, is_late", [(4.0, 0.1, False), (9.0, 0.1, True), (40.0, 0.1, False),
                                                    (9.0, 0.0, False)])
@pytest.mark.parametrize("every", [0.5, 9.0])  # the latter is too rare to show that it has begun to grow
@pytest.mark.parametrize("kind", ["vector", "vector with a flow", "scalar", "complex"])
def test_a_ramp_that_ends_before_order_has_grown_is_told(end, strength, is_late, kind, every, tmp_path):
    every = min(every, end)
    fields, equations = f'{{symbol = "p", rank = "{kind.split()[0]}"}}', f"({strength} t - 0.5) p - 2 |p|^2 p + lap p"
    equations = f'p = "{equations}"'
    if "flow" in kind:
        fields += ', {symbol = "v", rank = "vector"}'
        equations += ', v = "100 (p - v)"'
    (tmp_path / "own.toml").write_text(f"""
field = [{fields}]
equations = {{{equations}}}
grid = {{nx = 16, ny = 16, lx = 16.0, ly = 16.0}}
time = {{dt = 0.05, end = {end}, stepper = "etdrk4-krogstad"}}
initial = {{kind = "random", amplitude = 1e-4}}
output = {{frame_every = {end}, sample_every = {every}}}
""")
    said = drover(tmp_path, "run", "own.toml", "--quiet").stdout
    told = [line for line in said.splitlines() if "at which it saturates" in line]
    assert len(told) == is_late, said
    for part in ("far below the 0.45", "a factor of at most 2.2", "at 0.4 /s at the end") if is_late else ():
        assert part in told[0], told[0]


@pytest.mark.parametrize("equations, start", [
    ('u = "u - u^2 - u*v", v = "10*u*v - 0.5*v"', 'u = "0.05", v = "0.95"'),  # predators and prey that stay
    ('u = "u - v - u*(u^2 + v^2)", v = "u + v - v*(u^2 + v^2)"', 'u = "1", v = "0"')])  # and an oscillation through 0
def test_scalars_that_others_keep_small_are_not_late(equations, start, tmp_path):
    scene = f"""
field = [{{symbol = "u"}}, {{symbol = "v"}}]
equations = {{{equations}}}
grid = {{nx = 8, ny = 8, lx = 8.0, ly = 8.0}}
time = {{dt = 0.05, end = 11.0, stepper = "etdrk4-krogstad"}}
output = {{frame_every = 1.0, sample_every = 0.5}}
"""
    (tmp_path / "first.toml").write_text(f'{scene}initial = {{kind = "formula", {start}}}\n')
    (tmp_path / "second.toml").write_text(f'{scene}initial = {{kind = "file", file = "first.h5"}}\n')
    drover(tmp_path, "run", "first.toml", "--quiet")
    assert "at which it saturates" not in drover(tmp_path, "run", "second.toml", "--quiet").stdout


def test_values_beyond_a_table_that_is_held_are_told(tmp_path):
    (tmp_path / "own.toml").write_text("""
field = [{symbol = "u", name = "heat", reference = 1.0}]
tabulated = [{symbol = "D", of = ["u"], first = [0.9, 1.0, 1.1], values = [1.0, 1.5, 2.0], outside = "hold"}]
equations = {u = "div(D grad u)"}
grid = {nx = 32, ny = 1, lx = 32.0, ly = 1.0}
time = {dt = 0.01, end = 0.1}
initial = {kind = "formula", heat = "1 + 0.3 sin(2 pi x / 32)"}
output = {frame_every = 0.1, sample_every = 0.1}
""")
    said = drover(tmp_path, "run", "own.toml", "--quiet").stdout
    for value in (0.7, 1.3):  # at the start, on a point
        assert f"heat left the table of coefficients in 2 samples, {value} at t = 0 s" in said
    assert "use a table wider than 0.9 to 1.1" in said
