// measure/particles_balance.cpp: rows of energies, work, impacts and overlaps.
#include <string>
#include <utility>

#include "measure/particles_boxes.hpp"
#include "measure/particles_rows.hpp"

namespace drover::measure {

namespace {

using Rows = ParticleRows;

void add_work(Rows& rows) {
    const auto row = [&](std::string name, std::string formula, double dem::EnergyBalance::*entry) {
        add_number(
            rows, std::move(name), "mg mm2 s-2", std::move(formula),
            [entry](const ParticleMoment& moment) { return moment.balance.*entry; }, true);
    };
    row("work_gravity", "work of gravity since the start", &dem::EnergyBalance::gravity);
    row("work_plates", "work of base and lid since the start", &dem::EnergyBalance::plates);
    row("work_forces", "work of the other forces on bodies since the start", &dem::EnergyBalance::forces);
    row("work_kicks", "work of the kicks since the start", &dem::EnergyBalance::kicks);
    row("work_impact", "work of impacts along the normals since the start, <= 0", &dem::EnergyBalance::impact);
    row("work_friction", "work of friction since the start, <= 0", &dem::EnergyBalance::friction);
}

/// Impacts of one kind since the start, each counted `shares` times, per body.
void add_impacts(Rows& rows, const std::string& what, const std::string& of, std::size_t bodies, double shares,
                 std::int64_t dem::Counts::*count) {
    if (bodies == 0) return;
    const double part = shares / static_cast<double>(bodies);
    add_number(
        rows, "impacts_" + what, "1", "impacts since the start of a " + of + ", mean; their rate is the collision rate",
        [part, count](const ParticleMoment& moment) { return part * static_cast<double>(moment.counts.*count); }, true);
}

}  // namespace

void add_balance(const ParticleSetting& setting, Rows& rows) {
    if (setting.beads + setting.rods == 0) return;
    const std::size_t beads = setting.beads, rods = setting.rods;
    add_number(
        rows, "energy_kinetic", "mg mm2 s-2", "kinetic energy of all bodies",
        [](const ParticleMoment& moment) { return moment.energy_kinetic; }, false);
    add_number(
        rows, "energy_balance", "mg mm2 s-2",
        "kinetic energy less all work since the start: the kinetic energy at the start, when none is lost or made in "
        "the reckoning",
        [](const ParticleMoment& moment) { return moment.energy_kinetic - dem::sum(moment.balance); }, false);
    add_work(rows);
    add_impacts(rows, "bead_bead", "bead with beads", beads, 2.0, &dem::Counts::bead_bead);
    if (beads > 0) add_impacts(rows, "rod_bead", "rod with beads", rods, 1.0, &dem::Counts::rod_bead);
    add_impacts(rows, "rod_rod", "rod with rods", rods, 2.0, &dem::Counts::rod_rod);
    add_impacts(rows, "bead_plate", "bead with base or lid", beads, 1.0, &dem::Counts::bead_plate);
    add_impacts(rows, "rod_plate", "rod with base or lid", rods, 1.0, &dem::Counts::rod_plate);
    if (!setting.periodic) {
        add_impacts(rows, "bead_wall", "bead with the side wall", beads, 1.0, &dem::Counts::bead_wall);
        add_impacts(rows, "rod_wall", "rod with the side wall", rods, 1.0, &dem::Counts::rod_wall);
    }
    add_number(
        rows, "impacts_unresolved", "1", "groups of contacts left with an approach above the tolerance since the start",
        [](const ParticleMoment& moment) { return static_cast<double>(moment.counts.unresolved); }, true);
    add_number(
        rows, "overlap_largest", "1", "largest overlap of two bodies since the start, beside the smaller radius",
        [](const ParticleMoment& moment) { return moment.counts.overlap; }, false);
}

}  // namespace drover::measure
