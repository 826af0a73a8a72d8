// dem/world/setup_schema.cpp: the input keys of each section of a particle world.
#include "dem/contact/contact_law.hpp"
#include "drover/dem/setup.hpp"

namespace drover {

using namespace dem;

template <>
const std::vector<Row<Cell>>& schema<Cell>() {
    static const std::vector<Row<Cell>> rows{
        {.name = "shape",
         .member = &Cell::shape,
         .choices = {"periodic", "rectangle", "circle", "flower"},
         .doc = "shape of the cell: periodic in x and y, or with a vertical side wall: a rectangle, a circle, or a "
                "flower of arcs that meet in inner corners and turn bodies back inwards"},
        {.name = "lx",
         .member = &Cell::lx,
         .unit = "mm",
         .range = positive,
         .doc = "periodic, rectangle: side along x, from -lx/2 to lx/2"},
        {.name = "ly",
         .member = &Cell::ly,
         .unit = "mm",
         .range = positive,
         .doc = "periodic, rectangle: side along y, from -ly/2 to ly/2"},
        {.name = "radius",
         .member = &Cell::radius,
         .unit = "mm",
         .range = positive,
         .doc = "circle: its radius; flower: distance of the inner corners from the centre"},
        {.name = "petals",
         .member = &Cell::petals,
         .range = {.min = 3, .max = 1000},
         .doc = "flower: number of arcs; the middle of the first points along x"},
        {.name = "petal_radius",
         .member = &Cell::petal_radius,
         .unit = "mm",
         .range = positive,
         .doc = "flower: radius of each arc, at least radius sin(pi/petals): an arc is at most half a circle"}};
    return rows;
}

template <>
const std::vector<Row<Plates>>& schema<Plates>() {
    static const std::vector<Row<Plates>> rows{{.name = "amplitude",
                                                .member = &Plates::amplitude,
                                                .unit = "mm",
                                                .range = not_negative,
                                                .doc = "amplitude A of the vibration: the base is at z = A (1 + cos(2 "
                                                       "pi f t)), and the lid moves with it; 0: at rest"},
                                               {.name = "frequency",
                                                .member = &Plates::frequency,
                                                .unit = "1/s",
                                                .range = positive,
                                                .doc = "frequency f of the vibration"},
                                               {.name = "gap",
                                                .member = &Plates::gap,
                                                .unit = "mm",
                                                .range = positive,
                                                .doc = "height of the lid above the base; every body must be thinner"},
                                               {.name = "lid",
                                                .member = &Plates::lid,
                                                .doc = "whether there is a lid"}};
    return rows;
}

template <>
const std::vector<Row<Gravity>>& schema<Gravity>() {
    static const std::vector<Row<Gravity>> rows{
        {.name = "x", .member = &Gravity::x, .unit = "mm/s^2", .doc = "acceleration along x; not 0 for tilted plates"},
        {.name = "y", .member = &Gravity::y, .unit = "mm/s^2", .doc = "acceleration along y; not 0 for tilted plates"},
        {.name = "z",
         .member = &Gravity::z,
         .unit = "mm/s^2",
         .doc = "acceleration along z (upwards); negative on Earth"}};
    return rows;
}

template <>
const std::vector<Row<BeadSupply>>& schema<BeadSupply>() {
    static const std::vector<Row<BeadSupply>> rows{
        {.name = "area_fraction",
         .member = &BeadSupply::area_fraction,
         .range = {.min = 0.0, .max = 1.0},
         .doc = "area fraction Phi_b: projected area of all beads over the area of the cell, if count is 0"},
        {.name = "count",
         .member = &BeadSupply::count,
         .range = {.min = 0, .max = 1e7},
         .doc = "number of beads; 0: from area_fraction"},
        {.name = "diameters",
         .member = &BeadSupply::diameters,
         .unit = "mm",
         .range = positive,
         .doc = "diameters of the beads, one for each component of a mixture"},
        {.name = "proportions",
         .member = &BeadSupply::proportions,
         .range = not_negative,
         .doc = "proportions of the diameters, by number; only their ratios matter"},
        {.name = "density",
         .member = &BeadSupply::density,
         .unit = "mg/mm^3",
         .range = positive,
         .doc = "density of the material: 2.7 aluminium, 7.8 steel, 2.5 glass"}};
    return rows;
}

template <>
const std::vector<Row<RodSupply>>& schema<RodSupply>() {
    static const std::vector<Row<RodSupply>> rows{
        {.name = "area_fraction",
         .member = &RodSupply::area_fraction,
         .range = {.min = 0.0, .max = 1.0},
         .doc = "area fraction Phi_r: projected area of all lying rods over the area of the cell, if count is 0"},
        {.name = "count",
         .member = &RodSupply::count,
         .range = {.min = 0, .max = 1e6},
         .doc = "number of rods; 0: from area_fraction"},
        {.name = "diameters",
         .member = &RodSupply::diameters,
         .unit = "mm",
         .range = positive,
         .doc = "diameters of the spheres whose union is a rod, equally spaced on its axis from tail to head"},
        {.name = "length",
         .member = &RodSupply::length,
         .unit = "mm",
         .range = positive,
         .doc = "length from tip to tip; ignored for a rod of one sphere"},
        {.name = "densities",
         .member = &RodSupply::densities,
         .unit = "mg/mm^3",
         .range = not_negative,
         .doc = "density of the material: one number, or one for each sphere, which applies where that sphere is the "
                "widest"},
        {.name = "size_tolerance",
         .member = &RodSupply::size_tolerance,
         .range = {.min = 0.0, .max = 0.1},
         .doc = "standard deviation of the relative size of rods; all lengths of a rod have the same scale factor"},
        {.name = "bearing",
         .member = &RodSupply::bearing,
         .choices = {"hull", "all"},
         .doc = "spheres of a rod that can touch base and lid: hull: those on its convex hull, as in exact contact; "
                "all: also those that overlaps bring into contact (contacts.law = \"pairwise\" or contacts.model = "
                "\"spring-dashpot\")"}};
    return rows;
}

namespace {
template <class Struct>
Row<Struct> coefficient(const char* name, double Struct::*member, const Range& range, const char* doc) {
    return {.name = name, .member = member, .range = range, .doc = doc};
}
}  // namespace

template <>
const std::vector<Row<Restitution>>& schema<Restitution>() {
    constexpr Range range{.min = 0.0, .max = 1.0};
    static const std::vector<Row<Restitution>> rows{
        coefficient("bead_bead", &Restitution::bead_bead, range,
                    "coefficient of restitution e of two beads: 0: no rebound, 1: no loss of energy"),
        coefficient("rod_bead", &Restitution::rod_bead, range, "e of a rod and a bead"),
        coefficient("rod_rod", &Restitution::rod_rod, range, "e of two rods"),
        coefficient("bead_plate", &Restitution::bead_plate, range, "e of a bead on base or lid"),
        coefficient("rod_plate", &Restitution::rod_plate, range, "e of a rod on base or lid"),
        coefficient("bead_wall", &Restitution::bead_wall, range, "e of a bead on a side wall"),
        coefficient("rod_wall", &Restitution::rod_wall, range, "e of a rod on a side wall")};
    return rows;
}

template <>
const std::vector<Row<Friction>>& schema<Friction>() {
    static const std::vector<Row<Friction>> rows{
        coefficient("bead_bead", &Friction::bead_bead, not_negative, "coefficient of Coulomb friction mu of two beads"),
        coefficient("rod_bead", &Friction::rod_bead, not_negative, "mu of a rod and a bead"),
        coefficient("rod_rod", &Friction::rod_rod, not_negative, "mu of two rods"),
        coefficient("bead_plate", &Friction::bead_plate, not_negative, "mu of a bead on base or lid"),
        coefficient("rod_plate", &Friction::rod_plate, not_negative, "mu of a rod on base or lid"),
        coefficient("bead_wall", &Friction::bead_wall, not_negative, "mu of a bead on a side wall"),
        coefficient("rod_wall", &Friction::rod_wall, not_negative, "mu of a rod on a side wall")};
    return rows;
}

template <>
const std::vector<Row<Kick>>& schema<Kick>() {
    static const std::vector<Row<Kick>> rows{
        {.name = "strength",
         .member = &Kick::strength,
         .unit = "rad/mm",
         .range = not_negative,
         .doc = "epsilon: an impact of a rod on base or lid with normal approach speed v changes its spin about z by "
                "+epsilon v or -epsilon v with equal probability"}};
    return rows;
}

template <>
const std::vector<Row<BodyForces>>& schema<BodyForces>() {
    constexpr const char* force = "mg mm/s^2";
    static const std::vector<Row<BodyForces>> rows{
        {.name = "bead_x", .member = &BodyForces::bead_x, .unit = force, .doc = "force on each bead, along x"},
        {.name = "bead_y", .member = &BodyForces::bead_y, .unit = force, .doc = "force on each bead, along y"},
        {.name = "rod_x", .member = &BodyForces::rod_x, .unit = force, .doc = "force on each rod, along x"},
        {.name = "rod_y", .member = &BodyForces::rod_y, .unit = force, .doc = "force on each rod, along y"},
        {.name = "torque",
         .member = &BodyForces::torque,
         .unit = "mg mm^2/s^2",
         .range = not_negative,
         .doc = "strength of the field h that orients rods by the torque n x h"},
        {.name = "angle", .member = &BodyForces::angle, .unit = "rad", .doc = "direction of the field h, from x"},
        {.name = "hold_beads",
         .member = &BodyForces::hold_beads,
         .doc = "whether an equal force on every bead keeps the mean velocity of the beads constant"},
        {.name = "bead_velocity_x",
         .member = &BodyForces::bead_velocity_x,
         .unit = "mm/s",
         .doc = "mean velocity that hold_beads keeps, along x"},
        {.name = "bead_velocity_y",
         .member = &BodyForces::bead_velocity_y,
         .unit = "mm/s",
         .doc = "mean velocity that hold_beads keeps, along y"},
        {.name = "held_waves",
         .member = &BodyForces::held_waves,
         .range = not_negative,
         .doc =
             "0: hold_beads keeps the mean velocity; k: it keeps the mode sin(2 pi k y/ly) of the flow, with amplitude "
             "bead_velocity_x, bead_velocity_y"},
        {.name = "push",
         .member = &BodyForces::push,
         .unit = force,
         .doc = "amplitude of the force push sin(2 pi push_waves x/lx) along x on each bead"},
        {.name = "push_waves",
         .member = &BodyForces::push_waves,
         .range = {.min = 1},
         .doc = "number of periods of push across the cell"}};
    return rows;
}

template <>
const std::vector<Row<ContactControl>>& schema<ContactControl>() {
    static const std::vector<Row<ContactControl>> rows{
        {.name = "model", .member = &ContactControl::model, .choices = contact_models(), .doc = contact_models_doc()},
        {.name = "law",
         .member = &ContactControl::law,
         .choices = {"simultaneous", "approaching-first", "first-to-last", "last-to-first", "pairwise"},
         .doc =
             "impulse: how contacts of one group share an impact: simultaneously, or one after another, starting with "
             "the fastest approach, the first or the last contact; pairwise: time steps without groups, in which each "
             "overlapping contact that approaches gets one impulse and overlaps are not corrected"},
        {.name = "restitution",
         .member = &ContactControl::restitution,
         .choices = {"energetic", "kinetic", "kinematic"},
         .doc =
             "impulse: definition of e: energetic: e^2 is the ratio of the work of restitution to that of compression "
             "(Stronge); kinetic: of the impulses (Poisson); kinematic: of the velocities (Newton), which can create "
             "energy where the slip turns"},
        {.name = "track_slip",
         .member = &ContactControl::track_slip,
         .doc = "impulse: whether friction follows the slip through the impact; false: it keeps its initial direction"},
        {.name = "increments",
         .member = &ContactControl::increments,
         .range = {.min = 1, .max = 100000},
         .doc = "impulse: number of increments of the impact of a group; those of a single contact follow their error"},
        {.name = "inelastic_threshold",
         .member = &ContactControl::inelastic_threshold,
         .range = {.min = 0.0, .max = 1.0},
         .doc = "impulse: approaches in a group of contacts slower than this times 1 - e of its fastest end without "
                "rebound; 0: none do"},
        {.name = "substep",
         .member = &ContactControl::substep,
         .unit = "s",
         .range = positive,
         .doc = "impulse: minimum time between two impacts of a rod on the plates; faster ones are merged"},
        {.name = "simultaneity_gap",
         .member = &ContactControl::simultaneity_gap,
         .unit = "mm",
         .range = not_negative,
         .doc = "impulse: contacts of a body with smaller gaps act in one impact"},
        {.name = "order",
         .member = &ContactControl::order,
         .choices = {"tail-first", "random", "fastest-first"},
         .doc = "pairwise: order of the contacts of a rod with the plates within a step"},
        {.name = "friction",
         .member = &ContactControl::friction,
         .choices = {"stop-or-slide", "decoupled"},
         .doc = "pairwise: friction of a contact: stop-or-slide: it stops the slip if mu allows, otherwise it opposes "
                "the slip before, both with a normal velocity of -e times that before; decoupled: the normal impulse "
                "is that without friction, and friction opposes the slip before, up to mu times the normal impulse"},
        {.name = "rod_step",
         .member = &ContactControl::rod_step,
         .unit = "s",
         .range = positive,
         .doc =
             "pairwise: time step of rods and of their contacts with the plates; time.dt is divided into equal steps "
             "of at most this"},
        {.name = "stiffness",
         .member = &ContactControl::stiffness,
         .unit = "mg/s^2",
         .range = positive,
         .doc = "soft bodies: normal stiffness of all contacts; a larger one needs a smaller time.dt"},
        {.name = "tangential_stiffness_ratio",
         .member = &ContactControl::tangential_stiffness_ratio,
         .range = positive,
         .doc = "soft bodies: tangential over normal stiffness; 2/7 gives both the same period in contacts of solid "
                "spheres"},
        {.name = "skin",
         .member = &ContactControl::skin,
         .unit = "mm",
         .range = positive,
         .doc = "margin of the neighbour list; affects the speed of a run, not its physics"},
        {.name = "max_overlap",
         .member = &ContactControl::max_overlap,
         .range = {.min = 0.0, .max = 1.0, .min_open = true},
         .doc = "largest allowed overlap, relative to the smaller radius; a run with a larger one fails: dt is too "
                "long or "
                "contacts are too soft"}};
    return rows;
}

template <>
const std::vector<Row<Packing>>& schema<Packing>() {
    static const std::vector<Row<Packing>> rows{
        {.name = "kind",
         .member = &Packing::kind,
         .choices = {"random", "aligned", "file"},
         .doc = "initial bodies: random positions and directions; random positions with all rods along x; from a file"},
        {.name = "file", .member = &Packing::file, .doc = "file: an H5MD file of the same bodies"},
        {.name = "frame",
         .member = &Packing::frame,
         .range = {.min = -1},
         .doc = "file: index of its frame, from 0; -1: the last"}};
    return rows;
}

}  // namespace drover
