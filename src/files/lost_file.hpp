// files/lost_file.hpp: a file that another program removed, replaced or changed while a run writes it.
#pragma once
#include "files/overlay.hpp"

namespace drover::files {

/// Throws, now and at all later calls, a run Error unless the name of a file that is written still refers to it, and it
/// is as the last commit left it.  The Error says whether the run can be resumed, and how.  A file without any name is
/// written again, as of the last commit, where a checkpoint of the run remains: under its name, or where another file
/// has that, under the name with ".rescued".
void require_in_place(Overlay& overlay);

/// Removes the file, unless its name refers to another one.
void remove_in_place(const Overlay& overlay);

}  // namespace drover::files
