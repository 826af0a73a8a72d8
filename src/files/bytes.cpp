// files/bytes.cpp: the checksum and deflate.
#include "files/bytes.hpp"

#include <xxhash.h>
#include <zlib.h>

#include <utility>

#include "drover/base/error.hpp"

namespace drover::files {

std::uint64_t checksum(std::span<const std::byte> bytes) { return XXH3_64bits(bytes.data(), bytes.size()); }

std::vector<std::byte> with_checksum(std::vector<std::byte> bytes) {
    ByteWriter to{std::move(bytes)};
    to(checksum(to.bytes));
    return std::move(to.bytes);
}

std::optional<std::span<const std::byte>> without_checksum(std::span<const std::byte> bytes) {
    if (bytes.size() < sizeof(std::uint64_t)) return std::nullopt;
    const auto before = bytes.first(bytes.size() - sizeof(std::uint64_t));
    std::uint64_t stored = 0;
    std::memcpy(&stored, bytes.data() + before.size(), sizeof stored);
    if (stored != checksum(before)) return std::nullopt;
    return before;
}

std::vector<std::byte> deflated(std::span<const std::byte> bytes) {
    ByteWriter to;
    to(static_cast<std::uint64_t>(bytes.size()));
    const std::size_t head = to.bytes.size();
    uLongf length = compressBound(static_cast<uLong>(bytes.size()));
    to.bytes.resize(head + length);
    const int status = compress(reinterpret_cast<Bytef*>(to.bytes.data() + head), &length,
                                reinterpret_cast<const Bytef*>(bytes.data()), static_cast<uLong>(bytes.size()));
    if (status != Z_OK) fail_environment("{}", no_memory_text);
    to.bytes.resize(head + length);
    return std::move(to.bytes);
}

std::optional<std::vector<std::byte>> inflated(std::span<const std::byte> bytes) {
    ByteReader reader{bytes};
    const auto expected = reader.take<std::uint64_t>();
    constexpr std::uint64_t max_bytes = 1 << 30;
    if (!reader.is_complete || expected > max_bytes) return std::nullopt;
    std::vector<std::byte> result(static_cast<std::size_t>(expected));
    uLongf length = static_cast<uLongf>(expected);
    const int status =
        uncompress(reinterpret_cast<Bytef*>(result.data()), &length, reinterpret_cast<const Bytef*>(reader.rest.data()),
                   static_cast<uLong>(reader.rest.size()));
    if (status != Z_OK || length != expected) return std::nullopt;
    return result;
}

}  // namespace drover::files
