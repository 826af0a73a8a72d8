// physics/linear_theory.hpp: the System of a model about the isotropic state, and predictions of its linear part.
#pragma once
#include <string>
#include <vector>

#include "drover/numerics/system.hpp"
#include "physics/equations.hpp"

namespace drover::physics {

/// Dealiasing of products.
struct Dealiasing {
    std::string rule = "exact";  ///< exact: |k| < N/(degree + 1); two-thirds: |k| < N/3; none: |k| < N/2
};

/// The degree of products that determines which modes are kept; 1 if every term is linear.
int kept_degree(const Equations& equations, const Dealiasing& dealiasing);

/// L and Q of a model about a reference, and the degree of its products.  N is empty.
numerics::System linear_system(const Equations& equations, const numerics::Grid& grid, const Densities& about,
                               const Dealiasing& dealiasing = {});
/// The same about the scene's uniform densities.
numerics::System linear_system(const ModelValues& model, const numerics::Grid& grid, const Dealiasing& dealiasing = {});

/// The first active term that depends on position or time, so that there is no uniform state; "" if there is none.
std::string nonuniform_term(const Equations& equations);

}  // namespace drover::physics

namespace drover {
template <>
const std::vector<Row<physics::Dealiasing>>& schema<physics::Dealiasing>();
}  // namespace drover
