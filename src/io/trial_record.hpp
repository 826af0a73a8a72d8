// io/trial_record.hpp: trials of an assay at a point as bytes, and the files of them that earlier versions wrote.
#pragma once
#include <filesystem>
#include <string>
#include <vector>

#include "calibrate/trial_set.hpp"
#include "files/record_identity.hpp"

namespace drover::io {

/// A trial as bytes; and back.  Throws an input Error, with the name, for other bytes.
std::string attempt_bytes(const calibrate::Attempt& attempt);
calibrate::Attempt attempt_of(const std::string& bytes, const std::string& name);

/// The trials of one assay at one point in a file of an earlier version of drover calibrate; none if there is no file.
/// Throws as files::read_records, and an input Error for records that are no trials.
std::vector<calibrate::Attempt> read_trials(const std::filesystem::path& file, const files::RecordIdentity& identity);

}  // namespace drover::io
