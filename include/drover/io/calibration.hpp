// io/calibration.hpp: tables of coefficients as files.
#pragma once
#include <filesystem>
#include <string>
#include <vector>

#include "drover/calibrate/table.hpp"
#include "drover/io/archive.hpp"

namespace drover::io {

/// HDF5 that netCDF tools read.  Group /calibration: the axes bead_area_fraction and rod_area_fraction, and the varied key, with _ for its dot, if there is
/// one; of each coefficient x the datasets x (with unit and formula), x_error, x_trials and x_origin (a number of calibrate::Origin).  Root
/// attributes: those given; `coefficients`, their names; `varied`; `remarks`, one a line, "drag[3]: ...", by their place in x.
/// Written beside and renamed: the same table and attributes give the same bytes.  Throws a run Error when the disk is full.
void write_calibration(const std::filesystem::path& file, const calibrate::Table& table,
                       std::vector<Attribute> attributes);

bool is_calibration(const ArchiveReader& archive);

/// Throws an input Error, naming file and dataset, for a file that is no such table, or whose numbers cannot be: see calibrate::check.  Holes are kept, as
/// refused.
calibrate::Table read_calibration(const ArchiveReader& archive, const std::filesystem::path& file);
calibrate::Table read_calibration(const std::filesystem::path& file);

}  // namespace drover::io
