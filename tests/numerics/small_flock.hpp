// tests/numerics/small_flock.hpp: a nonlinear system for tests of time steppers.
#pragma once
#include <cmath>
#include <numbers>

#include "drover/numerics/transform.hpp"

namespace drover::numerics {

// A small flock: sigma and p on 16 x 16 points, order that grows (a = -1) and saturates, currents u sigma p and
// self-advection, a force that varies in time.
inline constexpr Grid small_grid{16, 16, 6.0, 6.0};

/// Covariance rate of noise of this strength on the order, for a system of one scalar and one vector.
inline auto noise_on_order(double strength) {
    return [strength](double) {
        IsotropicBlocks q{Block(2), Block(1)};
        q.even(1, 1) = q.odd(0, 0) = strength;
        return q;
    };
}

inline System small_flock(const Transform& transform) {
    System system{.grid = small_grid,
                  .layout = scalars_and_vectors(1, 1),
                  .linear = {},
                  .nonlinear = {},
                  .noise = {},
                  .degree = 3};
    system.linear = [](double q) {
        IsotropicBlocks m{Block(2), Block(1)};
        m.even(0, 0) = -0.3 * q * q;
        m.even(0, 1) = -q;
        m.even(1, 0) = 0.5 * q;
        m.even(1, 1) = 1.0 - 1.2 * q * q;
        m.odd(0, 0) = 1.0 - 0.8 * q * q;
        return m;
    };
    system.nonlinear = [&transform](double t, const Spectra& state, Spectra& rate) {
        const std::size_t width = columns(small_grid);
        Fields fields(small_grid, 3), products(small_grid, 4);
        transform.backward(state, fields);
        for (std::size_t i = 0; i < fields.size; ++i) {
            const double sigma = fields[0][i] - 1.0, px = fields[1][i], py = fields[2][i], size = px * px + py * py;
            products[0][i] = 0.7 * sigma * px;
            products[1][i] = 0.7 * sigma * py;
            products[2][i] = -size * px + 0.2 * std::sin(3.0 * t) * sigma;
            products[3][i] = -size * py;
        }
        Spectra hat(small_grid, 4);
        transform.forward(products, hat);
        for (std::size_t m = 0; m < hat.size; ++m) {
            const Wavevector q = wavevector(small_grid, m % width, m / width);
            rate[0][m] = -Complex(0.0, 1.0) * (q.x * hat[0][m] + q.y * hat[1][m]);
            rate[1][m] = hat[2][m];
            rate[2][m] = hat[3][m];
        }
    };
    return system;
}

inline Spectra start(const Transform& transform) {
    Fields fields(small_grid, 3);
    for (int j = 0; j < 16; ++j)
        for (int i = 0; i < 16; ++i) {
            const double x = 2.0 * std::numbers::pi * i / 16.0, y = 2.0 * std::numbers::pi * j / 16.0;
            const auto place = static_cast<std::size_t>(16 * j + i);
            fields[0][place] = 1.0 + 0.3 * std::cos(x) * std::sin(y);
            fields[1][place] = 0.6 + 0.2 * std::sin(x + y);
            fields[2][place] = 0.3 * std::cos(y);
        }
    Spectra state(small_grid, 3);
    transform.forward(fields, state);
    return state;
}

inline double distance(const Spectra& a, const Spectra& b) {
    double squares = 0.0;
    for (std::size_t m = 0; m < a.values.size(); ++m) squares += std::norm(a.values[m] - b.values[m]);
    return std::sqrt(squares);
}

}  // namespace drover::numerics
