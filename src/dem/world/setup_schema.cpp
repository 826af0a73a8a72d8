// dem/world/setup_schema.cpp: the input keys of each section of a particle world.
#include "drover/dem/setup.hpp"

namespace drover::dem {

Rows<Cell> Cell::rows() {
    return Rows<Cell>{
        {"shape", &Cell::shape,
         "shape of the cell: periodic in x and y, or with a vertical side wall: a rectangle, a circle, or a "
         "flower of arcs that meet in inner corners and turn bodies back inwards"},
        {"lx", &Cell::lx, "periodic, rectangle: side along x, from -lx/2 to lx/2", "mm", positive},
        {"ly", &Cell::ly, "periodic, rectangle: side along y, from -ly/2 to ly/2", "mm", positive},
        {"radius", &Cell::radius, "circle: its radius; flower: distance of the inner corners from the centre", "mm",
         positive},
        {"petals", &Cell::petals, "flower: number of arcs; the middle of the first points along x", "",
         within(3, 1000)},
        {"petal_radius", &Cell::petal_radius,
         "flower: radius of each arc, at least radius sin(pi/petals): an arc is at most half a circle", "mm", positive},
    };
}

Rows<Plates> Plates::rows() {
    return Rows<Plates>{
        {"amplitude", &Plates::amplitude,
         "amplitude A of the vibration: the base is at z = A (1 + cos(2 "
         "pi f t)), and the lid moves with it; 0: at rest",
         "mm", not_negative},
        {"frequency", &Plates::frequency, "frequency f of the vibration", "1/s", positive},
        {"gap", &Plates::gap, "height of the lid above the base; every body must be thinner", "mm", positive},
        {"lid", &Plates::lid, "whether there is a lid"},
    };
}

Rows<Gravity> Gravity::rows() {
    return Rows<Gravity>{
        {"x", &Gravity::x, "acceleration along x; not 0 for tilted plates", "mm/s^2"},
        {"y", &Gravity::y, "acceleration along y; not 0 for tilted plates", "mm/s^2"},
        {"z", &Gravity::z, "acceleration along z (upwards); negative on Earth", "mm/s^2"},
    };
}

Rows<BeadSupply> BeadSupply::rows() {
    return Rows<BeadSupply>{
        {"area_fraction", &BeadSupply::area_fraction,
         "area fraction Phi_b: projected area of all beads over the area of the cell, if count is 0", "",
         within(0.0, 1.0)},
        {"count", &BeadSupply::count, "number of beads; 0: from area_fraction", "", within(0, 1e7)},
        {"diameters", &BeadSupply::diameters, "diameters of the beads, one for each component of a mixture", "mm",
         positive},
        {"proportions", &BeadSupply::proportions, "proportions of the diameters, by number; only their ratios matter",
         "", not_negative},
        {"density", &BeadSupply::density, "density of the material: 2.7 aluminium, 7.8 steel, 2.5 glass", "mg/mm^3",
         positive},
    };
}

Rows<RodSupply> RodSupply::rows() {
    return Rows<RodSupply>{
        {"area_fraction", &RodSupply::area_fraction,
         "area fraction Phi_r: projected area of all lying rods over the area of the cell, if count is 0", "",
         within(0.0, 1.0)},
        {"count", &RodSupply::count, "number of rods; 0: from area_fraction", "", within(0, 1e6)},
        {"diameters", &RodSupply::diameters,
         "diameters of the spheres whose union is a rod, equally spaced on its axis from tail to head", "mm", positive},
        {"length", &RodSupply::length, "length from tip to tip; ignored for a rod of one sphere", "mm", positive},
        {"densities", &RodSupply::densities,
         "density of the material: one number, or one for each sphere, which applies where that sphere is the "
         "widest",
         "mg/mm^3", not_negative},
        {"size_tolerance", &RodSupply::size_tolerance,
         "standard deviation of the relative size of rods; all lengths of a rod have the same scale factor", "",
         within(0.0, 0.1)},
        {"bearing", &RodSupply::bearing,
         "spheres of a rod that can touch base and lid: hull: those on its convex hull, as in exact contact; "
         "all: also those that overlaps bring into contact (contacts.law = \"pairwise\" or a soft contacts.model)"},
    };
}

Rows<Restitution> Restitution::rows() {
    constexpr Range range{.min = 0.0, .max = 1.0};
    return Rows<Restitution>{
        {"bead_bead", &Restitution::bead_bead,
         "coefficient of restitution e of two beads: 0: no rebound, 1: no loss of energy", "", range},
        {"rod_bead", &Restitution::rod_bead, "e of a rod and a bead", "", range},
        {"rod_rod", &Restitution::rod_rod, "e of two rods", "", range},
        {"bead_plate", &Restitution::bead_plate, "e of a bead on base or lid", "", range},
        {"rod_plate", &Restitution::rod_plate, "e of a rod on base or lid", "", range},
        {"bead_wall", &Restitution::bead_wall, "e of a bead on a side wall", "", range},
        {"rod_wall", &Restitution::rod_wall, "e of a rod on a side wall", "", range},
    };
}

Rows<Friction> Friction::rows() {
    return Rows<Friction>{
        {"bead_bead", &Friction::bead_bead, "coefficient of Coulomb friction mu of two beads", "", not_negative},
        {"rod_bead", &Friction::rod_bead, "mu of a rod and a bead", "", not_negative},
        {"rod_rod", &Friction::rod_rod, "mu of two rods", "", not_negative},
        {"bead_plate", &Friction::bead_plate, "mu of a bead on base or lid", "", not_negative},
        {"rod_plate", &Friction::rod_plate, "mu of a rod on base or lid", "", not_negative},
        {"bead_wall", &Friction::bead_wall, "mu of a bead on a side wall", "", not_negative},
        {"rod_wall", &Friction::rod_wall, "mu of a rod on a side wall", "", not_negative},
    };
}

Rows<Kick> Kick::rows() {
    return Rows<Kick>{
        {"strength", &Kick::strength,
         "epsilon: each contact of a rod with base or lid that approaches at the speed v changes its spin about z by "
         "+epsilon v or -epsilon v with equal probability",
         "rad/mm", not_negative},
    };
}

Rows<BodyForces> BodyForces::rows() {
    constexpr const char* force = "mg mm/s^2";
    return Rows<BodyForces>{
        {"bead_x", &BodyForces::bead_x, "force on each bead, along x", force},
        {"bead_y", &BodyForces::bead_y, "force on each bead, along y", force},
        {"rod_x", &BodyForces::rod_x, "force on each rod, along x", force},
        {"rod_y", &BodyForces::rod_y, "force on each rod, along y", force},
        {"torque", &BodyForces::torque, "strength of the field h that orients rods by the torque n x h", "mg mm^2/s^2",
         not_negative},
        {"angle", &BodyForces::angle, "direction of the field h, from x", "rad"},
        {"hold_beads", &BodyForces::hold_beads,
         "whether an equal acceleration of every bead keeps the mean velocity of the beads constant"},
        {"bead_velocity_x", &BodyForces::bead_velocity_x, "mean velocity that hold_beads keeps, along x", "mm/s"},
        {"bead_velocity_y", &BodyForces::bead_velocity_y, "mean velocity that hold_beads keeps, along y", "mm/s"},
        {"held_waves", &BodyForces::held_waves,
         "0: hold_beads keeps the mean velocity; k: it keeps the mode sin(2 pi k y/ly) of the flow, with amplitude "
         "bead_velocity_x, bead_velocity_y",
         "", not_negative},
        {"push", &BodyForces::push, "amplitude of the force push sin(2 pi push_waves x/lx) along x on each bead",
         force},
        {"push_waves", &BodyForces::push_waves, "number of periods of push across the cell", "", at_least(1)},
    };
}

Rows<ContactControl> ContactControl::rows() {
    return Rows<ContactControl>{
        {"model", &ContactControl::model,
         "contact law: impulse: bodies are rigid and impacts take no time; spring-dashpot: bodies are soft, and "
         "contacts are linear springs with damping and friction (an independent check, with far smaller time steps); "
         "repulsive-spring: as spring-dashpot, with contacts that never pull"},
        {"law", &ContactControl::law,
         "impulse: how contacts of one group share an impact: simultaneously, or one after another, starting with "
         "the fastest approach, the first or the last contact; pairwise: time steps without groups, in which each "
         "overlapping contact that approaches gets one impulse and overlaps are not corrected"},
        {"restitution", &ContactControl::restitution,
         "impulse: definition of e: energetic: e^2 is the ratio of the work of restitution to that of compression "
         "(Stronge); kinetic: of the impulses (Poisson); kinematic: of the velocities (Newton), which can create "
         "energy where the slip turns"},
        {"track_slip", &ContactControl::track_slip,
         "impulse: whether friction follows the slip through the impact; false: it keeps its initial direction, in "
         "single contacts alone where contacts.law is \"simultaneous\""},
        {"increments", &ContactControl::increments,
         "impulse: number of increments of the impact of a group; those of a single contact follow their error", "",
         within(1, 100000)},
        {"inelastic_threshold", &ContactControl::inelastic_threshold,
         "impulse: approaches in a group of contacts slower than this times 1 - e of its fastest end without "
         "rebound; 0: none do",
         "", within(0.0, 1.0)},
        {"substep", &ContactControl::substep,
         "impulse: minimum time between two impacts of a rod on the plates; faster ones are merged", "s", positive},
        {"simultaneity_gap", &ContactControl::simultaneity_gap,
         "impulse: contacts of a body with smaller gaps act in one impact", "mm", not_negative},
        {"order", &ContactControl::order, "pairwise: order of the contacts of a rod with the plates within a step"},
        {"friction", &ContactControl::friction,
         "pairwise: friction of a contact: stop-or-slide: it stops the slip if mu allows, otherwise it opposes "
         "the slip before, both with a normal velocity of -e times that before; decoupled: the normal impulse "
         "is that without friction, and friction opposes the slip before, up to mu times the normal impulse"},
        {"rod_step", &ContactControl::rod_step,
         "pairwise: time step of rods and of their contacts with the plates; time.dt is divided into equal steps "
         "of at most this",
         "s", positive},
        {"stiffness", &ContactControl::stiffness,
         "soft bodies: normal stiffness of all contacts; a larger one needs a smaller time.dt", "mg/s^2", positive},
        {"tangential_stiffness_ratio", &ContactControl::tangential_stiffness_ratio,
         "soft bodies: tangential over normal stiffness; 2/7 gives both the same period in contacts of solid "
         "spheres",
         "", positive},
        {"skin", &ContactControl::skin, "margin of the neighbour list; affects the speed of a run, not its physics",
         "mm", positive},
        {"max_overlap",
         &ContactControl::max_overlap,
         "largest allowed overlap, relative to the smaller radius; a run with a larger one fails: dt is too "
         "long or "
         "contacts are too soft",
         "",
         {.min = 0.0, .max = 1.0, .min_open = true}},
    };
}

Rows<Packing> Packing::rows() {
    return Rows<Packing>{
        {"kind", &Packing::kind,
         "initial bodies: random positions and directions; random positions with all rods along x; from a file"},
        {"file", &Packing::file, "file: an H5MD file of the same bodies"},
        {"frame", &Packing::frame, "file: index of its frame, from 0; -1: the last", "", at_least(-1)},
    };
}

}  // namespace drover::dem
