// io/xyz.hpp: frames of a run of particles as extended XYZ text, and what such a file holds.
#pragma once
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "drover/io/archive.hpp"

namespace drover::io {

/// Which frames, and whether spheres or bodies.
struct XyzPlan {
    std::int64_t frame = -1;  ///< the only one; -1: all of them, by `every`
    std::int64_t every = 1;
    bool bodies = false;  ///< one line a body, with its direction, instead of one a sphere
};

/// Writes frames of an archive of particles to a text file, which appears when it is whole.  Lines of spheres: species (B of a bead, Rh of
/// a rod), place in the box, radius, velocity, number of the sphere and of its body.  Lines of bodies: species, centre of mass in the box,
/// length, direction, velocity, angular velocity, number.  Throws an input Error for an archive without a trajectory, a frame that is not
/// there or a file that exists (unless `overwrite`), and a run Error when the disk is full, leaving nothing behind.  Returns the frames written.
std::size_t write_xyz(const ArchiveReader& archive, const std::string& name, const XyzPlan& plan,
                      const std::filesystem::path& file, bool overwrite);

/// What an extended XYZ file holds.
struct XyzInfo {
    std::size_t frames = 0;
    std::size_t min_lines = 0, max_lines = 0;           ///< particles of a frame
    std::string lattice, origin, periodic, properties;  ///< of the first frame
    std::vector<double> times;                          ///< of the frames that tell one
};

/// Whether a file looks like XYZ: its first line is a number alone.
bool is_xyz(const std::filesystem::path& file);

/// Throws an input Error, with the line, where the file is no extended XYZ.
XyzInfo read_xyz_info(const std::filesystem::path& file);

}  // namespace drover::io
