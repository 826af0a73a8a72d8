// run/fields/field_prediction.hpp: structure factors of a run of fields by linear theory about its present state.
#pragma once
#include <functional>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "drover/theory/theory.hpp"
#include "io/scene.hpp"

namespace drover::run {

/// The recorded values of a scalar observable; empty where there is none of this name.
using SeriesOf = std::function<std::vector<double>(const std::string& name)>;

/// The means of all components in samples first, first + stride, ..., fields in balance as in the references.
std::vector<model::UniformState> sampled_means(const model::Equations& equations, const SeriesOf& series_of,
                                               std::size_t first, std::size_t stride = 1);

/// The field with a spin that tells the direction of a run best, by its first component: of those with a value in a
/// state that one whose size in the samples scatters least.  -1: none.
int directing_component(const model::Model& model, const model::UniformState& state,
                        const std::vector<model::UniformState>& samples);
/// The angle by which a state is turned in a sample [rad].
double turn_of(const model::Model& model, int directing, const model::UniformState& state,
               const model::UniformState& sample);

/// The uniform stationary states that a run can be about: those with the conserved means in its samples.
theory::StationaryStates states_of_run(const io::Scene& scene, const model::Equations& equations,
                                       const std::vector<model::UniformState>& samples);

/// Two of model::part_names(), by index.
using PartPair = std::pair<std::size_t, std::size_t>;

struct FieldPrediction {
    std::vector<std::vector<double>> powers;   ///< of each pair, the real part of S of each stored mode
    std::string about;                         ///< the uniform state, for people
    bool about_order = false;                  ///< that state has a direction
    std::optional<std::string> why_none = {};  ///< why there is no prediction, if there is none
};

/// Of a scene and its equations_of(): about the state nearest to the means of samples, with their conserved means.
/// Where its direction is free, averaged over those of the samples.  degree: of the modes that are kept.  is_wanted: as
/// for theory::structure_factors.
FieldPrediction predicted_fields(const io::Scene& scene, const model::Equations& equations,
                                 const std::vector<model::UniformState>& samples, const std::vector<PartPair>& pairs,
                                 int degree, Threads& threads, const theory::IsWanted& is_wanted = {});

}  // namespace drover::run
