// run/fields/scene_equations.cpp: from a scene to what is integrated, and its numbers.
#include "run/fields/scene_equations.hpp"

#include <algorithm>

#include "base/mapped.hpp"
#include "calibrate/slow_order.hpp"
#include "model/energy.hpp"
#include "model/start.hpp"
#include "numerics/steppers/time_method.hpp"
#include "physics/integrated.hpp"
#include "physics/program_functions.hpp"

namespace drover::run {

namespace {
constexpr const char* own_section = "coefficients.";

model::Integrated whole_equations_of(const io::Scene& scene) {
    if (scene.kind != io::SceneKind::model) return physics::integrated(scene.model, scene.dealiasing);
    const model::Equations equations(io::model_of(scene.declared));
    return {.equations = equations, .kept_degree = io::kept_degree(scene, equations)};
}

}  // namespace

model::Integrated compiled_of(const io::Scene& scene) {
    model::Integrated what = whole_equations_of(scene);
    if (scene.approximation.quasi_linear) what.long_waves = scene.approximation.quasi_linear_above;
    return what;
}

model::Integrated integrated_of(const io::Scene& scene) {
    physics::require_functions(scene.model);
    return compiled_of(scene);
}

bool stands_still(const io::Scene& scene, const model::Equations& equations, const model::UniformState& means) {
    constexpr double half = 0.5;
    return numerics::time_method(scene.time.stepper).is_exponential &&
           equations.part_of_slow_change(means, scene.grid, scene.time.dt) < half;
}

model::Integrated about_start(const io::Scene& scene, model::Integrated what) {
    if (scene.kind != io::SceneKind::model || scene.initial.formulas.empty()) return what;
    if (!what.equations.has_nonlinear_part() || what.equations.placed_term() != nullptr) return what;
    const model::UniformState means = model::means_of_start(scene.initial, what.equations, scene.grid);
    if (stands_still(scene, what.equations, means)) what.equations = what.equations.about(means);
    return what;
}

double counterterm_of(const io::Scene& scene) {
    const int degree = physics::kept_degree(physics::Equations(scene.model), scene.dealiasing);
    return calibrate::counterterm(scene.model, {scene.grid, degree}, io::locate(scene, "approximation.counterterm"));
}

model::Integrated integrated_in_run(const io::Scene& given) {
    io::Scene scene = given;
    if (scene.approximation.counterterm) calibrate::add_counterterm(counterterm_of(scene), scene.model);
    return about_start(scene, integrated_of(scene));
}

model::Equations equations_of(const io::Scene& scene) {
    if (scene.kind == io::SceneKind::model) return model::Equations(io::model_of(scene.declared));
    return physics::Equations(scene.model).solver();
}

std::string placed_term_of(const io::Scene& scene, const model::Equations& equations) {
    if (scene.kind != io::SceneKind::model) return physics::nonuniform_term(physics::Equations(scene.model));
    const model::TermSummary* placed = equations.placed_term();
    return placed == nullptr ? "" : placed->text;
}

model::UniformState with_conserved_means(const model::Equations& equations, const model::UniformState& sample) {
    constexpr double rounding = 1e-9;  // of a mean over a run or a grid
    const Eigen::MatrixXd kept = theory::conserved_means(equations);
    const std::vector<int>& state = equations.state_components();
    model::UniformState means = equations.reference();
    Eigen::VectorXd apart(kept.cols());
    for (Eigen::Index k = 0; k < apart.size(); ++k) {
        const auto component = static_cast<std::size_t>(state[static_cast<std::size_t>(k)]);
        apart(k) = sample[component] - means[component];
    }
    const Eigen::VectorXd moved = kept.transpose() * (kept * apart);
    for (Eigen::Index k = 0; k < moved.size(); ++k) {
        double& mean = means[static_cast<std::size_t>(state[static_cast<std::size_t>(k)])];
        if (std::abs(moved(k)) > rounding * (mean != 0.0 ? std::abs(mean) : 1.0)) mean += moved(k);
    }
    return means;
}

model::UniformState conserved_start(const io::Scene& scene, const model::Equations& equations) {
    if (scene.initial.formulas.empty()) return equations.reference();
    return with_conserved_means(equations, model::means_of_start(scene.initial, equations, scene.grid));
}

theory::StationaryStates uniform_states_of(const io::Scene& scene, const model::Equations& equations) {
    if (scene.kind == io::SceneKind::model)
        return theory::stationary_states(equations, conserved_start(scene, equations));
    // The fields of a model file follow the order in one way alone: without a search where that is enough.
    const physics::Equations keyed(scene.model);
    std::optional<theory::StationaryStates> few;
    if (keyed.model.text_terms.empty()) few = theory::states_of_cubic_order(keyed.theory(), equations.reference());
    theory::StationaryStates found = few ? *std::move(few) : theory::stationary_states(equations);
    if (found.why_no_order.empty()) return found;
    if (const std::string why = calibrate::why_no_order(keyed); !why.empty()) {
        found.why_no_order = why;
        if (found.states.empty()) found.why_none = why;
    }
    return found;
}

theory::StationaryStates stationary_states_of(const io::Scene& scene, const model::Equations& equations) {
    if (scene.kind != io::SceneKind::model)
        if (const std::string term = placed_term_of(scene, equations); !term.empty())
            return {.states = {}, .why_none = term + " depends on position or time", .why_no_order = {}};
    return uniform_states_of(scene, equations);
}

std::string coefficient_of(const io::Scene& scene, const std::string& list, const std::string& key,
                           const SourceLocation& where, std::span<const std::string> others) {
    const std::string section = own_section, name = key.starts_with(section) ? key.substr(section.size()) : key;
    auto names = mapped(scene.declared.coefficients, [&](const auto& one) { return section + one.first; });
    names.insert(names.end(), others.begin(), others.end());
    require(scene.declared.coefficients.contains(name), where, "{} names {}; expected {}", list, key,
            names.empty() ? "a coefficient of the model, which has none" : "one of " + joined(names));
    return name;
}

SceneNumber number_of(const io::Scene& scene, const std::string& list, const std::string& key,
                      const SourceLocation& where) {
    if (scene.kind == io::SceneKind::model) {
        const std::string name = coefficient_of(scene, list, key, where);
        return {.key = own_section + name, .value = scene.declared.coefficients.at(name)};
    }
    const io::ModelNumber number = io::model_number(key, where, scene.model);
    physics::ModelValues model = scene.model;
    return {.key = key, .unit = number.unit.empty() ? "1" : number.unit, .value = number.in(model)};
}

SceneNumber example_number(const io::Scene& scene) {
    if (scene.kind == io::SceneKind::particles)
        return {.key = "cell.lx", .unit = "mm", .value = scene.particles.cell.lx};
    for (const auto& [name, value] : scene.declared.coefficients)
        if (value != 0.0) return {.key = own_section + name, .value = value};
    for (const physics::CoefficientRow& row : scene.model.file->coefficients)
        if (const double value = number(scene.model, row.key()); scene.kind == io::SceneKind::fields && value != 0.0)
            return {.key = row.key(), .unit = row.unit, .value = value};
    return {.key = "grid.lx", .unit = "mm", .value = scene.grid.lx};
}

std::string example_of_number(const io::Scene& scene) {
    const SceneNumber number = example_number(scene);
    return text("\"{} = {}\"", number.key, number.value);
}

std::string example_observable(const io::Scene& scene) {
    if (!io::has_grid(scene.kind)) return "energy_kinetic";
    return "variance_" + equations_of(scene).model().fields.front().name;
}

std::string key_of_term(const io::Scene& scene, const model::Equations& equations, const model::Field& field,
                        const std::string& factor) {
    if (scene.kind != io::SceneKind::model) return physics::key_of_term(field.symbol, factor);
    for (const model::TermSummary& term : equations.terms()) {
        if (equations.model().fields[term.field].symbol != field.symbol || !term.text.ends_with(" " + factor)) continue;
        std::string name = term.text.substr(0, term.text.size() - factor.size() - 1);
        name.erase(0, name.find_first_not_of("+- "));
        if (scene.declared.coefficients.contains(name)) return own_section + name;
    }
    return "";
}

std::vector<std::string> names_of_terms(const io::Scene& scene, const model::Equations& equations) {
    const std::vector<std::size_t> terms = model::terms_with_power(equations);
    std::vector<std::string> keys;
    if (scene.kind != io::SceneKind::model) keys = physics::Equations(scene.model).terms();
    const auto field_of = [&](std::size_t term) { return equations.terms()[term].field; };
    const bool has_one_field =
        std::ranges::all_of(terms, [&](std::size_t n) { return field_of(n) == field_of(terms[0]); });
    return mapped(terms, [&](std::size_t n) {
        if (n < keys.size()) return keys[n];
        const std::string& written = equations.terms()[n].text;
        return has_one_field ? written : equations.model().fields[field_of(n)].symbol + ": " + written;
    });
}

std::vector<physics::HeldRange> held_ranges(const io::Scene& scene) {
    if (scene.kind != io::SceneKind::model) return physics::held_ranges(scene.model.table);
    std::vector<physics::HeldRange> ranges;
    for (const io::DeclaredTable& table : scene.declared.tables)
        for (std::size_t k = 0; k < table.of.size() && table.outside == numerics::Outside::hold; ++k) {
            const std::vector<double>& nodes = k == 0 ? table.first : table.second;
            ranges.push_back({.symbol = table.of[k], .min = nodes.front(), .max = nodes.back()});
        }
    return ranges;
}

io::Scene scene_with(const io::Scene& scene, const std::string& key, double value) {
    io::Scene changed = scene;
    if (scene.kind == io::SceneKind::model)
        changed.declared.coefficients.at(key.substr(std::string_view(own_section).size())) = value;
    else io::model_number(key, {}, changed.model).in(changed.model) = value;
    return changed;
}

}  // namespace drover::run
