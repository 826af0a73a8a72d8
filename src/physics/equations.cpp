// physics/equations.cpp: choosing and checking the terms of a model; its linearisations.
#include "drover/physics/equations.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "compiled_function.hpp"
#include "compiled_text.hpp"
#include "linear_part.hpp"
#include "term_shapes.hpp"

namespace drover::physics {

namespace {
using numerics::Wavevector;

bool pointwise_velocity(const CompiledModel& model, const std::vector<Term>& active) {
    if (model.form.velocity != Velocity::slaved) return false;
    return model.drag.varies() || std::any_of(active.begin(), active.end(), [&](const Term& term) {
               return term.of == Equation::bead_velocity && term.cost && term.cost(model, false).writes != 0;
           });
}
}  // namespace

Equations::Equations(const Model& the_model) : CompiledModel(the_model) { choose_terms({}); }
Equations::Equations(const Model& the_model, const std::vector<Term>& further) : CompiledModel(the_model) {
    choose_terms(further);
}
Equations::Equations(const Model& the_model, const Equations& like) : CompiledModel(the_model, like) {
    choose_terms({});
}

void Equations::choose_terms(const std::vector<Term>& further) {
    for (const Term& term : built_in_terms())
        if (term.is_active(*this)) active.push_back(term);
    for (const Term& term : further) {
        if (term.is_active && !term.is_active(*this)) continue;
        check_linear_part(*this, term);
        active.push_back(term);
    }
    if (model.text_terms.empty()) return;
    // A text that makes a slaved velocity pointwise changes how the others are compiled.
    std::vector<Term> all = active;
    for (bool pointwise = pointwise_velocity(*this, active);; pointwise = true) {
        all = active;
        for (Term& term : compiled_text_terms(*this, pointwise)) all.push_back(std::move(term));
        if (pointwise_velocity(*this, all) == pointwise) break;
    }
    active = std::move(all);
}

void check(const Model& model, const LocationOf& location_of) {
    check_numbers(model, location_of);
    check_functions(Equations(model));
}

std::vector<ActiveTerm> active_terms(const Equations& equations) {
    std::vector<ActiveTerm> result;
    for (const Term& term : equations.active) result.push_back({term.name, term.equation(equations)});
    for (const auto& [key, equation] :
         {std::pair{"noise.beads", "d_t rho: conserved noise"}, std::pair{"noise.rods", "d_t sigma: conserved noise"},
          std::pair{"noise.velocity", "d_t v: white noise"}, std::pair{"noise.order", "d_t p: white noise"}}) {
        const CoefficientRow& row = coefficient_row(key);
        if (const double strength = row.value_in(equations.model); strength != 0.0)
            result.push_back({key, text("{}, {} = {} {}", equation, row.symbol, strength, row.unit)});
    }
    return result;
}

bool has_pointwise_velocity(const Equations& equations) { return pointwise_velocity(equations, equations.active); }

PointCost point_cost(const Equations& equations, const Term& term) {
    if (!term.cost) return {};
    const bool pointwise = has_pointwise_velocity(equations);
    PointCost cost = term.cost(equations, pointwise);
    if (pointwise && (cost.reads & reads_velocity)) ++cost.degree;
    return cost;
}

Symbol force_symbol(const Equations& equations, const UniformPoint& about, const Wavevector& q) {
    Symbol m = Symbol::Zero();
    for (const Term& term : equations.active) {
        require(term.is_uniform_in_space, {},
                "{} depends on position or time: no uniform state exists, so linear wave theory does not apply",
                term.name);
        if (term.linearise) term.linearise(equations, about, q, m);
    }
    return m;
}

namespace {
/// Divides the forces by what they move, or eliminates a slaved velocity, and drops the fields that the form leaves
/// out.
Symbol reduced(const Equations& equations, Symbol m, const UniformPoint& about, const Eigen::Vector2d& force) {
    const Form& form = equations.form;
    if (form.velocity == Velocity::dynamic) {
        const double moved = equations.model.inertia.bead_mass * about.bead_density;
        m.middleRows<2>(v_x) /= moved;
        m.block<2, 1>(v_x, rho) -= force / (moved * about.bead_density);
    }
    if (form.velocity == Velocity::slaved && m.middleRows<2>(v_x).cwiseAbs().maxCoeff() > 0.0) {
        // 0 = F_v v + F_others: v = -F_v^-1 F_others.
        const Eigen::Matrix2cd inverse = m.block<2, 2>(v_x, v_x).inverse();
        const Eigen::Matrix<std::complex<double>, 2, FieldIndex::count> slave = -inverse * m.middleRows<2>(v_x);
        m += m.middleCols<2>(v_x).eval() * slave;
    }
    const auto drop = [&](int field) {
        m.row(field).setZero();
        m.col(field).setZero();
    };
    if (form.bead_density < 0) drop(rho);
    if (form.rod_density < 0) drop(sigma);
    if (form.velocity != Velocity::dynamic) {
        drop(v_x);
        drop(v_y);
    }
    return m;
}
}  // namespace

Symbol linear_symbol(const Equations& equations, const UniformPoint& about, const Wavevector& q) {
    Eigen::Vector2d force = Eigen::Vector2d::Zero();
    if (equations.form.velocity == Velocity::dynamic) force = uniform_rates(equations, about).segment<2>(v_x);
    const Symbol m = force_symbol(equations, about, q);
    if (!m.allFinite()) require_linearisation(equations, equations.active, about);
    return reduced(equations, m, about, force);
}

Symbol noise_symbol(const Equations& equations, double q) {
    const Noise& noise = equations.model.noise;
    Symbol result = Symbol::Zero();
    if (equations.form.bead_density >= 0)
        result(FieldIndex::bead_density, FieldIndex::bead_density) = noise.beads * q * q;
    if (equations.form.rod_density >= 0) result(FieldIndex::rod_density, FieldIndex::rod_density) = noise.rods * q * q;
    result(FieldIndex::bead_velocity_x, FieldIndex::bead_velocity_x) =
        result(FieldIndex::bead_velocity_y, FieldIndex::bead_velocity_y) = noise.velocity;
    result(FieldIndex::polar_order_x, FieldIndex::polar_order_x) =
        result(FieldIndex::polar_order_y, FieldIndex::polar_order_y) = noise.order;
    return result;
}

Symbol propagator_symbol(const Equations& equations, const Reference& reference, double q) {
    Symbol m = Symbol::Zero();
    for (const Term& term : equations.active) add_isotropic_part(equations, term, reference, q, m);
    return reduced(equations, m, at_rest(reference), Eigen::Vector2d::Zero());
}

UniformRates uniform_rates(const Equations& e, const UniformPoint& at) {
    const Reference densities{.bead_density = at.bead_density, .rod_density = at.rod_density};
    UniformRates state;
    state << 0.0, 0.0, at.velocity, at.order;  // deviations from the state at rest at the same densities
    std::array<double, Input::count> fields{};
    fields[Input::bead_density] = at.bead_density;
    fields[Input::rod_density] = at.rod_density;
    for (const int i : {0, 1}) {
        fields[static_cast<std::size_t>(Input::bead_velocity_x + i)] = at.velocity(i);
        fields[static_cast<std::size_t>(Input::polar_order_x + i)] = at.order(i);
    }
    PointFields point{.size = 1};
    for (std::size_t i = 0; i < fields.size(); ++i) point.values[i] = &fields[i];
    point.linear_velocity = point.velocity();
    std::array<double, Output::count> sums{};
    PointRates rates;
    for (std::size_t i = 0; i < sums.size(); ++i) rates.values[i] = &sums[i];

    UniformRates result = UniformRates::Zero();
    Symbol linear = Symbol::Zero();
    for (const Term& term : e.active) {
        if (!term.whole && term.linearise) term.linearise(e, at_rest(densities), {}, linear);
        const Term::Act& act = term.whole ? term.whole : term.remainder;
        if (act && term.cost(e, false).writes != 0) act(e, densities, point, rates);
        if (!term.source || !term.source_is_uniform) continue;
        const VectorMode source = term.source(e, {}, 0.0, {});
        const int row = term.of == Equation::bead_velocity ? v_x : p_x;
        result(row) += source.x.real();
        result(row + 1) += source.y.real();
    }
    result += linear.real() * state;
    for (const int i : {0, 1}) {
        result(v_x + i) += sums[static_cast<std::size_t>(Output::force + i)];
        result(p_x + i) += sums[static_cast<std::size_t>(Output::order + i)];
    }
    return result;
}

}  // namespace drover::physics
