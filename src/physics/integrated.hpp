// physics/integrated.hpp: the equations of a model file as a run integrates them.
#pragma once
#include <string>

#include "model/field_evolution.hpp"
#include "numerics/steppers/kept_modes.hpp"
#include "physics/equations.hpp"

namespace drover::physics {

/// The degree of products that determines which modes are kept; 1 if every term is linear.
int kept_degree(const Equations& equations, const numerics::Dealiasing& dealiasing);

/// The first active term that depends on position or time, so that there is no uniform state; "" if there is none.
std::string nonuniform_term(const Equations& equations);

/// With the linear part about a reference.  Evaluations throw a model::DomainFailure where the equations divide by a
/// density or a drag that is not positive, or a density leaves the table of a coefficient.
model::Integrated integrated(const Equations& equations, const Densities& about,
                             const numerics::Dealiasing& dealiasing = {});
/// The same about the uniform densities of a model.
model::Integrated integrated(const ModelValues& model, const numerics::Dealiasing& dealiasing = {});

}  // namespace drover::physics
