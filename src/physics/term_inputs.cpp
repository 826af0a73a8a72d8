// physics/term_inputs.cpp: names of the inputs, equations by name, symbols of derivatives.
#include "term_inputs.hpp"

#include <algorithm>
#include <array>

#include "term_shapes.hpp"

namespace drover::physics {

namespace {
using numerics::Wavevector;

struct FieldName {
    const char* name;
    int field;
};
constexpr std::array field_names{FieldName{"bead_density", rho},    FieldName{"rod_density", sigma},
                                 FieldName{"bead_velocity_x", v_x}, FieldName{"bead_velocity_y", v_y},
                                 FieldName{"order_x", p_x},         FieldName{"order_y", p_y}};

}  // namespace

bool has_field(const Form& form, int field) {
    if (field == rho) return form.bead_density >= 0;
    if (field == sigma) return form.rod_density >= 0;
    return field >= p_x || form.velocity != Velocity::absent;
}

Vocabulary vocabulary_of(const CompiledModel& model) {
    Vocabulary names;
    const auto add_vector = [&](const char* name, int divergence, int curl, int grad_div) {
        names.operators["div"][name] = divergence;
        names.operators["curl"][name] = curl;
        names.operators["grad_div_x"][name] = grad_div;
        names.operators["grad_div_y"][name] = grad_div + 1;
    };
    for (const auto& [name, field] : field_names) {
        if (!has_field(model.form, field)) continue;
        names.variables[name] = field;
        names.operators["d_x"][name] = Input::d_x + field;
        names.operators["d_y"][name] = Input::d_y + field;
        names.operators["lap"][name] = Input::laplacian + field;
    }
    add_vector("order", Input::order_divergence, Input::order_curl, Input::order_grad_div);
    if (has_field(model.form, v_x))
        add_vector("bead_velocity", Input::velocity_divergence, Input::velocity_curl, Input::velocity_grad_div);
    names.variables["x"] = Input::x;
    names.variables["y"] = Input::y;
    names.variables["t"] = Input::t;
    int slot = parameters_begin;
    for (const auto& [name, value] : model.model.parameters) names.variables[name] = slot++;
    return names;
}

std::array<double, Input::count> slots_at(const UniformPoint& about) {
    std::array<double, Input::count> values{};
    values[Input::bead_density] = about.bead_density;
    values[Input::rod_density] = about.rod_density;
    for (int i = 0; i < 2; ++i) {
        values[static_cast<std::size_t>(Input::bead_velocity_x + i)] = about.velocity(i);
        values[static_cast<std::size_t>(Input::polar_order_x + i)] = about.order(i);
    }
    return values;
}

namespace {
/// What a slot is of the fields at q: at most two of them, times factors.
struct SlotSymbol {
    std::array<int, 2> field{};
    std::array<std::complex<double>, 2> factor{};
};
SlotSymbol symbol_of_slot(int slot, const Wavevector& q) {
    const std::complex<double> d_x = i_unit * q.x, d_y = i_unit * q.y;
    if (slot == Input::velocity_curl) return {{v_y, v_x}, {d_x, -d_y}};
    if (slot == Input::order_curl) return {{p_y, p_x}, {d_x, -d_y}};
    if (slot == Input::velocity_divergence) return {{v_x, v_y}, {d_x, d_y}};
    if (slot == Input::order_divergence) return {{p_x, p_y}, {d_x, d_y}};
    if (slot >= Input::velocity_grad_div) {
        const bool of_order = slot >= Input::order_grad_div, along_y = (slot - Input::velocity_grad_div) % 2 == 1;
        const double q_out = along_y ? q.y : q.x;
        return {{of_order ? p_x : v_x, of_order ? p_y : v_y}, {-q_out * q.x, -q_out * q.y}};
    }
    const int field = slot % FieldIndex::count;
    if (slot >= Input::laplacian) return {{field, field}, {-(q.x * q.x + q.y * q.y), 0.0}};
    if (slot >= Input::d_y) return {{field, field}, {d_y, 0.0}};
    if (slot >= Input::d_x) return {{field, field}, {d_x, 0.0}};
    return {{field, field}, {1.0, 0.0}};
}
}  // namespace

void add_derivative(int first_row, bool is_flux, std::size_t component, double slope, int slot, const Wavevector& q,
                    Symbol& m) {
    const SlotSymbol symbol = symbol_of_slot(slot, q);
    const std::complex<double> outer = is_flux ? -i_unit * (component == 0 ? q.x : q.y) : std::complex<double>(1.0);
    const int row = is_flux ? first_row : first_row + static_cast<int>(component);
    for (std::size_t k = 0; k < 2; ++k)
        if (symbol.factor[k] != 0.0) m(row, symbol.field[k]) += outer * slope * symbol.factor[k];
}

const Target& target_of(const CompiledModel& model, const TextTerm& written) {
    static constexpr std::array targets{
        Target{"bead_density", "d_t rho", Equation::bead_density, rho, Output::bead_rate, Output::bead_flux},
        Target{"rod_density", "d_t sigma", Equation::rod_density, sigma, Output::rod_rate, Output::rod_flux},
        Target{"bead_velocity", "m rho d_t v", Equation::bead_velocity, v_x, Output::force, -1},
        Target{"order", "d_t p", Equation::polar_order, p_x, Output::order, -1}};
    const auto* target =
        std::find_if(targets.begin(), targets.end(), [&](const Target& t) { return written.of == t.of; });
    require(target != targets.end(), written.where,
            "of = \"{}\"; expected one of bead_density, rod_density, bead_velocity, order: the field of the equation",
            written.of);
    require(has_field(model.form, target->row), written.where,
            "of = \"{}\", a field that this model excludes; include the field in [fields], or remove the term",
            written.of);
    return *target;
}

void check_admissible(const CompiledModel& model, const SourceLocation& where, const WrittenTraits& term,
                      bool pointwise_velocity) {
    const bool density = term.of == Equation::bead_density || term.of == Equation::rod_density;
    require(!density || term.conserves, where,
            "{} changes the number of {} in a uniform state, which the equations conserve; use a flux", term.name,
            term.of == Equation::bead_density ? "beads" : "rods");
    if (model.form.velocity != Velocity::slaved) return;
    require(term.of != Equation::bead_velocity || !term.reads_velocity, where,
            "{}: a force that depends on the bead velocity needs fields.bead_velocity = \"dynamic\"; a slaved velocity "
            "balances forces with drag.coefficient only",
            term.name);
    const bool viscous = model.model.viscosity.shear != 0.0 || model.model.viscosity.bulk != 0.0;
    require(!viscous || term.of != Equation::bead_velocity || term.is_linear, where,
            "{}: a slaved velocity with viscosity allows only linear isotropic forces; set viscosity.shear and "
            "viscosity.bulk to 0, or set fields.bead_velocity = \"dynamic\"",
            term.name);
    require(!term.derives_velocity || !pointwise_velocity, where,
            "{}: derivatives of a slaved velocity are not available when it depends on the densities at each point; "
            "set fields.bead_velocity = \"dynamic\"",
            term.name);
}

}  // namespace drover::physics
