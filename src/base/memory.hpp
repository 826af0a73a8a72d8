// base/memory.hpp: the memory that is free.
#pragma once
#include <cstdint>

namespace drover {

/// Free memory [bytes] as reported by the system, at most the limit of this process; a large number if unknown.
std::uint64_t memory_available();

}  // namespace drover
