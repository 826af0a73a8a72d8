// files/archive_library.cpp: HDF5 in this process: its version, and how it may end the process.
#include "files/archive.hpp"
#include "files/hdf5_handle.hpp"

namespace drover::files {

void contain_hdf5() {
    watch_crashes();  // first: the other call can crash, too
    const InHdf5 within;
    H5dont_atexit();
}

std::string archive_library() {
    require_memory_for_hdf5();
    const InHdf5 within;
    unsigned major = 0, minor = 0, release = 0;
    H5get_libversion(&major, &minor, &release);
    return text("HDF5 {}.{}.{}", major, minor, release);
}

}  // namespace drover::files
