// numerics/travelling_state.hpp: states that travel along x without change of shape, or stand, stable or not.
#pragma once
#include <complex>
#include <functional>
#include <memory>
#include <optional>
#include <vector>

#include "drover/base/threads.hpp"
#include "drover/numerics/system.hpp"

namespace drover::numerics {

/// A family of systems without noise on one line of points (grid.ny = 1).
struct TravellingFamily {
    std::function<System(double parameter)> system;
    /// The mean of a component that the family prescribes, where it is conserved; it moves with the parameter.
    std::function<double(double parameter, int component)> mean;
    double parameter = 0.0;  ///< of the state that find() looks for
};

/// A solution of  speed d_x a + L a + N(a) = 0  with the conserved means of the guess.
struct TravellingState {
    Spectra state;
    double speed = 0.0;  ///< along x [length/time]
    double parameter = 0.0;
    double speed_error = 0.0;  ///< of rounding and of the residual
    double residual = 0.0;     ///< the largest rate of a mode, relative to the rates of the linear terms
    int iterations = 0;        ///< of Newton's method
};

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
    struct Work;
    std::unique_ptr<Work> work_;
};

}  // namespace drover::numerics
