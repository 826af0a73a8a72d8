// run/declared_boundary.cpp: margins and stable states of a declared model over a plane of its coefficients.
#include <cmath>
#include <memory>

#include "drover/base/draws.hpp"
#include "drover/run/progress.hpp"
#include "drover/run/signals.hpp"
#include "run/boundary_problem.hpp"
#include "run/model_coefficients.hpp"
#include "run/stability_problem.hpp"

namespace drover::run {

namespace {
using model::MarginState;

MarginState margin_state(const std::string& line) {
    return line == "isotropic" ? MarginState::isotropic : MarginState::ordered;
}

class ModelPlane {
public:
    using Changes = std::vector<std::pair<std::string, double>>;

    ModelPlane(const io::Scene& scene, const PlannedBoundary& plan, bool quiet)
        : declared_(scene.declared),
          x_(coefficient_of(scene, "", plan.x.name, {})),
          y_(coefficient_of(scene, "", plan.y.name, {})),
          search_(growth_search(scene)),
          progress_(std::make_unique<PointProgress>(least_points(scene, plan), quiet)) {
        if (scene.stability.min_wavenumber == 0.0) search_.min *= 100.0;  // the limit of long waves covers the rest
        search_.wavenumbers = 41;  // the least stable wave is refined: these find it
        search_.angles = 18;
        for (const double x : {0.5, 0.0, 1.0})
            for (const double y : {0.5, 0.0, 1.0})
                add_guesses(
                    at({plan.x.from + x * (plan.x.to - plan.x.from), plan.y.from + y * (plan.y.to - plan.y.from)}));
        for (const auto& [key, error] : plan.errors) uncertain_.emplace_back(coefficient_of(scene, "", key, {}), error);
    }

    /// Margins of one state, with other values of these coefficients.
    model::MarginOf margin(MarginState state, const Changes& others = {}) const {
        return [=, this](const numerics::PlanePoint& point) {
            check_stop_signal();
            progress_->add();
            Changes changes = at(point);
            changes.insert(changes.end(), others.begin(), others.end());
            return model::margin(equations_with(declared_, changes), state, guesses_, search_);
        };
    }
    /// The same with the uncertain coefficients drawn within their errors; NaN where a draw has no such state.
    std::vector<model::MarginOf> draws(MarginState state, std::size_t count) const {
        std::vector<Changes> drawn(count);
        for (std::size_t n = 0; n < uncertain_.size(); ++n) {
            const auto& [name, error] = uncertain_[n];
            const std::vector<double> normal = normal_draws(n, 0, count);
            for (std::size_t k = 0; k < drawn.size(); ++k)
                drawn[k].emplace_back(name, declared_.coefficients.at(name) + normal[k] * error);
        }
        std::vector<model::MarginOf> result;
        for (const Changes& one : drawn) result.push_back(model::where_valid(margin(state, one)));
        return result;
    }

private:
    /// The samples of each contour, at the corners and centres of its cells, and those of the map.
    static std::int64_t least_points(const io::Scene& scene, const PlannedBoundary& plan) {
        const std::int64_t cells = scene.boundary.cells, side = scene.boundary.map;
        return static_cast<std::int64_t>(plan.lines.size()) * ((cells + 1) * (cells + 1) + cells * cells + side * side);
    }

    Changes at(const numerics::PlanePoint& point) const { return {{x_, point.x}, {y_, point.y}}; }
    /// States differ little over a plane: those of its corners and middles lead to the others.
    void add_guesses(const Changes& changes) {
        for (const model::StationaryState& state : model::stationary_states(equations_with(declared_, changes)).states)
            guesses_.push_back(state.values);
    }

    io::DeclaredModel declared_;
    std::string x_, y_;
    Changes uncertain_;  // with their errors
    model::GrowthSearch search_;
    std::vector<model::UniformState> guesses_;
    std::unique_ptr<PointProgress> progress_;
};

DescribedLines described_state(const std::string& state) {
    return {.heading = text("the {} state becomes unstable", state),
            .names = {{.name = "state",
                       .unit = "",
                       .meaning = "the uniform state that becomes unstable",
                       .value = state,
                       .choices = line_names(io::SceneKind::model),
                       .shown = {.text = false}}},
            .shows_angles = state == "ordered",
            .shows_waves = true};
}

}  // namespace

BoundaryProblem declared_boundary(const io::Scene& scene, const PlannedBoundary& planned, bool quiet) {
    const auto plane = std::make_shared<const ModelPlane>(scene, planned, quiet);
    BoundaryProblem problem{.draws = planned.errors.empty() ? 0 : static_cast<std::size_t>(scene.boundary.draws)};
    std::vector<MarginState> states;
    for (const std::string& line : planned.lines) {
        states.push_back(margin_state(line));
        problem.lines.push_back(
            {.described = described_state(line), .margins = [plane, state = states.back(), count = problem.draws] {
                 return model::PlaneMargins{plane->margin(state), plane->draws(state, count)};
             }});
    }
    problem.map = {{"stable_states",
                    "1",
                    "-1 no uniform state, 0 none is stable, 1 isotropic, 2 ordered, 3 both",
                    {"map_y", "map_x"}}};
    problem.map_at = [plane, states](const numerics::PlanePoint& point) -> std::vector<double> {
        int stable = 0;
        bool found = false;
        for (const MarginState state : states) {
            const double margin = plane->margin(state)(point).value;
            found = found || !std::isnan(margin);
            if (margin > 0.0) stable += state == MarginState::isotropic ? 1 : 2;
        }
        return {found ? static_cast<double>(stable) : -1.0};
    };
    return problem;
}

}  // namespace drover::run
