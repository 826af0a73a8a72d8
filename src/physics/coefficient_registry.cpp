// physics/coefficient_registry.cpp: the keys of a scene that the coefficients of rod_bead.toml and other numbers have.
#include "drover/physics/coefficient_registry.hpp"

#include <algorithm>

#include "model_file.hpp"

namespace drover::physics {

const CoefficientRow& coefficient_row(const std::string& key) {
    const CoefficientRegistry& rows = coefficient_registry();
    const auto found =
        std::find_if(rows.begin(), rows.end(), [&](const CoefficientRow& row) { return row.key() == key; });
    require(found != rows.end(), {}, "unknown coefficient {}; expected a key of the registry", key);
    return *found;
}

bool has_fields(const FieldChoice& fields, unsigned needs) {
    return (fields.bead_density || !(needs & needs_bead_density)) &&
           (fields.rod_density || !(needs & needs_rod_density)) &&
           (fields.bead_velocity != "absent" || !(needs & needs_bead_velocity));
}

namespace {
// Descriptions are made apart: GCC 12 destroys the members of a nested aggregate twice when memory runs out within it.
ModelKey coefficient_key(const CoefficientRow& row) {
    const Model standard;
    Description description{.name = row.name,
                            .default_value = row.value_in(standard),
                            .unit = row.unit,
                            .range = row.range,
                            .choices = {},
                            .doc = row.symbol + ": " + row.doc};
    return {.description = std::move(description),
            .get = [row](const Model& model) -> Value { return row.value_in(model); },
            .set = [row](Model& model, const Value& value) { row.value(model) = std::get<double>(value); },
            .number = row.value};
}

ModelKey monomials_key(const CoefficientRow& row) {
    using Texts = std::vector<std::string>;
    Description description{.name = row.name + "_terms",
                            .default_value = Texts{},
                            .unit = {},
                            .range = {},
                            .choices = {},
                            .doc = "monomials in the densities added to the coefficient, such as \"-0.5 rho sigma^2\""};
    return {.description = std::move(description),
            .get = [row](const Model& model) -> Value { return row.monomials_in(model); },
            .set = [row](Model& model, const Value& value) { row.monomials(model) = std::get<Texts>(value); }};
}

/// The keys of a struct of a model that are not coefficients.
template <class Struct>
void add_keys(Struct Model::*part, std::vector<ModelKey>& keys) {
    const std::vector<Description> described = descriptions<Struct>();
    for (std::size_t i = 0; i < described.size(); ++i) {
        const Row<Struct>& row = schema<Struct>()[i];
        keys.push_back(
            {.description = described[i],
             .get = [part, &row](const Model& model) { return schema_detail::get(model.*part, row); },
             .set = [part, &row](Model& model, const Value& value) { schema_detail::set(model.*part, row, value); }});
    }
}

ModelKey word_key(const char* name, std::string& (*word)(Model&), std::vector<std::string> choices, const char* doc) {
    Model standard;
    Description description{.name = name,
                            .default_value = word(standard),
                            .unit = {},
                            .range = {},
                            .choices = std::move(choices),
                            .doc = doc};
    return {.description = std::move(description),
            .get = [word](const Model& model) -> Value { return word(const_cast<Model&>(model)); },
            .set = [word](Model& model, const Value& value) { word(model) = std::get<std::string>(value); }};
}

ModelKey nodes_key(const std::string& name, const std::string& unit, const Range& range, const char* doc,
                   std::function<std::vector<double>&(Model&)> nodes) {
    Description description{
        .name = name, .default_value = std::vector<double>{}, .unit = unit, .range = range, .choices = {}, .doc = doc};
    return {.description = std::move(description),
            .get = [nodes](const Model& model) -> Value {
                Model copy{.table = model.table};  // nodes() makes a column where there is none
                return nodes(copy);
            },
            .set = [nodes](Model& model, const Value& value) { nodes(model) = std::get<std::vector<double>>(value); }};
}

std::vector<ModelKey> table_keys(const CoefficientRegistry& registry) {
    constexpr const char* values = "at each node, rod density fastest; replaces the coefficient in its section";
    constexpr const char* errors = "standard errors of these values, independent of each other; for drover boundary";
    std::vector<ModelKey> keys{nodes_key("bead_density", "1/mm^2", any_number,
                                         "nodes of the bead density rho, ascending; empty: no dependence on it",
                                         [](Model& m) -> std::vector<double>& { return m.table.bead_density; }),
                               nodes_key("rod_density", "1/mm^2", any_number,
                                         "nodes of the rod density sigma, ascending; empty: no dependence on it",
                                         [](Model& m) -> std::vector<double>& { return m.table.rod_density; })};
    for (const bool error : {false, true})
        for (const CoefficientRow& row : registry)
            if (row.varies())
                keys.push_back(nodes_key(row.section + "_" + row.name + (error ? "_error" : ""), row.unit,
                                         error ? not_negative : any_number, error ? errors : values,
                                         [key = row.key(), error](Model& m) -> std::vector<double>& {
                                             TableColumn& column = m.table.columns[key];
                                             return error ? column.errors : column.values;
                                         }));
    keys.push_back(word_key(
        "outside", [](Model& m) -> std::string& { return m.table.outside; }, {"refuse", "hold"},
        "densities beyond the nodes: refuse: stop with an error; hold: use the values at the edge"));
    return keys;
}

/// Keys of a section that are not coefficients.
void add_other_keys(const std::string& section, const CoefficientRegistry& registry, std::vector<ModelKey>& keys) {
    if (section == "fields") add_keys(&Model::fields, keys);
    if (section == "uniform") add_keys(&Model::uniform, keys);
    if (section == "force") add_keys(&Model::force, keys);
    if (section == "orienting_field") add_keys(&Model::orienting_field, keys);
    if (section == "approximation") add_keys(&Model::approximation, keys);
    if (section == "current")
        keys.push_back(word_key(
            "kind", [](Model& m) -> std::string& { return m.current.kind; }, {"order", "density-order"},
            "order: J = u p, p being sigma times the mean orientation [1/mm^2]; density-order: J = u sigma p, p being "
            "the mean orientation itself [1]; [p] is the unit of p"));
    if (section == "inertia")
        keys.push_back({.description = {.name = "advection",
                                        .default_value = false,
                                        .unit = {},
                                        .range = {},
                                        .choices = {},
                                        .doc = "include momentum advection of the beads, m rho v.grad v"},
                        .get = [](const Model& m) -> Value { return m.inertia.advection; },
                        .set = [](Model& m, const Value& v) { m.inertia.advection = std::get<bool>(v); }});
    if (section == "weathercock")
        keys.push_back(word_key(
            "convention", [](Model& m) -> std::string& { return m.weathercock.convention; }, {"mean", "single-rod"},
            "meaning of strength: mean: lambda of the equations; single-rod: lambda_s of one rod that turns as dn/dt = "
            "lambda_s (1 - nn).v, as measured on one rod in a transverse flow: lambda = lambda_s/2"));
    if (section == "table")
        for (ModelKey& key : table_keys(registry)) keys.push_back(std::move(key));
}
}  // namespace

std::vector<ModelSection> model_sections(const CoefficientRegistry& registry) {
    std::vector<ModelSection> sections{{"fields", "The fields of the model; the polar order p is always present.", {}},
                                       {"uniform", "The mean densities.", {}},
                                       {"current", "Self-propulsion of rods along the order.", {}},
                                       {"inertia", "Inertia of the beads.", {}},
                                       {"drag", "Friction of the beads with the plate.", {}},
                                       {"viscosity", "Viscosity of the beads.", {}},
                                       {"driving", "Driving of the beads by the rods.", {}},
                                       {"stiffness", "Pressure on the beads: forces along gradients of density.", {}},
                                       {"relaxation", "Relaxation and saturation of the order.", {}},
                                       {"elasticity", "Elasticity of the order.", {}},
                                       {"weathercock", "Alignment of rods with the bead flow.", {}},
                                       {"advection", "Self-advection of the order.", {}},
                                       {"pressure", "Reorientation of rods away from high densities.", {}},
                                       {"diffusion", "Diffusion of the densities.", {}},
                                       {"noise", "Strengths of the noise.", {}},
                                       {"force", "A body force on the beads.", {}},
                                       {"orienting_field", "A field that orients rods.", {}},
                                       {"approximation", "What the equations leave out.", {}},
                                       {"table", "Coefficients measured on a mesh of densities.", {}}};
    for (ModelSection& section : sections) {
        for (const CoefficientRow& row : registry) {
            if (row.section != section.name) continue;
            section.keys.push_back(coefficient_key(row));
            if (row.varies()) section.keys.push_back(monomials_key(row));
        }
        add_other_keys(section.name, registry, section.keys);
    }
    return sections;
}

std::vector<CoefficientValue> coefficient_values(const Model& model, const CoefficientRegistry& registry) {
    std::vector<CoefficientValue> result;
    for (const CoefficientRow& row : registry) {
        if (!has_fields(model.fields, row.needs)) continue;
        const double constant = row.value_in(model);
        if (row.varies() && !model.table.column(row.key()).values.empty())
            result.push_back({row.key(), row.symbol, "from the table", row.unit, row.doc});
        else if (row.varies() && !row.monomials_in(model).empty())
            result.push_back({row.key(), row.symbol,
                              text("{:.6g} + {}", constant, joined(row.monomials_in(model), " + ")), row.unit,
                              row.doc});
        else if (constant != 0.0) result.push_back({row.key(), row.symbol, constant, row.unit, row.doc});
    }
    if (model.fields.rod_density && model.current.speed != 0.0)
        result.push_back({"current.kind", "J", current_of(model.current.kind), "", "self-propulsion of the rods"});
    if (const BodyForce& f = model.force; f.kind != "none")
        result.push_back({"force", "f", text("({}, {}), {}", f.x, f.y, f.kind),
                          f.kind == "point" ? "mg mm/s^2" : "mg/(mm s^2)", "force on the beads"});
    if (const OrientingField& h = model.orienting_field; h.x != 0.0 || h.y != 0.0)
        result.push_back({"orienting_field", "h", text("({}, {})", h.x, h.y), "[p]/s", "field that orients rods"});
    for (const auto& [name, value] : model.parameters)
        result.push_back({"terms." + name, name, value, "", "a parameter of the terms written as text"});
    return result;
}

std::string coefficient_documentation(const CoefficientRegistry& registry) {
    const auto escaped = [](std::string words) {
        for (std::size_t at = 0; (at = words.find('|', at)) != std::string::npos; at += 2) words.insert(at, 1, '\\');
        return words;
    };
    std::string result = "| symbol | key | unit | meaning |\n|---|---|---|---|\n";
    for (const CoefficientRow& row : registry)
        result += text("| {} | `{}`{} | {} | {} |\n", row.symbol, row.key(), row.varies() ? " *" : "", row.unit,
                       escaped(row.doc));
    return result;
}

}  // namespace drover::physics
