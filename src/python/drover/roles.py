"""drover/roles.py: the fields of a run by what they are: scalars, densities, vectors, nematics."""
from dataclasses import dataclass

import numpy

from drover.archive import loaded
from drover.error import Error
from drover.fields import has_noise, shipped_fields
from drover.text import drawable
from drover.typeset import named, simple_unit, symbol_text

ZERO = 1e-12        # smaller components are rounding errors
SIGNED_FROM = 0.05  # of its range, on either side of its centre: a field with two signs


@dataclass(frozen=True)
class Role:
    """One field of a run."""

    name: str
    symbol: str           # as mathtext, without dollars
    spin: int             # 0: scalar, 1: vector, 2: nematic
    components: tuple     # names of its arrays
    unit: str = "1"
    is_density: bool = False  # with noise, that of few bodies in a cell of the grid
    is_number: bool = False   # a conserved number per area, which noise alone makes negative
    is_flow: bool = False     # a vector of mm/s
    reference: float = 0.0
    key: str = ""         # its symbol as equations have it
    short: str = ""       # its name in structure factors, where it is another
    number: int = 0       # of its colour

    @property
    def words(self):
        return drawable(self.name.replace("_", " "))

    @property
    def title_words(self):
        """The name beside its symbol; nothing where it is the symbol."""
        return "" if symbol_text(self.name, self.spin) == self.symbol else self.words

    @property
    def label(self):
        """For legends."""
        return f"{self.short} ${self.symbol}$".lstrip()

    @property
    def size_words(self):
        """What a map shows by colour."""
        return f"magnitude of the {self.words}" if self.spin else self.words

    @property
    def size_symbol(self):
        """The symbol of what a map shows by colour."""
        return f"|{self.symbol}|" if self.spin else self.symbol

    def size(self, arrays):
        """The field itself, of a scalar, or its magnitude, of arrays by name."""
        first = arrays[self.components[0]]
        return numpy.hypot(first, arrays[self.components[1]]) if self.spin else first

    def centre(self, values):
        """0 or the reference, about which a scalar has both signs; None of a size, or of a density above 0.

        `values`: over (..., y, x).
        """
        if self.spin or self.is_number or values.size == 0:
            return None
        values = coarse(values) if self.is_density else values
        low, high = float(values.min()), float(values.max())
        for centre in (0.0,) if self.is_density else (0.0, self.reference):
            # Colours about it would reach signs that the field has nowhere.
            beyond = low >= 0.0 > 2.0 * centre - high or high <= 0.0 < 2.0 * centre - low
            if not beyond and min(centre - low, high - centre) > SIGNED_FROM * (high - low):
                return centre
        return None


def coarse(values, blocks=12):
    """Averages over blocks, about 12 along y and x: what is left of the noise of few bodies in a cell of the grid."""
    counts = [max(n for n in range(1, min(size, blocks) + 1) if size % n == 0) for size in values.shape[-2:]]
    rows, columns = (size // count for size, count in zip(values.shape[-2:], counts))
    return values.reshape(*values.shape[:-2], counts[0], rows, counts[1], columns).mean(axis=(-3, -1))


def has_own_fields(run):
    """Whether a run is of a scene with fields and equations of its own."""
    return "field" in run.scene


def roles_of(run):
    """The fields of a run, in their order in its scene, or in the model file for figures."""
    names = set(run.frames.data_vars)
    if not has_own_fields(run):
        return [role_of(run, number, field, field.conserved, short=short)
                for number, (field, short) in enumerate(shipped_fields().items()) if set(field.components) <= names]
    from drover.model import model_of
    model = model_of(run.scene, str(run.path))
    reference = dict(zip(model.components, model.state()))
    is_noisy = has_noise(run.scene)
    found = [field for field in model.parts if not field.balance or set(field.components) <= names]
    return [role_of(run, number, field, is_noisy and field.conserved and reference_of(field, reference) > 0.0,
                    reference_of(field, reference)) for number, field in enumerate(found)]


def role_of(run, number, field, is_density, reference=0.0, short=""):
    spin, unit = field.spin, simple_unit(run.frames[field.components[0]].attrs.get("units", "1"))
    is_number = spin == 0 and field.conserved and (bool(short) or simple_unit(field.unit) == "mm-2")
    return Role(field.name or field.symbol, symbol_text(field.symbol, spin), spin, field.components, unit,
                is_density=spin == 0 and is_density, is_number=is_number,
                is_flow=spin == 1 and unit == named("mm/s", run.scene) != "1", reference=reference, key=field.symbol,
                short=short, number=number)


def chosen(run, field):
    """The fields of a run: one by its name or symbol, or all."""
    roles = roles_of(run)
    if field is None:
        return roles
    found = [role for role in roles if field in (role.name, role.key)]
    if not found:
        raise Error(f'field = "{field}"; expected one of {", ".join(role.name for role in roles)}')
    return found


def maps_of(run, field=None):
    """What maps of a run show: the field by colours, and those of which the first that is not zero is by arrows.

    One map of a density with the order or the flow; of a scene with fields of its own, or of one `field`, each field
    with its own directions.
    """
    roles = chosen(run, field)
    if field is not None or has_own_fields(run):
        return [(role, [role] if role.spin in (1, 2) else []) for role in roles]
    return [(roles_first(roles), [role for role in roles if role.spin])]


def roles_first(roles):
    """The first scalar, or field."""
    return next((role for role in roles if not role.spin), roles[0])


def arrows_of(roles, arrays):
    """The first of the fields that is not zero in arrays by name, or the last; None of none."""
    return next((role for role in roles if max(float(abs(arrays[name]).max()) for name in role.components) > ZERO),
                next(reversed(roles), None))


def reference_of(field, values):
    return 0.0 if field.spin else float(values[field.components[0]])


def arrays_at(run, role, frame):
    """The components of a field at a frame, by name."""
    return {name: loaded(run.frames[name].isel(time=frame), run.path) for name in role.components}
