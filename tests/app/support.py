"""tests/app/support.py: running the program, small scenes, archives compared byte by byte."""
import contextlib
import io
import json
import os
import subprocess
import time
import tomllib
from pathlib import Path

import h5py
import pytest

if not os.environ.get("DROVER"):
    raise RuntimeError("DROVER is not set; expected the program, as in DROVER=build/release/drover pytest tests/app")
DROVER = str(Path(os.environ["DROVER"]).absolute())
MODELS = Path(__file__).resolve().parents[2] / "models"

# A stochastic run of every linear term on a small grid: at most half a second.
SMALL = {
    "uniform.rod_density": 2.0,
    "current.speed": 3.0,
    "relaxation.rate": 0.5,
    "elasticity.stiffness": 2.0,
    "elasticity.splay": 0.5,
    "pressure.rods": 1.5,
    "diffusion.rods": 0.2,
    "noise.order": 0.05,
    "noise.rods": 0.8,
    "grid.nx": 16,
    "grid.ny": 16,
    "grid.lx": 16.0,
    "grid.ly": 16.0,
    "time.dt": 0.1,
    "time.end": 40.0,
    "initial.kind": "stationary",
    "output.frame_every": 5.0,
    "output.sample_every": 0.5,
    "run.seed": 7,
}

# For tests that repeat for long what others show under sanitizers too.
not_sanitized = pytest.mark.skipif(bool(os.environ.get("DROVER_SANITIZE")), reason="too slow under sanitizers")


def slow_but(cases, *fast):
    """The cases of a test, of which `make test` runs those in `fast` and `make test-slow` the others."""
    return [case if case in fast else pytest.param(*(case if isinstance(case, tuple) else [case]),
                                                   marks=pytest.mark.slow) for case in cases]


def scenes(kind):
    """The names of the scenes of models/ of one kind.

    A scene with a section [calibrate] is of kind "calibrate", one with a section [cell] of kind "particles", one with
    its own fields, [[field]], of kind "model", and any other of kind "fields".
    """
    def kind_of(scene):
        kinds = {"calibrate": "calibrate", "cell": "particles", "field": "model"}
        return next((kind for section, kind in kinds.items() if section in scene), "fields")
    return sorted(path.stem for path in MODELS.glob("*.toml") if kind_of(tomllib.loads(path.read_text())) == kind)


def settings(keys):
    """The options for "section.key=value"."""
    return [word for key in keys for word in ("--set", key)]


def toml_value(value):
    """A value as TOML writes it; JSON writes numbers, texts, lists and true or false in the same way."""
    return json.dumps(value)


def scene_text(keys):
    """TOML of {"section.key": value}."""
    sections = {}
    for name, value in keys.items():
        section, key = name.rsplit(".", 1)
        sections.setdefault(section, []).append(f"{key} = {toml_value(value)}\n")
    return "\n".join(f"[{section}]\n" + "".join(lines) for section, lines in sections.items())


def write_scene(folder, changes=None, name="flock.toml", base=None):
    """Writes the small scene, with some keys changed, and returns its name."""
    keys = {**(SMALL if base is None else base), **(changes or {})}
    (folder / name).write_text(scene_text(keys))
    return name


def in_process(main, folder, *arguments):
    """What `python3 -m` does with the function `main` of a module, without the seconds that its imports take."""
    words, out, err = [str(argument) for argument in arguments], io.StringIO(), io.StringIO()
    with contextlib.chdir(folder), contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
        try:
            status = main(words)
        except SystemExit as ended:
            status = ended.code
    return subprocess.CompletedProcess(words, status or 0, out.getvalue(), err.getvalue())


def environment(**more):
    """The environment of the tests without variables that would change the program's output."""
    kept = {key: value for key, value in os.environ.items() if key not in ("NO_COLOR", "OMP_NUM_THREADS")}
    return {**kept, **more}


def drover(folder, *words, status=0, seconds=300, **options):
    """Runs the program in a folder to its end; its exit status must be the one given (None: any)."""
    options.setdefault("env", environment())
    ended = subprocess.run([DROVER, *map(str, words)], cwd=folder, capture_output=True, text=True, errors="replace",
                           stdin=subprocess.DEVNULL, timeout=seconds, check=False, **options)
    assert status is None or ended.returncode == status, \
        f"drover {' '.join(map(str, words))} ended with {ended.returncode}, not {status}:\n{ended.stderr}{ended.stdout}"
    return ended


def start_shares(folder, count, *words):
    """Starts a command as so many shares."""
    return [start(folder, *words, "--share", f"{share}/{count}") for share in range(1, count + 1)]


def end_shares(shares, seconds=240):
    """Waits for all of them; each must end with status 0."""
    try:
        for process in shares:
            process.communicate(timeout=seconds)
    finally:
        for process in shares:
            end_group(process)
    assert [process.returncode for process in shares] == [0] * len(shares)


SBATCH = """#!/bin/sh
# Replaces Slurm: runs the tasks of an array, or a job, sequentially and immediately.
echo "$@" >> "$SBATCH_LOG"
tasks=0
for word in "$@"; do
    case "$word" in --array=1-*) tasks=${word#--array=1-} ;; esac
    last=$word
done
SLURM_CPUS_PER_TASK=1; export SLURM_CPUS_PER_TASK
if [ "$tasks" = 0 ]; then sh -c "$last" >> "$SBATCH_LOG.out" 2>&1; fi
while [ "$tasks" -gt 0 ]; do
    SLURM_ARRAY_TASK_ID=$tasks sh -c "$last" >> "$SBATCH_LOG.out" 2>&1
    tasks=$((tasks - 1))
done
echo "4711;cluster"
"""


def slurm_at_once(folder):
    """The environment of a Slurm that runs all jobs as they are submitted."""
    binaries = folder / "bin"
    binaries.mkdir()
    (binaries / "sbatch").write_text(SBATCH)
    (binaries / "sbatch").chmod(0o755)
    (binaries / "drover").symlink_to(DROVER)
    return {"PATH": f"{binaries}:{os.environ['PATH']}", "SBATCH_LOG": str(folder / "log")}


def drover_json(folder, *words):
    """What a command prints with --json."""
    return json.loads(drover(folder, *words, "--json").stdout)


def start(folder, *words, **options):
    """Starts the program in a folder, in a new process group, and returns the running process."""
    return subprocess.Popen([DROVER, *map(str, words)], cwd=folder, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE,
                            stderr=subprocess.PIPE, text=True, env=environment(), start_new_session=True, **options)


def wait_until(holds, what, seconds=120.0, process=None):
    """Waits for an event in the program; fails if the process ends before it."""
    deadline = time.monotonic() + seconds
    while not holds():
        assert time.monotonic() < deadline, f"waited {seconds} s for {what}"
        if process is not None and process.poll() is not None:
            assert holds(), f"the program ended with {process.returncode} before {what}: {process.stderr.read()}"
            return
        time.sleep(0.002)


def group_is_alive(group):
    """Whether any process of a process group still runs; a zombie does not count."""
    for stat in Path("/proc").glob("[0-9]*/stat"):
        try:
            state, _, its_group = stat.read_text().rpartition(")")[2].split()[:3]
        except OSError:  # it has just ended
            continue
        if int(its_group) == group and state not in "ZX":
            return True
    return False


def end_group(process):
    """Ends a process that `start` started, and all its children, in any state."""
    if group_is_alive(process.pid):
        os.killpg(process.pid, 9)
    process.communicate()


def contents(path):
    """Every dataset of every group of an archive: name -> (type, shape, raw bytes)."""
    found = {}

    def take(name, item):
        if isinstance(item, h5py.Dataset):
            found[name] = (item.dtype.str, item.shape, item[()].tobytes())

    with h5py.File(path, "r") as file:
        file.visititems(take)
    return found


def assert_same_bytes(one, other):
    """Both archives contain the same datasets, byte for byte."""
    a, b = contents(one), contents(other)
    assert len(a) > 50 and {"rod_density", "observables/polar_order", "summary/polar_order"} <= set(a), sorted(a)
    assert sorted(a) == sorted(b)
    assert [name for name in a if a[name] != b[name]] == []


def attributes(path):
    """The root attributes of an archive."""
    with h5py.File(path, "r") as file:
        return {name: value.decode() if isinstance(value, bytes) else value for name, value in file.attrs.items()}


def frame_count(path):
    """Frames of an archive."""
    with h5py.File(path, "r") as file:
        return len(file["time"])


def checkpoints(archive):
    """The two checkpoint files of an archive."""
    return [Path(f"{archive}.checkpoint-{letter}") for letter in "ab"]


def checkpoint_step(path):
    """The step in the header of a checkpoint file: magic (8), version (4), length (8), counter (8), step (8)."""
    head = path.read_bytes()[:36]
    assert head[:8] == b"drvchkp1", path
    return int.from_bytes(head[28:36], "little")


def damage(path, place=None):
    """Flips one bit of a file, in its middle."""
    content = bytearray(path.read_bytes())
    place = len(content) // 2 if place is None else place
    content[place] ^= 0x10
    path.write_bytes(content)


def tree(folder):
    """Everything below a folder: relative name -> content, or None for a folder."""
    return {str(path.relative_to(folder)): path.read_bytes() if path.is_file() and os.access(path, os.R_OK) else None
            for path in sorted(Path(folder).rglob("*"))}
