// base/normal_pairs.hpp: the transform of Box and Muller on many pairs at once.
#pragma once
#include <array>
#include <cstddef>

namespace drover {

inline constexpr std::size_t pair_block = 64;
using PairBlock = std::array<double, pair_block>;

/// Pairs of uniform numbers in (0, 1) to pairs of standard normal ones, in place.  Every pair takes the same path through the same
/// instructions wherever it stands in the block, so that a number depends on its own pair alone.
void make_normal_pairs(PairBlock& first, PairBlock& second);

}  // namespace drover
