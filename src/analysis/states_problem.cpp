// analysis/states_problem.cpp: the travelling states of a scene of fields.
#include "analysis/states_problem.hpp"

#include <algorithm>
#include <cmath>

#include "model/start.hpp"
#include "run/field_simulation.hpp"
#include "run/number_lists.hpp"
#include "run/scene_equations.hpp"
#include "run/signals.hpp"
#include "theory/density_profile.hpp"
#include "theory/travelling_family.hpp"

namespace drover::analysis {

namespace {
/// What is told of a scalar, and its name; "": nothing.
struct ScalarNames {
    std::string mean, min, max, low, high, coexistence, width;
};

ScalarNames names_of(const io::Scene& scene, const std::string& field) {
    const auto before = [&](const char* what) { return text("{}_{}", what, field); };
    if (scene.kind == io::SceneKind::model)
        return {before("mean"), before("min"),         before("max"),  before("low"),
                before("high"), before("coexistence"), before("width")};
    const std::string stem = field.substr(0, field.find('_'));  // "rod_density", as archives have it: "rod_low"
    return {field, "", "", stem + "_low", stem + "_high", stem + "_coexistence", stem + "_width"};
}

void add_scalar(const ScalarNames& names, const model::StateComponent& of, double mean, std::span<const double> values,
                double lx, std::vector<run::Entry>& entries) {
    const auto add = [&](const std::string& name, const std::string& unit, const std::string& meaning,
                         const run::EntryValue& value) {
        if (!name.empty())
            entries.push_back({.name = name, .unit = unit, .meaning = meaning, .value = value, .digits = 10});
    };
    const auto [least, most] = std::minmax_element(values.begin(), values.end());
    const theory::DensityProfile profile = theory::density_profile(values, lx);
    const std::string words = of.name;
    add(names.mean, of.unit, text("mean of {}", words), mean);
    add(names.min, of.unit, text("smallest {} on a point", words), *least);
    add(names.max, of.unit, text("largest {} on a point", words), *most);
    add(names.low, of.unit, text("{} where it is flattest below the middle of its range", words), profile.low);
    add(names.high, of.unit, text("{} where it is flattest above the middle of its range", words), profile.high);
    add(names.coexistence, "1", text("1: both values of {} are plateaus, of two phases", words),
        profile.low_is_flat && profile.high_is_flat);
    add(names.width, "mm", text("of the part with {} above the middle", words), profile.width);
}

std::vector<run::Entry> entries_of(const numerics::TravellingState& at, const numerics::Fields& fields,
                                   const io::Scene& line, const model::Equations& equations) {
    const std::vector<model::StateComponent> components = model::components_of_state(equations);
    std::vector<run::Entry> entries;
    for (int c = 0; c < fields.count(); ++c) {
        const model::StateComponent& one = components[static_cast<std::size_t>(c)];
        const model::Field& field = equations.model().fields[one.field];
        if (field.spin == 0) {
            add_scalar(names_of(line, one.name), one, at.state[c][0].real(), fields[c], line.grid.lx, entries);
            continue;
        }
        if (line.kind == io::SceneKind::model)
            entries.push_back(run::number("mean_" + one.name, one.unit, "mean", at.state[c][0].real(), 10));
        if (one.part == 0) continue;
        double largest = 0.0;
        for (std::size_t i = 0; i < fields.size; ++i)
            largest = std::max(largest, std::hypot(fields[c - 1][i], fields[c][i]));
        entries.push_back(
            run::number("max_" + field.name, one.unit, text("largest |{}| on a point", field.symbol), largest, 10));
    }
    return entries;
}
}  // namespace

StatesProblem states_problem(const io::Scene& scene, const std::string& follow, Threads& threads) {
    const io::Scene line = run::line_of(scene);
    StatesProblem states;
    double parameter = 0.0;
    std::function<model::Integrated(double)> at = [line](double) { return run::integrated_of(line); };
    if (!follow.empty()) {
        const std::string list = "--follow";
        const SourceLocation where{.file = list};
        const auto [key, value] = run::read_assignment(follow, list, run::example_of_number(line), where);
        const run::SceneNumber number = run::number_of(line, list, key, where);
        const double last = run::read_number(value, follow, list, run::example_of_number(line), where);
        parameter = number.value;
        require(last != parameter, where, "{} is {} already; expected another value to follow the state to", key, last);
        states.followed = FollowedNumber{.key = number.key, .unit = number.unit, .last = last};
        at = [line, key = number.key](double changed) {
            return run::integrated_of(run::scene_with(line, key, changed));
        };
    }
    const model::Integrated here = at(parameter);
    for (const model::Field& field : here.equations.model().fields)
        require(!field.solenoidal || field.left == model::LeftSide::balance, field.where,
                "{} is solenoidal: of a state that depends on x alone its x component is a constant; expected its y "
                "component as a scalar field of its own, for drover states",
                field.symbol);
    states.family = theory::travelling_family(at, parameter, line.grid, threads);
    states.family.system = [system = states.family.system](double value) {
        run::check_stop_signal();
        return system(value);
    };
    states.grid = line.grid;
    states.degree = here.equations.linear_system(line.grid, here.kept_degree).degree;
    states.guess = run::travelling_guess(scene, line, threads);
    states.frames = run::frame_recording(scene);
    if (!model::components_in_balance(here.equations).empty())
        states.further = [at, grid = line.grid, &threads](const auto& state) {
            const model::Integrated what = at(state.parameter);
            return model::ExplicitPart(what.equations, what.equations.linear_system(grid, what.kept_degree), threads)
                .balanced(0.0, state.state);
        };
    states.entries = [line, equations = here.equations](const auto& state, const auto& fields) {
        return entries_of(state, fields, line, equations);
    };
    return states;
}

}  // namespace drover::analysis
