"""tests/app/test_hostile_names.py: names and texts of files that command a shell, a terminal, Python or TeX."""
import os
import re
import subprocess
import sys
from pathlib import Path

import h5py
import numpy
import pytest
from support import DROVER, drover, end_group, environment, slow_but, start, wait_until, write_scene

import drover as module

FAULTS = Path(__file__).resolve().parents[1] / "faults"
sys.path.insert(0, str(FAULTS))
from names import tools_in, try_name  # noqa: E402

SHORT = {"time.end": 2.0, "output.frame_every": 1.0, "grid.nx": 8, "grid.ny": 8, "grid.lx": 8.0, "grid.ly": 8.0}
# What each of the names of tests/faults/names.py has alone, in two names.
ALL = b"-\xff $a$ %d a:b \x1b[31m\x07 {0} #'\"\ntouch canary\n$(touch canary)`touch canary`;"
LONG = b"x" * 250


def archive_of(folder):
    drover(folder, "run", write_scene(folder, SHORT), "--quiet")
    return folder / "flock.h5"


def python(folder, *words, **more):
    return subprocess.run([sys.executable, *map(str, words)], cwd=folder, capture_output=True, text=True, check=False,
                          env=environment(**more), timeout=120)


@pytest.mark.parametrize("name, has_film", slow_but([(ALL, True), (LONG, False)], (ALL, True)))
def test_a_hostile_name_is_taken_as_it_is_by_every_command(name, has_film, tmp_path):
    wrong = try_name(name, os.fsencode(tmp_path) + b"/work", tools_in(tmp_path), has_film)
    assert not wrong, "\n".join(wrong)


def test_an_output_that_is_not_utf_8_gets_the_name_that_was_given(tmp_path):
    drover(tmp_path, "run", write_scene(tmp_path, SHORT), "--quiet", "-o", os.fsdecode(b"\xff.h5"))
    assert b"\xff.h5" in os.listdir(os.fsencode(tmp_path))


EVIL = 'import sys\nopen("canary", "w").close()\nprint("owned", file=sys.stderr)\n'


def test_nothing_in_the_current_folder_is_run(tmp_path):
    archive_of(tmp_path)
    for name in ("drover", "numpy", "h5py", "matplotlib", "argparse", "json", "sitecustomize"):
        (tmp_path / f"{name}.py").write_text(EVIL)
    package = str(Path(module.__file__).parents[1])
    for path in ("", "::", ":first::second"):  # an empty part would name the current folder
        found = drover(tmp_path, "film", "flock.h5", env=environment(PYTHONPATH=package + path))
        (tmp_path / "flock.mp4").unlink()
        assert "owned" not in found.stderr
    sweep = ("import sys, drover; scene = drover.Scene.load('flock.toml'); "
             "drover.sweep(scene, {'relaxation.rate': [0.5, 1.0]})")
    for words in (["-c", sweep], ["-m", "drover.figure", "flock.h5"]):
        ended = python(tmp_path, "-P", *words, PYTHONPATH=package)
        assert ended.returncode == 0 and "owned" not in ended.stderr, ended.stderr
    assert not (tmp_path / "canary").exists()


def dynamic_paths(binary):
    listed = subprocess.run(["readelf", "-d", binary], capture_output=True, text=True, check=True).stdout
    lines = [line for line in listed.splitlines() if "(RUNPATH)" in line or "(RPATH)" in line]
    return [path for line in lines for path in line.partition("[")[2].rstrip("]").split(":")]


def test_libraries_are_looked_for_in_absolute_folders_only(tmp_path):
    build = Path(DROVER).parent
    compiled = next((Path(module.__file__).parent).glob("_drover.*.so"))
    subprocess.run(["cmake", "--install", build, "--prefix", tmp_path], check=True, capture_output=True)
    installed = [tmp_path / "bin" / "drover", *tmp_path.rglob("_drover.*.so")]
    assert len(installed) == 2
    for binary in (DROVER, compiled, *installed):
        assert all(path.startswith(("/", "$ORIGIN")) for path in dynamic_paths(binary)), (binary, dynamic_paths(binary))


def test_the_module_tells_the_dynamic_linker_which_processor_it_needs():
    if "DROVER_NATIVE:BOOL=ON" in (Path(DROVER).parent / "CMakeCache.txt").read_text(encoding="utf-8"):
        pytest.skip("compiled for the processor of this machine")
    compiled = next((Path(module.__file__).parent).glob("_drover.*.so"))
    notes = subprocess.run(["readelf", "-n", compiled], capture_output=True, text=True, check=True).stdout
    assert re.search("x86 ISA needed:.*x86-64-v3", notes)


HOSTILE = ["$a$", "$\\frac{1}{", "\x1b[31m", "$" * 5001, "x" * 60000, "$\\sqrt{" * 2000, "\x01\x02", "$\\alpha", "\\$"]


@pytest.mark.parametrize("turn", range(2))
def test_texts_of_an_archive_are_drawn_as_they_are(turn, tmp_path):
    archive = archive_of(tmp_path)
    texts = iter([numpy.bytes_(words.encode()) for words in HOSTILE[4 * turn:] + HOSTILE])
    with h5py.File(archive, "r+") as file:
        for name in ("scene_file", "seed"):
            file.attrs[name] = next(texts)
        for name in ("rod_density", "polar_order_x", "x", "time", "observables/polar_order"):
            file[name].attrs["units"] = next(texts)
    with module.open_run(archive) as run:
        module.plot.figure(run).canvas.draw()
    ended = drover(tmp_path, "film", "flock.h5", "--every", "3", seconds=60)
    assert "\x1b" not in ended.stdout + ended.stderr


@pytest.mark.parametrize("value", [numpy.nan, numpy.inf])
def test_frames_that_are_not_finite_are_an_error_and_not_a_picture(value, tmp_path):
    archive = archive_of(tmp_path)
    with h5py.File(archive, "r+") as file:
        file["rod_density"][-1, 2, 3] = value
    with module.open_run(archive) as run, pytest.raises(module.Error, match="rod_density has values that are not fin"):
        module.plot.figure(run)
    ended = drover(tmp_path, "film", "flock.h5", status=2)
    assert "rod_density has values that are not finite" in ended.stderr and "Traceback" not in ended.stderr


def test_a_film_that_is_stopped_leaves_no_part(tmp_path):
    drover(tmp_path, "run", write_scene(tmp_path, {**SHORT, "time.end": 200.0, "output.frame_every": 0.2}), "--quiet")
    process = start(tmp_path, "film", "flock.h5")
    try:
        wait_until((tmp_path / ".flock.mp4.part").exists, "the part of the film", process=process)
        process.terminate()
        assert process.wait(20) == -15
        assert [path.name for path in tmp_path.iterdir() if "mp4" in path.name] == []
    finally:
        end_group(process)
