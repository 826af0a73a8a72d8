"""tests/app/test_bad_input.py: every mistake of a person is told in one sentence that says where, what and what to do.

Exit status 2, one line on standard error, nothing on standard output, and the folder stays as it was.
"""
import os
import re
import subprocess

import h5py
import numpy as np
import pytest
from support import DROVER, SMALL, checkpoints, damage, drover, environment, scene_text, tree, write_scene

# What tells a person how to go on.
REMEDY = re.compile(r"expected|did you mean|choose|give |make |name |check |start |see |smaller|--help")
SHORT = {**SMALL, "time.end": 1.0, "output.frame_every": 0.5, "output.sample_every": 0.5}
AS_ROOT = os.geteuid() == 0
not_as_root = pytest.mark.skipif(AS_ROOT, reason="root may read and write everything")


def refused(folder, words, says, lines_most=1, stdin=subprocess.DEVNULL):
    """Runs a command that must be refused as bad input, with all of `says` in the one sentence it gives."""
    before = tree(folder)
    ended = subprocess.run([DROVER, *map(str, words)], cwd=folder, capture_output=True, text=True, errors="replace",
                           stdin=stdin, timeout=60, env=environment(), check=False)
    report = f"drover {' '.join(map(str, words))}: {ended.returncode}\n{ended.stderr}{ended.stdout}"
    lines = ended.stderr.splitlines()
    assert ended.returncode == 2, report
    assert ended.stdout == "", report
    assert 1 <= len(lines) <= lines_most, report
    assert lines[0].startswith("error: "), report
    assert REMEDY.search(ended.stderr), report
    assert len(ended.stderr) < 1000, report
    assert [part for part in says if part not in ended.stderr] == [], report
    assert tree(folder) == before, report


# A scene that is wrong by itself: its text, and what the message must contain, the place first.
SCENES = {
    "an unknown table": ("[grids]\nnx = 16\n", ["bad.toml:1:2", "[grids]", "did you mean [grid]?"]),
    "an unknown table like no other": ("[banana]\nnx = 16\n", ["bad.toml:1:2", "[banana]", "uniform, current, relaxation"]),
    "an unknown key": ("[grid]\nny = 16\nnxx = 16\n", ["bad.toml:3:1", "grid.nxx", "did you mean grid.nx?"]),
    "an unknown key like no other": ("[grid]\ntemperature = 3\n", ["bad.toml:2:1", "grid.temperature", "nx, ny, lx, ly"]),
    "a key of another table": ("[time]\nnx = 16\n", ["bad.toml:2:1", "time.nx"]),
    "a key outside a table": ("nx = 16\n[grid]\nny = 16\n", ["bad.toml:1:1", "nx stands outside a table", "[grid]"]),
    "a text for an integer": ("[grid]\nnx = \"many\"\n", ["bad.toml:2:1", 'grid.nx = "many"', "an integer"]),
    "a number for an integer": ("[grid]\nnx = 16.5\n", ["bad.toml:2:1", "grid.nx = 16.5", "an integer"]),
    "a list for an integer": ("[grid]\nnx = [16]\n", ["bad.toml:2:1", "grid.nx = [16", "an integer"]),
    "true for an integer": ("[grid]\nnx = true\n", ["bad.toml:2:1", "grid.nx = true", "an integer"]),
    "a text for a number": ("[relaxation]\nrate = \"1.0\"\n", ["bad.toml:2:1", 'relaxation.rate = "1.0"', "a number"]),
    "true for a number": ("[relaxation]\nrate = true\n", ["bad.toml:2:1", "relaxation.rate = true", "a number"]),
    "a list for a number": ("[relaxation]\nrate = [1.0]\n", ["bad.toml:2:1", "relaxation.rate = [1.0]", "a number"]),
    "a number for a text": ("[output]\nfile = 4\n", ["bad.toml:2:1", "output.file = 4", "a text in quotes"]),
    "a number for a word": ("[time]\nstepper = 4\n", ["bad.toml:2:1", "time.stepper = 4", "etdrk2"]),
    "a text for a list of texts": ("[sweep]\nvary = \"relaxation.rate = 1, 2\"\n", ["bad.toml:2:1", "a list of texts"]),
    "numbers for a list of texts": ("[sweep]\nvary = [1, 2]\n", ["bad.toml:2:1", "sweep.vary = [1.0, 2.0]", "a list of texts"]),
    "a mixed list": ("[sweep]\nvary = [\"relaxation.rate = 1\", 2]\n", ["bad.toml:2:1", "sweep.vary", "one kind"]),
    "a list with true in it": ("[sweep]\nvary = [true]\n", ["bad.toml:2:1", "sweep.vary", "expected"]),
    "a list of lists": ("[sweep]\nvary = [[\"relaxation.rate = 1\"]]\n", ["bad.toml:2:1", "sweep.vary", "expected"]),
    "a table in a table": ("[grid.nx]\npoints = 16\n", ["bad.toml:1", "grid.nx", "is a table"]),
    "an inline table": ("[grid]\nnx = {points = 16}\n", ["bad.toml:2:1", "grid.nx", "is a table"]),
    "a table given as a list": ("[[grid]]\nnx = 16\n", ["bad.toml:1", "grid"]),
    "a date": ("[time]\nend = 2024-01-01\n", ["bad.toml:2:1", "time.end", "date", "a number"]),
    "an unknown word": ("[time]\nstepper = \"etdrk3\"\n", ["bad.toml:2:1", '"etdrk3"', "exponential-euler", 'did you mean "etdrk']),
    "a grid too small": ("[grid]\nnx = 2\n", ["bad.toml:2:1", "grid.nx = 2", ">= 4"]),
    "a grid of nothing": ("[grid]\nny = 0\n", ["bad.toml:2:1", "grid.ny = 0", ">= 4"]),
    "a negative grid": ("[grid]\nny = -16\n", ["bad.toml:2:1", "grid.ny = -16", ">= 4"]),
    "an odd grid": ("[grid]\nnx = 16\nny = 17\n", ["bad.toml:3:1", "grid.ny = 17", "even"]),
    "a grid too large": ("[grid]\nnx = 65538\n", ["bad.toml:2:1", "grid.nx = 65538", "65536"]),
    "an integer beyond 64 bits": ("[grid]\nnx = 99999999999999999999\n", ["bad.toml:2", "expected"]),
    "more than this machine's memory": (
        "[grid]\nnx = 65536\nny = 65536\n", ["bad.toml:2:1", "65536 by 65536", "of memory", "are free", "smaller"]),
    "a box of no width": ("[grid]\nlx = 0.0\n", ["bad.toml:2:1", "grid.lx = 0.0", "> 0", "[mm]"]),
    "a negative box": ("[grid]\nly = -64\n", ["bad.toml:2:1", "grid.ly = -64", "> 0", "[mm]"]),
    "a box that is not a number": ("[grid]\nly = nan\n", ["bad.toml:2:1", "grid.ly = nan", "> 0"]),
    "an endless box": ("[grid]\nlx = inf\n", ["bad.toml:2:1", "grid.lx = inf", "> 0"]),
    "no rods": ("[uniform]\nrod_density = 0\n", ["bad.toml:2:1", "uniform.rod_density = 0", "> 0"]),
    "negative noise": ("[noise]\norder = -0.1\n", ["bad.toml:2:1", "noise.order = -0.1", ">= 0"]),
    "negative noise of the rods": ("[noise]\nrods = -1e-9\n", ["bad.toml:2:1", "noise.rods = -1e-09", ">= 0"]),
    "negative stiffness": ("[elasticity]\nsplay = -1\n", ["bad.toml:2:1", "elasticity.splay = -1", ">= 0"]),
    "an infinite rate": ("[relaxation]\nrate = -inf\n", ["bad.toml:2:1", "relaxation.rate = -inf", "a number"]),
    "a step of no length": ("[time]\ndt = 0\n", ["bad.toml:2:1", "time.dt = 0", "> 0"]),
    "a step back in time": ("[time]\ndt = -0.1\n", ["bad.toml:2:1", "time.dt = -0.1", "> 0"]),
    "a step that is not a number": ("[time]\ndt = nan\n", ["bad.toml:2:1", "time.dt = nan", "> 0"]),
    "an end between two steps": (
        "[time]\ndt = 0.1\nend = 0.25\n", ["bad.toml:3:1", "time.end = 0.25", "whole number of steps", "time.dt = 0.1", "choose 0.2 or 0.3"]),
    "an end at the start": ("[time]\nend = 0\n", ["bad.toml:2:1", "time.end = 0", "> 0"]),
    "an end before the first step": ("[time]\ndt = 1e3\nend = 1e-4\n", ["bad.toml:3:1", "time.end", "step", "time.dt"]),
    "an end that never comes": ("[time]\nend = inf\n", ["bad.toml:2:1", "time.end = inf"]),
    "more steps than anyone has time for": ("[time]\ndt = 1e-15\nend = 10.0\n", ["bad.toml:3:1", "steps", "at most"]),
    "samples between steps": (
        "[time]\ndt = 0.1\nend = 1.0\n[output]\nsample_every = 0.15\n", ["bad.toml:5:1", "output.sample_every = 0.15", "whole number of steps"]),
    "frames between steps": (
        "[time]\ndt = 0.1\nend = 1.0\n[output]\nframe_every = 0.25\n", ["bad.toml:5:1", "output.frame_every = 0.25", "whole number of steps"]),
    "samples closer than steps": ("[output]\nsample_every = 1e-9\n", ["bad.toml:2:1", "output.sample_every = 1e-09", "step"]),
    "frames before the start": ("[output]\nframe_every = -1\n", ["bad.toml:2:1", "output.frame_every = -1", ">= 0"]),
    "checkpoints before the start": ("[output]\ncheckpoint_minutes = -5\n", ["bad.toml:2:1", "checkpoint_minutes = -5", ">= 0"]),
    "a warm-up beyond the end": ("[time]\nend = 1\n[analysis]\nwarm_up = 2\n", ["bad.toml:4:1", "analysis.warm_up = 2", "time.end = 1"]),
    "a warm-up of less than nothing": ("[analysis]\nwarm_up = -0.5\n", ["bad.toml:2:1", "analysis.warm_up = -0.5", "-1"]),
    "an unknown start": ("[initial]\nkind = \"modes\"\n", ["bad.toml:2:1", '"modes"', 'did you mean "mode"?']),
    "an unknown field": (
        "[initial]\nkind = \"mode\"\nfield = \"order\"\n", ["bad.toml:3:1", '"order"', "rod_density, polar_order_x, polar_order_y"]),
    "a mode beyond the grid": (
        "[grid]\nnx = 16\n[initial]\nkind = \"mode\"\nmode_x = 8\n", ["bad.toml:5:1", "initial.mode_x = 8", "less than 8"]),
    "a mode beyond the grid, the other way": (
        "[grid]\nny = 16\n[initial]\nkind = \"mode\"\nmode_y = -8\n", ["bad.toml:5:1", "initial.mode_y = -8", "less than 8"]),
    "a mode beyond 32 bits": ("[initial]\nkind = \"mode\"\nmode_x = 2147483648\n", ["bad.toml:3:1", "initial.mode_x = 2147483648"]),
    "a mode at the end of 32 bits": (
        "[initial]\nkind = \"mode\"\nmode_x = -2147483648\n", ["bad.toml:3:1", "initial.mode_x = -2147483648", "less than 128"]),
    "a mode of negative amplitude": (
        "[initial]\nkind = \"mode\"\namplitude = -1\n", ["bad.toml:3:1", "initial.amplitude = -1", ">= 0"]),
    "a stationary start without noise": (
        "[initial]\nkind = \"stationary\"\n", ["bad.toml:2:1", "stationary", "noise.order = 0", "give noise.order > 0"]),
    "a stationary start of a model without a stationary state": (
        "[relaxation]\nrate = -1\n[noise]\norder = 1\n[diffusion]\ndiffusivity = 1\n[initial]\nkind = \"stationary\"\n",
        ["bad.toml:8:1", "stationary", "grows"]),
    "a start from no file": ("[initial]\nkind = \"file\"\n", ["bad.toml:2:1", "initial.file", "name the archive"]),
    "a start from a missing file": (
        "[initial]\nkind = \"file\"\nfile = \"lost.h5\"\n", ["bad.toml:3:1", "lost.h5", "does not exist"]),
    "a negative frame": ("[initial]\nframe = -2\n", ["bad.toml:2:1", "initial.frame = -2", ">= -1"]),
    "a negative seed": ("[run]\nseed = -1\n", ["bad.toml:2:1", "run.seed = -1", ">= 0"]),
    "too many threads": ("[run]\nthreads = 5000\n", ["bad.toml:2:1", "run.threads = 5000", "1024"]),
    "negative threads": ("[run]\nthreads = -1\n", ["bad.toml:2:1", "run.threads = -1", ">= 0"]),
    "no seeds": ("[sweep]\nseeds = 0\n", ["bad.toml:2:1", "sweep.seeds = 0", ">= 1"]),
    "an unknown ramp": ("[sweep]\nramp = \"down\"\n", ["bad.toml:2:1", '"down"', "none", "up-down"]),
    "a key twice": ("[grid]\nnx = 16\nnx = 32\n", ["bad.toml:3", "nx", "not TOML"]),
    "a table twice": ("[grid]\nnx = 16\n[grid]\nny = 32\n", ["bad.toml:3", "grid", "not TOML"]),
    "a value that is missing": ("[grid]\nnx =\n", ["bad.toml:2", "not TOML"]),
    "an open quote": ("[initial]\nkind = \"mode\n", ["bad.toml:2", "not TOML"]),
    "an open bracket": ("[grid\nnx = 16\n", ["bad.toml:1", "not TOML"]),
    "a line of prose": ("[grid]\nnx is sixteen\n", ["bad.toml:2", "not TOML"]),
    "an output in a missing folder": ("[output]\nfile = \"there/flock.h5\"\n", ["bad.toml:2:1", "there", "make it first"]),
    "a folder as output": ("[output]\nfile = \".\"\n", ["bad.toml:2:1", "is a folder", "name of a file"]),
}


SEEN_BY_A_RUN_ALONE = ("a start from a missing file", "a stationary start of a model without a stationary state")


@pytest.mark.parametrize("command", ["run", "check"])
@pytest.mark.parametrize("name", SCENES)
def test_a_scene_is_refused_that_has(name, command, tmp_path):
    text, says = SCENES[name]
    if command == "check" and name in SEEN_BY_A_RUN_ALONE:
        pytest.skip("check opens no other file and draws no state")
    (tmp_path / "bad.toml").write_text(text)
    refused(tmp_path, [command, "bad.toml"], says)


@pytest.mark.parametrize("command", ["explain", "sweep"])
@pytest.mark.parametrize("name", ["an unknown key", "an end between two steps", "a key twice", "a mode beyond the grid"])
def test_every_command_refuses_in_the_same_words(name, command, tmp_path):
    text, says = SCENES[name]
    (tmp_path / "bad.toml").write_text(text)
    refused(tmp_path, [command, "bad.toml"], says)


def make_archive(folder, name, changes=None):
    """Runs a short scene beside the folder and puts its archive, without checkpoints, into it."""
    beside = folder.parent / (folder.name + "-made")
    beside.mkdir(exist_ok=True)
    write_scene(beside, changes, base=SHORT)
    drover(beside, "run", "flock.toml", "--quiet", "--overwrite", "-o", name)
    (folder / name).write_bytes((beside / name).read_bytes())
    return beside


def start_from(frame=-1):
    return {"initial.kind": "file", "initial.file": "first.h5", "initial.frame": frame}


def cut_short(folder):
    make_archive(folder, "first.h5")
    content = (folder / "first.h5").read_bytes()
    (folder / "first.h5").write_bytes(content[:len(content) // 3])


def other_fields(folder):
    with h5py.File(folder / "first.h5", "w") as file:
        file["time"] = np.zeros(1)
        file["x"] = file["y"] = np.arange(16.0)
        file["rod_density"] = np.zeros((1, 16, 16))


def not_finite(folder):
    make_archive(folder, "first.h5")
    with h5py.File(folder / "first.h5", "r+") as file:
        file["polar_order_x"][-1, 3, 4] = np.nan


# A start from an archive that cannot be: how to make it, changes of the scene, and what the message must contain.
STARTS = {
    "no HDF5": (lambda folder: (folder / "first.h5").write_text("rods\n" * 999), {}, ["first.h5", "not an HDF5 file"]),
    "a folder": (lambda folder: (folder / "first.h5").mkdir(), {}, ["first.h5", "folder"]),
    "cut short": (cut_short, {}, ["first.h5"]),
    "empty": (lambda folder: (folder / "first.h5").write_bytes(b""), {}, ["first.h5", "not an HDF5 file"]),
    "without the fields": (other_fields, {}, ["flock.toml:43:1", "first.h5", "polar_order_x"]),
    "of another grid": (lambda folder: make_archive(folder, "first.h5", {"grid.nx": 32}), {},
                        ["flock.toml:43:1", "first.h5", "16 by 16"]),
    "of another cell": (lambda folder: make_archive(folder, "first.h5", {"grid.lx": 32.0}), {}, ["first.h5", "cell"]),
    "of fewer frames": (lambda folder: make_archive(folder, "first.h5"), start_from(3), ["flock.toml:44:1", "initial.frame = 3", "0 to 2"]),
    "with a value that is not a number": (not_finite, {}, ["first.h5", "polar_order_x"]),
}


@pytest.mark.parametrize("name", STARTS)
def test_a_start_from_an_archive_is_refused_that_is(name, tmp_path):
    prepare, changes, says = STARTS[name]
    prepare(tmp_path)
    text = scene_text({**{key: SHORT[key] for key in SHORT if key != "initial.kind"}, **start_from(), **changes})
    (tmp_path / "flock.toml").write_text(text)
    refused(tmp_path, ["run", "flock.toml"], says)


# A file that is no scene.
def garbage(folder):
    (folder / "bad.toml").write_bytes(np.random.default_rng(1).bytes(5000))


def with_nul(folder):
    (folder / "bad.toml").write_bytes(b"[grid]\nnx = \x0016\n")


def not_utf8(folder):
    (folder / "bad.toml").write_bytes(b"[output]\nfile = \"fl\xffock.h5\"\n")


def huge(folder):
    (folder / "bad.toml").write_text("# rods\n" * 200000)


FILES = {
    "is missing": (lambda folder: None, ["bad.toml", "no such file", "expected a scene"]),
    "is a folder": (lambda folder: (folder / "bad.toml").mkdir(), ["bad.toml", "not a file"]),
    "is a pipe": (lambda folder: os.mkfifo(folder / "bad.toml"), ["bad.toml", "not a file"]),
    "is binary": (garbage, ["bad.toml", "not TOML"]),
    "has a zero byte": (with_nul, ["bad.toml:2", "not TOML"]),
    "is not UTF-8": (not_utf8, ["bad.toml:2", "not TOML"]),
    "is huge": (huge, ["bad.toml", "1 MiB"]),
}


@pytest.mark.parametrize("name", FILES)
def test_a_scene_is_refused_that(name, tmp_path):
    prepare, says = FILES[name]
    prepare(tmp_path)
    for command in ("run", "check", "explain", "sweep"):
        refused(tmp_path, [command, "bad.toml"], says)


@not_as_root
def test_a_scene_is_refused_that_may_not_be_read(tmp_path):
    write_scene(tmp_path, base=SHORT)
    (tmp_path / "flock.toml").chmod(0)
    refused(tmp_path, ["run", "flock.toml"], ["flock.toml", "cannot be read", "check its permissions"])


def test_an_empty_scene_is_good_and_is_all_defaults(tmp_path):
    (tmp_path / "empty.toml").write_text("")
    assert drover(tmp_path, "check", "empty.toml").stdout == "empty.toml: good\n"
    (tmp_path / "again.toml").write_text(drover(tmp_path, "check", "empty.toml", "--resolved").stdout)
    again = drover(tmp_path, "check", "again.toml", "--resolved").stdout
    assert again == (tmp_path / "again.toml").read_text() and "nx = 256\n" in again


# A --set that is wrong: its text, and what the message must contain beside it.
SETTINGS = {
    "no value": ("grid.nx", ["expected section.key=value"]),
    "no section": ("nx=16", ["expected section.key=value"]),
    "no name": ("=16", ["expected section.key=value"]),
    "an empty section": (".nx=16", ["expected section.key=value"]),
    "an empty key": ("grid.=16", ["expected section.key=value"]),
    "a dot in the value alone": ("nx=1.5", ["expected section.key=value"]),
    "nothing": ("", ["expected section.key=value"]),
    "an empty value": ("grid.nx=", ["grid.nx = \"\"", "an integer"]),
    "a word for an integer": ("grid.nx=many", ['grid.nx = "many"', "an integer"]),
    "two values": ("grid.nx=16 32", ['grid.nx = "16 32"', "an integer"]),
    "two lines": ("grid.nx=16\nny = 32", ["grid.nx", "expected"]),
    "an unknown section": ("grids.nx=16", ["[grids]", "did you mean [grid]?"]),
    "an unknown key": ("grid.nxx=16", ["grid.nxx", "did you mean grid.nx?"]),
    "an odd grid": ("grid.nx=17", ["grid.nx = 17", "even"]),
    "a date": ("time.end=2024-01-01", ["time.end", "a number"]),
    "a table": ("time.end={a = 1}", ["time.end", "a number"]),
    "a number beyond all": ("time.end=1e999", ["time.end", "a number"]),
    "an end between steps": ("time.end=0.123456", ["time.end = 0.123456", "choose"]),
}


@pytest.mark.parametrize("name", SETTINGS)
def test_a_setting_is_refused_that_has(name, tmp_path):
    setting, says = SETTINGS[name]
    write_scene(tmp_path, base=SHORT)
    words = ["run", "flock.toml", "--set", setting]
    refused(tmp_path, words, [f"--set {setting}", *says], lines_most=1 + setting.count("\n"))  # it is quoted as it was given


# A wrong place for the archive: how to prepare the folder, the name, and what the message must contain.
def make_locked_folder(folder):
    (folder / "locked").mkdir(mode=0o555)


OUTPUTS = {
    "a file that exists": (lambda folder: make_archive(folder, "flock.h5"), "flock.h5", ["flock.h5", "exists", "--overwrite"]),
    "a file of someone else": (lambda folder: (folder / "notes").write_text("rods"), "notes", ["notes", "exists"]),
    "the scene itself": (lambda folder: None, "flock.toml", ["flock.toml"]),
    "a folder": (lambda folder: (folder / "out").mkdir(), "out", ["out", "is a folder"]),
    "a name that ends like a folder": (lambda folder: (folder / "out").mkdir(), "out/", ["out", "is a folder"]),
    "a missing folder": (lambda folder: None, "there/flock.h5", ["there", "no folder", "make it first"]),
    "a file as folder": (lambda folder: (folder / "notes").write_text("rods"), "notes/flock.h5", ["notes", "no folder"]),
    "a folder that takes no files": (lambda folder: None, "/proc/flock.h5", ["/proc/flock.h5", "cannot be written"]),
    "a device": (lambda folder: None, "/dev/null", ["/dev/null"]),
    "a name too long": (lambda folder: None, "f" * 300 + ".h5", ["fff.h5"]),
}


@pytest.mark.parametrize("name", OUTPUTS)
def test_an_output_is_refused_that_is(name, tmp_path):
    prepare, output, says = OUTPUTS[name]
    prepare(tmp_path)
    write_scene(tmp_path, base=SHORT)
    refused(tmp_path, ["run", "flock.toml", "-o", output], says)


@pytest.mark.parametrize("output", ["flock.toml", "/dev/null", "."])
def test_even_overwriting_does_not_replace(output, tmp_path):
    write_scene(tmp_path, base=SHORT)
    refused(tmp_path, ["run", "flock.toml", "--overwrite", "-o", output], [output])


@not_as_root
def test_an_output_is_refused_whose_folder_may_not_be_written(tmp_path):
    make_locked_folder(tmp_path)
    write_scene(tmp_path, base=SHORT)
    refused(tmp_path, ["run", "flock.toml", "-o", "locked/flock.h5"], ["locked/flock.h5", "Permission denied"])


# A sweep that cannot be planned: words after `sweep flock.toml`, and what the message must contain.
SWEEPS = {
    "nothing to sweep": ([], ["nothing to sweep", "--vary"]),
    "no values": (["--vary", "relaxation.rate"], ["relaxation.rate", "expected"]),
    "an empty list": (["--vary", "relaxation.rate = "], ["relaxation.rate", "at least one"]),
    "a hole in the list": (["--vary", "relaxation.rate = 1,,2"], ["relaxation.rate = 1,,2", "expected numbers"]),
    "a word": (["--vary", "relaxation.rate = 1, two"], ['"two"', "expected numbers"]),
    "not-a-number": (["--vary", "relaxation.rate = 1, nan"], ['"nan"', "expected numbers"]),
    "no section": (["--vary", "rate = 1, 2"], ["rate = 1, 2", "section.key"]),
    "an unknown key": (["--vary", "relaxation.rat = 1, 2"], ["relaxation.rat", "did you mean relaxation.rate?"]),
    "an unknown section": (["--vary", "relax.rate = 1, 2"], ["[relax]", "expected"]),
    "a range without count": (["--vary", "relaxation.rate = 1:2"], ["relaxation.rate = 1:2", "first:last:count"]),
    "a range of four": (["--vary", "relaxation.rate = 1:2:3:4"], ["1:2:3:4", "first:last:count"]),
    "a range of one": (["--vary", "relaxation.rate = 1:2:1"], ["1:2:1", "whole number"]),
    "a range of half a point": (["--vary", "relaxation.rate = 1:2:2.5"], ["1:2:2.5", "whole number"]),
    "a range of too many": (["--vary", "relaxation.rate = 1:2:1e9"], ["1:2:1e9", "whole number"]),
    "the same key twice": (["--vary", "relaxation.rate = 1", "--vary", "relaxation.rate = 2"], ["relaxation.rate twice"]),
    "a value that the scene refuses": (["--vary", "grid.nx = 16, 17"], ["grid.nx = 17", "even"]),
    "a value of the wrong type": (["--vary", "grid.nx = 16, 16.5"], ["grid.nx = 16.5", "an integer"]),
    "the seed, which has its own key": (["--vary", "run.seed = 1, 2"], ["run.seed", "sweep.seeds"]),
    "a ramp of two keys": (["--vary", "relaxation.rate = 1, 2", "--vary", "noise.order = 1, 2", "--ramp", "up"],
                           ["sweep.ramp", "2 varied keys", "exactly one"]),
    "a ramp of no key": (["--ramp", "up", "--seeds", "2"], ["sweep.ramp", "0 varied keys", "exactly one"]),
    "a ramp of the grid": (["--vary", "grid.nx = 16, 32", "--ramp", "up"], ["grid.nx", "ramp"]),
    "an unknown ramp": (["--vary", "relaxation.rate = 1, 2", "--ramp", "sideways"], ['"sideways"', "up-down"]),
    "a folder with other things in it": (["--vary", "relaxation.rate = 1, 2", "-o", "full"], ["full", "not empty", "--output"]),
    "a file as folder": (["--vary", "relaxation.rate = 1, 2", "-o", "full/notes"], ["full/notes", "folder"]),
}


@pytest.mark.parametrize("name", SWEEPS)
def test_a_sweep_is_refused_that_has(name, tmp_path):
    words, says = SWEEPS[name]
    (tmp_path / "full").mkdir()
    (tmp_path / "full" / "notes").write_text("rods")
    write_scene(tmp_path, base=SHORT)
    refused(tmp_path, ["sweep", "flock.toml", *words], says)


def test_a_sweep_is_refused_in_the_folder_of_another(tmp_path):
    write_scene(tmp_path, base=SHORT)
    drover(tmp_path, "sweep", "flock.toml", "--vary", "relaxation.rate = 1, 2", "--quiet")
    refused(tmp_path, ["sweep", "flock.toml", "--vary", "relaxation.rate = 1, 3"], ["flock.sweep", "another sweep", "--output"])


# A restart that cannot be: what to do to a finished run, words after `restart`, and what the message must contain.
def remove_checkpoints(folder):
    for file in checkpoints(folder / "flock.h5"):
        file.unlink(missing_ok=True)


def damage_checkpoints(folder):
    for file in checkpoints(folder / "flock.h5"):
        damage(file)


def cut_archive(folder):
    content = (folder / "flock.h5").read_bytes()
    (folder / "flock.h5").write_bytes(content[:len(content) // 2])


def archive_of_another_grid(folder):
    make_archive(folder, "flock.h5", {"grid.nx": 32})


RESTARTS = {
    "a missing file": (lambda folder: None, ["lost.h5"], ["lost.h5", "start the run anew"]),
    "the scene": (lambda folder: None, ["flock.toml"], ["flock.toml", "checkpoint"]),
    "a folder": (lambda folder: (folder / "out").mkdir(), ["out"], ["out"]),
    "an archive without checkpoints": (remove_checkpoints, ["flock.h5"], ["flock.h5", "no checkpoint", "checkpoint-a"]),
    "an archive with both checkpoints damaged": (
        damage_checkpoints, ["flock.h5"], ["flock.h5", "checkpoint-a", "checkpoint-b", "damaged", "start the run anew"]),
    "checkpoints without their archive": (lambda folder: (folder / "flock.h5").unlink(), ["flock.h5"], ["flock.h5", "does not exist"]),
    "an archive cut short": (cut_archive, ["flock.h5"], ["flock.h5"]),
    "an archive that is text": (lambda folder: (folder / "flock.h5").write_text("rods\n"), ["flock.h5"], ["flock.h5", "not an HDF5 file"]),
    "an archive of another grid": (archive_of_another_grid, ["flock.h5"], ["flock.h5", "expected"]),
    "another rate": (lambda folder: None, ["flock.h5", "--set", "relaxation.rate=2"],
                     ["--set relaxation.rate=2", "time.end, output.checkpoint_minutes and run.threads", "start a new run"]),
    "another seed": (lambda folder: None, ["flock.h5", "--set", "run.seed=2"], ["--set run.seed=2", "start a new run"]),
    "an end that is past": (lambda folder: None, ["flock.h5", "--set", "time.end=0.5"], ["flock.h5", "beyond time.end = 0.5", "give a later end"]),
    "an end between steps": (lambda folder: None, ["flock.h5", "--set", "time.end=1.23"], ["time.end = 1.23", "choose"]),
    "a word as end": (lambda folder: None, ["flock.h5", "--set", "time.end=late"], ["--set time.end=late", "a number"]),
}


@pytest.mark.parametrize("name", RESTARTS)
def test_a_restart_is_refused_that_has(name, tmp_path):
    prepare, words, says = RESTARTS[name]
    write_scene(tmp_path, base=SHORT)
    drover(tmp_path, "run", "flock.toml", "--quiet", "--set", "output.checkpoint_minutes=0")
    prepare(tmp_path)
    refused(tmp_path, ["restart", *words], says)


# What is no archive for `drover info`: how to make it, and what the message must contain.
def hdf5_from_elsewhere(folder):
    with h5py.File(folder / "flock.h5", "w") as file:
        file["time"] = np.arange(3.0)


def archive_without_samples(folder):
    make_archive(folder, "flock.h5")
    with h5py.File(folder / "flock.h5", "r+") as file:
        del file["observables"]


def archive_with_another_scene(folder):
    make_archive(folder, "flock.h5")
    with h5py.File(folder / "flock.h5", "r+") as file:
        file.attrs["scene"] = np.bytes_("[grid]\nnx = 17\n")


ARCHIVES = {
    "missing": (lambda folder: None, ["flock.h5", "does not exist"]),
    "a text": (lambda folder: (folder / "flock.h5").write_text("rods\n"), ["flock.h5", "not an HDF5 file"]),
    "a folder": (lambda folder: (folder / "flock.h5").mkdir(), ["flock.h5", "is a folder"]),
    "from elsewhere": (hdf5_from_elsewhere, ["flock.h5", "no attribute", "an archive of drover"]),
    "cut short": (lambda folder: (make_archive(folder, "flock.h5"), cut_archive(folder)), ["flock.h5"]),
    "without samples": (archive_without_samples, ["flock.h5", "/observables/time"]),
    "one with a scene that is wrong": (archive_with_another_scene, ["grid.nx = 17", "even"]),
}


@pytest.mark.parametrize("name", ARCHIVES)
def test_info_refuses_what_is(name, tmp_path):
    prepare, says = ARCHIVES[name]
    prepare(tmp_path)
    for words in (["info", "flock.h5"], ["info", "flock.h5", "--json"]):
        refused(tmp_path, words, says)


# A command line that is wrong: CLI11 tells it, and where help is.
COMMANDS = {
    "no command": ([], ["subcommand"]),
    "an unknown command": (["simulate", "flock.toml"], ["simulate"]),
    "a command misspelt": (["restrat", "flock.h5"], ["restrat"]),
    "no scene": (["run"], ["scene"]),
    "two scenes": (["run", "flock.toml", "flock.toml"], ["flock.toml"]),
    "an unknown option": (["run", "flock.toml", "--colour"], ["--colour"]),
    "an option without its value": (["run", "flock.toml", "--output"], ["--output"]),
    "no threads": (["run", "flock.toml", "--threads", "0"], ["--threads"]),
    "a word for threads": (["run", "flock.toml", "--threads", "all"], ["--threads", "all"]),
    "no seeds": (["sweep", "flock.toml", "--seeds", "0"], ["--seeds"]),
    "negative workers": (["sweep", "flock.toml", "--workers", "-1"], ["--workers"]),
    "no archive": (["info"], ["archive"]),
    "two commands": (["check", "run"], ["run"]),
}


@pytest.mark.parametrize("name", COMMANDS)
def test_a_command_line_is_refused_that_has(name, tmp_path):
    words, says = COMMANDS[name]
    write_scene(tmp_path, base=SHORT)
    refused(tmp_path, words, says, lines_most=2)
    assert len(drover(tmp_path, *words, status=2).stderr) < 300  # CLI11 would print the largest double in full
