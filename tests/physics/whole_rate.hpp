// tests/physics/whole_rate.hpp: the linear part and the complete right-hand side of a model of a model file.
#pragma once
#include "drover/numerics/system.hpp"
#include "numerics/steppers/linear_operator.hpp"
#include "physics/integrated.hpp"

namespace drover::physics {

/// L and Q of a model about a reference, and the degree of its products.  N is empty.
inline numerics::System linear_system(const Equations& equations, const numerics::Grid& grid, const Densities& about) {
    return equations.solver(about).linear_system(grid, kept_degree(equations, {}));
}
/// The same about the uniform densities of a model.
inline numerics::System linear_system(const ModelValues& model, const numerics::Grid& grid) {
    return linear_system(Equations(model), grid, mean_densities(model));
}

inline numerics::WholeRate whole_rate(const Equations& equations, const numerics::Grid& grid, const Densities& about,
                                      Threads& threads, const numerics::Dealiasing& dealiasing = {}) {
    return numerics::WholeRate(model::system_of(integrated(equations, about, dealiasing), grid, threads));
}

}  // namespace drover::physics
