"""drover/typeset.py: symbols and units in figures."""
import re

from drover.text import drawable

UNIT = re.compile(r"\s*(?:(?P<open>\()|(?P<close>\))|(?P<over>/)|(?P<times>[*.])|(?P<word>[^\W\d_]+|%|1))"
                  r"(?:\^?(?P<power>[-+]?\d+))?")


def simple_unit(unit):
    """A product of units with each base once; as it is where it is no such product.

    >>> simple_unit("(1/mm^2)^2 mm2"), simple_unit("mg mm/s2"), simple_unit("(s)(1/s)"), simple_unit("[p] mm")
    ('mm-2', 'mg mm s-2', '1', '[p] mm')
    """
    stack, sign, at = [{}], [1], 0
    while at < len(unit):
        part = UNIT.match(unit, at)
        if part is None:
            return unit
        at, power = part.end(), int(part["power"] or 1)
        if part["over"]:
            sign[-1] = -1
            continue
        if part["open"]:
            stack.append({})
            sign.append(1)
        elif part["close"] or part["word"]:
            if part["close"] and len(stack) == 1:
                return unit
            group = stack.pop() if part["close"] else {part["word"]: 1}
            if part["close"]:
                sign.pop()
            for base, count in group.items():
                stack[-1][base] = stack[-1].get(base, 0) + sign[-1] * power * count
            sign[-1] = 1
    if len(stack) > 1:
        return unit
    words = [base + (str(count) if count != 1 else "") for base, count in stack[0].items() if count and base != "1"]
    return " ".join(words) or "1"


def named(unit, scene):
    """A unit of mm, s and mg with the names that a scene (its tables) gives them; "1" where it has none.

    >>> named("mm-2 s", {"units": {"length": "cm", "time": "none", "mass": "mg"}}), named("1/mm", {})
    ('cm-2', 'mm-1')
    """
    keys, names = {"mm": "length", "s": "time", "mg": "mass"}, scene.get("units", {})

    def renamed(found):
        name = names.get(keys[found[1]], found[1])
        return "1" if name == "none" else name + (found[2] or "")

    return simple_unit(re.sub(r"(?<![A-Za-z])(mm|s|mg)(?![A-Za-z])(\^?-?\d+)?", renamed, unit))


def unit_text(unit):
    """A unit in UDUNITS ("mm-2") or scene ("mm^-2") notation as mathtext."""
    unit = drawable(simple_unit(unit) if "(" in unit else unit)
    if "^" in unit:
        return re.sub(r"\^(-?\d+)", r"$^{\1}$", unit)
    words = []
    for word in unit.split():
        base = word.rstrip("-+0123456789")
        words.append(f"{base}$^{{{word[len(base):]}}}$" if base and base != word else word)
    return " ".join(words)


def bracket(unit):
    """A unit for a label: " [mm$^{-2}$]", or nothing."""
    return "" if unit == "1" else f" [{unit_text(unit)}]"


def spaced(unit):
    """A unit after a number; nothing without one."""
    return "" if unit == "1" else f" {unit_text(unit)}"


def symbol_text(symbol, spin):
    r"""A symbol as mathtext, without dollars; bold if it has a direction.

    >>> symbol_text("rho_0", 0), symbol_text("p", 1), symbol_text("v1", 1)
    ('\\rho_{0}', '\\mathbf{p}', '\\mathbf{v}_{1}')
    """
    from drover import _drover  # only here: figures of other scenes do without the extension module

    stem, *index = _drover.latex_of_name(symbol).split("_", 1)
    return "_".join([rf"\mathbf{{{stem}}}" if spin and len(stem) == 1 else stem, *index])


def order_unit(unit, values):
    """A unit of a key with that of the order, [p], put in: a number per area where its current has no other density.

    >>> order_unit("[p]/mm", {"current": {"kind": "order"}}), order_unit("1/s/[p]^2", {})
    ('mm-3', 's-1')
    """
    from drover.fields import model_file, shipped_fields
    density, order = list(shipped_fields())[:2]
    current = model_file()["current"].get(values.get("current", {}).get("kind"), density.symbol)
    is_number = density.symbol not in current.split() and values.get("fields", {}).get(density.name, True)
    return simple_unit(unit.replace(f"[{order.symbol}]", "(1/mm2)" if is_number else "(1)"))
