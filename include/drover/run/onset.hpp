// run/onset.hpp: what drover boundary says of a table of coefficients, for people and for files.
#pragma once
#include <string>
#include <vector>

#include "drover/calibrate/onset.hpp"
#include "drover/files/archive.hpp"

namespace drover::run {

/// Curves at the nodes of the table, crossings of both conventions, and the line.
std::string onset_text(const calibrate::Onset& onset, const calibrate::Table& table);

/// "from Phi_b = 0.43 +- 0.03; ...", "from the least area fraction of beads on; ...", "no_location in the table; ...", with how many redrawn tables cross.
std::string crossing_text(const calibrate::Crossing& crossing);

/// Groups /curves (by rod_fraction, bead_fraction) and /line (by rod_fraction).
std::vector<files::ResultTable> onset_tables(const calibrate::Onset& onset);

}  // namespace drover::run
