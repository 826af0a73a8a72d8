// measure/particles.cpp: the rows of what is measured on rods and beads.
#include "drover/measure/particles.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "drover/base/text.hpp"
#include "measure/particles_boxes.hpp"
#include "measure/particles_rows.hpp"

namespace drover::measure {

namespace {

using Rows = ParticleRows;
using Sums = std::vector<double> PairSums::*;

const std::string moment_only = "; at one phase of the plates when samples are a whole number of their periods apart";

void add_over(Rows& rows, std::string name, std::string unit, std::vector<ParticleAxis> axes, std::string formula,
              Sums sums) {
    rows.push_back({.name = std::move(name),
                    .unit = std::move(unit),
                    .axes = std::move(axes),
                    .formula = std::move(formula),
                    .measure = [sums](const ParticleMoment& moment, std::span<double> out) {
                        std::copy((moment.pairs.*sums).begin(), (moment.pairs.*sums).end(), out.begin());
                    }});
}

void add_beads(Rows& rows, std::string name, std::string unit, std::string formula, double BeadMeans::*mean) {
    add_number(rows, std::move(name), std::move(unit), std::move(formula),
               [mean](const ParticleMoment& moment) { return moment.beads.*mean; });
}

void add_rods(Rows& rows, std::string name, std::string unit, std::string formula, double RodMeans::*mean) {
    add_number(rows, std::move(name), std::move(unit), std::move(formula),
               [mean](const ParticleMoment& moment) { return moment.rods.*mean; });
}

double order_size(const RodMeans& rods) { return std::hypot(rods.order_x, rods.order_y); }

void add_order(const ParticleSetting& setting, Rows& rows) {
    add_number(rows, "polar_order", "1",
               "polar order P = |<n>|, n of each rod from tail to head, of length 1 in the plane",
               [](const ParticleMoment& moment) { return order_size(moment.rods); });
    add_rods(rows, "polar_order_x", "1", "mean of n_x over the rods", &RodMeans::order_x);
    add_rods(rows, "polar_order_y", "1", "mean of n_y over the rods", &RodMeans::order_y);
    add_number(rows, "polar_order_direction", "rad", "direction of <n> from x, -pi to pi",
               [](const ParticleMoment& moment) { return std::atan2(moment.rods.order_y, moment.rods.order_x); });
    add_rods(rows, "nematic_order", "1", "|<exp(2 i theta)>|, theta the direction of n of each rod",
             &RodMeans::order_nematic);
    if (!setting.round) return;
    add_number(rows, "polar_order_local", "1",
               "polar order in the local polar frame about the origin, |(<n_radial>, <n_azimuthal>)|",
               [](const ParticleMoment& moment) {
                   return std::hypot(moment.rods.order_radial, moment.rods.order_azimuthal);
               });
    add_rods(rows, "polar_order_radial", "1", "mean over the rods of the part of n away from the origin",
             &RodMeans::order_radial);
    add_rods(rows, "polar_order_azimuthal", "1",
             "mean over the rods of the part of n around the origin, counter-clockwise > 0: minus the n x r of the "
             "seed paper",
             &RodMeans::order_azimuthal);
}

void add_rod_motion(const ParticleSetting& setting, Rows& rows) {
    add_rods(rows, "rod_velocity_along", "mm s-1",
             "mean over the rods of the velocity of each along its own n, in the plane" + moment_only,
             &RodMeans::velocity_along);
    add_rods(rows, "rod_velocity_along_deviation", "mm s-1",
             "standard deviation among the rods of the velocity of each along its own n" + moment_only,
             &RodMeans::velocity_along_deviation);
    add_rods(rows, "rod_velocity_x", "mm s-1", "mean velocity of the rods along x", &RodMeans::velocity_x);
    add_rods(rows, "rod_velocity_y", "mm s-1", "mean velocity of the rods along y", &RodMeans::velocity_y);
    add_rods(
        rows, "rod_temperature_horizontal", "mg mm2 s-2",
        "granular temperature of the rods in the plane: mean of m |v - <v>|^2/2; their own motion along n is in it",
        &RodMeans::temperature_horizontal);
    add_rods(rows, "rod_temperature_vertical", "mg mm2 s-2", "the same, m (v_z - <v_z>)^2" + moment_only,
             &RodMeans::temperature_vertical);
    add_rods(rows, "rod_temperature_turning", "mg mm2 s-2",
             "mean of I omega_z^2 of the rods, I about an axis across n" + moment_only, &RodMeans::temperature_turning);
    add_rods(rows, "rod_height", "mm", "mean height of the centres of mass of the rods" + moment_only,
             &RodMeans::height);
    add_rods(rows, "rod_tilt", "1", "root of the mean of n_z^2 over the rods" + moment_only, &RodMeans::tilt);
    if (!setting.round) return;
    add_rods(rows, "rod_velocity_azimuthal", "mm s-1",
             "mean velocity of the rods around the origin, counter-clockwise > 0", &RodMeans::velocity_azimuthal);
    add_rods(rows, "rod_velocity_radial", "mm s-1", "mean velocity of the rods away from the origin",
             &RodMeans::velocity_radial);
}

void add_bead_flow(const ParticleSetting& setting, Rows& rows) {
    add_beads(rows, "bead_velocity_x", "mm s-1", "mean velocity of the beads along x", &BeadMeans::velocity_x);
    add_beads(rows, "bead_velocity_y", "mm s-1", "mean velocity of the beads along y", &BeadMeans::velocity_y);
    add_number(rows, "bead_velocity_size", "mm s-1", "size of the mean velocity of the beads in the plane, |<v>|",
               [](const ParticleMoment& moment) {
                   return std::hypot(moment.beads.velocity_x, moment.beads.velocity_y);
               });
    add_beads(rows, "bead_speed", "mm s-1", "mean over the beads of |v| in the plane", &BeadMeans::speed);
    add_number(rows, "bead_velocity_order", "1",
               "order of the bead velocity, |<v>|/<|v|> in the plane; 0 when all are at rest",
               [](const ParticleMoment& moment) {
                   const BeadMeans& beads = moment.beads;
                   return beads.speed > 0.0 ? std::hypot(beads.velocity_x, beads.velocity_y) / beads.speed : 0.0;
               });
    add_number(rows, "bead_direction_order", "1",
               "|<v/|v|>|: order of the directions of the bead velocities in the plane",
               [](const ParticleMoment& moment) {
                   return std::hypot(moment.beads.direction_x, moment.beads.direction_y);
               });
    if (setting.rods > 0)
        add_number(rows, "bead_velocity_along_order", "mm s-1",
                   "mean velocity of the beads along the mean n of the rods; 0 when that has no direction",
                   [](const ParticleMoment& moment) {
                       const double size = order_size(moment.rods);
                       return size > 0.0 ? (moment.beads.velocity_x * moment.rods.order_x +
                                            moment.beads.velocity_y * moment.rods.order_y) /
                                               size
                                         : 0.0;
                   });
    if (!setting.round) return;
    add_beads(rows, "bead_velocity_azimuthal", "mm s-1",
              "mean velocity of the beads around the origin, counter-clockwise > 0", &BeadMeans::velocity_azimuthal);
    add_beads(rows, "bead_velocity_radial", "mm s-1", "mean velocity of the beads away from the origin",
              &BeadMeans::velocity_radial);
    add_number(rows, "bead_direction_order_local", "1",
               "the bead velocity order of the seed paper: |<u>|, u = v/|v| in the local polar frame about the origin",
               [](const ParticleMoment& moment) {
                   return std::hypot(moment.beads.direction_radial, moment.beads.direction_azimuthal);
               });
}

void add_bead_state(const ParticleSetting& setting, Rows& rows) {
    add_beads(rows, "bead_temperature_horizontal", "mg mm2 s-2",
              "granular temperature of the beads in the plane, mean of m |v - <v>|^2/2, <v> over the whole cell",
              &BeadMeans::temperature_horizontal);
    add_beads(rows, "bead_temperature_vertical", "mg mm2 s-2", "the same, m (v_z - <v_z>)^2" + moment_only,
              &BeadMeans::temperature_vertical);
    add_beads(rows, "bead_height", "mm", "mean height of the centres of the beads" + moment_only, &BeadMeans::height);
    add_number(
        rows, "hexatic_order", "1",
        "|<psi6>| over the beads, psi6 = <exp(6 i angle)> over the neighbours of a bead, 0 without any: beads nearer "
        "than 1.4 mean "
        "diameters in the plane",
        [](const ParticleMoment& moment) { return moment.pairs.hexatic; });
    add_number(rows, "hexatic_order_local", "1", "<|psi6|> over the beads",
               [](const ParticleMoment& moment) { return moment.pairs.hexatic_local; });
    add_number(rows, "bead_neighbours", "1", "mean number of beads nearer than 1.4 mean diameters in the plane",
               [](const ParticleMoment& moment) { return moment.pairs.neighbours; });
    if (setting.periodic && setting.bead_separations.count > 0)
        add_over(rows, "pair_correlation_beads", "1", {ParticleAxis::bead_separation},
                 "pair correlation g(r) of the beads in the plane, beside others at random; around 8192 of them when "
                 "there are more",
                 &PairSums::bead_correlation);
}

void add_pairs(const ParticleSetting& setting, Rows& rows) {
    if (setting.rod_separations.count == 0) return;
    const std::string n = setting.round ? "(n_radial, n_azimuthal)" : "n";
    if (setting.periodic)
        add_over(rows, "pair_correlation_rods", "1", {ParticleAxis::rod_separation},
                 "pair correlation g(r) of the centres of mass of the rods in the plane, beside others at random",
                 &PairSums::rod_correlation);
    add_over(rows, "rod_pairs", "1", {ParticleAxis::rod_separation},
             "mean number of other rods at that separation from a rod; around 1024 of them when there are more",
             &PairSums::rod_pairs);
    add_over(rows, "rod_pairs_order", "1", {ParticleAxis::rod_separation},
             "sum over these pairs of p_i.p_j, p = " + n + " in the plane, per rod", &PairSums::rod_pairs_order);
    add_over(rows, "rod_pairs_excess", "1", {ParticleAxis::rod_separation},
             "sum over these pairs of p_i.p_j - |<p>|^2, <p> of the same moment, per rod", &PairSums::rod_pairs_excess);
}

void add_flow(const ParticleSetting& setting, Rows& rows) {
    if (setting.mesh == 0) return;
    const std::vector axes{ParticleAxis::along, ParticleAxis::across};
    const std::string about = " in the frame of a rod, mean over the rods, 256 of them when there are more";
    add_over(rows, "flow_density", "mm-2", axes, "number density of beads" + about, &PairSums::flow_density);
    add_over(rows, "flow_flux_along", "mm-1 s-1", axes,
             "density times velocity of the beads, against the plates, along n" + about, &PairSums::flow_along);
    add_over(rows, "flow_flux_across", "mm-1 s-1", axes,
             "density times velocity of the beads, against the plates, along n turned by +90 degrees" + about,
             &PairSums::flow_across);
}

void add_numbers(const ParticleSetting& setting, Rows& rows) {
    if (setting.boxes.empty()) return;
    const std::string formula =
        " in a box, DN^2: over all positions of the box at one time; a box is a share of the cell, sides in the ratio "
        "of the cell's counting "
        "mesh, nearly square.  N (1 - part) for bodies at random";
    if (setting.rods > 0)
        rows.push_back({"rod_number_variance",
                        "1",
                        {ParticleAxis::box},
                        "variance of the number of rods" + formula,
                        [](const ParticleMoment& moment, std::span<double> out) {
                            box_variances(moment.setting, moment.bodies.rods, out);
                        }});
    if (setting.beads > 0)
        rows.push_back({"bead_number_variance",
                        "1",
                        {ParticleAxis::box},
                        "variance of the number of beads" + formula,
                        [](const ParticleMoment& moment, std::span<double> out) {
                            box_variances(moment.setting, moment.bodies.beads, out);
                        }});
}

}  // namespace

std::vector<ParticleObservable> particle_observables(const ParticleSetting& setting) {
    Rows rows;
    if (setting.rods > 0) {
        add_order(setting, rows);
        add_rod_motion(setting, rows);
    }
    if (setting.beads > 0) {
        add_bead_flow(setting, rows);
        add_bead_state(setting, rows);
    }
    add_pairs(setting, rows);
    add_flow(setting, rows);
    add_numbers(setting, rows);
    add_balance(setting, rows);
    return rows;
}

std::vector<ParticleQuotient> particle_quotients(const ParticleSetting& setting) {
    std::vector<ParticleQuotient> rows;
    if (setting.rod_separations.count > 0) {
        rows.push_back({"polar_correlation_total", "1", "G_tot(r) = <p_i.p_j> over pairs of rods at separation r",
                        "rod_pairs_order", "rod_pairs"});
        rows.push_back({"polar_correlation", "1",
                        "G(r) = <p_i.p_j - P^2> over pairs of rods at separation r, P of the same moment",
                        "rod_pairs_excess", "rod_pairs"});
    }
    if (setting.mesh > 0) {
        rows.push_back({"flow_velocity_along", "mm s-1",
                        "mean velocity of the beads around a rod, against the plates, along n", "flow_flux_along",
                        "flow_density"});
        rows.push_back({"flow_velocity_across", "mm s-1",
                        "mean velocity of the beads around a rod, against the plates, along n turned by +90 degrees",
                        "flow_flux_across", "flow_density"});
    }
    return rows;
}

}  // namespace drover::measure
