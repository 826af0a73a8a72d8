// numerics/solvers/travelling_equations.hpp: the equations of a travelling state, for Newton's method.
#pragma once
#include <cmath>
#include <numeric>
#include <optional>
#include <vector>

#include "drover/base/threads.hpp"
#include "numerics/algebra/dense.hpp"
#include "numerics/solvers/newton_krylov.hpp"
#include "numerics/solvers/travelling_family.hpp"
#include "numerics/steppers/linear_operator.hpp"
#include "numerics/steppers/mode_vector.hpp"

namespace drover::numerics {

namespace travelling {
using Numbers = std::vector<double>;
using Values = std::span<const double>;

inline double product(Values a, Values b) { return std::inner_product(a.begin(), a.end(), b.begin(), 0.0); }

}  // namespace travelling

/// The state of a TravellingSolver.
struct TravellingEquations {
    using Matrix = SmallSquare<Complex>;
    using RealMatrix = SmallSquare<double>;
    using Numbers = travelling::Numbers;
    using Values = travelling::Values;
    TravellingFamily family;
    Grid grid;
    Threads& threads;
    std::optional<WholeRate> whole;  ///< at the parameter
    double parameter = 0.0;
    std::optional<ModeVector> modes;
    std::size_t per_component = 0;       // numbers of a component
    std::vector<std::size_t> conserved;  // numbers: the means of conserved densities
    Numbers masses;                      // their values, less the means that the family prescribes
    double shift = 1.0;                  // of the preconditioner [1/s]
    Numbers sizes;                       // root mean squares of the field of each number
    Spectra scratch, rate;
    std::int64_t evaluations = 0;
    std::vector<Matrix> inverses;  // of each mode
    // Unknowns beside the modes (the speed, the parameter) and as many equations: their columns and rows.
    std::vector<Numbers> columns, rows;
    Numbers offsets;  // of the rows
    std::vector<Numbers> preconditioned_columns;
    RealMatrix schur;

    TravellingEquations(TravellingFamily the_family, Threads& the_threads);
    std::size_t size() const { return modes->size(); }
    void set_parameter(double value);
    void evaluate(Values a, std::span<double> f);
    Numbers slope(Values a) const;
    void find_conserved(Values a);
    void set_sizes(Values a);
    void choose_shift();
    double mass(std::size_t i) const;
    void fill_equations(Values a, double speed, std::span<double> f);
    void derive(Values a, double speed, Values v, std::span<double> result);
    void prepare(Values a, double speed);
    void solve_blocks(std::span<double> v) const;
    void precondition(std::span<double> v) const;
    TravellingState solve(Numbers u);
    void fix_position(Values a);
    double variation(Values a) const;
    double smallest_speed() const;  ///< that counts as one [mm/s]
    /// The solution at the parameter of `near` or, with a direction, that on the plane through `near` across it.
    TravellingState solve_near(const Numbers& near, const Numbers* direction, Values weights);
    void set_equation_sizes(double speed, NonlinearEquations& e) const;
    Numbers metric() const;
    Numbers parameter_column(Values a);
    NonlinearEquations equations();
};

}  // namespace drover::numerics
