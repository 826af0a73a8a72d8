// io/result_units.hpp: units of keys of a scene as its results have them.
#pragma once
#include <string>

#include "io/scene.hpp"

namespace drover::io {

/// A unit of a key in which [p] is the unit of the order, with the names that the scene gives: "mm^2/s" of
/// "[p]^2 mm^2/s" where the order has none.
std::string unit_in_results(const Scene& scene, const std::string& unit);

}  // namespace drover::io
