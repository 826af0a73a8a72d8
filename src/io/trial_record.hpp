// io/trial_record.hpp: trials of an assay at a point as bytes.
#pragma once
#include <string>

#include "calibrate/trial_set.hpp"

namespace drover::io {

/// A trial as bytes; and back.  Throws an input Error, with the name, for other bytes.
std::string attempt_bytes(const calibrate::Attempt& attempt);
calibrate::Attempt attempt_of(const std::string& bytes, const std::string& name);

}  // namespace drover::io
