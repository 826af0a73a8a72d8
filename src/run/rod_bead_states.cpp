// run/rod_bead_states.cpp: travelling states of rods and beads.
#include <algorithm>
#include <cmath>

#include "drover/physics/density_profile.hpp"
#include "drover/physics/integrated.hpp"
#include "drover/physics/travelling_problem.hpp"
#include "drover/run/field_simulation.hpp"
#include "drover/run/signals.hpp"
#include "run/number_lists.hpp"
#include "run/states_problem.hpp"

namespace drover::run {

namespace {
struct FollowedFamily {
    physics::TravellingProblem problem;
    std::optional<FollowedNumber> followed;
};

FollowedFamily family_of(const io::Scene& line, const std::string& follow) {
    FollowedFamily family{.problem = {.model = [model = line.model](double) { return model; },
                                      .parameter = 0.0,
                                      .grid = line.grid,
                                      .dealiasing = line.dealiasing},
                          .followed = std::nullopt};
    if (follow.empty()) return family;
    const std::string list = "--follow", example = "\"relaxation.rate = 1.2\"";
    const SourceLocation where{.file = list};
    const auto [key, value] = read_assignment(follow, list, example, where);
    const io::ModelNumber number = io::model_number(key, where, line.model);
    const double last = read_number(value, follow, list, example, where);
    physics::Model model = line.model;
    family.problem.parameter = number.in(model);
    require(last != family.problem.parameter, where, "{} is {} already; expected another value to follow the state to",
            key, last);
    family.problem.model = [model, in = number.in](double parameter) {
        check_stop_signal();
        physics::Model changed = model;
        in(changed) = parameter;
        return changed;
    };
    family.followed = FollowedNumber{.key = key, .unit = number.unit.empty() ? "1" : number.unit, .last = last};
    return family;
}

struct Density {
    std::string name;
    int component;
};
std::vector<Density> densities_of(const physics::Form& form) {
    std::vector<Density> densities;
    if (form.bead_density >= 0) densities.push_back({"bead", form.bead_density});
    if (form.rod_density >= 0) densities.push_back({"rod", form.rod_density});
    return densities;
}

std::vector<Entry> entries_of(const numerics::TravellingState& at, const numerics::Fields& fields,
                              const physics::Form& form, double lx) {
    std::vector<Entry> entries;
    for (const Density& density : densities_of(form)) {
        const physics::DensityProfile profile = physics::density_profile(fields[density.component], lx);
        const auto add = [&](const char* what, const char* unit, const std::string& meaning, const EntryValue& value) {
            entries.push_back({.name = text("{}_{}", density.name, what),
                               .unit = unit,
                               .meaning = meaning,
                               .value = value,
                               .digits = 10});
        };
        add("density", "mm-2", text("mean {} density", density.name), at.state[density.component][0].real());
        add("low", "mm-2", text("{} density where it is flattest below the middle of its range", density.name),
            profile.low);
        add("high", "mm-2", text("{} density where it is flattest above the middle of its range", density.name),
            profile.high);
        add("coexistence", "1", text("1: both {} densities are plateaus, of two phases", density.name),
            profile.low_is_flat && profile.high_is_flat);
        add("width", "mm", text("of the part with a {} density above the middle", density.name), profile.width);
    }
    double largest = 0.0;
    for (std::size_t i = 0; i < fields.size; ++i)
        largest = std::max(largest, std::hypot(fields[form.polar_order][i], fields[form.polar_order + 1][i]));
    entries.push_back({.name = "max_polar_order",
                       .unit = physics::component_names(form)[static_cast<std::size_t>(form.polar_order)].unit,
                       .meaning = "largest |p|",
                       .value = largest,
                       .digits = 10});
    return entries;
}

numerics::Fields slaved_velocity_of(const numerics::TravellingState& at, const physics::TravellingProblem& problem) {
    const physics::Equations equations(problem.model(at.parameter));
    return physics::slaved_velocity(equations,
                                    physics::linear_system(equations, problem.grid,
                                                           physics::reference(equations.model.uniform),
                                                           problem.dealiasing),
                                    0.0, at.state);
}
}  // namespace

StatesProblem rod_bead_states(const io::Scene& scene, const std::string& follow, Threads& threads) {
    const io::Scene line = line_of(scene);
    const physics::Form form = physics::form(line.model);
    const FollowedFamily family = family_of(line, follow);
    StatesProblem states{.family = physics::travelling_family(family.problem, threads),
                         .followed = family.followed,
                         .grid = line.grid,
                         .degree = physics::linear_system(line.model, line.grid, line.dealiasing).degree,
                         .guess = travelling_guess(scene, line, threads),
                         .frames = frame_recording(scene),
                         .entries = [form, lx = line.grid.lx](const auto& at, const auto& fields) {
                             return entries_of(at, fields, form, lx);
                         }};
    if (form.velocity == physics::Velocity::slaved)
        states.further = [problem = family.problem](const auto& at) { return slaved_velocity_of(at, problem); };
    return states;
}

}  // namespace drover::run
