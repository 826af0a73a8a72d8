"""tests/faults/mutants.py: damaged archives, tables, checkpoints and trial files through every command that reads them.

    DROVER=build/release/drover python3 tests/faults/mutants.py [--count 1000] [--seed 1]

A command on a mutant (some bytes changed, a part overwritten with zeros or another part, or the end cut off) ends
within 10 s, takes less than 1 GB, and has status 0, or 2 with one sentence (1: the run that it starts diverges or the
disk fails; a mutant cannot cause the latter).
"""
import argparse
import collections
import random
import resource
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

from walk import DROVER, MODELS, TINY, calibration_scene, environment, run, write_scene

GRAINS = {"cell.lx": 9.0, "cell.ly": 9.0, "beads.count": 4, "rods.count": 1, "time.dt": 2e-5, "time.end": 0.004,
          "output.frame_every": 0.002, "output.sample_every": 0.001, "run.threads": 1}
COMMANDS = {
    "fields.h5": [["info"], ["info", "--json"], ["restart", "--quiet", "--set", "time.end=0.5"],
                  ["run", "from-file.toml", "--quiet", "--overwrite"]],
    "fields.h5.checkpoint-a": [["restart", "--quiet", "--set", "time.end=0.5"]],
    "grains.h5": [["info"], ["export", "-o", "grains.xyz", "--overwrite"],
                  ["restart", "--quiet", "--set", "time.end=0.005"]],
    "waves.h5": [["fit", "relaxation.rate", "noise.order", "noise.rods"]],
    "bed.h5": [["fit", "relaxation.rate", "--scene", "fields.toml"]],
    "trials/table.h5": [["info"], ["boundary"]],
    "matched.calibration/table.h5": [["check", "calibrated-flock.toml"], ["info"]],  # one that fields can use
    "trials/records/share.records": [["calibrate", "calibrate.toml", "--collect", "--quiet", "-o", "trials"]],
}


def make_files(folder):
    """One of each file that drover writes."""
    write_scene(folder, TINY, name="fields.toml", base={})
    write_scene(folder, {**TINY, "initial.kind": "file", "initial.file": "fields.h5"}, name="from-file.toml", base={})
    write_scene(folder, GRAINS, name="grains.toml", base={})
    write_scene(folder, {**TINY, "time.end": 8.0, "output.frame_every": 0.1}, name="waves.toml", base={})
    write_scene(folder, {**GRAINS, "rods.count": 3, "time.end": 0.07, "output.frame_every": 0.001}, name="bed.toml",
                base={})
    calibration_scene(folder)
    shutil.copy(MODELS / "calibrated-flock.toml", folder)
    (folder / "matched.calibration").mkdir()
    shutil.copy(MODELS / "matched.calibration/table.h5", folder / "matched.calibration")
    for words in (["run", "fields.toml", "--quiet"], ["run", "grains.toml", "--quiet"],
                  ["run", "waves.toml", "--quiet"], ["run", "bed.toml", "--quiet"],
                  ["calibrate", "calibrate.toml", "--workers", "1", "--quiet", "-o", "trials"]):
        ended = run(folder, words)
        assert ended.returncode == 0, ended.stderr
    records, = (folder / "trials" / "records").iterdir()  # it has a random name
    records.rename(records.with_name("share.records"))


def mutant(content, dice):
    """Damaged bytes."""
    content = bytearray(content)
    for _ in range(dice.choice((1, 1, 2, 8))):
        at, kind = dice.randrange(len(content)), dice.random()
        if kind < 0.6:
            content[at] = dice.choice((0, 255, content[at] ^ 1 << dice.randrange(8), dice.randrange(256)))
        elif kind < 0.75:
            content[at:at + 8] = dice.choice((bytes(8), b"\xff" * 8, bytes(7) + b"\x7f"))[:len(content) - at]
        elif kind < 0.95:
            length, start = dice.randrange(1, 4097), dice.randrange(len(content))
            content[at:at + length] = content[start:start + length]
        else:
            del content[max(1, at):]
    return bytes(content)


def words_of(command, name):
    first, *rest = command
    name = name.removesuffix(".checkpoint-a")
    return [first, *([name] if first in ("info", "restart", "export", "boundary", "fit") else []), *rest]


def outcome(folder, words):
    """The status, and what is wrong; None for nothing."""
    def limit():
        resource.setrlimit(resource.RLIMIT_DATA, (1 << 30, 1 << 30))

    try:
        ended = subprocess.run([DROVER, *words], cwd=folder, capture_output=True, text=True, errors="replace",
                               stdin=subprocess.DEVNULL, timeout=10, check=False, env=environment(), preexec_fn=limit)
    except subprocess.TimeoutExpired:
        return "late", "takes more than 10 s"
    errors = [line for line in ended.stderr.splitlines() if line.startswith("error: ")]
    if ended.returncode not in (0, 1, 2) or "not enough memory" in ended.stderr or "bug in drover" in ended.stderr:
        return ended.returncode, f"status {ended.returncode}: {ended.stderr[-300:]}"
    if ended.returncode != 0 and len(errors) != 1 and words[0] != "calibrate":
        return ended.returncode, f"no sentence: {ended.stderr[-300:]}"
    return ended.returncode, None


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--count", type=int, default=1000)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--only", choices=COMMANDS, help="mutants of this file")
    parser.add_argument("--keep", type=Path, help="folder for the mutants that something is wrong with")
    options = parser.parse_args()
    dice = random.Random(options.seed)
    statuses, complaints, count = collections.Counter(), 0, 0
    with tempfile.TemporaryDirectory(prefix="drover-mutants-") as place:
        whole = Path(place) / "whole"
        whole.mkdir()
        make_files(whole)
        while count < options.count:
            name = options.only or list(COMMANDS)[count % len(COMMANDS)]
            changed = mutant((whole / name).read_bytes(), dice)
            count += 1
            if count % 100 == 0:
                print(f"{count} mutants so far, {complaints} complaints", flush=True)
            for command in COMMANDS[name]:
                folder = Path(place) / "mutant"
                shutil.copytree(whole, folder)
                (folder / name).write_bytes(changed)
                status, wrong = outcome(folder, words_of(command, name))
                shutil.rmtree(folder)
                statuses[f"{name} {command[0]}: {status}"] += 1
                if wrong:
                    complaints += 1
                    print(f"mutant {count} of {name}, {' '.join(command)}: {wrong}", flush=True)
                    if options.keep:
                        options.keep.mkdir(exist_ok=True)
                        (options.keep / f"{count}-{Path(name).name}").write_bytes(changed)
    for line, number in sorted(statuses.items()):
        print(f"{line}: {number}")
    print(f"{count} mutants, {sum(statuses.values())} commands, {complaints} complaints")
    return complaints > 0


if __name__ == "__main__":
    sys.exit(main())
