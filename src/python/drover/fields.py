"""drover/fields.py: the fields of a scene: its own, or those of the model file of rods and beads."""
import json
from functools import cache

from drover.model import RANKS, Field, model_of


@cache
def model_file():
    """The model file that the library is built with."""
    from drover import _drover
    return json.loads(_drover.model_file())


def shipped_fields():
    """{Field: its short name} of the model file, in the order of figures."""
    return {Field(row["symbol"], name=row["name"], spin=RANKS.index(row.get("rank", "scalar")),
                  conserved=row.get("conserved", False)): row["short"]
            for row in sorted(model_file()["field"], key=lambda row: row["drawn"])}


def key_of(symbol):
    """Section and name of the key of a coefficient of the model file."""
    return next(row["key"] for row in model_file()["coefficient"] if row["symbol"] == symbol).split(".")


def fields_of(scene):
    """The fields of a scene (its tables) that have arrays in its archives."""
    if "field" in scene:
        return [field for field in model_of(scene).fields if not field.balance]
    chosen = scene.get("fields", {})
    return [field for field in shipped_fields() if chosen.get(field.name, True) not in (False, "absent")]


def has_noise(scene):
    """Whether noise drives any field of a scene (its tables)."""
    if "field" in scene:
        model = model_of(scene)
        return bool(model.noises) or any(model.noise_strengths)
    keys = (row["key"].split(".") for row in model_file()["coefficient"] if "noise_of" in row)
    return any(scene.get(section, {}).get(name) for section, name in keys)
