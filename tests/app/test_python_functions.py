"""tests/app/test_python_functions.py: Python functions as terms: equal texts, exact rates, functions that fail."""
import inspect
import linecache
import signal
import subprocess
import sys
import threading
import time
import warnings

import numpy as np
import pytest
from support import assert_same_bytes, drover as program, environment
from test_python_module import interrupt_soon

import drover

BASE = {"relaxation.rate": 0.5, "elasticity.stiffness": 0.5, "diffusion.rods": 0.3, "pressure.rods": 0.5,
        "noise.order": 0.05, "grid.nx": 16, "grid.ny": 16, "grid.lx": 16.0, "grid.ly": 16.0, "time.dt": 0.05,
        "time.end": 2.0, "output.frame_every": 1.0, "output.sample_every": 0.5, "run.seed": 3}
QUIET = {**BASE, "relaxation.rate": 0.0, "elasticity.stiffness": 0.0, "noise.order": 0.0, "initial.kind": "formula"}


def scene_of(**changes):
    return drover.Scene.from_dict({**BASE, **changes})


def saturate(order_x, order_y, rod_density, W=0.7):
    """Cubic, times a density: of degree 4."""
    slow = -W * rod_density * (order_x**2 + order_y**2)
    return slow * order_x, slow * order_y


def tilt(order_x, order_y, W):
    return -W * order_y, W * order_x


SATURATE_TEXT = ["-W rod_density (order_x^2 + order_y^2) order_x", "-W rod_density (order_x^2 + order_y^2) order_y"]


def close(one, other):
    # The texts' linear parts are taken exactly by the propagator, those of functions by differences: the sum of
    # propagator and remainder is the same up to rounding, over 40 steps.
    scale = max(np.abs(other.rod_density).max(), np.abs(other.polar_order_x).max())
    return max(np.abs(one[name] - other[name]).max() for name in other.arrays) < 1e-12 * scale


# --- equal to texts

@pytest.mark.parametrize("function, text, degree", [
    (saturate, SATURATE_TEXT, 4),
    (lambda order_x, order_y, W=0.7: (-W * order_y, W * order_x), ["-W order_y", "W order_x"], 1),
    (lambda order_x, d_x_order_x, d_y_rod_density, W=0.7: (-W * order_x * d_x_order_x, W * order_x * d_y_rod_density),
     ["-W order_x d_x order_x", "W order_x d_y rod_density"], 2),
    (lambda lap_order_x, div_order, grad_div_y_order, W=0.7: (W * lap_order_x, W * grad_div_y_order + 0 * div_order),
     ["W lap order_x", "W grad_div_y order"], 1),
    (lambda order_x, x, y, t, W=0.7: (W * np.cos(np.pi * x / 8) * np.sin(np.pi * y / 8), -W * t * order_x),
     ["W cos(pi x / 8) sin(pi y / 8)", "-W t order_x"], None),
])
def test_a_function_gives_the_fields_of_the_equal_text(function, text, degree):
    # A text that depends on x counts as of degree 1, a function without degree as of 3: give both a product of 3.
    cubic = scene_of().term("order", ["-0.1 order_x^3", "0"])
    with_text = cubic.term("order", text, W=0.7).start().advance()
    assert close(cubic.term("order", function, degree=degree).start().advance(), with_text)


def test_a_flux_of_a_function_gives_the_fields_of_the_equal_text_and_conserves_the_rods():
    text = scene_of().term("rod_density", flux=["-W rod_density d_x rod_density", "0"], W=0.1)
    function = scene_of().term("rod_density", degree=2, W=0.1,
                               flux=lambda rod_density, d_x_rod_density, W: (-W * rod_density * d_x_rod_density, 0.0))
    one, other = function.start().advance(), text.start().advance()
    assert close(one, other) and abs(one.rod_density.mean() - 1.0) < 1e-13


def test_a_parameter_is_a_key_and_the_error_estimate_is_that_of_the_text():
    watched = scene_of(**{"time.max_error": 0.01, "relaxation.rate": -0.5})
    function = watched.term("order", saturate, degree=4, W=0.3).set("terms.W", 0.9).start()
    text = watched.term("order", SATURATE_TEXT, W=0.9).start()
    assert close(function.advance(), text.advance())
    errors = function.observables.step_error.values
    # Both compare the same right-hand sides; differences of rounding errors, relative to an error of 1e-3.
    assert np.allclose(errors, text.observables.step_error.values, rtol=1e-8) and errors.max() > 0


@pytest.mark.parametrize("changes", [{"fields.bead_velocity": "slaved", "drag.coefficient": 2.0},
                                     {"fields.bead_velocity": "dynamic", "drag.coefficient": 2.0,
                                      "inertia.bead_mass": 1.0}])
def test_a_force_on_the_beads_is_that_of_the_text(changes):
    beads = scene_of(**{"fields.bead_density": True, "stiffness.beads": 0.5, "weathercock.strength": 0.3, **changes})
    text = beads.term("bead_velocity", ["W order_x rod_density", "W order_y rod_density"], W=0.4)
    function = beads.term("bead_velocity", lambda order_x, order_y, rod_density, W: (W * order_x * rod_density,
                                                                                     W * order_y * rod_density),
                          degree=2, W=0.4)
    assert close(function.start().advance(), text.start().advance())


# --- exact rates

def test_a_wave_decays_at_its_exact_rate_and_stability_has_it():
    wave = {"initial.polar_order_x": "0.01 cos(pi y / 4)"}
    scene = drover.Scene.from_dict({**QUIET, **wave}).term("order", lambda lap_order_x, lap_order_y, order_x, order_y:
                                                           (lap_order_x - 0.3 * order_x, lap_order_y - 0.3 * order_y),
                                                           degree=1)
    rate = 0.3 + (np.pi / 4) ** 2
    run = scene.start()
    start = run.frame.polar_order_x.copy()
    # Isotropic, so the propagator takes all of it: exact but for the differences, 1e-12 of the slopes.
    assert np.abs(run.advance().polar_order_x - start * np.exp(-2 * rate)).max() < 1e-11 * np.abs(start).max()
    growth = scene.stability().growth_rate
    exact = -0.3 - growth.wavenumber**2
    found = np.abs(growth - exact).min("branch") / np.abs(exact)
    assert found.max() < 1e-10


def test_a_nonlinear_function_is_linearised_about_the_ordered_state():
    # An order where tanh p^2 = 1/2: slopes there against those of the text, which are exact.
    quick = scene_of(**{"relaxation.rate": -0.5, "stability.wavenumbers": 8, "stability.angles": 3,
                        "stability.frequencies": 5})
    functions = quick.term(
        "order", lambda order_x, order_y: tuple(-np.tanh(order_x**2 + order_y**2) * p for p in (order_x, order_y)))
    texts = quick.term("order", [f"-tanh(order_x^2 + order_y^2) order_{axis}" for axis in "xy"])
    one, other = functions.stability(), texts.stability()
    assert set(one.groups) == set(other.groups) and "ordered" in one.groups
    # The states agree as Newton's method ends; the order that it finds is at most 1e-8 off.
    assert np.abs(one.growth_rate - other.growth_rate).max() < 1e-7
    text = " ".join(one.text.split())
    assert "by differences" in text and "degree is not known" in text and "slow" in text
    assert any("by differences" in note for note in functions.check())


@pytest.mark.parametrize("size", [lambda rods, order: order, lambda rods, order: order * np.sqrt(rods)],
                         ids=["kink at 0", "no value below 0"])
def test_a_function_of_the_size_of_order_keeps_its_direction_free(size):
    # Slopes by differences are far off where fields are large, and a density below 0 has no root.
    quick = scene_of(**{"relaxation.rate": -0.5, "stability.wavenumbers": 8, "stability.angles": 3,
                        "stability.frequencies": 5})
    functions = quick.term("order", lambda rod_density, order_x, order_y: tuple(
        -size(rod_density, np.hypot(order_x, order_y)) * p for p in (order_x, order_y)))
    ordered = [state for state in functions.stability().values["states"] if state["name"] == "ordered"]
    assert len(ordered) == 1 and ordered[0]["free_direction"]


def test_a_function_that_is_not_smooth_is_flagged():
    scene = scene_of().term("order", lambda order_x: (np.where(order_x > 0, 1.0, -0.5) * order_x, 0.0), degree=None)
    assert "not smooth" in " ".join(scene.stability().text.split())


def test_an_unknown_degree_counts_as_cubic_and_is_named():
    explained = scene_of().term("order", saturate).explain()
    assert explained["terms_without_degree"] == ["terms[1]"]
    kept = {degree: scene_of().term("order", saturate, degree=degree).explain()["degree"] for degree in (None, 4)}
    assert kept == {None: 3, 4: 4}


# --- archives

def test_an_archive_names_the_function_and_is_read_without_it_but_not_resumed(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    scene = scene_of().term("order", saturate, degree=4)
    with scene.run("short.h5") as run:
        (term,) = run.scene["terms"]
        assert term["function"] == "saturate" and "Cubic, times a density" in term["source"]
        assert (run.frames.rod_density.isel(time=-1) == scene.start().advance().rod_density).all()
    assert program(tmp_path, "info", "short.h5").stdout
    program(tmp_path, "export", "short.h5", "-o", "short.csv")
    for refused in (program(tmp_path, "restart", "short.h5", "--set", "time.end=3", status=2).stderr,
                    str(pytest.raises(drover.Error, drover.restart, "short.h5", end=3.0).value)):
        for part in ("short.h5 (its scene):", "saturate", "does not have it", "scene.term(\"order\", saturate)"):
            assert part in refused
    drover.restart("short.h5", end=3.0, functions=[saturate]).close()
    scene.set("time.end", 3.0).run("long.h5").close()
    assert_same_bytes("short.h5", "long.h5")
    (tmp_path / "kept.toml").write_text(scene.to_toml())
    assert "does not have it" in program(tmp_path, "run", "kept.toml", status=2).stderr


def test_a_run_resumes_with_the_function_with_which_it_began(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    ours = saturate
    scene_of(**{"time.end": 0.5}).term("order", ours, degree=4).run("short.h5").close()

    def saturate_of(text):
        (tmp_path / "functions.py").write_text(text)
        found = {}
        exec(compile(text, str(tmp_path / "functions.py"), "exec"), found)
        linecache.checkcache()
        return found["saturate"]

    same = inspect.getsource(ours).replace("    slow", "    # a comment\n    slow")
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        drover.restart("short.h5", end=1.0, functions=[saturate_of(same)]).close()
    with pytest.warns(UserWarning, match="saturate is not the function with which the run began"):
        drover.restart("short.h5", end=1.5, functions=[saturate_of(same.replace("-W", "W"))]).close()
    with pytest.raises(drover.Error, match="order_y, rod_density; expected those of the run, .* rod_density, W"):
        drover.restart("short.h5", end=2.0, functions=[saturate_of(same.replace(", W=0.7", "").replace("-W *", "-"))])
    with pytest.raises(drover.Error, match="tilt is not a function of this run; expected .*: saturate"):
        drover.restart("short.h5", end=2.0, functions=[saturate, tilt])


def test_the_bytes_do_not_depend_on_the_number_of_threads(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    scene = scene_of(**{"grid.nx": 64, "grid.ny": 64, "time.end": 0.5}).term("order", saturate, degree=4)
    for threads in (1, 3):
        scene.run(f"by-{threads}.h5", threads=threads).close()
    assert_same_bytes("by-1.h5", "by-3.h5")


def test_other_processes_refuse_a_function_with_a_remedy():
    for call in (lambda scene: drover.sweep(scene, {"terms.W": [0.1, 0.2]}),
                 lambda scene: drover.tradeoff(scene, "polar_order=10%", "5s")):
        with pytest.raises(drover.Error, match="saturate.*as text, or run the scenes one by one"):
            call(scene_of().term("order", saturate))


# --- functions that fail

def test_functions_that_are_no_terms_are_refused():
    own = drover.Model([drover.Field("u", "-u")]).scene(points=8, side=8.0, dt=0.1, end=1.0)
    for call, said in [(lambda: own.term("u", lambda u: -u), "write the term in the equation of its field"),
                       (lambda: scene_of().term("order", lambda: (0.0, 0.0)), "no arguments; expected at least one"),
                       (lambda: scene_of().term("order", lambda order_x, *, W=1.0: (order_x, order_x)),
                        "has the keyword-only argument W=1.0; .* without \\*")]:
        with pytest.raises(drover.Error, match=said):
            call()


def test_an_exception_of_a_function_ends_the_run_and_leaves_whole_rows(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)

    def fails_late(order_x, order_y, t):
        if t > 1.22:
            raise LookupError("no such table")
        return -order_x, -order_y

    scene = scene_of().term("order", fails_late)
    with pytest.raises(LookupError, match="no such table") as raised:
        scene.run("late.h5", threads=2)
    assert any(entry.name == "fails_late" for entry in raised.traceback)
    if (tmp_path / "late.h5").exists():
        with drover.open_run("late.h5") as run:
            assert run.frames.sizes["time"] == 2 and np.isfinite(run.frames.rod_density).all()
    run = scene.start()
    with pytest.raises(LookupError):
        run.advance()
    assert 1.19 < run.time < 1.26
    with pytest.raises(drover.Error, match="the run has failed"):
        run.advance(steps=1)


@pytest.mark.parametrize("make, says", [
    (lambda order_x: order_x, "expected two arrays, the x and y components"),
    (lambda order_x: None, "it returns NoneType"),
    (lambda order_x: (order_x[:3], order_x), "shape (3,) for arguments of shape"),
    (lambda order_x: (order_x, 1j * order_x), "complex128; expected real numbers"),
    (lambda order_x: ("a", order_x), "expected real numbers"),
    (lambda order_x: (order_x / 0.0, 0.0), "expected finite numbers"),
    (lambda order_x: (order_x - order_x.mean(), 0.0), "no means, shifts, transforms"),
    (lambda order_x: (np.roll(order_x, 1), 0.0), "no means, shifts, transforms"),
    (lambda order_x: (np.random.normal(size=order_x.shape), 0.0), "random numbers"),
    (lambda order_z: (order_z, 0.0), "did you mean order_"),
    (lambda t: (t, 0.0), "no field among its arguments"),
    (lambda order_x, *rest: (order_x, 0.0), "argument *rest"),
    (lambda bead_density: (bead_density, 0.0), "the argument bead_density"),
])
@pytest.mark.filterwarnings("ignore:divide by zero", "ignore:invalid value")
def test_a_bad_function_is_refused_with_a_sentence_before_a_run(make, says):
    with pytest.raises(drover.Error) as raised:
        scene_of().term("order", make)
    assert says in str(raised.value) and ";" in str(raised.value)


def test_a_wrong_degree_a_value_of_a_density_and_a_lost_parameter_are_refused():
    with pytest.raises(drover.Error, match="no polynomial of degree 2"):
        scene_of().term("order", saturate, degree=2)
    with pytest.raises(drover.Error, match="expected flux="):
        scene_of().term("rod_density", lambda rod_density: rod_density)
    with pytest.raises(drover.Error, match="has no argument K"):
        scene_of().term("order", tilt, W=1.0, K=2.0)
    with pytest.raises(drover.Error, match="W.*numbers given with the term"):
        scene_of().term("order", tilt)
    with pytest.raises(ZeroDivisionError):
        scene_of().term("order", lambda order_x: (1 // 0, 0.0))


def test_values_that_are_not_finite_end_a_run_with_their_place():
    scene = scene_of().term("order", lambda order_x, t: (np.where(t > 0.5, np.nan, 0.0) * order_x, 0.0))
    with pytest.raises(drover.Error, match=r"is nan at order_x = .*; expected finite numbers") as raised:
        scene.start().advance()
    assert raised.value.fault == "run"


# --- threads and signals

def test_one_thread_at_a_time_calls_a_function():
    inside, most = [], []

    def watched(order_x, order_y):
        inside.append(1)
        most.append(len(inside))
        time.sleep(0)  # lets another thread take the GIL
        inside.pop()
        return -order_x, -order_y

    scene = scene_of(**{"grid.nx": 64, "grid.ny": 64, "time.end": 0.5}).term("order", watched)
    runs = [scene.set("run.threads", threads).start() for threads in (2, 3)]  # two at once, of scenes from one
    threads = [threading.Thread(target=run.advance) for run in runs]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert max(most) == 1 and len(most) > 100  # 16 strips of 256 points in 40 evaluations
    assert all(run.step == run.steps for run in runs)


def test_ctrl_c_stops_between_two_steps_and_the_run_goes_on():
    scene = scene_of(**{"time.end": 1e6, "output.frame_every": 1e6, "output.sample_every": 1e6})
    run, other = (scene.term("order", saturate, degree=4).start() for _ in range(2))
    interrupt_soon()
    with pytest.raises(KeyboardInterrupt):
        run.advance()
    assert run.step > 0 and signal.getsignal(signal.SIGINT) is signal.default_int_handler
    other.advance(steps=run.step)
    assert run.advance(steps=5).rod_density.tobytes() == other.advance(steps=5).rod_density.tobytes()


def words_printed_by(code):
    """Of a Python of its own, which ends with the status 0."""
    return subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=60, env=environment(),
                          check=True).stdout.split()


def test_a_scene_with_a_function_is_dropped_without_a_leak_or_a_crash():
    code = ("import drover, gc, weakref\n"
            "def tilt(order_x, order_y): return -order_y, order_x\n"
            "kept = weakref.ref(tilt)\n"
            "scene = drover.Scene.from_dict({'grid.nx': 16, 'grid.ny': 16, 'time.dt': 0.1})"
            ".term('order', tilt)\n"
            "run = scene.start(); run.advance(steps=2); theory = scene.stability()\n"
            "del scene, run, theory, tilt; gc.collect(); print(kept() is None)\n")
    assert words_printed_by(code) == ["True"]


def test_thread_states_of_calls_do_not_accumulate_and_a_forked_child_makes_its_own():
    code = ("import ctypes, os, drover\n"
            "api = ctypes.pythonapi\n"
            "for call in (api.PyInterpreterState_Get, api.PyInterpreterState_ThreadHead, api.PyThreadState_Next):\n"
            "    call.restype = ctypes.c_void_p\n"
            "def states():\n"
            "    state = ctypes.c_void_p(api.PyInterpreterState_ThreadHead(ctypes.c_void_p("
            "api.PyInterpreterState_Get())))\n"
            "    count = 0\n"
            "    while state.value:\n"
            "        count, state = count + 1, ctypes.c_void_p(api.PyThreadState_Next(state))\n"
            "    return count\n"
            "def tilt(order_x, order_y): return -order_y, order_x\n"
            "scene = drover.Scene.from_dict({'grid.nx': 64, 'grid.ny': 64, 'time.dt': 0.1, 'run.threads': 3})"
            ".term('order', tilt)\n"
            "def run(): scene.start().advance(steps=3)\n"
            "counts = [(run(), states())[1] for _ in range(8)]\n"
            "child = os.fork()\n"
            "if child == 0:\n"
            "    run(), run()\n"
            "    os._exit(0)\n"
            "print(max(counts), os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]))\n"
            "run()\n")
    most, status = words_printed_by(code)
    # That of the program, those of a run in its thread with two helpers, and as many of the run before.
    assert int(most) <= 7 and status == "0"


def test_fields_are_arrays_in_every_call_and_parameters_numbers():
    def brake(order_x, order_y, W=0.7):
        slow = np.zeros_like(order_x)
        slow[np.hypot(order_x, order_y) > 0.1] = W  # of arrays alone
        assert isinstance(W, float)
        return -slow * order_x.copy(), -slow * order_y

    scene = scene_of().term("order", brake)
    scene.check()
    assert scene.explain() and scene.start().advance(steps=2)
    assert "isotropic" in scene.stability().groups
