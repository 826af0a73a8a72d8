// run/fields/field_prediction.cpp: the nearest state, its directions in a run, and the mean of their structure factors.
#include "run/fields/field_prediction.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <complex>
#include <numbers>
#include <ranges>

#include "run/fields/scene_equations.hpp"
#include "theory/state_names.hpp"

namespace drover::run {

namespace {
using model::UniformState;
using std::numbers::pi;

/// Turns of a state in samples, and their shares.  Opposite ones are equivalent: S(q) is the same for both.
struct Direction {
    double angle = 0.0, share = 0.0;
};
std::vector<Direction> directions_of(const model::Model& model, const UniformState& state,
                                     const std::vector<UniformState>& samples) {
    constexpr int bins = 16;  // of 11 degrees, each represented by its mean
    std::array<double, bins> cosines{}, sines{};
    std::array<int, bins> counts{};
    const int directing = directing_component(model, state, samples);
    for (const UniformState& sample : samples) {
        double angle = turn_of(model, directing, state, sample);
        angle -= pi * std::floor(angle / pi);
        if (!(angle < pi)) angle = 0.0;  // of a rounding error below 0
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
    for (const auto& [field, at] : model::placed_fields(model)) {
        if (field.spin == 0) continue;
        const double c = std::cos(field.spin * angle), s = std::sin(field.spin * angle), x = state[at];
        state[at] = c * x - s * state[at + 1];
        state[at + 1] = s * x + c * state[at + 1];
    }
    return state;
}

/// The name and the values of a state for people; of rods and beads the sizes alone, since the scene has the densities.
std::string words_of(const io::Scene& scene, const model::Model& model, const theory::StationaryState& state) {
    const UniformState& values = state.values;
    if (scene.kind == io::SceneKind::model)
        return text("\"{}\", {}", state.is_isotropic ? "isotropic" : "ordered", theory::state_text(model, values));
    std::string sizes;
    for (const auto& [field, at] : std::views::reverse(model::placed_fields(model)))  // the order before its flow
        if (field.spin > 0)
            sizes += text("{}|{}| = {:.4g}{}", sizes.empty() ? ", " : " and ", field.symbol,
                          std::hypot(values[at], values[at + 1]),
                          field.unit == "1" ? "" : " " + io::renamed(field.unit, scene.units));
    return text("\"{}\"{}", state.name, sizes);
}
}  // namespace

int directing_component(const model::Model& model, const UniformState& state,
                        const std::vector<UniformState>& samples) {
    int best = -1;
    double min_scatter = 0.0;
    for (const auto& [field, at] : model::placed_fields(model)) {
        const double size = field.spin > 0 ? std::hypot(state[at], state[at + 1]) : 0.0;
        if (size == 0.0) continue;
        double sum = 0.0, squares = 0.0;
        for (const UniformState& sample : samples) {
            const double relative = std::hypot(sample[at], sample[at + 1]) / size;
            sum += relative;
            squares += relative * relative;
        }
        const auto count = static_cast<double>(std::max<std::size_t>(1, samples.size()));
        const double scatter = squares / count - std::pow(sum / count, 2);
        if (best < 0 || scatter <= min_scatter) best = static_cast<int>(at), min_scatter = scatter;
    }
    return best;
}

double turn_of(const model::Model& model, int directing, const UniformState& state, const UniformState& sample) {
    if (directing < 0) return 0.0;
    const auto at = static_cast<std::size_t>(directing);
    int spin = 1;
    for (const auto& [field, first] : model::placed_fields(model))
        if (first == at) spin = field.spin;
    const std::complex<double> here(sample[at], sample[at + 1]), there(state[at], state[at + 1]);
    return std::arg(here * std::conj(there)) / spin;
}

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

theory::StationaryStates states_of_run(const io::Scene& scene, const model::Equations& equations,
                                       const std::vector<UniformState>& samples) {
    if (scene.kind != io::SceneKind::model || samples.empty() || equations.placed_term() != nullptr)
        return stationary_states_of(scene, equations);
    return theory::stationary_states(equations, with_conserved_means(equations, samples.back()));
}

FieldPrediction predicted_fields(const io::Scene& scene, const model::Equations& equations,
                                 const std::vector<UniformState>& samples, const std::vector<PartPair>& pairs,
                                 int degree, Threads& threads, const theory::IsWanted& is_wanted) {
    if (!equations.has_noise())
        return {.why_none = "without noise the stationary state of the linear theory is uniform"};
    if (const std::string term = placed_term_of(scene, equations); !term.empty())
        return {.why_none = term + " depends on position or time: there is no uniform state"};
    const theory::StationaryStates found = states_of_run(scene, equations, samples);
    if (found.states.empty()) return {.why_none = "there is no uniform stationary state: " + found.why_none};
    const theory::StationaryState& state = *theory::nearest_state(found, equations.model(), samples);
    if (state.is_of_family)
        return {.why_none =
                    "the stationary states are a continuum, such as all phases of an amplitude, of which the "
                    "theory has one"};
    FieldPrediction result;
    result.about = text("the state {}", words_of(scene, equations.model(), state));
    if (!found.why_incomplete.empty()) result.about += ", the nearest of those found (" + found.why_incomplete + ")";
    result.about_order = !state.is_isotropic;
    const bool turns = state.has_free_direction && !state.is_isotropic && !samples.empty();
    const std::vector<Direction> directions = turns ? directions_of(equations.model(), state.values, samples)
                                                    : std::vector<Direction>{{.angle = 0.0, .share = 1.0}};
    result.powers.assign(pairs.size(), std::vector<double>(numerics::modes(scene.grid), 0.0));
    for (const Direction& direction : directions) {
        const model::LinearisedAt at(equations, turned(equations.model(), state.values, direction.angle));
        const theory::StructureFactors one = theory::structure_factors(at, scene.grid, degree, threads, is_wanted);
        if (!one.why_none.empty())
            return {.about_order = result.about_order,
                    .why_none = text("the linear theory about {} has none: {}; see drover stability", result.about,
                                     one.why_none)};
        for (std::size_t k = 0; k < pairs.size(); ++k)
            for (std::size_t m = 0; m < result.powers[k].size(); ++m)
                result.powers[k][m] += direction.share * one.at(m, pairs[k].first, pairs[k].second).real();
    }
    return result;
}

}  // namespace drover::run
