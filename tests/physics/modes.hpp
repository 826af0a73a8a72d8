// tests/physics/modes.hpp: uniform states of a form and the modes of small waves on them, by component.
#pragma once
#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <vector>

#include "drover/numerics/field.hpp"
#include "numerics/algebra/dense.hpp"
#include "physics/rod_bead_model.hpp"
#include "symbols.hpp"

namespace drover::physics {

/// Component of a form at each place of a Symbol, -1 where it has none.
inline std::array<int, FieldIndex::count> components(const Form& form) {
    const auto second = [](int first) { return first < 0 ? -1 : first + 1; };
    return {form.bead_density,          form.rod_density, form.bead_velocity,
            second(form.bead_velocity), form.polar_order, second(form.polar_order)};
}

inline numerics::Spectra uniform_state(const Form& form, const numerics::Grid& grid, const UniformPoint& point) {
    numerics::Spectra state(grid, numerics::components(layout(form)));
    const std::array<double, FieldIndex::count> values{point.bead_density, point.rod_density, point.velocity.x(),
                                                       point.velocity.y(), point.order.x(),   point.order.y()};
    const auto at = components(form);
    for (std::size_t place = 0; place < FieldIndex::count; ++place)
        if (at[place] >= 0) state[at[place]][0] = values[place];
    return state;
}

/// The mean densities, the order along a direction [rad] in balance with its saturation and with the beads that it
/// drives:
/// b p0^2 = lambda alpha/Gamma - a, v0 = alpha p0/Gamma.
inline UniformPoint flock(const Equations& e, double direction) {
    const double rho = uniform_of(e.model).bead_density, sigma = uniform_of(e.model).rod_density;
    const double carried =
        physics::form(e.model).velocity == Velocity::absent
            ? 0.0
            : e.coefficient("driving.strength").at({rho, sigma}) / e.coefficient("drag.coefficient").at({rho, sigma});
    const double growth = e.coefficient("weathercock.strength").at({rho, sigma}) * carried -
                          e.coefficient("relaxation.rate").at({rho, sigma});
    const Eigen::Vector2d order = std::sqrt(growth / e.coefficient("relaxation.saturation").at({rho, sigma})) *
                                  Eigen::Vector2d(std::cos(direction), std::sin(direction));
    return {.bead_density = rho, .rod_density = sigma, .velocity = carried * order, .order = order};
}

/// d/dt of the components of a form, for small waves exp(i q.r) about a uniform state.
inline Eigen::MatrixXcd rate_matrix(const Equations& e, const UniformPoint& about, const numerics::Wavevector& q) {
    const Symbol symbol = linear_symbol(e, about, q);
    const auto at = components(physics::form(e.model));
    const int count = numerics::components(layout(physics::form(e.model)));
    Eigen::MatrixXcd matrix(count, count);
    for (int i = 0; i < FieldIndex::count; ++i)
        for (int j = 0; j < FieldIndex::count; ++j)
            if (at[static_cast<std::size_t>(i)] >= 0 && at[static_cast<std::size_t>(j)] >= 0)
                matrix(at[static_cast<std::size_t>(i)], at[static_cast<std::size_t>(j)]) = symbol(i, j);
    return matrix;
}

/// Modes of small waves, the slowest (least |rate|) first.
struct WaveModes {
    Eigen::VectorXcd rates;
    Eigen::MatrixXcd right;  ///< the modes, column by column, the largest component of each 1
    Eigen::MatrixXcd left;   ///< its inverse: row k gives the amplitude of mode k in any wave

    explicit WaveModes(const Eigen::MatrixXcd& matrix) : rates(matrix.rows()), right(matrix.rows(), matrix.cols()) {
        const numerics::DenseEigen solved = numerics::dense_eigen(matrix);
        std::vector<int> order(static_cast<std::size_t>(matrix.rows()));
        std::iota(order.begin(), order.end(), 0);
        std::sort(order.begin(), order.end(),
                  [&](int a, int b) { return std::abs(solved.values(a)) < std::abs(solved.values(b)); });
        for (int k = 0; k < matrix.rows(); ++k) {
            rates(k) = solved.values(order[static_cast<std::size_t>(k)]);
            right.col(k) = solved.vectors.col(order[static_cast<std::size_t>(k)]);
            Eigen::Index largest = 0;
            right.col(k).cwiseAbs().maxCoeff(&largest);
            right.col(k) /= right(largest, k);
        }
        left = numerics::inverse(right);
    }
    /// The mode whose rate is nearest to one given.
    int nearest(std::complex<double> rate) const {
        Eigen::Index at = 0;
        (rates.array() - rate).abs().minCoeff(&at);
        return static_cast<int>(at);
    }
    /// The mode that grows fastest.
    int fastest_growing() const {
        Eigen::Index at = 0;
        rates.real().maxCoeff(&at);
        return static_cast<int>(at);
    }
};

}  // namespace drover::physics
