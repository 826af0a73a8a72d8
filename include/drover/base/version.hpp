// base/version.hpp: the version of drover and the commit that it was built from.
#pragma once
#include <string>

namespace drover {

struct Version {
    std::string version;   ///< "0.1.0"
    std::string git_hash;  ///< full hash of the commit; "unknown" when built outside a git checkout
    bool dirty = false;    ///< whether the sources differed from that commit
};

/// Recorded at each build, so that it is correct when a build folder is reused.
Version version();

}  // namespace drover
