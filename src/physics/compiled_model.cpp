// physics/compiled_model.cpp: compiling the coefficients of a model, and checking its numbers.
#include "drover/physics/compiled_model.hpp"

#include <algorithm>
#include <cmath>

namespace drover::physics {

namespace {
/// Conversion factor from the scene value: lambda is half of the lambda_s of one rod.
double factor_of(const Model& m, const CoefficientRow& row) {
    return row.key() == "weathercock.strength" && m.weathercock.convention == "single-rod" ? 1.0 / single_rod_factor
                                                                                           : 1.0;
}

Coefficient tabulated(const std::vector<double>& nodes, const TableData& table, double factor) {
    const auto axis = [](const std::vector<double>& at) { return at.empty() ? std::vector<double>{0.0} : at; };
    std::vector<double> values = nodes;
    for (double& value : values) value *= factor;
    return Coefficient(std::make_shared<numerics::SplineTable>(axis(table.bead_density), axis(table.rod_density),
                                                               std::move(values),
                                                               table.outside == "hold" ? numerics::Outside::hold
                                                                                       : numerics::Outside::refuse));
}

/// Alignment of rods that touch lowers their relaxation rate to a - c sigma; sigma is uniform if it is not a field.
void add_contact(const Model& model, double& rate, std::vector<Monomial>& monomials) {
    const double contact = model.relaxation.contact;
    if (model.fields.rod_density) monomials.push_back({.factor = -contact, .rods = 1});
    else rate -= contact * model.uniform.rod_density;
}

Coefficient compiled(const CoefficientRow& row, const Model& model, const LocationOf& location_of) {
    const TableColumn& column = model.table.column(row.key());
    const std::vector<double>&nodes = column.values, &errors = column.errors;
    const std::string name = "table." + row.section + "_" + row.name, monomial_key = row.key() + "_terms";
    const std::vector<std::string>& written = row.monomials_in(model);
    const double factor = factor_of(model, row);
    require(errors.empty() || errors.size() == nodes.size(), location_of(name + "_error"),
            "{}_error has {} values and {} has {}; expected equal numbers, or no errors", name, errors.size(), name,
            nodes.size());
    const bool has_contact = row.key() == "relaxation.rate" && model.relaxation.contact != 0.0;
    if (!nodes.empty()) {
        require(!has_contact, location_of("relaxation.contact"),
                "relaxation.contact and {} are both given; expected one of them: a table of the rate contains -c sigma",
                name);
        require(written.empty(), location_of(monomial_key), "{} and {} are both given; expected one of them",
                monomial_key, name);
        try {
            return tabulated(nodes, model.table, factor);
        } catch (const Error& error) {
            fail_input(location_of(name), "{}: {}", name, error.what());
        }
    }
    std::vector<Monomial> monomials;
    for (const std::string& monomial : written) {
        monomials.push_back(read_monomial(monomial, location_of(monomial_key)));
        monomials.back().factor *= factor;
    }
    double constant = factor * row.value_in(model);
    if (has_contact) add_contact(model, constant, monomials);
    return {constant, std::move(monomials)};
}

Coefficients compile(const Model& model, const LocationOf& location_of) {
    Coefficients result;
    for (const CoefficientRow& row : coefficient_registry())
        if (row.compiled) result.*row.compiled = compiled(row, model, location_of);
    return result;
}

/// Compiles the coefficients, reusing tables of an earlier model with equal data.
Coefficients compile(const Model& model, const CompiledModel& like) {
    const TableData &now = model.table, &then = like.model.table;
    const bool same_mesh = now.bead_density == then.bead_density && now.rod_density == then.rod_density &&
                           now.outside == then.outside &&
                           model.weathercock.convention == like.model.weathercock.convention;
    Coefficients result;
    for (const CoefficientRow& row : coefficient_registry()) {
        if (!row.compiled) continue;
        const std::vector<double>& nodes = now.column(row.key()).values;
        const bool same = same_mesh && !nodes.empty() && nodes == then.column(row.key()).values;
        result.*row.compiled = same ? like.*row.compiled : compiled(row, model, no_location);
    }
    return result;
}

/// The first key of [fields] that excludes a field needed by a coefficient; nullptr if all are present.
const char* missing_field(const FieldChoice& fields, unsigned needs) {
    if ((needs & needs_bead_density) && !fields.bead_density) return "bead_density";
    if ((needs & needs_rod_density) && !fields.rod_density) return "rod_density";
    if ((needs & needs_bead_velocity) && fields.bead_velocity == "absent") return "bead_velocity";
    return nullptr;
}

/// A coefficient of an absent field is an error in the scene.
void check_fields(const Model& m, const Coefficients& c, const LocationOf& location_of,
                  const CoefficientRegistry& registry) {
    const auto needs = [&](bool given, const char* missing, const std::string& key) {
        require(!given || !missing, location_of(key),
                "{} is given, but fields.{} excludes its field; set it to 0 or include the field", key,
                missing ? missing : "");
    };
    for (const CoefficientRow& row : registry)
        needs(row.compiled ? (c.*row.compiled).is_active() : row.value_in(m) != 0.0, missing_field(m.fields, row.needs),
              row.key());
    needs(m.force.kind != "none", missing_field(m.fields, needs_bead_velocity), "force.kind");
    const char* dynamic = m.fields.bead_velocity == "dynamic" ? nullptr : "bead_velocity";
    needs(m.inertia.advection, dynamic, "inertia.advection");
    needs(m.noise.velocity != 0.0, dynamic, "noise.velocity");
    for (const auto& [key, coefficient] : named(c)) {
        require(m.fields.bead_density || !coefficient->depends_on_beads(), location_of(text("{}_terms", key)),
                "{} depends on the bead density, which fields.bead_density excludes; include the field", key);
        require(m.fields.rod_density || !coefficient->depends_on_rods(), location_of(text("{}_terms", key)),
                "{} depends on the rod density, which fields.rod_density excludes; include the field", key);
    }
}

void check_slaved(const Model& m, const Coefficients& c, const LocationOf& location_of) {
    const bool viscous = m.viscosity.shear != 0.0 || m.viscosity.bulk != 0.0;
    require(!viscous || (!c.drag.varies() && !c.driving.varies()),
            location_of(c.drag.varies() ? "drag.coefficient_terms" : "driving.strength_terms"),
            "a slaved velocity supports either density-dependent drag and driving or viscosity, not both; set "
            "viscosity.shear and viscosity.bulk to 0, or set fields.bead_velocity = \"dynamic\"");
    require(!viscous || m.driving.cubic == 0.0, location_of("driving.cubic"),
            "a slaved velocity supports either driving.cubic or viscosity, not both; set viscosity.shear and "
            "viscosity.bulk to 0, or set fields.bead_velocity = \"dynamic\"");
    const double drag = c.drag.at(m.uniform.bead_density, m.uniform.rod_density).value;
    require(drag > 0.0, location_of("drag.coefficient"),
            "drag.coefficient is {} in the uniform state; expected > 0: at q = 0 only drag limits a slaved velocity",
            drag);
}

void check_numbers(const Model& model, const Coefficients& c, const LocationOf& location_of,
                   const CoefficientRegistry& registry) {
    check_fields(model, c, location_of, registry);
    if (model.fields.bead_velocity == "slaved") check_slaved(model, c, location_of);
    bool moved = model.fields.bead_velocity != "absent" || model.diffusion.beads != 0.0 || model.noise.beads != 0.0;
    for (const TextTerm& term : model.text_terms) moved = moved || term.of == "bead_density";
    require(
        !model.fields.bead_density || moved, location_of("fields.bead_density"),
        "fields.bead_density = true with fields.bead_velocity = \"absent\": nothing moves the beads; give a velocity, "
        "or exclude the bead density");
    try {
        require_values(c, model.uniform.bead_density, model.uniform.rod_density);
    } catch (const Error& error) {
        fail_input(location_of("uniform.rod_density"), "{}", error.what());
    }
}
}  // namespace

void check_numbers(const Model& model, const LocationOf& location_of, const CoefficientRegistry& registry) {
    check_numbers(model, compile(model, location_of), location_of, registry);
}

CompiledModel::CompiledModel(const Model& the_model)
    : Coefficients(compile(the_model, no_location)), model(the_model), form(physics::form(the_model)) {
    check_numbers(model, *this, no_location, coefficient_registry());
}
CompiledModel::CompiledModel(const Model& the_model, const CompiledModel& like)
    : Coefficients(compile(the_model, like)), model(the_model), form(physics::form(the_model)) {
    check_numbers(model, *this, no_location, coefficient_registry());
}

std::vector<std::pair<std::string_view, const Coefficient*>> named(const Coefficients& coefficients) {
    struct Keyed {
        std::string key;
        Coefficient Coefficients::*compiled;
    };
    static const std::vector<Keyed> keyed = [] {
        std::vector<Keyed> found;
        for (const CoefficientRow& row : coefficient_registry())
            if (row.compiled) found.push_back({row.key(), row.compiled});
        return found;
    }();
    std::vector<std::pair<std::string_view, const Coefficient*>> result;
    for (const Keyed& one : keyed) result.emplace_back(one.key, &(coefficients.*one.compiled));
    return result;
}

void require_values(const Coefficients& coefficients, double bead_density, double rod_density) {
    for (const auto& [key, coefficient] : named(coefficients))
        require(std::isfinite(coefficient->at(bead_density, rod_density).value), {},
                "{} is not defined at the densities {} (beads) and {} (rods), outside its table of {}; use densities "
                "inside the table, or set table.outside = \"hold\"",
                key, bead_density, rod_density, coefficient->table() ? range_text(*coefficient->table()) : "");
}

}  // namespace drover::physics
