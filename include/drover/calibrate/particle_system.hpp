// calibrate/particle_system.hpp: the seam between an assay and the particles it is made on.
#pragma once
#include <cstdint>
#include <functional>
#include <memory>
#include <vector>

#include "drover/dem/setup.hpp"

namespace drover::calibrate {

/// A rod in the plane.
struct RodPlace {
    double x = 0.0, y = 0.0;  ///< of its centre of mass, not wrapped [mm]
    double angle = 0.0;       ///< of n from x, in any turn [rad]
};

/// All beads taken together, in the plane.
struct BeadMotion {
    double x = 0.0, y = 0.0;    ///< mean place, not wrapped: its change is the integral of the velocity [mm]
    double vx = 0.0, vy = 0.0;  ///< mean velocity [mm/s]
};

/// Rods and beads in a periodic cell, on which forces can be imposed and of which a few means can be taken.  There are several makers of these
/// (the particle world, and stand-ins that obey known coefficients), chosen while the program runs: hence virtual functions.
class ParticleSystem {
public:
    virtual ~ParticleSystem() = default;
    /// What acts on bodies from now on.
    virtual void impose(const dem::BodyForces& forces) = 0;
    /// To a time since the start [s], not before the one reached.
    virtual void advance_to(double time) = 0;

    virtual std::vector<RodPlace> rods() const = 0;
    virtual BeadMotion beads() const = 0;
    /// Amplitude A of v_x = A sin(2 pi waves y/ly) among the beads [mm/s].
    virtual double shear_wave(int waves) const = 0;
    /// Amplitude d of the density of beads rho (1 + d cos(2 pi waves x/lx)).
    virtual double density_wave(int waves) const = 0;
};

/// Makes a system at t = 0: bodies of the setup, packed as it says, under its forces, all else from the seed.
using SystemFactory = std::function<std::unique_ptr<ParticleSystem>(const dem::Setup& setup, std::uint64_t seed)>;

/// Specimens of the particle world, one thread each, in steps of dt [s].  A system throws what dem::World and dem::pack throw.
SystemFactory system_factory(double dt);

}  // namespace drover::calibrate
