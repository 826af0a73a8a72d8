// run/field_evolution.cpp: the reference and the step that follow a run.
#include "drover/run/field_evolution.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "drover/base/log.hpp"

namespace drover::run {

namespace {
using numerics::Spectra;

/// 1, 2, 3, 4, 6, 8, 12, 16, ...
int coarser(int division) {
    if (division <= 2) return 1;
    if (division == 3) return 2;
    const bool is_power = (division & (division - 1)) == 0;
    return is_power ? division / 4 * 3 : division / 3 * 2;
}
constexpr int max_division = 1 << 16;

physics::Reference reference_at(const physics::UniformState& uniform, int rung) {
    physics::Reference result = physics::reference(uniform);
    result.bead_density *= std::exp2(0.5 * rung);
    return result;
}
}  // namespace

struct FieldEvolution::Solver {
    std::shared_ptr<physics::RightHandSide> rest;  // none: the system is linear
    numerics::System system;
    std::unique_ptr<numerics::Stepper> stepper;
};

FieldEvolution::FieldEvolution(const io::Scene& scene, Threads& threads)
    : scene_(scene),
      equations_(scene.model),
      linear_(
          physics::linear_system(equations_, scene.grid, physics::reference(scene.model.uniform), scene.dealiasing)),
      threads_(threads) {
    if (scene_.time.tolerance > 0.0) {
        next_ = Spectra(scene_.grid, numerics::components(linear_.layout));
        error_ = next_;
    }
    solver(1);
}
FieldEvolution::~FieldEvolution() = default;

FieldEvolution::Solver& FieldEvolution::solver(int division) {
    std::unique_ptr<Solver>& found = solvers_[division];
    if (found) return *found;
    found = std::make_unique<Solver>();
    const physics::Reference reference = reference_at(scene_.model.uniform, reference_rung_);
    found->system = physics::linear_system(equations_, scene_.grid, reference, scene_.dealiasing);
    if (physics::is_nonlinear(equations_)) {
        found->rest = std::make_shared<physics::RightHandSide>(equations_, found->system, reference, threads_);
        found->system.nonlinear = [rest = found->rest](double t, const Spectra& state, Spectra& rate) {
            (*rest)(t, state, rate);
        };
    }
    found->stepper = std::make_unique<numerics::Stepper>(found->system, numerics::stepper_table(scene_.time.stepper),
                                                         scene_.time.dt / division,
                                                         static_cast<std::uint64_t>(scene_.run.seed), threads_);
    // The rungs in use are neighbours; others cost memory alone.
    constexpr std::size_t kept = 4;
    while (solvers_.size() > kept) {
        const bool first_is_farther = division - solvers_.begin()->first > solvers_.rbegin()->first - division;
        solvers_.erase(first_is_farther ? solvers_.begin() : std::prev(solvers_.end()));
    }
    return *solvers_.at(division);
}

void FieldEvolution::start(const Spectra& state) {
    const Solver& first = solver(1);
    if (!first.rest) return;
    Spectra rate(scene_.grid, state.count());
    (*first.rest)(0.0, state, rate);
    follow_densities(first.rest->extremes());
}

/// Hysteresis of half a rung keeps a density near a boundary from changing the reference again and again.
void FieldEvolution::follow_densities(const physics::Extremes& extremes) {
    if (equations_.form.bead_density < 0 || equations_.form.velocity == physics::Velocity::absent) return;
    const bool divides = equations_.form.velocity == physics::Velocity::dynamic;
    const double density = divides ? extremes.min_bead : extremes.max_bead;
    if (!std::isfinite(density) || density <= 0.0) return;
    // Rungs at which the reference is at most 1.7 times the least, or at least 1/1.7 of the largest.
    const double wanted = 2.0 * std::log2(density / scene_.model.uniform.bead_density), room = 2.0 * std::log2(1.7);
    int rung = reference_rung_;
    if (divides) {
        if (rung > wanted + room) rung = static_cast<int>(std::floor(wanted + room));
        if (rung < 0 && rung + 1.5 < wanted + room)
            rung = std::min(0, static_cast<int>(std::floor(wanted + room - 0.5)));
    } else {
        if (rung < wanted - room) rung = static_cast<int>(std::ceil(wanted - room));
        if (rung > 0 && rung - 1.5 > wanted - room)
            rung = std::max(0, static_cast<int>(std::ceil(wanted - room + 0.5)));
    }
    if (rung == reference_rung_) return;
    reference_rung_ = rung;
    solvers_.clear();
    ++count_.references;
}

/// The root mean square of the error of each field beside that of the field itself, or of its change over a whole dt at the
/// present rate where that is larger: a field that starts from zero has no size of its own yet.
double FieldEvolution::relative_error(const Spectra& error, const Spectra& before, const Spectra& after) const {
    const physics::Form& form = equations_.form;
    const double steps_in_dt = count_.division;
    double largest = 0.0;
    for (const auto& [first, width] : {std::pair{form.bead_density, 1}, std::pair{form.rod_density, 1},
                                       std::pair{form.bead_velocity, 2}, std::pair{form.polar_order, 2}}) {
        if (first < 0) continue;
        double wrong = 0.0, size = 0.0, change = 0.0;
        for (int c = first; c < first + width; ++c)
            for (std::size_t m = 0; m < after.size; ++m) {
                wrong += std::norm(error[c][m]);
                size += std::norm(after[c][m]);
                change += std::norm(after[c][m] - before[c][m]);
            }
        if (!std::isfinite(wrong)) return INFINITY;
        const double scale = std::sqrt(std::max(size, steps_in_dt * steps_in_dt * change));
        if (wrong > 0.0) largest = std::max(largest, scale > 0.0 ? std::sqrt(wrong) / scale : INFINITY);
    }
    return largest;
}

void FieldEvolution::advance_adaptively(double t, Spectra& state) {
    const double tolerance = scene_.time.tolerance;
    const int order = numerics::stepper_table(scene_.time.stepper).order;  // the error of the pair falls as dt^order
    double largest = 0.0;
    for (int i = 0; i < count_.division;) {
        numerics::Stepper& stepper = *solver(count_.division).stepper;
        stepper.attempt(t + scene_.time.dt * i / count_.division, state, next_, error_);
        const double error = relative_error(error_, state, next_);
        if (error <= tolerance) {
            std::swap(state.values, next_.values);
            largest = std::max(largest, error);
            ++count_.accepted;
            ++i;
            continue;
        }
        ++count_.refused;
        if (count_.division > max_division / 2)
            fail_run(
                "no step down to {:.3g} s meets time.tolerance = {} at t = {:.6g} s: the estimate of its error is "
                "{:.3g}; the fields "
                "may be blowing up; else give a larger tolerance or a smaller time.dt",
                scene_.time.dt / count_.division, tolerance, t, error);
        count_.division *= 2;
        i *= 2;
    }
    constexpr double safety = 2.0;
    const double growth = static_cast<double>(count_.division) / coarser(count_.division);
    if (count_.division > 1 && safety * largest * std::pow(growth, order) < tolerance)
        count_.division = coarser(count_.division);
}

void FieldEvolution::advance(std::int64_t step, Spectra& state) {
    const double t = static_cast<double>(step) * scene_.time.dt;
    if (scene_.time.tolerance > 0.0 && solver(1).rest) {
        advance_adaptively(t, state);
    } else {
        solver(1).stepper->step(t, static_cast<std::uint64_t>(step), state);
        ++count_.accepted;
    }
    if (const Solver& used = solver(scene_.time.tolerance > 0.0 ? count_.division : 1); used.rest)
        follow_densities(used.rest->extremes());
}

std::vector<double> FieldEvolution::save() const {
    return {static_cast<double>(reference_rung_), static_cast<double>(count_.division)};
}

void FieldEvolution::restore(std::span<const double> values) {
    const auto whole = [](double value, int least, int most) {
        require(std::isfinite(value) && value == std::round(value) && value >= least && value <= most, {},
                "the checkpoint holds {} where a whole number from {} to {} is expected; take the other checkpoint",
                value, least, most);
        return static_cast<int>(value);
    };
    require(values.size() == saved_numbers, {}, "the checkpoint holds {} numbers of the stepper; expected {}",
            values.size(), saved_numbers);
    reference_rung_ = whole(values[0], -200, 200);
    count_.division = whole(values[1], 1, max_division);
    solvers_.clear();
}

}  // namespace drover::run
