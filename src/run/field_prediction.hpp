// run/field_prediction.hpp: structure factors of a run of fields by linear theory about its present state.
#pragma once
#include <functional>
#include <string>
#include <vector>

#include "drover/io/scene.hpp"
#include "drover/model/theory.hpp"

namespace drover::run {

/// The recorded values of a scalar observable; empty where there is none of this name.
using SeriesOf = std::function<std::vector<double>(const std::string& name)>;

/// The means of all components in samples first, first + stride, ..., fields in balance as in the references.
std::vector<model::UniformState> sampled_means(const model::Equations& equations, const SeriesOf& series_of,
                                               std::size_t first, std::size_t stride = 1);

struct FieldPrediction {
    model::StructureFactors modes;
    std::string about;          ///< the uniform state, for people
    bool about_order = false;   ///< that state has a direction
    std::string why_none = {};  ///< why there is no prediction
};

/// Of a scene and its equations_of(): about the state nearest to the means of samples.  Where its direction is free,
/// averaged over those of the samples.  degree: of the modes that are kept.
FieldPrediction predicted_fields(const io::Scene& scene, const model::Equations& equations,
                                 const std::vector<model::UniformState>& samples, int degree, Threads& threads);

}  // namespace drover::run
