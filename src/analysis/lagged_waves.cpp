// analysis/lagged_waves.cpp: correlations of waves about one uniform state.
#include "analysis/lagged_waves.hpp"

#include <cmath>

#include "base/constants.hpp"
#include "drover/theory/theory.hpp"
#include "run/fields/field_prediction.hpp"
#include "run/fields/scene_equations.hpp"

namespace drover::analysis {

namespace {
using Means = std::map<std::string, double>;

/// A uniform state, whose fields are turned by `turn` in the run.
struct AboutState {
    std::string name;
    double turn = 0.0;
    std::optional<model::LinearisedAt> linear;
    std::optional<std::string> why_none = {};  ///< why there is none, if so
};

/// Where a component stands in the matrix; of a field of spin m >= 1, which of its two parts it is.
struct Component {
    int place = 0, part = 0, spin = 0;
};

AboutState about_state(const io::Scene& scene, const model::Equations& equations, const Means& means) {
    if (!equations.has_noise()) return {.why_none = "the scene has no noise"};
    if (const model::TermSummary* placed = equations.placed_noise())
        return {.why_none = text("the noise \"{}\" depends on position or time", placed->text)};
    model::UniformState mean = equations.reference();
    for (std::size_t at = 0; const model::Field& field : equations.model().fields)
        for (const std::string& name : model::dataset_names(field)) {
            if (const auto given = means.find(name); given != means.end()) mean[at] = given->second;
            ++at;
        }
    const theory::StationaryStates found = run::states_of_run(scene, equations, {mean});
    if (found.states.empty()) return {.why_none = "there is no uniform stationary state: " + found.why_none};
    const theory::StationaryState* const nearest = theory::nearest_state(found, equations.model(), {mean});
    if (nearest->is_of_family)
        return {.why_none =
                    "the stationary states are a continuum, such as all phases of an amplitude, of which the "
                    "theory has one"};
    AboutState about{.name = nearest->name};
    about.linear.emplace(equations, nearest->values);
    if (nearest->has_free_direction)
        about.turn =
            run::turn_of(equations.model(), run::directing_component(equations.model(), nearest->values, {mean}),
                         nearest->values, mean);
    return about;
}

Component component_of(const model::Model& model, const std::string& name) {
    for (const auto& [field, first] : model::placed_fields(model))
        for (int part = 0; const std::string& own : model::dataset_names(field)) {
            if (own == name) return {static_cast<int>(first) + part, part, field.spin};
            ++part;
        }
    fail_input({}, "{} is no component of a field of this scene", name);
}

/// That of one component in the frame of the run, of a matrix in that of the state, which is turned by `turn`.
std::complex<double> element_of(const model::Symbol& matrix, const Component& component, double turn) {
    const int i = component.place;
    if (component.spin == 0) return matrix(i, i);
    const int first = i - component.part, second = first + 1;
    const double c = std::cos(component.spin * turn), s = std::sin(component.spin * turn);
    const double one = component.part == 0 ? c : s, other = component.part == 0 ? -s : c;
    return one * one * matrix(first, first) + other * other * matrix(second, second) +
           one * other * (matrix(first, second) + matrix(second, first));
}
}  // namespace

LaggedWaves lagged_waves(const io::Scene& scene, const Means& means, const std::string& name,
                         const std::vector<numerics::Wavevector>& waves, double interval, std::size_t lags) {
    const model::Equations equations = run::equations_of(scene);
    const Component component = component_of(equations.model(), name);
    const AboutState about = about_state(scene, equations, means);
    LaggedWaves result{.state = about.name, .values = {}, .why_none = about.why_none};
    if (result.why_none) return result;
    const double c = std::cos(about.turn), s = std::sin(about.turn);
    for (const numerics::Wavevector& wave : waves) {
        const numerics::Wavevector q{c * wave.x + s * wave.y, c * wave.y - s * wave.x};
        const theory::Correlations lagged = theory::lagged_covariances(*about.linear, q, interval, lags);
        if (!lagged.why_none.empty()) {
            result.values.insert(result.values.end(), lags, nan);
            if (!result.why_none) result.why_none = lagged.why_none;
        }
        for (const model::Symbol& matrix : lagged.matrices)
            result.values.push_back(element_of(matrix, component, about.turn));
    }
    return result;
}

}  // namespace drover::analysis
