// dem/world.hpp: bodies between plates, and the step that moves them.
#pragma once
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "drover/base/threads.hpp"
#include "drover/dem/bodies.hpp"

namespace drover::dem {

/// Where the energy of the bodies came from and went, since the start [mg mm^2/s^2].  The kinetic energy now is that at the start plus the sum
/// of all of these.
struct EnergyBalance {
    double gravity = 0.0;   ///< work of gravity
    double plates = 0.0;    ///< work of the moving base and lid on the bodies
    double forces = 0.0;    ///< work of the other forces on bodies, the torque and the control of the mean velocity
    double kicks = 0.0;     ///< work of the kicks
    double impact = 0.0;    ///< lost in the direction of the normals, <= 0
    double friction = 0.0;  ///< lost to friction, <= 0
    double elastic = 0.0;   ///< stored in soft contacts at this moment, counted as a loss: <= 0
};
inline constexpr double EnergyBalance::*balance_parts[] = {&EnergyBalance::gravity, &EnergyBalance::plates,
                                                           &EnergyBalance::forces,  &EnergyBalance::kicks,
                                                           &EnergyBalance::impact,  &EnergyBalance::friction,
                                                           &EnergyBalance::elastic};
double sum(const EnergyBalance& balance);

/// Impacts that approach slower than this are not counted [mm/s]: bodies that stay together hop at the rate of the steps.
inline constexpr double counted_speed = 1.0;

/// What happened since the start, by kinds.
struct Counts {
    std::int64_t bead_bead = 0, rod_bead = 0, rod_rod = 0;  ///< impacts of pairs of spheres
    std::int64_t bead_plate = 0, rod_plate = 0;             ///< impacts on base or lid
    std::int64_t bead_wall = 0, rod_wall = 0;
    std::int64_t groups = 0;         ///< of more than one contact
    std::int64_t largest_group = 0;  ///< contacts
    std::int64_t unresolved = 0;     ///< groups left with an approach above the tolerance
    std::int64_t lists = 0;          ///< neighbour lists made
    double residual = 0.0;           ///< largest speed of approach left in a group, beside that before
    double overlap = 0.0;            ///< largest ever, beside the smaller radius of the pair
};

/// A body, or the sphere of a rod, by its number.
struct Name {
    enum class Kind { bead, rod, wall, base, lid } kind = Kind::wall;
    std::int64_t number = 0;
    std::int64_t sphere = 0;  ///< of a rod, from the tail
};
std::string name_text(const Name& name);  ///< "bead 12", "rod 3 (sphere 6)", "the side wall"

/// The largest overlap ever, of two bodies or of one with a wall.
struct OverlapRecord {
    double depth = 0.0, of_radius = 0.0;  ///< [mm]; beside the smaller radius
    Name first, second;
    double time = 0.0;  ///< [s]
};

/// The world.  Its state changes by advance() and restore() alone, and is the same bytes for any number of threads.
class World {
public:
    /// `threads` must outlive it.  Throws an input Error when the setup cannot be, and a run Error for a body that is at no finite place.
    World(const Setup& setup, Bodies bodies, double dt, std::uint64_t seed, Threads& threads,
          const LocationOf& place = no_location);
    World(World&&) noexcept;
    ~World();

    /// From step dt to (step + 1) dt.  Throws a run Error that names pair, overlap, speed and step when two bodies come to overlap by more than
    /// contacts.max_overlap of a radius, or a body leaves the finite numbers.
    void advance(std::int64_t step);

    /// What acts on bodies from now on.  Forces are no part of the state: set them before restore().  Throws an input Error for what cannot be.
    void set_forces(const BodyForces& forces);

    Bodies bodies() const;  ///< in the order in which they were given
    const Setup& setup() const;
    double dt() const;
    double energy_kinetic() const;  ///< [mg mm^2/s^2]
    EnergyBalance balance() const;
    Counts counts() const;
    OverlapRecord worst_overlap() const;

    std::vector<double> save() const;
    /// Throws an input Error if it is not of this world.
    void restore(std::span<const double> state);

private:
    struct State;
    std::unique_ptr<State> state_;
};

}  // namespace drover::dem
