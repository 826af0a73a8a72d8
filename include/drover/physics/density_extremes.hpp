// physics/density_extremes.hpp: the smallest and largest densities on the grid, and what they may not be.
#pragma once
#include <cstddef>
#include <limits>

#include "drover/model/field_evolution.hpp"
#include "drover/physics/compiled_model.hpp"

namespace drover::physics {

/// Smallest and largest densities; infinite for a field that the form does not have or that no term reads.
struct Extremes {
    double min_bead = std::numeric_limits<double>::infinity(), max_bead = -min_bead;
    double min_rod = std::numeric_limits<double>::infinity(), max_rod = -min_rod;
};

/// What a right-hand side divides by at points.
struct Divisors {
    bool by_bead_density = false, by_drag = false;
};

/// Throws a model::DomainFailure where the equations divide by a density or a drag that is not positive, or a density
/// leaves the table of a coefficient.  NaN is left to the health check, which locates it.
void check_extremes(const CompiledModel& model, const Extremes& extremes, const Divisors& divisors);

}  // namespace drover::physics
