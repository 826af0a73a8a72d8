"""drover/model.py: models of declared fields and equations in vector notation, their linear theory, runs in memory."""
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from numbers import Real
from types import MappingProxyType, NoneType

import numpy as np

from drover.error import Error
from drover.model_run import ModelRun, pair_of


@dataclass(frozen=True)
class Field:
    """One declared field with its equation.

    symbol            as in equations: "phi"; `name`, if given, names it in datasets
    equation          the right-hand side of d_t: "lap(phi^3 - phi - lap phi)"
    spin              0: a scalar; 1: a vector; 2: a nematic Q_xx + i Q_xy; m: turns by m times the angle
    odd               changes sign under reflections: a pseudoscalar
    mass              m of m d_t F = equation: "m rho"
    balance           0 = equation: the field follows the others at every instant
    conserved         the mean does not change; an equation that is no divergence is an error (of scalars)
    reference         of a scalar: the uniform value about which the linear part is exact, and at which a run starts;
                      a number, or a formula of the coefficients: "rho0"
    noise             D: each component of d_t F has white noise, <f f> = D delta(r - r') delta(t - t'); as reference
    conserved_noise   the noise is the divergence of a random flux: D q^2
    solenoidal        a vector without divergence: a pressure keeps it so at every instant
    complex           two scalars, A = A_re + i A_im, which do not turn; spin is 0
    energy            what output.powers calls the integral of mass F^2/2: "flow"; "": `name`; "none": not measured
    mass_unit         unit of the mass, for that energy

    >>> Field("phi", "lap mu", conserved=True).spin
    0
    """

    symbol: str
    equation: str = ""
    spin: int = 0
    name: str = ""
    odd: bool = False
    unit: str = "1"
    meaning: str = ""
    mass: str = ""
    balance: bool = False
    conserved: bool = False
    reference: float | str = 0.0
    noise: float | str = 0.0
    conserved_noise: bool = False
    solenoidal: bool = False
    complex: bool = False
    energy: str = ""
    mass_unit: str = "1"

    def __post_init__(self):
        for key, value in list(vars(self).items()):
            if np.ndim(value) == 0 and isinstance(value, (np.generic, np.ndarray)):
                object.__setattr__(self, key, value.item())  # numbers of numpy are numbers

    @property
    def components(self):
        """Names of the components: ("p_x", "p_y") of a vector."""
        ends = {0: ("_re", "_im") if self.complex else ("",),
                1: ("_x", "_y"), 2: ("_xx", "_xy")}.get(self.spin, ("_1", "_2"))
        return tuple((self.name or self.symbol) + end for end in ends)

    @property
    def parts(self):
        """The fields of a run: this one, or the two scalars of a complex one."""
        if not self.complex:
            return (self,)
        return tuple(replace(self, complex=False, symbol=self.symbol + end, name=(self.name or self.symbol) + end,
                             reference=self.reference if end == "_re" else 0.0) for end in ("_re", "_im"))


@dataclass(frozen=True)
class Noise:
    """White noise of unit strength, a name in equations: <xi xi> = delta(r - r') delta(t - t') for each component.

    Fields whose equations have it are driven by the same noise.

    symbol, spin, odd   as of a Field

    >>> model = Model([Field("a", "-a + xi"), Field("b", "-b - xi")], noises=[Noise("xi")])
    >>> float(model.structure_factors([1.0]).sel(component="a", with_component="b").real[0])
    -0.5
    """

    symbol: str
    spin: int = 0
    odd: bool = False


@dataclass(frozen=True)
class Table:
    """A coefficient that is a smooth function of one or two scalars: cubic splines through its values.

    symbol     as in equations
    of         the scalars, as formulas of the fields: ("rho",), ("rho", "sigma")
    first      values of the first scalar, ascending
    values     values of the coefficient: for each of `first` those of all of `second`
    second     values of the second scalar, ascending; empty: there is one scalar
    outside    beyond the table: "refuse": an error; "hold": the value at its edge

    >>> model = Model([Field("n", "-a n", reference=1.0)], tables=[Table("a", ("n",), (0.0, 2.0), (1.0, 3.0))])
    >>> float(model.rates()[0]), float(model.growth_rates([0.0]).growth_rate[0, 0])
    (-2.0, -3.0)
    """

    symbol: str
    of: tuple
    first: tuple
    values: tuple
    second: tuple = ()
    outside: str = "refuse"

    def __post_init__(self):
        shape = (len(self.first), len(self.second)) if len(self.second) else (len(self.first),)
        if np.ndim(self.values) > 1 and np.shape(self.values) != shape:
            raise Error(f"the values of the table {self.symbol} have the shape {np.shape(self.values)}; expected "
                        f"{shape}: rows of `first`, columns of `second`")
        for key in ("first", "second", "values"):
            object.__setattr__(self, key, tuple(np.ravel(np.asarray(getattr(self, key), dtype=float)).tolist()))
        object.__setattr__(self, "of", (self.of,) if isinstance(self.of, str) else tuple(self.of))
        if not all(isinstance(formula, str) for formula in self.of):
            raise Error(f"the table {self.symbol} is of {self.of!r}; expected formulas of fields, as texts")


KINDS = {key: (int, float, str) if kind == float | str else kind for key, kind in Field.__annotations__.items()}
CALCULI = ("ito", "stratonovich")
RANKS = ("scalar", "vector", "nematic")  # of spin 0, 1, 2


def model_of(values, of="this scene"):
    """The Model of a scene, {section: {key: value}} with every key, as Scene.values or in an archive."""
    if not values.get("field"):
        raise Error(f"{of} has no fields and equations of its own; expected a scene with [[field]]")
    equations, header = values.get("equations", {}), values.get("model", {})
    fields = [Field(symbol=table["symbol"], equation=str(equations.get(table["symbol"], "")),
                    spin=spin_of(table), complex=is_complex(table),
                    odd=table.get("parity", "even") == "odd",
                    **{key: number_or_text(table[key]) if key in ("reference", "noise") else table[key]
                       for key in SCENE_KEYS if key in table}) for table in values["field"]]
    noises = [Noise(symbol=table["symbol"], spin=spin_of(table), odd=table.get("parity", "even") == "odd")
              for table in values.get("white_noise", [])]
    define = {name: str(text) for name, text in values.get("define", {}).items()}
    tables = [Table(**table) for table in values.get("tabulated", [])]
    return Model(fields, noises=noises, tables=tables, define=define,
                 **{key: header[key] for key in ("chiral", "calculus") if key in header},
                 coefficients=values.get("coefficients", {}))


def spin_of(table):
    """Of a [[field]] or a [[white_noise]]."""
    return table["spin"] if table.get("spin", -1) >= 0 else 0 if is_complex(table) else RANKS.index(
        table.get("rank", "scalar"))


def is_complex(table):
    return table.get("rank") == "complex" and table.get("spin", -1) < 0


def number_or_text(value):
    """A number that a scene has as a text, or a formula."""
    try:
        return float(value)
    except ValueError:
        return value


def waves_at(wavenumbers, angle):
    """(q_x, q_y) of each |q|, at an angle to the x axis."""
    try:
        numbers = np.atleast_1d(np.asarray(wavenumbers, dtype=float))
    except (TypeError, ValueError):
        raise Error(f"the wavenumbers are {wavenumbers!r}; expected a number or a list of them") from None
    if not numbers.size:
        raise Error("no wavenumbers; expected at least one")
    if numbers.ndim != 1:
        raise Error(f"the wavenumbers have the shape {numbers.shape}; expected a list of numbers")
    wrong = numbers[~(np.isfinite(numbers) & (numbers >= 0))]
    if wrong.size:
        raise Error(f"wavenumber {wrong[0]}; expected finite ones >= 0")
    if not isinstance(angle, Real) or not np.isfinite(angle):
        raise Error(f"angle = {angle!r}; expected a finite number")
    return [(q * np.cos(angle), q * np.sin(angle)) for q in numbers]


SCENE_KEYS = ("name", "unit", "meaning", "mass", "balance", "conserved", "solenoidal", "reference", "noise",
              "conserved_noise", "energy", "mass_unit")


def noise_table(noise):
    """A noise as a table of a scene, or what a field has too."""
    rank = {"rank": RANKS[noise.spin]} if 0 < noise.spin < len(RANKS) else {"spin": noise.spin} if noise.spin else {}
    return {"symbol": noise.symbol, **rank, **({"parity": "odd"} if noise.odd else {})}


def field_table(field):
    """A field as a table of a scene, without what is as by default."""
    changed = [key for key in SCENE_KEYS if getattr(field, key) != getattr(Field, key)]
    rank = {"rank": "complex"} if field.complex else {}
    return noise_table(field) | rank | {key: getattr(field, key) for key in changed}


def all_of(kind, name, given):
    """One of a kind, several, or none, as a tuple."""
    if isinstance(given, kind):
        return (given,)
    if not isinstance(given, (Iterable, NoneType)) or isinstance(given, str):
        raise Error(f"{name} = {given!r}; expected a list of drover.{kind.__name__}")
    return () if given is None else tuple(given)


def check(fields, noises, tables, define, chiral, coefficients):
    """Raises Error for arguments of another type, and for components of one name."""
    def expect(name, value, kind):
        kinds = kind if isinstance(kind, tuple) else (kind,)
        if not isinstance(value, kinds) or (isinstance(value, bool) and bool not in kinds):
            raise Error(f"{name} = {value!r}; expected {' or '.join(one.__name__ for one in kinds)}")

    names = {}
    for field in fields:
        if not isinstance(field, Field):
            raise Error(f"{field!r} is not a field; expected drover.Field(symbol, equation, ...)")
        for key, kind in KINDS.items():
            expect(f"{key} of the field {field.symbol}", getattr(field, key), kind)
        for name in field.components:
            if names.setdefault(name, field) is not field:
                raise Error(f"{name} is a component of {names[name].symbol} and of {field.symbol}; expected another "
                            "name")
        if field.complex and field.spin:
            raise Error(f"{field.symbol} is complex and has spin {field.spin}; expected spin 0: it does not turn")
        if field.spin < 0:
            raise Error(f"{field.symbol} has spin {field.spin}; expected 0 or more")
    for noise in noises:
        if not isinstance(noise, Noise):
            raise Error(f"{noise!r} is not a noise; expected drover.Noise(symbol, spin)")
        for key in ("symbol", "spin", "odd"):
            expect(f"{key} of the noise {noise.symbol}", getattr(noise, key), KINDS[key])
        if noise.spin < 0:
            raise Error(f"the noise {noise.symbol} has spin {noise.spin}; expected 0 or more")
    for table in tables:
        if not isinstance(table, Table):
            raise Error(f"{table!r} is not a table; expected drover.Table(symbol, of, first, values)")
    expect("chiral", chiral, bool)
    for name, text in define.items():
        expect(f"the definition of {name}", text, str)
    for name, value in coefficients.items():
        if not isinstance(value, (int, float, np.number)) or isinstance(value, bool):
            raise Error(f"the coefficient {name} = {value!r}; expected a number")


def remade(fields, options):
    """A copy of a model, from a pickle."""
    return Model(fields, **options)


class Model:
    """Fields, the equations that couple them, named parts of these, and the values of their coefficients.

    The linear part about the reference is exact in runs, noise included; linear theory is of the same equations.
    noises: white noises that the equations name, each a Noise.  tables: coefficients by their values, each a Table.
    calculus: the sense of noise that multiplies fields, "ito" or "stratonovich"; the drift of the second depends on the
    grid, so that theory and runs of such a model are those of its scene.
    Coefficients are keyword arguments, with a warning where no equation has one, or, for names such as "lambda" and
    "define", in `coefficients`.  Errors give the place as "symbol.equation:1:column".

    >>> model = Model([Field("phi", "D lap phi - k phi", noise=0.5)], D=2.0, k=1.0)
    >>> float(model.growth_rates([3.0]).growth_rate[0, 0])
    -19.0
    >>> run = model.start(points=16, side=8.0, dt=0.1, seed=3).advance(2.0)
    >>> run.fields.phi.shape
    (16, 16)
    """

    def __init__(self, fields, /, *, noises=(), tables=(), define=None, chiral=False, calculus="ito",
                 coefficients=None, **more):
        from drover._drover import Equations

        self.fields, self.noises = all_of(Field, "fields", fields), all_of(Noise, "noises", noises)
        self.tables = all_of(Table, "tables", tables)
        for name, given in (("define", define), ("coefficients", coefficients)):
            if not isinstance(given, (Mapping, NoneType)):
                raise Error(f"{name} = {given!r}; expected a dictionary of names and values")
        twice = sorted({*(coefficients or {})} & {*more})
        if twice:
            raise Error(f"the coefficient {twice[0]} is given twice; expected it once")
        self.coefficients = MappingProxyType({**(coefficients or {}), **more})  # compiled: a change has no effect
        self.define, self.chiral, self.calculus = MappingProxyType(dict(define or {})), chiral, calculus
        if calculus not in CALCULI:
            raise Error(f"calculus = {calculus!r}; expected {' or '.join(map(repr, CALCULI))}")
        check(self.fields, self.noises, self.tables, self.define, chiral, self.coefficients)
        self._equations = Equations([{**vars(field), "name": field.name or field.symbol} for field in self.fields],
                                    [vars(noise) for noise in self.noises],
                                    [vars(table) for table in self.tables], dict(self.define),
                                    {key: float(value) for key, value in self.coefficients.items()}, chiral, list(more))

    def __reduce__(self):
        return remade, (self.fields, {"noises": self.noises, "tables": self.tables, "define": dict(self.define),
                                      "chiral": self.chiral, "calculus": self.calculus,
                                      "coefficients": dict(self.coefficients)})

    @property
    def terms(self):
        """(symbol of the field, summand of its equation), as written."""
        return [(self.parts[field].symbol, text) for field, text in self._equations.terms()]

    @property
    def latex(self):
        """The equations as LaTeX, one line each."""
        lines = [self._equations.latex(self.parts.index(field.parts[0])).replace(" = ", " &= ", 1)
                 for field in self.fields]
        return r"\begin{aligned}" + r" \\ ".join(lines) + r"\end{aligned}"

    def _repr_latex_(self):
        return f"$\\displaystyle {self.latex}$"

    def __repr__(self):
        return "\n".join(f"{'0' if f.balance else f'({f.mass}) d_t {f.symbol}' if f.mass else f'd_t {f.symbol}'}"
                         f" = {f.equation or '0'}" for f in self.fields)

    @property
    def parts(self):
        """The fields of a run: of a complex field its two scalars."""
        return tuple(part for field in self.fields for part in field.parts)

    @property
    def noise_strengths(self):
        """D of the noise of each of the parts, as a number."""
        return self._equations.noise_strengths()

    @property
    def components(self):
        """Names of all components, in the order of symbols and states."""
        return tuple(name for field in self.fields for name in field.components)

    @property
    def transforms(self):
        """(inverse, forward) Fourier transforms of one evaluation of the explicit part."""
        return self._equations.transforms()

    def state(self, /, **values):
        """A uniform state by components: the reference, with other values by symbol: state(phi=0.3, p=(1.0, 0.0))."""
        state, at = np.array(self._equations.reference()), 0
        for field in self.fields:
            width = len(field.components)
            if field.symbol in values:
                value = values.pop(field.symbol)
                pair = field.complex and np.ndim(value) == 0
                given = np.atleast_1d(np.asarray([np.real(value), np.imag(value)] if pair else value, dtype=float))
                if given.shape != (width,):
                    raise Error(f"{field.symbol} has {given.size} values; expected {width}: "
                                + ", ".join(field.components))
                state[at:at + width] = given
            at += width
        if values:
            raise Error(f"{next(iter(values))} is not a field of this model; expected one of "
                        + ", ".join(field.symbol for field in self.fields))
        return state

    def rates(self, state=None):
        """d/dt of a uniform state, by components.  Raises Error where a function or a table has no value."""
        rates = self._equations.uniform_rates(self._of(state))
        for name, rate in zip(self.components, rates):
            if not np.isfinite(rate):
                raise Error(f"the rate of {name} is {rate} in this state; expected one in which all functions and "
                            "tables have values")
        return rates

    def symbol(self, q, state=None):
        """The matrix M of d_t a = M a for small waves a exp(i q.r) about a uniform state, by components."""
        if np.shape(q) != (2,):
            raise Error(f"q = {q!r}; expected its two components, (q_x, q_y)")
        return self._equations.symbol(self._of(state), *map(float, q))

    def growth_rates(self, wavenumbers, angle=0.0, state=None):
        """growth_rate and frequency of the waves (wavenumber, branch) about a uniform state; the fastest first.

        angle: of q to the x axis.
        """
        import xarray

        found = self._equations.mode_rates(self._of(state), waves_at(wavenumbers, angle))
        found = [sorted(at, key=lambda s: (-s.real, s.imag)) for at in found]
        rates, dims = np.full((len(found), max(map(len, found))), complex("nan+nanj")), ("wavenumber", "branch")
        for row, at in zip(rates, found, strict=True):  # at q = 0 a solenoidal field has a mode more
            row[:len(at)] = at
        return xarray.Dataset({"growth_rate": (dims, rates.real), "frequency": (dims, -rates.imag)},
                              {"wavenumber": np.atleast_1d(wavenumbers)})

    def structure_factors(self, wavenumbers, angle=0.0, state=None):
        """S = <a a^H> per area of the stationary linear theory: (wavenumber, component, with_component), complex.

        Solves M S + S M^H + Q = 0.  Raises Error where a mode grows, or does not decay and noise drives it.
        """
        import xarray

        names = [self.components[k] for k in self._equations.state_components()]
        result = self._equations.covariances(self._of(state), waves_at(wavenumbers, angle))
        return xarray.DataArray(np.array(result), dims=("wavenumber", "component", "with_component"),
                                coords={"wavenumber": np.atleast_1d(wavenumbers), "component": names,
                                        "with_component": names})

    def start(self, points, side, dt, *, method="etdrk4-krogstad", seed=1, threads=1):
        """A run in memory, at time 0 with all fields at their reference.

        points, side: of the periodic grid; one number, or two along x and y (1 point along y: a line).
        dt: the step; method: a name of `drover schema time` but cvode-* and arkode-*, which a scene has.  Runs of dt
        and dt/2 with one seed share their noise, so their difference measures the error of the step.
        """
        return ModelRun(self, pair_of("points", points), pair_of("side", side), float(dt), method, seed, threads)

    def scene(self, points, side, dt, end, *, initial=None, method="etdrk4-krogstad", tolerance=0.0, seed=1,
              name="model"):
        """The Scene of a run of this model to the time `end`, which writes an archive: scene.run("model.h5").

        points, side, dt, seed: as of start().  method: any of time.stepper of a scene.  tolerance: time.tolerance,
        which the cvode methods need; 0: steps of dt.  initial: {component: formula in x and y, or number}, or the keys
        of [initial], such as {"kind": "random", "amplitude": 0.01}; default: the reference.  name: of the file.
        Samples are 0.1 apart, and frames 1.0, or the next multiple of dt.

        >>> model = Model([Field("phi", "lap(phi^3 - phi - lap phi)", conserved=True)])
        >>> scene = model.scene(points=32, side=32.0, dt=0.1, end=1.0, initial={"phi": "0.1 cos(2 pi x / 32)"})
        >>> scene.model.latex == model.latex, scene["initial.kind"]
        (True, 'formula')
        """
        from drover.scene import Scene

        (nx, ny), (lx, ly) = pair_of("points", points).tolist(), pair_of("side", side).tolist()
        start = dict(initial or {})
        if not start.keys().isdisjoint(self.components):
            start = {"kind": "formula", **start}
        return Scene.from_dict({
            "model": {"name": name, **({"chiral": True} if self.chiral else {}),
                      **({"calculus": self.calculus} if self.calculus != "ito" else {})},
            "field": [field_table(field) for field in self.fields],
            "white_noise": [noise_table(noise) for noise in self.noises],
            "tabulated": [vars(table) for table in self.tables],
            "equations": {field.symbol: field.equation for field in self.fields},
            "define": dict(self.define),
            "coefficients": {key: float(value) for key, value in self.coefficients.items()},
            "grid": {"nx": nx, "ny": ny, "lx": float(lx), "ly": float(ly)},
            "time": {"dt": float(dt), "end": float(end), "stepper": method, "tolerance": float(tolerance)},
            "initial": start,
            "output": {key: float(dt * np.ceil(every / dt - 1e-9)) if dt > 0 else every
                       for key, every in (("sample_every", 0.1), ("frame_every", 1.0))},
            "run": {"seed": seed}}, f"{name}.toml")

    def _require_no_grid(self):
        if self.calculus != "ito":
            raise Error("the drift of noise in the sense of Stratonovich depends on the grid; expected a scene of it: "
                        "model.scene(points=..., side=..., dt=..., end=...), and its theory from drover stability")

    def _of(self, state):
        self._require_no_grid()
        if isinstance(state, dict):
            return self.state(**state)
        if state is None:
            return self._equations.reference()
        try:
            return [float(value) for value in state]
        except (TypeError, ValueError):
            raise Error(f"state = {state!r}; expected values by field, such as {{\"{self.fields[0].symbol}\": 0.5}}, "
                        "or a number of each component: " + ", ".join(self.components)) from None
