// dem/setup.hpp: the parameters of a particle world, by sections of a scene.
#pragma once
#include <array>
#include <string>
#include <vector>

#include "drover/base/schema.hpp"

namespace drover::dem {

enum class CellShape { periodic, rectangle, circle, flower };
constexpr auto names_of(CellShape) { return std::array{"periodic", "rectangle", "circle", "flower"}; }

/// The shape of the world in the plane of the plates.
struct Cell {
    CellShape shape = CellShape::periodic;
    double lx = 45.0, ly = 45.0;  ///< sides, periodic and rectangle [mm]
    double radius = 25.0;         ///< of the circle; of the inner corners of the flower [mm]
    int petals = 8;               ///< arcs of the flower
    double petal_radius = 12.0;   ///< of each arc, at least radius sin(pi/petals) [mm]

    static Rows<Cell> rows();
};

inline bool is_periodic(const Cell& cell) { return cell.shape == CellShape::periodic; }

/// Base and lid, which move together: base at z = A (1 + cos(2 pi f t)), lid a gap above it.
struct Plates {
    double amplitude = 0.04;   ///< A [mm]; 0: at rest
    double frequency = 200.0;  ///< f [1/s]
    double gap = 1.2;          ///< [mm]
    bool lid = true;

    static Rows<Plates> rows();
};

struct Gravity {
    double x = 0.0, y = 0.0, z = -9810.0;  ///< acceleration [mm/s^2]

    static Rows<Gravity> rows();
};

/// Beads: single spheres.
struct BeadSupply {
    double area_fraction = 0.0;            ///< projected area of beads over that of the cell, if count is 0
    int count = 0;                         ///< 0: from area_fraction
    std::vector<double> diameters{0.8};    ///< [mm]
    std::vector<double> proportions{1.0};  ///< of the diameters, by number
    double density = 2.7;                  ///< [mg/mm^3]

    bool any() const { return count > 0 || area_fraction > 0.0; }  ///< whether there are such bodies
    static Rows<BeadSupply> rows();
};

/// Spheres of a rod that can touch a plate: those on the convex hull, or all.
enum class Bearing { hull, all };
constexpr auto names_of(Bearing) { return std::array{"hull", "all"}; }

/// Rods: solids of equally spaced spheres on a line, tail to head; n points to the head.
struct RodSupply {
    double area_fraction = 0.0;  ///< projected area of lying rods over that of the cell, if count is 0
    int count = 0;               ///< 0: from area_fraction
    std::vector<double> diameters{1.1, 1.1, 1.1, 1.1, 1.1, 1.1, 1.1, 0.88, 0.88, 0.88, 0.72, 0.72, 0.72};  ///< [mm]
    double length = 4.5;                 ///< from tip to tip [mm]
    std::vector<double> densities{8.7};  ///< of the rod, or where each sphere is the widest [mg/mm^3]
    double size_tolerance = 0.0;         ///< standard deviation of the relative size of rods
    Bearing bearing = Bearing::hull;

    bool any() const { return count > 0 || area_fraction > 0.0; }  ///< whether there are such bodies
    static Rows<RodSupply> rows();
};

/// Coefficients of normal restitution, 0 to 1, by kinds of bodies.
struct Restitution {
    double bead_bead = 0.3, rod_bead = 0.3, rod_rod = 0.3;
    double bead_plate = 0.3, rod_plate = 0.1;
    double bead_wall = 0.3, rod_wall = 0.3;

    static Rows<Restitution> rows();
};

/// Coefficients of Coulomb friction, by kinds of bodies.
struct Friction {
    double bead_bead = 0.05, rod_bead = 0.05, rod_rod = 0.05;
    double bead_plate = 0.01, rod_plate = 0.03;
    double bead_wall = 0.01, rod_wall = 0.01;

    static Rows<Friction> rows();
};

/// Noise of the rods: each time a sphere of a rod hits base or lid with normal approach speed v, omega_z += +-strength
/// v.
struct Kick {
    double strength = 0.015;  ///< epsilon [rad/mm]

    static Rows<Kick> rows();
};

/// Forces on bodies besides gravity and contacts.
struct BodyForces {
    double bead_x = 0.0, bead_y = 0.0, rod_x = 0.0, rod_y = 0.0;  ///< on each body [mg mm/s^2]
    double torque = 0.0;                                          ///< of an orienting field: torque n x h [mg mm^2/s^2]
    double angle = 0.0;                                           ///< direction of the field h, from x [rad]
    bool hold_beads = false;                                      ///< keep the mean velocity of the beads at:
    double bead_velocity_x = 0.0, bead_velocity_y = 0.0;          ///< [mm/s]
    int held_waves = 0;  ///< 0: keep the mean velocity; k: keep the mode sin(2 pi k y/ly) of the flow
    double push = 0.0;   ///< amplitude of a force push sin(2 pi push_waves x/lx) along x on each bead [mg mm/s^2]
    int push_waves = 1;

    static Rows<BodyForces> rows();
};

enum class ContactModel { impulse, spring_dashpot, repulsive_spring };
constexpr auto names_of(ContactModel) { return std::array{"impulse", "spring-dashpot", "repulsive-spring"}; }

/// How the impulses of contacts are found.
enum class GroupLaw {
    simultaneous,       ///< all contacts of a group are compressed at the same time, see resolve()
    approaching_first,  ///< one impact after another: the fastest approach comes next
    first_to_last,      ///< one after another in the order of the contacts, repeatedly
    last_to_first,
    pairwise  ///< there are no groups: PairwiseLaw
};
constexpr auto names_of(GroupLaw) {
    return std::array{"simultaneous", "approaching-first", "first-to-last", "last-to-first", "pairwise"};
}

/// What ends the impact of one contact.
enum class RestitutionKind {
    energetic,  ///< Stronge: the normal force gives back e^2 of the work of compression
    kinetic,    ///< Poisson: the impulse of restitution is e times that of compression
    kinematic   ///< Newton: the normal velocity after is -e times that before
};
constexpr auto names_of(RestitutionKind) { return std::array{"energetic", "kinetic", "kinematic"}; }

enum class ContactOrder { tail_first, random, fastest_first };
constexpr auto names_of(ContactOrder) { return std::array{"tail-first", "random", "fastest-first"}; }

enum class PairwiseFriction { stop_or_slide, decoupled };
constexpr auto names_of(PairwiseFriction) { return std::array{"stop-or-slide", "decoupled"}; }

/// How contacts are resolved: see the page "Particles" of the manual.
struct ContactControl {
    ContactModel model = ContactModel::impulse;
    GroupLaw law = GroupLaw::simultaneous;
    RestitutionKind restitution = RestitutionKind::energetic;
    bool track_slip = true;  ///< friction follows the slip through the impact; false: keeps the direction before
    int increments = 8;      ///< of the impact of a group
    double inelastic_threshold =
        0.03;  ///< approaches in a group below this times 1 - e of its largest end without rebound; 0: none
    double substep = 2e-5;                          ///< minimum time between two impacts of a rod on the plates [s]
    double simultaneity_gap = 1e-5;                 ///< contacts with smaller gaps act in one impact [mm]
    ContactOrder order = ContactOrder::tail_first;  ///< of the contacts of a rod with the plates, pairwise
    PairwiseFriction friction = PairwiseFriction::stop_or_slide;
    double rod_step = 2e-6;                         ///< of rods and their contacts with the plates, pairwise [s]
    double stiffness = 1e10;                        ///< of spring-dashpot contacts [mg/s^2]
    double tangential_stiffness_ratio = 2.0 / 7.0;  ///< of spring-dashpot contacts, to the normal one
    double skin = 0.25;                             ///< of the neighbour list [mm]
    double max_overlap = 0.02;                      ///< relative to a radius; a run with a larger overlap fails

    static Rows<ContactControl> rows();
};

/// aligned: all rods along x.
enum class PackingKind { random, aligned, file };
constexpr auto names_of(PackingKind) { return std::array{"random", "aligned", "file"}; }

/// The bodies at the start.
struct Packing {
    PackingKind kind = PackingKind::random;
    std::string file;  ///< of kind file: an H5MD file of the same bodies
    int frame = -1;    ///< frame of the file; -1: the last

    static Rows<Packing> rows();
};

struct Setup {
    Cell cell;
    Plates plates;
    Gravity gravity;
    BeadSupply beads;
    RodSupply rods;
    Restitution restitution;
    Friction friction;
    Kick kick;
    BodyForces forces;
    ContactControl contacts;
    Packing packing;
};

/// Calls visit(name, what it is, section) for each section of a scene of particles.
template <class AnySetup, class Visit>
void for_sections(AnySetup& setup, Visit visit) {
    visit("cell", "The side wall of the particle world.", setup.cell);
    visit("plates", "Base and lid, which vibrate together.", setup.plates);
    visit("gravity", "Gravity.", setup.gravity);
    visit("beads", "Single spheres.", setup.beads);
    visit("rods", "Rigid bodies of spheres on a line, tail to head.", setup.rods);
    visit("restitution", "Coefficients of normal restitution.", setup.restitution);
    visit("friction", "Coefficients of friction.", setup.friction);
    visit("kick", "Noise of the rods.", setup.kick);
    visit("forces", "Forces on bodies other than gravity and contacts.", setup.forces);
    visit("contacts", "How contacts are resolved.", setup.contacts);
    visit("packing", "Initial positions of the bodies.", setup.packing);
}

/// Throws an input Error at the location of the first invalid key.
void check(const Setup& setup, const Locate& locate = no_location);

}  // namespace drover::dem
