"""tests/faults/kills.py: commands that are killed (kill -9) at random times, alone or with their workers.

    DROVER=build/release/drover python3 tests/faults/kills.py [--count 100] [--only SCENARIO] [--seed 1]

After each kill the next command, given at once, must end with status 0, without a word of damage, and with the bytes of
a run that was not killed.  Scenarios: run, restart, sweep and calibrate of walk.py, and particles.  (tests/app/crash.py
checks in addition, for a run of fields, what other readers find after each kill.)
"""
import argparse
import os
import random
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from pathlib import Path

from mutants import GRAINS
from walk import DROVER, Scenario, environment, run, write_scene


class Particles(Scenario):
    """A run of particles."""

    def __init__(self, folder):  # pylint: disable=super-init-not-called
        self.name, self.template = "run", folder / "particles"
        self.template.mkdir()
        write_scene(self.template, {**GRAINS, "output.checkpoint_minutes": 0.0}, name="s.toml", base={})
        self.words, self.results = ["run", "s.toml", "--quiet", "-o", "r.h5"], ["r.h5"]


def kill(folder, words, delay, alone):
    """Whether the kill hit the command while it ran."""
    process = subprocess.Popen([DROVER, *words], cwd=folder, stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL,
                               stderr=subprocess.DEVNULL, env=environment(), start_new_session=True)
    time.sleep(delay)
    met = process.poll() is None
    if alone:
        process.kill()
    elif met:
        os.killpg(process.pid, signal.SIGKILL)
    process.wait()
    return met


def storm(scenario, place, count, dice):
    """Returns the number of kills that hit and the complaints."""
    whole = place / "whole"
    shutil.copytree(scenario.template, whole)
    start = time.monotonic()
    ended = run(whole, scenario.words)
    assert ended.returncode == 0, ended.stderr
    duration, expected = time.monotonic() - start, scenario.bytes_in(whole, ended.stdout)
    shutil.rmtree(whole)
    hits, wrong = 0, []
    for number in range(count):
        folder = place / "killed"
        shutil.copytree(scenario.template, folder)
        words = scenario.words
        for _ in range(dice.randint(1, 3)):
            hits += kill(folder, words, dice.uniform(0.0, 1.1 * duration), dice.random() < 0.5)
            words = scenario.next_words(folder)
        again = run(folder, words)
        if again.returncode != 0 or "damaged" in again.stderr:
            wrong.append(f"kill {number}: {' '.join(words)} ends with {again.returncode}: {again.stderr[-300:]}")
        elif scenario.bytes_in(folder, again.stdout) != expected:
            wrong.append(f"kill {number}: other bytes")
        shutil.rmtree(folder)
    return hits, wrong


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--count", type=int, default=100)
    parser.add_argument("--only", default="")
    parser.add_argument("--seed", type=int, default=1)
    options = parser.parse_args()
    bad = 0
    for name in ("run", "restart", "sweep", "calibrate", "particles"):
        if options.only and options.only != name:
            continue
        with tempfile.TemporaryDirectory(prefix="drover-kills-") as place:
            scenario = Particles(Path(place)) if name == "particles" else Scenario(name, Path(place))
            hits, wrong = storm(scenario, Path(place), options.count, random.Random(options.seed))
        print("\n".join([*wrong, f"{name}: {hits} kills, {len(wrong)} complaints"]), flush=True)
        bad += len(wrong)
    return bad > 0


if __name__ == "__main__":
    sys.exit(main())
