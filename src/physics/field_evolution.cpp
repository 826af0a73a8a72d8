// physics/field_evolution.cpp: the reference density that follows a run.
#include "drover/physics/field_evolution.hpp"

#include <algorithm>
#include <cmath>

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
      stepper_(control, split_.system, seed, threads) {}

FieldEvolution::Split FieldEvolution::split_at(int rung) const {
    const Reference about = reference_at(equations_.model.uniform, rung);
    Split split{.system = linear_system(equations_, grid_, about, dealiasing_), .remainder = nullptr};
    if (!is_nonlinear(equations_)) return split;
    split.remainder = std::make_shared<RightHandSide>(equations_, split.system, about, threads_);
    split.system.nonlinear = [remainder = split.remainder](double t, const Spectra& state, Spectra& rate) {
        (*remainder)(t, state, rate);
    };
    return split;
}

void FieldEvolution::set_reference(int rung) {
    rung_ = rung;
    split_ = split_at(rung);
    stepper_.set_system(split_.system);
}

/// By the densities of the last evaluation.
void FieldEvolution::follow_beads() {
    const int rung = follow_densities(equations_, split_.remainder->extremes(), rung_);
    if (rung == rung_) return;
    set_reference(rung);
    ++changes_;
}

void FieldEvolution::start(const Spectra& state) {
    if (!split_.remainder) return;
    Spectra rate(grid_, state.count());
    (*split_.remainder)(0.0, state, rate);
    follow_beads();
}

void FieldEvolution::advance(std::int64_t step, Spectra& state) {
    stepper_.advance(step, state);
    if (split_.remainder) follow_beads();
}

std::vector<double> FieldEvolution::save() const {
    return {static_cast<double>(rung_), static_cast<double>(stepper_.division())};
}

void FieldEvolution::restore(std::span<const double> values) {
    const auto integer = [](double value, int min, int max) {
        require(std::isfinite(value) && value == std::round(value) && value >= min && value <= max, {},
                "the checkpoint contains {}; expected an integer from {} to {}; use the other checkpoint", value, min,
                max);
        return static_cast<int>(value);
    };
    require(values.size() == saved_numbers, {}, "the checkpoint contains {} stepper values; expected {}", values.size(),
            saved_numbers);
    const int rung = integer(values[0], -200, 200);
    stepper_.set_division(integer(values[1], 1, numerics::AdaptiveStepper::max_division));
    set_reference(rung);
}

}  // namespace drover::physics
