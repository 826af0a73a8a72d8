// io/archive_netcdf.hpp: groups and datasets as netCDF-4 and the CF conventions want them.
#pragma once
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
    int rows_per_chunk = 0;  ///< 0: no time axis
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
    std::vector<Handle> quantities;
};

/// Makes the group (the root group is there already), its axes with their coordinates, time and empty quantities.
GroupDatasets make_group(hid_t file, const GroupPlan& plan, const Hdf5Errors& errors);

/// Opens those of a group that make_group made.
GroupDatasets open_group(hid_t file, const GroupPlan& plan, const Hdf5Errors& errors);

/// Path of a member of a group: "/observables/time".
std::string path_in(const std::string& group, const std::string& name);

/// For files and groups: links and attributes in the order in which they were made, no times of day.
Handle file_creation(const Hdf5Errors& errors);

/// Texts are stored as fixed-length ASCII, or UTF-8 when they need it.
void write_attribute(hid_t object, const Attribute& attribute, const Hdf5Errors& errors);

/// The text of an attribute of a dataset that make_group made.
std::string read_text_attribute(hid_t object, const std::string& name, const Hdf5Errors& errors);

}  // namespace drover::io
