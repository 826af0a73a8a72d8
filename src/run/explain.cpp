// run/explain.cpp: what a scene holds and what it costs.
#include "drover/run/explain.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "drover/io/trajectory.hpp"
#include "drover/numerics/time_method.hpp"
#include "drover/physics/equations.hpp"
#include "drover/run/kind.hpp"

namespace drover::run {

Cost cost_of(const io::Scene& scene) {
    const Needs needs = needs_of(scene);
    return {.steps = io::whole_steps(scene, "time.end", scene.time.end),
            .threads = kind_of(scene).threads(scene),
            .needs = needs,
            .time = needs.memory_bytes < needs.memory_free ? expected_time(scene) : std::nullopt};
}

namespace {
/// The largest k with k (degree + 1) < points.
int largest_kept(int points, int degree) { return (points - 1) / (degree + 1); }

/// Right-hand sides of one step; 0: they vary.
int stages_of(const io::Scene& scene) {
    const numerics::TimeMethod& method = numerics::time_method(scene.time.stepper);
    return scene.time.tolerance > 0.0 ? method.stages_with_tolerance : method.stages;
}

std::string limit_of_growth(const physics::Equations& equations) {
    if (equations.saturation.is_active()) return " until relaxation.saturation limits it";
    return equations.model.text_terms.empty() ? "; no term saturates it" : " unless a term written as text limits it";
}
}  // namespace

FieldExplanation explain_fields(const io::Scene& scene) {
    const physics::Equations equations(scene.model);
    const numerics::System system = physics::linear_system(scene.model, scene.grid, scene.dealiasing);
    return {.form = physics::form_name(equations.form),
            .fields = physics::component_names(equations.form),
            .terms = physics::active_terms(equations),
            .without_degree = physics::terms_without_degree(equations),
            .beyond_growth = physics::terms_beyond_propagator(equations),
            .coefficients = physics::coefficient_values(scene.model),
            .growth = physics::fastest_growth(system),
            .fastest_rate = physics::fastest_rate(system),
            .cost = cost_of(scene),
            .transforms = physics::transform_count(equations),
            .is_nonlinear = physics::is_nonlinear(equations),
            .stages = physics::is_nonlinear(equations) ? stages_of(scene) : 0,
            .limit_of_growth = limit_of_growth(equations),
            .degree = system.degree,
            .kept_x = largest_kept(scene.grid.nx, system.degree),
            .kept_y = largest_kept(scene.grid.ny, system.degree)};
}

namespace {
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
}  // namespace

ParticleExplanation explain_particles(const io::Scene& scene) {
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

}  // namespace drover::run
