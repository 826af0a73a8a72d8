// files/run_id.hpp: the random number by which the files of one run are known.
#pragma once
#include <string>

#include "files/archive_reader.hpp"

namespace drover::files {

/// 128 random bits as hexadecimal digits.  Drawn once for each archive that a run creates; a restart keeps it.
std::string draw_run_id();

/// Of the run that made an archive; "" if that was an earlier version of drover.
std::string run_id_of(const ArchiveReader& archive);

}  // namespace drover::files
