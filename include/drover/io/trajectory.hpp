// io/trajectory.hpp: the bodies of a particle world as an archive has them: H5MD, and back.
//
// /particles/spheres holds every sphere, those of beads first, then those of rods from tail to head.  It is the only group of
// /particles, of which MDAnalysis 2.4 takes the first one it finds; box/edges has a row a frame because that reader wants it so; and
// units stand in `units` and not in H5MD's `unit`, because it refuses a file whose `unit` it does not know, such as mm.
// The state of the bodies, exact and not wrapped, stands in /bodies/beads and /bodies/rods in the same layout.
#pragma once
#include <span>
#include <string>
#include <vector>

#include "drover/dem/bodies.hpp"
#include "drover/io/archive.hpp"

namespace drover::io {

inline constexpr const char* spheres_group = "/particles/spheres";
inline constexpr const char* beads_group = "/bodies/beads";
inline constexpr const char* rods_group = "/bodies/rods";

/// The series of a run of particles.  Not /observables, which H5MD keeps for elements of another layout.
inline constexpr const char* series_group = "/series";

/// One recording and how its row is made: one array for each quantity.
struct BodyRecording {
    Recording recording;
    std::vector<std::vector<double>> (*row)(const dem::Setup& setup, const dem::Bodies& bodies);
};
/// Those of spheres, of beads and of rods, without those of which there are none.
std::vector<BodyRecording> trajectory_recordings(const dem::Setup& setup, const dem::Bodies& bodies);

/// Spheres of all bodies.
std::size_t sphere_count(const dem::Bodies& bodies);

/// Whether an archive holds a trajectory, and its frames.
bool has_trajectory(const ArchiveReader& archive);
std::size_t frame_count(const ArchiveReader& archive);

/// Places `bodies` as they stand in a frame, which must be of bodies of the same number and shapes.  Throws an input Error at `where`, which
/// starts with `what`, the words for the file.
void read_bodies(const ArchiveReader& archive, std::size_t frame, dem::Bodies& bodies, const std::string& what,
                 const SourceLocation& where);

/// The box about a cell, centred on its middle: sides [mm], and whether it goes on beyond them.
struct Box {
    std::array<double, 3> sides{};
    std::array<double, 3> origin{};
    std::array<bool, 3> periodic{};
};
Box box_of(const dem::Setup& setup);

}  // namespace drover::io
