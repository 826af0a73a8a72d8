// files/archive_root.hpp: the root attributes of an archive.
#pragma once
#include <vector>

#include "files/archive_layout.hpp"
#include "files/hdf5_handle.hpp"

namespace drover::files {

/// Writes "Conventions" and these; those that exist are replaced one at a time.
void write_root_attributes(hid_t file, const std::vector<Attribute>& attributes, const Hdf5Errors& errors);

/// The same, and removes all others but the run id.  That stays where it is in the file: HDF5 moves attributes where
/// there are few.
void replace_root_attributes(hid_t file, const std::vector<Attribute>& attributes, const Hdf5Errors& errors);

}  // namespace drover::files
