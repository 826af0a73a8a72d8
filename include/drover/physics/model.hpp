// physics/model.hpp: a model as given in a scene: its fields, mean densities and parameters.
#pragma once
#include <map>
#include <string>
#include <vector>

#include "drover/physics/coefficients.hpp"
#include "drover/physics/form.hpp"
#include "drover/physics/text_term.hpp"

namespace drover::physics {

/// The mean densities, which the equations conserve.
struct UniformState {
    double rod_density = 1.0;   ///< mean sigma [1/mm^2] > 0
    double bead_density = 1.0;  ///< mean rho [1/mm^2] > 0
    double rod_area = 0.0;      ///< projected area of one rod [mm^2]; 0: unknown
    double bead_area = 0.0;     ///< projected area of one bead [mm^2]; 0: unknown
    bool operator==(const UniformState&) const = default;
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
    Approximation approximation;
    TableData table;
    std::vector<TextTerm> text_terms;          ///< terms given as text in the scene
    std::map<std::string, double> parameters;  ///< parameters of the text terms, by name
};

Form form(const Model& model);

}  // namespace drover::physics

namespace drover {
template <>
const std::vector<Row<physics::UniformState>>& schema<physics::UniformState>();
}  // namespace drover
