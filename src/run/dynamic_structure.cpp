// run/dynamic_structure.cpp: S(q, omega) about one uniform state, of rods and beads and of models of one's own.
#include "drover/run/dynamic_structure.hpp"

#include <cmath>
#include <functional>
#include <limits>

#include "drover/io/declared_model.hpp"
#include "drover/model/theory.hpp"
#include "drover/physics/fluctuations.hpp"
#include "drover/physics/linear_theory.hpp"
#include "drover/physics/predictions.hpp"
#include "drover/physics/stability.hpp"

namespace drover::run {

namespace {
using Means = std::map<std::string, double>;

/// A uniform state, whose fields are turned by `turn` in the run.
struct AboutState {
    std::string name;
    double turn = 0.0;
    std::function<bool(const numerics::Wavevector&)> grows;
    std::function<Eigen::MatrixXcd(const numerics::Wavevector&, double)> matrix;  // between all components
    std::string why_none;
};

/// Where a component stands in the matrix; of a field of spin m >= 1, which of its two parts it is.
struct Component {
    int place = 0, part = 0, spin = 0;
};

double mean_of(const Means& means, const std::string& name, double otherwise) {
    const auto found = means.find(name);
    return found == means.end() ? otherwise : found->second;
}

AboutState of_rods_and_beads(const io::Scene& scene, const Means& means) {
    AboutState about;
    const physics::Equations equations(scene.model);
    if (!physics::has_noise(scene.model.noise)) about.why_none = "the scene has no noise";
    else if (const std::string term = physics::nonuniform_term(equations); !term.empty())
        about.why_none = term + " depends on position or time: there is no uniform state";
    if (!about.why_none.empty()) return about;
    const physics::StationaryStates found = physics::stationary_states(equations);
    const Eigen::Vector2d order(mean_of(means, "polar_order_x", 0.0), mean_of(means, "polar_order_y", 0.0));
    const physics::StationaryState* state = physics::nearest_state(found, {order});
    if (state == nullptr) {
        about.why_none = "there is no uniform stationary state: " + found.no_order;
        return about;
    }
    about.name = state->name;
    if (state->free_direction) about.turn = std::atan2(order.y(), order.x());
    const physics::UniformPoint point = state->point;
    about.grows = [equations, point](const numerics::Wavevector& q) {
        return physics::modes(equations, point, q).grows();
    };
    about.matrix = [equations, point](const numerics::Wavevector& q, double omega) {
        return Eigen::MatrixXcd(physics::dynamic_structure_matrix(equations, point, q, omega));
    };
    return about;
}

AboutState of_own_model(const io::Scene& scene, const Means& means) {
    AboutState about;
    const model::Equations equations(io::model_of(scene.declared));
    if (!equations.has_noise()) about.why_none = "the scene has no noise";
    if (!about.why_none.empty()) return about;
    const model::StationaryStates found = model::stationary_states(equations);
    if (found.states.empty()) {
        about.why_none = "there is no uniform stationary state: " + found.why_none;
        return about;
    }
    model::UniformState mean = equations.reference();
    std::size_t at = 0;
    for (const model::Field& field : equations.model().fields)
        for (const std::string& name : model::dataset_names(field)) {
            mean[at] = mean_of(means, name, mean[at]);
            ++at;
        }
    const model::StationaryState* const nearest = model::nearest_state(found, equations.model(), mean);
    if (nearest->is_of_family) {
        about.why_none =
            "the stationary states are a continuum, such as all phases of an amplitude, of which the theory "
            "has one";
        return about;
    }
    about.name = nearest->name;
    const model::LinearisedAt linear(equations, nearest->values);
    if (nearest->has_free_direction) about.turn = model::direction_of(equations.model(), mean) - linear.direction();
    about.grows = [linear](const numerics::Wavevector& q) { return model::modes(linear, q).grows(); };
    about.matrix = [linear](const numerics::Wavevector& q, double omega) {
        return Eigen::MatrixXcd(model::dynamic_structure(linear, q, omega));
    };
    return about;
}

Component component_of(const io::Scene& scene, const std::string& name) {
    using physics::FieldIndex;
    std::map<std::string, Component> known;
    if (scene.kind != io::SceneKind::model)
        known = {{"bead_density", {FieldIndex::bead_density, 0, 0}},
                 {"rod_density", {FieldIndex::rod_density, 0, 0}},
                 {"bead_velocity_x", {FieldIndex::bead_velocity_x, 0, 1}},
                 {"bead_velocity_y", {FieldIndex::bead_velocity_y, 1, 1}},
                 {"polar_order_x", {FieldIndex::polar_order_x, 0, 1}},
                 {"polar_order_y", {FieldIndex::polar_order_y, 1, 1}}};
    else {
        int place = 0;
        for (const model::Field& field : io::model_of(scene.declared).fields) {
            int part = 0;
            for (const std::string& own : model::dataset_names(field)) known[own] = {place++, part++, field.spin};
        }
    }
    const auto found = known.find(name);
    require(found != known.end(), {}, "{} is no component of a field of this scene", name);
    return found->second;
}

/// The power of one component in the frame of the run, of a matrix in that of the state, which is turned by `turn`.
double power_of(const Eigen::MatrixXcd& matrix, const Component& component, double turn) {
    const int i = component.place;
    if (component.spin == 0) return matrix(i, i).real();
    const int first = i - component.part, second = first + 1;
    const double c = std::cos(component.spin * turn), s = std::sin(component.spin * turn);
    const double one = component.part == 0 ? c : s, other = component.part == 0 ? -s : c;
    return one * one * matrix(first, first).real() + other * other * matrix(second, second).real() +
           2.0 * one * other * matrix(first, second).real();
}
}  // namespace

DynamicStructure dynamic_structure(const io::Scene& scene, const Means& means, const std::string& name,
                                   const std::vector<numerics::Wavevector>& waves,
                                   const std::vector<double>& frequencies) {
    const Component component = component_of(scene, name);
    const AboutState about =
        scene.kind == io::SceneKind::model ? of_own_model(scene, means) : of_rods_and_beads(scene, means);
    DynamicStructure result{.state = about.name, .values = {}, .why_none = about.why_none};
    if (!result.why_none.empty()) return result;
    const double c = std::cos(about.turn), s = std::sin(about.turn);
    for (const numerics::Wavevector& wave : waves) {
        const numerics::Wavevector q{c * wave.x + s * wave.y, c * wave.y - s * wave.x};
        const bool grows = about.grows(q);
        for (const double omega : frequencies)
            result.values.push_back(grows ? std::numeric_limits<double>::quiet_NaN()
                                          : power_of(about.matrix(q, omega), component, about.turn));
    }
    return result;
}

}  // namespace drover::run
