// io/units.hpp: names of units in results: drover computes in the numbers of a scene, whatever their units are called.
#pragma once
#include <string>

#include "drover/base/schema.hpp"

namespace drover::io {

/// What results call the units of the scene; "none": numbers without a unit.
struct Units {
    std::string length = "mm", time = "s", mass = "mg";

    static Rows<Units> rows();
};

/// A unit of mm, s and mg with these names: "mm-2 s" with length "cm" is "cm-2 s", and with length "none" it is "s".
std::string renamed(const std::string& unit, const Units& units);
/// The units of all rows.
template <class Rows>
void rename_units(Rows& rows, const Units& units) {
    for (auto& row : rows) row.unit = renamed(row.unit, units);
}
/// A number and its unit: "0.4 /um" of in_unit("{:.3g}", 0.4, "/mm", units).
std::string in_unit(const char* format, double value, const std::string& unit, const Units& units);

}  // namespace drover::io
