// tests/fuzz/fuzzer.cpp: the entry point of libFuzzer for the target DROVER_FUZZ_TARGET.
#include <algorithm>
#include <cstdint>

#include "drover/files/archive.hpp"
#include "fuzz/targets.hpp"

extern "C" int LLVMFuzzerInitialize(int*, char***) {
    drover::files::skip_hdf5_at_exit();
    return 0;
}

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    const auto& all = drover::fuzz::targets();
    static const auto target =
        std::find_if(all.begin(), all.end(), [](const auto& one) { return one.name == DROVER_FUZZ_TARGET; });
    target->read({reinterpret_cast<const char*>(data), size});
    return 0;
}
