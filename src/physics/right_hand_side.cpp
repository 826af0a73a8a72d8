// physics/right_hand_side.cpp: N of the model layer, with what rods and beads may not reach.
#include "drover/physics/right_hand_side.hpp"

#include <cmath>

#include "drover/model/explicit_part.hpp"
#include "program_functions.hpp"
#include "quasi_linear.hpp"

namespace drover::physics {

using numerics::Spectra;

struct RightHandSide::Work {
    Equations e;
    model::Equations solver;
    model::ExplicitPart part;
    QuasiLinear quasi_linear;
    Divisors divisors;
    Extremes extremes = {};

    Work(const Equations& equations, const numerics::System& linear, const Reference& reference, Threads& threads)
        : e(equations),
          solver(e.solver(reference)),
          part(solver, linear, threads),
          quasi_linear(e, linear.grid, linear.degree),
          divisors{.by_bead_density = has_mass_of_beads(), .by_drag = has_pointwise_velocity(e)} {
        require_functions(e.model);
        for (const int field : {FieldIndex::bead_density, FieldIndex::rod_density})
            if (e.component(field) >= 0) part.watch(e.component(field));
    }

    /// Some force is divided by m rho.
    bool has_mass_of_beads() const {
        if (e.form.velocity != Velocity::dynamic || e.form.bead_density < 0) return false;
        for (std::size_t n = 0; n < e.terms().size(); ++n)
            if (e.is_force(n) && e.terms()[n] != "inertia.advection") return true;
        return false;
    }

    void evaluate(double t, const Spectra& state, Spectra& rate) {
        part(t, state, rate);
        Extremes found;
        if (const int rho = e.component(FieldIndex::bead_density); rho >= 0)
            found.min_bead = part.range(rho).min, found.max_bead = part.range(rho).max;
        if (const int sigma = e.component(FieldIndex::rod_density); sigma >= 0)
            found.min_rod = part.range(sigma).min, found.max_rod = part.range(sigma).max;
        extremes = of_both(extremes, found);
        check_extremes(e, extremes, divisors);
    }
};

RightHandSide::RightHandSide(const Equations& equations, const numerics::System& linear, const Reference& reference,
                             Threads& threads)
    : work_(std::make_unique<Work>(equations, linear, reference, threads)) {}
RightHandSide::~RightHandSide() = default;

void RightHandSide::operator()(double t, const Spectra& state, Spectra& rate) {
    Work& w = *work_;
    w.extremes = {};
    w.quasi_linear.write(
        state, [&](const Spectra& at, Spectra& to) { w.evaluate(t, at, to); }, rate);
}

void RightHandSide::set_step(double dt) { work_->part.set_step(dt); }

Extremes RightHandSide::extremes() const { return work_->extremes; }

double RightHandSide::min_moving_density() const {
    const Work& w = *work_;
    const int velocity = w.e.component(FieldIndex::bead_velocity_x);
    const auto field =
        static_cast<std::size_t>(w.e.form.bead_density >= 0) + static_cast<std::size_t>(w.e.form.rod_density >= 0);
    const double floor = velocity < 0 ? 0.0 : w.part.mass_floor(field) / w.e.model.inertia.bead_mass;
    return w.extremes.min_bead * std::pow(1.0 + std::pow(floor / w.extremes.min_bead, 16.0), 1.0 / 16.0);
}

numerics::Fields RightHandSide::bead_velocity(double t, const Spectra& state) const {
    return work_->part.balanced(t, state);
}

numerics::Fields slaved_velocity(const Equations& equations, const numerics::System& linear, double t,
                                 const Spectra& state) {
    Threads one(1);
    return RightHandSide(equations, linear, reference(equations.model.uniform), one).bead_velocity(t, state);
}

TransformCount transform_count(const Equations& equations) {
    const model::TransformCount count = equations.solver(reference(equations.model.uniform)).transforms();
    const int times = evaluations(equations);
    return {.inverse = count.forward > 0 ? times * count.inverse : 0, .forward = times * count.forward};
}

bool is_nonlinear(const Equations& equations) {
    return equations.solver(reference(equations.model.uniform)).has_nonlinear_part();
}

double right_hand_side_bytes(const Equations& equations, const numerics::Grid& grid, int degree) {
    const double displaced =
        evaluations(equations) > 1 ? 2.0 * static_cast<double>(component_names(equations.form).size()) : 0.0;
    return model::ExplicitPart::bytes(equations.solver(reference(equations.model.uniform)), grid, degree) +
           displaced * static_cast<double>(numerics::modes(grid)) * sizeof(numerics::Complex);
}

}  // namespace drover::physics
