"""physics/embed_model.py: a model file as the C++ source that holds it.

Usage: embed_model.py MODEL.toml OUTPUT.cpp
"""
import json
import re
import sys
import tomllib


def literal(value):
    """A value as C++, of the types of a Value."""
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, str):
        return f"std::string({json.dumps(value)})"
    return repr(float(value)) if isinstance(value, float) else json.dumps(value)


def texts(words):
    return "{" + ", ".join(json.dumps(word) for word in words) + "}"


def pairs(table):
    return "{" + ", ".join(f"{{{json.dumps(key)}, {json.dumps(value)}}}" for key, value in table.items()) + "}"


def row(members):
    return "{" + ",\n     ".join(f".{name} = {value}" for name, value in members.items()) + "}"


def rows(found):
    return "{" + ",\n    ".join(found) + "}"


def fields_in(formula, model):
    names = set(re.findall(r"[A-Za-z_]\w*", formula))
    return [field["symbol"] for field in model["field"] if field["symbol"] in names]


def needs_of(key, model, found=()):
    """The fields without which a term or a coefficient has no meaning: of its equation and its formula."""
    found = set(found)
    for field, terms in model["equations"].items():
        if key in terms:
            found |= {field, *fields_in(terms[key], model)}
    return [field["symbol"] for field in model["field"] if field["symbol"] in found]


def term(key, formula, model):
    return row({"key": json.dumps(key), "formula": json.dumps(formula), "needs": texts(fields_in(formula, model)),
                "on": texts(model["on"].get(key, []))})


def body_of(row, model):
    """What bodies a field is of: those that it counts, or those of its density."""
    return next(one["counted"] for one in model["field"] if one["symbol"] == row.get("of", row["symbol"]))


def field(one, model):
    text = json.dumps
    noise = next(c["key"] for c in model["coefficient"] if c.get("noise_of") == one["symbol"])
    terms = [term(key, formula, model) for key, formula in model["equations"][one["symbol"]].items()]
    observed = row({"short_name": text(one["short"]), "counted": text(one.get("counted", "")),
                    "of": text(one.get("of", "")), "body": text(body_of(one, model)),
                    "name_first": literal(one.get("name_first", False)),
                    "drawn": one["drawn"],
                    "energy": text(one["energy"]), "mass_unit": text(one.get("mass_unit", "1"))})
    return row({"symbol": text(one["symbol"]), "name": text(one["name"]), "alias": text(one.get("alias", one["name"])),
                "unit": text(one["unit"]), "meaning": text(one["meaning"]), "spin": int(one.get("rank") == "vector"),
                "mass": text(one.get("mass", "")),
                "mass_factors": texts(one.get("mass", "").split()), "conserved": literal(one.get("conserved", False)),
                "perturbed": literal(one.get("perturbed", False)),
                "noise": text(noise), "present": text(one.get("present", "")),
                "reference": text(one.get("reference", "")), "area": text(one.get("area", "")),
                "observed": observed, "terms": rows(terms)})


def coefficient(one, model):
    factors = dict(one.get("factors", {}))
    lowers = one.get("lowers", ["", ""])
    text = json.dumps
    return row({"id": text(one["key"]), "symbol": text(one["symbol"]),
                "unit": text(one["unit"]), "range": one.get("range", "any_number"), "doc": text(one["meaning"]),
                "needs": texts(needs_of(one["key"], model, [one["noise_of"]] if "noise_of" in one else [])),
                "order_power": one.get("order_power", 0), "standard": float(one.get("default", 0.0)),
                "varies": literal(one.get("depends", False)), "noise_of": text(one.get("noise_of", "")),
                "factor_key": text(factors.pop("key", "")), "factors": pairs(factors),
                "lowers": text(lowers[0]), "times": text(lowers[1])})


def key(one):
    description = row({"name": json.dumps(one["key"].partition(".")[2]), "default_value": literal(one["default"]),
                       "unit": json.dumps(one.get("unit", "")), "range": one.get("range", "any_number"),
                       "choices": texts(one.get("choices", [])), "doc": json.dumps(one["meaning"])})
    return row({"id": json.dumps(one["key"]), "description": description,
                "needs": json.dumps(one.get("needs", "")), "needs_rate": literal(one.get("rate", False))})


def definitions(model):
    chosen = [row({"name": json.dumps(name), "by": json.dumps(by), "formulas": pairs(model[table])})
              for name, (by, table) in model["by"].items()]
    return chosen + [row({"name": json.dumps(name), "by": '""', "formulas": pairs({"": formula})})
                     for name, formula in model["define"].items()]


def main():
    with open(sys.argv[1], "rb") as file:
        model = tomllib.load(file)
    order, source = model["order"], model["source"]
    members = {
        "fields": rows([field(one, model) for one in model["field"]]),
        "coefficients": rows([coefficient(one, model) for one in model["coefficient"]]),
        "sections": pairs(model["sections"]),
        "keys": rows([key(one) for one in model["key"]]),
        "definitions": rows(definitions(model)),
        "numbers": pairs(model["numbers"]),
        "forms": rows([f"{{{json.dumps(name)}, {pairs(fields)}}}" for name, fields in model["forms"].items()]),
        "order": row({name: json.dumps(order[name]) for name in ("density", "key", "value", "unit", "otherwise")}),
        "source": row({name: json.dumps(source[name]) for name in ("symbol", "section", "unit", "point_unit")})}
    with open(sys.argv[2], "w", encoding="utf-8") as file:
        file.write(f"""// Made of the model file by physics/embed_model.py.
#include "physics/model_file.hpp"

namespace drover::physics {{

const ModelFile& shipped_model() {{
    static const ModelFile file{row(members)};
    return file;
}}

const char* model_file_text() {{
    return R"model({json.dumps(model)})model";
}}

}}  // namespace drover::physics
""")


main()
