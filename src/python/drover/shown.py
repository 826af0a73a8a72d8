"""drover/shown.py: runs as a page shows them: one that goes on in a thread of its own, or one in an archive."""
import threading
import time
import traceback

import numpy

from drover.error import DroverError
from drover.particles import is_of_particles, sides_of
from drover.pictures import picture_of
from drover.typeset import named

PICTURES_PER_SECOND = 5
WATCHED = 2.0    # s after a page asked last: pictures are made for a page alone
SERIES = 1.0     # s between copies of the observables
# Of particles the sections whose numbers may change while the bodies stay as they are.
OF_BODIES = {"plates", "gravity", "restitution", "friction", "kick", "forces"}
# Sections whose numbers are no coefficients.
SETTINGS = {"grid", "dealiasing", "time", "initial", "output", "analysis", "accuracy", "run", "sweep", "stability",
            "calibrated", "boundary", "uniform", "table", "approximation", "fields", "model", "terms"}


def units_of(values):
    """Names of the units of length, of wavenumbers and of time in a scene, for labels; "" without one."""
    found = {what: named(unit, values) for what, unit in (("length", "mm"), ("wavenumber", "mm-1"), ("time", "s"))}
    return {what: "" if unit == "1" else unit for what, unit in found.items()}


class Shown:
    """What a page asks for: a picture with a number that grows, and what else is known."""

    def __init__(self, name):
        self.name, self.state, self.error = name, "starting", ""
        self.number, self.picture, self.observables, self.warnings = 0, None, None, []
        self.changed = threading.Condition()
        self.asked, self.units = 0.0, units_of({})

    def publish(self, picture=None, observables=None, state=None, error=None):
        with self.changed:
            self.picture = picture or self.picture
            self.observables = observables if observables is not None else self.observables
            self.state = state or self.state
            self.error = self.error if error is None else error
            self.number += 1
            self.changed.notify_all()

    def wait_for(self, number, seconds):
        """Waits until there is something newer than `number`; returns the number there is."""
        self.asked = time.monotonic()
        with self.changed:
            self.changed.wait_for(lambda: self.number > number, seconds)
            return self.number

    def close(self):
        """Ends what goes on."""


def coefficients_of(scene):
    """Keys of numbers of the model that a page may change, with their values, units and meanings."""
    found = []
    for key in scene.keys():
        section = key.partition(".")[0].partition("[")[0]
        if scene.kind == "particles" and section not in OF_BODIES:
            continue
        if section in SETTINGS or section in ("field", "white_noise") and not key.endswith("noise"):
            continue
        value = scene[key]
        if isinstance(value, float):
            about = scene.describe(key)
            found.append({"key": key, "value": value, "unit": about.get("unit", ""), "doc": about.get("doc", "")})
    return found


class LiveRun(Shown):
    """A run in memory, advanced in a thread of its own: paused, resumed, restarted, given other coefficients."""

    sampled = 0.0  # when the observables were copied

    def __init__(self, scene):
        super().__init__(scene.name)
        self.scene, self.run, self.before = scene, None, 0.0  # s that earlier coefficients took
        self.requests, self.is_closed, self.is_paused = [], False, False
        self.changes = 0  # of coefficients since the start
        self.speed = 0.0  # steps a second
        self.thread = threading.Thread(target=self._work, daemon=True)
        self.thread.start()

    @property
    def time(self):
        return self.before + (self.run.time if self.run else 0.0)

    @property
    def progress(self):
        return self.run.step / max(self.run.steps, 1) if self.run else 0.0

    @property
    def coefficients(self):
        return coefficients_of(self.scene)

    def request(self, action, **values):
        """Asks the thread for something; what goes wrong is shown as error."""
        if action not in ("pause", "resume", "restart", "set", "wake"):
            raise ValueError(f"{action}; expected pause, resume, restart or set")
        with self.changed:
            self.requests.append((action, values))
            self.changed.notify_all()

    def close(self):
        self.is_closed = True
        self.request("wake")
        self.thread.join(timeout=5.0)

    def _work(self):
        try:
            self._start(self.scene)
        except DroverError as error:
            self.publish(state="failed", error=str(error))
        steps = 1
        while not self.is_closed:
            while self.requests:
                self._fulfil(*self.requests.pop(0))
            if not self._is_going():
                with self.changed:
                    self.changed.wait_for(lambda: self.requests or self.is_closed)
                continue
            began = time.monotonic()
            steps = min(steps, self.run.steps - self.run.step)
            try:
                self.run.advance(steps=steps, progress=False)
            except DroverError as error:
                self.run = None
                self.publish(state="failed", error=str(error))
                continue
            took = time.monotonic() - began
            self.speed = steps / max(took, 1e-9)
            if self._state() == "ended":
                self._warn()
            steps = int(numpy.clip(steps * numpy.clip(1.0 / PICTURES_PER_SECOND / max(took, 1e-9), 0.25, 4.0), 1, 1e6))
            self._show()

    def _is_going(self):
        return self.run is not None and not self.is_paused and self.run.step < self.run.steps

    def _state(self):
        if self.run is None:
            return "failed"
        return "ended" if self.run.step >= self.run.steps else "paused" if self.is_paused else "running"

    def _show(self, always=False):
        state = self._state()
        if not always and state == "running" and time.monotonic() - self.asked > WATCHED:
            return
        frame = self.run.frame
        side = (self.scene["grid.lx"], self.scene["grid.ly"]) if frame.box is None else numpy.diag(frame.box)[:2]
        units = {name: about.get("units", "1") for name, (_, about) in frame._about[0].items()}
        picture = picture_of(self.time, frame.arrays, side, units)
        observables = None
        now = time.monotonic()
        if always or state != "running" or now - self.sampled > SERIES:
            observables, self.sampled = self.run.observables, now
        self.publish(picture, observables, state)

    def _start(self, scene):
        self.run, self.scene = scene.start(), scene
        self.units = units_of(scene.values)
        self._warn()
        self._show(always=True)

    def _warn(self):
        """Reads the warnings of the scene or, of a run that has ended, of its results."""
        try:
            self.warnings = self.run.warnings if self._state() == "ended" else self.scene.check()
        except DroverError as error:  # such as a disk that has no room for the archive, which is not written here
            self.warnings = [str(error)]

    def _fulfil(self, action, values):
        try:
            if action == "pause":
                self.is_paused = True
            elif action == "resume":
                self.is_paused = False
            elif action == "restart":
                self.before, self.is_paused, self.changes = 0.0, False, 0
                self._start(self.scene)
            elif action == "set":
                self._set(values)
            if self.run is not None:
                self.error = ""
                self._show(always=True)
        except DroverError as error:
            self.publish(error=str(error))
        except Exception:  # shown, not lost in the thread
            self.publish(error=traceback.format_exc(limit=1).strip().splitlines()[-1])

    def _set(self, values):
        """Goes on from the fields or bodies as they are, with other coefficients; the run is then one of its own."""
        scene = self.scene.set(values)
        if self.run is None:
            self.before = 0.0
            self._start(scene)
            return
        lift = self._to_whole_period(scene) if scene.kind == "particles" else 0.0
        self.changes += 1  # noise that would be that of the start again is that of another seed, which draws no sizes
        seed = scene["run.seed"] + (self.changes if scene.kind != "particles" else 0)
        run = scene.set({"run.seed": seed % 2**62}).start()
        with run.edit() as fields:
            for name, array in self.run.frame.arrays.items():
                if fields[name].flags.writeable:  # masses and shapes are not
                    fields[name][...] = array
                    if name.endswith("_position"):
                        fields[name][:, 2] += lift
        self.before += self.run.time
        self.run, self.scene = run, scene
        self._warn()

    def _to_whole_period(self, scene):
        """Ends the period of the plates, whose phase is 0 at the start of a run; returns how much higher they are in
        the other scene then [mm]."""
        frequency = self.scene["plates.frequency"]
        periods = -(-self.run.time * frequency // 1.0)
        steps = round(periods / frequency / self.run.dt) - self.run.step
        if steps > 0:
            self.run.advance(steps=steps, progress=False)
        return 2.0 * (scene["plates.amplitude"] - self.scene["plates.amplitude"])


class ShownArchive(Shown):
    """A run in an archive, finished or in progress, which is read again when it has grown."""

    shown = -1  # number of the frame
    has_warned = False

    def __init__(self, path):
        super().__init__(str(path))
        self.path, self.coefficients, self.speed = path, [], 0.0
        self.frames, self.seen, self.chosen = 0, None, None  # a frame, or the last
        self.lock = threading.Lock()
        self.refresh()

    @property
    def progress(self):
        return (self.shown + 1) / max(self.frames, 1)

    def request(self, action, **values):
        if action != "frame":
            raise ValueError(f"{action}; expected frame: an archive is shown, and not steered")
        self.chosen = int(values["number"])
        self.refresh()

    def wait_for(self, number, seconds):
        ends = time.monotonic() + seconds
        while True:
            self.refresh()
            if self.number > number or time.monotonic() >= ends:
                return self.number
            time.sleep(0.2)

    def refresh(self):
        from drover.archive import open_run
        from drover.hdf5_reader import state_of
        with self.lock:
            now = state_of(self.path), self.chosen
            if now == self.seen:
                return
            try:
                with open_run(self.path) as run:
                    self.frames = run.frames.sizes["time"]
                    self._read(run)
            except DroverError as error:
                if self.seen is None:  # it could never be read
                    raise
                self.publish(error=str(error))
            self.seen = now

    def _read(self, run):
        last, self.units = self.frames - 1, units_of(run.scene)
        self.shown = last if self.chosen is None else int(numpy.clip(self.chosen, 0, last))
        frame = run.frames.isel(time=self.shown).load()
        side = sides_of(run) if is_of_particles(run.scene) else [run.scene["grid"][name] for name in ("lx", "ly")]
        picture = picture_of(float(frame["time"]), {name: values.values for name, values in frame.data_vars.items()},
                             side, {name: values.attrs.get("units", "1") for name, values in frame.data_vars.items()})
        self.publish(picture, run.observables.load(), "ended" if run.summary is not None else "running", error="")
        if run.summary is not None and not self.has_warned:
            from drover.lookup import info
            self.has_warned, self.warnings = True, info(self.path).get("warnings", [])
