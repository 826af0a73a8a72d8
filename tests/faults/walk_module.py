"""tests/faults/walk_module.py: makes every call below the Python module fail in turn, and checks what Python sees.

    DROVER=build/release/drover PYTHONPATH=build/release/python \\
        python3 tests/faults/walk_module.py SHIM [--every N] [--most N] [--only SCENARIO[:CALL]] [--within NAME]

Each fault is one of walk.py, in a process that runs a scene, starts a run in memory, sweeps, opens an archive or
restarts: in calls on the files of its folder, and in allocations with the module among the innermost calls (each n
with new ones, and some 200 more), there and in the processes that the module starts.  The process ends with status 0
within two minutes, unless FFTW's planner ends it.  Each of its two tries gives the data of a process without faults,
raises drover.Error, OSError or MemoryError with a sentence, or warns of a point of the sweep that failed.  Then a
process without faults gives the data.  --within: allocations within another library.
"""
import argparse
import collections
import ctypes
import gc
import hashlib
import json
import os
import shutil
import signal
import sys
import tempfile
import traceback
import warnings
from pathlib import Path

import drover
import drover._drover  # all modules, before the faults
import drover.archive
import drover.sweeping  # noqa: F401

sys.path.insert(0, str(Path(__file__).resolve().parent))
from walk import ERRORS, TINY, faults_of, run, write_scene  # noqa: E402

SECONDS = 120
COUNTED_BY_FILE = [call for call in ERRORS if call != "malloc"]


def digest(*datasets):
    one = hashlib.sha256()
    for data in datasets:
        for name in sorted(map(str, data)):
            one.update(name.encode() + data[name].values.tobytes())
    return one.hexdigest()


def digest_of_archive(archive):
    with archive:
        return digest(archive.frames, archive.observables)


def start(scene):
    run_in_memory = scene.set("run.threads", 2).start()
    run_in_memory.advance()
    return digest(run_in_memory.frame.to_xarray(), run_in_memory.observables)


def sweep(scene):
    return digest(drover.sweep(scene, {"relaxation.rate": [0.5, 1.0]}, folder="swept", workers=1).data)


SCENARIOS = {"run": lambda scene: digest_of_archive(scene.run("r.h5", overwrite=True)),
             "start": start,
             "sweep": sweep,
             "open": lambda _: digest_of_archive(drover.open_run("r.h5")),
             "restart": lambda _: digest_of_archive(drover.restart("r.h5", end=0.4))}


def try_once(scenario):
    try:
        return {"data": SCENARIOS[scenario](drover.Scene.load("s.toml"))}
    except (drover.Error, OSError, MemoryError, UserWarning) as error:
        return {"raised": type(error).__name__, "message": str(error)}
    except Exception as error:  # pylint: disable=broad-exception-caught
        return {"unexpected": repr(error)}


def make_template(scenario, folder):
    """What is there before."""
    folder.mkdir()
    write_scene(folder, TINY, name="s.toml", base={})
    if scenario in ("open", "restart"):
        end = "0.2" if scenario == "restart" else "0.4"
        assert run(folder, ["run", "s.toml", "--quiet", "-o", "r.h5", "--set", f"time.end={end}"]).returncode == 0


def child(scenario, folder, variables, tries):
    """Tries in a fork of this process, which has loaded all modules; returns the status and what it wrote."""
    files = [folder.parent / name for name in ("out", "err")]
    process = os.fork()
    if process == 0:
        libc = ctypes.CDLL(None)
        try:
            signal.alarm(SECONDS)
            for number, file in enumerate(files, 1):
                os.dup2(os.open(file, os.O_WRONLY | os.O_CREAT | os.O_TRUNC, 0o666), number)
            os.chdir(folder)
            warnings.simplefilter("error", UserWarning)
            os.environ.update(variables)
            libc.drover_fault_begin()
            outcomes = [try_once(scenario) for _ in range(tries)]
            gc.collect()
            print(json.dumps(outcomes), flush=True)
            libc.exit(0)  # with the functions that libraries call at the end
        except BaseException:  # pylint: disable=broad-exception-caught
            traceback.print_exc()
        libc.exit(3)
    status = os.waitstatus_to_exitcode(os.waitpid(process, 0)[1])
    return (status, *(file.read_text(errors="replace") if file.exists() else "" for file in files))


def variables_for(call, folder, within):
    return {"DROVER_FAULT_WITHIN": within} if call == "malloc" else {"DROVER_FAULT_UNDER": str(folder)}


def counts_of(scenario, template, folder, within):
    """Which calls there are without faults, as in walk.counts_of, and the data."""
    counts = {}
    for calls in (COUNTED_BY_FILE, ["malloc"]):
        shutil.copytree(template, folder)
        file = folder.parent / "counts"
        status, out, err = child(scenario, folder, {"DROVER_FAULT_COUNT": str(file),
                                                    **variables_for(calls[0], folder, within)}, 2)
        assert status == 0 and "data" in json.loads(out)[0], (status, out, err)
        *lines, stacks = file.read_text().splitlines()
        numbers = {name: range(1, int(count) + 1) for name, count in map(str.split, lines)}
        spread = numbers["malloc"][::len(numbers["malloc"]) // 200 or 1]  # the stacks are those of this process alone
        numbers["malloc"] = sorted({*map(int, stacks.split()[1:]), *spread})
        counts.update({call: numbers[call] for call in calls})
        file.unlink()
        shutil.rmtree(folder)
    return counts, json.loads(out)[0]["data"]


def complaints_about(status, out, err, expected):
    if status == -signal.SIGABRT and "fftw: " in err:
        return []  # FFTW's planner ends its process where it finds no memory
    if status != 0:
        return [f"status {status}: {err[-300:]}"]
    wrong = []
    for one in json.loads(out.splitlines()[-1]):
        if "unexpected" in one:
            wrong.append(f"raises {one['unexpected'][-300:]}")
        elif one.get("data", expected) != expected:
            wrong.append("other data")
        elif "raised" in one and (not one["message"] or "bug in drover" in one["message"]):
            wrong.append(f"{one['raised']} without a sentence: {one['message'][-300:]}")
    return wrong


def try_fault(scenario, template, folder, expected, fault, within):
    """The outcome of the first try, in a word, and what is wrong, as a list of texts."""
    shutil.copytree(template, folder)
    ended = child(scenario, folder, {"DROVER_FAULT": fault, **variables_for(fault.split(":")[0], folder, within)}, 2)
    wrong = complaints_about(*ended, expected)
    if scenario not in ("start", "open"):  # which write nothing
        again = child(scenario, folder, {}, 1)
        wrong += [f"then, without a fault: {one}" for one in complaints_about(*again, expected)]
        if again[0] == 0 and "data" not in json.loads(again[1])[0]:
            wrong.append(f"then, without a fault: {again[1][:300]}")
    shutil.rmtree(folder)
    first = json.loads(ended[1].splitlines()[-1])[0] if ended[0] == 0 else {"raised": f"status {ended[0]}"}
    return first.get("raised", "unexpected" if "unexpected" in first else "data"), wrong


def walk(every, only, most, within):
    """Tries all faults, or `most` of them for each call.  Returns the number of faults and of complaints."""
    faults = failures = 0
    with tempfile.TemporaryDirectory(prefix="drover-walk-") as place:
        for scenario in SCENARIOS:
            if only and only.split(":")[0] != scenario:
                continue
            template, folder = Path(place) / scenario, Path(place) / "fault"
            make_template(scenario, template)
            counts, expected = counts_of(scenario, template, folder, within)
            for call in ERRORS:
                if ":" in only and only.split(":")[1] != call:
                    continue
                outcomes = collections.Counter()
                tried = list(faults_of(counts, call, every))
                for fault in tried if most is None else tried[::-(-len(tried) // most) or 1]:
                    outcome, wrong = try_fault(scenario, template, folder, expected, fault, within)
                    outcomes[outcome] += 1
                    faults += 1
                    failures += bool(wrong)
                    for one in wrong:
                        print(f"{scenario} {fault}: {one}", flush=True)
                print(f"{scenario} {call}: {len(counts[call])} calls, {sum(outcomes.values())} faults, "
                      f"{dict(sorted(outcomes.items()))}", flush=True)
    return faults, failures


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("shim", type=os.path.abspath)
    parser.add_argument("--every", type=int, default=0)
    parser.add_argument("--most", type=int)
    parser.add_argument("--only", default="")
    parser.add_argument("--within", default="_drover.")
    options = parser.parse_args()
    if os.environ.get("LD_PRELOAD") != options.shim:
        os.execve(sys.executable, [sys.executable, *sys.argv], {**os.environ, "LD_PRELOAD": options.shim})
    faults, failures = walk(options.every, options.only, options.most, options.within)
    print(f"{faults} faults, {failures} complaints")
    return failures > 0


if __name__ == "__main__":
    sys.exit(main())
