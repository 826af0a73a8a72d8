// app/processor.cpp: a processor that lacks instructions of this build gets a sentence instead of SIGILL.
#ifdef DROVER_NEEDS_X86_64_V3
#include <sys/platform/x86.h>
#include <unistd.h>

#include <cstring>

namespace {

/// What the processor lacks of x86-64-v3, or nullptr.
const char* missing_feature() {
    if (!CPU_FEATURE_ACTIVE(SSE4_2)) return "SSE4.2";
    if (!CPU_FEATURE_ACTIVE(POPCNT)) return "POPCNT";
    if (!CPU_FEATURE_ACTIVE(MOVBE)) return "MOVBE";
    if (!CPU_FEATURE_ACTIVE(LZCNT)) return "LZCNT";
    if (!CPU_FEATURE_ACTIVE(AVX)) return "AVX";
    if (!CPU_FEATURE_ACTIVE(AVX2)) return "AVX2";
    if (!CPU_FEATURE_ACTIVE(BMI1)) return "BMI1";
    if (!CPU_FEATURE_ACTIVE(BMI2)) return "BMI2";
    if (!CPU_FEATURE_ACTIVE(F16C)) return "F16C";
    if (!CPU_FEATURE_ACTIVE(FMA)) return "FMA";
    return nullptr;
}

void write_text(const char* words) {
    [[maybe_unused]] const ssize_t written = ::write(STDERR_FILENO, words, std::strlen(words));
}

void require_processor() {
    const char* missing = missing_feature();
    if (missing == nullptr) return;
    write_text("error: this processor has no ");
    write_text(missing);
    write_text(
        ", and this drover is compiled for x86-64-v3 (from 2013 on); compile drover on this machine with "
        "-D DROVER_NATIVE=ON\n");
    constexpr int exit_run_failed = 1;
    ::_exit(exit_run_failed);
}

/// Called before the constructors of the program and of its libraries.  This file uses functions of C only: an inline
/// function of C++ could be that of another file, compiled for x86-64-v3.
[[gnu::section(".preinit_array"), gnu::used]] void (*const first)() = &require_processor;

}  // namespace
#endif
