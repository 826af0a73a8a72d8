// numerics/steppers/linear_operator.hpp: the linear part of a System applied to a state, and its whole rate.
#pragma once
#include <utility>
#include <vector>

#include "drover/numerics/system.hpp"
#include "numerics/fields/shells.hpp"

namespace drover::numerics {

/// L of a system; its blocks are computed once, at construction.
class LinearOperator {
public:
    explicit LinearOperator(const System& system);

    /// rate += L state, on the kept modes.
    void add(const Spectra& state, Spectra& rate) const;

    /// (1 - gamma L)^-1; not finite where a mode grows at the rate 1/gamma.
    LinearOperator shifted_inverse(double gamma) const;

private:
    Grid grid_;
    Layout layout_;
    DistinctWavenumbers wavenumbers_;
    std::vector<double> matrices_;  // for each |q|: the entries of the even block, then of the odd one
};

/// d_t a = L a + N(t, a): for implicit steppers, budgets and travelling states.  Independent of the reference, to
/// rounding.
class WholeRate {
public:
    explicit WholeRate(System whole) : system(std::move(whole)), linear(system) {}

    Spectra operator()(double t, const Spectra& state) const;
    /// Writes the result to the kept modes of `rate`.
    void write(double t, const Spectra& state, Spectra& rate) const;

    System system;  ///< with its nonlinear part
    LinearOperator linear;
};

}  // namespace drover::numerics
