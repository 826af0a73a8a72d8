// physics/symbol.cpp: the linearised equations of a form, from the terms.
#include <Eigen/LU>

#include "drover/physics/term.hpp"

namespace drover::physics {

namespace {
/// The uniform force on the beads in a uniform state: every force is linear in v and p at given densities.
Eigen::Vector2d uniform_force(const Equations& e, const UniformPoint& about) {
    const Symbol m = force_symbol(e, about, {});
    Eigen::Vector2d force =
        m.block<2, 2>(FieldIndex::bead_velocity_x, FieldIndex::bead_velocity_x).real() * about.velocity +
        m.block<2, 2>(FieldIndex::bead_velocity_x, FieldIndex::polar_order_x).real() * about.order;
    if (has_term(e, "force") && e.model.force.kind == "uniform")
        force += Eigen::Vector2d(e.model.force.x, e.model.force.y);
    return force;
}
}  // namespace

bool is_force_on_beads(const Term& term) {
    const std::string_view name = term.name;
    return name == "drag" || name == "viscosity" || name == "driving" || name == "force" ||
           name.starts_with("stiffness");
}

bool has_term(const Equations& equations, std::string_view name) {
    for (const Term* term : equations.active)
        if (name == term->name) return true;
    return false;
}

Symbol force_symbol(const Equations& equations, const UniformPoint& about, const numerics::Wavevector& q) {
    Symbol m = Symbol::Zero();
    for (const Term* term : equations.active) term->linearise(equations, about, q, m);
    return m;
}

Symbol linear_symbol(const Equations& equations, const UniformPoint& about, const numerics::Wavevector& q) {
    Symbol m = force_symbol(equations, about, q);
    const Form& form = equations.form;
    if (form.velocity == Velocity::dynamic) {
        const double moved = equations.model.inertia.bead_mass * about.bead_density;
        m.middleRows<2>(FieldIndex::bead_velocity_x) /= moved;
        m.block<2, 1>(FieldIndex::bead_velocity_x, FieldIndex::bead_density) -=
            uniform_force(equations, about) / (moved * about.bead_density);
    }
    if (form.velocity == Velocity::slaved && m.middleRows<2>(FieldIndex::bead_velocity_x).cwiseAbs().maxCoeff() > 0.0) {
        // 0 = F_v v + F_others: v = -F_v^-1 F_others.
        const Eigen::Matrix2cd inverse =
            m.block<2, 2>(FieldIndex::bead_velocity_x, FieldIndex::bead_velocity_x).inverse();
        const Eigen::Matrix<std::complex<double>, 2, FieldIndex::count> slave =
            -inverse * m.middleRows<2>(FieldIndex::bead_velocity_x);
        m += m.middleCols<2>(FieldIndex::bead_velocity_x).eval() * slave;
    }
    const auto drop = [&](int place) {
        m.row(place).setZero();
        m.col(place).setZero();
    };
    if (form.bead_density < 0) drop(FieldIndex::bead_density);
    if (form.rod_density < 0) drop(FieldIndex::rod_density);
    if (form.velocity != Velocity::dynamic) {
        drop(FieldIndex::bead_velocity_x);
        drop(FieldIndex::bead_velocity_y);
    }
    return m;
}

}  // namespace drover::physics
