// physics/field_evolution.cpp: the reference density that follows a run.
#include "drover/physics/field_evolution.hpp"

#include <algorithm>
#include <cmath>
#include <tuple>

namespace drover::physics {

using numerics::Spectra;

Reference reference_at(const UniformState& uniform, int rung) {
    Reference result = reference(uniform);
    result.bead_density *= std::exp2(0.5 * rung);
    return result;
}

int follow_densities(const Equations& equations, const Extremes& extremes, int rung) {
    if (equations.form.bead_density < 0 || equations.form.velocity == Velocity::absent) return rung;
    const bool has_inertia = equations.form.velocity == Velocity::dynamic;
    const double density = has_inertia ? extremes.min_bead : extremes.max_bead;
    if (!std::isfinite(density) || density <= 0.0) return rung;
    // Allowed: at most 1.7 times the smallest density, or at least 1/1.7 of the largest.
    const double exact = 2.0 * std::log2(density / equations.model.uniform.bead_density), margin = 2.0 * std::log2(1.7);
    if (has_inertia) {
        if (rung > exact + margin) rung = static_cast<int>(std::floor(exact + margin));
        if (rung < 0 && rung + 1.5 < exact + margin)
            rung = std::min(0, static_cast<int>(std::floor(exact + margin - 0.5)));
    } else {
        if (rung < exact - margin) rung = static_cast<int>(std::ceil(exact - margin));
        if (rung > 0 && rung - 1.5 > exact - margin)
            rung = std::max(0, static_cast<int>(std::ceil(exact - margin + 0.5)));
    }
    return rung;
}

FieldEvolution::FieldEvolution(const Model& model, const numerics::Grid& grid, const Dealiasing& dealiasing,
                               const numerics::StepControl& control, std::uint64_t seed, Threads& threads)
    : equations_(model),
      grid_(grid),
      dealiasing_(dealiasing),
      threads_(threads),
      linear_(linear_system(equations_, grid, reference(model.uniform), dealiasing)),
      split_(split_at(0)),
      stepper_(control, split_.system, seed, threads, control.watches_error ? std::optional(watched()) : std::nullopt) {
}

numerics::ErrorEquations::OnGrid FieldEvolution::equations_on_grid(int rung) const {
    return [equations = equations_, dealiasing = dealiasing_,
            about = reference_at(equations_.model.uniform, rung)](const numerics::Grid& grid, bool keeps_all,
                                                                  Threads& threads) {
        return split_of(equations, grid, about, keeps_all ? Dealiasing{.rule = "none"} : dealiasing, threads).system;
    };
}

numerics::ErrorEquations FieldEvolution::watched() const {
    const Form& form = equations_.form;
    numerics::ErrorEquations result{.fields = {},
                                    .on_grid = equations_on_grid(0),
                                    .degree = linear_.degree,
                                    .noisy = has_noise(equations_.model.noise),
                                    .turning = {form.polar_order}};
    if (form.bead_velocity >= 0) result.turning.push_back(form.bead_velocity);
    for (const auto& [first, count, name] :
         {std::tuple{form.bead_density, 1, "bead_density"}, std::tuple{form.rod_density, 1, "rod_density"},
          std::tuple{form.bead_velocity, 2, "bead_velocity"}, std::tuple{form.polar_order, 2, "polar_order"}})
        if (first >= 0) result.fields.push_back({first, count, name});
    return result;
}

FieldEvolution::Split FieldEvolution::split_of(const Equations& equations, const numerics::Grid& grid,
                                               const Reference& about, const Dealiasing& dealiasing, Threads& threads) {
    Split split{.system = linear_system(equations, grid, about, dealiasing), .remainder = nullptr};
    if (!is_nonlinear(equations)) return split;
    split.remainder = std::make_shared<RightHandSide>(equations, split.system, about, threads);
    split.system.nonlinear = [remainder = split.remainder](double t, const Spectra& state, Spectra& rate) {
        (*remainder)(t, state, rate);
    };
    split.system.set_step = [remainder = split.remainder](double dt) { remainder->set_step(dt); };
    return split;
}

FieldEvolution::Split FieldEvolution::split_at(int rung) const {
    return split_of(equations_, grid_, reference_at(equations_.model.uniform, rung), dealiasing_, threads_);
}

void FieldEvolution::set_reference(int rung) {
    rung_ = rung;
    split_ = split_at(rung);
    stepper_.set_system(split_.system, equations_on_grid(rung));
}

void FieldEvolution::follow(const FieldEvolution& other) {
    stepper_.begin_anew();
    if (rung_ != other.rung_) set_reference(other.rung_);
}

/// Of the last evaluation, the smallest bead density as that of the mass that moves.
Extremes FieldEvolution::moving_extremes() const {
    Extremes extremes = split_.remainder->extremes();
    if (std::isfinite(extremes.min_bead)) extremes.min_bead = split_.remainder->min_moving_density();
    return extremes;
}

void FieldEvolution::follow_beads(const Extremes& extremes) {
    const int rung = follow_densities(equations_, extremes, rung_);
    if (rung == rung_) return;
    set_reference(rung);
    ++changes_;
}

void FieldEvolution::start(const Spectra& state) {
    if (!split_.remainder) return;
    Spectra rate(grid_, state.count());
    (*split_.remainder)(0.0, state, rate);
    split_.remainder->set_step(stepper().dt());
    follow_beads(moving_extremes());
}

void FieldEvolution::advance(std::int64_t step, Spectra& state) {
    stepper_.advance(step, state);
    if (!split_.remainder) return;
    const Extremes extremes = moving_extremes();  // of the step, not of what measures its error
    stepper_.watch(step, state);
    follow_beads(extremes);
}

std::vector<double> FieldEvolution::save() const {
    std::vector<double> values = stepper_.save();
    values.insert(values.begin(), static_cast<double>(rung_));
    return values;
}

void FieldEvolution::restore(std::span<const double> values) {
    constexpr double most = 200.0;
    const double rung = values.empty() ? NAN : values[0];
    require(std::abs(rung) <= most && rung == std::round(rung), {},
            "the checkpoint contains {}; expected an integer from {} to {}; use the other checkpoint", rung, -most,
            most);
    set_reference(static_cast<int>(rung));
    stepper_.restore(values.subspan(1));
}

}  // namespace drover::physics
