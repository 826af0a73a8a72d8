// numerics/solvers/travelling_state.hpp: states that travel along x without change of shape, or stand, stable or not.
#pragma once
#include <algorithm>
#include <cmath>
#include <complex>
#include <functional>
#include <optional>
#include <span>
#include <vector>

#include "numerics/algebra/dense.hpp"
#include "numerics/steppers/linear_operator.hpp"
#include "numerics/steppers/mode_vector.hpp"

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
    double guessed_speed = 0.0;
    double change = 0.0;  ///< of the fields from their guess, in parts of the variation of the guess
};

/// Newton's method (KINSOL) with the position of the state fixed; GMRES is preconditioned by the blocks of L.
class TravellingSolver {
public:
    /// Throws an input Error for more than one row of points.
    explicit TravellingSolver(TravellingFamily family);

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

    std::size_t unknowns() const { return size() + 1; }
    std::int64_t right_hand_sides() const { return evaluations_; }  ///< so far

private:
    using Numbers = std::vector<double>;
    using Values = std::span<const double>;
    struct Newton;

    std::size_t size() const { return modes_->size(); }
    void set_parameter(double value);
    void evaluate(Values a, std::span<double> f);
    Numbers slope(Values a) const;
    void find_conserved(Values a);
    void set_sizes(Values a);
    void choose_shift();
    double mass(std::size_t i) const;
    void fill_equations(Values a, double speed, std::span<double> f);
    void derive(Values a, double speed, Values v, std::span<double> result);
    void invert_blocks(double speed);
    void prepare(Values a, double speed);
    void solve_blocks(std::span<double> v) const;
    void precondition(std::span<double> v) const;
    TravellingState solve(Numbers u);
    void fix_position(Values a);
    double variation(Values a) const;
    double parameter_size() const { return std::max(std::abs(parameter_), parameter_range_); }
    double smallest_speed() const;  ///< that counts as one [mm/s]
    /// The solution at the parameter of `near` or, with a direction, that on the plane through `near` across it.
    TravellingState solve_near(const Numbers& near, const Numbers* direction, Values weights);
    Numbers equation_sizes(double speed) const;
    Numbers metric() const;
    Numbers parameter_column(Values a);
    Numbers numbers_of(const TravellingState& at) const;

    TravellingFamily family_;
    Grid grid_;
    std::optional<WholeRate> whole_;  ///< at the parameter
    double parameter_ = 0.0, parameter_range_ = 0.0;
    std::optional<ModeVector> modes_;
    std::size_t per_component_ = 0;       // numbers of a component
    std::vector<std::size_t> conserved_;  // numbers: the means of conserved densities
    Numbers masses_;                      // their values, less the means that the family prescribes
    double shift_ = 1.0;                  // of the preconditioner [1/s]
    Numbers sizes_;                       // root mean squares of the field of each number
    Spectra scratch_, rate_;
    std::int64_t evaluations_ = 0;
    std::vector<Eigen::MatrixXcd> inverses_;  // of each mode
    // Unknowns beside the modes (the speed, the parameter) and as many equations: their columns and rows.
    std::vector<Numbers> columns_, rows_;
    Numbers offsets_;  // of the rows
    std::vector<Numbers> preconditioned_columns_;
    Eigen::MatrixXd schur_;
};

}  // namespace drover::numerics
