"""tests/app/test_python_guards.py: the module in forked processes, in threads, and where calls below it fail."""
import os
import re
import subprocess
import sys
from pathlib import Path

import pytest
from support import SMALL, environment, slow_but

import drover
from drover import new_file

WALK = Path(__file__).resolve().parents[1] / "faults" / "walk_module.py"
SHIM = os.environ.get("DROVER_SHIM")
needs_shim = pytest.mark.skipif(not SHIM, reason="DROVER_SHIM is not set; ctest sets it")
# Loops of this grid are divided over both threads.
TWO_THREADS = {**SMALL, "time.end": 2.0, "grid.nx": 64, "grid.ny": 64, "run.threads": 2}
START = f"""
import multiprocessing, os, signal, threading, traceback
import drover
signal.alarm(50)
scene = drover.Scene.from_dict({TWO_THREADS!r})

def status_of_child(action):
    child = os.fork()
    if child == 0:
        signal.alarm(40)  # the signals of a parent are not those of its child
        try:
            os._exit(0 if action() else 1)
        except BaseException:
            traceback.print_exc()
            os._exit(2)
    return os.waitpid(child, 0)[1]

def reason_of(action):
    try:
        action()
        return ""
    except drover.Error as error:
        return str(error)
"""


def python(code, folder, **variables):
    """Runs Python code, of a file, which processes that are spawned read again."""
    (folder / "code.py").write_text(START + code)
    ended = subprocess.run([sys.executable, "code.py"], cwd=folder, capture_output=True, text=True, timeout=90,
                           env=environment(**variables), check=False)
    assert ended.returncode == 0, f"status {ended.returncode}: {ended.stderr[-3000:]}"
    return ended.stdout.split()


# --- arguments

@pytest.mark.parametrize("steps", [-1, 0, 1.5, "2"])
def test_a_number_of_steps_that_is_not_one_or_more_is_rejected(steps):
    run = drover.Scene.from_dict({"time": {"dt": 0.1, "end": 1.0}}).start()
    with pytest.raises(ValueError, match="expected a whole number, 1 or more") as raised:
        run.advance(steps=steps)
    assert isinstance(raised.value, drover.Error) and run.step == 0


# --- forks

def test_the_child_of_a_fork_advances_a_run_of_two_threads_to_the_same_bytes_and_frees_it(tmp_path):
    python("""
run, other = scene.start(), scene.start()
run.advance(steps=3), other.advance(steps=3)
expected = other.advance(steps=3).rod_density.tobytes()

def advance():
    return run.advance(steps=3).rod_density.tobytes() == expected

def free():
    global run
    del run
    return True

assert status_of_child(advance) == status_of_child(free) == status_of_child(lambda: advance() and free()) == 0
assert advance()
""", tmp_path)


@pytest.mark.parametrize("method", ["fork", "spawn", "forkserver"])
def test_processes_of_multiprocessing_run_scenes(method, tmp_path):
    python(f"""
def bytes_of(seed):
    own = scene.set("run.seed", seed)
    with own.run(f"{{seed}}.h5", overwrite=True) as run:
        assert (run.frames.rod_density[-1] == own.start().advance().rod_density).all()
        return run.frames.rod_density.values.tobytes()

if __name__ == "__main__":
    expected = [bytes_of(seed) for seed in (1, 2)]
    with multiprocessing.get_context({method!r}).Pool(2) as pool:
        assert pool.map(bytes_of, (1, 2)) == expected
""", tmp_path)


def test_a_run_that_another_thread_advances_during_a_fork_has_an_error_in_the_child(tmp_path):
    python("""
run = scene.set("time.end", 1e6).start()
threading.Thread(target=lambda: run._session.advance(10**6)).start()
while not reason_of(lambda: run.frame):
    pass
def is_error():
    return "when the process forked" in reason_of(lambda: run.advance(steps=1))
assert status_of_child(is_error) == 0
os._exit(0)
""", tmp_path)


def test_a_fork_within_a_call_of_hdf5_leaves_the_child_an_error(tmp_path):
    python("""
from drover.locks import hdf5
scene.run("a.h5").close()
begun, over = threading.Event(), threading.Event()
def hold():
    with hdf5():
        begun.set(), over.wait()
thread = threading.Thread(target=hold)
thread.start(), begun.wait()
def are_errors():
    return all("spawn" in reason_of(lambda: action("a.h5")) for action in (drover.open_run, drover.info))
assert status_of_child(are_errors) == 0
over.set(), thread.join()
assert status_of_child(lambda: drover.info("a.h5")) == 0
""", tmp_path)


def test_a_child_and_its_parent_read_an_open_archive(tmp_path):
    python("""
scene.run("a.h5").close()
run, other = drover.open_run("a.h5"), drover.open_run("a.h5")
expected = other.frames.rod_density.values.tobytes()
assert status_of_child(lambda: run.frames.rod_density.values.tobytes() == expected) == 0
assert run.frames.rod_density.values.tobytes() == expected
""", tmp_path)


# --- threads

def test_the_first_runs_may_be_started_by_several_threads_at_once(tmp_path):
    python("""
barrier, failures = threading.Barrier(5), []
def work(number):
    try:
        barrier.wait()
        scene.run(f"{number}.h5").close()
    except BaseException as error:
        failures.append(repr(error))
threads = [threading.Thread(target=work, args=(number,)) for number in range(5)]
for thread in threads:
    thread.start()
for thread in threads:
    thread.join()
assert not failures, failures
""", tmp_path)


def test_a_lock_finds_the_half_imported_h5py_of_another_thread(tmp_path):
    python("""
import sys, types
from importlib.machinery import ModuleSpec
from drover.locks import hdf5
begun, goes_on = threading.Event(), threading.Event()
class Slow:  # finds h5py first, and begins its import without an end
    def find_spec(self, name, path=None, target=None):
        return ModuleSpec(name, self) if name == "h5py" else None
    def create_module(self, spec):
        return None
    def exec_module(self, module):
        begun.set()
        goes_on.wait()
        module._objects = types.SimpleNamespace(phil=threading.RLock())
sys.meta_path.insert(0, Slow())
importing = threading.Thread(target=lambda: __import__("h5py"))
importing.start(), begun.wait()
entered = []
def enter():
    with hdf5():
        entered.append(True)
entering = threading.Thread(target=enter)
entering.start()
entering.join(0.5)  # it waits, and does not fail
goes_on.set()
importing.join(), entering.join()
assert entered
""", tmp_path)


# --- faults

@needs_shim
@pytest.mark.parametrize("only, most, within", slow_but([
    ("start:malloc", 12, "drover8numerics"),
    ("open:open", 4, "_drover."),
    ("open:pread", 40, "_drover."),
    ("run:pread", 3, "_drover."),
    ("restart:pread", 2, "_drover."),
], ("start:malloc", 12, "drover8numerics"), ("open:open", 4, "_drover.")))
def test_python_survives_a_failing_call_below_the_module(only, most, within):
    ended = subprocess.run([sys.executable, WALK, SHIM, "--only", only, "--most", str(most), "--within", within],
                           capture_output=True, text=True, timeout=300, env=environment(), check=False)
    assert ended.returncode == 0 and " 0 complaints" in ended.stdout, ended.stdout + ended.stderr


@needs_shim
def test_a_run_with_a_python_function_survives_a_disk_that_fails_for_good(tmp_path):
    """It has no process of its own: HDF5 must not crash when that of the user ends."""
    code = """
def force(order_x, order_y):
    return -0.1 * order_x, -0.1 * order_y
own = scene.set({"run.threads": 1, "grid.nx": 16, "grid.ny": 16, "time.end": 0.4}).term("order", force)
try:
    own.run("r.h5", overwrite=True).close()
    print("ran")
except (drover.Error, OSError) as error:
    print(type(error).__name__)
"""
    counts = tmp_path / "counts"
    python(code, tmp_path, LD_PRELOAD=SHIM, DROVER_FAULT_COUNT=str(counts), DROVER_FAULT_UNDER=str(tmp_path))
    count = next(int(line.split()[1]) for line in counts.read_text().splitlines() if line.startswith("pread "))
    found = [python(code, tmp_path, LD_PRELOAD=SHIM, DROVER_FAULT=f"pread:{n}:EIO:always",
                    DROVER_FAULT_UNDER=str(tmp_path))[0] for n in range(2, count + 1, -(-count // 4))]
    assert "Error" in found


def test_of_two_that_write_one_file_at_a_time_one_fails_and_the_file_is_whole(tmp_path):
    with pytest.raises(drover.Error, match="another process wrote this file at the same time"):
        with new_file.part_of(tmp_path / "film.mp4") as slow:
            slow.write_bytes(b"slow")
            new_file.write(tmp_path / "film.mp4", b"fast")
    assert (tmp_path / "film.mp4").read_bytes() == b"fast" and len(list(tmp_path.iterdir())) == 1


def isotropic(**more):
    return drover.Scene.from_dict({"time": {"dt": 0.1, "end": 1.0}, "output.sample_every": 0.1, **more})


@pytest.mark.parametrize("call, says", [
    (lambda: drover.sweep(isotropic(), ["relaxation.rate"]), "expected a dict"),
    (lambda: drover.sweep(isotropic(), {}, want="polar_order=2%"), "expected a dict"),
    (lambda: isotropic().set("grid.nx=32 #", 5), "the key 'grid.nx=32 #'"),
    (lambda: isotropic().run("a\0b.h5"), "has a zero byte"),
    (lambda: isotropic().states(follow=5), "follow = 5; expected a key and its last value"),
    (lambda: isotropic().boundary(("relaxation.rate", 1)), "expected a key with its first and last value"),
    (lambda: drover.Scene.from_dict({5: 5}), "the key 5"),
    (lambda: drover.Scene.parse(1), "expected TOML as text"),
    (lambda: drover.sweep("flock.toml", {"grid.nx": [8]}), "expected a drover.Scene"),
    (lambda: drover.fit("run.h5", ["relaxation.rate"], scene="flock.toml"), "expected a drover.Scene"),
    (lambda: drover.dynamic_structure_factor("run.h5", "order_x"), "expected an open one"),
    (lambda: drover.export("run.h5", "run.vtk", frame=1.5), "frame = 1.5"),
    (lambda: drover.tradeoff(isotropic(), "polar_order=1%", 3), 'expected a time, such as "20min"'),
    (lambda: drover.tradeoff(isotropic(), "polar_order", "3s"), "expected OBSERVABLE=ERROR"),
    (lambda: drover.tradeoff(isotropic(), ["polar_order=1%", "polar_order=2%"], "3s"), "given twice"),
    (lambda: drover.calibrate(isotropic(), budget="3s"), "without want; expected both"),
    (lambda: drover.calibrate(isotropic(), share=(3, 2)), "expected (i, n) with i from 1 to n"),
    (lambda: isotropic().stability(threads=-5), "expected 1 to 1024"),
    (lambda: isotropic().states(points=1), "2 or more"),
    (lambda: drover.film("run.h5", "run.gif", rate=60), "hundredths of a second"),
    (lambda: drover.film("run.h5", "run.png", rate=5), "expected no rate"),
    (lambda: drover.onset("table.h5", draws=5), "at least 20"),
    (lambda: drover.onset("table.h5", points=5), "points = 5; expected pairs"),
    (lambda: drover.fit("run.h5", 5), "keys = 5; expected names"),
    (lambda: drover.onset("table.h5", points=[(0.5, 0.1)]), "points apply to a cell"),
])
def test_arguments_that_the_program_rejects_are_rejected(call, says, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    with pytest.raises(drover.Error, match=re.escape(says)) as raised:
        call()
    assert raised.value.fault == "input" and list(tmp_path.iterdir()) == []
