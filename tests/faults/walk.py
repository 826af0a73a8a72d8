"""tests/faults/walk.py: makes every call of a short command fail in turn, and checks what the program makes of it.

    DROVER=build/release/drover python3 tests/faults/walk.py SHIM [--every N] [--only SCENARIO[:CALL]] [--once ERROR]

For each scenario (SCENARIOS), each call (see shim.cpp), each of its errors, once or for good, and each n (for malloc,
with DROVER_FAULT_WITHIN: each n whose innermost calls are new): a command ends with status 0, 1 or 2 within a
minute and by no signal, but for that of FFTW's planner; a failure has one sentence, not "bug in drover"; after status 0
the results have the bytes of a run without faults; the archive of a result is there complete or not at all; and the
next command, without a fault, ends with status 0 and those bytes.  A command without a file of results has its standard
output in place of bytes.
"""
import argparse
import collections
import os
import shutil
import signal
import subprocess
import sys
import tempfile
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "app"))
from calibration import write_plausible  # noqa: E402
from support import DROVER, MODELS, contents, environment, write_scene  # noqa: E402

TINY = {"relaxation.rate": 0.5, "noise.order": 0.05, "noise.rods": 0.5, "diffusion.rods": 0.2,
        "uniform.rod_density": 2.0, "elasticity.stiffness": 2.0, "grid.nx": 8, "grid.ny": 8, "grid.lx": 8.0,
        "grid.ly": 8.0, "time.dt": 0.1, "time.end": 0.4, "initial.kind": "random", "initial.amplitude": 0.1,
        "output.frame_every": 0.2, "output.sample_every": 0.1, "output.checkpoint_minutes": 0.0, "run.seed": 7,
        "run.threads": 1}
ERRORS = {"read": ["EIO", "ESTALE", "short", "EINTR"], "write": ["ENOSPC", "EIO", "short", "EINTR"],
          "pwrite": ["ENOSPC", "EIO", "EDQUOT", "short", "EINTR"], "pread": ["EIO", "ESTALE", "short", "EINTR"],
          "fsync": ["EIO", "ENOSPC", "EINTR"], "rename": ["EIO", "ENOSPC"],
          "link": ["EIO", "ENOSPC"], "ftruncate": ["EIO", "EINTR"],
          "open": ["EIO", "EINTR", "ENOSPC"], "malloc": ["ENOMEM"]}
SCENARIOS = ("run", "restart", "sweep", "calibrate", "tradeoff", "film", "figure", "check", "fit", "info", "stability",
             "states", "boundary")
IN_PYTHON = ("film", "figure")  # Python and ffmpeg: their calls are made to fail on the files of the folder only
CALIBRATED = {"fields.bead_density": True, "fields.bead_velocity": "dynamic", "current.kind": "density-order",
              "calibrated.table": "table.h5", "calibrated.bead_area_fraction": 0.5,
              "calibrated.rod_area_fraction": 0.08, "grid.lx": 45.0, "grid.ly": 45.0, "time.dt": 0.05}
NEVER_FOR_GOOD = ("EINTR",)  # a call that is interrupted for good is rightly repeated for good


def calibration_scene(folder):
    """One assay at one point, of a few short trials."""
    text = (MODELS / "calibrate-small.toml").read_text().replace("bead_area_fractions = [0.5, 0.65]",
                                                                "bead_area_fractions = [0.5]\nassays = [\"damping\"]")
    text = text.replace("[calibrate.damping]\ntime = 3.0", "[calibrate.damping]\ntime = 0.4")
    text = text.replace("max_trials = 24", "max_trials = 8").replace("lx = 13.5\nly = 13.5", "lx = 6.0\nly = 6.0")
    (folder / "calibrate.toml").write_text(text)


def calibrated_scene(folder):
    """Fields with a table of coefficients, which start from an archive."""
    write_plausible(folder / "table.h5")
    keys = {**TINY, **CALIBRATED}
    for key in [key for key in keys if key.split(".")[0] in ("relaxation", "noise", "diffusion", "uniform",
                                                             "elasticity")]:
        del keys[key]
    write_scene(folder, keys, name="s.toml", base={})
    run(folder, ["run", "s.toml", "--quiet", "-o", "start.h5"])
    write_scene(folder, {**keys, "initial.kind": "file", "initial.file": "start.h5"}, name="s.toml", base={})


class Scenario:
    """A command, what is there before it, the next commands after a failure, and the files that must be equal."""

    def __init__(self, name, folder):
        self.name, self.template = name, folder / name
        self.template.mkdir()
        getattr(self, "prepare_" + name, self.prepare_run)()

    def prepare_run(self):
        write_scene(self.template, TINY, name="s.toml", base={})
        self.words, self.results = ["run", "s.toml", "--quiet", "-o", "r.h5"], ["r.h5"]

    def prepare_restart(self):
        self.prepare_run()
        run(self.template, [*self.words, "--set", "time.end=0.2"])
        self.words = ["restart", "r.h5", "--quiet", "--set", "time.end=0.4"]

    def prepare_sweep(self):
        write_scene(self.template, {**TINY, "sweep.workers": 1, "sweep.vary": ["relaxation.rate = 0.5, 1"]},
                    name="s.toml", base={})
        self.words = ["sweep", "s.toml", "--quiet", "-o", "swept"]
        self.results = ["swept/point-0000-seed-7.h5", "swept/point-0001-seed-7.h5"]

    def prepare_calibrate(self):
        calibration_scene(self.template)
        self.words = ["calibrate", "calibrate.toml", "--workers", "1", "--quiet", "-o", "trials"]
        self.results = ["trials/table.h5"]

    def prepare_tradeoff(self):
        """Its result depends on times, so that the bytes are those of the recorded scene."""
        write_scene(self.template, {**TINY, "relaxation.rate": -0.5, "relaxation.saturation": 1.0, "noise.order": 0.0,
                                    "noise.rods": 0.0, "initial.kind": "formula", "initial.polar_order_x": "0.3",
                                    "time.end": 4.0}, name="s.toml", base={})
        self.words = ["tradeoff", "s.toml", "--want", "polar_order=5%", "--budget", "20s", "--workers", "1", "--quiet",
                      "-o", "trials"]
        self.results = ["trials/scene.toml"]

    def prepare_film(self):
        self.prepare_run()
        run(self.template, self.words)
        self.words, self.results = ["film", "r.h5", "-o", "r.mp4"], ["r.mp4"]

    def prepare_figure(self):
        self.prepare_film()
        self.words, self.results = ["r.h5", "-o", "r.png"], ["r.png"]

    def prepare_check(self):
        calibrated_scene(self.template)
        self.words, self.results = ["check", "s.toml", "--resolved"], []

    def prepare_info(self):
        self.prepare_run()
        run(self.template, self.words)
        self.words, self.results = ["info", "r.h5", "--json"], []

    def prepare_fit(self):
        write_scene(self.template, {**TINY, "time.end": 40.0, "output.frame_every": 0.5}, name="s.toml", base={})
        run(self.template, ["run", "s.toml", "--quiet", "-o", "r.h5"])
        self.words, self.results = ["fit", "r.h5", "relaxation.rate", "noise.order", "--json"], []

    def prepare_stability(self):
        write_scene(self.template, {**TINY, "stability.wavenumbers": 8, "stability.angles": 4}, name="s.toml", base={})
        self.words, self.results = ["stability", "s.toml", "-o", "x.h5", "--overwrite"], ["x.h5"]

    def prepare_boundary(self):
        write_scene(self.template, {**TINY, "boundary.map": 3}, name="s.toml", base={})
        self.words = ["boundary", "s.toml", "--x", "relaxation.rate = 0.5:1", "--y", "uniform.rod_density = 1:2", "-o",
                      "x.h5", "--overwrite"]
        self.results = ["x.h5"]

    def prepare_states(self):
        shutil.copy(MODELS / "band.toml", self.template / "s.toml")
        self.words = ["states", "s.toml", "--wave", "x", "--set", "grid.nx=256", "--set", "grid.ny=8", "-o", "x.h5",
                      "--overwrite"]
        self.results = ["x.h5"]

    @property
    def program(self):
        return [sys.executable, "-m", "drover.figure"] if self.name == "figure" else [DROVER]

    def left_incomplete(self, folder, expected):
        """Whether a result that appears complete or not at all is there in part."""
        return ("x.h5" in self.results and (folder / "x.h5").exists() and
                (not is_hdf5(folder / "x.h5") or self.bytes_in(folder, "") != expected))

    def next_words(self, folder):
        if self.name == "run":
            archive = folder / "r.h5"
            if any(Path(f"{archive}.checkpoint-{letter}").exists() for letter in "ab"):
                return ["restart", "r.h5", "--quiet"]
            return [*self.words, "--overwrite"]
        return self.words

    def variables(self, folder):
        return {"DROVER_FAULT_UNDER": str(folder)} if self.name in IN_PYTHON else {}

    def bytes_in(self, folder, printed):
        if not self.results:
            return printed
        return [contents(folder / name) if name.endswith(".h5") else (folder / name).read_bytes()
                for name in self.results]


def is_hdf5(file):
    with open(file, "rb") as stream:
        return stream.read(4) == b"\x89HDF"


def run(folder, words, program=(DROVER,), **variables):
    """Runs the program; the errors of a command that is not done within a minute are those of subprocess."""
    return subprocess.run([*program, *words], cwd=folder, capture_output=True, text=True, errors="replace", check=False,
                          stdin=subprocess.DEVNULL, timeout=60, env=environment(**variables))


def complaints(scenario, folder, expected, shim, fault):
    """What is wrong after one fault, as a list of texts."""
    try:
        ended = run(folder, scenario.words, scenario.program, LD_PRELOAD=shim, DROVER_FAULT=fault,
                    **scenario.variables(folder))
    except subprocess.TimeoutExpired:
        return None, ["the command hangs"]
    wrong = []
    if ended.returncode == -signal.SIGABRT and "fftw: " in ended.stderr:
        pass  # FFTW's planner ends its process where it finds no memory
    elif ended.returncode not in (0, 1, 2):
        wrong.append(f"status {ended.returncode}: {ended.stderr[-300:]}")
    elif ended.returncode == 0 and scenario.bytes_in(folder, ended.stdout) != expected:
        wrong.append("status 0 and other bytes")
    elif ended.returncode != 0 and scenario.left_incomplete(folder, expected):
        wrong.append("an incomplete result under its final name")
    elif ended.returncode != 0 and not any(sign in ended.stderr for sign in ("error: ", "warning: ")):
        wrong.append("no sentence")
    if "bug in drover" in ended.stderr:
        wrong.append(f"called a bug: {ended.stderr[-300:]}")
    try:
        again = run(folder, scenario.next_words(folder), scenario.program)
        if again.returncode != 0:
            wrong.append(f"the next command ends with {again.returncode}: {again.stderr[-300:]}")
        elif scenario.bytes_in(folder, again.stdout) != expected:
            wrong.append("the next command gives other bytes")
    except subprocess.TimeoutExpired:
        wrong.append("the next command hangs")
    return ended.returncode, wrong


def counts_of(scenario, folder, shim):
    """Which calls there are without faults (of allocations the first of each stack of calls), and the results."""
    shutil.copytree(scenario.template, folder)
    ended = run(folder, scenario.words, scenario.program, LD_PRELOAD=shim, DROVER_FAULT_COUNT=str(folder / "counts"),
                **scenario.variables(folder))
    assert ended.returncode == 0, ended.stderr
    *lines, stacks = (folder / "counts").read_text().splitlines()
    numbers = {name: range(1, int(count) + 1) for name, count in map(str.split, lines)}
    return {**numbers, "malloc": sorted(map(int, stacks.split()[1:]))}, scenario.bytes_in(folder, ended.stdout)


def fails_in(name):
    """Whether allocations of a scenario fail: not those of Python and ffmpeg, nor those of HDF5 1.10, which crashes."""
    return name not in IN_PYTHON and "DROVER_FAULT_WITHIN" in os.environ


def faults_of(counts, call, every, once=""):
    for number in counts[call][::every or 1]:
        for error in [once] if once else ERRORS[call]:
            for how in ("once",) if once else ("once", "always"):
                if how == "once" or error not in NEVER_FOR_GOOD:
                    yield f"{call}:{number}:{error}:{how}"


def walk(shim, every=0, only="", report=print, most=None, once=""):
    """Tries all faults, or `most` of them for each call; `once`: each n with this error, once.  Returns the number of
    faults and of complaints.
    """
    faults = failures = 0
    with tempfile.TemporaryDirectory(prefix="drover-walk-") as place:
        for name in SCENARIOS:
            if only and only.split(":")[0] != name:
                continue
            scenario = Scenario(name, Path(place))
            counts, expected = counts_of(scenario, Path(place) / "whole", shim)
            shutil.rmtree(Path(place) / "whole")
            for call in ERRORS:
                if (":" in only and only.split(":")[1] != call) or (call == "malloc" and not fails_in(name)):
                    continue
                statuses = collections.Counter()
                tried = list(faults_of(counts, call, every, once))
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
    parser.add_argument("--once", default="", metavar="ERROR", help="each n once, with this error alone")
    options = parser.parse_args()
    faults, failures = walk(options.shim, options.every, options.only, lambda line: print(line, flush=True),
                            once=options.once)
    print(f"{faults} faults, {failures} complaints")
    return failures > 0


if __name__ == "__main__":
    sys.exit(main())
