// tests/theory/models.hpp: short models and their states, for tests of the linear theory.
#pragma once
#include <gtest/gtest.h>

#include <complex>
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

inline std::vector<std::string> names(const StationaryStates& found) {
    std::vector<std::string> result;
    for (const StationaryState& state : found.states) result.push_back(state.name);
    return result;
}

}  // namespace drover::theory
