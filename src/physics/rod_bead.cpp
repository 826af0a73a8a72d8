// physics/rod_bead.cpp: the terms, numbers and functions of a model of rods and beads.
#include "rod_bead.hpp"

#include <algorithm>
#include <map>

#include "drover/physics/function_terms.hpp"
#include "term_names.hpp"
#include "text_terms.hpp"

namespace drover::physics {

namespace {
/// Of terms whose key is no coefficient, too.
bool is_active(const CompiledModel& m, const std::string& key) {
    const bool moves = m.form.velocity != Velocity::absent;
    if (key == "bead_current") return moves;
    if (key == "inertia.advection") return m.form.velocity == Velocity::dynamic && m.model.inertia.advection;
    if (key == "force") return m.model.force.kind != "none";
    if (key == "orienting_field") return m.model.orienting_field.x != 0.0 || m.model.orienting_field.y != 0.0;
    const CoefficientRow& row = coefficient_row(key);
    return has_fields(m.model.fields, row.needs) &&
           (row.compiled ? (m.*row.compiled).is_active() : row.value_in(m.model) != 0.0);
}

model::GivenFunction function_of(const Coefficient& coefficient) {
    const std::shared_ptr<const numerics::SplineTable> table = coefficient.table();
    return {.arguments = 2,
            .degree = coefficient.degree(),
            .values =
                [table](std::size_t size, std::span<const PointArgument> at, std::span<double* const> out) {
                    const auto argument = [&](std::size_t a, std::size_t i) {
                        return at[a].values ? at[a].values[i] : at[a].number;
                    };
                    for (std::size_t i = 0; i < size; ++i) out[0][i] = table->at(argument(0, i), argument(1, i)).value;
                },
            .slopes =
                [table](std::span<const double> at) {
                    const numerics::TableValue found = table->at(at[0], at[1]);
                    return std::vector<double>{found.by_first, found.by_second};
                }};
}

/// What the names in the formulas stand for, besides the fields.
void add_names(const CompiledModel& m, model::Model& result) {
    for (const CoefficientRow& row : coefficient_registry()) {
        if (row.section == "noise") continue;
        if (!row.compiled) {
            result.coefficients[row.symbol] = row.value_in(m.model);
            continue;
        }
        const Coefficient& c = m.*row.compiled;
        if (c.table()) {
            result.functions["tabulated_" + row.symbol] = function_of(c);
            result.definitions.push_back({row.symbol, {text("tabulated_{}(rho, sigma)", row.symbol), {}}});
        } else if (c.varies()) {
            result.definitions.push_back({row.symbol, {c.text_of(), {}}});
        } else {
            result.coefficients[row.symbol] = c.at(0.0, 0.0).value;
        }
    }
    if (!has_field(m.form, "rho")) result.coefficients["rho"] = m.model.uniform.bead_density;
    if (!has_field(m.form, "sigma")) result.coefficients["sigma"] = m.model.uniform.rod_density;
    const BodyForce& force = m.model.force;
    const OrientingField& h = m.model.orienting_field;
    result.coefficients["force_x"] = force.x;
    result.coefficients["force_y"] = force.y;
    result.coefficients["field_x"] = h.x;
    result.coefficients["field_y"] = h.y;
    result.definitions.push_back({"J", {current_of(m.model.current.kind), {}}});
    result.definitions.push_back({"h", {"field_x e_x + field_y e_y", {}}});
    if (force.kind == "point" && has_field(m.form, "v"))
        result.fields.push_back({.name = "force",
                                 .symbol = "f",
                                 .spin = 1,
                                 .left = model::LeftSide::given,
                                 .source = {.x = force.x,
                                            .y = force.y,
                                            .at_x = force.at_x,
                                            .at_y = force.at_y,
                                            .velocity_x = force.velocity_x,
                                            .velocity_y = force.velocity_y,
                                            .width = force.width}});
    else result.definitions.push_back({"f", {"force_x e_x + force_y e_y", {}}});
}

bool is_chosen(const std::string& name, const std::vector<std::string>* only) {
    return only == nullptr || std::find(only->begin(), only->end(), name) != only->end();
}

/// What an equation has besides its terms.
model::Field field_of(const CompiledModel& m, const RodBead::Field& row, Written as) {
    model::Field field{.name = row.name,
                       .symbol = row.symbol,
                       .spin = row.spin,
                       .unit = unit_of(row, m.form.order_is_density),
                       .meaning = row.meaning,
                       .observed = row.observed};
    if (row.symbol == "rho") field.reference = m.model.uniform.bead_density;
    if (row.symbol == "sigma") field.reference = m.model.uniform.rod_density;
    field.conserved = row.conserved;
    if (as == Written::forces) return field;
    const bool is_slaved = row.symbol == "v" && m.form.velocity == Velocity::slaved;
    if (is_slaved) field.left = model::LeftSide::balance;
    else {
        field.mass = {row.mass, {}};
        field.noise = coefficient_row(row.noise).value_in(m.model);
        field.noise_conserves = row.conserved;
    }
    return field;
}
}  // namespace

WrittenModel write_model(const CompiledModel& m, Written as, const std::vector<std::string>* only) {
    WrittenModel result;
    const std::vector<SceneTerm> of_scene = scene_terms(m);
    for (const RodBead::Field& row : rod_bead().fields) {
        if (!has_field(m.form, row.symbol)) continue;
        model::Field field = field_of(m, row, as);
        for (const auto& [key, formula] : row.terms) {
            if (!is_active(m, key) || !is_chosen(key, only)) continue;
            if (!field.equation.text.empty()) field.equation.text += formula[0] == '-' ? " " : " + ";
            field.equation.text += formula;
            result.terms.push_back(key);
        }
        for (const SceneTerm& term : of_scene) {
            if (term.field != row.symbol || !is_chosen(term.written.name, only)) continue;
            field.further.push_back(term.written);
            result.terms.push_back(term.written.name);
            // Texts that are no fluxes are checked in a uniform state alone.
            if (!term.written.is_flux) field.conserved = false;
        }
        const bool is_empty = field.equation.text.empty() && field.further.empty();
        if (field.left == model::LeftSide::balance && is_empty) field.equation.text = "-v";  // of some terms only
        result.model.fields.push_back(std::move(field));
    }
    add_names(m, result.model);
    return result;
}

std::optional<std::map<std::string, double>> ratios_of_terms(const CompiledModel& m, const CompiledModel& to) {
    const Model &a = m.model, &b = to.model;
    const bool has_densities = a.fields.bead_density && a.fields.rod_density;
    if (a.fields != b.fields || a.inertia != b.inertia || a.current.kind != b.current.kind || a.force != b.force ||
        a.orienting_field != b.orienting_field || !a.text_terms.empty() || !b.text_terms.empty() ||
        (!has_densities && a.uniform != b.uniform))
        return {};
    std::map<std::string, double> ratios;
    for (const CoefficientRow& row : coefficient_registry()) {
        if (row.compiled && m.*row.compiled == to.*row.compiled) continue;
        if (row.compiled && ((m.*row.compiled).varies() || (to.*row.compiled).varies())) return {};
        const auto constant = [&](const CompiledModel& c) {
            return row.compiled ? (c.*row.compiled).at(0.0, 0.0).value : row.value_in(c.model);
        };
        const double before = constant(m), now = constant(to);
        if (before == now || row.section == "noise") continue;
        if (before == 0.0 || now == 0.0) return {};
        ratios[row.key()] = now / before;
    }
    return ratios;
}

std::string key_of_term(const std::string& symbol, const std::string& factor) {
    for (const RodBead::Field& field : rod_bead().fields)
        for (const auto& [key, formula] : field.terms)  // of one coefficient: "-b |p|^2 p"
            if (field.symbol == symbol && formula.ends_with(" " + factor) &&
                formula.find(' ') == formula.size() - factor.size() - 1)
                return key;
    return "";
}

std::vector<HeldRange> held_ranges(const TableData& table) {
    std::vector<HeldRange> ranges;
    if (!table.has_values() || table.outside != "hold") return ranges;
    for (const auto& [symbol, nodes] : {std::pair{"rho", &table.bead_density}, std::pair{"sigma", &table.rod_density}})
        if (nodes->size() > 1) ranges.push_back({.symbol = symbol, .min = nodes->front(), .max = nodes->back()});
    return ranges;
}

}  // namespace drover::physics
