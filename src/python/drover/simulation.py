"""drover/simulation.py: a run in memory: advanced step by step, its fields and bodies as NumPy arrays."""
import math
from copy import copy
from contextlib import contextmanager
from numbers import Integral

from drover import _drover
from drover.attributes import about
from drover.error import ArgumentError, Error
from drover.locks import hdf5
from drover.progress import Progress

# Groups of a run of particles: prefix of their arrays, and their axis, as in the archive.
BODIES = {"/bodies/beads": ("bead_", "bead"), "/bodies/rods": ("rod_", "rod")}
SPHERES = "/particles/spheres"
CHUNK = 0.2  # s between reports of the progress, roughly
ENDINGS = ("_error", "_linear", "_autocorrelation_time", "_step_bias")  # of names in a summary


class Frame:
    """The state of a run now: its arrays as attributes, frame.rod_density(y, x), frame.rod_position(rod, component).

    The arrays are views of the memory of the run, without copies, and read-only: they show the state of the last
    frame that was taken.  Keep a state by to_xarray(), or by .copy() of an array.  Units: mm, s, mg.
    """

    OWN = ("step", "time", "arrays", "spheres", "box", "_time_unit", "_about", "_step_now")

    def __init__(self, step, time, arrays, spheres, box, about, time_unit="s", step_now=None):
        self.step, self.time, self._time_unit, self._step_now = step, time, time_unit, step_now
        self.arrays, self.spheres, self.box, self._about = arrays, spheres, box, about

    def __getattr__(self, name):
        arrays = self.__dict__.get("arrays", {})
        if name in arrays:
            return arrays[name]
        raise AttributeError(f"a frame of this run has no {name}; expected one of {', '.join(arrays)}, spheres")

    def __getstate__(self):
        """Of a copy: it does not change when the run goes on."""
        return {**self.__dict__, "arrays": {name: array.copy() for name, array in self.arrays.items()},
                "spheres": copy(self.spheres), "box": copy(self.box), "_step_now": None}

    def __setattr__(self, name, value):
        """frame.rod_density = values is frame.rod_density[...] = values; a DataArray is taken by its dimensions."""
        if name in self.__dict__.get("arrays", {}):
            dims = self._about[0][name][0] if name in self._about[0] else ()
            if set(getattr(value, "dims", ())) == set(dims) != set():
                value = value.transpose(*dims)
            self.arrays[name][...] = value
        elif name in self.OWN:
            super().__setattr__(name, value)
        else:
            raise AttributeError(f"a frame of this run has no {name}; expected one of {', '.join(self.arrays)}")

    def __getitem__(self, name):
        return self.arrays[name]

    def __dir__(self):
        return [*super().__dir__(), *self.arrays]

    def __repr__(self):
        return f"<drover.Frame t = {self.time:g} s: {', '.join(self.arrays)}>"

    def to_xarray(self):
        """A copy, as a dataset with coordinates and units; of a frame that is the last one taken."""
        import xarray
        if self._step_now and self._step_now() != self.step:
            raise Error(f"this frame is of t = {self.time:g}, but the run, whose memory it shows, has gone on; call "
                        "to_xarray() before the next step to keep a state")
        variables, axes = self._about
        coordinates = {name: (name, values.copy(), about) for name, (values, about) in axes.items()}
        data = {name: (dims, self.arrays[name].copy(), about) for name, (dims, about) in variables.items()}
        return xarray.Dataset(data, {**coordinates, "time": ((), self.time, {"units": self._time_unit})})


class Simulation:
    """A run in this process that writes no files.

    >>> import drover
    >>> scene = drover.Scene.from_dict({"grid": {"nx": 16, "ny": 16}, "time": {"dt": 0.1, "end": 1.0}})
    >>> run = scene.start()
    >>> [round(frame.time, 3) for frame in run.every(0.5)]
    [0.0, 0.5, 1.0]
    >>> run.observables.polar_order.sizes["time"]
    11

    Steps release the GIL; Ctrl-C raises KeyboardInterrupt between two steps, and the run can be advanced further.  Its
    states and observables are those of `drover run`, to the last bit.  Several runs may go on at once, each used by one
    thread at a time: to read a run while another thread advances it, share a lock with that thread.
    """

    def __init__(self, scene):
        """At t = 0; scene.start() does the same.  Without time.dt the step is chosen first."""
        with hdf5():
            self._session = _drover.Session(scene._native)
        self._scene = scene
        self._own = {}  # observables of the user: name -> (function, unit, times, values)
        self._sample_steps = 0
        self._is_edited = False

    def observe(self, function, name=None, unit="1"):
        """Adds an observable of your own: `function(frame)`, a number, at each sample from now on.

        It joins `observables` under `name` (default: the name of the function), and `summary` with its mean and error.
        Python calls it between two steps, which costs more than a built-in observable; the run itself is the same, to
        the last bit.

        >>> from drover import Scene
        >>> run = Scene.from_dict({"time": {"dt": 0.1, "end": 1.0}, "output.sample_every": 0.5}).start()
        >>> run.observe(lambda frame: frame.rod_density.max(), "peak", "mm-2")
        >>> frame = run.advance()
        >>> run.observables.peak.sizes["time"], float(run.observables.peak[-1])
        (3, 1.0)
        """
        if not callable(function):
            raise Error(f"the observable is {function!r}; expected a function of a frame, which gives a number")
        name = getattr(function, "__name__", "") if name is None else name
        if not isinstance(name, str) or not isinstance(unit, str):
            raise Error(f"name = {name!r}, unit = {unit!r}; expected texts")
        is_reserved = name == "warm_up" or name.endswith(ENDINGS)  # of summary
        if not name.isidentifier() or is_reserved:
            raise Error(f'an observable cannot be called "{name}"; expected a new name: give name=')
        if name in self.observables or (self.step and name in self.summary):
            raise Error(f'the run measures "{name}" already; expected a new name: give name=')
        self._sample_steps = self._sample_steps or self.whole_steps(self._scene["output.sample_every"])
        if self._sample_steps < 1:
            raise Error("the scene takes no samples; expected output.sample_every > 0")
        own = function, unit, [], []
        if self._is_sampled():
            self._sample({name: own})
        self._own[name] = own  # once it has given a number

    def _is_sampled(self):
        """Whether the run takes a sample now: on its schedule, and at time.end."""
        return self.step % self._sample_steps == 0 or self.step == self.steps

    def _sample(self, observables):
        frame = self.frame
        for name, (function, _, times, values) in observables.items():
            value = function(frame)
            try:
                values.append(float(value))
            except (TypeError, ValueError):
                raise Error(f'the observable "{name}" gave {type(value).__name__} of shape '
                            f"{getattr(value, 'shape', ())}; expected one number") from None
            times.append(self.time)

    @property
    def scene(self):
        """The scene as it was given."""
        return self._scene

    @property
    def time(self):
        """[s]"""
        return self._session.time

    @property
    def step(self):
        """Steps taken."""
        return self._session.step

    @property
    def steps(self):
        """Steps to time.end."""
        return self._session.steps

    @property
    def dt(self):
        """The time step [s], chosen or given."""
        return self._session.dt

    @property
    def was_changed(self):
        """Whether edit() changed fields or bodies: the run is then no longer that of its scene."""
        return self._session.was_changed

    def __repr__(self):
        return f"<drover.Simulation of {self._scene.name}: t = {self.time:g} s, step {self.step} of {self.steps}>"

    def advance(self, duration=None, *, steps=None, progress=None):
        """Takes steps: for `duration` [s], a whole number of steps; for `steps`; or to time.end.  Returns the frame.

        >>> from drover import Scene
        >>> Scene.from_dict({"time": {"dt": 0.1, "end": 1.0}}).start().advance(steps=-1)
        Traceback (most recent call last):
        drover.error.ArgumentError: steps = -1; expected a whole number, 1 or more: a run does not go back
        """
        if steps is not None and duration is not None:
            raise ArgumentError(f"duration = {duration} and steps = {steps}; expected one of them")
        if steps is None:
            steps = max(self.steps - self.step, 0) if duration is None else self.whole_steps(duration)
        elif not isinstance(steps, Integral) or steps < 1:
            raise ArgumentError(f"steps = {steps}; expected a whole number, 1 or more: a run does not go back")
        self._advance(self.step + steps, Progress(self.step, self.step + steps, progress))
        return self.frame

    def every(self, interval=None, *, until=None, progress=None):
        """Yields the frame now and after every `interval` [s] up to `until` [s].

        Defaults: output.frame_every and time.end of the scene.
        """
        stride = self._session.frame_every if interval is None else self.whole_steps(interval)
        last = self.steps if until is None else self.whole_steps(until)
        stride = stride or max(last, 1)
        progress = Progress(self.step, last, progress)
        yield self.frame
        while self.step + stride <= last:
            self._advance(self.step + stride, progress)
            yield self.frame

    def watch(self, interval=None, *, until=None):
        """Advances as every(), and shows the figure of each frame: in a notebook in place, otherwise in a window.

        Closing the window stops it; the run can be advanced further.  Returns the frame.
        """
        from drover import live, plot
        screen = live.screen()
        for _ in self.every(interval, until=until, progress=False):
            screen.show(plot.figure(self))
            if not screen.is_open:
                break
        return self.frame

    def _advance(self, last, progress):
        self._require_whole()
        if self.step == self.steps and last > self.step and self.step % (self._sample_steps or 1):
            for _, _, times, values in self._own.values():  # the sample of time.end is off the schedule, and left out
                if times and times[-1] == self.time:
                    times.pop()
                    values.pop()
        chunk = 1
        try:
            while self.step < last:
                started = progress.start if chunk == 1 else now()
                count = min(chunk, last - self.step)
                if self._own:
                    count = min(count, self._sample_steps - self.step % self._sample_steps)
                    if self.step < self.steps:
                        count = min(count, self.steps - self.step)
                self._session.advance(count)
                if self._own and self._is_sampled():
                    self._sample(self._own)
                if now() - started < CHUNK:
                    chunk *= 2
                progress.report(self.step, f"t = {self.time:g} s")
        finally:
            if self.step >= progress.last:
                progress.close()

    def whole_steps(self, duration):
        """A duration [s] in steps; raises Error unless it is a whole number of them."""
        if not math.isfinite(duration):
            raise Error(f"a time of {duration} s; expected a number")
        steps = round(duration / self.dt)
        # As of the scene: decimals, of which a millionth of a step is rounding.
        if steps < 0 or abs(steps * self.dt - duration) > 1e-6 * self.dt + 1e-12 * abs(duration):
            raise Error(f"a time of {duration} s is {duration / self.dt:.6g} steps of dt = {self.dt} s; expected a "
                        f"whole number of steps, such as {max(steps, 1) * self.dt:.6g} s")
        return steps

    def __copy__(self):
        raise TypeError("a run cannot be copied: its copy would be the same run; expected another run of its scene")

    @property
    def frame(self):
        """The state now; see Frame."""
        return self._frame(False)

    def _require_whole(self):
        if self._is_edited:
            raise Error("the run is being edited: its arrays are not yet its state; end the block of edit() first")

    def _frame(self, writable):
        self._require_whole()
        arrays, spheres, variables, axes = {}, {}, {}, {}
        for group in self._session.frames(writable):
            start, axis = BODIES.get(group["group"], ("", "sphere"))
            is_spheres = group["group"] == SPHERES
            into = spheres if is_spheres else arrays
            is_field = group["group"] == "/"
            if is_field:
                axes = {name: (values, about(name, unit, meaning))
                        for name, unit, meaning, values in group["axes"]}
            for name, (unit, meaning, dims, values) in group["arrays"].items():
                into[start + name] = values
                named = tuple(dims) if is_field else (axis, "component")
                if not is_spheres:
                    variables[start + name] = named, about(name, unit, meaning)
            for name, (unit, meaning, values) in group["fixed"].items():
                into[start + name] = values
                if not is_spheres:
                    variables[start + name] = ((axis, f"{axis}_sphere")[:values.ndim], about(name, unit, meaning))
        box = spheres.pop("box/edges", None)
        all_spheres = Frame(self.step, self.time, spheres, None, box, ({}, {})) if spheres else None
        return Frame(self.step, self.time, arrays, all_spheres, box, (variables, axes), self._session.time_unit,
                     lambda: self.step)

    @contextmanager
    def edit(self):
        """Changes fields or bodies between two steps: `with run.edit() as fields: fields.rod_density[...] *= 1.1`.

        The arrays are the memory of the run: of particles `bead_position`, `bead_velocity`, `rod_axis`, ....  On exit
        they are checked (finite values, no overlaps), and the run goes on from them: it is a new run then
        (was_changed).  After an exception in the block, or of the check, all is as before.
        """
        frame = self._frame(True)
        for array in frame.spheres.arrays.values() if frame.spheres else ():
            array.setflags(write=False)  # they follow from the bodies
        self._is_edited = True
        try:
            yield frame
            self._session.accept()
        except BaseException:
            self._session.frames()  # computes the arrays from the state again, which has not changed
            raise
        finally:
            self._is_edited = False
            for array in frame.arrays.values():
                array.setflags(write=False)

    @property
    def observables(self):
        """The series of the observables so far, as an xarray Dataset over time, with units; a copy."""
        import xarray
        series = self._session.series()
        coordinates = {"time": ("time", series["times"],
                                about("time", self._session.time_unit, "time since the start of the run"))}
        for name, unit, meaning, values in series["axes"]:
            coordinates[name] = (name, values, about(name, unit, meaning))
        dataset = xarray.Dataset({name: (("time", *dims), values, about(name, unit, meaning))
                                  for name, (unit, meaning, dims, values) in series["arrays"].items()}, coordinates)
        for name, (_, unit, times, values) in self._own.items():
            own = xarray.DataArray(values, {"time": times}, ("time",))
            own = own.reindex(time=dataset["time"], method="nearest", tolerance=0.5 * self.dt)
            dataset[name] = own.assign_attrs(units=unit, long_name=name.replace("_", " "))
        return dataset

    @property
    def summary(self):
        """Means of the samples so far with errors and linear theory, as the summary of an archive: a Dataset.

        Without biases of the step, and of particles without what needs their paths.  Computed anew each time.

        >>> from drover import Scene
        >>> run = Scene.from_dict({"grid": {"nx": 16, "ny": 16}, "time": {"dt": 0.1, "end": 50.0},
        ...                        "relaxation": {"rate": 1.0}, "noise": {"order": 0.1}}).start()
        >>> frame = run.advance()
        >>> bool(run.summary.polar_order > 0.0), run.summary.polar_order.units
        (True, '1')
        """
        from drover.computed import dataset_of
        found = dataset_of(self._session.summary())
        warm_up = float(found["warm_up"]) if "warm_up" in found else 0.0
        for name, (_, unit, times, values) in self._own.items():
            self._summarise(found, name, unit, times, values, warm_up)
        return found

    @property
    def warnings(self):
        """The warnings about the results so far, as a run that ends now prints them; a list of sentences."""
        return self._session.warnings() if self.step > 0 else self._scene.check()

    def _summarise(self, found, name, unit, times, values, warm_up):
        """Adds the mean of an observable of the user's own, its error and its autocorrelation time."""
        if self.step == self.steps and self.step % self._sample_steps and times and times[-1] == self.time:
            times, values = times[:-1], values[:-1]  # means are of samples on the schedule
        skip = sum(time < warm_up for time in times)
        if len(values) - skip < 1:
            return
        if name in found:
            raise Error(f'the run has a result "{name}" of its own; observe yours under another name')
        mean, error, memory = _drover.mean_of(values, self._sample_steps * self.dt, skip)
        nan = float("nan")
        for key, value, its_unit, words in (
                (name, mean, unit, f"mean of {name}"),
                (f"{name}_error", nan if error is None else error, unit, f"standard error of {name}"),
                (f"{name}_autocorrelation_time", memory, self._session.time_unit,
                 f"integrated autocorrelation time of {name}")):
            found[key] = ((), value, about(key, its_unit, words))


def now():
    import time
    return time.monotonic()
