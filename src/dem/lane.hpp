// dem/lane.hpp: four doubles that move through the processor together: x, y, z and one more.
#pragma once
#include "drover/dem/vector.hpp"

namespace drover::dem {

using Lane = double __attribute__((vector_size(32)));

inline Vector vector_of(const Lane& lane) { return {lane[0], lane[1], lane[2]}; }
inline void set_vector(Lane& lane, const Vector& v) {
    lane[0] = v.x;
    lane[1] = v.y;
    lane[2] = v.z;
}

}  // namespace drover::dem
