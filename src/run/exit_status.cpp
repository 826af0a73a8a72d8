// run/exit_status.cpp: exceptions to exit statuses.
#include "run/exit_status.hpp"

#include <cstdio>
#include <exception>
#include <new>

#include "drover/base/error.hpp"

namespace drover::run {

namespace {
/// Errors of other types as an Error.  Neither an Error nor a bad_alloc is converted: there may be no memory for it.
int in_errors(const std::function<int()>& work) {
    try {
        return work();
    } catch (const Error&) {
        throw;
    } catch (const std::bad_alloc&) {
        throw;
    } catch (const std::exception& exception) {
        throw error_of(exception);
    }
}
}  // namespace

int status_of(const std::function<int()>& work) {
    try {
        return in_errors(work);
    } catch (const Error& error) {
        std::fprintf(stderr, "error: %s\n", error.what());
        const bool is_bad_input = error.fault() == Fault::input || error.fault() == Fault::unavailable;
        return is_bad_input ? exit_bad_input : exit_run_failed;
    } catch (const std::bad_alloc&) {
        std::fprintf(stderr, "error: %s\n", no_memory_text);
        return exit_run_failed;
    }
}

}  // namespace drover::run
