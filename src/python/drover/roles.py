"""drover/roles.py: the fields of a run by what they are: scalars, densities, vectors, nematics."""
from dataclasses import dataclass

import numpy

from drover.archive import loaded
from drover.error import Error
from drover.text import drawable
from drover.typeset import named, symbol_text

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
    reference: float = 0.0

    @property
    def words(self):
        return drawable(self.name.replace("_", " "))

    @property
    def title_words(self):
        """The name beside its symbol; nothing where it is the symbol."""
        return "" if symbol_text(self.name, self.spin) == self.symbol else self.words

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
        if self.spin or values.size == 0:
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
    """The fields of a run of a scene with fields of its own, in their order there."""
    from drover.model import model_of
    model = model_of(run.scene, str(run.path))
    reference = dict(zip(model.components, model.state()))
    is_noisy = bool(model.noises) or any(model.noise_strengths)
    return [Role(field.name or field.symbol, symbol_text(field.symbol, field.spin), field.spin, field.components,
                 named(field.unit, run.scene),
                 is_noisy and field.spin == 0 and field.conserved and reference_of(field, reference) > 0.0,
                 reference_of(field, reference)) for field in model.parts
            if not field.balance or set(field.components) <= set(run.frames.data_vars)]


def chosen(run, field):
    """The fields of a run: one by its name or symbol in the scene, or all."""
    roles = roles_of(run) if has_own_fields(run) else []
    if not roles:
        raise Error("this run is not of a scene with fields of its own")
    if field is None:
        return roles
    symbols = {table["symbol"]: table.get("name") or table["symbol"] for table in run.scene["field"]}
    found = [role for role in roles if role.name == symbols.get(field, field)]
    if not found:
        raise Error(f'field = "{field}"; expected one of {", ".join(role.name for role in roles)}')
    return found


def reference_of(field, values):
    return 0.0 if field.spin else float(values[field.components[0]])


def arrays_at(run, role, frame):
    """The components of a field at a frame, by name."""
    return {name: loaded(run.frames[name].isel(time=frame), run.path) for name in role.components}
