// files/archive_contents.hpp: the objects, attributes and axes in an HDF5 file that is not trusted.
#pragma once
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "files/archive_layout.hpp"
#include "files/hdf5_handle.hpp"

namespace drover::files {

/// Whether each step of an absolute path is a hard link and the last one leads to an object of this type.  Other links
/// are rejected: an external one could open any file.
bool leads_to(hid_t file, const std::string& path, H5O_type_t type, const Hdf5Errors& errors);

/// An attribute of an object that is a number or a string; nothing for any other.
std::optional<Attribute> read_attribute(hid_t object, const std::string& name, std::uint64_t file_bytes,
                                        const Hdf5Errors& errors);
/// All such attributes of an object, by name.
std::vector<Attribute> attributes_of(hid_t object, std::uint64_t file_bytes, const Hdf5Errors& errors);

/// The paths of all groups and datasets, in the order of their creation.
struct Objects {
    std::vector<std::string> groups, datasets;
};
/// Rejects links, and a file with more than some thousand objects.
Objects objects_of(hid_t file, const Hdf5Errors& errors);

/// The datasets that references lead to, by their last names: HDF5 would walk through the file for each.
using NamesOfReferences = std::map<hobj_ref_t, std::string>;
NamesOfReferences names_of_references(hid_t file, const std::vector<std::string>& datasets, const Hdf5Errors& errors);

/// The names of the dimension scales of a dataset: its own if it is one, one for each axis if it is sound.
std::vector<std::string> axes_of(hid_t dataset, const std::string& path, std::size_t rank, std::uint64_t file_bytes,
                                 const NamesOfReferences& datasets, const Hdf5Errors& errors);

}  // namespace drover::files
