// io/field_export.hpp: frames of a run of fields as VTK files or as a table of text; what all exports share.
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

/// The numbers of the frames, of `count`.  Throws an input Error, at `name`, for a frame that is missing.
std::vector<std::size_t> chosen_frames(const FrameChoice& choice, std::size_t count, const std::string& name);

/// Throws an input Error for a folder, and for an existing file unless `overwrite` is set and the file may be replaced.
void check_target(const std::filesystem::path& file, bool overwrite, bool (*may_replace)(const std::filesystem::path&),
                  const char* else_it_is);

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

}  // namespace drover::io
