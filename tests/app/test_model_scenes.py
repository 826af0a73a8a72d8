"""tests/app/test_model_scenes.py: a scene with its own fields in every command of the program, and its errors."""
import csv
import json
import os
import pty
import re
import select
import signal
import subprocess
import time

import h5py
import numpy as np
import pytest
from rejection import rejected
from support import (DROVER, MODELS, checkpoints, contents, drover, drover_json, environment, settings, start,
                     wait_until)

# A scalar, a pseudoscalar, a vector and a nematic.
FOUR = """[model]
name = "four ranks"

[[field]]
name = "density"
symbol = "rho"
unit = "1/mm^2"
meaning = "number density"
conserved = true
reference = "rho0"
noise = "2 D rho0"
conserved_noise = true

[[field]]
name = "vorticity"
symbol = "w"
parity = "odd"
unit = "1/s"

[[field]]
name = "polarity"
symbol = "p"
rank = "vector"
noise = 0.01

[[field]]
name = "nematic_order"
symbol = "Q"
rank = "nematic"

[equations]
rho = "-div J + D lap rho"
w = "-w + nu lap w + curl p"
p = "(a rho - b p.p) p + lap p - grad rho - lambda Q.p + 0.1 w perp p"
Q = "-Q + lap Q + sym(outer(p, p)) - 0.5 (Q:Q) Q"

[define]
J = "u rho p"

[coefficients]
rho0 = 0.8
D = 0.5
nu = 0.7
a = 0.6
b = 1.0
lambda = 0.2
u = 0.3

[grid]
nx = 32
ny = 32
lx = 32.0
ly = 32.0

[time]
dt = 0.05
end = 10.0
stepper = "etdrk4-krogstad"

[initial]
kind = "formula"
amplitude = 0.01
polarity_x = "0.5"
density = "0.8 + 0.1 cos(2 pi x / 32)"

[output]
frame_every = 2.0
sample_every = 0.25
"""
COMPONENTS = ["density", "vorticity", "polarity_x", "polarity_y", "nematic_order_xx", "nematic_order_xy"]


def write(folder, *changes, name="four.toml"):
    """The scene with texts replaced, each of which must be there."""
    text = FOUR
    for old, new in changes:
        assert old in text, old
        text = text.replace(old, new, 1)
    (folder / name).write_text(text)
    return name


def run(folder, output, *keys, threads=1):
    drover(folder, "run", write(folder), "--quiet", "--overwrite", "--threads", threads, "-o", output, *settings(keys))
    return folder / output


def same(one, other):
    a, b = contents(one), contents(other)
    assert {*COMPONENTS, "observables/mean_density", "summary/mean_density"} <= set(a) == set(b)
    return [name for name in a if a[name] != b[name]] == []


def test_check_and_explain_describe_the_fields_and_terms(tmp_path):
    assert drover(tmp_path, "check", write(tmp_path)).stdout == "four.toml: valid\n"
    told = drover_json(tmp_path, "explain", "four.toml")
    assert [(field["symbol"], field["rank"]) for field in told["fields"]] == [
        ("rho", "scalar"), ("w", "odd scalar"), ("p", "vector"), ("Q", "nematic")]
    numbers = {row["name"]: row["value"] for row in told["coefficients"]}
    assert numbers["conserved noise of rho"] == 2.0 * 0.5 * 0.8 and numbers["nu"] == 0.7
    assert told["degree"] == 3
    lines = drover(tmp_path, "explain", "four.toml").stdout
    for term in ("-div J", "+ D lap rho", "+ curl p", "- lambda Q.p", "+ sym(outer(p, p))", "- 0.5 (Q:Q) Q"):
        assert f"  {term}\n" in lines, term


def test_explain_has_the_growth_and_the_modes_of_a_model_of_ones_own(tmp_path):
    """d_t u = r u - (lap + 1)^2 u - u^3: the fastest wave has |q| = 1 /mm, which is mode 16 of the grid, and the rate
    r = 0.1 /s; the highest kept mode has |q|^2 = 2 (k/16)^2."""
    told = drover_json(tmp_path, "explain", MODELS / "swift-hohenberg.toml")
    assert told["growth_rate"] == pytest.approx(0.1, abs=1e-9)  # (lap + 1)^2 cancels in lap lap + 2 lap + 1
    assert told["growth_wavenumber"] == pytest.approx(1.0, rel=1e-12) and told["growth_leaves_out"] == []
    kept = told["largest_mode_kept"]["x"]
    assert kept * (told["degree"] + 1) < 128 <= (kept + 1) * (told["degree"] + 1)
    assert told["fastest_rate"] == pytest.approx((2.0 * (kept / 16)**2 - 1.0)**2 - 0.1, rel=1e-9)
    count = told["transforms_per_right_hand_side"]
    assert told["transforms_per_step"] == told["right_hand_sides_per_step"] * (count["inverse"] + count["forward"])
    assert told["memory_bytes"] > 8 * 128**2 and told["seconds_estimate"] > 0.0
    lines = drover_json(tmp_path, "explain", MODELS / "swift-hohenberg.toml", "--set",
                        'equations.u="r u - u^3 + 0.1 d_x d_x u"')
    assert lines["growth_leaves_out"] == ["+ 0.1 d_x d_x u"] and lines["growth_rate"] == pytest.approx(0.1, rel=1e-12)


def test_a_run_on_other_threads_and_one_killed_and_resumed_give_the_same_bytes(tmp_path):
    keys = ["grid.nx=64", "grid.ny=64"]
    whole = run(tmp_path, "whole.h5", *keys)
    assert same(whole, run(tmp_path, "two.h5", *keys, threads=2))
    assert not same(whole, run(tmp_path, "seed.h5", *keys, "run.seed=2"))
    for threads in (1, 2):
        killed = tmp_path / f"killed-{threads}.h5"
        process = start(tmp_path, "run", "four.toml", "--quiet", "--threads", str(threads), "-o", killed.name,
                        *settings([*keys, "output.checkpoint_minutes=0.001"]))
        wait_until(lambda: any(path.exists() for path in checkpoints(killed)), "a checkpoint", process=process)
        process.send_signal(signal.SIGKILL)
        process.communicate()
        drover(tmp_path, "restart", killed, "--quiet", "--threads", 3 - threads)
        assert same(whole, killed), threads
    stopped = tmp_path / "stopped.h5"
    drover(tmp_path, "run", "four.toml", "--quiet", "--max-time", "0.01", "-o", stopped, *settings(keys), status=3)
    drover(tmp_path, "restart", stopped, "--quiet")
    assert same(whole, stopped)


@pytest.mark.parametrize("scene, end", [("active-nematic", 4.0), ("bidisperse-bed", 4.0), ("kpz", 20.0)])
def test_fields_in_balance_with_mass_and_on_a_line_restart_to_the_same_bytes(tmp_path, scene, end):
    keys = ["grid.nx=16", "grid.lx=16"] + (["grid.ny=16", "grid.ly=16"] if scene != "kpz" else [])
    for output, last in (("whole.h5", 2.0 * end), ("parts.h5", end)):
        drover(tmp_path, "run", MODELS / f"{scene}.toml", "--quiet", "-o", output,
               *settings([*keys, "output.frame_every=1", "output.sample_every=0.5", f"time.end={last}"]))
    drover(tmp_path, "restart", "parts.h5", "--quiet", "--set", f"time.end={2.0 * end}")
    whole, parts = contents(tmp_path / "whole.h5"), contents(tmp_path / "parts.h5")
    assert set(whole) == set(parts) and [name for name in whole if whole[name] != parts[name]] == []


def test_info_and_exports_contain_every_component(tmp_path):
    archive = run(tmp_path, "four.h5")
    told = drover_json(tmp_path, "info", archive)
    assert told["results"]["mean_density"]["mean"] == pytest.approx(0.8, rel=1e-14)  # conserved
    drover(tmp_path, "export", archive, "-o", "four.csv", "--frame", 3)
    drover(tmp_path, "export", archive, "-o", "four.vtk", "--frame", 3)
    with h5py.File(archive) as file:
        frames = {name: file[name][3] for name in COMPONENTS}
        assert file["density"].attrs["units"] in ("1/mm^2", b"1/mm^2", "mm-2", b"mm-2")
    with (tmp_path / "four.csv").open() as file:
        rows = list(csv.reader(line for line in file if not line.startswith("#")))
    titles = [re.sub(r" .*", "", title) for title in rows[0]]
    numbers = np.array(rows[1:], dtype=float)
    vtk = (tmp_path / "four.vtk").read_bytes()
    arrays = re.findall(rb"^(\w+) (\d) 1024 double$", vtk, re.M)
    assert arrays == [(b"density", b"1"), (b"vorticity", b"1"), (b"polarity", b"3"), (b"nematic_order_xx", b"1"),
                      (b"nematic_order_xy", b"1")]
    for name in COMPONENTS:
        column = numbers[:, titles.index(name)]
        assert np.sort(column) == pytest.approx(np.sort(frames[name].ravel()), rel=1e-6, abs=1e-12), name


def test_a_sweep_over_a_coefficient_runs_each_value(tmp_path):
    table = drover(tmp_path, "sweep", write(tmp_path), "--vary", "coefficients.a = 0.2, 0.6", "--quiet").stdout
    assert "variance_density" in table and "size_mean_polarity" in table
    with (tmp_path / "four.sweep" / "table.csv").open() as file:
        rows = list(csv.DictReader(file))
    name = next(title for title in rows[0] if title.startswith("coefficients.a"))
    assert [float(row[name]) for row in rows] == [0.2, 0.6]
    order = next(title for title in rows[0] if re.fullmatch(r"size_mean_polarity( \[1\])?", title))
    assert float(rows[0][order]) < float(rows[1][order])  # a feeds the order


def test_a_run_starts_from_a_frame_of_another(tmp_path):
    first = run(tmp_path, "first.h5")
    formulas = 'kind = "formula"\namplitude = 0.01\npolarity_x = "0.5"\ndensity = "0.8 + 0.1 cos(2 pi x / 32)"\n'
    scene = write(tmp_path, (formulas, 'kind = "file"\nfile = "first.h5"\n'), name="second.toml")
    drover(tmp_path, "run", scene, "--quiet")
    with h5py.File(first) as one, h5py.File(tmp_path / "second.h5") as other:
        for name in COMPONENTS:
            assert other[name][0] == pytest.approx(one[name][-1], abs=1e-12), name


@pytest.mark.parametrize("old, new, says", [
    ('unit = "1/s"', 'unti = "1/s"', ["four.toml:18:1", "field[2].unti", "did you mean field[2].unit"]),
    ('w = "-w', 'omega = "-w', ["four.toml:33:10", "equations.omega", "expected one of rho, w, p, Q"]),
    ('w = "-w + nu lap w + curl p"\n', "", ["four.toml:16:11", "w has no equation", 'expected w = "..."']),
    ("- grad rho", "- rho", ["four.toml:34:34", "this is a scalar; expected a vector"]),
    ("+ curl p", "+ div p", ["four.toml:33:22", "this is a scalar; expected a pseudoscalar", "chiral = true"]),
    ("nu lap w", "nu ∇²w", ["four.toml:33:14", "character 9", "expected a word for this operator", "lap u"]),
    ("+ curl p", "+ p.p**2", ["four.toml:33:", "a power is written with ^, as in u^2"]),
    ("[grid]", '[[field]]\nsymbol = "w"\nname = "spin"\n\n[grid]', ["four.toml:", "w is the symbol of two fields"]),
    ("nu lap w", "mu lap w", ["four.toml:33:11", '"mu" at character 6', "expected one of", "nu"]),
    ("2 D rho0", "2 D rho1", ["four.toml:11:14", '"rho1" at character 5', "rho0 (did you mean that?)"]),
    ("[grid]", "[relaxation]\nrate = 1.0\n\n[grid]",
     ["four.toml:49:2", "[relaxation] belongs to a scene of fields", "[model] (four.toml:1:2)", "remove one"]),
    ('rank = "vector"', 'rank = "vector"\nreference = 0.5', ["four.toml:20:1", "polarity", "is 0.5; expected 0"]),
    ("J + D lap rho", "J + D rho", ["four.toml:32:15", '"+ D rho" is no divergence', "conserved = false"]),
    ("polarity_x =", "polarity_z =", ["four.toml:63:1", "initial.polarity_z", "did you mean initial.polarity_"]),
    ("polarity_x =", "polar_order_x =", ["four.toml:63:1", "initial.polar_order_x", "expected one of", "polarity_x"]),
    ("nu = 0.7", 'nu = "b"', ["four.toml:43:1", 'coefficients.nu = "b"', "expected a number"]),
    ('name = "vorticity"', 'name = "time"', ["four.toml:15:9", "w would be time in archives", "another name"]),
    ('name = "vorticity"', 'name = "polarity_x"', ["four.toml:", "polarity_x", "another name"]),
    ('rank = "vector"', 'rank = "tensor"', ["four.toml:23:1", 'field[3].rank = "tensor"', "vector"]),
    ('J = "u rho p"', 'J = "J p"', ["four.toml:38:6", "J is defined by itself"]),
])
def test_a_mistake_in_a_model_is_reported_at_its_place(tmp_path, old, new, says):
    rejected(tmp_path, ["check", write(tmp_path, (old, new))], says)


def test_a_key_of_a_model_that_the_scene_does_not_have_cannot_be_set_or_swept(tmp_path):
    scene = write(tmp_path)
    for setting, says in [("coefficients.nuu=1", ["coefficients.nuu", "no coefficient nuu", "did you mean nu?"]),
                          ("field[9].noise=1", ["no [field[9]]", "expected one of"]),
                          ("field[1].nose=1", ["field[1].nose", "did you mean field[1].noise"]),
                          ("equations.z=1", ["equations.z is the equation of no field"])]:
        rejected(tmp_path, ["run", scene, "--set", setting], says)
    rejected(tmp_path, ["sweep", scene, "--vary", "coefficients.nuu = 1, 2"], ["no coefficient nuu"])
    (tmp_path / "none.toml").write_text('[equations]\nphi = "-phi"\n\n[time]\ndt = 0.1\n')
    rejected(tmp_path, ["check", "none.toml"], ["none.toml:2:8", "equation of no field", "expected [[field]]"])


def test_a_command_that_needs_particles_rejects_a_model(tmp_path):
    scene = write(tmp_path)
    rejected(tmp_path, ["calibrate", scene], ["four.toml", "this is a scene of a model of its own"])


def test_boundary_of_a_model_traces_where_its_uniform_state_becomes_unstable(tmp_path):
    """b = (1 + a sqrt(Du/Dv))^2 of the Brusselator (Prigogine and Lefever 1968), to the printed 8 digits."""
    result = drover_json(tmp_path, "boundary", MODELS / "brusselator.toml", "--x", "a = 3:4", "--y",
                         "coefficients.b = 6:13", "--set", "boundary.map=0", "--set", "boundary.cells=4", "--set",
                         "boundary.chord=0.01", "--json")
    (traced,) = result["traced"]
    points = [point for line in traced["lines"] for point in line["points"]]
    assert traced["state"] == "isotropic" and len(points) > 3
    for point in points:
        assert point["y"] == pytest.approx((1.0 + point["x"] * (5.0 / 12.0) ** 0.5) ** 2, rel=1e-8)
        assert point["wavenumber"] == pytest.approx((point["x"] / 60.0 ** 0.5) ** 0.5, rel=1e-6)
    rejected(tmp_path, ["boundary", MODELS / "brusselator.toml", "--x", "aa = 1:4", "--y", "b = 2:12"],
             ["boundary.x names aa", "coefficients.a"])
    rejected(tmp_path, ["boundary", MODELS / "brusselator.toml", "--x", "a = 1:4", "--y", "b = 2:12", "--set",
                        'boundary.lines=["onset"]'], ["boundary.lines", "no field of the model has a direction"])


def lines_of(folder, scene, x, y, lines, *more):
    result = drover_json(folder, "boundary", scene, "--x", x, "--y", y, *settings(
        [f"boundary.lines={json.dumps(lines)}", "boundary.map=0", "boundary.cells=12", "boundary.chord=1e-3", *more]))
    assert [one["limit"] for one in result["traced"]] == lines
    return [[[(point["x"], point["y"]) for point in line["points"]] for line in one["lines"]]
            for one in result["traced"]]


def test_limits_of_long_waves_of_a_model_are_those_of_rods_and_beads_with_the_same_equations(tmp_path):
    """models/toner-tu.toml has the equations of models/band.toml: onset at abar = 0, banding to |abar| = 1/6."""
    for scene, x, y in (("band.toml", "uniform.rod_density", "relaxation.rate"),
                        ("toner-tu.toml", "uniform.density", "coefficients.rho_c")):
        onset, banding = lines_of(tmp_path, MODELS / scene, f"{x} = 0.5:2", f"{y} = 0.5:1.1", ["onset", "banding"])
        for lines, distance in ((onset, 0.0), (banding, 1.0 / 6.0)):
            (line,) = lines
            assert len(line) > 10
            for density, threshold in line:
                assert density - threshold == pytest.approx(distance, abs=1e-7), scene


def test_binodals_and_the_spinodal_of_cahn_and_hilliard_are_those_of_its_free_energy(tmp_path):
    """(phi^2 - 1)^2/4: phases of +-1 whatever kappa is, unstable within +-1/sqrt(3)."""
    spinodal, binodal = lines_of(
        tmp_path, MODELS / "cahn-hilliard.toml", "uniform.composition = -1.2:1.2", "kappa = 0.8:1.2",
        ["phase-separation", "binodal"], "grid.nx=256", "grid.ny=1", "grid.lx=60", 'initial.kind="formula"',
        'initial.composition="tanh((x - 15)/1.4) - tanh((x - 45)/1.4) - 1"', "initial.amplitude=0")
    for lines, size, error in ((spinodal, 3.0**-0.5, 1e-8), (binodal, 1.0, 1e-6)):
        assert sorted(round(line[0][0] / size) for line in lines) == [-1, 1]
        for line in lines:
            assert all(abs(x) == pytest.approx(size, abs=error) for x, _ in line)
            assert (min(y for _, y in line), max(y for _, y in line)) == pytest.approx((0.8, 1.2), abs=1e-6)


# F = f^4/4 - f^2/2 + f'^2/2 + (s - g f + e f^2)^2/2: f obeys the potential without s, but for c (e f^2 - g f) with the
# potential c of s.  Phases are f = +-sqrt(1 - 2 e c), s = c + g f - e f^2.
TWO_DENSITIES = """
model = {name = "two densities"}
field = [{symbol = "f", conserved = true}, {symbol = "s", conserved = true}]
grid = {nx = 256, ny = 1, lx = 80.0, ly = 1.0}
time = {dt = 0.05, end = 1.0}
boundary = {lines = ["binodal"], map = 0}
define = {c = "s - g f + e f^2"}
equations = {f = "lap(f^3 - f - lap f + c (2 e f - g))", s = "lap c"}
coefficients = {g = 0.5, e = 0.2}
initial = {kind = "formula", f = "FRONTS", s = "0.5 + 0.5 * (FRONTS)", amplitude = 0.0}
""".replace("FRONTS", "tanh((x - 20)/1.4) - tanh((x - 60)/1.4) - 1")


def test_binodals_of_two_densities_are_edges_of_coexistence_in_their_plane_alone(tmp_path):
    (tmp_path / "two.toml").write_text(TWO_DENSITIES)

    def found(axis):
        done = drover(tmp_path, "boundary", "two.toml", "--x", "uniform.f = -1.5:1.5", "--y", axis, "--json")
        traced = json.loads(done.stdout)["traced"][0]
        return [np.array([(point["x"], point["y"]) for point in line["points"]]) for line in traced["lines"]], (
            traced["notes"]), done.stderr

    # The cell has the mean s = 0.5 of its formula.
    lines, notes, said = found("uniform.s = 0.2:0.8")
    assert [np.sign(line[0, 0]) for line in lines] == [-1.0, 1.0]
    for line in lines:
        f, s = line.T
        assert np.abs(f**2 - (1.0 - 0.4 * (s - 0.5 * f + 0.2 * f**2))).max() < 1e-6
        assert len(f) > 10 and (np.diff(s) > 0.0).all()
    # In the cell of means 0.2 and 0.8 both phases lie elsewhere.
    assert len(notes) == 2 and all("ends within the plane" in note and note in said for note in notes)
    # Over a coefficient they are the phases at one mean of s; from g = 0.5, outside of the plane, on one side.
    lines, notes, said = found("g = 0.6:0.7")
    for line in lines:
        assert (np.diff(line[:, 1]) > 0.0).all() and np.ptp(line[:, 1]) > 0.09
    assert len(notes) == 1 and "s differs between the phases" in notes[0] and "uniform.s" in notes[0]
    assert notes[0] in said


def test_binodals_on_a_grid_that_does_not_resolve_their_fronts_say_so(tmp_path):
    """Waves of fronts tanh(x/w), w = sqrt(2 kappa) = 0.77, decay as exp(-pi q w/2): of the shortest sixth of the waves
    of 512 points, from q = 9 on, the square is some 1e-9 of the whole, of 64 points, from q = 1.1 on, not below 1e-3.
    """
    binodal = (MODELS / "cahn-hilliard.toml", "uniform.composition = -1.2:1.2", "kappa = 0.29:0.31", ["binodal"],
               "grid.ny=1", "grid.lx=60", 'initial.kind="formula"', "initial.amplitude=0", "coefficients.kappa=0.3",
               'initial.composition="tanh((x - 15)/0.8) - tanh((x - 45)/0.8) - 1"')
    said = {points: drover(tmp_path, "boundary", binodal[0], "--x", binodal[1], "--y", binodal[2],
                           *settings(['boundary.lines=["binodal"]', "boundary.map=0", *binodal[4:],
                                      f"grid.nx={points}"]), status=None) for points in (64, 512)}
    assert "resolve" in said[64].stdout + said[64].stderr and "choose" in said[64].stdout + said[64].stderr
    assert "resolve" not in said[512].stdout + said[512].stderr and said[512].returncode == 0


def on_a_terminal(folder, *words, until, seconds=60):
    """The process with standard error on a terminal, and what it has shown there when `until` appears or it ends."""
    ours, its = pty.openpty()
    process = subprocess.Popen([DROVER, *map(str, words)], cwd=folder, stdin=subprocess.DEVNULL, env=environment(),
                               stdout=subprocess.DEVNULL, stderr=its)
    os.close(its)
    shown, end = b"", time.monotonic() + seconds
    while until not in shown and process.poll() is None and time.monotonic() < end:
        if select.select([ours], [], [], 0.1)[0]:
            shown += os.read(ours, 4096)
    os.close(ours)
    return process, shown


def test_boundary_of_a_model_shows_progress_on_a_terminal_and_an_interrupt_ends_it_without_a_file(tmp_path):
    words = ["boundary", MODELS / "brusselator.toml", "--x", "a = 3:4", "--y", "coefficients.b = 6:13", "--output",
             "plane.h5"]
    process, shown = on_a_terminal(tmp_path, *words, until=b"points/s")
    process.send_signal(signal.SIGINT)
    assert process.wait(10) != 0 and list(tmp_path.iterdir()) == []
    assert re.search(rb"\d+ points of at least \d+, \S+ points/s", shown), shown
    process, shown = on_a_terminal(tmp_path, *words, "--quiet", until=b"points/s", seconds=2)
    process.send_signal(signal.SIGINT)
    assert process.wait(10) != 0 and shown == b""


# Two coupled scalars with noise: the waves of their frames determine coefficients of equations and noise.
COUPLED = """[model]
name = "two scalars"
[[field]]
symbol = "u"
noise = "T"
[[field]]
symbol = "w"
noise = 0.2
[equations]
u = "-a u + k w + D lap u"
w = "-b w + lap w - k u"
[coefficients]
a = 0.5
b = 0.8
k = 0.3
D = 1.5
T = 0.1
[grid]
nx = 16
ny = 16
lx = 10.0
ly = 10.0
[time]
dt = 0.5
end = 500.0
[output]
frame_every = 0.5
sample_every = 5.0
[run]
seed = 11
"""


def test_fit_finds_the_coefficients_of_a_model_from_its_frames(tmp_path):
    (tmp_path / "coupled.toml").write_text(COUPLED)
    drover(tmp_path, "run", "coupled.toml", "--quiet", "-o", "coupled.h5")
    found = drover_json(tmp_path, "fit", "coupled.h5", "a", "coefficients.D", "k", "T", "--set", "coefficients.a=1.0",
                        "--set", "coefficients.k=0.1", "--set", "coefficients.T=0.3", "--json")["coefficients"]
    for row, true in zip(found, (0.5, 1.5, 0.3, 0.1)):  # an error of 4 standard errors: 6e-5 for each of the four
        assert abs(row["value"] - true) < 4.0 * row["error"] < 0.5 * true, row
    rejected(tmp_path, ["fit", "coupled.h5", "zz"], ["fit names zz", "coefficients.a"])
