"""physics/embed_model.py: a model file as the C++ source that holds it.

Usage: embed_model.py MODEL.toml OUTPUT.cpp
"""
import json
import re
import sys
import tomllib

NEEDS = {"rho": "needs_bead_density", "sigma": "needs_rod_density", "v": "needs_bead_velocity"}


def names_in(formula):
    return set(re.findall(r"[A-Za-z_]\w*", formula))


def needs_of(row, model):
    """The fields without which a coefficient has no meaning: of its equation and its term."""
    found = {row["noise_of"]} if "noise_of" in row else set()
    for field, terms in model["equations"].items():
        if row["key"] in terms:
            found |= {field} | names_in(terms[row["key"]])
    return " | ".join(NEEDS[symbol] for symbol in NEEDS if symbol in found) or "0"


def coefficient(row, model):
    section, name = row["key"].split(".")
    value = f"m.{section}.{name}"
    lines = [f'.section = {json.dumps(section)}, .name = {json.dumps(name)}, .symbol = {json.dumps(row["symbol"])}',
             f'.unit = {json.dumps(row["unit"])}, .range = {row.get("range", "any_number")}',
             f'.doc = {json.dumps(row["meaning"])}',
             f'.needs = {needs_of(row, model)}, .order_power = {row.get("order_power", 0)}',
             f".value = [](Model& m) -> double& {{ return {value}; }}"]
    if "depends_as" in row:
        lines += [f".monomials = [](Model& m) -> std::vector<std::string>& {{ return {value}_terms; }}",
                  f'.compiled = &Coefficients::{row["depends_as"]}']
    return "    {" + ",\n     ".join(lines) + "}"


def body_of(row, model):
    """What bodies a field is of: those that it counts, or those of its density."""
    return next(one["counted"] for one in model["field"] if one["symbol"] == row.get("of", row["symbol"]))


def field(row, model):
    terms = [f"{{{json.dumps(key)}, {json.dumps(formula)}}}"
             for key, formula in model["equations"][row["symbol"]].items()]
    noise = [c["key"] for c in model["coefficient"] if c.get("noise_of") == row["symbol"]]
    text = json.dumps
    return (f'    {{.symbol = {text(row["symbol"])}, .name = {text(row["name"])}, .left = {text(row["left"])},\n'
            f'     .unit = {text(row["unit"])}, .meaning = {text(row["meaning"])},\n'
            f'     .spin = {int(row.get("rank") == "vector")}, .mass = {text(row.get("mass", ""))},\n'
            f'     .conserved = {text(row.get("conserved", False))},\n'
            f'     .perturbed = {text(row.get("perturbed", False))}, .noise = {text(noise[0])},\n'
            f'     .observed = {{.short_name = {text(row["short"])}, .counted = {text(row.get("counted", ""))},\n'
            f'                  .of = {text(row.get("of", ""))}, .body = {text(body_of(row, model))},\n'
            f'                  .name_first = {text(row.get("name_first", False))}, .drawn = {row["drawn"]},\n'
            f'                  .energy = {text(row["energy"])}, .mass_unit = {text(row.get("mass_unit", "1"))}}},\n'
            f'     .terms = {{' + ",\n               ".join(terms) + "}}")


def main():
    with open(sys.argv[1], "rb") as file:
        model = tomllib.load(file)
    fields = ",\n".join(field(row, model) for row in model["field"])
    rows = ",\n".join(coefficient(row, model) for row in model["coefficient"])
    currents = ", ".join(f"{{{json.dumps(kind)}, {json.dumps(text)}}}" for kind, text in model["current"].items())
    with open(sys.argv[2], "w") as file:
        file.write(f"""// Made of the model file by physics/embed_model.py.
#include "drover/physics/coefficient_registry.hpp"
#include "physics/model_file.hpp"

namespace drover::physics {{

const CoefficientRegistry& coefficient_registry() {{
    static const CoefficientRegistry rows{{
{rows}}};
    return rows;
}}

const RodBead& rod_bead() {{
    static const RodBead equations{{.fields = {{
{fields}}},
    .currents = {{{currents}}}}};
    return equations;
}}

const char* model_file() {{
    return R"model({json.dumps(model)})model";
}}

}}  // namespace drover::physics
""")


main()
