// base/normal_pairs.hpp: the Box-Muller transform of many pairs.
#pragma once
#include <array>
#include <cstddef>

namespace drover {

inline constexpr std::size_t pair_block = 64;
using PairBlock = std::array<double, pair_block>;

/// Pairs of uniform numbers in (0, 1) to pairs of standard normal numbers, in place.  Every pair passes through the
/// same instructions at any position in the block, so that each result depends on its own pair only.
void make_normal_pairs(PairBlock& first, PairBlock& second);

}  // namespace drover
