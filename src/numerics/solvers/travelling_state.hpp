// numerics/solvers/travelling_state.hpp: states that travel along x without change of shape, or stand, stable or not.
#pragma once
#include <complex>
#include <memory>
#include <optional>
#include <vector>

#include "drover/base/threads.hpp"
#include "numerics/solvers/travelling_family.hpp"

namespace drover::numerics {

struct TravellingEquations;

/// Newton's method with the position of the state fixed; GMRES is preconditioned by the blocks of L.
class TravellingSolver {
public:
    /// Throws an input Error for more than one row of points.
    TravellingSolver(TravellingFamily family, Threads& threads);
    ~TravellingSolver();
    TravellingSolver(TravellingSolver&&) noexcept;

    /// speed: its guess; nothing: that with which the guess comes nearest to a solution.  Throws a run Error where
    /// Newton's method does not converge, and an input Error for a guess that does not depend on x.
    TravellingState find(const Spectra& guess, std::optional<double> speed = std::nullopt);

    /// The states along the curve of solutions through `first`, by pseudo-arclength: past folds, until the parameter
    /// leaves the range from its value at `first` to `last`, or the curve ends (in a uniform state), or there are
    /// `max_points`.
    std::vector<TravellingState> follow(const TravellingState& first, double last, int max_points);

    /// Rates of the perturbations of a state that depend on x alone, with its conserved means, fastest growth first: at
    /// most `count`.  One is zero: a translation.  By the eigenvalues of the matrix; empty beyond max_dense numbers.
    std::vector<std::complex<double>> perturbation_rates(const TravellingState& at, std::size_t count);
    static constexpr std::size_t max_dense = 1600;

    std::size_t unknowns() const;
    std::int64_t right_hand_sides() const;  ///< so far

private:
    std::unique_ptr<TravellingEquations> work_;
};

}  // namespace drover::numerics
