// jobs/campaign/job_options.cpp: the text of a share, and how many units are computed at a time.
#include "jobs/campaign/job_options.hpp"

#include <cstdio>

#include "drover/base/error.hpp"
#include "drover/base/threads.hpp"

namespace drover::jobs {

Share read_share(const std::string& written) {
    Share share;
    int used = 0;
    const bool is_whole = std::sscanf(written.c_str(), "%9d/%9d%n", &share.number, &share.count, &used) == 2 &&
                          used == static_cast<int>(written.size());
    require(is_whole && share.number >= 1 && share.number <= share.count, {},
            "--share {}; expected I/N with I from 1 to N, such as 2/8", written);
    return share;
}

JobOptions with_workers(JobOptions options, int of_scene) {
    if (options.workers == 0) options.workers = of_scene > 0 ? of_scene : usable_cores();
    return options;
}

}  // namespace drover::jobs
