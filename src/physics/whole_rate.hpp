// physics/whole_rate.hpp: the complete right-hand side of the equations, without splitting.
#pragma once
#include <utility>

#include "numerics/steppers/linear_operator.hpp"
#include "physics/integrated.hpp"

namespace drover::physics {

/// d_t a = L a + N(t, a): for implicit steppers, budgets and tests.  Independent of the reference, to rounding.
class WholeRate {
public:
    explicit WholeRate(numerics::System whole) : system(std::move(whole)), linear(system) {}
    WholeRate(const Equations& equations, const numerics::Grid& grid, const Densities& about, Threads& threads,
              const Dealiasing& dealiasing = {});

    numerics::Spectra operator()(double t, const numerics::Spectra& state) const;
    /// Writes the result to the kept modes of `rate`.
    void write(double t, const numerics::Spectra& state, numerics::Spectra& rate) const;

    numerics::System system;  ///< with its nonlinear part
    numerics::LinearOperator linear;
};

}  // namespace drover::physics
