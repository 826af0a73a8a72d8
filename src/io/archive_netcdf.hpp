// io/archive_netcdf.hpp: groups and datasets as netCDF-4 and the CF conventions want them, and as H5MD does.
#pragma once
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "drover/io/archive.hpp"
#include "io/hdf5_handle.hpp"

namespace drover::io {

/// What a group holds.
struct GroupPlan {
    std::string group;
    std::vector<Axis> axes;
    std::vector<Quantity> quantities;
    int rows_per_chunk = 0;                     ///< 0: no time axis
    std::optional<Trajectory> trajectory = {};  ///< laid out as H5MD
};

GroupPlan plan_of(const Recording& recording);
GroupPlan plan_of(const ResultTable& table);

/// Throws an input Error unless names are plain and single, axes known and not empty, and a chunk fits HDF5.
void check(const GroupPlan& plan, const std::string& file);

/// Size of the array of a quantity, without time, and its product.
std::vector<std::size_t> shape_of(const GroupPlan& plan, const Quantity& quantity);
std::size_t count_of(const GroupPlan& plan, const Quantity& quantity);

/// The datasets of a group that are written to.
struct GroupDatasets {
    Handle time;  ///< none in a group without time
    Handle step;  ///< of a trajectory
    std::vector<Handle> quantities;
};

/// Makes the group (the root group is there already), its axes with their coordinates, time and empty quantities.
GroupDatasets make_group(hid_t file, const GroupPlan& plan, const Hdf5Errors& errors);

/// Opens those of a group that make_group made.
GroupDatasets open_group(hid_t file, const GroupPlan& plan, const Hdf5Errors& errors);

/// Path of a member of a group: "/observables/time".
std::string path_in(const std::string& group, const std::string& name);

/// Where the times and the rows of a quantity of a group stand.
std::string time_path(const GroupPlan& plan);
std::string value_path(const GroupPlan& plan, const Quantity& quantity);

// What the two layouts share.

/// The extent and the chunk of a dataset; time, when it has one, comes first and starts with no rows.
struct Extent {
    std::vector<hsize_t> now, max, chunk;
};
Extent extent_of(const std::vector<std::size_t>& shape, std::size_t rows_per_chunk);
Handle make_dataset(hid_t group, const std::string& name, const Extent& extent, bool whole, const Hdf5Errors& errors);
void write_description(hid_t dataset, const std::string& unit, const std::string& meaning, const Hdf5Errors& errors);

/// Makes the group, or opens one that is there.
Handle group_handle(hid_t file, const std::string& group, bool is_new, const Hdf5Errors& errors);

/// A text that programs read as a null-terminated one, and lists.
void write_list(hid_t object, const char* name, std::span<const std::int64_t> values, const Hdf5Errors& errors);
void write_list(hid_t object, const char* name, std::span<const std::string> values, const Hdf5Errors& errors);

/// Makes the groups and datasets of a trajectory, and /h5md, where they are not there yet.
GroupDatasets make_trajectory(hid_t file, const GroupPlan& plan, const Hdf5Errors& errors);

/// For files and groups: links and attributes in the order in which they were made, no times of day.
Handle file_creation(const Hdf5Errors& errors);

/// Texts are stored as fixed-length ASCII, or UTF-8 when they need it.
void write_attribute(hid_t object, const Attribute& attribute, const Hdf5Errors& errors);

/// The text of an attribute of a dataset that make_group made.
std::string read_text_attribute(hid_t object, const std::string& name, const Hdf5Errors& errors);

}  // namespace drover::io
