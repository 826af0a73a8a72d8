// base/version.hpp: which drover this is, and from which commit it was built.
#pragma once
#include <string>

namespace drover {

struct Version {
    std::string version;   ///< "0.1.0"
    std::string git_hash;  ///< full hash of the commit; "unknown" when built outside a git checkout
    bool dirty = false;    ///< whether the library's or program's files differed from that commit
};

/// Taken at build time, so that it stays true when a build folder is used again.
Version version();

}  // namespace drover
