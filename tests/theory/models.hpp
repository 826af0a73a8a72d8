// tests/theory/models.hpp: short models and their states, for tests of the linear theory.
#pragma once
#include <gtest/gtest.h>

#include <algorithm>
#include <complex>
#include <limits>
#include <numbers>
#include <string>
#include <vector>

#include "drover/theory/theory.hpp"

namespace drover::theory {

using numerics::Wavevector;
using std::numbers::pi;
using Complex = std::complex<double>;

inline model::Field scalar(const std::string& symbol, const std::string& equation) {
    return {.name = symbol + "_field", .symbol = symbol, .equation = {equation, {"test", 1, 1}}};
}
inline model::Field spin(int m, const std::string& symbol, const std::string& equation) {
    model::Field field = scalar(symbol, equation);
    field.spin = m;
    return field;
}

inline model::LinearisedAt about(const model::Model& model, std::size_t state = 0) {
    const model::Equations equations(model);
    const StationaryStates found = stationary_states(equations);
    EXPECT_LT(state, found.states.size()) << found.why_none;
    return {equations, found.states.at(state).values};
}

/// The largest error of a damping: the difference between s and its expansion over q^2, at the q where it is smallest;
/// at large q the next term of the series limits it, at small q rounding.
inline double damping_error(const model::LinearisedAt& at, double angle, const std::vector<SlowMode>& slow) {
    double smallest = std::numeric_limits<double>::infinity();
    for (double q = 1.0; q > 1e-6; q *= 0.2) {
        const Eigen::VectorXcd exact = mode_rates(at, at.wavevector(q, angle));
        double largest = 0.0;
        for (const SlowMode& mode : slow) {
            const Complex series = Complex(0.0, -q) * mode.speed - q * q * mode.damping;
            largest = std::max(largest, (exact.array() - series).abs().minCoeff() / (q * q));
        }
        smallest = std::min(smallest, largest);
    }
    return smallest;
}

inline std::vector<std::string> names(const StationaryStates& found) {
    std::vector<std::string> result;
    for (const StationaryState& state : found.states) result.push_back(state.name);
    return result;
}

}  // namespace drover::theory
