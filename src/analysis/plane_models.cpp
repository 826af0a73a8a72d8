// analysis/plane_models.cpp: models by the numbers of a plane.
#include "analysis/plane_models.hpp"

#include "base/constants.hpp"
#include "base/draws.hpp"
#include "base/log.hpp"
#include "run/scene_equations.hpp"

namespace drover::analysis {

namespace {
constexpr const char* mean_of = "uniform.";
constexpr const char* fraction_end = "_area_fraction";

/// The mean density of a field of a model of one's own is its reference.
PlaneNumber declared_mean(const io::Scene& scene, const model::Field& field) {
    std::size_t at = 0;
    while (scene.declared.fields[at].symbol != field.symbol) ++at;
    return {.name = mean_of + field.name,
            .unit = field.unit,
            .get = [at](const SceneModel& of) { return io::model_of(of.declared).fields[at].reference; },
            .set = [at](SceneModel& of, double value) { of.declared.fields[at].reference = text("{:.17g}", value); },
            .density = field.name};
}

PlaneNumber number_of_model(const physics::ModelValues& model, const std::string& key, const SourceLocation& where) {
    const io::ModelNumber number = io::model_number(key, where, model);
    return {.name = key,
            .unit = number.unit.empty() ? "1" : number.unit,
            .range = number.range,
            .get = [in = number.in](const SceneModel& of) { return in(const_cast<physics::ModelValues&>(of.model)); },
            .set = [in = number.in](SceneModel& of, double value) { in(of.model) = value; }};
}

/// The area of one body, "uniform.bead_area": a number of the scene that the equations do not have.
double area_of_body(const physics::ModelValues& model, const std::string& name) {
    for (const physics::ModelSection& section : physics::model_sections())
        for (const physics::ModelKey& key : section.keys)
            if (mean_of == section.name + "." && key.description.name == name) return std::get<double>(key.get(model));
    return 0.0;
}
}  // namespace

PlaneNumber plane_number(const io::Scene& scene, const std::string& list, const std::string& name,
                         const SourceLocation& where) {
    const bool is_own = scene.kind == io::SceneKind::model;
    const model::Equations equations = run::equations_of(scene);
    for (const model::Field& field : equations.model().fields) {
        if (field.spin != 0 || !field.conserved) continue;
        const std::string mean = mean_of + field.name;
        if (name == mean && is_own) return declared_mean(scene, field);
        if (name == mean) {
            PlaneNumber number = number_of_model(scene.model, mean, where);
            number.density = field.name;
            return number;
        }
        if (is_own || field.observed.counted.empty() || name != field.observed.counted + fraction_end) continue;
        const std::string body_area = field.observed.counted + "_area", area_key = mean_of + body_area;
        const PlaneNumber number = number_of_model(scene.model, mean, where);
        const double area = area_of_body(scene.model, body_area);
        require(area > 0.0, io::locate(scene, area_key),
                "{} names {}, which needs the area of one particle, and {} = {}; expected > 0 [mm^2]", list, name,
                area_key, area);
        return {.name = name,
                .get = [get = number.get, area](const SceneModel& of) { return area * get(of); },
                .set = [set = number.set, area](SceneModel& of, double covered) { set(of, covered / area); },
                .density = field.name,
                .area = area,
                .is_fraction = true};
    }
    if (!is_own) return number_of_model(scene.model, name, where);
    const std::string coefficient = run::coefficient_of(scene, list, name, where);
    return {.name = run::number_of(scene, list, name, where).key,
            .get = [coefficient](const SceneModel& of) { return of.declared.coefficients.at(coefficient); },
            .set = [coefficient](SceneModel& of, double value) { of.declared.coefficients.at(coefficient) = value; }};
}

bool are_same(const PlaneNumber& one, const PlaneNumber& other) {
    return one.name == other.name || (!one.density.empty() && one.density == other.density);
}

PlaneModels::PlaneModels(io::SceneKind kind, SceneModel base, PlaneNumber x, PlaneNumber y,
                         const numerics::Rectangle& plane, const PlaneModels* like)
    : kind_(kind), base_(std::move(base)), x_(std::move(x)), y_(std::move(y)) {
    if (kind_ == io::SceneKind::model) {
        const model::Equations equations(io::model_of(base_.declared));
        has_order_ = !model::turning_components(equations.model()).empty();
        search_ = like != nullptr ? like->search_ : theory::order_search(equations);
        return;
    }
    // Of coefficients the middle, which is valid; where the middle of densities lies beyond a table the coefficients
    // themselves still serve the rest of the plane.
    SceneModel middle = base_;
    if (x_.density.empty()) x_.set(middle, 0.5 * (plane.x0 + plane.x1));
    if (y_.density.empty()) y_.set(middle, 0.5 * (plane.y0 + plane.y1));
    compiled_ = like != nullptr ? std::make_shared<const physics::Equations>(middle.model, *like->compiled_)
                                : std::make_shared<const physics::Equations>(middle.model);
    theory_ = std::make_shared<const theory::PointTheory>(compiled_->theory());
    has_order_ = true;
    search_ = like != nullptr ? like->search_ : theory::order_search(theory_->solver());
    for (const auto& [field, first] : model::placed_fields(theory_->equations().model()))
        if (field.spin == 0) densities_.emplace_back(first, number_of_model(middle.model, mean_of + field.name, {}));
    means_ = means_of(middle);
    x_change_ = change_of(x_, middle, plane.x0);
    y_change_ = change_of(y_, middle, plane.y0);
}

std::optional<PlaneModels::Change> PlaneModels::change_of(const PlaneNumber& number, const SceneModel& middle,
                                                          double min_value) const {
    if (!number.density.empty()) {
        for (const auto& [field, first] : model::placed_fields(theory_->equations().model()))
            if (field.name == number.density) return Change{.component = static_cast<int>(first), .terms = {}};
        return {};  // a number in the terms
    }
    const auto coefficient = compiled_->coefficients.find(number.name);
    const double base = number.get(middle);
    if (coefficient == compiled_->coefficients.end() || coefficient->second.varies() || base == 0.0) return {};
    const std::vector<std::string>& names = compiled_->terms();
    Change change{.terms = {}, .base = base};
    for (std::size_t n = 0; n < names.size(); ++n)
        if (names[n] == number.name) change.terms.push_back(n);
    // A balance needs a drag above 0: where it may not have it, each model is checked.
    const bool is_checked =
        min_value <= 0.0 && std::any_of(change.terms.begin(), change.terms.end(), [&](std::size_t n) {
            const std::string& symbol =
                theory_->equations().model().fields[theory_->equations().terms()[n].field].symbol;
            return presence(middle.model, symbol) == physics::Presence::balance;
        });
    if (change.terms.empty() || is_checked) return {};
    return change;
}

SceneModel PlaneModels::changed(const numerics::PlanePoint& point) const {
    SceneModel result = base_;
    x_.set(result, point.x);
    y_.set(result, point.y);
    return result;
}

std::string PlaneModels::place_of(const numerics::PlanePoint& point) const {
    return text("at {} = {}, {} = {}", x_.name, point.x, y_.name, point.y);
}

model::UniformState PlaneModels::means_of(const SceneModel& changed) const {
    model::UniformState means(static_cast<std::size_t>(theory_->equations().components()), 0.0);
    for (const auto& [component, density] : densities_) means[component] = density.get(changed);
    return means;
}

theory::Margin PlaneModels::margin_of_changes(const numerics::PlanePoint& point, theory::Limit limit) const {
    model::UniformState means = means_;
    std::vector<double> factors(compiled_->terms().size(), 1.0);
    for (const auto& [change, number, value] :
         {std::tuple{&*x_change_, &x_, point.x}, std::tuple{&*y_change_, &y_, point.y}}) {
        if (change->component >= 0) means[static_cast<std::size_t>(change->component)] = value / number->area;
        for (const std::size_t n : change->terms) factors[n] *= value / change->base;
    }
    if (x_change_->terms.empty() && y_change_->terms.empty()) return theory::margin(*theory_, means, limit, search_);
    const auto solver = [this, point] { return physics::Equations(changed(point).model).solver(); };
    return theory::margin(theory_->scaled(factors, solver), means, limit, search_);
}

theory::Margin PlaneModels::margin(const numerics::PlanePoint& point, theory::Limit limit) const {
    try {
        if (x_change_ && y_change_) return margin_of_changes(point, limit);
        const SceneModel here = changed(point);
        if (kind_ == io::SceneKind::model) {
            const model::Equations equations(io::model_of(here.declared));
            return theory::margin(theory::PointTheory(equations), equations.reference(), limit, search_);
        }
        const model::UniformState means = means_of(here);
        if (!theory_->rates(means).allFinite()) return {.value = nan};  // beyond a table
        const auto equations = std::make_shared<const physics::Equations>(here.model, *compiled_);
        return theory::margin(physics::Equations::theory(equations), means, limit, search_);
    } catch (const Error& error) {
        if (!is_of_scene(error.fault())) throw;
        fail_input({}, "{}: {}", place_of(point), error.what());
    }
}

model::Equations PlaneModels::equations(const numerics::PlanePoint& point) const {
    const SceneModel here = changed(point);
    try {
        if (kind_ == io::SceneKind::model) return model::Equations(io::model_of(here.declared));
        const physics::Equations equations(here.model);
        return equations.solver();
    } catch (const Error& error) {
        throw Error(error.fault(), {}, text("{}: {}", place_of(point), error.what()));
    }
}

namespace {
/// A number with a standard error; errors of different numbers are independent.
struct UncertainNumber {
    double error = 0.0;
    std::function<void(SceneModel&, double)> add;
};

/// All table values of a model that have an error.
std::vector<UncertainNumber> table_errors(const physics::ModelValues& model) {
    std::vector<UncertainNumber> result;
    for (const auto& [key, column] : model.table.columns)
        for (std::size_t i = 0; i < column.errors.size(); ++i)
            if (const double error = column.errors[i]; error != 0.0)
                result.push_back({.error = error, .add = [key = key, i](SceneModel& of, double change) {
                                      of.model.table.columns.at(key).values[i] += change;
                                  }});
    return result;
}
}  // namespace

std::vector<SceneModel> drawn_scenes(const io::Scene& scene,
                                     const std::vector<std::pair<std::string, double>>& errors) {
    const bool is_own = scene.kind == io::SceneKind::model;
    std::vector<UncertainNumber> uncertain = is_own ? std::vector<UncertainNumber>() : table_errors(scene.model);
    for (const auto& [key, error] : errors) {
        const PlaneNumber number = plane_number(scene, "boundary.errors", key, {});
        uncertain.push_back({.error = error, .add = [number](SceneModel& of, double change) {
                                 number.set(of, number.get(of) + change);
                             }});
    }
    const bool has_errors = !uncertain.empty() || (!is_own && !scene.calibrated.filled.empty());
    const int count = scene.boundary.draws;
    if (!has_errors || count == 0) return {};
    std::vector<SceneModel> drawn;
    if (is_own) drawn.assign(static_cast<std::size_t>(count), scene_model(scene));
    else
        for (physics::ModelValues& one : io::drawn_models(scene, count))
            drawn.push_back({.model = std::move(one), .declared = {}});
    for (std::size_t n = 0; n < uncertain.size(); ++n) {
        const std::vector<double> normal = normal_draws(n, 0, drawn.size());
        for (std::size_t k = 0; k < drawn.size(); ++k) uncertain[n].add(drawn[k], normal[k] * uncertain[n].error);
    }
    if (drawn.empty())
        log_warning("none of {} draws of the numbers with errors is a valid model: the lines have no error bands",
                    count);
    return drawn;
}

}  // namespace drover::analysis
