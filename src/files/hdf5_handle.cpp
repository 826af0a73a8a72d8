// files/hdf5_handle.cpp: the innermost message of HDF5's error stack.
#include "files/hdf5_handle.hpp"

#include <sys/mman.h>
#include <sys/resource.h>
#include <unistd.h>

#include <cerrno>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <new>

namespace drover::files {
namespace {

using Message = std::array<char, 256>;

/// Keeps the first entry, the innermost.  HDF5 calls it: it must not throw.
extern "C" herr_t keep_innermost(unsigned number, const H5E_error2_t* entry, void* message) noexcept {
    auto& kept = *static_cast<Message*>(message);
    if (number == 0 && entry->desc != nullptr) std::snprintf(kept.data(), kept.size(), "%s", entry->desc);
    return 0;
}

extern "C" herr_t keep_first(hid_t stack, void* failure) noexcept {
    auto& first = *static_cast<Hdf5Failure*>(failure);
    if (!first.happened) H5Ewalk2(stack, H5E_WALK_UPWARD, keep_innermost, &first.message);
    first.happened = true;
    return 0;
}

volatile std::sig_atomic_t calls_of_hdf5 = 0;  // objects InHdf5
bool are_crashes_watched = false;

/// Calls nothing that a signal handler may not call.
void end_with(std::string_view sentence) {
    [[maybe_unused]] const ssize_t written = ::write(STDERR_FILENO, sentence.data(), sentence.size());
    ::_exit(1);
}

void end_if_in_hdf5() {
    if (calls_of_hdf5 > 0)
        end_with(
            "error: the HDF5 library ended the process within a call, as version 1.10 does where memory is short or a "
            "file is damaged; free memory or check the file; what was committed before is whole\n");
}

extern "C" void end_by_signal(int signal) {
    end_if_in_hdf5();
    std::signal(signal, SIG_DFL);
    std::raise(signal);
}

extern "C" void end_by_exit() { end_if_in_hdf5(); }

}  // namespace

void watch_crashes() {
    are_crashes_watched = true;
    std::atexit(end_by_exit);
#ifndef __SANITIZE_ADDRESS__                             // which has handlers of its own
    alignas(16) static std::array<char, 1 << 16> stack;  // HDF5 may have used up the other one
    const stack_t place{.ss_sp = stack.data(), .ss_flags = 0, .ss_size = stack.size()};
    ::sigaltstack(&place, nullptr);
    struct sigaction action {};
    action.sa_handler = end_by_signal;
    action.sa_flags = SA_ONSTACK;
    for (const int signal : {SIGSEGV, SIGBUS, SIGABRT, SIGFPE}) ::sigaction(signal, &action, nullptr);
#endif
}

InHdf5::InHdf5() : exceptions_(std::uncaught_exceptions()) {
    if (calls_of_hdf5 == 0) errno = 0;
    calls_of_hdf5 = calls_of_hdf5 + 1;
}

InHdf5::~InHdf5() {
    // Where an allocation fails, HDF5 1.10 frees its lists of unused blocks and repeats it; if that succeeds, it writes
    // to a list that it has freed, and the process would crash later or write anything.
    if (are_crashes_watched && errno == ENOMEM && std::uncaught_exceptions() == exceptions_)
        end_with(
            "error: memory was short within the HDF5 library, and version 1.10 cannot be trusted after that; free "
            "memory; what was committed before is whole\n");
    calls_of_hdf5 = calls_of_hdf5 - 1;
}

bool has_memory_for_hdf5() {
    // Several times what one call takes.  Address space, since a limit of it (ulimit -v) is what makes malloc fail; and
    // a small block, since malloc may fail for other reasons.
    constexpr std::size_t reserve = std::size_t{16} << 20, small = std::size_t{1} << 16;
    struct rlimit limit {};
    if (::getrlimit(RLIMIT_AS, &limit) != 0 || limit.rlim_cur != RLIM_INFINITY) {
        void* const space = ::mmap(nullptr, reserve, PROT_NONE, MAP_PRIVATE | MAP_ANONYMOUS | MAP_NORESERVE, -1, 0);
        if (space == MAP_FAILED) return false;
        ::munmap(space, reserve);
    }
    void* volatile const block = std::malloc(small);  // volatile: a pair of calls could be optimised away
    std::free(block);
    return block != nullptr;
}

void require_memory_for_hdf5() {
    if (!has_memory_for_hdf5()) throw std::bad_alloc();
}

QuietErrors::QuietErrors(Hdf5Failure* first) {
    H5Eget_auto2(H5E_DEFAULT, &print_, &data_);
    H5Eset_auto2(H5E_DEFAULT, first == nullptr ? nullptr : keep_first, first);
}

std::string hdf5_message() {
    Message message{};
    H5Ewalk2(H5E_DEFAULT, H5E_WALK_UPWARD, keep_innermost, &message);
    return message[0] == '\0' ? "no message" : message.data();
}

void Hdf5Errors::fail(std::string_view doing) const {
    const std::string message = hdf5_message();
    if (throw_cause) throw_cause();
    if (fault == Fault::input)
        fail_input({file},
                   "{} failed (HDF5: {}); expected an archive: the file is damaged or was not written by drover{}",
                   doing, message, message.find("alloc") == message.npos ? "" : ", or too little memory is free");
    throw Error(fault, {file}, text("{} failed (HDF5: {})", doing, message));
}

}  // namespace drover::files
