// measure/stub_particles.cpp: a stand-in for the observables of particles, to be deleted at merge.
#include <cmath>

#include "drover/measure/particles.hpp"

namespace drover::measure {

ParticleSetting make_particle_setting(const dem::Setup& setup, const dem::Bodies& at_start) {
    ParticleSetting setting;
    setting.cell = setup.cell;
    setting.beads = at_start.beads.size();
    setting.rods = at_start.rods.size();
    setting.rod_separations = {.width = 0.5, .count = 6};
    return setting;
}
BeadMeans bead_means(const ParticleSetting&, const dem::Bodies&) { return {}; }
RodMeans rod_means(const ParticleSetting&, const dem::Bodies& bodies) {
    RodMeans means;
    for (const dem::Rod& rod : bodies.rods) {
        means.order_x += rod.axis.x / static_cast<double>(bodies.rods.size());
        means.order_y += rod.axis.y / static_cast<double>(bodies.rods.size());
    }
    return means;
}
PairSums pair_sums(const ParticleSetting& setting, const dem::Bodies& bodies) {
    PairSums sums;
    sums.rod_pairs.assign(setting.rod_separations.count, static_cast<double>(bodies.rods.size()));
    return sums;
}

std::vector<ParticleObservable> particle_observables(const ParticleSetting& setting) {
    std::vector<ParticleObservable> rows{
        {"energy_kinetic", "mg mm2 s-2", {}, "kinetic energy", [](const ParticleMoment& moment, std::span<double> out) {
             out[0] = moment.energy_kinetic;
         }}};
    if (setting.rods == 0) return rows;
    rows.push_back({"polar_order", "1", {}, "|<n>|", [](const ParticleMoment& moment, std::span<double> out) {
                        out[0] = std::hypot(moment.rods.order_x, moment.rods.order_y);
                    }});
    rows.push_back({"impacts",
                    "1",
                    {},
                    "impacts of rods on plates since the start",
                    [](const ParticleMoment& moment, std::span<double> out) {
                        out[0] = static_cast<double>(moment.counts.rod_plate);
                    },
                    true});
    rows.push_back({"rod_pairs",
                    "1",
                    {ParticleAxis::rod_separation},
                    "pairs",
                    [](const ParticleMoment& moment, std::span<double> out) {
                        for (std::size_t i = 0; i < out.size(); ++i) out[i] = moment.pairs.rod_pairs[i];
                    }});
    rows.push_back({"rod_pairs_order",
                    "1",
                    {ParticleAxis::rod_separation},
                    "order of pairs",
                    [](const ParticleMoment& moment, std::span<double> out) {
                        for (std::size_t i = 0; i < out.size(); ++i)
                            out[i] = moment.pairs.rod_pairs[i] * moment.rods.order_x;
                    }});
    return rows;
}
std::vector<ParticleQuotient> particle_quotients(const ParticleSetting& setting) {
    if (setting.rods == 0) return {};
    return {{"rod_alignment", "1", "order of pairs over pairs", "rod_pairs_order", "rod_pairs"}};
}
std::vector<double> rates(std::span<const double> accumulated, double spacing) {
    std::vector<double> out;
    for (std::size_t i = 0; i + 1 < accumulated.size(); ++i)
        out.push_back((accumulated[i + 1] - accumulated[i]) / spacing);
    return out;
}
std::size_t size_of(ParticleAxis, const ParticleSetting& setting) { return setting.rod_separations.count; }
std::size_t size_of(const ParticleObservable& observable, const ParticleSetting& setting) {
    std::size_t size = 1;
    for (const ParticleAxis axis : observable.axes) size *= size_of(axis, setting);
    return size;
}
AxisValues axis_of(ParticleAxis, const ParticleSetting& setting) {
    AxisValues axis{"rod_separation", "mm", "distance of two rods", {}};
    for (std::size_t i = 0; i < setting.rod_separations.count; ++i)
        axis.values.push_back((static_cast<double>(i) + 0.5) * setting.rod_separations.width);
    return axis;
}

}  // namespace drover::measure
