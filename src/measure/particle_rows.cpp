// measure/particle_rows.cpp: the observables of rods and beads.
#include <cmath>
#include <utility>

#include "base/mapped.hpp"
#include "drover/base/text.hpp"
#include "measure/particles.hpp"
#include "measure/shared_rows.hpp"

namespace drover::measure {

static MeanVector mean_direction(const ParticleMoment& moment) { return {moment.rods.order_x, moment.rods.order_y}; }
static MeanVector mean_velocity(const ParticleMoment& moment) {
    return {moment.beads.velocity_x, moment.beads.velocity_y};
}
static double mean_square_velocity(const ParticleMoment& moment) { return moment.beads.velocity_square; }

namespace {
constexpr const char* shared_order = "polar_order";  // as fields call it

using ParticleRows = Observables<ParticleMoment>;

const std::string at_one_phase = "; at one phase of the plates when samples are whole periods of the plates apart";

std::vector<double> bin_centres(const Bins& bins) {
    std::vector<double> values(bins.count);
    for (std::size_t i = 0; i < values.size(); ++i) values[i] = (static_cast<double>(i) + 0.5) * bins.width;
    return values;
}

auto beads(double BeadMeans::*mean) {
    return [mean](const ParticleMoment& moment) { return moment.beads.*mean; };
}
auto rods(double RodMeans::*mean) {
    return [mean](const ParticleMoment& moment) { return moment.rods.*mean; };
}
template <class Sum>
auto pairs(Sum PairSums::*sum) {
    return [sum](const ParticleMoment& moment) { return moment.pairs.*sum; };
}
auto work(double dem::EnergyBalance::*entry) {
    return [entry](const ParticleMoment& moment) { return moment.balance.*entry; };
}

void add_rod_order(const ParticleSetting& setting, ParticleRows& rows) {
    add(rows, "rod_direction_mean_x", "1", "mean over the rods of n_x", rods(&RodMeans::order_x));
    add(rows, "rod_direction_mean_y", "1", "mean over the rods of n_y", rods(&RodMeans::order_y));
    add(
        rows, "polar_order_direction", "rad", "direction of <n> from x, -pi to pi",
        [](const ParticleMoment& moment) { return std::atan2(moment.rods.order_y, moment.rods.order_x); },
        Averaging::direction);
    add(rows, "nematic_order", "1", "|<exp(2 i theta)>|, theta the direction of n of each rod",
        rods(&RodMeans::order_nematic));
    if (!setting.round) return;
    add(rows, "polar_order_local", "1",
        "polar order in the polar frame about the origin, |(<n_radial>, <n_azimuthal>)|",
        [](const ParticleMoment& moment) { return std::hypot(moment.rods.order_radial, moment.rods.order_azimuthal); });
    add(rows, "polar_order_radial", "1", "mean over the rods of the component of n away from the origin",
        rods(&RodMeans::order_radial));
    add(rows, "polar_order_azimuthal", "1",
        "mean over the rods of the component of n around the origin, counter-clockwise > 0: minus the n x r of the "
        "seed paper",
        rods(&RodMeans::order_azimuthal));
}

void add_rod_motion(const ParticleSetting& setting, ParticleRows& rows) {
    add(rows, "rod_velocity_along", "mm s-1",
        "mean over the rods of the velocity of each along its n, in the plane" + at_one_phase,
        rods(&RodMeans::velocity_along));
    add(rows, "rod_velocity_along_deviation", "mm s-1",
        "standard deviation among the rods of the velocity of each along its n" + at_one_phase,
        rods(&RodMeans::velocity_along_deviation));
    add(rows, "rod_velocity_mean_x", "mm s-1", "mean velocity of the rods along x", rods(&RodMeans::velocity_x));
    add(rows, "rod_velocity_mean_y", "mm s-1", "mean velocity of the rods along y", rods(&RodMeans::velocity_y));
    add(rows, "rod_temperature_horizontal", "mg mm2 s-2",
        "granular temperature of the rods in the plane: mean of m |v - <v>|^2/2; includes their self-propulsion "
        "along n",
        rods(&RodMeans::temperature_horizontal));
    add(rows, "rod_temperature_vertical", "mg mm2 s-2", "mean over the rods of m (v_z - <v_z>)^2" + at_one_phase,
        rods(&RodMeans::temperature_vertical));
    add(rows, "rod_temperature_turning", "mg mm2 s-2",
        "mean of I omega_z^2 of the rods, I about an axis perpendicular to n" + at_one_phase,
        rods(&RodMeans::temperature_turning));
    add(rows, "rod_height", "mm", "mean height of the centres of mass of the rods" + at_one_phase,
        rods(&RodMeans::height));
    add(rows, "rod_pitch", "1", "mean of n_z over the rods: > 0 where heads are above tails" + at_one_phase,
        [](const ParticleMoment& moment) {
            double sum = 0.0;
            for (const dem::Rod& rod : moment.bodies.rods) sum += rod.axis.z;
            return sum / static_cast<double>(moment.bodies.rods.size());
        });
    add(rows, "rod_tilt", "1", "root mean square of n_z over the rods" + at_one_phase, rods(&RodMeans::tilt));
    if (!setting.round) return;
    add(rows, "rod_velocity_azimuthal", "mm s-1", "mean velocity of the rods around the origin, counter-clockwise > 0",
        rods(&RodMeans::velocity_azimuthal));
    add(rows, "rod_velocity_radial", "mm s-1", "mean velocity of the rods away from the origin",
        rods(&RodMeans::velocity_radial));
}

/// Component of the mean velocity of the beads along the mean direction of the rods; 0 when that is zero.
double velocity_along_order(const ParticleMoment& moment) {
    const double size = std::hypot(moment.rods.order_x, moment.rods.order_y);
    const BeadMeans& v = moment.beads;
    return size > 0.0 ? (v.velocity_x * moment.rods.order_x + v.velocity_y * moment.rods.order_y) / size : 0.0;
}

void add_bead_motion(const ParticleSetting& setting, ParticleRows& rows) {
    add(rows, "bead_velocity_size", "mm s-1", "magnitude of the mean velocity of the beads in the plane, |<v>|",
        [](const ParticleMoment& moment) { return std::hypot(moment.beads.velocity_x, moment.beads.velocity_y); });
    add(rows, "bead_direction_order", "1", "|<v/|v|>|: order of the directions of the bead velocities in the plane",
        [](const ParticleMoment& moment) { return std::hypot(moment.beads.direction_x, moment.beads.direction_y); });
    if (setting.rods > 0)
        add(rows, "bead_velocity_along_order", "mm s-1",
            "mean velocity of the beads along the mean n of the rods; 0 when the mean n is zero", velocity_along_order);
    if (!setting.round) return;
    add(rows, "bead_velocity_azimuthal", "mm s-1",
        "mean velocity of the beads around the origin, counter-clockwise > 0", beads(&BeadMeans::velocity_azimuthal));
    add(rows, "bead_velocity_radial", "mm s-1", "mean velocity of the beads away from the origin",
        beads(&BeadMeans::velocity_radial));
    add(rows, "bead_direction_order_local", "1",
        "the bead velocity order of the seed paper: |<u>|, u = v/|v| in the polar frame about the origin",
        [](const ParticleMoment& moment) {
            return std::hypot(moment.beads.direction_radial, moment.beads.direction_azimuthal);
        });
}

void add_bead_state(const ParticleSetting& setting, ParticleRows& rows) {
    add(rows, "bead_temperature_horizontal", "mg mm2 s-2",
        "granular temperature of the beads in the plane, mean of m |v - <v>|^2/2, <v> over the whole cell",
        beads(&BeadMeans::temperature_horizontal));
    add(rows, "bead_temperature_vertical", "mg mm2 s-2", "mean over the beads of m (v_z - <v_z>)^2" + at_one_phase,
        beads(&BeadMeans::temperature_vertical));
    add(rows, "bead_height", "mm", "mean height of the centres of the beads" + at_one_phase, beads(&BeadMeans::height));
    add(rows, "hexatic_order", "1",
        "|<psi6>| over the beads, psi6 = <exp(6 i angle)> over the neighbours of a bead, 0 without any: beads "
        "nearer than 1.4 mean diameters in the plane",
        pairs(&PairSums::hexatic));
    add(rows, "hexatic_order_local", "1", "<|psi6|> over the beads", pairs(&PairSums::hexatic_local));
    add(rows, "bead_neighbours", "1", "mean number of beads nearer than 1.4 mean diameters in the plane",
        pairs(&PairSums::neighbours));
    if (setting.periodic && setting.bead_separations.count > 0)
        add(rows, "pair_correlation_beads", "1",
            {{"bead_separation", "mm", "distance of two beads in the plane, middle of the bin",
              bin_centres(setting.bead_separations)}},
            "pair correlation g(r) of the beads in the plane, relative to a uniform gas; around 8192 of them "
            "when there are more",
            pairs(&PairSums::bead_correlation));
}

void add_rod_pairs(const ParticleSetting& setting, ParticleRows& rows) {
    if (setting.rod_separations.count == 0) return;
    const std::string n = setting.round ? "(n_radial, n_azimuthal)" : "n";
    const Axis separations{"rod_separation", "mm",
                           "distance of the centres of mass of two rods in the plane, middle of the bin",
                           bin_centres(setting.rod_separations)};
    if (setting.periodic)
        add(rows, "pair_correlation_rods", "1", {separations},
            "pair correlation g(r) of the centres of mass of the rods in the plane, relative to a uniform gas",
            pairs(&PairSums::rod_correlation));
    add(rows, "rod_pairs", "1", {separations},
        "mean number of other rods at that separation from a rod; around 1024 of them when there are more",
        pairs(&PairSums::rod_pairs));
    add(rows, "rod_pairs_order", "1", {separations},
        "sum over these pairs of p_i.p_j, p = " + n + " in the plane, per rod", pairs(&PairSums::rod_pairs_order));
    add(rows, "rod_pairs_excess", "1", {separations},
        "sum over these pairs of p_i.p_j - |<p>|^2, <p> of the same moment, per rod",
        pairs(&PairSums::rod_pairs_excess));
}

void add_rod_flow(const ParticleSetting& setting, ParticleRows& rows) {
    if (setting.mesh == 0) return;
    std::vector<double> centres;
    for (int i = 0; i < setting.mesh; ++i) centres.push_back((i - 0.5 * (setting.mesh - 1)) * setting.mesh_width);
    const std::vector<Axis> axes{
        {"along_rod", "mm", "position relative to the centre of mass of a rod along its n, tail to head", centres},
        {"across_rod", "mm", "position relative to the centre of mass of a rod along its n turned by +90 degrees",
         centres}};
    const std::string frame = " in the frame of a rod, mean over the rods, 256 of them when there are more";
    add(rows, "flow_density", "mm-2", axes, "number density of beads" + frame, pairs(&PairSums::flow_density));
    add(rows, "flow_flux_along", "mm-1 s-1", axes,
        "density times velocity of the beads, relative to the plates, along n" + frame, pairs(&PairSums::flow_along));
    add(rows, "flow_flux_across", "mm-1 s-1", axes,
        "density times velocity of the beads, relative to the plates, along n turned by +90 degrees" + frame,
        pairs(&PairSums::flow_across));
}

void add_numbers(const ParticleSetting& setting, ParticleRows& rows) {
    if (setting.boxes.empty()) return;
    const auto of = [](auto dem::Bodies::*bodies) {
        return [bodies](const ParticleMoment& moment) {
            const auto position = [](const auto& body) { return body.position; };
            return box_variances(moment.setting, mapped(moment.bodies.*bodies, position));
        };
    };
    const Axis sides = box_axis(setting.boxes, setting.cell.lx / setting.fine_x * (setting.cell.ly / setting.fine_y));
    if (setting.rods > 0) add_number_variance(rows, "rod", "", "square box", sides, of(&dem::Bodies::rods));
    if (setting.beads > 0) add_number_variance(rows, "bead", "", "square box", sides, of(&dem::Bodies::beads));
}

void add_energy(ParticleRows& rows) {
    const std::string unit = "mg mm2 s-2";
    add(rows, "energy_kinetic", unit, "kinetic energy of all bodies",
        [](const ParticleMoment& moment) { return moment.energy_kinetic; });
    add(rows, "energy_balance", unit,
        "kinetic energy less all work since the start: equals the kinetic energy at the start when the balance is "
        "complete",
        [](const ParticleMoment& moment) { return moment.energy_kinetic - dem::sum(moment.balance); });
    add(rows, "work_gravity", unit,
        "work of gravity and of the constant forces on bodies, forces.bead_x to forces.rod_y, since the start; without "
        "those forces minus the change of m g z (of the pairwise law less m a^2 h^2/2 in each step h of a body)",
        work(&dem::EnergyBalance::gravity), Averaging::rate);
    add(rows, "work_plates", unit,
        "work of base and lid since the start, and what bodies gain against gravity and forces where overlaps are "
        "removed",
        work(&dem::EnergyBalance::plates), Averaging::rate);
    add(rows, "work_forces", unit, "work of torques, push, hold_beads and edits by a program since the start",
        work(&dem::EnergyBalance::forces), Averaging::rate);
    add(rows, "work_kicks", unit, "work of the kicks since the start", work(&dem::EnergyBalance::kicks),
        Averaging::rate);
    add(rows, "work_impact", unit,
        "work of impacts along the normals since the start, <= 0 for the laws that create no energy",
        work(&dem::EnergyBalance::impact), Averaging::rate);
    add(rows, "work_friction", unit, "work of friction since the start, <= 0", work(&dem::EnergyBalance::friction),
        Averaging::rate);
}

/// Impacts since the start and the largest overlap.
void add_impact_counts(const ParticleSetting& setting, ParticleRows& rows) {
    const std::size_t beads = setting.beads, rods = setting.rods;
    const std::string pairs = text("; slower approaches than {} mm/s are not counted", dem::counted_speed);
    const std::string plates = text(
        "; approaches slower than (|g_z| + A omega^2)/(40 f), at least {} mm/s, are not counted: hops of a body "
        "that rests on a plate are slower for any time step up to 1/20 of a plate period",
        dem::counted_speed);
    const auto add_impacts = [&](const std::string& name, const std::string& of, std::size_t bodies,
                                 double bodies_per_impact, std::int64_t dem::Counts::*count,
                                 const std::string& left_out) {
        if (bodies == 0) return;
        const double per_body = bodies_per_impact / static_cast<double>(bodies);
        add(
            rows, "impacts_" + name, "1",
            "impacts since the start of a " + of + ", mean; their rate is the collision rate" + left_out,
            [per_body, count](const ParticleMoment& moment) {
                return per_body * static_cast<double>(moment.counts.*count);
            },
            Averaging::rate);
    };
    add_impacts("bead_bead", "bead with beads", beads, 2.0, &dem::Counts::bead_bead, pairs);
    if (beads > 0) add_impacts("rod_bead", "rod with beads", rods, 1.0, &dem::Counts::rod_bead, pairs);
    add_impacts("rod_rod", "rod with rods", rods, 2.0, &dem::Counts::rod_rod, pairs);
    add_impacts("bead_plate", "bead with base or lid", beads, 1.0, &dem::Counts::bead_plate, plates);
    add_impacts("rod_plate", "rod with base or lid", rods, 1.0, &dem::Counts::rod_plate, plates);
    if (!setting.periodic) {
        add_impacts("bead_wall", "bead with the side wall", beads, 1.0, &dem::Counts::bead_wall, pairs);
        add_impacts("rod_wall", "rod with the side wall", rods, 1.0, &dem::Counts::rod_wall, pairs);
    }
    add(
        rows, "impacts_unresolved", "1",
        "groups of contacts whose approach the group law did not end (its rest ended without rebound) since the start",
        [](const ParticleMoment& moment) { return static_cast<double>(moment.counts.unresolved); }, Averaging::rate);
    add(
        rows, "impacts_limited", "1",
        "pairwise law: impulses since the start whose friction was reduced, since they would have created energy",
        [](const ParticleMoment& moment) { return static_cast<double>(moment.counts.limited); }, Averaging::rate);
    add(
        rows, "overlap_largest", "1", "largest overlap of two bodies since the start, over the smaller radius",
        [](const ParticleMoment& moment) { return moment.counts.overlap; }, Averaging::maximum);
}

std::vector<Quotient> quotients(const ParticleSetting& setting) {
    std::vector<Quotient> rows;
    if (setting.rod_separations.count > 0) {
        rows.push_back({"polar_correlation_total", "1", "G_tot(r) = <p_i.p_j> over pairs of rods at separation r",
                        "rod_pairs_order", "rod_pairs"});
        rows.push_back({"polar_correlation", "1",
                        "G(r) = <p_i.p_j - P^2> over pairs of rods at separation r, P of the same moment",
                        "rod_pairs_excess", "rod_pairs"});
    }
    if (setting.mesh > 0) {
        rows.push_back({"flow_velocity_along", "mm s-1",
                        "mean velocity of the beads around a rod, relative to the plates, along n", "flow_flux_along",
                        "flow_density"});
        rows.push_back(
            {"flow_velocity_across", "mm s-1",
             "mean velocity of the beads around a rod, relative to the plates, along n turned by +90 degrees",
             "flow_flux_across", "flow_density"});
    }
    return rows;
}

}  // namespace

Observables<ParticleMoment> particle_observables(const ParticleSetting& setting) {
    ParticleRows rows;
    add_shared({.order = setting.rods > 0 ? shared_order : "", .flow = setting.beads > 0 ? "bead_velocity" : ""}, rows);
    if (setting.rods > 0) {
        add_rod_order(setting, rows);
        add_rod_motion(setting, rows);
    }
    if (setting.beads > 0) {
        add_bead_motion(setting, rows);
        add_bead_state(setting, rows);
    }
    add_rod_pairs(setting, rows);
    add_rod_flow(setting, rows);
    add_numbers(setting, rows);
    if (setting.beads + setting.rods > 0) {
        add_energy(rows);
        add_impact_counts(setting, rows);
    }
    std::erase_if(rows, [](const auto& row) { return size_of(row.axes) == 0; });
    return rows;
}

Recorded particle_recording(const ParticleSetting& setting, std::vector<RecordedSeries> series) {
    Recorded recorded{.series = std::move(series),
                      .area = dem::area(setting.cell),
                      .quotients = quotients(setting),
                      .orders = {shared_order}};
    for (const auto& [what, total] : {std::pair{"rod", setting.rods}, {"bead", setting.beads}})
        recorded.boxes.push_back({what, "", "square box", {static_cast<double>(total)}, setting.fractions});
    for (const char* name : {shared_order, "energy_kinetic"})
        if (const RecordedSeries* indicator = find_row(recorded.series, name))
            recorded.indicators.push_back(indicator->values);
    return recorded;
}

}  // namespace drover::measure
