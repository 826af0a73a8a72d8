"""tests/app/test_bad_input.py: every input error is reported in one line: place, value, remedy.

Exit status 2, one line on standard error, nothing on standard output, and the folder is unchanged.
"""
import os

import h5py
import numpy as np
import pytest
from rejection import SHORT, cut_in_two, make_archive, not_as_root, rejected
from support import drover, scene_text, write_scene

# An invalid scene: its text, and what the message must contain, the place first.
SCENES = {
    "an unknown table": ("[grids]\nnx = 16\n", ["bad.toml:1:2", "[grids]", "did you mean [grid]?"]),
    "an unknown table like no other": ("[banana]\nnx = 16\n",
                                       ["bad.toml:1:2", "[banana]", "fields, uniform, current, inertia"]),
    "an unknown key": ("[grid]\nny = 16\nnxx = 16\n", ["bad.toml:3:1", "grid.nxx", "did you mean grid.nx?"]),
    "an unknown key like no other": ("[grid]\ntemperature = 3\n",
                                     ["bad.toml:2:1", "grid.temperature", "nx, ny, lx, ly"]),
    "a key of another table": ("[time]\nnx = 16\n", ["bad.toml:2:1", "time.nx"]),
    "an equation in a list of its own": ('[[equation]]\nfield = "a"\n', ["bad.toml:1:3", "[[field]]", "[equations]"]),
    "an equation in its field": ('[[field]]\nsymbol = "a"\nequation = "-a"\n', ["bad.toml:3:1", "[equations]"]),
    "a key outside a table": ("nx = 16\n[grid]\nny = 16\n", ["bad.toml:1:1", "nx is outside a table", "[grid]"]),
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
    "numbers for a list of texts": ("[sweep]\nvary = [1, 2]\n",
                                    ["bad.toml:2:1", "sweep.vary = [1.0, 2.0]", "a list of texts"]),
    "a mixed list": ("[sweep]\nvary = [\"relaxation.rate = 1\", 2]\n", ["bad.toml:2:1", "sweep.vary", "one type"]),
    "a list with true in it": ("[sweep]\nvary = [true]\n", ["bad.toml:2:1", "sweep.vary", "expected"]),
    "a list of lists": ("[sweep]\nvary = [[\"relaxation.rate = 1\"]]\n", ["bad.toml:2:1", "sweep.vary", "expected"]),
    "a table in a table": ("[grid.nx]\npoints = 16\n", ["bad.toml:1", "grid.nx", "is a table"]),
    "an inline table": ("[grid]\nnx = {points = 16}\n", ["bad.toml:2:1", "grid.nx", "is a table"]),
    "a table given as a list": ("[[grid]]\nnx = 16\n", ["bad.toml:1", "grid"]),
    "a date": ("[time]\nend = 2024-01-01\n", ["bad.toml:2:1", "time.end", "date", "a number"]),
    "an unknown word": ("[time]\nstepper = \"etdrk5\"\n",
                        ["bad.toml:2:1", '"etdrk5"', "exponential-euler", 'did you mean "etdrk']),
    "a grid too small": ("[grid]\nnx = 2\n", ["bad.toml:2:1", "grid.nx = 2", ">= 4"]),
    "a grid of nothing": ("[grid]\nny = 0\n", ["bad.toml:2:1", "grid.ny = 0", ">= 1"]),
    "a negative grid": ("[grid]\nny = -16\n", ["bad.toml:2:1", "grid.ny = -16", ">= 1"]),
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
    "a step back in time": ("[time]\ndt = -0.1\n", ["bad.toml:2:1", "time.dt = -0.1", ">= 0"]),
    "a step that is not a number": ("[time]\ndt = nan\n", ["bad.toml:2:1", "time.dt = nan", ">= 0"]),
    "an end between two steps": (
        "[time]\ndt = 0.1\nend = 0.25\n", ["bad.toml:3:1", "time.end = 0.25", "whole number of steps", "time.dt = 0.1",
                                           "choose 0.2 or 0.3"]),
    "an end at the start": ("[time]\nend = 0\n", ["bad.toml:2:1", "time.end = 0", "> 0"]),
    "an end before the first step": ("[time]\ndt = 1e3\nend = 1e-4\n", ["bad.toml:3:1", "time.end", "step", "time.dt"]),
    "an end that never comes": ("[time]\nend = inf\n", ["bad.toml:2:1", "time.end = inf"]),
    "more steps than anyone has time for": ("[time]\ndt = 1e-15\nend = 10.0\n", ["bad.toml:3:1", "steps", "at most"]),
    "samples between steps": (
        "[time]\ndt = 0.1\nend = 1.0\n[output]\nsample_every = 0.15\n",
        ["bad.toml:5:1", "output.sample_every = 0.15", "whole number of steps"]),
    "frames between steps": (
        "[time]\ndt = 0.1\nend = 1.0\n[output]\nframe_every = 0.25\n",
        ["bad.toml:5:1", "output.frame_every = 0.25", "whole number of steps"]),
    "samples closer than steps": ("[time]\ndt = 0.01\n[output]\nsample_every = 1e-9\n",
                                  ["bad.toml:4:1", "output.sample_every = 1e-09", "step"]),
    "frames before the start": ("[output]\nframe_every = -1\n", ["bad.toml:2:1", "output.frame_every = -1", ">= 0"]),
    "checkpoints before the start": ("[output]\ncheckpoint_minutes = -5\n",
                                     ["bad.toml:2:1", "checkpoint_minutes = -5", ">= 0"]),
    "a warm-up of less than nothing": ("[analysis]\nwarm_up = -0.5\n",
                                       ["bad.toml:2:1", "analysis.warm_up = -0.5", "-1"]),
    "an unknown start": ("[initial]\nkind = \"modes\"\n", ["bad.toml:2:1", '"modes"', 'did you mean "mode"?']),
    "an unknown field": (
        "[initial]\nkind = \"mode\"\nfield = \"order\"\n",
        ["bad.toml:3:1", '"order"', "rod_density, polar_order_x, polar_order_y"]),
    "a mode beyond the grid": (
        "[grid]\nnx = 16\n[initial]\nkind = \"mode\"\nmode_x = 8\n",
        ["bad.toml:5:1", "initial.mode_x = 8", "less than 8"]),
    "a mode beyond the grid, the other way": (
        "[grid]\nny = 16\n[initial]\nkind = \"mode\"\nmode_y = -8\n",
        ["bad.toml:5:1", "initial.mode_y = -8", "less than 8"]),
    "a mode beyond 32 bits": ("[initial]\nkind = \"mode\"\nmode_x = 2147483648\n",
                              ["bad.toml:3:1", "initial.mode_x = 2147483648"]),
    "a mode at the end of 32 bits": (
        "[initial]\nkind = \"mode\"\nmode_x = -2147483648\n",
        ["bad.toml:3:1", "initial.mode_x = -2147483648", "expected"]),
    "a mode of negative amplitude": (
        "[initial]\nkind = \"mode\"\namplitude = -1\n", ["bad.toml:3:1", "initial.amplitude = -1", ">= 0"]),
    "a stationary start without noise": (
        "[initial]\nkind = \"stationary\"\n", ["bad.toml:2:1", "stationary", "noise.order = 0",
                                               "give one of them > 0"]),
    "a stationary start of a model without a stationary state": (
        "[relaxation]\nrate = -1\n[noise]\norder = 1\n[diffusion]\nrods = 1\n[initial]\nkind = \"stationary\"\n",
        ["bad.toml:8:1", "stationary", "grows"]),
    "a start from no file": ("[initial]\nkind = \"file\"\n", ["bad.toml:2:1", "initial.file", "name the archive"]),
    "a start from a missing file": (
        "[initial]\nkind = \"file\"\nfile = \"lost.h5\"\n", ["bad.toml:3:1", "lost.h5", "does not exist"]),
    "a negative frame": ("[initial]\nframe = -2\n", ["bad.toml:2:1", "initial.frame = -2", ">= -1"]),
    "an amplitude of a uniform start": (
        "[initial]\namplitude = 0.1\n",
        ["bad.toml:2:1", "initial.amplitude = 0.1 has no effect with initial.kind = \"uniform\"", "default, 0.0, or"]),
    "a wave of a uniform start": ("[initial]\nmode_y = 2\n",
                                  ["bad.toml:2:1", "initial.mode_y = 2 has no effect", 'kind = "mode"']),
    "a file of a uniform start": ("[initial]\nfile = \"a.h5\"\n",
                                  ["bad.toml:2:1", "initial.file = \"a.h5\" has no effect", 'kind = "file"']),
    "long waves of a full model": ("[approximation]\nquasi_linear_above = 0.3\n",
                                   ["bad.toml:2:1", "has no effect without approximation.quasi_linear = true"]),
    "a degree of dealiasing with another rule": (
        "[dealiasing]\nrule = \"none\"\ndegree = 3\n",
        ["bad.toml:3:1", "dealiasing.degree = 3 has no effect with dealiasing.rule = \"none\""]),
    "a negative seed": ("[run]\nseed = -1\n", ["bad.toml:2:1", "run.seed = -1", ">= 0"]),
    "too many threads": ("[run]\nthreads = 5000\n", ["bad.toml:2:1", "run.threads = 5000", "1024"]),
    "negative threads": ("[run]\nthreads = -1\n", ["bad.toml:2:1", "run.threads = -1", ">= 0"]),
    "no seeds": ("[sweep]\nseeds = 0\n", ["bad.toml:2:1", "sweep.seeds = 0", ">= 1"]),
    "an unknown ramp": ("[sweep]\nramp = \"down\"\n", ["bad.toml:2:1", '"down"', "none", "up-down"]),
    "a key twice": ("[grid]\nnx = 16\nnx = 32\n", ["bad.toml:3", "nx", "not TOML"]),
    "a table twice": ("[grid]\nnx = 16\n[grid]\nny = 32\n", ["bad.toml:3", "grid", "not TOML"]),
    "a value that is missing": ("[grid]\nnx =\n", ["bad.toml:2", "not TOML", "a number such as 0.6"]),
    "a decimal comma": ("[grid]\nlx = 0,6\n", ["bad.toml:2:7", "not TOML", "a number such as 0.6"]),
    "a table that is a list": ("[field]\nsymbol = \"u\"\n", ["bad.toml:1:2", "[field]", "expected [[field]]"]),
    "an open quote": ("[initial]\nkind = \"mode\n", ["bad.toml:2", "not TOML"]),
    "an open bracket": ("[grid\nnx = 16\n", ["bad.toml:1", "not TOML"]),
    "a line of prose": ("[grid]\nnx is sixteen\n", ["bad.toml:2", "not TOML", "lines such as [grid]"]),
    "an output in a missing folder": ("[output]\nfile = \"there/flock.h5\"\n",
                                      ["bad.toml:2:1", "there", "make it first"]),
    "a folder as output": ("[output]\nfile = \".\"\n", ["bad.toml:2:1", "is a folder", "name of a file"]),
}


SEEN_BY_A_RUN_ALONE = ("a start from a missing file", "a stationary start of a model without a stationary state")


@pytest.mark.parametrize("command", ["run", "check"])
@pytest.mark.parametrize("name", SCENES)
def test_a_scene_is_rejected_with(name, command, tmp_path):
    text, says = SCENES[name]
    if command == "check" and name in SEEN_BY_A_RUN_ALONE:
        pytest.skip("check opens no other file and draws no state")
    (tmp_path / "bad.toml").write_text(text)
    rejected(tmp_path, [command, "bad.toml"], says)


@pytest.mark.parametrize("command", ["explain", "sweep"])
@pytest.mark.parametrize("name", ["an unknown key", "an end between two steps", "a key twice",
                                  "a mode beyond the grid"])
def test_every_command_rejects_a_scene_with_the_same_message(name, command, tmp_path):
    text, says = SCENES[name]
    (tmp_path / "bad.toml").write_text(text)
    rejected(tmp_path, [command, "bad.toml"], says)


def start_from(frame=-1):
    return {"initial.kind": "file", "initial.file": "first.h5", "initial.frame": frame}


def cut_short(folder):
    make_archive(folder, "first.h5")
    cut_in_two(folder / "first.h5")


def other_fields(folder):
    with h5py.File(folder / "first.h5", "w") as file:
        file["time"] = np.zeros(1)
        file["x"] = file["y"] = np.arange(16.0)
        file["rod_density"] = np.zeros((1, 16, 16))


def odd_points(folder):
    with h5py.File(folder / "first.h5", "w") as file:
        file["time"] = np.zeros(1)
        file["x"] = file["y"] = 16.0 / 15 * np.arange(15)
        for name in ("rod_density", "polar_order_x", "polar_order_y"):
            file[name] = np.zeros((1, 15, 15))
            file[name].attrs["units"] = np.bytes_("mm-2")


def not_finite(folder):
    make_archive(folder, "first.h5")
    with h5py.File(folder / "first.h5", "r+") as file:
        file["polar_order_x"][-1, 3, 4] = np.nan


# An impossible start from an archive: how to prepare it, changes of the scene, and what the message must contain.
STARTS = {
    "no HDF5": (lambda folder: (folder / "first.h5").write_text("rods\n" * 999), {}, ["first.h5", "not an HDF5 file"]),
    "a folder": (lambda folder: (folder / "first.h5").mkdir(), {}, ["first.h5", "folder"]),
    "cut short": (cut_short, {}, ["first.h5"]),
    "empty": (lambda folder: (folder / "first.h5").write_bytes(b""), {}, ["first.h5", "not an HDF5 file"]),
    "without the fields": (other_fields, {}, ["flock.toml:43:1", "first.h5", "polar_order_x"]),
    "of another cell": (lambda folder: make_archive(folder, "first.h5", {"grid.lx": 32.0}), {},
                        ["flock.toml:43:1", "first.h5", "another cell", "16 by 16 mm"]),
    "of another cell and grid": (lambda folder: make_archive(folder, "first.h5", {"grid.lx": 32.0, "grid.nx": 32}), {},
                                 ["first.h5", "another cell"]),
    "of a grid that no run has": (odd_points, {}, ["flock.toml:43:1", "has 15 by 15 points", "even"]),
    "of fewer frames": (lambda folder: make_archive(folder, "first.h5"), start_from(3),
                        ["flock.toml:44:1", "initial.frame = 3", "0 to 2"]),
    "with a value that is not a number": (not_finite, {}, ["first.h5", "polar_order_x"]),
}


@pytest.mark.parametrize("name", STARTS)
def test_a_start_is_rejected_from_an_archive_that_is(name, tmp_path):
    prepare, changes, says = STARTS[name]
    prepare(tmp_path)
    text = scene_text({**{key: SHORT[key] for key in SHORT if key != "initial.kind"}, **start_from(), **changes})
    (tmp_path / "flock.toml").write_text(text)
    rejected(tmp_path, ["run", "flock.toml"], says)


# A file that is not a scene.
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
    "is a folder": (lambda folder: (folder / "bad.toml").mkdir(), ["bad.toml", "not a plain file"]),
    "is a pipe": (lambda folder: os.mkfifo(folder / "bad.toml"), ["bad.toml", "not a plain file"]),
    "is binary": (garbage, ["bad.toml", "not TOML"]),
    "has a zero byte": (with_nul, ["bad.toml:2", "not TOML"]),
    "is not UTF-8": (not_utf8, ["bad.toml:2", "not TOML"]),
    "is huge": (huge, ["bad.toml", "larger than 1.05 MB"]),
}


@pytest.mark.parametrize("name", FILES)
def test_a_scene_file_is_rejected_that(name, tmp_path):
    prepare, says = FILES[name]
    prepare(tmp_path)
    for command in ("run", "check", "explain", "sweep"):
        rejected(tmp_path, [command, "bad.toml"], says)


@not_as_root
def test_a_scene_without_read_permission_is_rejected(tmp_path):
    write_scene(tmp_path, base=SHORT)
    (tmp_path / "flock.toml").chmod(0)
    rejected(tmp_path, ["run", "flock.toml"], ["flock.toml", "cannot be read", "check its permissions"])


def test_an_empty_scene_is_valid_and_has_all_defaults(tmp_path):
    (tmp_path / "empty.toml").write_text("")
    assert drover(tmp_path, "check", "empty.toml").stdout == "empty.toml: valid\n"
    (tmp_path / "again.toml").write_text(drover(tmp_path, "check", "empty.toml", "--resolved").stdout)
    again = drover(tmp_path, "check", "again.toml", "--resolved").stdout
    assert again == (tmp_path / "again.toml").read_text() and "nx = 256\n" in again


# An invalid --set: its text, and what else the message must contain.
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
def test_a_setting_is_rejected_with(name, tmp_path):
    setting, says = SETTINGS[name]
    write_scene(tmp_path, base=SHORT)
    words = ["run", "flock.toml", "--set", setting]
    rejected(tmp_path, words, [f"--set {setting}", *says],
            max_lines=1 + setting.count("\n"))  # the message quotes it unchanged
