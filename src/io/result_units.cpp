// io/result_units.cpp: units of keys with the unit of the order and the names of the scene.
#include "io/result_units.hpp"

#include <algorithm>

#include "physics/model_values.hpp"

namespace drover::io {

namespace {
/// Without the factors [p]: "mm^2/s" of "[p]^2 mm^2/s", "mm/s" of "mm/s/[p]", "1/s" of "[p]/s".
std::string without_order(std::string unit) {
    for (std::size_t at = unit.find("[p]"); at != std::string::npos; at = unit.find("[p]")) {
        std::size_t end = at + 3;
        if (end < unit.size() && unit[end] == '^') end = std::min(unit.find_first_of(" /", end), unit.size());
        const bool divides = at > 0 && unit[at - 1] == '/', multiplies = end < unit.size() && unit[end] == ' ';
        if (divides) unit.erase(at - 1, end - at + 1);
        else if (multiplies) unit.erase(at, end - at + 1);
        else unit.replace(at, end - at, "1");
    }
    return unit;
}
}  // namespace

std::string unit_in_results(const Scene& scene, const std::string& unit) {
    if (scene.kind != SceneKind::fields) return renamed(unit, scene.units);
    const bool has_no_unit = physics::unit_of(scene.model, "[p]") == "1";
    return renamed(has_no_unit ? without_order(unit) : physics::unit_of(scene.model, unit), scene.units);
}

}  // namespace drover::io
