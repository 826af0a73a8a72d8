// run/field_prediction.cpp: the nearest state, its directions in a run, and the mean of their structure factors.
#include "run/field_prediction.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "run/scene_equations.hpp"
#include "run/stability_problem.hpp"

namespace drover::run {

namespace {
using model::UniformState;
using std::numbers::pi;

/// Directions of samples and their shares.  Opposite ones are equivalent: S(q) is the same for both.
struct Direction {
    double angle = 0.0, share = 0.0;
};
std::vector<Direction> directions_of(const model::Model& model, const std::vector<UniformState>& samples) {
    constexpr int bins = 16;  // of 11 degrees, each represented by its mean
    std::array<double, bins> cosines{}, sines{};
    std::array<int, bins> counts{};
    for (const UniformState& sample : samples) {
        double angle = model::direction_of(model, sample);
        angle -= pi * std::floor(angle / pi);
        const auto bin = static_cast<std::size_t>(angle / pi * bins) % bins;
        cosines[bin] += std::cos(angle);
        sines[bin] += std::sin(angle);
        ++counts[bin];
    }
    std::vector<Direction> result;
    for (std::size_t bin = 0; bin < bins; ++bin)
        if (counts[bin] > 0)
            result.push_back({.angle = std::atan2(sines[bin], cosines[bin]),
                              .share = counts[bin] / static_cast<double>(samples.size())});
    return result;
}

UniformState turned(const model::Model& model, UniformState state, double angle) {
    std::size_t at = 0;
    for (const model::Field& field : model.fields) {
        if (field.spin > 0) {
            const double c = std::cos(field.spin * angle), s = std::sin(field.spin * angle), x = state[at];
            state[at] = c * x - s * state[at + 1];
            state[at + 1] = s * x + c * state[at + 1];
        }
        at += static_cast<std::size_t>(model::components(field));
    }
    return state;
}

model::StructureFactors mean_over_directions(const model::Equations& equations, const UniformState& state,
                                             const std::vector<Direction>& directions, const numerics::Grid& grid,
                                             int degree, Threads& threads) {
    const double along = model::direction_of(equations.model(), state);
    model::StructureFactors mean;
    for (const Direction& direction : directions) {
        const model::LinearisedAt at(equations, turned(equations.model(), state, direction.angle - along));
        model::StructureFactors one = model::structure_factors(at, grid, degree, threads);
        if (!one.why_none.empty()) return one;
        for (std::complex<double>& value : one.values) value *= direction.share;
        if (mean.values.empty()) mean = std::move(one);
        else std::ranges::transform(mean.values, one.values, mean.values.begin(), std::plus<>());
    }
    return mean;
}

/// The values of a state for people; of rods and beads the sizes alone, the densities being those of the scene.
std::string words_of(const io::Scene& scene, const model::Model& model, const UniformState& values) {
    if (scene.kind == io::SceneKind::model) return state_text(model, values);
    double order = 0.0, velocity = 0.0;
    std::size_t at = 0;
    for (const model::Field& field : model.fields) {
        if (field.symbol == "p") order = std::hypot(values[at], values[at + 1]);
        if (field.symbol == "v") velocity = std::hypot(values[at], values[at + 1]);
        at += static_cast<std::size_t>(model::components(field));
    }
    return text("|p| = {:.4g} and |v| = {:.4g} mm/s", order, velocity);
}
}  // namespace

std::vector<UniformState> sampled_means(const model::Equations& equations, const SeriesOf& series_of, std::size_t first,
                                        std::size_t stride) {
    std::vector<std::vector<double>> series;
    std::size_t count = 0;
    for (const model::Field& field : equations.model().fields) {
        const std::vector<std::string> names = model::dataset_names(field);
        for (const std::string& name : names) {
            series.push_back(series_of("mean_" + name));
            // Of rods and beads: polar_order_mean_x.
            if (series.back().empty() && names.size() == 2)
                series.back() = series_of(field.name + "_mean" + name.substr(field.name.size()));
            count = std::max(count, series.back().size());
        }
    }
    std::vector<UniformState> samples;
    for (std::size_t i = first; i < count; i += stride) {
        samples.push_back(equations.reference());
        for (std::size_t c = 0; c < series.size(); ++c)
            if (i < series[c].size()) samples.back()[c] = series[c][i];
    }
    return samples;
}

FieldPrediction predicted_fields(const io::Scene& scene, const model::Equations& equations,
                                 const std::vector<UniformState>& samples, int degree, Threads& threads) {
    FieldPrediction result;
    if (!equations.has_noise()) {
        result.why_none = "without noise the stationary state of the linear theory is uniform";
        return result;
    }
    if (const model::TermSummary* placed = equations.placed_term()) {
        result.why_none = placed->text + " depends on position or time: there is no uniform state";
        return result;
    }
    const model::StationaryStates found = stationary_states_of(scene);
    if (found.states.empty()) {
        result.why_none = "there is no uniform stationary state: " + found.why_none;
        return result;
    }
    const model::StationaryState& state = *model::nearest_state(found, equations.model(), samples);
    if (state.is_of_family) {
        result.why_none =
            "the stationary states are a continuum, such as all phases of an amplitude, of which the theory has one";
        return result;
    }
    result.about = text("the state \"{}\", {}", state.name.substr(0, state.name.find(',')),
                        words_of(scene, equations.model(), state.values));
    result.about_order = !state.is_isotropic;
    const bool turns = state.has_free_direction && !state.is_isotropic && !samples.empty();
    const std::vector<Direction> directions =
        turns ? directions_of(equations.model(), samples)
              : std::vector<Direction>{{.angle = model::direction_of(equations.model(), state.values), .share = 1.0}};
    result.modes = mean_over_directions(equations, state.values, directions, scene.grid, degree, threads);
    if (!result.modes.why_none.empty()) {
        result.why_none =
            text("the linear theory about {} has none: {}; see drover stability", result.about, result.modes.why_none);
        result.about.clear();
    }
    return result;
}

}  // namespace drover::run
