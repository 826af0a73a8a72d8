// files/packed_chunk.cpp: shuffles and compresses numbers, byte by byte of their eight.
#include "files/packed_chunk.hpp"

#include <zlib.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cstring>
#include <new>
#include <optional>

#include "drover/base/error.hpp"

namespace drover::files {
namespace {

using Buffer = std::vector<unsigned char>;
using Octets = std::span<const unsigned char>;

static_assert(std::endian::native == std::endian::little, "archives hold little-endian numbers");
constexpr std::size_t width = sizeof(double);

/// Exchanges the upper bits of a with the lower ones of b, in each group of 2 * shift bits.
void exchange(std::uint64_t& a, std::uint64_t& b, int shift, std::uint64_t lower) {
    const std::uint64_t changed = ((a >> shift) ^ b) & lower;
    b ^= changed;
    a ^= changed << shift;
}

/// The first bytes of all numbers, then the second ones, ...
Buffer shuffled(std::span<const double> numbers) {
    const std::size_t count = numbers.size();
    Buffer result(count * width);
    std::array<std::uint64_t, width> rows{};
    std::size_t i = 0;
    for (; i + width <= count; i += width) {
        std::memcpy(rows.data(), numbers.data() + i, sizeof(rows));
        for (std::size_t k = 0; k < 4; ++k) exchange(rows[k], rows[k + 4], 32, 0x00000000ffffffff);
        for (const std::size_t k : {0, 1, 4, 5}) exchange(rows[k], rows[k + 2], 16, 0x0000ffff0000ffff);
        for (const std::size_t k : {0, 2, 4, 6}) exchange(rows[k], rows[k + 1], 8, 0x00ff00ff00ff00ff);
        for (std::size_t byte = 0; byte < width; ++byte)
            std::memcpy(result.data() + byte * count + i, &rows[byte], width);
    }
    for (; i < count; ++i) {
        std::array<unsigned char, width> bytes{};
        std::memcpy(bytes.data(), &numbers[i], width);
        for (std::size_t byte = 0; byte < width; ++byte) result[byte * count + i] = bytes[byte];
    }
    return result;
}

/// Whether some values are more frequent than others, by the probability that two bytes are equal: an eighth above that
/// of equally frequent ones is a gain of 2 %.
bool has_frequent_values(Octets bytes) {
    std::array<std::array<std::uint32_t, 256>, 4> counts{};  // four: equal neighbours do not wait for each other
    std::size_t i = 0;
    for (; i + 4 <= bytes.size(); i += 4)
        for (std::size_t k = 0; k < 4; ++k) ++counts[k][bytes[i + k]];
    for (; i < bytes.size(); ++i) ++counts[0][bytes[i]];
    std::uint64_t pairs = 0;
    for (std::size_t value = 0; value < 256; ++value) {
        const std::uint64_t count =
            std::uint64_t{counts[0][value]} + counts[1][value] + counts[2][value] + counts[3][value];
        pairs += count * (count - (count > 0));
    }
    const auto all = static_cast<std::uint64_t>(bytes.size());  // a chunk has less than 2^32 bytes: no overflow
    return pairs / 9 > all * all / (std::uint64_t{256} * 8);
}

/// Whether at least a sixteenth of the words of four bytes has occurred before, as where rows of a field are equal.
bool has_repeats(Octets bytes) {
    constexpr std::size_t slots = 16384;
    std::vector<std::uint32_t> last(slots);
    std::size_t repeated = 0, words = 0;
    for (std::size_t i = 0; i + 4 <= bytes.size(); i += 4, ++words) {
        std::uint32_t word = 0;
        std::memcpy(&word, bytes.data() + i, sizeof(word));
        std::uint32_t& slot = last[(word * 2654435761u) >> 18];
        if (slot == word) ++repeated;
        slot = word;
    }
    return 16 * repeated > words;
}

/// Raw deflate streams, one after the other, each ended at a whole byte.
class Deflater {
public:
    /// `size`: of each of its streams.
    Deflater(int strategy, std::size_t size) {
        constexpr int level = 1;  // higher levels gain almost nothing on shuffled noise and take twice the time
        // Small tables for small arrays: zlib clears them first.
        const bool is_small = size <= 4096;
        const int raw_window = is_small ? -12 : -15, memory = is_small ? 4 : 8;
        if (deflateInit2(&stream_, level, Z_DEFLATED, raw_window, memory, strategy) != Z_OK) throw std::bad_alloc();
    }
    ~Deflater() { deflateEnd(&stream_); }
    Deflater(const Deflater&) = delete;
    Deflater& operator=(const Deflater&) = delete;

    void append(Octets bytes, Buffer& to) {
        deflateReset(&stream_);
        const std::size_t before = to.size();
        constexpr std::size_t end_of_block = 64;
        to.resize(before + deflateBound(&stream_, bytes.size()) + end_of_block);
        stream_.next_in = const_cast<unsigned char*>(bytes.data());  // zlib does not write to it
        stream_.avail_in = static_cast<uInt>(bytes.size());
        stream_.next_out = to.data() + before;
        stream_.avail_out = static_cast<uInt>(to.size() - before);
        const int status = deflate(&stream_, Z_SYNC_FLUSH);
        if (status != Z_OK || stream_.avail_in != 0 || stream_.avail_out == 0)
            fail_environment("compression of {} bytes stopped with status {} of zlib, {} bytes before the end",
                             bytes.size(), status, stream_.avail_in);
        to.erase(to.end() - static_cast<std::ptrdiff_t>(stream_.avail_out), to.end());
    }

private:
    z_stream stream_{};
};

/// Blocks of deflate that hold the bytes as they are.
void append_stored(Octets bytes, Buffer& to) {
    constexpr std::size_t max_block = 65535;
    for (std::size_t i = 0; i < bytes.size(); i += max_block) {
        const std::size_t size = std::min(max_block, bytes.size() - i);
        const auto low = static_cast<unsigned char>(size & 0xff), high = static_cast<unsigned char>(size >> 8);
        to.insert(to.end(), {0, low, high, static_cast<unsigned char>(~low), static_cast<unsigned char>(~high)});
        to.insert(to.end(), bytes.begin() + static_cast<std::ptrdiff_t>(i),
                  bytes.begin() + static_cast<std::ptrdiff_t>(i + size));
    }
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
    Buffer result{0x78, 0x01};  // zlib: deflate, window of 32 kB, fastest
    result.reserve(bytes.size() + bytes.size() / 1024 + 256);
    // Short ones are compressed together: each stream starts without knowledge of the others.
    constexpr std::size_t min_count = 4096;
    const std::size_t step = numbers.size() < min_count ? std::max<std::size_t>(bytes.size(), 1) : numbers.size();
    std::optional<Deflater> repeats, frequencies;
    const auto append = [&](std::optional<Deflater>& deflater, int strategy, Octets plane) {
        if (!deflater) deflater.emplace(strategy, step);
        deflater->append(plane, result);
    };
    for (std::size_t i = 0; i < bytes.size(); i += step) {
        const Octets plane = Octets(bytes).subspan(i, step);
        if (step == bytes.size() || has_repeats(plane)) append(repeats, Z_DEFAULT_STRATEGY, plane);
        else if (has_frequent_values(plane)) append(frequencies, Z_HUFFMAN_ONLY, plane);
        else append_stored(plane, result);
    }
    const auto adler = static_cast<std::uint32_t>(adler32_z(1, bytes.data(), bytes.size()));
    result.insert(result.end(), {1, 0, 0, 0xff, 0xff});  // the last block: stored, empty
    for (const int shift : {24, 16, 8, 0}) result.push_back(static_cast<unsigned char>(adler >> shift));
    const std::uint32_t checksum = fletcher32(result);
    for (const int shift : {0, 8, 16, 24}) result.push_back(static_cast<unsigned char>(checksum >> shift));
    return result;
}

}  // namespace drover::files
