// io/trajectory.hpp: the bodies of a particle world in an archive, in H5MD.
//
// /particles/spheres holds every sphere: those of beads first, then those of rods from tail to head.  It is the only
// group of /particles, because MDAnalysis 2.4 reads the first one that it finds.  box/edges has one row per frame, as
// that reader requires.  Units are in the attribute `units` instead of H5MD's `unit`, because that reader rejects
// unknown units such as mm. The exact, unwrapped state of the bodies is in /bodies/beads and /bodies/rods, in the same
// layout.
#pragma once
#include <string>
#include <vector>

#include "dem/bodies/rotation.hpp"
#include "files/archive.hpp"

namespace drover::io {

inline constexpr const char* spheres_group = "/particles/spheres";
inline constexpr const char* beads_group = "/bodies/beads";
inline constexpr const char* rods_group = "/bodies/rods";

/// The time series of a particle run.  Not /observables, which H5MD reserves for another layout.
inline constexpr const char* series_group = "/series";

/// A recording and the function that computes its rows: one array per quantity.
struct BodyRecording {
    files::Recording recording;
    std::vector<std::vector<double>> (*row)(const dem::Setup& setup, const dem::Bodies& bodies);
};
/// The recordings of spheres, beads and rods, without empty ones.
std::vector<BodyRecording> trajectory_recordings(const dem::Setup& setup, const dem::Bodies& bodies);

/// One sphere of a body.
struct Sphere {
    dem::Vector position, velocity;
    double radius = 0.0;
    bool of_rod = false;
    std::size_t body = 0;  ///< beads first, then rods
};

/// Visits the spheres in the order of /particles/spheres.
template <class Visit>
void for_spheres(const dem::Bodies& bodies, Visit visit) {
    std::size_t body = 0;
    for (const dem::Bead& bead : bodies.beads)
        visit(Sphere{bead.position, bead.velocity, bodies.shapes[bead.shape].radius.front(), false, body++});
    for (const dem::Rod& rod : bodies.rods) {
        const dem::Shape& shape = bodies.shapes[rod.shape];
        const dem::Vector spin = angular_velocity(rod, shape);
        for (std::size_t s = 0; s < shape.at.size(); ++s) {
            const dem::Vector arm = shape.at[s] * rod.axis;
            visit(Sphere{rod.position + arm, rod.velocity + cross(spin, arm), shape.radius[s], true, body});
        }
        ++body;
    }
}

/// Number of spheres of all bodies.
std::size_t sphere_count(const dem::Bodies& bodies);

/// Whether an archive contains a trajectory, and its number of frames.
bool has_trajectory(const files::ArchiveReader& archive);
std::size_t frame_count(const files::ArchiveReader& archive);

/// Sets `bodies` to the state of a frame, whose bodies must have the same number and shapes.  Throws an input Error at
/// `where`, which starts with `what`, the description of the file.
void read_bodies(const files::ArchiveReader& archive, std::size_t frame, dem::Bodies& bodies, const std::string& what,
                 const SourceLocation& where);

/// Sets `bodies` from rows of beads and of rods, as a BodyRecording makes them.  Throws as read_bodies().
void set_bodies(const std::vector<std::vector<double>>& beads, const std::vector<std::vector<double>>& rods,
                dem::Bodies& bodies, const std::string& what, const SourceLocation& where);

/// The bounding box of a cell, centred on it: sides [mm] and periodicity.
struct Box {
    std::array<double, 3> sides{};
    std::array<double, 3> origin{};
    std::array<bool, 3> periodic{};
};
Box box_of(const dem::Setup& setup);

/// Moves a position into the box; returns the number of sides subtracted along each axis.
std::array<double, 3> wrap(dem::Vector& position, const Box& box);

}  // namespace drover::io
