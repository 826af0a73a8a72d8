// measure/spread_over_list.hpp: some members of a list, to stand for all.
#pragma once
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numbers>

namespace drover::measure {

/// Number k of `chosen` among `all`: each once when as many are chosen, else spread over the list in no step of its own, so that a list dealt
/// out by kind is met in its parts.  When more than a third are chosen, some may come twice.
inline std::size_t spread_over_list(std::size_t k, std::size_t chosen, std::size_t all) {
    if (chosen == all) return k;
    const double golden = static_cast<double>(k) * (std::numbers::phi - 1.0);
    return std::min(static_cast<std::size_t>((golden - std::floor(golden)) * static_cast<double>(all)), all - 1);
}

}  // namespace drover::measure
