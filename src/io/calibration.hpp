// io/calibration.hpp: tables of coefficients as HDF5 files, and trials as bytes.
#pragma once
#include <filesystem>
#include <string>
#include <vector>

#include "calibrate/table.hpp"
#include "calibrate/trial_set.hpp"
#include "files/archive.hpp"

namespace drover::io {

/// What the axis of a key is called in files: with _ for its dot.
std::string axis_of(std::string key);

/// Writes HDF5 that obeys netCDF-4.  In the root group the axes bead_area_fraction and rod_area_fraction and, if a
/// key is varied, its own; for each coefficient x the datasets x (with unit and formula), x_error,
/// x_trials and x_origin (a number of calibrate::Origin) and, of one with ranks, x_ranks.  Root attributes:
/// `attributes`; `coefficients`, their names; `varied`; `remarks`, one per line, "drag[3]: ...", with the index in x.
/// The same table and attributes give the same bytes.  Replaces an existing file atomically.  Throws a run Error when
/// the disk is full.
void write_calibration(const std::filesystem::path& file, const calibrate::Table& table,
                       std::vector<files::Attribute> attributes);

bool is_calibration(const files::ArchiveReader& archive);

/// Throws an input Error, naming file and dataset, when the file is not such a table or calibrate::check rejects its
/// numbers.  Missing entries are read as refused ones.
calibrate::Table read_calibration(const files::ArchiveReader& archive, const std::filesystem::path& file);
calibrate::Table read_calibration(const std::filesystem::path& file);

/// A trial of an assay at a point as bytes; and back.  Throws an input Error, with the name, for other bytes.
std::string attempt_bytes(const calibrate::Attempt& attempt);
calibrate::Attempt attempt_of(const std::string& bytes, const std::string& name);

}  // namespace drover::io
