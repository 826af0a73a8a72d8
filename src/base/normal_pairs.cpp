// base/normal_pairs.cpp: the Box-Muller kernel.  Only this file is compiled with -ffast-math: it lets the compiler use
// the C library's vector logarithm, sine and cosine (error 4 ulp), which are four times as fast as the scalar
// functions.
#include "base/normal_pairs.hpp"

#include <cmath>
#include <numbers>

namespace drover {

void make_normal_pairs(PairBlock& first, PairBlock& second) {
    // Alignment and a fixed length avoid scalar remainder loops.
    alignas(64) PairBlock radius, angle, cosine, sine;
    for (std::size_t i = 0; i < pair_block; ++i) radius[i] = std::sqrt(-2.0 * std::log(first[i]));
    for (std::size_t i = 0; i < pair_block; ++i) angle[i] = 2.0 * std::numbers::pi * second[i];
    for (std::size_t i = 0; i < pair_block; ++i) cosine[i] = std::cos(angle[i]);
    for (std::size_t i = 0; i < pair_block; ++i) sine[i] = std::sin(angle[i]);
    for (std::size_t i = 0; i < pair_block; ++i) {
        first[i] = radius[i] * cosine[i];
        second[i] = radius[i] * sine[i];
    }
}

}  // namespace drover
