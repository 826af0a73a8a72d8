// measure/quasirandom_subset.hpp: a representative subset of a list.
#pragma once
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numbers>

namespace drover::measure {

/// Index number k of a subset of `chosen` of `all` indices: each index once when chosen == all, else a golden-ratio
/// sequence, which has no period, so that a list sorted by species is sampled evenly.  When more than a third are
/// chosen, some may occur twice.
inline std::size_t quasirandom_index(std::size_t k, std::size_t chosen, std::size_t all) {
    if (chosen == all) return k;
    const double golden = static_cast<double>(k) * (std::numbers::phi - 1.0);
    return std::min(static_cast<std::size_t>((golden - std::floor(golden)) * static_cast<double>(all)), all - 1);
}

}  // namespace drover::measure
