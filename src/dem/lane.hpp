// dem/lane.hpp: four doubles that move through the processor together: x, y, z and one more.
#pragma once
#ifdef __AVX__
#include <immintrin.h>
#endif

#include "drover/dem/vector.hpp"

namespace drover::dem {

using Lane = double __attribute__((vector_size(32)));

inline Vector vector_of(const Lane& lane) { return {lane[0], lane[1], lane[2]}; }
inline void set_vector(Lane& lane, const Vector& v) {
    lane[0] = v.x;
    lane[1] = v.y;
    lane[2] = v.z;
}

/// The answers to a comparison of lanes, as bits.
inline unsigned bits(const decltype(Lane{} < Lane{}) & mask) {
#ifdef __AVX__
    return static_cast<unsigned>(_mm256_movemask_pd(reinterpret_cast<__m256d>(mask)));
#else
    unsigned result = 0;
    for (unsigned k = 0; k < 4; ++k) result |= mask[k] ? 1u << k : 0u;
    return result;
#endif
}

}  // namespace drover::dem
