// dem/world/world_state.hpp: the state of a world, and the parts of its step.
#pragma once
#include <vector>

#include "dem/contact/contact_law.hpp"
#include "dem/contact/contact_report.hpp"
#include "dem/contact/pair_impacts.hpp"
#include "dem/contact/pairwise_contacts.hpp"
#include "dem/contact/soft_contacts.hpp"
#include "dem/flight/spheres.hpp"
#include "dem/neighbours/neighbours.hpp"
#include "drover/dem/world.hpp"

namespace drover::dem {

struct World::State {
    Setup setup;
    ContactLaw law;
    double dt = 0.0;
    std::int64_t step = 0;  ///< that runs now
    Threads& threads;
    std::vector<Shape> shapes;
    Spheres spheres;
    Neighbours neighbours;
    PlateMotion plates;
    StepRules rules;
    PairImpacts pair_impacts;
    SoftContacts soft_contacts;
    OverlapSearch overlap_search;
    Walls walls;
    EnergyBalance balance;
    Counts counts;
    OverlapRecord worst_overlap;
    double bead_potential_start = 0.0;
    bool left_skin = false;  // since the neighbour list was made
    bool failed = false;     // in a step

    struct ChunkResult : ContactReport {
        bool left_skin = false;
    };
    std::vector<ChunkResult> results;
    ContactReport flight;  ///< the deepest overlap with base or lid in this step, pairwise law

    State(const Setup& the_setup, Bodies bodies, double the_dt, std::uint64_t seed, Threads& the_threads);

    /// Sum of (m g + F) . x of the beads.  Its change is the work of gravity and force on them, so that free flight
    /// needs no accounting.
    double bead_potential() const;

    /// A position plus the periods that were taken off it.
    Vector unwrapped(const Vector& position, const std::array<std::int32_t, 2>& image) const;

    template <class Work>
    void run_chunks(std::size_t length, std::size_t chunk, Work work);
    template <class Move>
    void move_rods(Move move);
    void renew_lists();

    /// The motion of one step under each kind of contact law.
    ContactReport step_with(const ImpactLaw& law);
    ContactReport step_with(const PairwiseLaw& law);
    template <SoftLaw Law>
    ContactReport step_with(const Law& law);

    /// The neighbours at the beginning of a step.  Throws an input Error for values that are not finite, and for
    /// overlaps beyond contacts.max_overlap.
    Neighbours checked_neighbours(Spheres& placed, std::int64_t at_step) const;
    void set_forces(const BodyForces& forces);
    void turn_rods();
    void hold_beads();
    void push_beads();
    void record_overlap(const ContactReport& report);
    EnergyBalance total_balance() const;  ///< with the work that is known only as a whole
    std::string non_finite() const;
    [[noreturn]] void fail_non_finite(const std::string& first) const;
    void check_positions() const;
};

}  // namespace drover::dem
