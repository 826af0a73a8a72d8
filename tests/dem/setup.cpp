// tests/dem/setup.cpp: invalid parameters of a particle world, each rejected at its key.
#include "drover/dem/setup.hpp"

#include <gtest/gtest.h>

#include <functional>

#include "dem/packing_support.hpp"

namespace drover::dem::setup_tests {
namespace {

/// The message of check(), whose locations are the keys.
std::string rejection(const dem::Setup& setup) {
    try {
        check(setup, [](const std::string& key) { return SourceLocation{.file = "at " + key}; });
    } catch (const Error& error) {
        EXPECT_EQ(error.fault(), Fault::input);
        return error.what();
    }
    return "accepted";
}

std::string rejection(const std::function<void(dem::Setup&)>& change) {
    auto setup = mixture(45.0, 0.6, 0.11);
    change(setup);
    return rejection(setup);
}

#define EXPECT_REJECTED(change, words)                                                  \
    do {                                                                                \
        const std::string message = rejection([](dem::Setup& s) { change; });           \
        EXPECT_EQ(message.substr(0, std::string_view(words).size()), words) << message; \
    } while (false)

TEST(Setup, of_the_paper_and_the_default_are_accepted) {
    EXPECT_EQ(rejection(mixture(247.95, 0.6, 0.11)), "accepted");
    EXPECT_EQ(rejection(dem::Setup{}), "accepted");
    EXPECT_EQ(rejection([](dem::Setup& s) { s.cell.shape = CellShape::flower; }), "accepted");
    EXPECT_EQ(rejection([](dem::Setup& s) { s.plates.amplitude = 0.0; }), "accepted");
}

TEST(Setup, made_in_code_with_a_value_out_of_range_is_rejected) {
    EXPECT_REJECTED(s.cell.lx = -1.0, "at cell.lx: cell.lx = -1.0; expected ");
    EXPECT_REJECTED(s.restitution.bead_bead = 1.1, "at restitution.bead_bead: restitution.bead_bead = 1.1; expected ");
    EXPECT_REJECTED(s.friction.rod_wall = -0.1, "at friction.rod_wall: friction.rod_wall = -0.1; expected ");
    EXPECT_REJECTED(s.plates.gap = std::nan(""), "at plates.gap: plates.gap = nan; expected ");
    EXPECT_REJECTED(s.contacts.increments = 0, "at contacts.increments: contacts.increments = 0; expected ");
    EXPECT_REJECTED(s.packing.frame = -2, "at packing.frame: packing.frame = -2; expected ");
}

TEST(Setup, with_a_key_of_what_is_not_there_is_rejected) {
    EXPECT_REJECTED(s.forces.push_waves = 2,
                    "at forces.push_waves: forces.push_waves = 2 has no effect with forces.push = 0; expected its "
                    "default, 1, or a forces.push other than 0");
    EXPECT_REJECTED(s.forces.angle = 0.5, "at forces.angle: forces.angle = 0.5 has no effect");
    EXPECT_REJECTED(s.packing.frame = 3, "at packing.frame: packing.frame = 3 has no effect with packing.kind");
}

TEST(Setup, with_force_waves_in_a_cell_that_is_not_periodic_is_rejected) {
    EXPECT_REJECTED((s.cell.shape = CellShape::circle, s.forces.push = 1.0),
                    "at forces.push: forces.push asks for waves in a cell of shape \"circle\"; expected \"periodic\"");
    EXPECT_REJECTED((s.cell.shape = CellShape::rectangle, s.forces.hold_beads = true, s.forces.held_waves = 2),
                    "at forces.held_waves: forces.held_waves asks for waves");
    EXPECT_REJECTED(s.forces.push_waves = 0, "at forces.push_waves: forces.push_waves = 0; expected ");
}

TEST(Setup, with_a_cell_too_small_for_its_bodies_is_rejected) {
    EXPECT_REJECTED((s.cell.lx = 2.6, s.cell.ly = 900.0),
                    "at cell.lx: cell.lx = 2.6 mm; expected more than 2.7 mm, twice");
    EXPECT_REJECTED((s.cell.ly = 4.4, s.cell.lx = 900.0),
                    "at cell.ly: cell.ly = 4.4 mm; expected at least 4.5 mm, the length");
    EXPECT_REJECTED((s.cell.shape = CellShape::circle, s.cell.radius = 2.2, s.rods.area_fraction = 0.0,
                     s.rods.count = 1),
                    "at cell.radius: cell.radius = 2.2 mm, with bodies 4.5 mm long; expected more");
    EXPECT_REJECTED((s.cell.shape = CellShape::rectangle, s.cell.lx = 1.1),
                    "at cell.lx: cell.lx = 1.1 mm between walls, with bodies 1.1 mm thick; expected more");
    EXPECT_REJECTED((s.cell.shape = CellShape::rectangle, s.cell.lx = 4.0, s.packing.kind = PackingKind::aligned),
                    "at cell.lx: cell.lx = 4 mm, with bodies 4.5 mm long, aligned with x; expected more");
    EXPECT_REJECTED((s.cell.shape = CellShape::flower, s.cell.petal_radius = 9.5),
                    "at cell.petal_radius: cell.petal_radius = 9.5 mm does not span the 19.1342 mm between two inner");
    EXPECT_REJECTED(s.plates.gap = 1.1,
                    "at plates.gap: plates.gap = 1.1 mm, with bodies 1.1 mm thick; expected a larger gap");
}

TEST(Setup, with_inconsistent_numbers_of_bodies_is_rejected) {
    EXPECT_REJECTED(s.beads.count = 10, "at beads.count: beads.count = 10 and beads.area_fraction = 0.6; expected one");
    EXPECT_REJECTED(s.rods.count = 10, "at rods.count: rods.count = 10 and rods.area_fraction = 0.11; expected one");
    EXPECT_REJECTED(s.rods.area_fraction = 0.0009,
                    "at rods.area_fraction: rods.area_fraction = 0.0009 is less than half");
    EXPECT_REJECTED(s.beads.diameters = {0.001}, "at beads.area_fraction: beads.area_fraction = 0.6 asks for 1.55e+09");
    EXPECT_REJECTED(s.beads.area_fraction = 0.9,
                    "at beads.area_fraction: beads cover 0.9001 and rods 0.1098 of the cell");
    EXPECT_REJECTED((s.beads.area_fraction = 0.0, s.forces.hold_beads = true), "at forces.hold_beads: ");
    EXPECT_REJECTED(s.forces.bead_velocity_x = 2.0,
                    "at forces.bead_velocity_x: forces.bead_velocity_x = 2 has no effect");
    EXPECT_REJECTED(s.cell.radius = 30.0,
                    "at cell.radius: cell.radius = 30.0 has no effect with cell.shape = \"periodic\"");
    EXPECT_REJECTED(s.cell.petals = 6, "at cell.petals: cell.petals = 6 has no effect with cell.shape = \"periodic\"");
    EXPECT_REJECTED(s.forces.held_waves = 1, "at forces.held_waves: forces.held_waves = 1 has no effect");
}

TEST(Setup, with_lists_of_different_length_is_rejected) {
    EXPECT_REJECTED(s.beads.proportions = {},
                    "at beads.proportions: beads.proportions has 0 numbers beside 1 of beads.diameters");
    EXPECT_REJECTED(s.beads.diameters = {}, "at beads.diameters: beads.diameters is empty");
    EXPECT_REJECTED(s.beads.proportions = {0.0}, "at beads.proportions: beads.proportions sum to 0; expected");
    EXPECT_REJECTED(s.rods.diameters = {}, "at rods.diameters: rods.diameters is empty");
    EXPECT_REJECTED((s.rods.densities = {8.7, 1.0}),
                    "at rods.densities: rods.densities has 2 numbers beside 13 of rods.diameters");
    EXPECT_REJECTED(s.rods.densities = {0.0}, "at rods.densities: rods.densities holds no number above 0");
    EXPECT_REJECTED(s.rods.length = 0.9, "at rods.length: a rod 0.9 mm long");
}

TEST(Setup, with_a_plate_substep_too_long_for_the_vibration_is_rejected) {
    EXPECT_REJECTED(s.contacts.substep = 1e-3,
                    "at contacts.substep: contacts.substep = 0.001 s with plates.frequency = 200");
}

TEST(Setup, with_a_key_of_contacts_that_its_law_does_not_read_is_rejected) {
    EXPECT_REJECTED((s.contacts.law = GroupLaw::pairwise, s.contacts.track_slip = false),
                    "at contacts.track_slip: contacts.track_slip = false has no effect with contacts.law = "
                    "\"pairwise\"; expected its default, true, or a contacts.law with groups");
    EXPECT_EQ(rejection([](dem::Setup& s) { s.contacts.track_slip = false; }), "accepted");  // of single contacts
    EXPECT_REJECTED((s.contacts.law = GroupLaw::first_to_last, s.contacts.track_slip = false,
                     s.contacts.restitution = RestitutionKind::kinetic),
                    "at contacts.restitution: contacts.restitution = \"kinetic\" has no effect with "
                    "contacts.track_slip = false; expected its default, \"energetic\", or ");
    EXPECT_REJECTED(
        (s.contacts.law = GroupLaw::pairwise, s.contacts.simultaneity_gap = 1e-4),
        "at contacts.simultaneity_gap: contacts.simultaneity_gap = 0.0001 has no effect with contacts.law = "
        "\"pairwise\"; expected its default, ");
    EXPECT_REJECTED(s.contacts.rod_step = 1e-6,
                    "at contacts.rod_step: contacts.rod_step = 1e-06 has no effect with contacts.law = "
                    "\"simultaneous\"; expected its default, 2e-06, or contacts.law = \"pairwise\"");
    for (const char* key : {"track_slip", "restitution", "increments", "inelastic_threshold", "substep"}) {
        const std::string message = rejection([&](dem::Setup& s) {
            s.contacts.law = GroupLaw::pairwise;
            const std::string name = key;
            if (name == "track_slip") s.contacts.track_slip = false;
            if (name == "restitution") s.contacts.restitution = RestitutionKind::kinematic;
            if (name == "increments") s.contacts.increments = 9;
            if (name == "inelastic_threshold") s.contacts.inelastic_threshold = 0.0;
            if (name == "substep") s.contacts.substep = 1e-5;
        });
        EXPECT_NE(message.find(std::string(key) + " = "), std::string::npos) << message;
    }
    EXPECT_REJECTED((s.contacts.model = ContactModel::spring_dashpot, s.contacts.law = GroupLaw::pairwise),
                    "at contacts.law: contacts.law = \"pairwise\" has no effect with contacts.model = "
                    "\"spring-dashpot\"; expected its default, \"simultaneous\", or contacts.model = \"impulse\"");
    EXPECT_REJECTED(s.contacts.stiffness = 1e9,
                    "at contacts.stiffness: contacts.stiffness = 1000000000.0 has no effect");
    EXPECT_EQ(rejection([](dem::Setup& s) { s.contacts.law = GroupLaw::first_to_last, s.contacts.track_slip = false; }),
              "accepted");
    EXPECT_EQ(rejection([](dem::Setup& s) {
                  s.contacts.law = GroupLaw::pairwise, s.contacts.order = ContactOrder::random,
                  s.contacts.friction = PairwiseFriction::decoupled, s.contacts.rod_step = 1e-6,
                  s.rods.bearing = Bearing::all;
              }),
              "accepted");
}

TEST(Setup, with_spheres_that_bear_only_in_an_overlap_is_rejected_where_bodies_do_not_overlap_plates) {
    EXPECT_REJECTED(s.rods.bearing = Bearing::all,
                    "at rods.bearing: rods.bearing = \"all\" has no effect with contacts.law = \"simultaneous\"");
    EXPECT_EQ(rejection([](dem::Setup& s) {
                  s.rods.bearing = Bearing::all, s.contacts.model = ContactModel::spring_dashpot;
              }),
              "accepted");
}

TEST(Setup, with_a_rod_step_too_long_for_the_vibration_is_rejected) {
    EXPECT_REJECTED((s.contacts.law = GroupLaw::pairwise, s.contacts.rod_step = 1e-3),
                    "at contacts.rod_step: contacts.rod_step = 0.001 s with plates.frequency = 200");
}

TEST(Setup, with_a_missing_or_unused_packing_file_is_rejected) {
    EXPECT_REJECTED(s.packing.kind = PackingKind::file,
                    "at packing.kind: packing.kind = \"file\" without packing.file; name");
    EXPECT_REJECTED(s.packing.file = "start.h5",
                    "at packing.file: packing.file is given with packing.kind = \"random\"");
}

/// Every key has a doc string; check_rows checks that its default is in its range.
template <class Struct>
void expect_rows(std::size_t count) {
    const std::vector<Description> rows = descriptions<Struct>();
    EXPECT_EQ(rows.size(), count);
    for (const Description& row : rows) EXPECT_FALSE(row.doc.empty()) << row.name;
}

TEST(Setup, has_a_row_for_each_of_its_members) {
    expect_rows<Cell>(6);
    expect_rows<Plates>(4);
    expect_rows<Gravity>(3);
    expect_rows<BeadSupply>(5);
    expect_rows<RodSupply>(7);
    expect_rows<Restitution>(7);
    expect_rows<Friction>(7);
    expect_rows<Kick>(1);
    expect_rows<BodyForces>(12);
    expect_rows<ContactControl>(15);
    expect_rows<Packing>(3);
}

}  // namespace
}  // namespace drover::dem::setup_tests
