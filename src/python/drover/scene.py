"""drover/scene.py: a scene (input file) as an immutable object; what the commands of drover do with one."""
import json
import os
import re
import tomllib
from collections.abc import Mapping
from copy import deepcopy
from pathlib import Path

from drover import _drover
from drover.campaign import Submitted, folder_for_jobs, submit
from drover.error import Error
from drover.functions import function_of, function_table, held_functions
from drover.locks import hdf5
from drover.toml import scene_text, value_text


class Scene:
    """Everything that defines a run: model, cell, time, noise, seed.  Valid by construction.

    >>> scene = Scene.from_dict({"relaxation": {"rate": 1.0}, "grid": {"nx": 32, "ny": 32}})
    >>> scene["grid.nx"], scene.set("grid.nx", 64)["grid.nx"]
    (32, 64)
    >>> scene.set("grid.nx", 7)
    Traceback (most recent call last):
    drover.error.Error: --set grid.nx=7: grid.nx = 7; expected an even number >= 4
    """

    def __init__(self, native, text, name, settings=(), functions=None):
        """For load(), parse() and from_dict(), which check the scene."""
        self._native, self._text, self._name, self._settings = native, text, name, tuple(settings)
        self._functions = functions or {}  # {number of a term: TermFunction}
        self._values = None

    @classmethod
    def load(cls, path):
        """The scene of a TOML file.  Raises Error with file, line, column and remedy."""
        name = os.fspath(path)
        with hdf5():
            native = _drover.Scene.read(name, [])
        return cls(native, Path(name).read_text(encoding="utf-8"), name)

    @classmethod
    def parse(cls, text, name="scene.toml"):
        """The scene of a TOML text.  Messages and archives call it `name`."""
        if not isinstance(text, str):
            raise Error(f"the scene is {text!r}; expected TOML as text: load() reads a file, from_dict() a dict")
        with hdf5():
            return cls(_drover.Scene.parse(text, name, []), text, name)

    @classmethod
    def from_dict(cls, sections, name="scene.toml"):
        """The scene of {"section": {"key": value}} or {"section.key": value}."""
        if not isinstance(sections, Mapping):
            raise Error(f"the scene is {sections!r}; expected a dictionary of sections, or of keys")
        return cls.parse(scene_text(sections), name)

    def set(self, key, value=None):
        """A scene with other values: set("driving.strength", 12), or of several keys or sections.

        >>> Scene.from_dict({}).set({"grid": {"nx": 64, "lx": 32.0}, "time.end": 5.0})
        <drover.Scene scene.toml: fields, grid.nx=64, grid.lx=32.0, time.end=5.0>
        """
        changes = key if isinstance(key, dict) else {key: value}
        for name, _ in (changed := list(flat(changes))):
            if not isinstance(name, str) or "=" in name:
                raise Error(f"the key {name!r}; expected one of the keys of scene.keys(), such as \"grid.nx\"")
        settings = [*self._settings, *(f"{name}={value_text(value)}" for name, value in changed)]
        return restored(self._text, self._name, settings, self._functions)

    def term(self, of, value=None, *, flux=None, degree=None, explicit=False, **parameters):
        """A scene with one more term, as text or as a function, and its parameters as keys terms.W.

        >>> Scene.from_dict({}).term("order", ["-W order_x", "-W order_y"], W=0.7)["terms.W"]
        0.7

        `of` is the equation (bead_density, rod_density, bead_velocity or order); a density takes a text or a flux.
        `explicit`: nothing of the term is in the exact linear part.

        A function returns the x and y components at points from arrays of what its arguments name: fields (order_x),
        derivatives (d_x_order_x, lap_order_x, div_order, curl_order), x, y, t, or its parameters, which are numbers.

        >>> import numpy
        >>> def brake(order_x, order_y, W=0.7):
        ...     slow = W / (1 + numpy.hypot(order_x, order_y))
        ...     return -slow * order_x, -slow * order_y
        >>> Scene.from_dict({}).term("order", brake).set("terms.W", 0.5).stability().text.count("by differences")
        1

        Functions are slow: Python calls them, one thread at a time, at every few hundred points. Linear theory takes
        their slopes by differences; boundary() calls them many thousand times for each point, for minutes to hours.
        `degree` is their degree as a polynomial in the fields, for exact dealiasing; without it products count as
        cubic, and aliases may remain. For a density the function is the flux, `flux=`. An archive keeps name and source
        only: restart() needs the function again, and drover sweep refuses it.
        """
        if self.kind != "fields":
            raise Error(f"a term of {of} in a scene of {'a model of its own' if self.kind == 'model' else self.kind}; "
                        "expected a scene of the shipped fields" +
                        (": write the term in the equation of its field" if self.kind == "model" else ""))
        function = function_of(of, value, flux)
        if function is not None:
            table = {**function_table(of, function, parameters), "degree": 0 if degree is None else degree}
        elif degree is not None:
            raise Error(f"degree = {degree} of a term as text, whose degree is known; expected none")
        else:
            table = {"of": of, **({"value": value} if flux is None else {"flux": flux})}
        if explicit:
            table["explicit"] = True
        if parameters:
            table["parameters"] = parameters
        text = self._text.rstrip("\n") + "\n\n" + scene_text({"terms": [table]})
        functions = self._functions
        if function is not None:
            functions = {**functions, len(self.values.get("terms", [])) + 1: _drover.TermFunction(function)}
        return restored(text, self._name, self._settings, functions)

    @property
    def settings(self):
        """What set() has changed, as "section.key=value"."""
        return self._settings

    @property
    def name(self):
        """The file, or the name given to parse()."""
        return self._name

    @property
    def kind(self):
        """"fields", "particles", or "model": fields and equations of the scene's own."""
        return self._native.kind

    @property
    def values(self):
        """Every key with its value: values["grid"]["nx"].  A copy: set() makes another scene."""
        return deepcopy(self._tables)

    @property
    def _tables(self):
        if self._values is None:
            self._values = tomllib.loads(self._native.text)
        return self._values

    def __getitem__(self, key):
        section, _, name = str(key).rpartition(".")
        tables = [self._tables]
        for part in section.split("."):
            part, number = LISTED.fullmatch(part).groups() if LISTED.fullmatch(part) else (part, None)
            tables = [table[part] for table in tables if part in table]
            tables = tables[0] if tables and isinstance(tables[0], list) else tables  # [[terms]]
            tables = tables if number is None else tables[int(number) - 1:int(number)]
        for table in tables:
            for values in (table, table.get("parameters", {})):
                if name in values:
                    return values[name]
        raise KeyError(f"{key}; expected one of the keys of scene.keys()")

    def __contains__(self, key):
        try:
            self[key]
        except KeyError:
            return False
        return True

    def __iter__(self):
        return iter(self.keys())

    def keys(self):
        """The keys of this kind of scene, "section.key"; of its own fields also "field[1].noise", "coefficients.a"."""
        rows = described(self.kind)
        if self.kind != "model":
            return list(rows)
        own = [(f"{name}[{number}]", table) for name in ("field", "white_noise", "tabulated")
               for number, table in enumerate(self.values.get(name, []), 1)]
        own += [(name, table) for name, table in self.values.items() if isinstance(table, dict)]
        return list(dict.fromkeys([*(f"{section}.{key}" for section, table in own for key in table),
                                   *(key for key in rows if not key.startswith("["))]))

    def describe(self, key):
        """Type, unit, range, default and meaning of a key, as a dict.

        >>> Scene.from_dict({}).describe("grid.lx")["unit"]
        'mm'
        """
        rows, (section, _, name) = described(self.kind), str(key).partition(".")
        row = rows.get(LISTED.sub(r"[\1]", section) + "." + name)
        if row is None and key in self.keys():  # a name of the scene's own
            row = {"name": name, "doc": next(part["doc"] for part in json.loads(_drover.schema(self.kind))
                                             if part["name"] == section)}
        if row is None:
            raise Error(f"{key} is not a key of a scene of {self.kind}; expected one of the keys of scene.keys()")
        return dict(row)

    _ipython_key_completions_ = keys

    def __repr__(self):
        changed = "".join(f", {setting}" for setting in self._settings)
        return f"<drover.Scene {self._name}: {self.kind}{changed}>"

    def __eq__(self, other):
        return isinstance(other, Scene) and self.to_toml() == other.to_toml()

    __hash__ = None

    def __reduce__(self):
        functions = {number: held.function for number, held in self._functions.items()}
        return restored, (self._text, self._name, list(self._settings), *([functions] if functions else []))

    def to_toml(self):
        """Every key with its value, as TOML that reads back as the same scene."""
        return self._native.text

    @property
    def model(self):
        """The fields and equations of its own as a Model: scene.model.growth_rates(...), .latex."""
        from drover.model import model_of
        return model_of(self.values, self._name)

    def _repr_html_(self):
        from drover.scene_page import keys_html, scene_html
        return scene_html(self) if self.kind == "model" else keys_html(self)

    def check(self):
        """Whether the scene fits on this machine: raises Error, or returns what to be careful about."""
        with hdf5():
            return _drover.check(self._native)

    def explain(self):
        """Fields and terms, or particles, and costs: memory and disk [bytes], wall time [s]; a dict.

        >>> Scene.from_dict({"time.dt": 0.1}).explain()["form"]
        'rods only'
        """
        with hdf5():
            return json.loads(_drover.explain(self._native))

    def start(self):
        """A run in memory, at t = 0; see Simulation.  It writes no files."""
        from drover.simulation import Simulation
        return Simulation(self)

    def run(self, output=None, *, accuracy=(), threads=0, overwrite=False, quiet=True):
        """Runs to time.end and writes an archive, as `drover run`; returns the open archive.

        `accuracy`: first finds the cheapest run with these errors, "polar_order=1%" or a list, by trials of at most a
        tenth of the run, which are kept in a folder beside the archive.

        `output` is the archive; default: the name of the scene with .h5, in the working folder.  After Ctrl-C, which
        raises KeyboardInterrupt, drover.restart(archive) resumes.  The run has a process of its own, unless a term is a
        Python function.

        >>> scene = Scene.from_dict({"grid": {"nx": 16, "ny": 16}, "time": {"dt": 0.1, "end": 2.0}})
        >>> with scene.run("short.h5") as run:
        ...     run.frames.rod_density.dims
        ('time', 'y', 'x')
        """
        scene = self.with_output(output, threads)
        if accuracy:
            from drover.tradeoffs import with_accuracy
            scene = with_accuracy(scene, accuracy, quiet)
        from drover.archive import open_run
        if scene._functions:
            with hdf5():
                done = _drover.run_scene(scene._native, overwrite, quiet)
        else:
            from drover.worker import call
            done = call("run_scene", scene, overwrite=overwrite, quiet=quiet)
        return open_run(done["archive"])

    def with_output(self, output=None, threads=0):
        """A scene with another archive or number of threads, as --output and --threads of the commands."""
        changes = {} if output is None else {"output.file": os.fspath(output)}
        if threads:
            changes["run.threads"] = threads
        return self.set(changes) if changes else self

    def stability(self, output=None, *, threads=0, overwrite=False):
        """Linear stability of the uniform states, as `drover stability`: a Theory.

        stability().growth_rate is that of the most ordered state, over angle [degree], wavenumber [1/mm] and branch.
        With `output` it is also written to an archive.

        >>> scene = Scene.from_dict({"relaxation.rate": 0.5, "grid": {"nx": 16, "ny": 16}})
        >>> theory = scene.stability()
        >>> theory.growth_rate.dims, theory.growth_rate.units, bool(theory.growth_rate.max() < 0.1)
        (('angle', 'wavenumber', 'branch'), 's-1', True)
        """
        return computed(_drover.stability, self, output, overwrite, threads=threads)

    def boundary(self, x=None, y=None, *, conventions=(), draws=None, output=None, threads=0, overwrite=False,
                 slurm=0):
        """Phase boundaries in a plane of two numbers, as `drover boundary`: a Theory.

        x and y are axes: ("driving.strength", 5, 60), or "driving.strength = 5:60"; default: those of the scene.
        `draws` of all numbers with errors give the error bands; 0: none.  `slurm=20` submits 20 jobs to Slurm, which
        write the archive `output`, and returns a campaign.Submitted with status() and collect() at once.

        >>> scene = Scene.from_dict({"relaxation.saturation": 1.0, "boundary.map": 0})
        >>> line = scene.boundary(("relaxation.rate", -1, 1), ("elasticity.stiffness", 0.5, 1))
        >>> float(abs(line.x[line.limit == 0]).max())   # onset: the relaxation rate is 0
        0.0
        """
        changes = {f"boundary.{name}": range_text(axis) for name, axis in (("x", x), ("y", y)) if axis is not None}
        if draws is not None:
            changes["boundary.draws"] = draws
        if conventions:
            changes["boundary.conventions"] = [conventions] if isinstance(conventions, str) else list(conventions)
        scene = self.set(changes) if changes else self
        if not slurm:
            return computed(_drover.boundary, scene, output, overwrite, threads=threads)
        file = folder_for_jobs(output)
        scene = submit("boundary", scene, file, slurm)
        shares = file + ".shares"
        return Submitted(shares, lambda: _drover.boundary_status(scene._native, shares),
                         lambda: computed(_drover.boundary, scene, None, False, threads=threads, collected=shares))

    def states(self, wave="x", *, speed=None, settle=None, follow="", points=60, output=None, threads=0,
               overwrite=False):
        """Travelling and standing states, stable or not, as `drover states`: a Theory with groups.

        `speed` [mm/s] is a guess, `settle` [s] lets the guess evolve first, `follow` = "relaxation.rate = 1.2" follows
        the state past folds with at most `points` states.
        """
        if wave != "x":
            raise Error(f'wave = "{wave}"; expected "x", along which the state varies and travels')
        if not isinstance(follow, str):
            raise Error(f'follow = {follow!r}; expected a key and its last value, "section.key = 1.2"')
        return computed(_drover.states, self, output, overwrite, threads=threads, speed=speed, settle=settle,
                        follow=follow, points=points)


def flat(changes):
    """("section.key", value) of {"section.key": value} or {"section": {"key": value}}."""
    for name, value in changes.items():
        yield from ((f"{name}.{key}", part) for key, part in value.items()) if isinstance(value, dict) else [
            (name, value)]


def computed(function, scene, output, overwrite, **options):
    from drover.computed import theory_of
    threads = options["threads"]
    if not isinstance(threads, int) or not 0 <= threads <= 1024:
        raise Error(f"threads = {threads!r}; expected 1 to 1024, or 0: as the scene has it")
    with hdf5():
        result = function(scene._native, **options)
        if output is not None:
            result.write(os.fspath(output), overwrite)
    return theory_of(result, scene.name)


def restored(text, name, settings, functions=None):
    held = held_functions(functions or {})
    with hdf5():
        native = _drover.Scene.parse(text, name, list(settings), held)
    return Scene(native, text, name, settings, held)


def range_text(axis):
    if isinstance(axis, str):
        return axis
    if not isinstance(axis, (list, tuple)) or len(axis) != 3:
        raise Error(f'the axis {axis!r}; expected a key with its first and last value, ("section.key", 5, 60)')
    key, first, last = axis
    return f"{key} = {value_text(first)}:{value_text(last)}"


LISTED = re.compile(r"(\w+)\[([1-9]\d*)\]")  # field[1]: the first table [[field]]
KNOWN = {}  # of each kind; read once, since the keys of a build do not change


def described(kind):
    """{"section.key": its row of the schema} of the scenes of a kind."""
    if kind not in KNOWN:
        sections = json.loads(_drover.schema(kind))
        KNOWN[kind] = {f"{section['name']}.{row['name']}": row for section in sections for row in section["rows"]}
    return KNOWN[kind]
