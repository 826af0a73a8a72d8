// physics/binodal.hpp: densities of two phases that coexist in a travelling or standing state.
#pragma once
#include "drover/physics/travelling_problem.hpp"

namespace drover::physics {

/// Two phases side by side, at the densities that they choose.
struct Coexistence {
    double parameter = 0.0;
    double low = 0.0, high = 0.0;              ///< of the density in question [1/mm^2]
    double other_low = 0.0, other_high = 0.0;  ///< of the other density, in the same phases; 0: not a field
    double speed = 0.0;                        ///< [mm/s]
};

struct Binodal {
    std::vector<Coexistence> points;  ///< in the order of the parameter; the first is that of the first state
    std::string ends;                 ///< why it ends before the last parameter; "": it does not
};

/// The phases of a state; nothing where a density has no plateaus.  `component`: of the density in question.
std::optional<Coexistence> phases_of(const TravellingProblem& problem, const TravellingState& state, int component,
                                     Threads& threads);

/// The phases that coexist as the parameter goes from that of `first` to `last` in `steps` or shorter steps.  The mean
/// density moves with them, so that both phases keep their part of the cell.  Throws a run Error where the first state
/// has no two phases, and what problem.model throws.
Binodal trace_binodal(const TravellingProblem& problem, const TravellingState& first, int component, double last,
                      int steps, Threads& threads);

}  // namespace drover::physics
