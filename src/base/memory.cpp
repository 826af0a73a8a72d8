// base/memory.cpp: free memory from /proc/meminfo and the limits of the process.
#include "base/memory.hpp"

#include <sys/resource.h>

#include <algorithm>
#include <fstream>
#include <limits>
#include <string>

namespace drover {

std::uint64_t memory_available() {
    std::uint64_t bytes = std::numeric_limits<std::uint64_t>::max();
    std::ifstream table("/proc/meminfo");
    for (std::string name; table >> name;) {
        std::uint64_t kilobytes = 0;
        if (name == "MemAvailable:" && table >> kilobytes) bytes = kilobytes * 1024;
        table.ignore(std::numeric_limits<std::streamsize>::max(), '\n');
    }
    struct rlimit limit {};
    if (::getrlimit(RLIMIT_AS, &limit) == 0 && limit.rlim_cur != RLIM_INFINITY)
        bytes = std::min(bytes, static_cast<std::uint64_t>(limit.rlim_cur));
    return bytes;
}

}  // namespace drover
