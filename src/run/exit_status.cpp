// run/exit_status.cpp: exceptions to exit statuses.
#include "drover/run/exit_status.hpp"

#include <cstdio>
#include <exception>
#include <new>
#include <system_error>

#include "drover/base/error.hpp"

namespace drover::run {

int status_of(const std::function<int()>& work) {
    try {
        return work();
    } catch (const Error& error) {
        std::fprintf(stderr, "error: %s\n", error.what());
        return error.fault() == Fault::input ? exit_bad_input : exit_run_failed;
    } catch (const std::bad_alloc&) {
        std::fprintf(stderr, "error: not enough memory; choose a smaller grid or cell, or free memory\n");
        return exit_run_failed;
    } catch (const std::system_error& error) {
        std::fprintf(stderr, "error: the operating system reports: %s; check the disk and the limits of this user\n",
                     printable(error.what()).c_str());
        return exit_run_failed;
    } catch (const std::exception& error) {
        std::fprintf(stderr, "error: %s; this is a bug in drover: please report it with the scene\n",
                     printable(error.what()).c_str());
        return exit_run_failed;
    }
}

}  // namespace drover::run
