// physics/model.hpp: a model as a scene says it, and the same made ready: fields placed, coefficients compiled, terms chosen.
#pragma once
#include <Eigen/Core>
#include <array>
#include <string>
#include <utility>
#include <vector>

#include "drover/physics/coefficient.hpp"
#include "drover/physics/form.hpp"
#include "drover/physics/terms.hpp"

namespace drover::physics {

/// The mean densities of a scene, which the equations conserve.
struct UniformState {
    double rod_density = 1.0;   ///< mean sigma [1/mm^2] > 0
    double bead_density = 1.0;  ///< mean rho [1/mm^2] > 0
    double rod_area = 0.0;      ///< of one rod, projected [mm^2]; 0: not known
    double bead_area = 0.0;     ///< of one bead, projected [mm^2]; 0: not known
};

struct Model {
    FieldChoice fields;
    UniformState uniform;
    RodCurrent current;
    Inertia inertia;
    Drag drag;
    Viscosity viscosity;
    Driving driving;
    Stiffness stiffness;
    Relaxation relaxation;
    Elasticity elasticity;
    Weathercock weathercock;
    SelfAdvection advection;
    Pressure pressure;
    Diffusion diffusion;
    Noise noise;
    BodyForce force;
    OrientingField orienting_field;
    TableData table;
};

Form form(const Model& model);

/// Throws an input Error, at its place, for coefficients that cannot be: of fields that the model does not have, a polynomial that
/// is none, a table that does not fit, a velocity that nothing holds back.
void check(const Model& model, const LocationOf& place = no_location);

struct Term;

/// The coefficients that may depend on the densities.
struct Coefficients {
    Coefficient relaxation, saturation, drag, driving, weathercock;
};

/// Each with its key in the scene.
inline std::array<std::pair<const char*, const Coefficient*>, 5> named(const Coefficients& c) {
    return {{{"relaxation.rate", &c.relaxation},
             {"relaxation.saturation", &c.saturation},
             {"drag.coefficient", &c.drag},
             {"driving.strength", &c.driving},
             {"weathercock.strength", &c.weathercock}}};
}

/// A model made ready for use.
struct Equations : Coefficients {
    explicit Equations(const Model& model);  ///< throws as check()
    /// The same, sharing the tables that `like` has made of the same numbers: for many models that differ in little.
    Equations(const Model& model, const Equations& like);

    Model model;
    Form form;
    std::vector<const Term*> active;  ///< those with a part in the model

private:
    Equations(const Model& model, const Coefficients& coefficients);
};

/// The uniform state about which the exact linear part is taken: its densities, the beads at rest, no order.
struct Reference {
    double bead_density = 1.0, rod_density = 1.0;
};
inline Reference reference(const UniformState& uniform) {
    return {.bead_density = uniform.bead_density, .rod_density = uniform.rod_density};
}

/// A uniform state.
struct UniformPoint {
    double bead_density = 1.0, rod_density = 1.0;
    Eigen::Vector2d velocity = Eigen::Vector2d::Zero(), order = Eigen::Vector2d::Zero();
};

/// A term that has a part in a model, for people.
struct ActiveTerm {
    std::string name;      ///< its table in the scene
    std::string equation;  ///< "d_t p: -a p, a = 0.5 1/s"
};
std::vector<ActiveTerm> active_terms(const Equations& equations);

}  // namespace drover::physics

namespace drover {
template <>
const std::vector<Row<physics::UniformState>>& schema<physics::UniformState>();
}  // namespace drover
