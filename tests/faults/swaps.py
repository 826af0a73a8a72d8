"""tests/faults/swaps.py: files of one run in the place of those of another; none may be joined.

    DROVER=build/release/drover python3 tests/faults/swaps.py [--count 200] [--seed 1] [--only KIND] [--other PROGRAM]

Each pair is two runs that differ in one key, in the seed, or in the version of drover that made them (or in nothing,
where two runs of one scene are mixed up); a file of one replaces that of the other, and the next command must end with
status 2 and a sentence that names the difference: the key, the version, or the run ids.  It must write nothing.

Kinds: archive, checkpoint (the newest or both), journal, sweep (an archive of its folder, with its checkpoints), trial
(that of the first trial of `tradeoff`, which each call reads; which others it reads depends on times), records (the
records of that folder), calibration (the trials of a measurement).  Another version of drover may resume a sweep or a
calibration: an archive of another version in a sweep is used, with a warning that names both versions; records and
calibrations have no pairs of versions.
`--other`: a drover of another version; without it, a pair of two versions has the version changed in the provenance of
one archive, which then cannot be that of a checkpoint.
"""
import argparse
import os
import random
import re
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

import h5py
import numpy

from walk import DROVER, TINY, calibration_scene, environment

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "app"))
from support import scene_text, settings, toml_value, tree  # noqa: E402

SCENE = {**TINY, "output.checkpoint_minutes": 60.0}
VALUES = {"relaxation.rate": 0.6, "noise.order": 0.06, "noise.rods": 0.4, "diffusion.rods": 0.3,
          "uniform.rod_density": 3.0, "elasticity.stiffness": 1.0, "grid.nx": 10, "grid.ly": 9.0, "time.dt": 0.05,
          "initial.amplitude": 0.2, "output.frame_every": 0.1, "output.sample_every": 0.2, "run.seed": 8,
          "advection.strength": 0.1, "output.powers": True, "cell.lx": 6.5}
KINDS = ("archive", "checkpoint", "journal", "sweep", "trial", "records", "calibration")
CHECKPOINTS = (".checkpoint-a", ".checkpoint-b")


def run(folder, words, program=DROVER, status=0):
    ended = subprocess.run([program, *map(str, words)], cwd=folder, capture_output=True, text=True, errors="replace",
                           stdin=subprocess.DEVNULL, env=environment(), timeout=120, check=False)
    assert status is None or ended.returncode == status, f"{words}: status {ended.returncode}: {ended.stderr}"
    return ended


class Pair:
    """Two runs in two folders, and the sentence by which their difference is named."""

    def __init__(self, folder, kind, difference, other):
        self.one, self.two = folder / "one", folder / "two"
        self.kind, self.difference, self.other = kind, difference, other
        for place, key in ((self.one, None), (self.two, difference)):
            place.mkdir()
            changes = {key: VALUES[key]} if key in VALUES else {}
            self.make(place, changes, other if key == "version" and other else DROVER)
        if difference == "version" and not other:
            for archive in self.two.rglob("*.h5"):
                with h5py.File(archive, "r+") as file:
                    file.attrs["drover_version"] = numpy.bytes_("0.0.9")

    def make(self, place, changes, program):
        keys = {**SCENE, **changes}
        if self.kind == "calibration":
            calibration_scene(place)
        elif self.kind == "sweep":
            keys |= {"sweep.vary": ["pressure.rods = 0.5, 1"], "sweep.workers": 1}
        elif self.kind in ("trial", "records"):
            keys |= {"time.end": 40.0}
        (place / "s.toml").write_text(scene_text(keys))
        changed = settings(f"{key}={toml_value(value)}" for key, value in changes.items())
        run(place, self.first() + (changed if self.kind == "calibration" else []), program)
        if self.kind == "journal":
            leave_journal(place, program)

    def first(self):
        """What makes the files."""
        study = ["tradeoff", "s.toml", "--quiet", "--want", "polar_order=30%", "--budget", "2s", "-o", "study"]
        return {"sweep": ["sweep", "s.toml", "--quiet", "-o", "swept"], "trial": study, "records": study,
                "calibration": ["calibrate", "calibrate.toml", "--workers", "1", "--quiet", "-o", "trials"],
                }.get(self.kind, ["run", "s.toml", "--quiet", "-o", "r.h5"])

    def next(self):
        """What must reject the other's files."""
        if self.kind in ("archive", "checkpoint", "journal"):
            return ["restart", "r.h5", "--quiet", "--set", "time.end=0.8"]
        return self.first()

    def swap(self, dice):
        """Puts a file of the second run in the place of that of the first; returns its name."""
        if self.kind == "archive":
            names = ["r.h5"], ["r.h5"]
        elif self.kind == "checkpoint":  # the newest, or both
            names = ([f"r.h5{end}" for end in dice.choice([CHECKPOINTS, CHECKPOINTS[1:]])],) * 2
        elif self.kind == "journal":
            names = (["r.h5.journal"],) * 2
        elif self.kind == "trial":
            names = tuple([first_trial(place) + end for end in ("", *CHECKPOINTS)] for place in (self.one, self.two))
        else:
            pattern = {"sweep": "swept/*.h5", "calibration": "trials/records/*.records",
                       "records": "study/records/*.records"}[self.kind]
            mine, theirs = (sorted(str(path.relative_to(place)) for path in place.glob(pattern))
                            for place in (self.one, self.two))
            number = dice.randrange(min(len(mine), len(theirs)))
            ends = ("", *CHECKPOINTS) if self.kind == "sweep" else ("",)
            names = [mine[number] + end for end in ends], [theirs[number] + end for end in ends]
        for mine, theirs in zip(*names):
            shutil.copy(self.two / theirs, self.one / mine)
        return names[0][0]

    def status(self):
        return 0 if self.kind == "sweep" and self.difference == "version" else 2

    def words(self):
        """Of which one must be in the sentence."""
        if self.kind == "sweep" and self.difference == "version":
            return ["was made by drover 0.0.9"] if not self.other else ["was made by drover "]
        if self.kind == "trial":  # two trials of one scene differ in keys of their own, too
            return [" in the archive, ", "run_id = "]
        if self.kind == "journal" or self.difference == "nothing":
            return ["run_id = "]
        if self.difference == "version":
            return ["the version of drover = ", "run_id = "]  # where only one of the files has the version
        return [self.difference + " = "]


def first_trial(place):
    """The archive of the first record of a study: of the scene as it was given."""
    records, = (place / "study/records").iterdir()
    name = re.search(rb"trial-[0-9a-f]{16}", records.read_bytes())
    return f"study/{name.group().decode()}.h5"


def leave_journal(place, program):
    """A restart whose disk fails while it overwrites the archive: the complete commit stays in the journal."""
    words = ["restart", "r.h5", "--quiet", "--set", "time.end=0.6"]
    shim = os.environ.get("DROVER_SHIM")
    assert shim, "DROVER_SHIM is not set; expected build/release/tests/drover_fault_shim.so, for --only journal"
    kept = tree(place)
    for number in range(4, 200):
        subprocess.run([program, *words], cwd=place, capture_output=True, check=False,
                       env=environment(LD_PRELOAD=shim, DROVER_FAULT=f"pwrite:{number}:EIO:always"))
        if (place / "r.h5.journal").exists():
            return
        for name, content in kept.items():
            (place / name).write_bytes(content)
    raise AssertionError("no failing write left a journal")


def complaints(folder, kind, difference, other, dice):
    """What is wrong after one swap, as a list of texts."""
    pair = Pair(folder, kind, difference, other)
    swapped = pair.swap(dice)
    before = tree(pair.one)
    ended = run(pair.one, pair.next(), status=None)
    wrong, printed = [], ended.stdout + ended.stderr
    if ended.returncode != pair.status():
        wrong.append(f"status {ended.returncode}: {ended.stderr[-300:]}")
    elif not any(word in printed for word in pair.words()):
        wrong.append(f"expected {pair.words()} in: {printed[-500:]}")
    if tree(pair.one) != before:
        wrong.append("files were changed")
    return [f"{kind}, {difference}, {swapped}: {one}" for one in wrong]


def differences_of(kind):
    """The keys in which two runs of this kind may differ; trials and sweeps set some of them themselves."""
    if kind == "calibration":
        return ["run.seed", "cell.lx"]
    keys = [key for key in VALUES if key != "cell.lx"]
    if kind in ("trial", "records"):
        keys = [key for key in keys if not key.startswith(("output.", "time."))]
    return [*keys, *{"sweep": ["version"], "records": []}.get(kind, ["version", "nothing"])]


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--count", type=int, default=200)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--only", choices=KINDS)
    parser.add_argument("--other", type=os.path.abspath)
    options = parser.parse_args()
    dice = random.Random(options.seed)
    bad = 0
    counts = dict.fromkeys(KINDS, 0)
    for _ in range(options.count):
        kind = options.only or dice.choice(KINDS)
        with tempfile.TemporaryDirectory(prefix="drover-swaps-") as place:
            wrong = complaints(Path(place), kind, dice.choice(differences_of(kind)), options.other, dice)
        counts[kind] += 1
        bad += bool(wrong)
        for one in wrong:
            print(one, flush=True)
    print(f"{sum(counts.values())} swaps ({', '.join(f'{kind} {count}' for kind, count in counts.items() if count)}), "
          f"{bad} complaints")
    return bad > 0


if __name__ == "__main__":
    sys.exit(main())
