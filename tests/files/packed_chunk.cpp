// tests/files/packed_chunk.cpp: compressed frames against zlib, and as read by HDF5's own filters.
#include "files/packed_chunk.hpp"

#include <zlib.h>

#include <array>
#include <cstring>
#include <random>

#include "files/support.hpp"

namespace drover::files::packed_chunk_tests {
namespace {

using namespace testing_support;
using Buffer = std::vector<unsigned char>;

/// Numbers of the kinds that fields consist of, by name.
std::vector<std::pair<std::string, std::vector<double>>> kinds_of_numbers(std::size_t count) {
    std::mt19937_64 random(1);
    std::normal_distribution<double> normal;
    const auto made = [&](auto value) {
        std::vector<double> result(count);
        for (std::size_t i = 0; i < count; ++i) result[i] = value(static_cast<double>(i));
        return result;
    };
    return {{"noise", made([&](double) { return normal(random); })},
            {"weak noise", made([&](double) { return 0.7 + 1e-3 * normal(random); })},
            {"constant", made([](double) { return 2.0; })},
            {"equal rows", made([](double i) { return std::sin(0.02 * std::fmod(i, 300.0)); })},
            {"smooth", made([](double i) { return std::sin(0.001 * i) + std::cos(0.02 * std::floor(i / 256.0)); })},
            {"few values", made([](double i) { return 1.0 + 0.125 * std::fmod(i, 7.0); })}};
}

Buffer shuffled_one_by_one(const std::vector<double>& numbers) {
    Buffer result(numbers.size() * 8);
    for (std::size_t i = 0; i < numbers.size(); ++i) {
        unsigned char bytes[8];
        std::memcpy(bytes, &numbers[i], 8);
        for (std::size_t byte = 0; byte < 8; ++byte) result[byte * numbers.size() + i] = bytes[byte];
    }
    return result;
}

TEST(PackedChunk, inflates_to_the_shuffled_bytes) {
    for (const std::size_t count : {1u, 9u, 4095u, 4096u, 20003u, 70000u})
        for (const auto& [kind, numbers] : kinds_of_numbers(count)) {
            const Buffer packed = packed_chunk(numbers), expected = shuffled_one_by_one(numbers);
            Buffer inflated(expected.size());
            uLongf size = inflated.size();
            constexpr std::size_t checksum = 4;
            ASSERT_EQ(::uncompress(inflated.data(), &size, packed.data(), packed.size() - checksum), Z_OK)
                << kind << " " << count;
            EXPECT_TRUE(inflated == expected && size == expected.size()) << kind << " " << count;
        }
}

// Stored bytes and one stream for each of the eight cost room where a single stream would find more.
TEST(PackedChunk, takes_about_the_room_of_a_single_stream) {
    for (const auto& [kind, numbers] : kinds_of_numbers(65536)) {
        const Buffer bytes = shuffled_one_by_one(numbers);
        Buffer single(::compressBound(bytes.size()));
        uLongf size = single.size();
        ASSERT_EQ(::compress2(single.data(), &size, bytes.data(), bytes.size(), 1), Z_OK);
        EXPECT_LT(static_cast<double>(packed_chunk(numbers).size()), 1.01 * static_cast<double>(size) + 200.0) << kind;
    }
}

TEST(PackedChunk, h5py_reads_large_frames) {
    if (!has_python("h5py")) GTEST_SKIP() << "needs python3-h5py";
    const Folder folder;
    constexpr std::size_t nx = 150, ny = 140;  // large enough to be compressed in a thread
    const auto recordings = sample_recordings(nx, ny);
    std::ofstream expected(folder / "expected.bin", std::ios::binary);
    {
        Archive archive = Archive::create(folder / "run.h5", recordings, {}, false);
        const auto kinds = kinds_of_numbers(nx * ny);
        for (std::size_t row = 0; row + 1 < kinds.size(); ++row) {
            for (const std::size_t kind : {row, row + 1})
                expected.write(reinterpret_cast<const char*>(kinds[kind].second.data()), nx * ny * sizeof(double));
            archive.append(0, static_cast<double>(row),
                           std::array<std::span<const double>, 2>{kinds[row].second, kinds[row + 1].second});
            if (row == 1) archive.commit();
        }
        archive.commit();
        append_samples(archive, recordings);  // not committed: discarded while it is compressed
    }
    expected.close();
    EXPECT_EQ(python(R"(
import h5py, numpy, sys
file = h5py.File(sys.argv[1] + "run.h5")
expected = numpy.fromfile(sys.argv[1] + "expected.bin").reshape(5, 2, 140, 150)
assert file["rod_density"].shape == (5, 140, 150)
assert numpy.array_equal(file["rod_density"][...], expected[:, 0])
assert numpy.array_equal(file["polar_order_x"][...], expected[:, 1])
print("well")
)",
                     folder / ""),
              "well\n");
}

}  // namespace
}  // namespace drover::files::packed_chunk_tests
