// files/archive_netcdf.hpp: creates groups and datasets that follow netCDF-4, the CF conventions and H5MD.
#pragma once
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "files/archive_layout.hpp"
#include "files/hdf5_handle.hpp"

namespace drover::files {

/// Throws an input Error unless the names in the group are unique and a chunk fits HDF5.
void check(const Recording& recording, const std::string& file);

/// Lengths of the axes of a quantity, without time, and their product.
inline std::vector<std::size_t> shape_of(const Recording& recording, const Quantity& quantity) {
    return shape_of(recording.axes, quantity);
}
std::size_t count_of(const Recording& recording, const Quantity& quantity);

/// The datasets of a group that the archive writes to.
struct GroupDatasets {
    Handle time;  ///< invalid in a group without time
    Handle step;  ///< of a trajectory
    std::vector<Handle> quantities;
};

/// Creates the group (unless it is the root group), its axes with their coordinates, time and empty quantities.
GroupDatasets make_group(hid_t file, const Recording& recording, const Hdf5Errors& errors);

/// Opens the datasets that make_group created.
GroupDatasets open_group(hid_t file, const Recording& recording, const Hdf5Errors& errors);

/// Path of a member of a group: "/observables/time".
std::string path_in(const std::string& group, const std::string& name);

/// Paths of the times and of the rows of a quantity of a group.
std::string time_path(const Recording& recording);
std::string value_path(const Recording& recording, const Quantity& quantity);

// Shared by the two layouts.

/// The extent and the chunk of a dataset; time, if any, is the first axis and starts with no rows.
struct Extent {
    std::vector<hsize_t> now, max, chunk;
};
constexpr std::size_t time_rows_per_chunk = 256;
Extent extent_of(const std::vector<std::size_t>& shape, std::size_t rows_per_chunk);
/// Whether a dataset of this extent is stored within its object header: small, and of a fixed size.
bool is_compact(const Extent& extent);
Handle make_dataset(hid_t group, const std::string& name, const Extent& extent, bool is_integer,
                    const Hdf5Errors& errors);

/// Creates the group, or opens an existing one.
Handle group_handle(hid_t file, const std::string& group, bool is_new, const Hdf5Errors& errors);

/// Attributes that are lists.
void write_list(hid_t object, const char* name, std::span<const std::int64_t> values, const Hdf5Errors& errors);
void write_list(hid_t object, const char* name, std::span<const std::string> values, const Hdf5Errors& errors);

/// For files, groups and datasets: links and attributes in order of creation, no timestamps.
Handle creation_list(hid_t kind, const Hdf5Errors& errors);

/// Strings are stored as fixed-length ASCII, or UTF-8 if needed.
void write_attribute(hid_t object, const Attribute& attribute, const Hdf5Errors& errors);

/// Writes "Conventions" and these to the root group; those that exist are replaced one at a time.
void write_root_attributes(hid_t file, const std::vector<Attribute>& attributes, const Hdf5Errors& errors);

/// The same, and removes all others but the run id.  That stays where it is in the file: HDF5 moves attributes where
/// there are few.
void replace_root_attributes(hid_t file, const std::vector<Attribute>& attributes, const Hdf5Errors& errors);

}  // namespace drover::files
