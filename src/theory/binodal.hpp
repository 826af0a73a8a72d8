// theory/binodal.hpp: densities of two phases that coexist in a travelling or standing state.
#pragma once
#include <cstddef>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "model/field_evolution.hpp"
#include "numerics/solvers/travelling_state.hpp"

namespace drover::theory {

/// A family of models on one line of points (grid.ny = 1); their noise is left out.
struct TravellingProblem {
    std::function<model::Integrated(double parameter)> at;  ///< what is integrated at a value of the parameter
    double parameter = 0.0;                                 ///< of the state that is looked for
    numerics::Grid grid;
    /// The largest part of the variance of a component of a state in the shortest waves of the grid; none: not asked.
    std::function<double(const numerics::TravellingState&)> tail = {};
};

/// The tail beyond which digits of a state mean nothing: waves of a thousandth of it.
inline constexpr double max_state_tail = 1e-6;

/// What is integrated at the last value of the parameter is kept.  Its systems throw an input Error for a term that
/// depends on position or time.
numerics::TravellingFamily travelling_family(const TravellingProblem& problem, Threads& threads);

/// Two phases side by side, at the densities that they choose.
struct Coexistence {
    double parameter = 0.0;
    double low = 0.0, high = 0.0;         ///< of the density in question
    std::vector<double> in_low, in_high;  ///< of each component of the state, in the same phases
    double speed = 0.0;
};

struct Binodal {
    std::vector<Coexistence> points;  ///< in the order of the parameter; the first is that of the first state
    std::string ends;                 ///< why it ends before the last parameter; "": it does not
    double tail = 0.0;                ///< the largest of the states
};

/// The phases that coexist as the parameter goes from that of `first` to `last` in `steps` or shorter steps.  The mean
/// density moves with them, so that both phases keep their part of the cell; the means of other conserved scalars
/// follow their references.  Throws a run Error where the first state has no two phases, and what problem.at throws.
Binodal trace_binodal(const TravellingProblem& problem, const numerics::TravellingState& first, int component,
                      double last, int steps, Threads& threads);

/// A density of a state between its extremes: two plateaus of coexisting phases, or a single wave.
struct DensityProfile {
    double low = 0.0, high = 0.0;                    ///< at the flattest points below and above the middle
    bool low_is_flat = false, high_is_flat = false;  ///< plateaus: both are phases that coexist
    std::size_t low_at = 0, high_at = 0;             ///< these points
    double width = 0.0;                              ///< of the part above the middle [mm]; 0: uniform to rounding
};

/// `density`: on the points of a line of length lx.
DensityProfile density_profile(std::span<const double> density, double lx);

}  // namespace drover::theory
