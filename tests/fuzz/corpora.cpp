// tests/fuzz/corpora.cpp: every file of the corpora, and mutants of it, through its reader.
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <random>

#include "base/log.hpp"
#include "files/archive.hpp"
#include "fuzz/targets.hpp"

/// Read by the leak sanitizer: HDF5 1.10 loses some memory when it rejects a damaged file.
extern "C" const char* __lsan_default_suppressions();
extern "C" const char* __lsan_default_suppressions() { return "leak:libhdf5"; }

namespace drover::fuzz {
namespace {

constexpr int mutants_per_file = 20;

/// As in the program: with that memory lost, HDF5 cannot close itself at the end of the process, and says so.  It has
/// to be told before its first use, by whatever test.
struct OpenHdf5 : ::testing::Environment {
    void SetUp() override { files::leave_hdf5_open(); }
};
[[maybe_unused]] const auto* const left_open = ::testing::AddGlobalTestEnvironment(new OpenHdf5);

std::vector<char> bytes_of(const std::filesystem::path& file) {
    std::ifstream stream(file, std::ios::binary);
    return {std::istreambuf_iterator<char>(stream), {}};
}

/// Some bytes changed, or a part doubled, removed or cut off.
std::vector<char> mutant(std::vector<char> bytes, std::mt19937& dice) {
    const auto below = [&](std::size_t size) { return std::uniform_int_distribution<std::size_t>(0, size - 1)(dice); };
    for (std::size_t changes = 1 + below(4); changes > 0 && !bytes.empty(); --changes) {
        const std::size_t at = below(bytes.size());
        const auto place = bytes.begin() + static_cast<std::ptrdiff_t>(at);
        const auto end = place + static_cast<std::ptrdiff_t>(std::min(bytes.size() - at, 1 + below(40)));
        switch (below(6)) {
            case 0: bytes.resize(at); break;
            case 1: bytes.erase(place, end); break;
            case 2: {
                const std::vector<char> part(place, end);
                bytes.insert(bytes.begin() + static_cast<std::ptrdiff_t>(below(bytes.size())), part.begin(),
                             part.end());
                break;
            }
            default: *place = static_cast<char>(below(256));
        }
    }
    return bytes;
}

TEST(Fuzz, every_reader_takes_or_rejects_every_file_of_its_corpus_and_mutants_of_it) {
    set_log_level(LogLevel::quiet);
    for (const Target& target : targets()) {
        const std::filesystem::path folder = std::filesystem::path(DROVER_TESTS) / "fuzz" / "corpora" / target.name;
        EXPECT_FALSE(std::filesystem::is_empty(folder)) << folder;
        for (const auto& entry : std::filesystem::directory_iterator(folder)) {
            const std::vector<char> bytes = bytes_of(entry.path());
            std::mt19937 dice(static_cast<unsigned>(bytes.size()));
            EXPECT_NO_THROW(target.read(bytes)) << entry.path();
            for (int i = 0; i < mutants_per_file; ++i)
                EXPECT_NO_THROW(target.read(mutant(bytes, dice))) << entry.path() << ", mutant " << i;
        }
    }
    set_log_level(LogLevel::information);
}

}  // namespace
}  // namespace drover::fuzz
