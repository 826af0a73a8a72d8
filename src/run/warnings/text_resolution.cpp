// run/warnings/text_resolution.cpp: the right-hand side at a smooth state, on twice the grid and between the steps.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <optional>
#include <span>
#include <utility>

#include "base/mapped.hpp"
#include "drover/base/threads.hpp"
#include "io/declared_model.hpp"
#include "io/units.hpp"
#include "model/start.hpp"
#include "numerics/fields/shells.hpp"
#include "numerics/steppers/time_method.hpp"
#include "run/fields/field_problem.hpp"
#include "run/warnings/warnings.hpp"

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
    /// The effect of all noises that multiply, with the waves of the first field in each component; nullptr: there is
    /// none, or it has no value in the smooth state.
    const Spectra* noise_at(double t) {
        if (!system_.product_noise) return nullptr;
        Spectra increments(system_.grid, components(system_.product_noise->layout));
        constexpr double apart = 0.37;  // so that the effects of two do not cancel
        for (int noise = 0; noise < increments.count(); ++noise) {
            std::ranges::transform(state_[0], increments[noise].begin(),
                                   [&](Complex mode) { return (1.0 + apart * noise) * mode; });
            increments[noise][0] = 1.0 + apart * noise;
        }
        std::ranges::fill(rate_.values, 0.0);
        try {
            system_.product_noise->add(t, state_, increments, rate_);
        } catch (const Error& error) {
            if (error.fault() != Fault::run) throw;
            return nullptr;
        }
        return &rate_;
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

/// The formulas of the equations; functions of the calling program are not looked at.
std::vector<std::string> formulas_of(const model::Model& model) {
    std::vector<std::string> formulas;
    for (const model::Definition& one : model.definitions) formulas.push_back(one.value.text);
    for (const model::Field& field : model.fields) {
        formulas.insert(formulas.end(), {field.equation.text, field.mass.text});
        for (const model::WrittenTerm& term : field.further)
            if (!term.scope || term.scope->functions.empty())
                for (const model::Text& one : term.texts) formulas.push_back(one.text);
    }
    return formulas;
}

bool mentions(const model::Model& model, const std::vector<std::string>& names) {
    const std::vector<std::string> formulas = formulas_of(model);
    return std::ranges::any_of(formulas, [&](const std::string& one) { return io::mentions(one, names); });
}

/// The numbers between 0 and `end` in formulas, and those that have names there: a pulse may be at one of them.
std::vector<double> named_times(const model::Model& model, double end) {
    std::vector<double> numbers;
    for (const auto& [name, value] : model.coefficients) numbers.push_back(value);
    for (const model::Field& field : model.fields)
        for (const model::WrittenTerm& term : field.further)
            if (term.scope)
                for (const auto& [name, value] : term.scope->parameters) numbers.push_back(value);
    for (const std::string& formula : formulas_of(model))
        for (const char* at = formula.c_str(); *at != '\0';) {
            char* after = nullptr;
            const double number = std::isalpha(static_cast<unsigned char>(*at)) != 0 ? 0.0 : std::strtod(at, &after);
            if (after == nullptr || after == at) {
                ++at;
                continue;
            }
            numbers.push_back(std::abs(number));
            at = after;
        }
    std::erase_if(numbers, [&](double one) { return !(one > 0.0 && one < end); });
    std::ranges::sort(numbers);
    numbers.erase(std::ranges::unique(numbers).begin(), numbers.end());
    constexpr std::size_t max_numbers = 16;
    if (numbers.size() > max_numbers) numbers.resize(max_numbers);
    return numbers;
}

/// Parts of a step whose middles sample a rate: equal ones, and ever shorter ones towards the named times in it.
std::vector<std::pair<double, double>> parts_of_step(double begin, double dt, int equal,
                                                     const std::vector<double>& named) {
    std::vector<double> edges;
    for (int k = 0; k <= equal; ++k) edges.push_back(begin + dt * k / equal);
    constexpr int halvings = 30;
    for (const double time : named)
        for (int k = 0; k <= halvings; ++k)
            for (const double side : {-1.0, 1.0}) edges.push_back(time + side * dt * std::exp2(-0.5 * k));
    std::erase_if(edges, [&](double edge) { return edge < begin || edge > begin + dt; });
    std::ranges::sort(edges);
    std::vector<std::pair<double, double>> parts;  // middle and width
    for (std::size_t k = 1; k < edges.size(); ++k)
        if (edges[k] > edges[k - 1]) parts.emplace_back(0.5 * (edges[k] + edges[k - 1]), edges[k] - edges[k - 1]);
    return parts;
}

/// Steps that are looked at: their first, and how many.
struct Window {
    std::int64_t first, count;
};

/// All steps of a short run, parts of a long one; and the steps about each named time.
std::vector<Window> windows_of(std::int64_t steps, double dt, const std::vector<double>& named) {
    constexpr std::int64_t in_window = 128, max_windows = 8, about = in_window / 2;
    std::vector<Window> windows;
    const std::int64_t count = std::min(max_windows, std::max<std::int64_t>(1, steps / in_window));
    const std::int64_t length = count < max_windows ? steps / count : in_window;
    for (std::int64_t window = 0; window < count; ++window)
        windows.push_back({count == 1 ? 0 : (steps - length) * window / (count - 1), length});
    if (count * length < steps)
        for (const double time : named) {
            const std::int64_t first = std::max<std::int64_t>(0, static_cast<std::int64_t>(time / dt) - about);
            windows.push_back({first, std::min(2 * about + 1, steps - first)});
        }
    return windows;
}

/// Squares of amplitudes of one component.
struct SpaceError {
    double aliased = 0.0, lost = 0.0, all = 0.0;
};

/// has_mean: whether `all` includes the mean.
SpaceError space_error(const Grid& grid, int degree, std::span<const Complex> coarse, const Grid& finer,
                       std::span<const Complex> fine, bool has_mean) {
    SpaceError error;
    const std::size_t width = numerics::columns(finer), coarse_width = numerics::columns(grid);
    for (std::size_t m = 0; m < fine.size(); ++m) {
        const int kx = static_cast<int>(m % width), ky = numerics::mode_number_y(finer, m / width);
        const double weight = numerics::mode_weight(finer, m % width), power = weight * std::norm(fine[m]);
        if (m > 0 || has_mean) error.all += power;
        const bool in_range =
            2 * kx < grid.nx + (grid.nx == 1) && (grid.ny == 1 ? ky == 0 : 2 * std::abs(ky) < grid.ny);
        const std::size_t row = static_cast<std::size_t>(ky < 0 ? grid.ny + ky : ky);
        if (in_range && numerics::is_kept(grid, degree, static_cast<std::size_t>(kx), row))
            error.aliased += weight * std::norm(coarse[row * coarse_width + static_cast<std::size_t>(kx)] - fine[m]);
        else error.lost += power;
    }
    return error;
}

std::optional<std::string> space_warning(const io::Scene& scene, const FieldProblem& problem) {
    const Grid& grid = scene.grid;
    Grid finer = grid;
    finer.nx = grid.nx == 1 ? 1 : 2 * grid.nx;
    finer.ny = grid.ny == 1 ? 1 : 2 * grid.ny;
    // Twice the grid with all its waves: products of the smooth state have none that would need to be cut.
    const std::vector<model::StateComponent> components = model::components_of_state(problem.integrated.equations);
    Rates here(problem, grid, grid, problem.integrated.kept_degree), there(problem, finer, grid, 1);
    // A jump loses and folds a few per cent on 100 points, and makes an error of less; on 32 points it is moved by half
    // of a cell, which can make an error of a tenth.
    constexpr double max_aliased = 0.005, max_lost = 0.05;
    const auto warning = [&](const Spectra& coarse, const Spectra& fine, bool is_noise) -> std::optional<std::string> {
        std::vector<SpaceError> errors;  // of each field
        double largest = 0.0;
        for (int c = 0; c < coarse.count(); ++c) {
            const SpaceError error = space_error(grid, here.system().degree, coarse[c], finer, fine[c], is_noise);
            if (components[static_cast<std::size_t>(c)].part == 0) errors.push_back({});
            errors.back().aliased += error.aliased;
            errors.back().lost += error.lost;
            errors.back().all += error.all;
            if (std::isfinite(error.all)) largest = std::max(largest, errors.back().all);
        }
        constexpr double rounding = 1e-20;  // a square: where a noise does not drive a field
        std::size_t field = 0;
        for (std::size_t c = 0; c < components.size(); ++c) {
            if (components[c].part != 0) continue;
            const SpaceError& error = errors[field++];
            if (!std::isfinite(error.all + error.aliased + error.lost))
                continue;  // the smooth state lies outside the domain of a function
            if (is_noise && error.all <= rounding * largest) continue;
            if (error.aliased <= max_aliased * error.all && error.lost <= max_lost * error.all) continue;
            const double wrong = std::min(1.0, std::sqrt((error.aliased + error.lost) / std::max(error.all, 1e-300)));
            return text(
                "the grid does not resolve a term written as text: the relative error of the {} of {} is {:.2g}, "
                "compared with twice the points along each axis (terms in x and y): choose {}, or a smoother "
                "expression",
                is_noise ? "noise" : "rate", components[c].name, wrong, grid_keys(finer));
        }
        return std::nullopt;
    };
    for (const double part : {0.0, 0.3819}) {  // of the run: some texts vanish at the start
        const double t = part * scene.time.end;
        if (auto found = warning(here.at(t), there.at(t), false)) return found;
        if (const Spectra* coarse = here.noise_at(t), *fine = there.noise_at(t); coarse && fine)
            if (auto found = warning(*coarse, *fine, true)) return found;
    }
    return std::nullopt;
}

/// The integral over a step as the stages of a method see a rate: its values at the nodes, and those before and after.
struct Nodes {
    double before, begin, middle, end, after;
};
double simpson(double begin, double middle, double end) { return (begin + 4.0 * middle + end) / 6.0; }
double as_seen(const numerics::TimeMethod& method, double dt, const Nodes& at) {
    if (!method.start.empty()) return dt / 24.0 * (13.0 * (at.begin + at.end) - at.before - at.after);
    if (method.order == 1) return dt * at.begin;
    if (method.order == 2) return dt / 2.0 * (at.begin + at.end);
    return dt * simpson(at.begin, at.middle, at.end);
}

/// The error of a step that a method with a tolerance notices and divides the step for: four times what its estimate
/// has of a rate with these values, since it sees smooth rates only in part; see numerics::AdaptiveStepper.
/// first, last: the rates at a quarter of the step and at three quarters.
double noticed_of(const numerics::TimeMethod& method, bool has_noise, double dt, const Nodes& at, double first,
                  double last) {
    constexpr double seen_in_part = 4.0;
    double estimate = 0.0;
    if (method.is_exponential && !has_noise)  // by halves
        estimate = method.order < 3
                       ? 0.25 * (at.begin - 2.0 * at.middle + at.end)
                       : simpson(at.begin, at.middle, at.end) -
                             0.5 * (simpson(at.begin, first, at.middle) + simpson(at.middle, last, at.end));
    else if (method.is_exponential ? method.order < 3 : method.implicit_table.empty())
        estimate = 0.5 * (at.end - at.begin);
    else if (!method.is_exponential || method.order == 3) estimate = (at.begin - 2.0 * at.middle + at.end) / 6.0;
    return seen_in_part * dt * std::abs(estimate);
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

/// The largest error of the integral of a rate over a window, over its largest deviation from a constant rate.  Of a
/// method that divides its steps that of the part which it does not notice.
class TimeError {
public:
    /// seen: the integral over a step, as the method has it; noticed: an error up to this divides the step.
    void add(double seen, double exact, double noticed) {
        integral_.push_back((integral_.empty() ? 0.0 : integral_.back()) + exact);
        const double wrong = seen - exact;
        wrong_ += std::copysign(std::max(0.0, std::abs(wrong) - noticed), wrong);
        largest_ = std::max(largest_, std::abs(wrong_));
        size_ += std::abs(exact);
    }
    double deviation() const {
        const auto steps = static_cast<double>(integral_.size());
        double deviation = 0.0;
        for (std::size_t i = 0; i < integral_.size(); ++i)
            deviation =
                std::max(deviation, std::abs(integral_[i] - static_cast<double>(i + 1) / steps * integral_.back()));
        return deviation;
    }
    /// The sum of the sizes of the integrals.
    double size() const { return size_; }
    /// To the deviation, and at least to `min_scale`; 0 within a rounding error of a rate of `size`.
    double relative(double min_scale, double size) const {
        constexpr double rounding = 1e-9;
        const double scale = std::max({deviation(), rounding * size, min_scale});
        return largest_ <= rounding * size ? 0.0 : largest_ / scale;
    }

private:
    double wrong_ = 0.0, largest_ = 0.0, size_ = 0.0;
    std::vector<double> integral_;
};

/// The rates on a few points as numbers: the mean rate of each component and both parts of its longest wave, and behind
/// them the mean square of what noise that multiplies does to each.
std::vector<double> numbers_at(Rates& rates, double t) {
    std::vector<double> values;
    const Spectra& rate = rates.at(t);
    for (int c = 0; c < rate.count(); ++c)
        values.insert(values.end(), {rate[c][0].real(), rate[c][1].real(), rate[c][1].imag()});
    if (!rates.system().product_noise) return values;
    const Grid& grid = rates.system().grid;
    const Spectra* effect = rates.noise_at(t);
    for (int c = 0; c < rate.count(); ++c) {
        values.push_back(0.0);
        for (std::size_t m = 0; effect != nullptr && m < effect->size; ++m)
            values.back() += numerics::mode_weight(grid, m % numerics::columns(grid)) * std::norm((*effect)[c][m]);
    }
    return values;
}

/// How a scene steps, and how finely its rates are sampled.
struct Stepping {
    double dt;
    const numerics::TimeMethod& method;
    bool has_stages, divides, has_noise;
    int parts;                  ///< of a step
    std::size_t of_rates;       ///< numbers of the rates that are no noise
    std::vector<double> named;  ///< times
};

Stepping stepping_of(const io::Scene& scene, const FieldProblem& problem) {
    const numerics::TimeMethod& method = numerics::time_method(scene.time.stepper);
    const bool has_stages = scene.time.tolerance == 0.0 && method.name == "arkode-ark436l2sa";
    constexpr int fewest = 7, in_stages = 21, samples = 2048;  // a switch falls into one of the parts
    const std::int64_t steps = std::max<std::int64_t>(std::llround(scene.time.end / scene.time.dt), 1);
    return {.dt = scene.time.dt,
            .method = method,
            .has_stages = has_stages,
            .divides = scene.time.tolerance > 0.0,
            .has_noise = io::has_noise(scene),
            .parts = std::max(has_stages ? in_stages : fewest, static_cast<int>(samples / steps) | 1),
            .of_rates = 3 * problem.components.size(),
            .named = named_times(problem.integrated.equations.model(), scene.time.end)};
}

/// Adds `weight` times the rates at a time.
void add_rates(Rates& rates, double t, double weight, std::vector<double>& to) {
    const std::vector<double> now = numbers_at(rates, t);
    for (std::size_t k = 0; k < to.size(); ++k) to[k] += weight * now[k];
}

/// Of each number of the rates.
std::vector<TimeError> errors_of(Rates& rates, const Stepping& how, const Window& window) {
    const double dt = how.dt;
    const auto first = static_cast<double>(window.first);
    std::vector<double> before = numbers_at(rates, (first - 1.0) * dt), begin = numbers_at(rates, first * dt),
                        end = numbers_at(rates, (first + 1.0) * dt);
    std::vector<TimeError> errors(begin.size());
    for (std::int64_t step = window.first; step < window.first + window.count; ++step) {
        const double t = static_cast<double>(step) * dt;
        std::vector<double> exact(errors.size(), 0.0), by_stages = exact, after = numbers_at(rates, t + 2.0 * dt);
        const std::vector<double> middle = numbers_at(rates, t + 0.5 * dt);
        for (const auto& [at, width] : parts_of_step(t, dt, how.parts, how.named)) add_rates(rates, at, width, exact);
        if (how.has_stages)
            for (const Stage& stage : stages_of_ark436)
                add_rates(rates, t + dt * stage.time, dt * stage.weight, by_stages);
        const std::vector<double> first_quarter = how.divides ? numbers_at(rates, t + 0.25 * dt) : middle,
                                  last_quarter = how.divides ? numbers_at(rates, t + 0.75 * dt) : middle;
        for (std::size_t k = 0; k < errors.size(); ++k) {
            const Nodes nodes{before[k], begin[k], middle[k], end[k], after[k]};
            if (k >= how.of_rates) errors[k].add(dt * middle[k], exact[k], 0.0);
            else
                errors[k].add(how.has_stages ? by_stages[k] : as_seen(how.method, dt, nodes), exact[k],
                              how.divides
                                  ? noticed_of(how.method, how.has_noise, dt, nodes, first_quarter[k], last_quarter[k])
                                  : 0.0);
        }
        before = std::exchange(begin, std::exchange(end, std::move(after)));
    }
    return errors;
}

/// The largest relative error, and its window.  all: of each window.  of_rates: numbers that are no noise.
std::pair<double, std::size_t> worst_error(const std::vector<std::vector<TimeError>>& all, std::size_t of_rates) {
    constexpr double matters = 0.01;  // of the largest change in any window
    // The mean and both parts of the wave of one component have the rounding errors of the largest of them, and a small
    // part of what changes may be aliased on this small grid.
    const auto largest_of = [&](const std::vector<TimeError>& errors, std::size_t k, double (TimeError::*of)() const) {
        if (k >= of_rates) return (errors[k].*of)();  // of a noise
        const std::size_t first = k - k % 3;
        return std::max({(errors[first].*of)(), (errors[first + 1].*of)(), (errors[first + 2].*of)()});
    };
    const auto size_of = [&](const std::vector<TimeError>& errors, std::size_t k) {
        double size = largest_of(errors, k, &TimeError::size);
        for (std::size_t one = of_rates; k >= of_rates && one < errors.size();
             ++one)  // it may not drive this component
            size = std::max(size, errors[one].size());
        return size;
    };
    std::pair<double, std::size_t> worst{0.0, 0};
    for (std::size_t k = 0; k < all.front().size(); ++k) {
        double largest = 0.0;
        for (const std::vector<TimeError>& errors : all)
            largest = std::max(largest, largest_of(errors, k, &TimeError::deviation));
        for (std::size_t n = 0; n < all.size(); ++n)
            if (const double relative = all[n][k].relative(matters * largest, size_of(all[n], k));
                relative > worst.first)
                worst = {relative, n};
    }
    return worst;
}

std::optional<std::string> time_warning(const io::Scene& scene, const FieldProblem& problem) {
    const double dt = scene.time.dt;
    Grid small = scene.grid;
    const int few = mentions(problem.integrated.equations.model(), {"x", "y"})
                        ? 16
                        : 8;  // of a moving source some harmonics are kept
    small.nx = std::min(small.nx, few);
    small.ny = std::min(small.ny, few);
    Rates rates(problem, small, small, problem.integrated.kept_degree);
    const Stepping how = stepping_of(scene, problem);
    const std::vector<Window> windows = windows_of(std::llround(scene.time.end / dt), dt, how.named);
    const auto all = mapped(windows, [&](const Window& window) { return errors_of(rates, how, window); });
    const auto [worst, window] = worst_error(all, how.of_rates);
    constexpr double max_wrong = 0.03;  // a switch in the middle of 100 steps is wrong by 0.02, and its fields by less
    if (worst <= max_wrong) return std::nullopt;
    return text(
        "time.dt = {} does not resolve the time dependence of a term written as text: its integral over the steps is "
        "wrong by {:.2g} of its change, from t = {} on: choose time.dt = {:.3g}, or a slower variation",
        dt, std::min(worst, 1.0),
        io::in_unit("{:.6g}", static_cast<double>(windows[window].first) * dt, "s", scene.units), dt / 4.0);
}

bool depends_on_time(const io::Scene& scene, const model::Model& model) {
    return scene.time.dt > 0.0 && mentions(model, {"t"});
}

using Check = std::optional<std::string> (*)(const io::Scene& scene, const FieldProblem& problem);

/// The warning of a check; none where the smooth state lies outside the domain of a term: the run is another.
std::optional<std::string> warning_of(Check check, const io::Scene& scene, std::optional<FieldProblem>& problem) try {
    if (!problem) problem = field_problem(scene);
    return check(scene, *problem);
} catch (const Error& error) {
    if (error.fault() != Fault::run) throw;
    return std::nullopt;
}
}  // namespace

bool resolves_time(const io::Scene& scene, const model::Model& model) {
    std::optional<FieldProblem> problem;
    return !depends_on_time(scene, model) || !warning_of(&time_warning, scene, problem);
}

std::vector<std::string> text_resolution_warnings(const io::Scene& scene, const model::Model& model) {
    constexpr std::size_t max_points = std::size_t{512} * 512;
    const bool in_space = mentions(model, {"x", "y"}) && numerics::points(scene.grid) <= max_points;
    std::optional<FieldProblem> problem;
    std::vector<std::string> warnings;
    for (const auto& [check, is_needed] :
         {std::pair{&space_warning, in_space}, std::pair{&time_warning, depends_on_time(scene, model)}})
        if (is_needed)
            if (std::optional<std::string> warning = warning_of(check, scene, problem))
                warnings.push_back(std::move(*warning));
    return warnings;
}

}  // namespace drover::run
