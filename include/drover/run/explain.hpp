// run/explain.hpp: what a scene holds and what it costs: fields and terms, or particles; memory, disk, wall time.
#pragma once
#include <optional>
#include <string>
#include <vector>

#include "drover/io/scene.hpp"
#include "drover/physics/integrated.hpp"
#include "drover/run/cost.hpp"
#include "drover/run/run_scene.hpp"

namespace drover::run {

/// Memory, disk and wall time of a scene.
struct Cost {
    std::int64_t steps = 0;
    int threads = 1;
    Needs needs;
    std::optional<ExpectedTime> time;  ///< empty when the scene cannot be stepped
};

/// Times a few steps, where there is enough memory.
Cost cost_of(const io::Scene& scene);

struct FieldExplanation {
    std::string form;
    std::vector<physics::Component> fields;
    std::vector<physics::ActiveTerm> terms;
    std::vector<std::string> without_degree;  ///< terms whose products have no finite degree
    std::vector<std::string> beyond_growth;   ///< terms that the growth rate leaves out
    std::vector<physics::CoefficientValue> coefficients;
    physics::FastestGrowth growth;
    double fastest_rate = 0.0;  ///< |s|max [1/s]
    Cost cost;
    physics::TransformCount transforms;  ///< per right-hand side
    bool is_nonlinear = false;
    int stages = 0;               ///< right-hand sides per step; 0 when every term is linear, or when they vary
    std::string limit_of_growth;  ///< what may stop the growth of order
    int degree = 1;               ///< of the products
    int kept_x = 0, kept_y = 0;   ///< the largest mode number kept on each axis
};

/// Of a scene with a time step.
FieldExplanation explain_fields(const io::Scene& scene);

/// Bodies of one kind in a cell.
struct Supply {
    std::size_t count = 0, shapes = 0;
    double area_fraction = 0.0, min_mass = 0.0, max_mass = 0.0, min_length = 0.0, max_length = 0.0;
};

struct ParticleExplanation {
    Supply beads, rods;
    std::size_t spheres = 0;
    double acceleration = 0.0;  ///< of the plates, in units of gravity
    double steps_per_period = 0.0;
    Cost cost;
};

ParticleExplanation explain_particles(const io::Scene& scene);

}  // namespace drover::run
