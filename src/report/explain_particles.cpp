// report/explain_particles.cpp: what a scene of particles holds.
#include <algorithm>
#include <cmath>
#include <numbers>

#include "dem/contact/contact_law.hpp"
#include "io/trajectory.hpp"
#include "jobs/calibration/calibration_layout.hpp"
#include "report/shown.hpp"

namespace drover::report {

namespace {
/// Bodies of one kind: those that are used of the shapes in `bodies`.
template <class Body>
run::Record supply_of(const char* name, const std::vector<Body>& list, const dem::Bodies& bodies, double area) {
    std::vector<bool> is_used(bodies.shapes.size());
    double covered = 0.0;
    for (const Body& body : list) {
        is_used[body.shape] = true;
        covered += bodies.shapes[body.shape].projected_area;
    }
    std::vector<double> masses, lengths;
    for (std::size_t n = 0; n < is_used.size(); ++n) {
        if (!is_used[n]) continue;
        masses.push_back(bodies.shapes[n].mass);
        lengths.push_back(bodies.shapes[n].head - bodies.shapes[n].tail);
    }
    const auto range = [](const char* of, const char* unit, const std::vector<double>& values) {
        const auto [min, max] = std::ranges::minmax_element(values);
        return run::Entry{.name = of,
                          .unit = unit,
                          .meaning = "smallest and largest",
                          .value = values.empty() ? std::vector<double>{0.0, 0.0} : std::vector<double>{*min, *max},
                          .digits = 4};
    };
    return {.heading = text("{} {}", list.size(), name),
            .entries = {run::count("count", "bodies", list.size()),
                        run::number("area_fraction", "1", "area of their projections per area", covered / area, 4),
                        run::count("shapes", "different bodies", masses.size()), range("mass", "mg", masses),
                        range("length", "mm", lengths)},
            .shown = {.text = !list.empty()}};
}

std::vector<std::string> words_of_setup(const dem::Setup& setup) {
    const dem::Plates& plates = setup.plates;
    const dem::ContactControl& contacts = setup.contacts;
    return {text("{}, gap {} mm; vertical vibration: amplitude {} mm, frequency {} Hz",
                 plates.lid ? "base and lid" : "base without lid", plates.gap, plates.amplitude, plates.frequency),
            text("packing: {}", setup.packing.kind),
            dem::PairwiseLaw::is_chosen(contacts)
                ? text("contacts: {}, {}, {} friction, rod steps of at most {} s", contacts.law, contacts.order,
                       contacts.friction, contacts.rod_step)
            : contacts.model == dem::ContactModel::impulse
                ? text("contacts: {}, restitution {}", contacts.law, contacts.restitution)
                : text("contacts: {}", contacts.model)};
}

void add_calibration(const io::Scene& scene, run::Record& root) {
    if (scene.calibration.bead_area_fractions.empty()) return;
    const jobs::CalibrationLayout layout = jobs::plan_calibration(scene);
    run::List list{.name = "assays",
                   .heading = text("drover calibrate: {} measurements with {} to {} trials each", layout.units.size(),
                                   layout.goal.round * layout.goal.min_rounds,
                                   layout.goal.max_trials / layout.goal.round * layout.goal.round),
                   .row = "assay"};
    for (const calibrate::Assay& assay : layout.assays)
        list.rows.push_back(
            {.entries = {run::words("name", "what it measures", assay.name),
                         run::words("depends_on", "area fractions",
                                    assay.population == calibrate::Population::all ? "Phi_b and Phi_r" : "Phi_b")}});
    root.lists.push_back(std::move(list));
}
}  // namespace

run::Record explain_particles(const io::Scene& scene) {
    const dem::Setup& setup = scene.particles;
    const dem::Bodies bodies = dem::make_bodies(setup, static_cast<std::uint64_t>(scene.run.seed));
    const io::Box box = io::box_of(setup);
    const double area = dem::area(setup.cell), rate = 2.0 * std::numbers::pi * setup.plates.frequency,
                 gravity = std::abs(setup.gravity.z);
    run::Record root{.heading =
                         text("particles in a {} cell, {} by {} mm", setup.cell.shape, box.sides[0], box.sides[1]),
                     .header = words_of_setup(setup)};
    root.entries = {run::data_only(run::words("cell", "its shape", name_of(setup.cell.shape))),
                    run::number("cell_area", "mm2", "area of the cell", area),
                    run::count("spheres", "of all bodies", io::sphere_count(bodies)),
                    run::number("acceleration", "1", "of the plates, in units of gravity",
                                gravity > 0.0 ? setup.plates.amplitude * rate * rate / gravity : 0.0, 3),
                    run::number("time_step", "s", "time.dt", scene.time.dt),
                    run::number("steps_per_period", "1", "of the vibration",
                                setup.plates.frequency > 0.0 ? 1.0 / (setup.plates.frequency * scene.time.dt) : 0.0,
                                4)};
    root.parts = {{"beads", supply_of("beads", bodies.beads, bodies, area)},
                  {"rods", supply_of("rods", bodies.rods, bodies, area)}};
    add_calibration(scene, root);
    return root;
}

}  // namespace drover::report
