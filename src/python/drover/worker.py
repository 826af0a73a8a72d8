"""drover/worker.py: `python3 -P -m drover.worker`: work that writes archives, in a process of its own.

A library that ends its process, as HDF5 and others do where memory is short, does not end that of the user then.
Sweeps and calibrations start processes by fork(), which is not safe in an interpreter with threads, such as that of a
notebook.
"""
import ctypes
import json
import os
import signal
import subprocess
import sys
from pathlib import Path

from drover.error import Error

PR_SET_PDEATHSIG = 1  # of Linux


def call(command, scene=None, **options):
    """Calls a function of _drover, with a scene if it takes one, in a process of its own; returns its result, a dict.

    Ctrl-C stops it after checkpoints; the same call resumes.
    """
    if scene is not None and scene._functions:
        from drover.functions import name_of
        names = ", ".join(name_of(held.function) for held in scene._functions.values())
        raise Error(f"a term of the scene is a Python function ({names}), "
                    f"which the processes of {command} do not have; write it as text, or run the scenes one by one: "
                    "for rate in rates: scene.set(key, rate).run(...)")
    request = {"command": command, "scene": None if scene is None else scene.__reduce__()[1], "options": options}
    package = str(Path(os.path.abspath(__file__)).parents[1])
    folders = [package, *filter(None, os.environ.get("PYTHONPATH", "").split(os.pathsep))]
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join(folders)}
    # -P, and no empty folder: modules in the current folder would come first.  A session of its own: signals of the
    # terminal reach it through this process alone, once.
    with subprocess.Popen([sys.executable, "-P", "-m", "drover.worker"], stdin=subprocess.PIPE, stdout=subprocess.PIPE,
                          stderr=subprocess.PIPE if options.get("quiet") else None, env=environment, text=True,
                          start_new_session=True) as process:
        try:
            output, log = process.communicate(json.dumps(request))
        except BaseException:
            process.send_signal(signal.SIGTERM)
            process.wait()
            raise
    try:
        result = json.loads(output.splitlines()[-1])
    except (IndexError, ValueError):
        reason = (log or "").strip()[-2000:] or "see its messages on standard error"
        raise Error(f"the worker process ended {how_it_ended(process.returncode)}: {reason}", fault="run") from None
    if "error" in result:
        raise Error(**result["error"])
    if result.get("signal"):
        raise Error(f"signal {result['signal']} stopped the run after a checkpoint; to resume: "
                    f"drover.restart({result['archive']!r})", fault="run")
    result["log"] = log or ""
    return result


def how_it_ended(status):
    return f"by signal {-status}" if status < 0 else f"with status {status}"


def main():
    from drover import _drover
    ctypes.CDLL(None).prctl(PR_SET_PDEATHSIG, signal.SIGTERM)  # stops, after checkpoints, when its parent is killed
    request = json.loads(sys.stdin.read())
    _drover.leave_signals_to_python(False)
    _drover.leave_hdf5_open()
    try:
        function = getattr(_drover, request["command"])
        scene = [_drover.Scene.parse(*request["scene"])] if request["scene"] else []
        result = function(*scene, **request["options"])
        print(result if isinstance(result, str) else json.dumps(result, default=os.fspath))
    except Error as error:
        message = str(error)[len(error.place) + 2:] if error.place else str(error)
        print(json.dumps({"error": {"message": message, "place": error.place, "fault": error.fault}}))
    except MemoryError:
        print(json.dumps({"error": {"message": "not enough memory; choose a smaller grid or cell, or free memory",
                                    "fault": "run"}}))


if __name__ == "__main__":
    main()
