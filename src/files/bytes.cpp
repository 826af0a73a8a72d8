// files/bytes.cpp: the checksum.
#include "drover/files/bytes.hpp"

#include <xxhash.h>

namespace drover::files {

std::uint64_t checksum(std::span<const std::byte> bytes) { return XXH3_64bits(bytes.data(), bytes.size()); }

std::optional<std::span<const std::byte>> without_checksum(std::span<const std::byte> bytes) {
    if (bytes.size() < sizeof(std::uint64_t)) return std::nullopt;
    const auto before = bytes.first(bytes.size() - sizeof(std::uint64_t));
    std::uint64_t stored = 0;
    std::memcpy(&stored, bytes.data() + before.size(), sizeof stored);
    if (stored != checksum(before)) return std::nullopt;
    return before;
}

}  // namespace drover::files
