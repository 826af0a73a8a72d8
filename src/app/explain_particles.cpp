// app/explain_particles.cpp: drover explain SCENE for particles.
#include <cmath>
#include <cstdio>
#include <nlohmann/json.hpp>
#include <numbers>

#include "command.hpp"
#include "drover/io/trajectory.hpp"
#include "drover/run/calibration.hpp"
#include "drover/run/kind.hpp"
#include "explain_cost.hpp"

namespace drover::app {

namespace {
/// Bodies of one kind in a cell.
struct Supply {
    std::size_t count = 0, shapes = 0;
    double area_fraction = 0.0, min_mass = 0.0, max_mass = 0.0, min_length = 0.0, max_length = 0.0;
};

template <class Body>
Supply supply_of(const std::vector<Body>& list, const dem::Bodies& bodies, const dem::Cell& cell) {
    Supply supply{.count = list.size()};
    std::vector<bool> seen(bodies.shapes.size());
    for (const Body& body : list) {
        const dem::Shape& shape = bodies.shapes[body.shape];
        const double length = shape.head - shape.tail;
        supply.area_fraction += shape.projected_area / dem::area(cell);
        if (seen[body.shape]) continue;
        const bool first = supply.shapes++ == 0;
        seen[body.shape] = true;
        supply.min_mass = first ? shape.mass : std::min(supply.min_mass, shape.mass);
        supply.max_mass = first ? shape.mass : std::max(supply.max_mass, shape.mass);
        supply.min_length = first ? length : std::min(supply.min_length, length);
        supply.max_length = first ? length : std::max(supply.max_length, length);
    }
    return supply;
}

struct Explanation {
    Supply beads, rods;
    std::size_t spheres = 0;
    double acceleration = 0.0;  ///< of the plates, in units of gravity
    double steps_per_period = 0.0;
    Cost cost;
};

Explanation explain(const io::Scene& scene) {
    const dem::Setup& setup = scene.particles;
    const dem::Bodies bodies = dem::make_bodies(setup, static_cast<std::uint64_t>(scene.run.seed));
    const double rate = 2.0 * std::numbers::pi * setup.plates.frequency, gravity = std::abs(setup.gravity.z);
    return {.beads = supply_of(bodies.beads, bodies, setup.cell),
            .rods = supply_of(bodies.rods, bodies, setup.cell),
            .spheres = io::sphere_count(bodies),
            .acceleration = gravity > 0.0 ? setup.plates.amplitude * rate * rate / gravity : 0.0,
            .steps_per_period = setup.plates.frequency > 0.0 ? 1.0 / (setup.plates.frequency * scene.time.dt) : 0.0,
            .cost = cost_of(scene)};
}

nlohmann::json supply_json(const Supply& supply) {
    return {{"count", supply.count},
            {"area_fraction", supply.area_fraction},
            {"shapes", supply.shapes},
            {"mass", {supply.min_mass, supply.max_mass}},
            {"length", {supply.min_length, supply.max_length}}};
}

nlohmann::json explanation_json(const io::Scene& scene, const Explanation& e) {
    nlohmann::json result{{"kind", "particles"},
                          {"beads", supply_json(e.beads)},
                          {"rods", supply_json(e.rods)},
                          {"spheres", e.spheres},
                          {"cell", scene.particles.cell.shape},
                          {"cell_area", dem::area(scene.particles.cell)},
                          {"acceleration", e.acceleration},
                          {"steps_per_period", e.steps_per_period}};
    result.update(cost_json(scene, e.cost));
    return result;
}

std::string range_text(double min, double max) {
    return min == max ? text("{:.4g}", min) : text("{:.4g} to {:.4g}", min, max);
}

void print_supply(const char* name, const Supply& supply) {
    if (supply.count == 0) return;
    std::printf("  %zu %s: area fraction %.4g, length %s, mass %s, %zu shape%s\n", supply.count, name,
                supply.area_fraction, (range_text(supply.min_length, supply.max_length) + " mm").c_str(),
                (range_text(supply.min_mass, supply.max_mass) + " mg").c_str(), supply.shapes,
                supply.shapes == 1 ? "" : "s");
}

void print(const io::Scene& scene, const Explanation& e) {
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
    if (setup.contacts.model == "impulse")
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
}  // namespace

void explain_particles(const io::Scene& scene, bool json) {
    const Explanation explanation = explain(scene);
    if (json) print_json(explanation_json(scene, explanation));
    else print(scene, explanation);
}

}  // namespace drover::app
