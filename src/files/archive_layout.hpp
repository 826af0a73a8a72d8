// files/archive_layout.hpp: what an archive holds, as data: axes, quantities, recordings, result tables, attributes.
#pragma once
#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "drover/base/axis.hpp"
#include "drover/base/schema.hpp"

namespace drover::files {

using drover::Axis;

/// One array.
struct Quantity {
    std::string name;               ///< "rod_density"
    std::string unit;               ///< UDUNITS text; "1" for a pure number
    std::string meaning;            ///< CF comment: what it is, with its formula
    std::vector<std::string> axes;  ///< names, slowest first, without time; each must be an axis of the same group
    bool is_integer = false;        ///< stored as int64
};

/// A time-independent array of a trajectory: radii, species.
struct FixedArray {
    std::string name, unit, meaning;
    bool is_integer = false;     ///< stored as int64
    std::size_t components = 1;  ///< numbers per particle; more than one adds a second axis
    std::vector<double> values;
};

/// Lengths of the axes of a quantity, each one of `axes`.
std::vector<std::size_t> shape_of(const std::vector<Axis>& axes, const Quantity& quantity);

/// What an H5MD group has besides the elements that grow with time.
struct Trajectory {
    std::vector<FixedArray> fixed;
    bool has_box = false;            ///< with the element box/edges among the quantities
    std::array<bool, 3> periodic{};  ///< of that box
};

/// A group of arrays that grow along a common time axis by one row per append.  A group with a trajectory is laid out
/// as H5MD: each quantity is a group <name>/{value,step,time}, which share step and time by hard links; axes give sizes
/// only and are not written.  Units are in the attribute `units`, as everywhere in the file.
struct Recording {
    std::string group;  ///< "/", "/observables"; of a trajectory also "/particles/spheres"
    std::vector<Axis> axes;
    std::vector<Quantity> quantities;
    int rows_per_chunk = 1;  ///< 1 for fields, many for scalars; 0: no time axis
    std::optional<Trajectory> trajectory = {};
    std::string time_unit = "s";  ///< not of a trajectory
};

/// A group of arrays without time: the results of a run.
struct ResultTable {
    std::string group;  ///< "/summary"
    std::vector<Axis> axes;
    std::vector<Quantity> quantities;         ///< without axes: a single number
    std::vector<std::vector<double>> values;  ///< of each quantity, in the order of `quantities`
    std::vector<std::string> warnings = {};   ///< the attribute `warnings` of the group; not written when empty
};

using Attribute = std::pair<std::string, Variant<std::int64_t, double, std::string>>;

/// The root attribute with the id of the run.  Two runs of the same scene differ in it, as in start_time.
inline constexpr const char* run_id_name = "run_id";

}  // namespace drover::files
