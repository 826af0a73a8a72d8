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
      stepper_(control, split_.system, seed, threads) {
    if (split_.remainder && control.watches_error)
        error_.emplace(equations_, grid, dealiasing, control.dt, control.tolerance > 0.0);
}

FieldEvolution::Split FieldEvolution::split_at(int rung) const {
    const Reference about = reference_at(equations_.model.uniform, rung);
    Split split{.system = linear_system(equations_, grid_, about, dealiasing_), .remainder = nullptr};
    if (!is_nonlinear(equations_)) return split;
    split.remainder = std::make_shared<RightHandSide>(equations_, split.system, about, threads_);
    split.system.nonlinear = [remainder = split.remainder](double t, const Spectra& state, Spectra& rate) {
        (*remainder)(t, state, rate);
    };
    split.system.set_step = [remainder = split.remainder](double dt) { remainder->set_step(dt); };
    return split;
}

void FieldEvolution::set_reference(int rung) {
    rung_ = rung;
    split_ = split_at(rung);
    stepper_.set_system(split_.system);
    if (error_) error_->set_reference(reference_at(equations_.model.uniform, rung));
}

void FieldEvolution::follow(const FieldEvolution& other) {
    stepper_.set_division(1);
    stepper_.restore_history({});
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
    split_.remainder->set_step(stepper_.dt());
    follow_beads(moving_extremes());
}

namespace {
/// Steps until the next is repeated in halves, which costs two steps: 1.7 % of 2000 steps, 0.4 % of a long run.  Local
/// errors change most at the start.
std::int64_t steps_to_next_check(std::int64_t step) { return std::clamp<std::int64_t>(2 * step / 3, 1, 500); }
/// Where the error of a step costs no right-hand side.
std::int64_t steps_to_cheap_check(std::int64_t step) { return std::clamp<std::int64_t>(step / 16, 1, 100); }
}  // namespace

void FieldEvolution::advance(std::int64_t step, Spectra& state) {
    const bool checks = error_ && step >= next_check_;
    if (checks) before_ = state;
    stepper_.advance(step, state);
    if (!split_.remainder) return;
    const Extremes extremes = moving_extremes();
    if (checks) measure_error(step, state);
    if (error_) error_->advance(step + 1, state);
    follow_beads(extremes);
}

void FieldEvolution::measure_error(std::int64_t step, const Spectra& state) {
    error_->start_local(before_);
    stepper_.find_error(step, state, before_);
    const std::int64_t cheap = stepper_.steps_to_cheap_error();
    next_check_ = step + (cheap > 0 ? std::max(cheap, steps_to_cheap_check(step)) : steps_to_next_check(step));
    error_->add_local(before_, state);
    const StepError::Relative local = error_->largest_local();
    // Fields that overflow have no error; the check of the fields says which of them failed first.
    double square = 0.0;
    for (const numerics::Complex value : state.values) square += std::norm(value);
    if (std::isfinite(square) && !(local.error < 0.5))
        fail_run(
            "the time step is too long: at t = {:.6g} s one step of {:.4g} s {}; choose time.dt <= {:.3g}, or a "
            "time.tolerance",
            (static_cast<double>(step) + 1.0) * stepper_.dt(), stepper_.dt(),
            std::isfinite(local.error) ? text("is wrong by {:.3g} times the {}", local.error, local.field)
                                       : text("leaves the {} without a finite error", local.field),
            stepper_.dt() / 4.0);
}

std::vector<double> FieldEvolution::save() const {
    std::vector<double> values{static_cast<double>(rung_), static_cast<double>(stepper_.division()),
                               static_cast<double>(next_check_)};
    const std::vector<double> history = stepper_.save_history();
    values.insert(values.end(), history.begin(), history.end());
    if (!error_) return values;
    const std::vector<double> error = error_->save();
    values.insert(values.end(), error.begin(), error.end());
    return values;
}

void FieldEvolution::restore(std::span<const double> values) {
    const auto integer = [](double value, int min, int max) {
        require(std::isfinite(value) && value == std::round(value) && value >= min && value <= max, {},
                "the checkpoint contains {}; expected an integer from {} to {}; use the other checkpoint", value, min,
                max);
        return static_cast<int>(value);
    };
    const std::size_t error_numbers = error_ ? error_->saved_numbers() : 0;
    require(values.size() >= 3 + error_numbers, {}, "the checkpoint contains {} stepper values; expected {} or more",
            values.size(), 3 + error_numbers);
    require(std::isfinite(values[2]) && values[2] >= 0.0 && values[2] < 0x1p53, {},
            "the checkpoint contains the step {}; expected 0 or more; use the other checkpoint", values[2]);
    next_check_ = static_cast<std::int64_t>(values[2]);
    const int rung = integer(values[0], -200, 200);
    stepper_.set_division(integer(values[1], 1, numerics::AdaptiveStepper::max_division));
    set_reference(rung);
    stepper_.restore_history(values.subspan(3, values.size() - 3 - error_numbers));
    if (error_) error_->restore(values.last(error_numbers));
}

}  // namespace drover::physics
