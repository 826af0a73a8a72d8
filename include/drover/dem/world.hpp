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

/// Work and losses since the start [mg mm^2/s^2].  The kinetic energy is that at the start plus their sum: to rounding
/// with the impulse law, to O(dt^2) with soft contacts.
struct EnergyBalance {
    /// Work of gravity and of the constant forces on bodies: the sum of (m g + F).(displacement), of the pairwise law
    /// less m a^2 h^2/2 for each step h of a body.
    double gravity = 0.0;
    double plates = 0.0;    ///< work of base and lid on the bodies, and that of removing overlaps of any
    double forces = 0.0;    ///< work of the torque, the push and the control of the mean velocity
    double kicks = 0.0;     ///< work of the kicks
    double impact = 0.0;    ///< lost along the normals, <= 0
    double friction = 0.0;  ///< lost to friction, <= 0; friction along the slip before an impact can return part of
                            ///< what is lost along the normals
    double elastic = 0.0;   ///< stored in soft contacts at this moment, counted as a loss: <= 0
};
inline constexpr double EnergyBalance::*balance_parts[] = {&EnergyBalance::gravity, &EnergyBalance::plates,
                                                           &EnergyBalance::forces,  &EnergyBalance::kicks,
                                                           &EnergyBalance::impact,  &EnergyBalance::friction,
                                                           &EnergyBalance::elastic};
double sum(const EnergyBalance& balance);

/// Slower impacts of pairs and on side walls are not counted [mm/s].
inline constexpr double counted_speed = 1.0;

/// Slower impacts on base or lid are not counted [mm/s]: what a body at rest gains on the plates in 1/40 of a period
/// at the largest acceleration, (|g_z| + A omega^2)/(40 f), and at least counted_speed.  A body that rests on a plate
/// hops every half time step, so its hops are slower for any step up to 1/20 of a period: counts do not depend on it.
double counted_plate_speed(const Setup& setup);

/// Numbers of events since the start.
struct Counts {
    std::int64_t bead_bead = 0, rod_bead = 0, rod_rod = 0;  ///< impacts of pairs of spheres
    std::int64_t bead_plate = 0, rod_plate = 0;             ///< impacts on base or lid
    std::int64_t bead_wall = 0, rod_wall = 0;
    std::int64_t groups = 0;         ///< of more than one contact
    std::int64_t largest_group = 0;  ///< contacts
    std::int64_t unresolved = 0;     ///< groups whose law left an approach above the tolerance
    std::int64_t limited = 0;        ///< pairwise impulses with reduced friction, since they would have created energy
    std::int64_t lists = 0;          ///< neighbour lists made
    double residual = 0.0;           ///< largest remaining speed of approach in a group, relative to that before
    double overlap = 0.0;            ///< largest ever, relative to the smaller radius of the pair
};
inline constexpr std::int64_t Counts::*count_parts[] = {&Counts::bead_bead,  &Counts::rod_bead,  &Counts::rod_rod,
                                                        &Counts::bead_plate, &Counts::rod_plate, &Counts::bead_wall,
                                                        &Counts::rod_wall,   &Counts::groups,    &Counts::largest_group,
                                                        &Counts::unresolved, &Counts::limited,   &Counts::lists};

/// A body or a surface, for messages.
struct Name {
    enum class Kind { bead, rod, wall, base, lid } kind = Kind::wall;
    std::int64_t number = 0;
    std::int64_t sphere = 0;  ///< of a rod, from the tail
};
std::string name_text(const Name& name);  ///< "bead 12", "rod 3 (sphere 6)", "the side wall", "the base"

/// The largest overlap ever, of two bodies or of a body and a surface.
struct OverlapRecord {
    double depth = 0.0, of_radius = 0.0;  ///< [mm]; relative to the smaller radius
    Name first, second;
    double time = 0.0;  ///< [s]
};

/// The world.  Only advance(), set_bodies() and restore() change its state, which is bitwise the same for any number of
/// threads.
class World {
public:
    /// `threads` must outlive it.  Throws an input Error for an invalid setup, a body of no shape, a dt that is not
    /// above 0 or too long for the plates or the contact law, and for bodies as set_bodies(), at step 0.
    /// is_start: false (for drover itself) for bodies that restore() replaces, or that are checked already.
    World(const Setup& setup, Bodies bodies, double dt, std::uint64_t seed, Threads& threads,
          const Locate& locate = no_location, bool is_start = true);
    World(World&&) noexcept;  ///< one that was moved from can only be assigned to or destroyed
    World& operator=(World&&) noexcept;
    ~World();

    /// From time step dt to (step + 1) dt.  Throws a run Error that names pair, overlap and step if two bodies overlap
    /// by more than contacts.max_overlap of a radius or a body diverges; the world can then be advanced after
    /// set_bodies(), which begins a new energy balance, or restore() alone.
    void advance(std::int64_t step);

    /// Replaces the body forces.  They are not part of the state: set them before restore().  Throws an input Error for
    /// invalid forces.
    void set_forces(const BodyForces& forces);

    Bodies bodies() const;  ///< in the order of the constructor
    /// Other positions, axes and velocities of its bodies, at the beginning of a step.  What this does to the kinetic
    /// energy counts as work of forces; contacts begin anew.  The shapes are those of the constructor.  Throws an input
    /// Error, and keeps the state, for another number of bodies or another shape of one, for values that are not
    /// finite, an axis of length 0, and bodies that overlap each other or a surface by more than contacts.max_overlap
    /// of a radius; a run Error for one far from the cell.
    void set_bodies(const Bodies& bodies, std::int64_t step);
    const Setup& setup() const;
    double dt() const;
    double energy_kinetic() const;  ///< [mg mm^2/s^2]
    EnergyBalance balance() const;
    Counts counts() const;
    OverlapRecord worst_overlap() const;
    std::string non_finite() const;  ///< the first value that is not finite, and the work behind it; empty: none

    std::vector<double> save() const;
    /// The state must be from save() of a world with the same setup, bodies, dt and seed: only its length is checked.
    /// Throws an input Error for another length.
    void restore(std::span<const double> state);

private:
    struct State;
    std::unique_ptr<State> state_;
};

}  // namespace drover::dem
