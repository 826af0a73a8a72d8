// files/packed_chunk.cpp: HDF5's filters shuffle, deflate and fletcher32.
#include "files/packed_chunk.hpp"

#include <zlib.h>

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <new>

namespace drover::files {
namespace {

using Buffer = std::vector<unsigned char>;

/// The first bytes of all numbers, then the second ones, ...
Buffer shuffled(std::span<const double> numbers) {
    constexpr std::size_t width = sizeof(double);
    const std::size_t count = numbers.size();
    Buffer plain(count * width), result(count * width);
    std::memcpy(plain.data(), numbers.data(), plain.size());
    for (std::size_t byte = 0; byte < width; ++byte)
        for (std::size_t i = 0; i < count; ++i) result[byte * count + i] = plain[i * width + byte];
    return result;
}

}  // namespace

std::uint32_t fletcher32(std::span<const unsigned char> bytes) {
    const auto carried = [](std::uint32_t sum) { return (sum & 0xffff) + (sum >> 16); };
    std::uint32_t sum = 0, sum_of_sums = 0;
    constexpr std::size_t without_overflow = 2 * 360;
    for (std::size_t begin = 0; begin < bytes.size(); begin += without_overflow) {
        const std::size_t end = std::min(begin + without_overflow, bytes.size());
        for (std::size_t i = begin; i < end; i += 2) {
            const std::uint32_t low = i + 1 < bytes.size() ? bytes[i + 1] : 0u;
            sum += static_cast<std::uint32_t>(bytes[i]) << 8 | low;
            sum_of_sums += sum;
        }
        sum = carried(sum);
        sum_of_sums = carried(sum_of_sums);
    }
    return carried(sum_of_sums) << 16 | carried(sum);
}

std::vector<unsigned char> packed_chunk(std::span<const double> numbers) {
    const Buffer bytes = shuffled(numbers);
    uLongf length = compressBound(bytes.size());
    Buffer result(length);
    if (compress2(result.data(), &length, bytes.data(), bytes.size(), deflate_level) != Z_OK) throw std::bad_alloc();
    result.resize(length);
    const std::uint32_t checksum = fletcher32(result);
    for (const int shift : {0, 8, 16, 24}) result.push_back(static_cast<unsigned char>(checksum >> shift));
    return result;
}

}  // namespace drover::files
