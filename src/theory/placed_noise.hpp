// theory/placed_noise.hpp: noise that no uniform state has.
#pragma once
#include <algorithm>

#include "drover/model/equations.hpp"

namespace drover::theory {

/// The first noise that depends on position or time; nullptr: none.
inline const model::TermSummary* placed_noise(const model::Equations& equations) {
    const auto& noises = equations.noise_terms();
    const auto found = std::ranges::find_if(noises, [](const model::TermSummary& one) { return one.is_placed; });
    return found == noises.end() ? nullptr : &*found;
}

}  // namespace drover::theory
