// io/export.hpp: frames of a run for other programs: of fields as VTK files or as a table of text, of particles as
// extended XYZ text, and the content of such files.
#pragma once
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "files/archive_reader.hpp"

namespace drover::io {

/// Selection of frames.
struct FrameChoice {
    std::int64_t frame = -1;  ///< a single frame; -1: every `every`-th frame
    std::int64_t every = 1;
};

/// Whether a name is that of a file which write_fields() writes: .vtk or .csv.
bool is_field_export(const std::filesystem::path& file);

/// Writes frames of an archive of fields; returns the files, in order.
/// name.vtk: the image of one frame (legacy VTK, binary, points of the grid; scalars and vectors by name, the time as
/// field data TIME); of several frames name-0000.vtk, name-0001.vtk, ..., numbered as in the archive, which ParaView
/// opens as a series.
/// name.csv: all frames in one table, a line for each point: time, x, y and the fields, with units in the first line.
/// Throws an input Error for an archive without fields, a missing frame or an existing file (unless `overwrite`), and a
/// run Error when the disk is full; each file appears when it is complete.
std::vector<std::filesystem::path> write_fields(const files::ArchiveReader& archive, const std::string& name,
                                                const FrameChoice& choice, const std::filesystem::path& file,
                                                bool overwrite);

/// Writes frames of an archive of particles to a text file, which appears when it is complete.  Lines of spheres:
/// species (B of a bead, Rh of a rod), position in the box, radius, velocity, number of the sphere and of its body.
/// Lines of bodies, if `of_bodies`: species, centre of mass in the box, length, direction, velocity, angular velocity,
/// number.  Throws an input Error for an archive without a trajectory or of other bodies than its scene has, a missing
/// frame or an existing file (unless `overwrite`), and a run Error when the disk is full, leaving nothing behind.
/// Returns the number of frames written.
std::size_t write_xyz(const files::ArchiveReader& archive, const std::string& name, const FrameChoice& choice,
                      bool of_bodies, const std::filesystem::path& file, bool overwrite);

/// The content of an extended XYZ file.
struct XyzInfo {
    std::size_t frames = 0;
    std::size_t min_lines = 0, max_lines = 0;           ///< particles of a frame
    std::string lattice, origin, periodic, properties;  ///< of the first frame
    std::vector<double> times;                          ///< of the frames with a time
};

/// Whether a file looks like XYZ: its first line is a number alone.
bool is_xyz(const std::filesystem::path& file);

/// Throws an input Error, with the line number, for a file that is not extended XYZ.
XyzInfo read_xyz_info(const std::filesystem::path& file);

}  // namespace drover::io
