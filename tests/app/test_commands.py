"""tests/app/test_commands.py: the output of each command, and what a diverging run leaves behind."""
import json
import math
import os
import pty
import re
import subprocess
import tomllib

import h5py
import numpy as np
import pytest
from rejection import rejected
from support import (DROVER, MODELS, SMALL, assert_same_bytes, checkpoint_step, checkpoints, drover, drover_json,
                     environment, scene_text, settings, write_scene)

COMMANDS = {
    "run": ["scene", "--set", "--output", "--threads", "--overwrite", "--json", "--quiet"],
    "restart": ["archive", "--set", "--threads", "--json", "--quiet"],
    "sweep": ["scene", "--set", "--output", "--vary", "--seeds", "--ramp", "--workers", "--json", "--quiet"],
    "stability": ["scene", "--set", "--output", "--threads", "--overwrite", "--json"],
    "boundary": ["scene", "--set", "--x", "--y", "--convention", "--draws", "--output", "--threads", "--overwrite",
                 "--json"],
    "check": ["scene", "--set", "--output", "--threads", "--resolved"],
    "explain": ["scene", "--set", "--output", "--threads", "--json"],
    "info": ["archive", "--scene", "--json"],
    "fit": ["archive", "keys", "--scene", "--set", "--max-wavenumber", "--from", "--to", "--every", "--json"],
    "schema": ["--json"],
}
BRIEF = {**SMALL, "time.end": 2.0, "output.frame_every": 1.0}


@pytest.mark.parametrize("command", COMMANDS)
def test_help_names_every_option_of(command, tmp_path):
    for word in ("--help", "-h"):
        ended = drover(tmp_path, command, word)
        assert ended.stderr == "" and "Usage: " in ended.stdout and f" {command} " in ended.stdout
        assert [option for option in COMMANDS[command] if option not in ended.stdout] == []
        assert ("3 stopped" in ended.stdout) == ("\n  --max-time" in ended.stdout)


def test_help_and_version(tmp_path):
    ended = drover(tmp_path, "--help")
    assert ended.stderr == "" and [command for command in COMMANDS if f"\n  {command} " not in ended.stdout] == []
    assert "Exit status: 0 success, 1 a run failed, 2 bad input, 3 stopped" in ended.stdout
    assert re.fullmatch(r"drover \d+\.\d+\.\d+ \(.+\)\n", drover(tmp_path, "--version").stdout)


def shown(text, name):
    """The number beside a name in the text of a result."""
    return float(re.search(rf"^ *{name} +(\S+)", text, re.MULTILINE)[1])


def kept_wavevectors(nx, ny, lx, ly):
    """q of every mode of a linear model: all but those of half the points of an axis, which have no sign."""
    x = 2.0 * math.pi / lx * np.arange(-(nx // 2) + 1, nx // 2)
    y = 2.0 * math.pi / ly * np.arange(-(ny // 2) + 1, ny // 2)
    return np.hypot(*np.meshgrid(x, y)).ravel()


def test_explain_of_a_scene_that_only_diffuses(tmp_path):
    scene = {"relaxation.rate": 0.0, "diffusion.rods": 0.3, "grid.nx": 32, "grid.ny": 16, "grid.lx": 20.0,
             "grid.ly": 5.0,
             "time.dt": 0.25, "time.end": 100.0}
    scene["output.frame_every"], scene["output.sample_every"] = 10.0, 0.5
    write_scene(tmp_path, scene, base={})
    report = drover_json(tmp_path, "explain", "flock.toml")
    fastest = 0.3 * kept_wavevectors(32, 16, 20.0, 5.0).max()**2
    assert report["steps"] == 400
    assert report["dt_times_fastest_rate"] == pytest.approx(0.25 * fastest,
                                                          rel=1e-12)  # rounding of eigenvalues of 3 by 3 matrices
    assert report["fastest_rate"] == pytest.approx(fastest, rel=1e-12)
    assert report["growth_rate"] == pytest.approx(0.0, abs=1e-12)
    assert [(term["name"], term["of"], term["term"], term["explicit"]) for term in report["terms"]] == [
        ("diffusion.rods", "d_t sigma", "D_sigma lap sigma", "")]
    assert [(one["name"], one["symbol"], one["value"], one["unit"]) for one in report["coefficients"]] == [
        ("inertia.bead_mass", "m", 1.0, "mg"), ("diffusion.rods", "D_sigma", 0.3, "mm^2/s")]
    assert [(field["name"], field["symbol"], field["rank"], field["unit"]) for field in report["fields"]] == [
        ("rod_density", "sigma", "scalar", "mm-2"), ("polar_order", "p", "vector", "mm-2")]
    assert report["fields"][0]["latex"].startswith(r"\partial_t \sigma = D_")
    assert report["transforms_per_right_hand_side"] == {"inverse": 0, "forward": 0} and report["archive"] == "flock.h5"
    assert 3 * 32 * 16 * 8 < report["memory_bytes"] < 1e7  # at least the fields themselves
    text = drover(tmp_path, "explain", "flock.toml").stdout
    assert "fields on 32 by 16 points, 20 by 5 mm" in text and "Cox & Matthews" in text
    assert shown(text, "steps") == 400 and shown(text, "time step") == 0.25
    assert shown(text, "dt times fastest rate") == pytest.approx(0.25 * fastest, rel=1e-5)  # six digits are shown
    assert shown(text, "growth rate") == 0.0 and "-0 s-1" not in text  # no negative zero


def growth_of(keys):
    """Fastest growth and its wavenumber, from the eigenvalues of an independent copy of the linear model."""
    get = {**{name: 0.0 for name in ("u", "a", "K", "K1", "B", "D")}, **keys}
    best = (-math.inf, 0.0)
    for q in np.unique(np.round(kept_wavevectors(32, 16, 20.0, 5.0), 12)):
        along = [[-get["D"] * q * q, -get["u"] * q], [get["B"] * q, -get["a"] - (get["K"] + get["K1"]) * q * q]]
        rates = [*np.linalg.eigvals(along).real, -get["a"] - get["K"] * q * q]
        best = max(best, (max(rates), q))
    return best


@pytest.mark.parametrize("keys", [
    {"a": -0.3, "K": 0.1},  # order that grows everywhere at once
    # rods that turn towards high density: at a finite q
    {"a": 0.5, "u": 2.0, "B": -3.0, "K": 2.0, "K1": 1.0, "D": 0.4},
])
def test_explain_reports_which_mode_grows_and_how_fast(keys, tmp_path):
    names = {"u": "current.speed", "a": "relaxation.rate", "K": "elasticity.stiffness", "K1": "elasticity.splay",
             "B": "pressure.rods", "D": "diffusion.rods"}
    scene = {names[key]: value for key, value in keys.items()}
    write_scene(tmp_path, {**scene, "grid.nx": 32, "grid.ny": 16, "grid.lx": 20.0, "grid.ly": 5.0, "time.end": 10.0},
                base={})
    report = drover_json(tmp_path, "explain", "flock.toml")
    rate, q = growth_of(keys)
    assert rate > 0.1 and report["growth_rate"] == pytest.approx(rate, rel=1e-9)
    assert report["growth_wavenumber"] == pytest.approx(q, rel=1e-9)
    text = drover(tmp_path, "explain", "flock.toml").stdout
    assert shown(text, "growth rate") == pytest.approx(rate, rel=1e-5)  # six digits are shown
    assert "unstable: a mode grows" in text and f"by a factor e^{10 * rate:.3g}" in text


@pytest.mark.parametrize("changes", [{}, {"grid.nx": 64, "grid.ny": 64, "time.end": 10.0}])
def test_a_run_takes_no_more_disk_than_explain_reports(changes, tmp_path):
    scene = write_scene(tmp_path, {**BRIEF, **changes})
    report = drover_json(tmp_path, "explain", scene)
    drover(tmp_path, "run", scene, "--quiet")
    used = sum(file.stat().st_size for file in tmp_path.glob("flock.h5*"))
    assert 0 < used <= report["disk_bytes"], report


def test_diff_names_each_key_that_differs_in_scenes_and_in_those_of_archives(tmp_path):
    write_scene(tmp_path, {"time.dt": 0.1, "time.end": 1.0})
    drover(tmp_path, "run", "flock.toml", "--set", "time.end=2.0", "-o", "longer.h5")
    rows = drover_json(tmp_path, "diff", "flock.toml", "longer.h5")
    assert {row["key"]: (row["one"], row["other"]) for row in rows} == {
        "time.end": ("1.0", "2.0"), "output.file": ('""', '"longer.h5"')}
    assert re.search(r"^time\.end +1\.0 \| 2\.0$", drover(tmp_path, "diff", "flock.toml", "longer.h5").stdout, re.M)
    assert drover(tmp_path, "diff", "flock.toml", "flock.toml").stdout == "flock.toml and flock.toml: the same scene\n"
    fields = drover_json(tmp_path, "diff", MODELS / "brusselator.toml", MODELS / "model-b.toml")
    assert any(row["key"] == "field[2].symbol" and row["other"] is None for row in fields)
    rejected(tmp_path, ["diff", "flock.toml", "none.toml"], ["none.toml"])


def test_check_of_a_valid_scene(tmp_path):
    write_scene(tmp_path, base=BRIEF)
    ended = drover(tmp_path, "check", "flock.toml")
    assert (ended.stdout, ended.stderr) == ("flock.toml: valid\n", "") and os.listdir(tmp_path) == ["flock.toml"]


@pytest.mark.parametrize("name", ["flock.h5", 'a "b" \\c\t.h5', "état é.h5", "x=1.h5"])
def test_check_resolved_reads_back_as_the_same_scene(name, tmp_path):
    write_scene(tmp_path, {"output.file": name, "sweep.vary": ["relaxation.rate = 1, 2", "noise.order = 0.1:0.3:3"],
                           "run.seed": 2**62 + 1, "relaxation.rate": 0.1 + 0.2, "noise.order": 1e-300, "grid.lx": 5e20,
                           "time.dt": 0.1})
    resolved = drover(tmp_path, "check", "flock.toml", "--resolved").stdout
    (tmp_path / "again.toml").write_text(resolved)
    assert drover(tmp_path, "check", "again.toml", "--resolved").stdout == resolved
    tables = tomllib.loads(resolved)
    assert tables["output"]["file"] == name and tables["run"]["seed"] == 2**62 + 1
    assert tables["relaxation"]["rate"] == 0.1 + 0.2 and tables["noise"]["order"] == 1e-300
    assert tables["grid"]["lx"] == 5e20 and len(tables["sweep"]["vary"]) == 2


def test_options_of_the_command_line_override_the_scene(tmp_path):
    write_scene(tmp_path, base=BRIEF)
    words = ["--set", "grid.nx=32", "--set", "time.stepper = etdrk4", "--set", 'initial.kind="random"', "--set",
             "run.seed=5",
             "--set", "run.seed=6", "-o", "other.h5", "--threads", "2"]
    tables = tomllib.loads(drover(tmp_path, "check", "flock.toml", "--resolved", *words).stdout)
    assert tables["grid"]["nx"] == 32 and tables["grid"]["ny"] == 16 and tables["time"]["stepper"] == "etdrk4"
    assert tables["initial"]["kind"] == "random" and tables["run"] == {"seed": 6, "threads": 2}  # the last one counts
    assert tables["output"]["file"] == "other.h5"


def schema(folder, *words):
    """The rows of the schema by "section.key"."""
    sections = drover_json(folder, "schema", *words)
    return {f"{section['name']}.{row['name']}": row for section in sections for row in section["rows"]}


def flat(tables, above=""):
    """Values by "section.key", of sections within sections too."""
    return {name: value for key, held in tables.items()
            for name, value in (flat(held, f"{above}{key}.") if isinstance(held, dict)
                                else {f"{above}{key}": held}).items()}


@pytest.mark.parametrize("kind, least", [("fields", ""), ("particles", "[cell]\n")])
def test_the_text_of_the_schema_is_a_scene_of_all_defaults_and_agrees_with_its_json(kind, least, tmp_path):
    text = drover(tmp_path, "schema", "--kind", kind).stdout
    # A run without a step chooses its method, unless one is given: here both have the one of the schema.
    (tmp_path / "schema.toml").write_text(text)
    method = '[time]\nstepper = "etdrk2"\n' if kind == "fields" else ""
    (tmp_path / "empty.toml").write_text(least + method)
    assert (drover(tmp_path, "check", "schema.toml", "--resolved").stdout
            == drover(tmp_path, "check", "empty.toml", "--resolved").stdout)
    rows = schema(tmp_path, "--kind", kind)
    defaults = flat(tomllib.loads(text))
    assert defaults == {key: row["default"] for key, row in rows.items()} and len(defaults) > 30
    lines = text.splitlines()
    for key, row in rows.items():
        name = key.rpartition(".")[2]
        at = next(i for i in range(len(lines)) if lines[i].startswith(f"{name} = ") and row["doc"] in lines[i + 1])
        assert f"[{row['unit']}]" in lines[at] if "unit" in row else "[" not in lines[at].split("#")[1]
        assert all(choice in lines[at] for choice in row.get("choices", []))
        assert len(row["doc"]) > 10 and row["type"] in ("a number", "an integer", "a text in quotes",
                                                             "a list of texts", "a list of numbers",
                                                             "true or false")


def test_run_and_info_report_the_same(tmp_path):
    write_scene(tmp_path, {**BRIEF, "time.end": 100.0})
    ran = drover_json(tmp_path, "run", "flock.toml")
    info = drover_json(tmp_path, "info", "flock.h5")
    assert (ran.pop("archive"), ran.pop("steps")) == ("flock.h5", 1000) and ran.pop("wall_seconds") > 0.0
    report = info.pop("attributes")
    assert info.pop("is_finished") and info == ran
    assert report["seed"] == 7 and report["scene_file"] == "flock.toml" and "rod_density = 2.0" in report["scene"]
    assert info["time"] == 100.0 and info["samples"] == 201 and info["results"]["polar_order"]["error"] > 0.0
    # As text: the same tables, after the provenance.
    text = drover(tmp_path, "info", "flock.h5", "--scene").stdout
    again = drover(tmp_path, "run", "flock.toml", "--overwrite").stdout
    assert again.rpartition("\n\n")[0].strip() in text and "\n[relaxation]\nrate = 0.5\n" in text
    assert re.search(r"^polar_order +1 +\S+ +\S+ +\S+ +exact$", text, re.M)  # every term is linear
    assert "nan" not in text


def test_results_go_to_stdout_and_the_log_to_stderr(tmp_path):
    write_scene(tmp_path, base=BRIEF)
    ended = drover(tmp_path, "run", "flock.toml")
    assert all(line.startswith("drover: ") for line in ended.stderr.splitlines())
    assert "20 steps of dt = 0.1 s" in ended.stderr
    assert "drover: " not in ended.stdout and ended.stdout.startswith("t = 0 to 2 s")
    quiet = drover(tmp_path, "run", "flock.toml", "--overwrite", "--quiet")
    assert quiet.stderr == ""
    assert quiet.stdout.splitlines()[:-1] == ended.stdout.splitlines()[:-1]  # the last line has the wall time
    json.loads(drover(tmp_path, "run", "flock.toml", "--overwrite", "--json").stdout)


def test_messages_have_the_unit_of_time_of_the_scene(tmp_path):
    (tmp_path / "front.toml").write_text("""
units = {time = "h"}
model = {name = "front"}
field = [{symbol = "h", name = "heat", reference = 1.0}]
grid = {nx = 8, ny = 8, lx = 1.0, ly = 1.0}
time = {dt = 0.1, end = 2.0}
initial = {kind = "formula", heat = "1 + 0.3 cos(2 pi x)"}
output = {frame_every = 1.0, sample_every = 0.5}
equations = {h = "lap h + h - h^3"}
""")
    said = drover(tmp_path, "run", "front.toml").stderr
    assert "steps of dt = 0.1 h" in said and re.search(r"fluctuation at t = \S+ h \(step_error\)", said)
    assert not re.search(r"= [\d.]+ s\b", said)


def test_results_that_cannot_be_written_are_a_failure(tmp_path):
    write_scene(tmp_path, base=BRIEF)
    for words in (["schema"], ["check", "flock.toml", "--resolved"], ["run", "flock.toml", "--quiet"]):
        with open("/dev/full", "w", encoding="utf-8") as full:
            ended = subprocess.run([DROVER, *words], cwd=tmp_path, stdout=full, stderr=subprocess.PIPE,
                                   env=environment(), check=False)
        assert ended.returncode == 1 and ended.stderr.startswith(b"error: "), words


def on_a_terminal(folder, env, *words):
    """Standard error of a command, when that is a terminal."""
    ours, theirs = pty.openpty()
    ended = subprocess.run([DROVER, *words], cwd=folder, stdout=subprocess.DEVNULL, stderr=theirs, env=env, check=False)
    os.close(theirs)
    written = b""
    try:
        while part := os.read(ours, 65536):
            written += part
    except OSError:  # the other end of the terminal is closed
        pass
    os.close(ours)
    assert ended.returncode == 0, written
    return written.decode()


def test_colour_only_on_a_terminal_and_not_with_no_color(tmp_path):
    write_scene(tmp_path, base=BRIEF)
    words = ["run", "flock.toml", "--overwrite"]
    # On a terminal an escape erases the line of progress; colour codes end in m.
    assert re.search("\x1b\\[[0-9;]*m", on_a_terminal(tmp_path, environment(TERM="xterm-256color"), *words))
    assert not re.search("\x1b\\[[0-9;]*m", on_a_terminal(tmp_path, environment(TERM="xterm-256color", NO_COLOR="1"),
                                                          *words))
    assert "\x1b" not in drover(tmp_path, *words).stderr


def test_overwriting_removes_the_earlier_run(tmp_path):
    write_scene(tmp_path, base=BRIEF)
    drover(tmp_path, "run", "flock.toml", "--quiet", "--set", "time.end=8.0", "--set", "output.checkpoint_minutes=0")
    drover(tmp_path, "run", "flock.toml", "--quiet", "--overwrite", "--set", "run.seed=9")
    drover(tmp_path, "restart", "flock.h5", "--quiet", "--set", "time.end=4.0")
    drover(tmp_path, "run", "flock.toml", "--quiet", "-o", "new.h5", "--set", "run.seed=9", "--set", "time.end=4.0")
    assert_same_bytes(tmp_path / "new.h5", tmp_path / "flock.h5")


def test_an_archive_is_written_to_the_working_folder_or_to_the_given_path(tmp_path):
    (tmp_path / "scenes").mkdir()
    write_scene(tmp_path / "scenes", base=BRIEF)
    drover(tmp_path, "run", "scenes/flock.toml", "--quiet")
    drover(tmp_path, "run", "scenes/flock.toml", "--quiet", "-o", "scenes/here.nc")
    assert_same_bytes(tmp_path / "flock.h5", tmp_path / "scenes" / "here.nc")


@pytest.mark.parametrize("frame", [-1, 0, 1])
def test_a_start_from_an_archive_beside_the_scene_is_its_frame(frame, tmp_path):
    (tmp_path / "scenes").mkdir()
    write_scene(tmp_path / "scenes", base=BRIEF)
    drover(tmp_path, "run", "scenes/flock.toml", "--quiet", "-o", "scenes/first.h5")
    write_scene(tmp_path / "scenes", {**BRIEF, "initial.kind": "file", "initial.file": "first.h5",
                                      "initial.frame": frame}, "next.toml")
    drover(tmp_path, "run", "scenes/next.toml", "--quiet")
    with h5py.File(tmp_path / "scenes" / "first.h5") as first, h5py.File(tmp_path / "next.h5") as following:
        for name in ("rod_density", "polar_order_x", "polar_order_y"):
            # A transform there and back costs some roundings of numbers of order one.
            assert np.abs(first[name][frame] - following[name][0]).max() < 1e-12


GROWING = {"relaxation.rate": -50.0, "grid.nx": 16, "grid.ny": 16, "time.dt": 0.1, "time.end": 100.0,
           "initial.kind": "random", "initial.amplitude": 0.1, "output.frame_every": 0.1, "output.sample_every": 0.1}


def test_a_diverging_run_stops_reports_where_and_keeps_its_valid_frames(tmp_path):
    (tmp_path / "flock.toml").write_text(scene_text(GROWING))
    ended = drover(tmp_path, "run", "flock.toml", "--quiet", status=1)
    assert len(ended.stderr.splitlines()) == 1 and ended.stderr.startswith("error: ") and ended.stdout == ""
    report = re.search(r"the run diverged at or before step (\d+) \(t = (\S+) s\): the root mean square of (\w+) is "
                     r"(\S+) mm-2; expected at most 1e\+06 times its size in this model, 1; its largest value is (\S+) "
                     r"in cell \((\d+), (\d+)\), dt = 0.1; likely cause: (.*)", ended.stderr)
    assert report, ended.stderr
    with h5py.File(tmp_path / "flock.h5") as file:
        order = [file[f"polar_order_{axis}"][()] for axis in "xy"]
        frames = len(file["time"])
        for name in ("rod_density", "polar_order_x", "polar_order_y", "observables/polar_order_mean_x"):
            assert np.isfinite(file[name][()]).all(), name
    # Order grows by e^5 a step: one of its components exceeds 1e6 times the rod density, 1, at this step.
    first = min(math.ceil(math.log(1e6 / math.sqrt(np.mean(part[0]**2))) / 5.0) for part in order)
    assert int(report[1]) == first
    assert float(report[2]) == pytest.approx(0.1 * first, rel=1e-5)  # six digits are printed
    # Frames are committed when a step fails: all before that are there.
    assert frames == first
    assert report[3] in ("polar_order_x", "polar_order_y") and 1e6 < float(report[4]) < abs(float(report[5]))
    assert max(int(report[6]), int(report[7])) < 16
    assert "grows at 50 /s" in report[8] and "checkpoint" in report[8]


def test_the_last_checkpoint_before_a_divergence_restarts(tmp_path):
    (tmp_path / "flock.toml").write_text(scene_text({**GROWING, "output.checkpoint_minutes": 0.0}))
    drover(tmp_path, "run", "flock.toml", "--quiet", status=1)
    assert all(file.exists() for file in checkpoints(tmp_path / "flock.h5"))
    # It fails again with the same message, unless it ends before.
    again = drover(tmp_path, "restart", "flock.h5", "--quiet", status=1)
    assert "the run diverged" in again.stderr
    good = max(checkpoint_step(file) for file in checkpoints(tmp_path / "flock.h5"))
    assert good >= 2  # a checkpoint at each step: the last one is just before, near step 4
    earlier = f"time.end={good / 10}"
    drover(tmp_path, "restart", "flock.h5", "--quiet", "--set", earlier)
    drover(tmp_path, "run", "flock.toml", "--quiet", "-o", "short.h5", "--set", earlier)
    assert_same_bytes(tmp_path / "short.h5", tmp_path / "flock.h5")


def test_a_warm_up_that_does_not_fit_is_found_from_the_series_with_a_warning(tmp_path):
    scene = write_scene(tmp_path, {**SMALL, "time.end": 20.0, "analysis.warm_up": 50.0})
    told = drover_json(tmp_path, "run", scene, "-q", "-o", "long.h5")
    found = drover_json(tmp_path, "run", scene, "-q", "-o", "found.h5", "--set", "analysis.warm_up=-1")
    warning, = (words for words in told["warnings"] if "analysis.warm_up" in words)
    assert "= 50 is not shorter than the run, time.end = 20" in warning
    assert told["results"] == found["results"] and told["warm_up_samples"] == found["warm_up_samples"]
    assert not any("analysis.warm_up" in words for words in found["warnings"])


def test_a_mean_that_is_zero_up_to_rounding_is_printed_as_zero(tmp_path):
    # The mean is 0 by reflection of y, and the sums over points have rounding.
    words = ["run", MODELS / "band.toml", *settings(["time.end=1", "analysis.warm_up=0", 'output.file="band.h5"',
                                                     'initial.polar_order_y="0.01 * sin(pi * y / 4)"'])]
    table = drover(tmp_path, *words, "-q").stdout
    row = next(line.split() for line in table.splitlines() if line.startswith("polar_order_mean_y"))
    # No error bar, no autocorrelation time and no bias by the step: its series is rounding.
    assert row[2:] == ["0", "0", "-", "-"]
    exact = drover_json(tmp_path, *words, "-q", "--overwrite")["results"]["polar_order_mean_y"]["mean"]
    assert 0.0 < abs(exact) < 1e-14
