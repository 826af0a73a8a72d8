// dem/flight/step_rules.hpp: what the parts of a time step take from the setup of a world.
#pragma once
#include <cstdint>

#include "dem/bodies/plate_motion.hpp"
#include "dem/bodies/vec4d.hpp"
#include "dem/impact/impact.hpp"
#include "drover/dem/setup.hpp"

namespace drover::dem {

struct StepRules {
    Restitution restitution;
    Friction friction;
    ImpactLaw law;                     ///< of contacts in groups
    Vector acceleration;               ///< of gravity [mm/s^2]
    Vector bead_force, rod_force;      ///< on each bead, and on each rod [mg mm/s^2]
    double dt = 0.0;                   ///< [s]
    double substep = 0.0;              ///< minimum time between impacts of a rod on the plates [s]
    double simultaneity_gap = 0.0;     ///< contacts with smaller gaps act in one impact, bodies rest on a plate [mm]
    double counted_plate_speed = 0.0;  ///< of impacts on the plates [mm/s]
    double skin = 0.0;                 ///< [mm]
    double kick = 0.0;                 ///< [rad/mm]
    std::uint64_t seed = 0;
    PlateState base;   ///< at the end of the step; of contacts in groups
    double lid = 0.0;  ///< height of the lid then [mm]; never: no lid

    Vector rod_acceleration(double mass) const { return acceleration + 1.0 / mass * rod_force; }
    /// Of a bead.
    Vec4d acceleration_of(double mass_inverse) const {
        return Vec4d{acceleration.x, acceleration.y, acceleration.z, 0.0} +
               Vec4d{bead_force.x, bead_force.y, bead_force.z, 0.0} * mass_inverse;
    }
};

}  // namespace drover::dem
