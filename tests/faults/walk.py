"""tests/faults/walk.py: makes every call of a short command fail in turn, and checks what the program makes of it.

    DROVER=build/release/drover python3 tests/faults/walk.py SHIM [--every N] [--only SCENARIO[:CALL]]

For each scenario (run, restart, sweep, calibrate, film), each call (see shim.cpp), each of its errors, once or for
good, and each n (for malloc: each n whose innermost calls are new): a command ends with status 0, 1 or 2 within a
minute and by no signal; a failure has one sentence, not "bug in drover"; after status 0 the results have the bytes of a
run without faults; and the next command, without a fault, ends with status 0 and those bytes.
"""
import argparse
import collections
import os
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "app"))
from support import DROVER, MODELS, contents, environment, write_scene  # noqa: E402

TINY = {"relaxation.rate": 0.5, "noise.order": 0.05, "noise.rods": 0.5, "diffusion.rods": 0.2,
        "uniform.rod_density": 2.0, "elasticity.stiffness": 2.0, "grid.nx": 8, "grid.ny": 8, "grid.lx": 8.0,
        "grid.ly": 8.0, "time.dt": 0.1, "time.end": 0.4, "initial.kind": "random", "initial.amplitude": 0.1,
        "output.frame_every": 0.2, "output.sample_every": 0.1, "output.checkpoint_minutes": 0.0, "run.seed": 7,
        "run.threads": 1}
ERRORS = {"write": ["ENOSPC", "EIO", "short", "EINTR"], "pwrite": ["ENOSPC", "EIO", "EDQUOT", "short", "EINTR"],
          "pread": ["EIO", "short", "EINTR"], "fsync": ["EIO", "ENOSPC", "EINTR"], "rename": ["EIO", "ENOSPC"],
          "ftruncate": ["EIO", "EINTR"], "open": ["EIO", "EINTR", "ENOSPC"], "malloc": ["ENOMEM"]}
SCENARIOS = ("run", "restart", "sweep", "calibrate", "film")
NEVER_FOR_GOOD = ("EINTR",)  # a call that is interrupted for good is rightly repeated for good


def calibration_scene(folder):
    """One assay at one point, of a few short trials."""
    text = (MODELS / "calibrate-small.toml").read_text().replace("bead_area_fractions = [0.5, 0.65]",
                                                                "bead_area_fractions = [0.5]\nassays = [\"damping\"]")
    text = text.replace("[calibrate.damping]\ntime = 3.0", "[calibrate.damping]\ntime = 0.4")
    text = text.replace("max_trials = 24", "max_trials = 8").replace("lx = 13.5\nly = 13.5", "lx = 6.0\nly = 6.0")
    (folder / "calibrate.toml").write_text(text)


class Scenario:
    """A command, what is there before it, the next commands after a failure, and the files that must be equal."""

    def __init__(self, name, folder):
        self.name, self.template = name, folder / name
        self.template.mkdir()
        if name == "calibrate":
            calibration_scene(self.template)
            self.words = ["calibrate", "calibrate.toml", "--workers", "1", "--quiet", "-o", "trials"]
            self.results = ["trials/table.h5"]
        elif name == "sweep":
            write_scene(self.template, {**TINY, "sweep.workers": 1, "sweep.vary": ["relaxation.rate = 0.5, 1"]},
                        name="s.toml", base={})
            self.words = ["sweep", "s.toml", "--quiet", "-o", "swept"]
            self.results = ["swept/point-0000-seed-7.h5", "swept/point-0001-seed-7.h5"]
        else:
            write_scene(self.template, TINY, name="s.toml", base={})
            self.words = ["run", "s.toml", "--quiet", "-o", "r.h5"]
            self.results = ["r.h5"]
        if name == "film":
            run(self.template, self.words)
            self.words, self.results = ["film", "r.h5", "-o", "r.mp4"], ["r.mp4"]
        if name == "restart":
            run(self.template, [*self.words, "--set", "time.end=0.2"])
            self.words = ["restart", "r.h5", "--quiet", "--set", "time.end=0.4"]

    def next_words(self, folder):
        if self.name == "run":
            archive = folder / "r.h5"
            if any(Path(f"{archive}.checkpoint-{letter}").exists() for letter in "ab"):
                return ["restart", "r.h5", "--quiet"]
            return [*self.words, "--overwrite"]
        return self.words

    def variables(self, folder):
        """A film is made by Python and ffmpeg: their calls are made to fail on the files of the folder only."""
        return {"DROVER_FAULT_UNDER": str(folder)} if self.name == "film" else {}

    def bytes_in(self, folder):
        return [contents(folder / name) if name.endswith(".h5") else (folder / name).read_bytes()
                for name in self.results]


def run(folder, words, **variables):
    """Runs the program; the errors of a command that is not done within a minute are those of subprocess."""
    return subprocess.run([DROVER, *words], cwd=folder, capture_output=True, text=True, errors="replace", check=False,
                          stdin=subprocess.DEVNULL, timeout=60, env=environment(**variables))


def complaints(scenario, folder, expected, shim, fault):
    """What is wrong after one fault, as a list of texts."""
    try:
        ended = run(folder, scenario.words, LD_PRELOAD=shim, DROVER_FAULT=fault, **scenario.variables(folder))
    except subprocess.TimeoutExpired:
        return None, ["the command hangs"]
    wrong = []
    if ended.returncode not in (0, 1, 2):
        wrong.append(f"status {ended.returncode}: {ended.stderr[-300:]}")
    elif ended.returncode == 0 and scenario.bytes_in(folder) != expected:
        wrong.append("status 0 and other bytes")
    elif ended.returncode != 0 and not any(sign in ended.stderr for sign in ("error: ", "warning: ")):
        wrong.append("no sentence")
    if "bug in drover" in ended.stderr:
        wrong.append(f"called a bug: {ended.stderr[-300:]}")
    try:
        again = run(folder, scenario.next_words(folder))
        if again.returncode != 0:
            wrong.append(f"the next command ends with {again.returncode}: {again.stderr[-300:]}")
        elif scenario.bytes_in(folder) != expected:
            wrong.append("the next command gives other bytes")
    except subprocess.TimeoutExpired:
        wrong.append("the next command hangs")
    return ended.returncode, wrong


def counts_of(scenario, folder, shim):
    """Which calls there are without faults (of allocations the first of each stack of calls), and the results."""
    shutil.copytree(scenario.template, folder)
    ended = run(folder, scenario.words, LD_PRELOAD=shim, DROVER_FAULT_COUNT=str(folder / "counts"),
                **scenario.variables(folder))
    assert ended.returncode == 0, ended.stderr
    *lines, stacks = (folder / "counts").read_text().splitlines()
    numbers = {name: range(1, int(count) + 1) for name, count in map(str.split, lines)}
    return {**numbers, "malloc": sorted(map(int, stacks.split()[1:]))}, scenario.bytes_in(folder)


def faults_of(counts, call, every):
    for number in counts[call][::every or 1]:
        for error in ERRORS[call]:
            for how in ("once", "always"):
                if how == "once" or error not in NEVER_FOR_GOOD:
                    yield f"{call}:{number}:{error}:{how}"


def walk(shim, every=0, only="", report=print, most=None):
    """Tries all faults, or `most` of them for each call.  Returns the number of faults and of complaints."""
    faults = failures = 0
    with tempfile.TemporaryDirectory(prefix="drover-walk-") as place:
        for name in SCENARIOS:
            if only and only.split(":")[0] != name:
                continue
            scenario = Scenario(name, Path(place))
            counts, expected = counts_of(scenario, Path(place) / "whole", shim)
            shutil.rmtree(Path(place) / "whole")
            for call in ERRORS:
                if (":" in only and only.split(":")[1] != call) or (name == "film" and call == "malloc"):
                    continue  # the allocations of a film are those of Python and ffmpeg
                statuses = collections.Counter()
                tried = list(faults_of(counts, call, every))
                for fault in tried if most is None else tried[::-(-len(tried) // most) or 1]:
                    folder = Path(place) / "fault"
                    shutil.copytree(scenario.template, folder)
                    status, wrong = complaints(scenario, folder, expected, shim, fault)
                    shutil.rmtree(folder)
                    statuses[status] += 1
                    faults += 1
                    failures += bool(wrong)
                    for one in wrong:
                        report(f"{name} {fault}: {one}")
                report(f"{name} {call}: {len(counts[call])} calls, {sum(statuses.values())} faults, by status "
                       f"{dict(sorted(statuses.items(), key=str))}")
    return faults, failures


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("shim", type=os.path.abspath)
    parser.add_argument("--every", type=int, default=0)
    parser.add_argument("--only", default="")
    options = parser.parse_args()
    faults, failures = walk(options.shim, options.every, options.only, lambda line: print(line, flush=True))
    print(f"{faults} faults, {failures} complaints")
    return failures > 0


if __name__ == "__main__":
    sys.exit(main())
