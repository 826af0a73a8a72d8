// app/explain_particles.cpp: drover explain SCENE for particles.
#include <cstdio>

#include "command.hpp"
#include "drover/dem/contact_law.hpp"
#include "drover/io/trajectory.hpp"
#include "drover/run/calibration.hpp"
#include "explain_cost.hpp"

namespace drover::app {

namespace {
std::string range_text(double min, double max) {
    return min == max ? text("{:.4g}", min) : text("{:.4g} to {:.4g}", min, max);
}

void print_supply(const char* name, const run::Supply& supply) {
    if (supply.count == 0) return;
    std::printf("  %zu %s: area fraction %.4g, length %s, mass %s, %zu shape%s\n", supply.count, name,
                supply.area_fraction, (range_text(supply.min_length, supply.max_length) + " mm").c_str(),
                (range_text(supply.min_mass, supply.max_mass) + " mg").c_str(), supply.shapes,
                supply.shapes == 1 ? "" : "s");
}
}  // namespace

void print_particles(const io::Scene& scene, const run::ParticleExplanation& e) {
    const dem::Setup& setup = scene.particles;
    const io::Box box = io::box_of(setup);
    std::printf("particles in a %s cell, %g by %g mm, area %.5g mm2\n", setup.cell.shape.c_str(), box.sides[0],
                box.sides[1], dem::area(setup.cell));
    std::printf("  %s, gap %g mm; vertical vibration: amplitude %g mm, frequency %g Hz, acceleration %.3g g\n",
                setup.plates.lid ? "base and lid" : "base without lid", setup.plates.gap, setup.plates.amplitude,
                setup.plates.frequency, e.acceleration);
    print_supply("beads", e.beads);
    print_supply("rods", e.rods);
    std::printf("  %zu spheres in total; packing: %s\n", e.spheres, setup.packing.kind.c_str());
    if (dem::PairwiseLaw::is_chosen(setup.contacts))
        std::printf("  contacts: %s, %s, %s friction, rod steps of at most %g s\n", setup.contacts.law.c_str(),
                    setup.contacts.order.c_str(), setup.contacts.friction.c_str(), setup.contacts.rod_step);
    else if (setup.contacts.model == "impulse")
        std::printf("  contacts: %s, restitution %s\n", setup.contacts.law.c_str(), setup.contacts.restitution.c_str());
    else std::printf("  contacts: %s\n", setup.contacts.model.c_str());
    std::printf("  %lld steps of dt = %g s, %.4g per vibration period\n", static_cast<long long>(e.cost.steps),
                scene.time.dt, e.steps_per_period);
    print_cost(scene, e.cost, "in a smaller cell");
    if (scene.calibration.bead_area_fractions.empty()) return;
    const run::CalibrationLayout layout = run::plan_calibration(scene);
    std::printf("drover calibrate: %zu measurements with %zu to %zu trials each\n", layout.units.size(),
                layout.goal.round * layout.goal.min_rounds,
                layout.goal.max_trials / layout.goal.round * layout.goal.round);
    for (const calibrate::Assay& assay : layout.assays)
        std::printf("  %-16s as a function of Phi_b%s\n", assay.name.c_str(),
                    assay.population == calibrate::Population::all ? " and Phi_r" : "");
}

}  // namespace drover::app
