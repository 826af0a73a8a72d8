// jobs/share.cpp: the text of a share.
#include "jobs/share.hpp"

#include <cstdio>

#include "drover/base/error.hpp"

namespace drover::jobs {

Share read_share(const std::string& written) {
    Share share;
    int used = 0;
    const bool is_whole = std::sscanf(written.c_str(), "%d/%d%n", &share.number, &share.count, &used) == 2 &&
                          used == static_cast<int>(written.size());
    require(is_whole && share.number >= 1 && share.number <= share.count, {},
            "--share {}; expected I/N with I from 1 to N, such as 2/8", written);
    return share;
}

}  // namespace drover::jobs
