// physics/integrated.hpp: the equations of a model file as a run integrates them.
#pragma once
#include "model/field_evolution.hpp"
#include "physics/linear_theory.hpp"

namespace drover::physics {

/// With the linear part about a reference.  Evaluations throw a model::DomainFailure where the equations divide by a
/// density or a drag that is not positive, or a density leaves the table of a coefficient.
model::Integrated integrated(const Equations& equations, const Densities& about, const Dealiasing& dealiasing = {});
/// The same about the uniform densities of a model.
model::Integrated integrated(const ModelValues& model, const Dealiasing& dealiasing = {});

}  // namespace drover::physics
