// files/archive_library.cpp: HDF5 in this process: its version, and what it does at its end.
#include "files/archive.hpp"

namespace drover::files {

void leave_hdf5_open() { H5dont_atexit(); }

std::string archive_library() {
    unsigned major = 0, minor = 0, release = 0;
    H5get_libversion(&major, &minor, &release);
    return text("HDF5 {}.{}.{}", major, minor, release);
}

}  // namespace drover::files
