// run/text_resolution.cpp: the right-hand side at a smooth state, on twice the grid and between the steps.
#include "run/text_resolution.hpp"

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <optional>
#include <span>
#include <utility>

#include "drover/base/threads.hpp"
#include "model/start.hpp"
#include "numerics/fields/shells.hpp"
#include "numerics/fields/wavenumbers.hpp"
#include "numerics/steppers/time_method.hpp"
#include "run/field_problem.hpp"
#include "run/scene_equations.hpp"

namespace drover::run {

namespace {
using numerics::Complex;
using numerics::Grid;
using numerics::Spectra;

/// The explicit right-hand side of a scene on a grid, at a smooth state with those of the longest waves in every field
/// that `coarsest` keeps in the scene's products.  kept: the degree that decides which modes are kept.
class Rates {
public:
    Rates(const FieldProblem& problem, const Grid& grid, const Grid& coarsest, int kept)
        : system_(model::system_of(problem.integrated, grid, kept, one_)),
          rate_(grid, static_cast<int>(problem.components.size())),
          state_(rate_) {
        const model::Equations& equations = problem.integrated.equations;
        const int degree = equations.linear_system(coarsest, problem.integrated.kept_degree).degree;
        const model::UniformState reference = equations.reference();
        const std::vector<model::StateComponent> components = model::components_of_state(equations);
        constexpr double part = 0.02;
        for (std::size_t c = 0; c < components.size(); ++c) {
            const double mean = reference[static_cast<std::size_t>(equations.state_components()[c])];
            if (mean != 0.0) set(static_cast<int>(c), mean, part * mean, coarsest, degree);
            else set(static_cast<int>(c), components[c].part == 0 ? 0.3 : 0.2, part, coarsest, degree);
        }
    }
    Rates(const Rates&) = delete;
    Rates& operator=(const Rates&) = delete;

    const Spectra& at(double t) {
        if (system_.nonlinear) system_.nonlinear(t, state_, rate_);
        return rate_;
    }
    const numerics::System& system() const { return system_; }

private:
    void set(int c, double mean, double wave, const Grid& coarsest, int degree) {
        const Grid& grid = system_.grid;
        state_[c][0] = mean;
        if (coarsest.nx > 2 && numerics::is_kept(coarsest, degree, 1, 0)) state_[c][1] = wave;
        const std::size_t row = numerics::columns(grid);
        if (coarsest.ny > 2 && numerics::is_kept(coarsest, degree, 0, 1))
            state_[c][row] = state_[c][(static_cast<std::size_t>(grid.ny) - 1) * row] = wave;
    }

    Threads one_{1};
    numerics::System system_;
    Spectra rate_;
    Spectra state_;
};

/// Of the equations; functions of the calling program are not looked at.
bool any_text_mentions(const io::Scene& scene, const std::vector<std::string>& names) {
    const model::Model model = equations_of(scene).model();
    const auto any = [&](const model::Text& one) { return mentions(one.text, names); };
    const auto any_of_term = [&](const model::WrittenTerm& term) {
        return (!term.scope || term.scope->functions.empty()) && std::ranges::any_of(term.texts, any);
    };
    return std::ranges::any_of(model.definitions, any, &model::Definition::value) ||
           std::ranges::any_of(model.fields, [&](const model::Field& field) {
               return any(field.equation) || any(field.mass) || std::ranges::any_of(field.further, any_of_term);
           });
}

/// Squares of amplitudes of one component.
struct SpaceError {
    double aliased = 0.0, lost = 0.0, all = 0.0;
};

SpaceError space_error(const Grid& grid, int degree, std::span<const Complex> coarse, const Grid& finer,
                       std::span<const Complex> fine) {
    SpaceError error;
    const std::size_t width = numerics::columns(finer), coarse_width = numerics::columns(grid);
    for (std::size_t m = 0; m < fine.size(); ++m) {
        const int kx = static_cast<int>(m % width), ky = numerics::mode_number_y(finer, m / width);
        const double weight = numerics::mode_weight(finer, m % width), power = weight * std::norm(fine[m]);
        if (m > 0) error.all += power;
        const bool in_range =
            2 * kx < grid.nx + (grid.nx == 1) && (grid.ny == 1 ? ky == 0 : 2 * std::abs(ky) < grid.ny);
        const std::size_t row = static_cast<std::size_t>(ky < 0 ? grid.ny + ky : ky);
        if (in_range && numerics::is_kept(grid, degree, static_cast<std::size_t>(kx), row))
            error.aliased += weight * std::norm(coarse[row * coarse_width + static_cast<std::size_t>(kx)] - fine[m]);
        else error.lost += power;
    }
    return error;
}

std::optional<std::string> space_warning(const io::Scene& scene) {
    constexpr std::size_t max_points = std::size_t{512} * 512;
    const Grid& grid = scene.grid;
    if (!any_text_mentions(scene, {"x", "y"}) || numerics::points(grid) > max_points) return std::nullopt;
    Grid finer = grid;
    finer.nx = grid.nx == 1 ? 1 : 2 * grid.nx;
    finer.ny = grid.ny == 1 ? 1 : 2 * grid.ny;
    // Twice the grid with all its waves: products of the smooth state have none that would need to be cut.
    const FieldProblem problem = field_problem(scene);
    const std::vector<model::StateComponent> components = model::components_of_state(problem.integrated.equations);
    Rates here(problem, grid, grid, problem.integrated.kept_degree), there(problem, finer, grid, 1);
    // A jump loses and folds a few per cent on 100 points, and makes an error of less; on 32 points it is moved by half
    // of a cell, which can make an error of a tenth.
    constexpr double max_aliased = 0.005, max_lost = 0.05;
    for (const double part : {0.0, 0.3819}) {  // of the run: some texts vanish at the start
        const double t = part * scene.time.end;
        const Spectra &coarse = here.at(t), &fine = there.at(t);
        for (int c = 0; c < coarse.count(); ++c) {
            SpaceError error = space_error(grid, here.system().degree, coarse[c], finer, fine[c]);
            const std::size_t first = static_cast<std::size_t>(c);
            if (first + 1 < components.size() && components[first + 1].part == 1) {  // both components of a vector
                ++c;
                const SpaceError other = space_error(grid, here.system().degree, coarse[c], finer, fine[c]);
                error.aliased += other.aliased;
                error.lost += other.lost;
                error.all += other.all;
            }
            if (!std::isfinite(error.all + error.aliased + error.lost))
                continue;  // the smooth state lies outside the domain of a function
            if (error.aliased <= max_aliased * error.all && error.lost <= max_lost * error.all) continue;
            const double wrong = std::min(1.0, std::sqrt((error.aliased + error.lost) / std::max(error.all, 1e-300)));
            return text(
                "the grid does not resolve a term written as text: the rate of {} that it gives is wrong by {:.2g} of "
                "its waves, beside twice the grid (terms of x and y): choose {}, or a smoother text",
                components[first].name, wrong,
                grid.ny == 1 ? text("grid.nx = {}", finer.nx)
                             : text("grid.nx = {} and grid.ny = {}", finer.nx, finer.ny));
        }
    }
    return std::nullopt;
}

/// The integral over a step as the stages of a method see a rate: its values at the nodes, and those before and after.
struct Nodes {
    double before, begin, middle, end, after;
};
double as_seen(const numerics::TimeMethod& method, double dt, const Nodes& at) {
    if (!method.start.empty()) return dt / 24.0 * (13.0 * (at.begin + at.end) - at.before - at.after);
    if (method.order == 1) return dt * at.begin;
    if (method.order == 2) return dt / 2.0 * (at.begin + at.end);
    return dt / 6.0 * (at.begin + 4.0 * at.middle + at.end);
}

/// The stages of a method of SUNDIALS with a fixed step, between the nodes above: ARK4(3)6L[2]SA, Kennedy and
/// Carpenter, Appl. Numer. Math. 44, 139 (2003).
struct Stage {
    double time, weight;
};
constexpr std::array<Stage, 5> stages_of_ark436{{{0.0, 82889.0 / 524892.0},
                                                 {83.0 / 250.0, 15625.0 / 83664.0},
                                                 {31.0 / 50.0, 69875.0 / 102672.0},
                                                 {17.0 / 20.0, -2260.0 / 8211.0},
                                                 {1.0, 0.25}}};

/// How much a rate changes between the nodes of a step: what a method that divides its steps notices.
double change_of(const Nodes& at) {
    double lowest = at.begin, highest = at.begin;
    for (const double value : {at.before, at.middle, at.end, at.after}) {
        lowest = std::min(lowest, value);
        highest = std::max(highest, value);
    }
    return highest - lowest;
}

/// The largest error of the integral of a rate over a window, over its largest deviation from a constant rate.  Of a
/// method that divides its steps that of the part which it does not notice.
class TimeError {
public:
    TimeError(double dt, bool divides) : dt_(dt), divides_(divides) {}

    /// seen: the integral over a step, as the method has it.
    void add(const Nodes& at, double seen, double exact) {
        integral_.push_back((integral_.empty() ? 0.0 : integral_.back()) + exact);
        const double wrong = seen - exact;
        const double noticed = divides_ ? dt_ * change_of(at) : 0.0;
        wrong_ += std::copysign(std::max(0.0, std::abs(wrong) - noticed), wrong);
        largest_ = std::max(largest_, std::abs(wrong_));
        size_ += std::abs(exact);
    }
    double relative() const {
        const auto steps = static_cast<double>(integral_.size());
        double deviation = 0.0;
        for (std::size_t i = 0; i < integral_.size(); ++i)
            deviation =
                std::max(deviation, std::abs(integral_[i] - static_cast<double>(i + 1) / steps * integral_.back()));
        constexpr double rounding = 1e-9;
        const double scale = std::max(deviation, largest_);
        return largest_ <= rounding * size_ || scale == 0.0 ? 0.0 : largest_ / std::max(deviation, rounding * size_);
    }

private:
    double dt_;
    bool divides_;
    double wrong_ = 0.0, largest_ = 0.0, size_ = 0.0;
    std::vector<double> integral_;
};

std::optional<std::string> time_warning(const io::Scene& scene) {
    if (scene.time.dt == 0.0 || !any_text_mentions(scene, {"t"})) return std::nullopt;
    const double dt = scene.time.dt;
    const numerics::TimeMethod& method = numerics::time_method(scene.time.stepper);
    const bool has_stages = scene.time.tolerance == 0.0 && method.name == "arkode-ark436l2sa";
    Grid small = scene.grid;
    small.nx = std::min(small.nx, 8);
    small.ny = std::min(small.ny, 8);
    const FieldProblem problem = field_problem(scene);
    Rates rates(problem, small, small, problem.integrated.kept_degree);
    const int count = rates.at(0.0).count();
    const auto values_at = [&](double t) {  // the mean rate of each component, and its longest wave
        std::vector<double> values;
        const Spectra& rate = rates.at(t);
        for (int c = 0; c < count; ++c) {
            values.push_back(rate[c][0].real());
            values.push_back(rate[c][1].real());
            values.push_back(rate[c][1].imag());
        }
        return values;
    };
    constexpr std::int64_t in_window = 128, most_windows = 8;
    const int parts = has_stages ? 21 : 7;  // a switch falls into one of them
    const auto steps = static_cast<std::int64_t>(std::llround(scene.time.end / dt));
    const std::int64_t windows = std::min(most_windows, std::max<std::int64_t>(1, steps / in_window));
    const std::int64_t length = windows < most_windows ? steps / windows : in_window;
    double worst = 0.0, worst_time = 0.0;
    for (std::int64_t window = 0; window < windows; ++window) {
        const std::int64_t first = windows == 1 ? 0 : (steps - length) * window / (windows - 1);
        std::vector<TimeError> errors(3 * static_cast<std::size_t>(count), TimeError(dt, scene.time.tolerance > 0.0));
        std::vector<double> before = values_at((static_cast<double>(first) - 1.0) * dt),
                            begin = values_at(static_cast<double>(first) * dt),
                            end = values_at((static_cast<double>(first) + 1.0) * dt);
        for (std::int64_t step = first; step < first + length; ++step) {
            const double t = static_cast<double>(step) * dt;
            std::vector<double> exact(errors.size(), 0.0), middle, after = values_at(t + 2.0 * dt);
            for (int part = 0; part < parts; ++part) {
                const std::vector<double> now = values_at(t + dt * (part + 0.5) / parts);
                for (std::size_t k = 0; k < exact.size(); ++k) exact[k] += dt / parts * now[k];
                if (2 * part + 1 == parts) middle = now;
            }
            std::vector<double> by_stages(errors.size(), 0.0);
            if (has_stages)
                for (const Stage& stage : stages_of_ark436) {
                    const std::vector<double> now = values_at(t + dt * stage.time);
                    for (std::size_t k = 0; k < now.size(); ++k) by_stages[k] += dt * stage.weight * now[k];
                }
            for (std::size_t k = 0; k < errors.size(); ++k) {
                const Nodes nodes{before[k], begin[k], middle[k], end[k], after[k]};
                errors[k].add(nodes, has_stages ? by_stages[k] : as_seen(method, dt, nodes), exact[k]);
            }
            before = std::exchange(begin, std::exchange(end, std::move(after)));
        }
        for (const TimeError& error : errors)
            if (const double relative = error.relative(); relative > worst) {
                worst = relative;
                worst_time = static_cast<double>(first) * dt;
            }
    }
    constexpr double max_wrong = 0.03;  // a switch in the middle of 100 steps is wrong by 0.02, and its fields by less
    if (worst <= max_wrong) return std::nullopt;
    return text(
        "time.dt = {} does not resolve a term written as text of t: what its steps add up is wrong by {:.2g} of its "
        "change, in the steps from t = {:.6g} s on: choose time.dt = {:.3g}, or a slower text",
        dt, std::min(worst, 1.0), worst_time, dt / 4.0);
}
}  // namespace

bool mentions(const std::string& formula, const std::vector<std::string>& names) {
    const auto in_name = [](char c) { return std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '_'; };
    for (std::size_t i = 0; i < formula.size();) {
        const auto end = std::find_if_not(formula.begin() + static_cast<std::ptrdiff_t>(i), formula.end(), in_name);
        const std::string name(formula.begin() + static_cast<std::ptrdiff_t>(i), end);
        if (std::find(names.begin(), names.end(), name) != names.end()) return true;
        i += std::max<std::size_t>(1, name.size());
    }
    return false;
}

std::vector<std::string> text_resolution_warnings(const io::Scene& scene) {
    std::vector<std::string> warnings;
    for (const auto& check : {space_warning, time_warning}) {
        try {
            if (const std::optional<std::string> warning = check(scene)) warnings.push_back(*warning);
        } catch (const Error& error) {  // the smooth state lies outside the domain of a term: the run is another
            if (error.fault() != Fault::run) throw;
        }
    }
    return warnings;
}

}  // namespace drover::run
