#!/usr/bin/python3
"""tests/bench/ratios.py: ratios of costs of the field solver, compared with those listed in README.md beside this file.

    ratios.py build/release/tests/drover_bench            exit status 1 if a ratio is more than a fifth above its value
    ratios.py build/release/tests/drover_bench --keep     writes the measured ratios to README.md

Each ratio is the median of seven, whose two times were measured in one process.
"""
import argparse
import json
import re
import statistics
import subprocess
import sys
from pathlib import Path

README = Path(__file__).parent / "README.md"
# The two benchmarks of tests/bench/step.cpp of each ratio.
RATIOS = {"step / transforms": ("flock_step_without_noise", "flock_transforms"),
          "noisy step / step": ("flock_step", "flock_step_without_noise"),
          "start-up / noisy step": ("flock_start", "flock_step"),
          "frame / step": ("flock_frame", "flock_step_without_noise")}
TOLERANCE = 1.2
REPETITIONS = 7


def row_of(name):
    """The pattern of a row of the table of README.md: its beginning and its value."""
    return re.compile(rf"^(\| {re.escape(name)} \| )([0-9.]+)", re.MULTILINE)


def milliseconds(program):
    """One measurement of each benchmark at 256 by 256 points on one thread."""
    names = "|".join(sorted({name for pair in RATIOS.values() for name in pair}))
    found = subprocess.run([program, f"--benchmark_filter=^({names})/n:256/threads:1/", "--benchmark_format=json",
                            "--benchmark_min_time=0.2"], capture_output=True, text=True, check=True)
    return {row["name"].split("/")[0]: row["real_time"] for row in json.loads(found.stdout)["benchmarks"]}


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("program")
    parser.add_argument("--keep", action="store_true", help="write the ratios to README.md")
    words = parser.parse_args()
    times = [milliseconds(words.program) for _ in range(REPETITIONS)]
    text, is_worse = README.read_text(encoding="utf-8"), False
    print(f"{'ratio':24} {'measured':>8} {'listed':>8}")
    for name, (above, below) in RATIOS.items():
        ratio = statistics.median(row[above] / row[below] for row in times)
        listed = float(row_of(name).search(text)[2])
        fails = ratio > TOLERANCE * listed
        print(f"{name:24} {ratio:8.3g} {listed:8.3g}  {'worse' if fails else 'ok'}")
        text = row_of(name).sub(rf"\g<1>{ratio:.3g}", text)
        is_worse = is_worse or fails
    if words.keep:
        README.write_text(text, encoding="utf-8")
        return 0
    return 1 if is_worse else 0


if __name__ == "__main__":
    sys.exit(main())
