// physics/model.cpp: compiling and checking a model.
#include "drover/physics/model.hpp"

#include <algorithm>
#include <cmath>

#include "drover/physics/term.hpp"

namespace drover::physics {

Form form(const Model& model) {
    return make_form(model.fields, model.fields.rod_density && model.current.kind == "order");
}

namespace {
/// A coefficient that may depend on the densities, as the scene says it.
struct Varying {
    std::string key;  ///< "relaxation.rate"
    double constant;
    const std::vector<std::string>& monomials;
    std::vector<double> TableData::*nodes;
    std::vector<double> TableData::*errors;
    Coefficient Coefficients::*place;
    double factor = 1.0;  ///< of all its numbers
};

std::vector<Varying> varying(const Model& m) {
    const double lambda = m.weathercock.convention == "single-rod" ? 0.5 : 1.0;
    return {{"relaxation.rate", m.relaxation.rate, m.relaxation.rate_terms, &TableData::relaxation_rate,
             &TableData::relaxation_rate_error, &Coefficients::relaxation},
            {"relaxation.saturation", m.relaxation.saturation, m.relaxation.saturation_terms,
             &TableData::relaxation_saturation, &TableData::relaxation_saturation_error, &Coefficients::saturation},
            {"drag.coefficient", m.drag.coefficient, m.drag.coefficient_terms, &TableData::drag_coefficient,
             &TableData::drag_coefficient_error, &Coefficients::drag},
            {"driving.strength", m.driving.strength, m.driving.strength_terms, &TableData::driving_strength,
             &TableData::driving_strength_error, &Coefficients::driving},
            {"weathercock.strength", m.weathercock.strength, m.weathercock.strength_terms,
             &TableData::weathercock_strength, &TableData::weathercock_strength_error, &Coefficients::weathercock,
             lambda}};
}

Coefficient tabulated(const Varying& written, const TableData& table) {
    const auto axis = [](const std::vector<double>& nodes) { return nodes.empty() ? std::vector<double>{0.0} : nodes; };
    std::vector<double> values = table.*written.nodes;
    for (double& value : values) value *= written.factor;
    return Coefficient(std::make_shared<CoefficientTable>(axis(table.bead_density), axis(table.rod_density),
                                                          std::move(values),
                                                          table.outside == "hold" ? Outside::hold : Outside::refuse));
}

Coefficient compiled(const Varying& written, const TableData& table, const LocationOf& place) {
    const std::vector<double>&nodes = table.*written.nodes, &errors = table.*written.errors;
    std::string name = "table." + written.key;
    std::replace(name.begin() + 6, name.end(), '.', '_');
    require(errors.empty() || errors.size() == nodes.size(), place(name + "_error"),
            "{}_error has {} values and {} has {}; expected one for each, or none", name, errors.size(), name,
            nodes.size());
    if (!nodes.empty()) {
        require(written.monomials.empty(), place(written.key + "_terms"),
                "{}_terms and {} are both given; expected one of them", written.key, name);
        try {
            return tabulated(written, table);
        } catch (const Error& error) {
            fail_input(place(name), "{}: {}", name, error.what());
        }
    }
    std::vector<Monomial> monomials;
    for (const std::string& monomial : written.monomials) {
        monomials.push_back(read_monomial(monomial, place(written.key + "_terms")));
        monomials.back().factor *= written.factor;
    }
    return {written.factor * written.constant, std::move(monomials)};
}

Coefficients compile(const Model& m, const LocationOf& place) {
    Coefficients result;
    for (const Varying& one : varying(m)) result.*one.place = compiled(one, m.table, place);
    return result;
}

/// The same, tables of the same numbers taken from an earlier model.
Coefficients compile(const Model& m, const Equations& like) {
    const TableData &now = m.table, &then = like.model.table;
    const bool same_mesh = now.bead_density == then.bead_density && now.rod_density == then.rod_density &&
                           now.outside == then.outside && m.weathercock.convention == like.model.weathercock.convention;
    Coefficients result;
    for (const Varying& one : varying(m)) {
        const bool same = same_mesh && !(now.*one.nodes).empty() && now.*one.nodes == then.*one.nodes;
        result.*one.place = same ? like.*one.place : compiled(one, now, no_location);
    }
    return result;
}

/// A coefficient of a field that is not there is a slip of the scene, not a wish.
void check_fields(const Model& m, const Coefficients& c, const LocationOf& place) {
    const bool beads = m.fields.bead_density, rods = m.fields.rod_density,
               velocity = m.fields.bead_velocity != "absent", dynamic = m.fields.bead_velocity == "dynamic";
    const auto needs = [&](bool given, bool has, const char* key, const char* field) {
        require(!given || has, place(key),
                "{} is given, but fields.{} leaves its field out; set it to 0 or give the field", key, field);
    };
    needs(m.stiffness.beads != 0.0, beads && velocity, "stiffness.beads", beads ? "bead_velocity" : "bead_density");
    needs(m.stiffness.rods != 0.0, rods && velocity, "stiffness.rods", rods ? "bead_velocity" : "rod_density");
    needs(m.pressure.beads != 0.0, beads, "pressure.beads", "bead_density");
    needs(m.pressure.rods != 0.0, rods, "pressure.rods", "rod_density");
    needs(m.diffusion.beads != 0.0, beads, "diffusion.beads", "bead_density");
    needs(m.diffusion.rods != 0.0, rods, "diffusion.rods", "rod_density");
    needs(m.noise.beads != 0.0, beads, "noise.beads", "bead_density");
    needs(m.noise.rods != 0.0, rods, "noise.rods", "rod_density");
    needs(m.current.speed != 0.0, rods, "current.speed", "rod_density");
    needs(c.drag.is_active(), velocity, "drag.coefficient", "bead_velocity");
    needs(c.driving.is_active(), velocity, "driving.strength", "bead_velocity");
    needs(c.weathercock.is_active(), velocity, "weathercock.strength", "bead_velocity");
    needs(m.viscosity.shear != 0.0, velocity, "viscosity.shear", "bead_velocity");
    needs(m.viscosity.bulk != 0.0, velocity, "viscosity.bulk", "bead_velocity");
    needs(m.force.kind != "none", velocity, "force.kind", "bead_velocity");
    needs(m.inertia.advection, dynamic, "inertia.advection", "bead_velocity");
    for (const auto& [key, coefficient] : named(c)) {
        require(beads || !coefficient->depends_on_beads(), place(text("{}_terms", key)),
                "{} depends on the bead density, which fields.bead_density leaves out; give the field", key);
        require(rods || !coefficient->depends_on_rods(), place(text("{}_terms", key)),
                "{} depends on the rod density, which fields.rod_density leaves out; give the field", key);
    }
}

void check_slaved(const Model& m, const Coefficients& c, const LocationOf& place) {
    const bool viscous = m.viscosity.shear != 0.0 || m.viscosity.bulk != 0.0;
    require(!viscous || (!c.drag.varies() && !c.driving.varies()),
            place(c.drag.varies() ? "drag.coefficient_terms" : "driving.strength_terms"),
            "a slaved velocity is exact for a drag and a driving that depend on the densities, or for viscosity, not "
            "for both; set "
            "viscosity.shear and viscosity.bulk to 0, or give fields.bead_velocity = \"dynamic\"");
    const double drag = c.drag.at(m.uniform.bead_density, m.uniform.rod_density).value;
    require(drag > 0.0, place("drag.coefficient"),
            "drag.coefficient is {} in the uniform state, and a slaved velocity has nothing else to hold it back at q "
            "= 0; expected > 0",
            drag);
}
}  // namespace

namespace {
void check_all(const Model& model, const Coefficients& c, const LocationOf& place) {
    check_fields(model, c, place);
    if (model.fields.bead_velocity == "slaved") check_slaved(model, c, place);
    require(!model.fields.bead_density || model.fields.bead_velocity != "absent" || model.diffusion.beads != 0.0 ||
                model.noise.beads != 0.0,
            place("fields.bead_density"),
            "fields.bead_density = true with fields.bead_velocity = \"absent\": nothing moves the beads; give a "
            "velocity, or leave them "
            "out");
    for (const auto& [name, coefficient] : named(c))
        require(
            std::isfinite(coefficient->at(model.uniform.bead_density, model.uniform.rod_density).value),
            place("uniform.rod_density"),
            "{}: the uniform densities {} (beads) and {} (rods) lie outside its table of {}; expected them inside, or "
            "table.outside = \"hold\"",
            name, model.uniform.bead_density, model.uniform.rod_density,
            coefficient->table() ? coefficient->table()->range_text() : "");
}

}  // namespace

void check(const Model& model, const LocationOf& place) { check_all(model, compile(model, place), place); }

Equations::Equations(const Model& the_model, const Coefficients& coefficients)
    : Coefficients(coefficients), model(the_model), form(physics::form(the_model)) {
    check_all(model, coefficients, no_location);
    for (const Term& term : terms())
        if (term.is_active(*this)) active.push_back(&term);
}

Equations::Equations(const Model& the_model) : Equations(the_model, compile(the_model, no_location)) {}
Equations::Equations(const Model& the_model, const Equations& like) : Equations(the_model, compile(the_model, like)) {}

std::vector<ActiveTerm> active_terms(const Equations& equations) {
    std::vector<ActiveTerm> result;
    for (const Term* term : equations.active) result.push_back({term->name, term->equation(equations)});
    const Noise& noise = equations.model.noise;
    if (noise.beads != 0.0)
        result.push_back({"noise.beads", text("d_t rho: conserved noise, strength {} 1/s", noise.beads)});
    if (noise.rods != 0.0)
        result.push_back({"noise.rods", text("d_t sigma: conserved noise, strength {} 1/s", noise.rods)});
    if (noise.order != 0.0)
        result.push_back({"noise.order", text("d_t p: white noise, Delta = {} [p]^2 mm^2/s", noise.order)});
    return result;
}

}  // namespace drover::physics

namespace drover {

template <>
const std::vector<Row<physics::UniformState>>& schema<physics::UniformState>() {
    static const std::vector<Row<physics::UniformState>> rows{
        {.name = "rod_density",
         .member = &physics::UniformState::rod_density,
         .unit = "1/mm^2",
         .range = positive,
         .doc = "sigma: mean density of the rods, which the equations conserve"},
        {.name = "bead_density",
         .member = &physics::UniformState::bead_density,
         .unit = "1/mm^2",
         .range = positive,
         .doc = "rho: mean density of the beads, which the equations conserve"},
        {.name = "rod_area",
         .member = &physics::UniformState::rod_area,
         .unit = "mm^2",
         .range = not_negative,
         .doc = "projected area of one rod, for area fractions; 0: not known"},
        {.name = "bead_area",
         .member = &physics::UniformState::bead_area,
         .unit = "mm^2",
         .range = not_negative,
         .doc = "projected area of one bead, for area fractions; 0: not known"}};
    return rows;
}

}  // namespace drover
