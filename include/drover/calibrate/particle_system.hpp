// calibrate/particle_system.hpp: the interface between an assay and the particles that it is run on.
#pragma once
#include <cstdint>
#include <functional>
#include <memory>
#include <vector>

#include "drover/dem/setup.hpp"

namespace drover::calibrate {

/// Position of a body in the plane, not wrapped [mm].
struct Position {
    double x = 0.0, y = 0.0;
};

/// A rod in the plane.
struct RodPose {
    double x = 0.0, y = 0.0;  ///< centre of mass, not wrapped [mm]
    double angle = 0.0;       ///< from the x axis to n, modulo 2 pi [rad]
};

/// Means over all beads, in the plane.
struct BeadMotion {
    double x = 0.0, y = 0.0;    ///< mean position, not wrapped: its change is the integral of the mean velocity [mm]
    double vx = 0.0, vy = 0.0;  ///< mean velocity [mm/s]
};

/// Rods and beads in a periodic cell, with imposed forces and a few measured quantities.  The virtual functions allow
/// the particle world and synthetic systems with known coefficients to be exchanged at run time.
class ParticleSystem {
public:
    virtual ~ParticleSystem() = default;
    /// Replaces the forces on the bodies from now on.
    virtual void impose(const dem::BodyForces& forces) = 0;
    /// Advances to a time since the start [s], not earlier than the current time.
    virtual void advance_to(double time) = 0;

    virtual std::vector<RodPose> rods() const = 0;
    virtual BeadMotion beads() const = 0;
    /// Position of each bead.
    virtual std::vector<Position> bead_positions() const = 0;
    /// Amplitude A of v_x = A sin(2 pi waves y/ly) of the beads [mm/s].
    virtual double shear_wave(int waves) const = 0;
    /// Amplitude d of the bead density rho (1 + d cos(2 pi waves x/lx)).
    virtual double density_wave(int waves) const = 0;
};

/// Creates a system at t = 0: the bodies of the setup, its packing and its forces; the seed fixes all random choices.
using SystemFactory = std::function<std::unique_ptr<ParticleSystem>(const dem::Setup& setup, std::uint64_t seed)>;

/// Creates systems of the particle world, single-threaded, with time step dt [s].
/// A system throws what dem::World and dem::pack throw.
SystemFactory system_factory(double dt);

}  // namespace drover::calibrate
