// physics/text_terms.hpp: the terms of a scene, as texts or functions, in the notation of the model layer.
#pragma once
#include <string>
#include <vector>

#include "drover/model/equations.hpp"
#include "physics/compiled_model.hpp"

namespace drover::physics {

struct SceneTerm {
    std::string field;     ///< symbol of the field in whose equation it is
    std::string equation;  ///< readable
    model::WrittenTerm written;
};

/// The terms of a model.  Throws an input Error at the place of one that its form cannot have.
std::vector<SceneTerm> scene_terms(const CompiledModel& model);

}  // namespace drover::physics
