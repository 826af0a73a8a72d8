"""tests/faults/names.py: files with hostile names through every command.

    DROVER=build/release/drover PYTHONPATH=build/release/python python3 tests/faults/names.py [--skip N]

A scene, its archive, its folders and its pictures have the name.  Every command ends with status 0, or with status 1 or
2 and one sentence; it prints no control character and nothing that is not UTF-8; it makes no file under another name,
and runs nothing that the name holds.
"""
import argparse
import os
import re
import subprocess
import sys
import tempfile
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "app"))
from support import DROVER, MODELS, environment, write_scene  # noqa: E402

SHORT = {"time.end": 2.0, "output.frame_every": 0.5, "output.sample_every": 0.5, "grid.nx": 8, "grid.ny": 8,
         "grid.lx": 8.0, "grid.ly": 8.0, "boundary.x": "relaxation.rate = 0.1:1", "boundary.y": "current.speed = 1:4",
         "stability.wavenumbers": 8, "boundary.cells": 4, "boundary.lines": ["onset"]}
# Run by a shell, each would make the file "canary".
COMMANDS = [b"$(touch canary)", b"`touch canary`", b"; touch canary;", b"\ntouch canary\n", b"' ; touch canary; '",
            b'"; touch canary; "', b"| touch canary", b"&& touch canary", b"\\\ntouch canary\n",
            b"a\n#\ntouch canary #", b"x'\ntouch canary\n'", b"$((1))$(touch canary)"]
NAMES = COMMANDS + [
    b"flock", b"two words", b" leading", b"trailing ", b"-dash", b"--help", b"-o", b"a:b", b"http:x", b"pipe:1", b"C:",
    b"file:x", b"50%", b"%d", b"%s%n", b"{0}", b"{}", b"$", b"$a$", b"$\\frac{1}{$", b"\\$x\\$", b"$x", b"a_b^c",
    b"\\alpha", b"\xff", b"\xc3\x28", b"a\xed\xa0\x80b", "straße €".encode(), "\u202egpj".encode(), b"\x1b[31mred",
    b"\x1b]0;title\x07", b"\x9b2J", "\u009b2J".encode(), b"bell\x07", b"tab\tbed", b"cr\rlf", b"del\x7f", b"#hash",
    b"a=b", b"[x]", b"a,b", b"*?", b"~", b"!x", b"\"quoted\"", b"'", b"a.b.c", b"..x", b"x" * 240, b"y" * 250,
    b"\xf0\x9f\x90\x91" * 50, b"true", b"1e5", b"nan"]
UNPRINTABLE = re.compile("[\x00-\x08\x0b-\x1f\x7f-\x9f]")
SBATCH = '#!/bin/sh\nfor word in "$@"; do case "$word" in exec*) sh -n -c "$word" || exit 1;; esac; done\necho 4711\n'
PICTURES = "import sys; from drover.{0} import main; sys.exit(main(sys.argv[1:]))"
OPENING = """import sys, drover
from drover.error import status_of
sys.exit(status_of(lambda: (drover.info(sys.argv[1]), drover.open_run(sys.argv[1]).close())))"""


def steps(name, has_film=True):
    """The commands, with where they need it the name of a file behind the word of its option."""
    def of(ending, start=b"./"):
        return start + name + ending
    python = [sys.executable, "-P"]
    film = [[DROVER, "film", of(b".h5")]] if has_film else []
    return [
        [DROVER, "check", of(b".toml")], [DROVER, "check", of(b".toml"), "--resolved"],
        [DROVER, "explain", of(b".toml")],
        [DROVER, "run", of(b".toml"), "--quiet", "--set", "time.end=1"],
        [DROVER, "restart", of(b".h5"), "--set", "time.end=2"],
        [DROVER, "restart", of(b".h5"), "--set", "time.end=2", "--quiet"],
        [DROVER, "run", of(b".toml"), "-o", of(b".2.h5")],
        [DROVER, "info", of(b".h5")], [DROVER, "info", of(b".h5"), "--scene"], [DROVER, "info", of(b".h5"), "--json"],
        [DROVER, "export", of(b".h5"), "-o", of(b".csv")], [DROVER, "export", of(b".h5"), "-o", of(b".vtk")],
        [DROVER, "fit", of(b".h5"), "relaxation.rate", "--every", "1"],
        [DROVER, "stability", of(b".toml"), "-o", of(b".s.h5")], [DROVER, "boundary", of(b".toml"), "-o", of(b".b.h5")],
        [DROVER, "states", of(b".toml")],
        [DROVER, "sweep", of(b".toml"), "--vary", "relaxation.rate = 0.5, 1", "-o", of(b".sweep")],
        [DROVER, "sweep", of(b".toml"), "--vary", "relaxation.rate = 0.5, 1", "--ramp", "up", "-o", of(b".ramp")],
        *film,
        *([*python, "-c", PICTURES.format("figure"), of(ending)] for ending in (b".h5", b".s.h5", b".b.h5")),
        [*python, "-c", OPENING, of(b".h5")],
        [DROVER, "info", of(b".missing")], [DROVER, "schema", of(b"")], [DROVER, of(b"", b"")],
        [DROVER, "check", b"./flock.toml", "--set", of(b"", b"")],
        [DROVER, "tradeoff", of(b".toml"), "--want", of(b"=1%", b"")],
        [DROVER, "calibrate", of(b".toml")],
        [DROVER, "calibrate", of(b".calibrate.toml"), "--slurm", "2", "-o", of(b".trials"), "--set", of(b"", b"a.b=")]]


def complaints(words, ended, strict):
    """What is wrong with what a command made of a name."""
    shown = b" ".join(os.fsencode(word) for word in words[1:]).decode(errors="replace")
    wrong = []
    if ended.returncode not in (0, 1, 2):
        wrong.append(f"status {ended.returncode}: {ended.stderr[-300:]}")
    if strict and ended.returncode != 0:
        wrong.append(f"status {ended.returncode}: {ended.stderr[-300:]}")
    if b"Traceback" in ended.stderr or b"bug in drover" in ended.stderr:
        wrong.append(f"no sentence: {ended.stderr[-300:]}")
    if ended.returncode in (1, 2) and b"error: " not in ended.stderr and b"warning: " not in ended.stderr:
        wrong.append(f"status {ended.returncode} without a sentence: {ended.stderr[-300:]}")
    if "--slurm" not in words:
        for stream in (ended.stdout, ended.stderr):
            try:
                if UNPRINTABLE.search(stream.decode()):
                    wrong.append(f"prints a control character: {stream[-300:]}")
            except UnicodeDecodeError:
                wrong.append(f"prints what is not UTF-8: {stream[-300:]}")
    return [f"{shown}: {line}" for line in wrong]


def run_slurm(folder, script, tools):
    """Runs a script as a user would, with an sbatch that checks the syntax of the command it is given."""
    (folder / "script.sh").write_bytes(script)
    return subprocess.run(["sh", "script.sh"], cwd=folder, capture_output=True, check=False, timeout=60,
                          env=environment(PATH=f"{tools}:{os.environ['PATH']}"))


def try_name(name, folder, tools, has_film=True):
    """All commands on one name in an empty folder; returns what is wrong."""
    os.mkdir(folder)
    folder = Path(os.fsdecode(folder))
    write_scene(folder, SHORT)
    scene = (folder / "flock.toml").read_bytes()
    wrong = []
    for ending, content in ((b".toml", scene), (b".calibrate.toml", (MODELS / "calibrate-small.toml").read_bytes())):
        try:
            (folder / os.fsdecode(name + ending)).write_bytes(content)
        except OSError:  # too long for the file system
            pass
    # These must succeed, but for names so long that those of the checkpoints are too long.
    strict = ("check", "explain", "run", "info", "export", "restart", "stability", "boundary", "sweep", "film", "-P")
    for words in steps(name, has_film):
        ended = subprocess.run(words, cwd=folder, capture_output=True, check=False, timeout=120, env=environment(),
                               stdin=subprocess.DEVNULL)
        is_mistake = b"./flock.toml" in words or b"./" + name + b".missing" in words
        wrong += complaints(words, ended, len(name) < 220 and words[1] in strict and not is_mistake)
        if "--slurm" in words and ended.returncode == 0:
            wrong += complaints(["script.sh"], run_slurm(folder, ended.stdout, tools), False)
    starts = (name, b"flock.toml", b"script.sh", b"." + name)
    for made in os.listdir(os.fsencode(folder)):
        if not made.startswith(starts):
            wrong.append(f"made {made!r}")
    return [f"{name!r}: {line}" for line in wrong]


def tools_in(folder):
    tools = Path(folder) / "tools"
    tools.mkdir()
    (tools / "sbatch").write_text(SBATCH)
    (tools / "sbatch").chmod(0o755)
    return tools


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--skip", type=int, default=0, metavar="N", help="leave out the first N names")
    names = NAMES[parser.parse_args().skip:]
    with tempfile.TemporaryDirectory(prefix="drover-names-") as place:
        tools, failures = tools_in(place), 0
        for number, name in enumerate(names):
            wrong = try_name(name, os.fsencode(place) + b"/%d" % number, tools)
            failures += len(wrong)
            print(f"{name!r}: {len(wrong)} complaints", *wrong, sep="\n  ", flush=True)
    print(f"{len(names)} names, {failures} complaints")
    return failures > 0


if __name__ == "__main__":
    sys.exit(main())
