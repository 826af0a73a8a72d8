// analysis/stability.hpp: the stability analysis of a scene: uniform states, coefficients, modes, instabilities,
// fluctuations.
#pragma once
#include <functional>
#include <string>
#include <vector>

#include "drover/theory/theory.hpp"
#include "io/scene.hpp"
#include "run/result.hpp"

namespace drover::analysis {

/// A structure factor, as a function of the matrix of all components at a wavevector.
struct StructurePart {
    std::string name, unit;
    std::function<double(const model::Symbol&, const numerics::Wavevector&)> value;
};

/// A uniform state.
struct AnalysedState {
    std::string name, group, heading;
    std::vector<run::Entry> entries;  ///< its values
    model::LinearisedAt linear;
    bool has_free_direction = false;  ///< turned copies are states too
    bool is_mapped_along_x = false;   ///< all directions are equivalent, and one is enough for its maps
    std::vector<StructurePart> parts = {};
};

/// The waves that a scene searches: by default from a thousandth of the smallest |q| of its cell to the largest of its
/// grid.  Throws an input Error for an empty range.
theory::GrowthSearch growth_search(const io::Scene& scene);

/// 2 pi over the longer side of the cell [1/mm].
double smallest_wavenumber(const numerics::Grid& grid);

/// Arrays over wavenumber, angle and frequency of one state.  direction: from which angles are measured, "p0".
files::ResultTable stability_maps(const io::StabilityPlan& plan, const numerics::Grid& grid, const AnalysedState& state,
                                  const std::string& direction, const theory::GrowthSearch& search, Threads& threads);

/// Coefficients and states; in an archive each state is a group named after it ("along_the_field").  With `threads`
/// also the maps that archives hold: branches over angle and wavenumber (growth_rate, frequency, shapes), slow modes by
/// angle, structure factors (NaN where a mode grows) and dynamic structure factors at stability.sound.  Throws an input
/// Error for an empty range of wavenumbers.
run::Result make_stability(const io::Scene& scene, Threads* threads = nullptr);

}  // namespace drover::analysis
