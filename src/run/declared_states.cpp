// run/declared_states.cpp: travelling states of a model of its own.
#include <algorithm>
#include <cmath>
#include <memory>

#include "drover/model/explicit_part.hpp"
#include "drover/physics/density_profile.hpp"
#include "drover/run/field_simulation.hpp"
#include "drover/run/signals.hpp"
#include "run/model_coefficients.hpp"
#include "run/number_lists.hpp"
#include "run/states_problem.hpp"

namespace drover::run {

namespace {
/// The equations at values of one coefficient; those at the last value are kept.
class EquationsAt {
public:
    EquationsAt(const io::DeclaredModel& declared, std::string coefficient)
        : declared_(declared), coefficient_(std::move(coefficient)) {}

    const model::Equations& operator()(double parameter) {
        if (equations_ && parameter == at_) return *equations_;
        equations_ = coefficient_.empty() ? model::Equations(io::model_of(declared_))
                                          : equations_with(declared_, {{coefficient_, parameter}});
        at_ = parameter;
        const model::TermSummary* placed = equations_->placed_term();
        require(placed == nullptr, placed == nullptr ? SourceLocation{} : placed->where,
                "the term {} depends on position or time; expected terms without: a travelling state has none",
                placed == nullptr ? "" : placed->text);
        return *equations_;
    }

private:
    io::DeclaredModel declared_;
    std::string coefficient_;
    std::optional<model::Equations> equations_;
    double at_ = 0.0;
};

/// On one row of points, without noise.
numerics::System quiet_system(const model::Equations& equations, const numerics::Grid& line, int degree,
                              Threads& threads) {
    numerics::System system = equations.system(line, threads, degree);
    system.noise = {};
    system.product_noise = {};
    return system;
}

void add_scalar(const std::string& name, const std::string& unit, double mean, std::span<const double> values,
                double lx, std::vector<Entry>& entries) {
    const auto add = [&](const char* what, const std::string& of_unit, const std::string& meaning,
                         const EntryValue& value) {
        entries.push_back(
            {.name = text("{}_{}", what, name), .unit = of_unit, .meaning = meaning, .value = value, .digits = 10});
    };
    const auto [least, most] = std::minmax_element(values.begin(), values.end());
    const physics::DensityProfile profile = physics::density_profile(values, lx);
    add("mean", unit, "mean", mean);
    add("min", unit, "smallest value on a point", *least);
    add("max", unit, "largest value on a point", *most);
    add("low", unit, "value where it is flattest below the middle of its range", profile.low);
    add("high", unit, "value where it is flattest above the middle of its range", profile.high);
    add("coexistence", "1", "1: both are plateaus, of two phases", profile.low_is_flat && profile.high_is_flat);
    add("width", "mm", "of the part above the middle", profile.width);
}

std::vector<Entry> entries_of_model(const numerics::TravellingState& at, const numerics::Fields& fields,
                                    const model::Equations& equations, double lx) {
    const std::vector<model::StateComponent> components = model::components_of_state(equations);
    std::vector<Entry> entries;
    for (int c = 0; c < fields.count(); ++c) {
        const model::StateComponent& one = components[static_cast<std::size_t>(c)];
        const model::Field& field = equations.model().fields[one.field];
        if (field.spin == 0) {
            add_scalar(one.name, one.unit, at.state[c][0].real(), fields[c], lx, entries);
            continue;
        }
        entries.push_back({.name = "mean_" + one.name,
                           .unit = one.unit,
                           .meaning = "mean",
                           .value = at.state[c][0].real(),
                           .digits = 10});
        if (one.part == 0) continue;
        double largest = 0.0;
        for (std::size_t i = 0; i < fields.size; ++i)
            largest = std::max(largest, std::hypot(fields[c - 1][i], fields[c][i]));
        entries.push_back({.name = "max_" + field.name,
                           .unit = one.unit,
                           .meaning = "largest size on a point",
                           .value = largest,
                           .digits = 10});
    }
    return entries;
}
}  // namespace

StatesProblem declared_states(const io::Scene& scene, const std::string& follow, Threads& threads) {
    const io::Scene line = line_of(scene);
    StatesProblem states;
    std::string coefficient;
    if (!follow.empty()) {
        const std::string list = "--follow", example = "\"coefficients.a = 1.2\"";
        const SourceLocation where{.file = list};
        const auto [key, value] = read_assignment(follow, list, example, where);
        coefficient = coefficient_of(line, list, key, where);
        const double last = read_number(value, follow, list, example, where);
        states.family.parameter = line.declared.coefficients.at(coefficient);
        require(last != states.family.parameter, where,
                "{} is {} already; expected another value to follow the state to", key, last);
        states.followed = FollowedNumber{.key = "coefficients." + coefficient, .last = last};
    }
    const auto at = std::make_shared<EquationsAt>(line.declared, coefficient);
    const model::Equations& equations = (*at)(states.family.parameter);
    for (const model::Field& field : equations.model().fields)
        require(!field.solenoidal || field.left == model::LeftSide::balance, field.where,
                "{} is solenoidal: of a state that depends on x alone its x component is a constant; expected its y "
                "component as a scalar field of its own, for drover states",
                field.symbol);
    const int degree = io::kept_degree(line, equations);
    states.grid = line.grid;
    states.degree = equations.linear_system(line.grid, degree).degree;
    states.family.system = [at, grid = line.grid, degree, &threads](double parameter) {
        check_stop_signal();
        return quiet_system((*at)(parameter), grid, degree, threads);
    };
    states.family.mean = [at](double parameter, int component) {
        const model::Equations& here = (*at)(parameter);
        return here.reference()[static_cast<std::size_t>(here.state_components()[static_cast<std::size_t>(component)])];
    };
    states.guess = travelling_guess(scene, line, threads);
    states.frames = frame_recording(scene);
    if (!model::components_in_balance(equations).empty())
        states.further = [at, grid = line.grid, degree, &threads](const auto& state) {
            const model::Equations& here = (*at)(state.parameter);
            return model::ExplicitPart(here, here.linear_system(grid, degree), threads).balanced(0.0, state.state);
        };
    states.entries = [at, lx = line.grid.lx](const auto& state, const auto& fields) {
        return entries_of_model(state, fields, (*at)(state.parameter), lx);
    };
    return states;
}

}  // namespace drover::run
