// files/installed_models.hpp: where the models are that are installed with drover.
#pragma once
#include <filesystem>

namespace drover::files {

/// The folder share/drover/models below the prefix of this program or module, or models of the source tree in which it
/// was built; empty: neither is there.
std::filesystem::path installed_models();

}  // namespace drover::files
