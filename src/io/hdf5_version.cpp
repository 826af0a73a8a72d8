// io/hdf5_version.cpp: which HDF5 this is.
#include <hdf5.h>

#include "drover/base/text.hpp"
#include "drover/io/archive.hpp"

namespace drover::io {

std::string archive_library() {
    unsigned major = 0, minor = 0, release = 0;
    H5get_libversion(&major, &minor, &release);
    return text("HDF5 {}.{}.{}", major, minor, release);
}

}  // namespace drover::io
