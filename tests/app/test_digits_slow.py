"""tests/app/test_digits_slow.py: tables print no digit that their error bar or the rounding of doubles cannot support.

Each command runs under the four rounding modes of IEEE 754.  A number may differ between them by one unit of its last
digit, since that digit is rounded.
"""
import os
import re
import subprocess

import pytest
from support import DROVER, MODELS, settings

SHIM = os.environ.get("DROVER_ROUNDING_SHIM", "")
MODES = ("nearest", "up", "down", "zero")
NUMBER = re.compile(r"(?<![\w.])[-+]?\d+(?:\.\d+)?(?:e[-+]?\d+)?(?![\w.])")
# Particle runs end before the bodies' chaos has made the modes differ: a few impacts of each body.
COMMANDS = {
    "isotropic": ("run", "isotropic", "grid.nx=32", "grid.ny=32", "time.end=20", "analysis.warm_up=0"),
    "flock": ("run", "flock", "grid.nx=32", "grid.ny=32", "time.end=60", "analysis.warm_up=0",
              "output.sample_every=0.1"),
    "band": ("run", "band", "time.end=10", "analysis.warm_up=0"),
    "quench": ("run", "quench", "grid.nx=64", "grid.ny=64", "time.end=10", "analysis.warm_up=0"),
    "barenblatt": ("run", "barenblatt", "grid.nx=64", "grid.ny=64", "time.end=1", "analysis.warm_up=0"),
    "bead-gas": ("run", "bead-gas", "cell.lx=8", "cell.ly=8", "time.end=0.02", "output.sample_every=0.0025",
                 "output.frame_every=0.0"),
    "rod": ("run", "rod", "time.end=0.02", "output.sample_every=0.0025", "output.frame_every=0.0"),
    "stability": ("stability", "flock"),
    "boundary": ("boundary", "phase-boundary"),
    "explain": ("explain", "flock"),
    "states of a band": ("states", "band", "--wave", "x", "grid.nx=256", "grid.ny=8"),
    "states of a kink": ("states", "kink", "--wave", "x"),
}


def output_of(mode, folder, command, model, *keys):
    words = [word for word in keys if word.startswith("-") or "=" not in word]
    keys = settings(key for key in keys if "=" in key)
    if command == "run":
        words = ["--quiet", "--overwrite", *settings(['output.file="run.h5"', "run.threads=2"])]
    environment = {**os.environ, "LD_PRELOAD": SHIM, "ROUNDING": mode}
    ended = subprocess.run([DROVER, command, MODELS / f"{model}.toml", *words, *keys], cwd=folder, text=True,
                           capture_output=True, env=environment, check=False, timeout=600)
    assert ended.returncode == 0, ended.stderr
    # The size of the archive and the times of the run are measurements of the machine.
    return [line for line in ended.stdout.splitlines() if not re.search(r"\.h5: |^wall time", line)]


def unit_of(number):
    """One unit of the last digit of a number."""
    digits, _, power = number.partition("e")
    return 10.0**(int(power or 0) - len(digits.partition(".")[2]))


def beyond_rounding(lines):
    """Lines whose numbers differ by more than a unit of their last digit."""
    for same in zip(*lines, strict=True):
        texts = {NUMBER.sub("#", line).split() == NUMBER.sub("#", same[0]).split() for line in same}
        if texts != {True}:
            yield same
            continue
        for numbers in zip(*(NUMBER.findall(line) for line in same), strict=True):
            values = [float(number) for number in numbers]
            unit = max(unit_of(number) for number in numbers)
            if max(values) - min(values) > 1.001 * unit:
                yield same
                break


def beyond_errors(lines):
    """Rows of tables in which a number has more digits than its error, in the column "error" after it."""
    columns = []
    for line in lines:
        if found := [match.end() for match in re.finditer(r"\berror\b", line)]:
            columns = found
            continue
        words = [(match.group(), match.end()) for match in re.finditer(r"\S+", line)]
        for (value, _), (error, end) in zip(words, words[1:]):
            if end in columns and NUMBER.fullmatch(value) and NUMBER.fullmatch(error) and float(error) > 0.0:
                if unit_of(value) < 0.99 * unit_of(f"{float(error):.1e}"):
                    yield line


@pytest.mark.parametrize("name", COMMANDS)
def test_a_table_prints_no_digit_that_its_error_or_rounding_does_not_support(tmp_path, name):
    assert SHIM, "DROVER_ROUNDING_SHIM is not set; expected the library of tests/digits/rounding.cpp"
    outputs = [output_of(mode, tmp_path, *COMMANDS[name]) for mode in MODES]
    assert any(NUMBER.search(line) for line in outputs[0])
    assert not list(beyond_errors(outputs[0]))
    different = list(beyond_rounding(outputs))
    assert not different, "\n".join(line for lines in different[:5] for line in lines)
