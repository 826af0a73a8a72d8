// measure/unit_product.hpp: the unit of a product of quantities.
#pragma once
#include <string>
#include <vector>

namespace drover::measure {

/// "mm4 s-2" of "mm s-1" twice and "mm2"; with brackets, "(1/mm^2)^2 mm2", where a unit is no such list of powers.
std::string unit_product(const std::vector<std::string>& units);

}  // namespace drover::measure
