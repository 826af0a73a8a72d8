// analysis/plane_models.cpp: models by the numbers of a plane.
#include "analysis/plane_models.hpp"

#include <algorithm>

#include "base/constants.hpp"
#include "base/draws.hpp"
#include "base/log.hpp"
#include "run/fields/scene_equations.hpp"

namespace drover::analysis {

namespace {
constexpr const char* mean_of = "uniform.";
constexpr const char* fraction_end = "_area_fraction";

/// The declared field of a symbol.
template <class Declared>
auto& field_of(Declared& declared, const std::string& symbol) {
    return *std::ranges::find(declared.fields, symbol, [](const auto& field) { return field.symbol; });
}

PlaneNumber number_of_model(const physics::ModelValues& model, const std::string& key, const SourceLocation& where) {
    const io::ModelNumber number = io::model_number(key, where, model);
    return {.name = key, .unit = number.unit.empty() ? "1" : number.unit, .range = number.range, .key = key};
}

/// The area of one body, "uniform.bead_area": a number of the scene that the equations do not have.
double area_of_body(const physics::ModelValues& model, const std::string& name) {
    const physics::ModelKey* key = physics::find_key(mean_of + name);
    return key == nullptr ? 0.0 : std::get<double>(key->get(model));
}

/// A number with a standard error; errors of different numbers are independent.
struct UncertainNumber {
    double error = 0.0;
    std::function<void(io::Scene&, double)> add;
};

/// All table values of a model that have an error.
std::vector<UncertainNumber> table_errors(const physics::ModelValues& model) {
    std::vector<UncertainNumber> result;
    for (const auto& [key, column] : model.table.columns)
        for (std::size_t i = 0; i < column.errors.size(); ++i)
            if (const double error = column.errors[i]; error != 0.0)
                result.push_back({.error = error, .add = [key = key, i](io::Scene& of, double change) {
                                      of.model.table.columns.at(key).values[i] += change;
                                  }});
    return result;
}
}  // namespace

PlaneNumber plane_number(const io::Scene& scene, const std::string& list, const std::string& name,
                         const SourceLocation& where) {
    const bool is_own = scene.kind == io::SceneKind::model;
    const model::Equations equations = run::equations_of(scene);
    std::vector<std::string> means;
    for (const model::Field& field : equations.model().fields) {
        if (field.spin != 0 || !field.conserved) continue;
        const std::string& mean = means.emplace_back(mean_of + field.name);
        if (name == mean && is_own)  // its reference
            return {.name = mean, .unit = field.unit, .key = field.symbol, .density = field.name};
        if (name == mean) {
            PlaneNumber number = number_of_model(scene.model, mean, where);
            number.density = field.name;
            return number;
        }
        if (is_own || field.observed.counted.empty() || name != field.observed.counted + fraction_end) continue;
        const std::string body_area = field.observed.counted + "_area", area_key = mean_of + body_area;
        const double area = area_of_body(scene.model, body_area);
        require(area > 0.0, io::locate(scene, area_key),
                "{} names {}, which needs the area of one particle, and {} = {}; expected > 0 [mm^2]", list, name,
                area_key, area);
        return {.name = name, .key = mean, .density = field.name, .area = area, .is_fraction = true};
    }
    if (!is_own) return number_of_model(scene.model, name, where);
    const std::string coefficient = run::coefficient_of(scene, list, name, where, means);
    return {.name = run::number_of(scene, list, name, where).key, .key = coefficient};
}

double PlaneNumber::in(const io::Scene& scene) const {
    if (scene.kind != io::SceneKind::model)
        return area * io::model_number(key, {}, scene.model).in(const_cast<physics::ModelValues&>(scene.model));
    if (density.empty()) return scene.declared.coefficients.at(key);
    const model::Model model = io::model_of(scene.declared);
    return field_of(model, key).reference;
}

void PlaneNumber::set(io::Scene& scene, double value) const {
    if (scene.kind != io::SceneKind::model) io::model_number(key, {}, scene.model).in(scene.model) = value / area;
    else if (density.empty()) scene.declared.coefficients.at(key) = value;
    else field_of(scene.declared, key).reference = text("{:.17g}", value);
}

bool are_same(const PlaneNumber& one, const PlaneNumber& other) {
    return one.name == other.name || (!one.density.empty() && one.density == other.density);
}

PlaneModels::PlaneModels(io::Scene base, PlaneAxis x, PlaneAxis y, const PlaneModels* like)
    : base_(std::move(base)), x_(std::move(x)), y_(std::move(y)) {
    if (base_.kind == io::SceneKind::model) {
        const model::Equations equations(io::model_of(base_.declared));
        search_ = like != nullptr ? like->search_ : theory::order_search(equations);
        return;
    }
    // Of coefficients the middle, which is valid; where the middle of densities lies beyond a table the coefficients
    // themselves still serve the rest of the plane.
    io::Scene middle = base_;
    for (const PlaneAxis* axis : {&x_, &y_})
        if (axis->density.empty()) axis->set(middle, 0.5 * (axis->from + axis->to));
    compiled_ = like != nullptr ? std::make_shared<const physics::Equations>(middle.model, *like->compiled_)
                                : std::make_shared<const physics::Equations>(middle.model);
    theory_ = std::make_shared<const theory::PointTheory>(compiled_->theory());
    search_ = like != nullptr ? like->search_ : theory::order_search(theory_->solver());
    means_ = means_of(middle.model);
    x_change_ = change_of(x_, middle);
    y_change_ = change_of(y_, middle);
}

std::optional<PlaneModels::Change> PlaneModels::change_of(const PlaneAxis& axis, const io::Scene& middle) const {
    if (!axis.density.empty()) {
        for (const auto& [field, first] : model::placed_fields(theory_->equations().model()))
            if (field.name == axis.density) return Change{.component = static_cast<int>(first), .terms = {}};
        return {};  // a number in the terms
    }
    const auto coefficient = compiled_->coefficients.find(axis.name);
    const double base = axis.in(middle);
    if (coefficient == compiled_->coefficients.end() || coefficient->second.varies() || base == 0.0) return {};
    const std::vector<std::string>& names = compiled_->terms();
    Change change{.terms = {}, .base = base};
    for (std::size_t n = 0; n < names.size(); ++n)
        if (names[n] == axis.name) change.terms.push_back(n);
    // A balance needs a drag above 0: where it may not have it, each model is checked.
    const bool is_checked = axis.from <= 0.0 && std::ranges::any_of(change.terms, [&](std::size_t n) {
                                const std::string& symbol =
                                    theory_->equations().model().fields[theory_->equations().terms()[n].field].symbol;
                                return presence(middle.model, symbol) == physics::Presence::balance;
                            });
    if (change.terms.empty() || is_checked) return {};
    return change;
}

io::Scene PlaneModels::changed(const numerics::PlanePoint& point) const {
    io::Scene result = base_;
    x_.set(result, point.x);
    y_.set(result, point.y);
    return result;
}

std::string PlaneModels::place_of(const numerics::PlanePoint& point) const {
    return text("at {} = {}, {} = {}", x_.name, point.x, y_.name, point.y);
}

model::UniformState PlaneModels::means_of(const physics::ModelValues& model) const {
    model::UniformState means(static_cast<std::size_t>(theory_->equations().components()), 0.0);
    for (const auto& [field, first] : model::placed_fields(theory_->equations().model()))
        if (field.spin == 0) means[first] = number(model, mean_of + field.name);
    return means;
}

void PlaneModels::visit_theory(const theory::PointTheory& theory, const model::UniformState& means,
                               const std::function<void(const MarginOfLimit&)>& use) const {
    theory::PointMargins margins(theory, means, search_);
    use([&](theory::Limit limit) { return margins.at(limit); });
}

void PlaneModels::visit_changes(const numerics::PlanePoint& point,
                                const std::function<void(const MarginOfLimit&)>& use) const {
    model::UniformState means = means_;
    std::vector<double> factors(compiled_->terms().size(), 1.0);
    for (const auto& [change, number, value] :
         {std::tuple{&*x_change_, &x_, point.x}, std::tuple{&*y_change_, &y_, point.y}}) {
        if (change->component >= 0) means[static_cast<std::size_t>(change->component)] = value / number->area;
        for (const std::size_t n : change->terms) factors[n] *= value / change->base;
    }
    if (x_change_->terms.empty() && y_change_->terms.empty()) return visit_theory(*theory_, means, use);
    const auto solver = [this, point] { return physics::Equations(changed(point).model).solver(); };
    visit_theory(theory_->scaled(factors, solver), means, use);
}

void PlaneModels::visit(const numerics::PlanePoint& point, const std::function<void(const MarginOfLimit&)>& use) const {
    try {
        if (x_change_ && y_change_) return visit_changes(point, use);
        const io::Scene here = changed(point);
        if (base_.kind == io::SceneKind::model) {
            const model::Equations equations(io::model_of(here.declared));
            return visit_theory(theory::PointTheory(equations), equations.reference(), use);
        }
        const model::UniformState means = means_of(here.model);
        if (!theory_->rates(means).allFinite())  // beyond a table
            return use([](theory::Limit) { return theory::Margin{.value = nan}; });
        const auto equations = std::make_shared<const physics::Equations>(here.model, *compiled_);
        visit_theory(physics::Equations::theory(equations), means, use);
    } catch (const Error& error) {
        if (!is_of_scene(error.fault())) throw;
        fail_input({}, "{}: {}", place_of(point), error.what());
    }
}

theory::Margin PlaneModels::margin(const numerics::PlanePoint& point, theory::Limit limit) const {
    theory::Margin result;
    visit(point, [&](const MarginOfLimit& margin) { result = margin(limit); });
    return result;
}

model::Equations PlaneModels::equations(const numerics::PlanePoint& point) const {
    const io::Scene here = changed(point);
    try {
        return run::equations_of(here);
    } catch (const Error& error) {
        throw Error(error.fault(), {}, text("{}: {}", place_of(point), error.what()));
    }
}

std::vector<io::Scene> drawn_scenes(const io::Scene& scene, const std::vector<std::pair<PlaneNumber, double>>& errors) {
    const bool is_own = scene.kind == io::SceneKind::model;
    std::vector<UncertainNumber> uncertain = is_own ? std::vector<UncertainNumber>() : table_errors(scene.model);
    for (const auto& [number, error] : errors)
        uncertain.push_back({.error = error, .add = [number = number](io::Scene& of, double change) {
                                 number.set(of, number.in(of) + change);
                             }});
    const bool has_errors = !uncertain.empty() || (!is_own && !scene.found.filled.empty());
    const int count = scene.boundary.draws;
    if (!has_errors || count == 0) return {};
    std::vector<io::Scene> drawn;
    if (is_own) drawn.assign(static_cast<std::size_t>(count), scene);
    else
        for (physics::ModelValues& one : io::drawn_models(scene, count)) {
            drawn.push_back(scene);
            drawn.back().model = std::move(one);
        }
    for (std::size_t n = 0; n < uncertain.size(); ++n) {
        const std::vector<double> normal = normal_draws(random_ranks(n, 0, drawn.size()));
        for (std::size_t k = 0; k < drawn.size(); ++k) uncertain[n].add(drawn[k], normal[k] * uncertain[n].error);
    }
    if (drawn.empty())
        log_warning("none of {} draws of the numbers with errors is a valid model: the lines have no error bands",
                    count);
    return drawn;
}

}  // namespace drover::analysis
