// physics/model.hpp: a model as a scene gives it: its fields, its mean densities and the numbers of its terms.
#pragma once
#include <map>
#include <string>
#include <vector>

#include "drover/physics/coefficients.hpp"
#include "drover/physics/form.hpp"
#include "drover/physics/text_term.hpp"

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
    std::vector<TextTerm> text_terms;          ///< terms that the scene writes as text
    std::map<std::string, double> parameters;  ///< numbers of these, by name
};

Form form(const Model& model);

}  // namespace drover::physics

namespace drover {
template <>
const std::vector<Row<physics::UniformState>>& schema<physics::UniformState>();
}  // namespace drover
