// numerics/solvers/travelling_state.cpp: travelling states, the curves that they form, and their stability.
#include "numerics/solvers/travelling_state.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "drover/base/error.hpp"
#include "numerics/algebra/dense.hpp"
#include "numerics/solvers/travelling_equations.hpp"

namespace drover::numerics {

using travelling::Numbers;
using travelling::product;
using travelling::Values;

namespace {
constexpr double vanished = 1e-3;  // of the variation of a state: it is uniform

/// The distance of two states, in parts of the deviation of the second from its mean; fields count by their sizes.
double change_of(const Spectra& state, const Spectra& guess) {
    double moved = 0.0, deviation = 0.0;
    for (int c = 0; c < guess.count(); ++c) {
        double difference = 0.0, variance = 0.0, mean = 0.0;
        for (std::size_t m = 0; m < guess.size; ++m) {
            difference += (m > 0 ? 2.0 : 1.0) * std::norm(state[c][m] - guess[c][m]);
            (m > 0 ? variance : mean) += (m > 0 ? 2.0 : 1.0) * std::norm(guess[c][m]);
        }
        if (variance + mean == 0.0) continue;
        moved += difference / (variance + mean);
        deviation += variance / (variance + mean);
    }
    return std::sqrt(moved / deviation);
}
}  // namespace

TravellingSolver::TravellingSolver(TravellingFamily family, Threads& threads)
    : work_(std::make_unique<TravellingEquations>(std::move(family), threads)) {}
TravellingSolver::~TravellingSolver() = default;
TravellingSolver::TravellingSolver(TravellingSolver&&) noexcept = default;

std::size_t TravellingSolver::unknowns() const { return work_->size() + 1; }
std::int64_t TravellingSolver::right_hand_sides() const { return work_->evaluations; }

TravellingState TravellingSolver::find(const Spectra& guess, std::optional<double> speed) {
    TravellingEquations& w = *work_;
    const std::size_t n = w.size();
    w.set_parameter(w.family.parameter);
    Numbers u(n);
    w.modes->pack(guess, u);
    w.choose_shift();
    w.set_sizes(u);
    w.find_conserved(u);
    w.columns.assign(1, Numbers(n));
    w.rows.assign(1, {});
    w.offsets.assign(1, 0.0);
    w.fix_position(u);
    if (!speed) {
        Numbers rates(n);
        w.evaluate(u, rates);
        const Numbers slope = w.slope(u), weights = w.metric();
        double along = 0.0, squares = 0.0;
        for (std::size_t i = 0; i < n; ++i) {
            along += weights[i] * slope[i] * rates[i];
            squares += weights[i] * slope[i] * slope[i];
        }
        speed = -along / squares;
    }
    u.push_back(*speed);
    const double variation = w.variation(Values(u).first(n));
    TravellingState found = w.solve(std::move(u));
    found.guessed_speed = *speed;
    found.change = change_of(found.state, guess);
    Numbers values(n);
    w.modes->pack(found.state, values);
    if (w.variation(values) < vanished * variation)
        fail_run("Newton's method ended in a uniform state; expected a wave: give a guess nearer to one, or settle it");
    return found;
}

namespace {
/// The unknowns of a point of a curve of solutions.
Numbers numbers_of(const ModeVector& modes, const TravellingState& at) {
    Numbers u(modes.size());
    modes.pack(at.state, u);
    u.push_back(at.speed);
    u.push_back(at.parameter);
    return u;
}

/// (a - b)/|a - b| and |a - b|.
struct Secant {
    Numbers direction;
    double length = 0.0;
};
Secant secant(Values a, Values b, Values weights) {
    Secant result{.direction = Numbers(a.size())};
    for (std::size_t i = 0; i < a.size(); ++i) {
        result.direction[i] = a[i] - b[i];
        result.length += weights[i] * result.direction[i] * result.direction[i];
    }
    result.length = std::sqrt(result.length);
    for (double& value : result.direction) value /= result.length;
    return result;
}
}  // namespace

std::vector<TravellingState> TravellingSolver::follow(const TravellingState& first, double last, int max_points) {
    TravellingEquations& w = *work_;
    const std::size_t n = w.size();
    const double begin = first.parameter, range = last - begin,
                 speed_size = std::max(std::abs(first.speed), w.smallest_speed());
    Numbers weights = w.metric();
    weights.push_back(1.0 / (speed_size * speed_size));
    weights.push_back(1.0 / (range * range));
    // A first step at a given value of the parameter, then along the secant.
    constexpr double first_step = 0.01, largest_step = 0.2, smallest_step = 1e-6;
    Numbers before = numbers_of(*w.modes, first), near = before;
    near[n + 1] += first_step * range;
    const double variation = w.variation(Values(before).first(n));
    std::vector<TravellingState> points{first, w.solve_near(near, nullptr, weights)};
    double step = 0.0;
    while (static_cast<int>(points.size()) < max_points) {
        const Numbers here = numbers_of(*w.modes, points.back());
        const Secant along = secant(here, before, weights);
        if (step == 0.0) step = 2.0 * along.length;
        for (std::size_t i = 0; i < near.size(); ++i) near[i] = here[i] + step * along.direction[i];
        try {
            points.push_back(w.solve_near(near, &along.direction, weights));
        } catch (const Error& error) {
            if (!is_of_scene(error.fault())) throw;
            step *= 0.5;
            if (error.fault() != Fault::run || step < smallest_step) break;  // the curve ends
            continue;
        }
        if (w.variation(numbers_of(*w.modes, points.back())) < vanished * variation) {
            points.pop_back();  // the curve ends in a uniform state
            break;
        }
        before = here;
        constexpr int few_iterations = 5;
        if (points.back().iterations <= few_iterations) step = std::min(1.5 * step, largest_step);
        const double covered = (points.back().parameter - begin) / range;
        if (covered > 1.0 || covered < 0.0) break;
    }
    return points;
}

std::vector<std::complex<double>> TravellingSolver::perturbation_rates(const TravellingState& at, std::size_t count) {
    TravellingEquations& w = *work_;
    const std::size_t n = w.size();
    if (n > max_dense) return {};
    w.set_parameter(at.parameter);
    Numbers a(n), unit(n, 0.0), column(n);
    w.modes->pack(at.state, a);
    std::vector<std::size_t> free;
    for (std::size_t i = 0; i < n; ++i)
        if (std::find(w.conserved.begin(), w.conserved.end(), i) == w.conserved.end()) free.push_back(i);
    Eigen::MatrixXd matrix(static_cast<Eigen::Index>(free.size()), static_cast<Eigen::Index>(free.size()));
    for (std::size_t k = 0; k < free.size(); ++k) {
        unit[free[k]] = 1.0;
        w.derive(a, at.speed, unit, column);
        unit[free[k]] = 0.0;
        for (std::size_t i = 0; i < free.size(); ++i)
            matrix(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(k)) = column[free[i]];
    }
    const Eigen::VectorXcd values = dense_eigenvalues(matrix);
    std::vector<std::complex<double>> rates(values.begin(), values.end());
    const double rounding = 1e-12 * values.cwiseAbs().maxCoeff();
    const auto cleared = [&](double part) { return std::abs(part) <= rounding ? 0.0 : part; };
    for (std::complex<double>& rate : rates) rate = {cleared(rate.real()), cleared(rate.imag())};
    std::sort(rates.begin(), rates.end(), [](const auto& x, const auto& y) {
        return x.real() != y.real() ? x.real() > y.real() : x.imag() > y.imag();
    });
    if (rates.size() > count) rates.resize(count);
    return rates;
}

}  // namespace drover::numerics
