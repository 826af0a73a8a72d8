"""drover/toml.py: Python values as TOML."""
import json
import math

from drover.error import Error


def value_text(value):
    """A number, text, flag or list as TOML.

    >>> value_text([1, 2.5, "a"]), value_text(True), value_text(float("inf"))
    ('[1, 2.5, "a"]', 'true', 'inf')
    """
    if hasattr(value, "tolist"):  # of NumPy
        value = value.tolist()
    if isinstance(value, (bool, int)):
        return json.dumps(value)
    if isinstance(value, float):
        return repr(value) if math.isfinite(value) else str(value)
    if isinstance(value, str):
        return json.dumps(value, ensure_ascii=False).replace("\x7f", "\\u007F")
    if isinstance(value, (list, tuple)):
        return "[" + ", ".join(value_text(item) for item in value) + "]"
    if isinstance(value, dict):
        return "{ " + ", ".join(f"{json.dumps(str(key))} = {value_text(item)}" for key, item in value.items()) + " }"
    raise Error(f"{value!r} is of type {type(value).__name__}; expected a number, a text, True or False, or a list")


LISTS = ("terms", "field", "white_noise", "tabulated")  # sections of several tables, [[terms]]


def scene_text(sections):
    """The TOML text of {"section": {"key": value}} or {"section.key": value}; lists of dicts are [[section]].

    >>> print(scene_text({"grid": {"nx": 64}, "time.end": 5.0}), end="")
    [grid]
    nx = 64
    [time]
    end = 5.0
    """
    tables = {}
    for name, value in sections.items():
        if not isinstance(name, str):
            raise Error(f"the key {name!r}; expected a section or section.key as text, such as grid.nx")
        if name in LISTS and isinstance(value, (list, tuple)):
            tables[name] = value
        elif isinstance(value, dict):
            add_table(tables, name, value)
        else:
            section, dot, key = name.rpartition(".")
            if not dot:
                raise Error(f"{name} = {value!r} is outside a section; expected section.key, such as grid.nx")
            tables.setdefault(section, {})[key] = value
    text = ""
    for name, table in tables.items():
        blocks = table if isinstance(table, (list, tuple)) else [table]
        head = f"[{name}]" if isinstance(table, dict) else f"[[{name}]]"
        for block in blocks:
            text += head + "\n" + "".join(f"{key} = {value_text(value)}\n" for key, value in block.items())
    return text


def add_table(tables, name, table):
    inner = {key: value for key, value in table.items() if isinstance(value, dict)}
    tables.setdefault(name, {}).update({key: value for key, value in table.items() if key not in inner})
    for key, value in inner.items():
        add_table(tables, f"{name}.{key}", value)
