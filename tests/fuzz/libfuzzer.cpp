// tests/fuzz/libfuzzer.cpp: a reader of targets.cpp for libFuzzer; DROVER_FUZZ names it.
#include <array>
#include <cstdint>
#include <cstdlib>
#include <iostream>
#include <string>

#include "base/log.hpp"
#include "fuzz/targets.hpp"

namespace {
const drover::fuzz::Target* chosen = nullptr;

constexpr std::size_t slots = 1 << 16;
/// libFuzzer looks for new values of these counters.
[[gnu::section("__libfuzzer_extra_counters"), gnu::used]] std::array<std::uint8_t, slots> counters;
}  // namespace

/// GCC calls this in each block of the library; libFuzzer knows the blocks of clang alone.
extern "C" void __sanitizer_cov_trace_pc();
extern "C" void __sanitizer_cov_trace_pc() {
    const auto place = reinterpret_cast<std::uintptr_t>(__builtin_return_address(0));
    std::uint8_t& counter = counters[(place * 0x9e3779b97f4a7c15) >> 48];
    if (counter < 255) ++counter;
}

/// HDF5 1.10 loses some memory when it rejects a damaged file.
extern "C" const char* __lsan_default_suppressions();
extern "C" const char* __lsan_default_suppressions() { return "leak:libhdf5"; }

extern "C" int LLVMFuzzerInitialize(int*, char***);
extern "C" int LLVMFuzzerInitialize(int*, char***) {
    drover::set_log_level(drover::LogLevel::quiet);
    const char* wanted = std::getenv("DROVER_FUZZ");
    for (const drover::fuzz::Target& target : drover::fuzz::targets())
        if (wanted != nullptr && wanted == std::string(target.name)) chosen = &target;
    if (chosen != nullptr) return 0;
    std::cerr << "DROVER_FUZZ must name a folder of tests/fuzz/corpora\n";
    std::exit(2);
}

extern "C" int LLVMFuzzerTestOneInput(const unsigned char*, std::size_t);
extern "C" int LLVMFuzzerTestOneInput(const unsigned char* bytes, std::size_t size) {
    chosen->read({reinterpret_cast<const char*>(bytes), size});
    return 0;
}
