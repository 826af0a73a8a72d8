// physics/model.hpp: a model: its uniform state and its terms, and the System that it hands to a stepper.
#pragma once
#include <string>
#include <vector>

#include "drover/physics/terms.hpp"

namespace drover::physics {

/// The uniform state about which a model stands.
struct UniformState {
    double rod_density = 1.0;  ///< mean sigma [1/mm^2] > 0
};

/// Rods alone, linear about the isotropic state.
struct Model {
    UniformState uniform;
    RodCurrent current;
    Relaxation relaxation;
    Elasticity elasticity;
    RodPressure pressure;
    RodDiffusion diffusion;
    Noise noise;
};

Form form(const Model& model);

/// L, N and Q of the model; terms whose coefficients are zero have no part in it.
numerics::System make_system(const Model& model, const numerics::Grid& grid);

/// A term that has a part in a model, for people.
struct ActiveTerm {
    std::string name;      ///< its table in the scene
    std::string equation;  ///< "d_t p = ... - 0.5 p"
};
std::vector<ActiveTerm> active_terms(const Model& model);

/// The largest growth rate of the linear model over the modes of a grid [1/s], conserved means left out, and the |q| where it
/// is [1/mm].
struct FastestGrowth {
    double rate = 0.0, q = 0.0;
};
FastestGrowth fastest_growth(const numerics::System& system);

/// The largest |s| of the linear model over the kept modes [1/s]: what dt is held against.
double fastest_rate(const numerics::System& system);

/// Stationary structure factors of the linear model at |q| [1/mm], in 1/mm^2.  Source: m S + S m^T + Q = 0 for each block.
struct StructureFactor {
    double rods = 0.0;          ///< of sigma
    double order_along = 0.0;   ///< of the part of p along q
    double order_across = 0.0;  ///< of the part of p across q
};
StructureFactor structure_factor(const numerics::System& system, const Form& form, double q);

/// The same for each stored mode of the system's grid; zero at q = 0 and where a mode is not kept.  Throws a run Error where
/// a mode grows.
std::vector<StructureFactor> structure_factors(const numerics::System& system, const Form& form);

}  // namespace drover::physics

namespace drover {
template <>
const std::vector<Row<physics::UniformState>>& schema<physics::UniformState>();
}  // namespace drover
