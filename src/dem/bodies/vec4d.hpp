// dem/bodies/vec4d.hpp: vectors of four doubles: x, y, z and one more number.
#pragma once
#ifdef __AVX__
#include <immintrin.h>
#endif

#include "drover/dem/bodies.hpp"

namespace drover::dem {

using Vec4d = double __attribute__((vector_size(32)));

inline Vector vector_of(const Vec4d& a) { return {a[0], a[1], a[2]}; }
inline void set_vector(Vec4d& a, const Vector& v) {
    a[0] = v.x;
    a[1] = v.y;
    a[2] = v.z;
}

/// Bit k is the result of the comparison of component k.
inline unsigned bits(const decltype(Vec4d{} < Vec4d{}) & mask) {
#ifdef __AVX__
    return static_cast<unsigned>(_mm256_movemask_pd(reinterpret_cast<__m256d>(mask)));
#else
    unsigned result = 0;
    for (unsigned k = 0; k < 4; ++k) result |= mask[k] ? 1u << k : 0u;
    return result;
#endif
}

}  // namespace drover::dem
