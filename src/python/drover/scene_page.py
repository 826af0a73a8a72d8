"""drover/scene_page.py: a scene as a page of a notebook: its equations, or its numbers that are not as by default."""
from html import escape

from drover import _drover
from drover.lookup import schema
from drover.shown import SETTINGS
from drover.text import printable
from drover.typeset import named, order_unit, simple_unit, spaced

# Sections of a scene of particles that say what it is of, not how it is computed.
PARTICLES = {"cell", "plates", "beads", "rods", "restitution", "friction", "kick", "forces"}


def scene_html(scene):
    """Equations, fields and coefficients of a scene with a model of its own."""
    model = scene.model
    names = {field.symbol: rf"\boldsymbol{{{_drover.latex_of_name(field.symbol)}}}" if field.spin == 1
             else rf"\mathsf{{{_drover.latex_of_name(field.symbol)}}}" if field.spin
             else _drover.latex_of_name(field.symbol) for field in model.fields}

    def typeset(formula):
        return f"${_drover.latex_of(str(formula), names)}$"

    noises = dict(zip((part.symbol for part in model.parts), model.noise_strengths))
    fields = [(typeset(field.symbol), field.name or field.symbol, rank_of(field), simple_unit(field.unit),
               "" if field.spin else typeset(field.reference),
               typeset(field.noise) + ", conserved" * field.conserved_noise if noises[field.parts[0].symbol] else "",
               field.meaning) for field in model.fields]
    parts = [f"<b>{escape(printable(scene.values['model'].get('name') or scene.name))}</b>",
             f"$$\\displaystyle {escape(model.latex)}$$"]
    if model.define:
        rows = [(typeset(name), "$=$", typeset(text)) for name, text in model.define.items()]
        parts.append(table(("definition", "", ""), rows))
    parts.append(table(("field", "name", "rank", "unit", "lookup", "noise", "meaning"), fields))
    if model.coefficients:
        parts.append(table(("coefficient", "value"),
                           [(typeset(name), f"{value:g}") for name, value in model.coefficients.items()]))
    return "".join(parts)


def keys_html(scene):
    """The numbers of a scene that are not as by default, with units and meanings, and its cell and duration."""
    values, rows = scene.values, []
    for section in schema(scene.kind):
        name = section["name"]
        is_physics = name in PARTICLES if scene.kind == "particles" else name == "uniform" or name not in SETTINGS
        for row in section["rows"] if is_physics else ():
            value = values.get(section["name"], {}).get(row["name"])
            if value is not None and value != row["default"]:
                rows.append((f"{section['name']}.{row['name']}", value_words(value),
                             order_unit(row.get("unit", "1"), values), row["doc"]))
    length, time = (spaced(named(unit, values)) for unit in ("mm", "s"))
    where = f"{values['time']['end']:g}{time}"
    if scene.kind == "fields":
        grid = values["grid"]
        where = f"{grid['nx']} × {grid['ny']} points, {grid['lx']:g} × {grid['ly']:g}{length}, {where}"
    return f"<b>{escape(printable(scene.name))}</b> ({where})" + table(("key", "value", "unit", "meaning"), rows)


def value_words(value):
    return f"{value:g}" if isinstance(value, float) else ", ".join(map(value_words, value)) \
        if isinstance(value, list) else str(value)


def rank_of(field):
    words = "complex" if field.complex else {0: "scalar", 1: "vector", 2: "nematic"}.get(field.spin,
                                                                                         f"spin {field.spin}")
    return f"odd {words}" if field.odd else words


def table(heads, rows):
    def cell(tag, text):
        return f'<{tag} style="text-align:left">{escape(printable(text))}</{tag}>'

    lines = [[cell("th", head) for head in heads], *([cell("td", text) for text in row] for row in rows)]
    return "<table>" + "".join(f"<tr>{''.join(line)}</tr>" for line in lines) + "</table>"
