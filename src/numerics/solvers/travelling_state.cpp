// numerics/solvers/travelling_state.cpp: travelling states, the curves that they form, and their stability.
#include "numerics/solvers/travelling_state.hpp"

#include <Eigen/SVD>

#include "drover/base/error.hpp"

namespace drover::numerics {

namespace {
constexpr double vanished = 1e-3;  // of the variation of a state: it is uniform

/// The distance of two states, in parts of the deviation of the second from its mean; fields count by their sizes.
double change_of(const Spectra& state, const Spectra& guess) {
    constexpr double rounding = 1e-20;  // of squares: what is left of a component that is 0
    double largest = 0.0;
    for (const Complex& value : guess.values) largest = std::max(largest, std::norm(value));
    double moved = 0.0, deviation = 0.0;
    for (int c = 0; c < guess.count(); ++c) {
        double difference = 0.0, variance = 0.0, mean = 0.0;
        for (std::size_t m = 0; m < guess.size; ++m) {
            difference += (m > 0 ? 2.0 : 1.0) * std::norm(state[c][m] - guess[c][m]);
            (m > 0 ? variance : mean) += (m > 0 ? 2.0 : 1.0) * std::norm(guess[c][m]);
        }
        if (variance + mean <= rounding * largest) continue;
        moved += difference / (variance + mean);
        deviation += variance / (variance + mean);
    }
    return std::sqrt(moved / deviation);
}

/// (a - b)/|a - b| and |a - b|.
struct Secant {
    std::vector<double> direction;
    double length = 0.0;
};
Secant secant(std::span<const double> a, std::span<const double> b, std::span<const double> weights) {
    Secant result{.direction = std::vector<double>(a.size())};
    for (std::size_t i = 0; i < a.size(); ++i) {
        result.direction[i] = a[i] - b[i];
        result.length += weights[i] * result.direction[i] * result.direction[i];
    }
    result.length = std::sqrt(result.length);
    for (double& value : result.direction) value /= result.length;
    return result;
}

/// Without the changes of sums of means that are conserved: those sums, which the rows of `means` determine, have no
/// rate at all but for `rounding`.
Eigen::MatrixXd without_sums(Eigen::MatrixXd matrix, const std::vector<Eigen::Index>& means, double rounding) {
    if (means.empty()) return matrix;
    const Eigen::JacobiSVD<Eigen::MatrixXd> rows(Eigen::MatrixXd(matrix(means, Eigen::all)), Eigen::ComputeFullU);
    const Eigen::MatrixXd before = matrix(means, Eigen::all);
    matrix(means, Eigen::all) = rows.matrixU().transpose() * before;
    const Eigen::MatrixXd across = matrix(Eigen::all, means);
    matrix(Eigen::all, means) = across * rows.matrixU();
    std::vector<Eigen::Index> kept;
    for (Eigen::Index i = 0; i < matrix.rows(); ++i) {
        const auto mean = std::ranges::find(means, i);
        if (mean == means.end() || rows.singularValues()(mean - means.begin()) > rounding) kept.push_back(i);
    }
    return matrix(kept, kept);
}
}  // namespace

TravellingState TravellingSolver::find(const Spectra& guess, std::optional<double> speed) {
    const std::size_t n = size();
    set_parameter(family_.parameter);
    Numbers u(n);
    modes_->pack(guess, u);
    choose_shift();
    set_sizes(u);
    find_conserved(u);
    columns_.assign(1, Numbers(n));
    rows_.assign(1, {});
    offsets_.assign(1, 0.0);
    fix_position(u);
    if (!speed) {
        Numbers rates(n);
        evaluate(u, rates);
        const Numbers along_x = slope(u), weights = metric();
        double along = 0.0, squares = 0.0;
        for (std::size_t i = 0; i < n; ++i) {
            along += weights[i] * along_x[i] * rates[i];
            squares += weights[i] * along_x[i] * along_x[i];
        }
        speed = -along / squares;
    }
    u.push_back(*speed);
    const double at_start = variation(Values(u).first(n));
    TravellingState found = solve(std::move(u));
    found.guessed_speed = *speed;
    found.change = change_of(found.state, guess);
    Numbers values(n);
    modes_->pack(found.state, values);
    if (variation(values) < vanished * at_start)
        fail_run("Newton's method ended in a uniform state; expected a wave: give a guess nearer to one, or settle it");
    return found;
}

/// The unknowns of a point of a curve of solutions.
TravellingSolver::Numbers TravellingSolver::numbers_of(const TravellingState& at) const {
    Numbers u(size());
    modes_->pack(at.state, u);
    u.push_back(at.speed);
    u.push_back(at.parameter);
    return u;
}

std::vector<TravellingState> TravellingSolver::follow(const TravellingState& first, double last, int max_points) {
    const std::size_t n = size();
    const double begin = first.parameter, range = last - begin,
                 speed_size = std::max(std::abs(first.speed), smallest_speed());
    parameter_range_ = std::abs(range);
    Numbers weights = metric();
    weights.push_back(1.0 / (speed_size * speed_size));
    weights.push_back(1.0 / (range * range));
    // A first step at a given value of the parameter, then along the secant.
    constexpr double first_step = 0.01, largest_step = 0.2, smallest_step = 1e-6;
    constexpr double largest_bend = 0.5;  // tangent of the angle between steps: farther off are other curves
    Numbers before = numbers_of(first), near = before;
    near[n + 1] += first_step * range;
    const double at_start = variation(Values(before).first(n));
    std::vector<TravellingState> points{first, solve_near(near, nullptr, weights)};
    double step = 0.0;
    while (static_cast<int>(points.size()) < max_points) {
        const Numbers here = numbers_of(points.back());
        const Secant along = secant(here, before, weights);
        if (step == 0.0) step = 2.0 * along.length;
        for (std::size_t i = 0; i < near.size(); ++i) near[i] = here[i] + step * along.direction[i];
        std::optional<TravellingState> found;
        try {
            found = solve_near(near, &along.direction, weights);
        } catch (const Error& error) {
            if (error.fault() == Fault::input) break;  // beyond, there are no equations
            if (error.fault() != Fault::run) throw;
        }
        const bool is_next = found && variation(numbers_of(*found)) >= vanished * at_start &&
                             secant(numbers_of(*found), near, weights).length <= largest_bend * step;
        if (!is_next) {
            step *= 0.5;
            if (step < smallest_step) break;  // the curve ends
            continue;
        }
        points.push_back(std::move(*found));
        before = here;
        constexpr int few_iterations = 5;
        if (points.back().iterations <= few_iterations) step = std::min(1.5 * step, largest_step);
        const double covered = (points.back().parameter - begin) / range;
        if (covered > 1.0 || covered < 0.0) break;
    }
    return points;
}

std::vector<std::complex<double>> TravellingSolver::perturbation_rates(const TravellingState& at, std::size_t count) {
    const std::size_t n = size();
    if (n > max_dense) return {};
    set_parameter(at.parameter);
    Numbers a(n), unit(n, 0.0), column(n);
    modes_->pack(at.state, a);
    std::vector<std::size_t> free;
    for (std::size_t i = 0; i < n; ++i)
        if (std::ranges::find(conserved_, i) == conserved_.end()) free.push_back(i);
    Eigen::MatrixXd matrix(static_cast<Eigen::Index>(free.size()), static_cast<Eigen::Index>(free.size()));
    std::vector<Eigen::Index> means;
    for (std::size_t k = 0; k < free.size(); ++k) {
        if (free[k] % per_component_ == 0) means.push_back(static_cast<Eigen::Index>(k));
        unit[free[k]] = 1.0;
        derive(a, at.speed, unit, column);
        unit[free[k]] = 0.0;
        for (std::size_t i = 0; i < free.size(); ++i)
            matrix(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(k)) =
                column[free[i]] * sizes_[free[k]] / sizes_[free[i]];
    }
    constexpr double of_differences = 1e-9;
    const Eigen::VectorXcd values = dense_eigenvalues(without_sums(std::move(matrix), means, of_differences * shift_));
    std::vector<std::complex<double>> rates(values.begin(), values.end());
    const double rounding = 1e-12 * values.cwiseAbs().maxCoeff();
    const auto cleared = [&](double part) { return std::abs(part) <= rounding ? 0.0 : part; };
    for (std::complex<double>& rate_ : rates) rate_ = {cleared(rate_.real()), cleared(rate_.imag())};
    std::ranges::sort(rates, [](const auto& x, const auto& y) {
        return x.real() != y.real() ? x.real() > y.real() : x.imag() > y.imag();
    });
    if (rates.size() > count) rates.resize(count);
    return rates;
}

}  // namespace drover::numerics
