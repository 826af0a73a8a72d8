// dem/world_state.hpp: all that a world holds, and the parts of its step.
#pragma once
#include <vector>

#include "bead_flight.hpp"
#include "drover/dem/world.hpp"
#include "neighbours.hpp"
#include "rod_flight.hpp"
#include "spheres.hpp"
#include "touch.hpp"

namespace drover::dem {

struct World::State {
    Setup setup;
    double dt = 0.0;
    Threads& threads;
    std::vector<Shape> shapes;
    Spheres spheres;
    Neighbours neighbours;
    PlateMotion plates;
    BeadRules bead_rules;
    FlightRules rod_rules;
    Vector rod_force;
    TouchRules touch_rules;
    TouchSolver touches;
    Walls walls;
    EnergyBalance balance;
    Counts counts;
    Overlap overlap;
    double bead_potential_start = 0.0;
    bool astray = false;

    struct Part {
        EnergyBalance balance;
        Counts counts;
        bool astray = false;
    };
    std::vector<Part> parts;

    State(const Setup& the_setup, Bodies bodies, double the_dt, std::uint64_t seed, Threads& the_threads);

    /// Sum of (m g + F) . x of the beads: its change is the work of gravity and force on them, but for what moves beads out of overlaps, which
    /// takes itself off the balance.  So free flight keeps no books.
    double bead_potential() const;

    /// A place with the turns round a periodic cell that were taken off it.
    Vector unwrapped(const Vector& place, const std::array<std::int32_t, 2>& image) const;

    template <class Work>
    void in_parts(std::size_t length, std::size_t chunk, Work work);
    void fly_all_beads();
    void fly_rods();
    void set_forces(const BodyForces& forces);
    void turn_rods();
    void hold_beads();
    void push_beads();
    void notice(const TouchReport& report, std::int64_t step);
};

}  // namespace drover::dem
