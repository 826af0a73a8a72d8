// run/report.cpp: from an archive to results and their predictions.
#include "drover/run/report.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <tuple>

#include "drover/io/scene_text.hpp"
#include "drover/physics/fluctuations.hpp"
#include "drover/run/field_simulation.hpp"
#include "drover/run/kind.hpp"

namespace drover::run {

namespace {
constexpr double not_a_number = std::numeric_limits<double>::quiet_NaN();

/// Samples that stand on the schedule: the last one may not.
std::size_t regular_samples(const std::vector<double>& times, double spacing) {
    std::size_t count = 0;
    while (count < times.size() && std::abs(times[count] - spacing * static_cast<double>(count)) < 1e-6 * spacing)
        ++count;
    return count;
}

/// The mean order of each sample after the warm-up.
std::vector<Eigen::Vector2d> mean_orders(const std::vector<measure::Observable>& observables,
                                         const std::vector<std::vector<double>>& series, std::size_t warm_up) {
    std::array<const std::vector<double>*, 2> parts{};
    for (std::size_t o = 0; o < observables.size(); ++o) {
        if (observables[o].name == "polar_order_mean_x") parts[0] = &series[o];
        if (observables[o].name == "polar_order_mean_y") parts[1] = &series[o];
    }
    std::vector<Eigen::Vector2d> result;
    for (std::size_t i = warm_up; i < parts[0]->size(); ++i) result.emplace_back((*parts[0])[i], (*parts[1])[i]);
    return result;
}

/// Number fluctuations in boxes that follow from the structure factor of each mode.
void predict_boxes(const std::string& what, std::span<const double> structure_factor, Report& report) {
    const measure::Setting& setting = report.setting;
    std::vector<double> power(structure_factor.begin(), structure_factor.end());
    for (double& value : power) value /= numerics::area(setting.grid);
    for (const measure::BoxFamily& family : measure::box_families()) {
        const std::vector<int>& sides = setting.*family.sides;
        const auto named = [&](const char* result) { return what + "_number_" + result + family.ending; };
        Prediction variance{named("variance"), {}}, deviation{named("deviation"), {}}, exponent{named("exponent"), {}};
        for (const int side : sides)
            variance.values.push_back(
                numerics::box_variance(setting.grid, power, family.along_x * side, family.along_y * side));
        for (std::size_t b = 0; b < sides.size(); ++b) {
            deviation.values.push_back(std::sqrt(variance.values[b]));
            exponent.values.push_back(b + 1 < sides.size()
                                          ? 0.5 * std::log(variance.values[b + 1] / variance.values[b]) /
                                                (2.0 * std::log(static_cast<double>(sides[b + 1]) / sides[b]))
                                          : not_a_number);
        }
        report.predictions.insert(report.predictions.end(), {variance, deviation, exponent});
    }
}

/// Directions that the mean order of a run has taken, by their share of its samples: p and -p are one, for S(q) is that of both.
struct Direction {
    double angle = 0.0, share = 0.0;
};
std::vector<Direction> directions(const std::vector<Eigen::Vector2d>& orders) {
    constexpr int bins = 16;  // of 11 degrees, each about its own mean
    std::array<Eigen::Vector2d, bins> sums;
    std::array<int, bins> counts{};
    sums.fill(Eigen::Vector2d::Zero());
    for (const Eigen::Vector2d& order : orders) {
        double half = std::atan2(order.y(), order.x());
        if (half < 0.0) half += std::numbers::pi;
        if (half >= std::numbers::pi) half -= std::numbers::pi;
        const auto bin = static_cast<std::size_t>(half / std::numbers::pi * bins) % bins;
        sums[bin] += Eigen::Vector2d(std::cos(half), std::sin(half));
        ++counts[bin];
    }
    std::vector<Direction> result;
    for (std::size_t bin = 0; bin < bins; ++bin)
        if (counts[bin] > 0)
            result.push_back({.angle = std::atan2(sums[bin].y(), sums[bin].x()),
                              .share = counts[bin] / static_cast<double>(orders.size())});
    return result;
}

/// The stationary state that a run is in: by its mean order as a vector where a field holds the direction, else by the size of the order.
const physics::StationaryState* nearest_state(const physics::StationaryStates& found,
                                              const std::vector<Eigen::Vector2d>& orders) {
    double size = 0.0;
    Eigen::Vector2d mean = Eigen::Vector2d::Zero();
    for (const Eigen::Vector2d& one : orders) {
        size += one.norm() / static_cast<double>(orders.size());
        mean += one / static_cast<double>(orders.size());
    }
    const bool held = std::none_of(found.states.begin(), found.states.end(),
                                   [](const auto& state) { return state.point.order.norm() == 0.0; });
    const auto miss = [&](const physics::StationaryState& state) {
        return held ? (state.point.order - mean).norm() : std::abs(state.point.order.norm() - size);
    };
    const physics::StationaryState* nearest = nullptr;
    for (const physics::StationaryState& state : found.states)
        if (!nearest || miss(state) < miss(*nearest)) nearest = &state;
    return nearest;
}

/// Structure factors about a flock, over the directions that it has taken, or about a state that something from outside holds.
std::vector<physics::StructureFactor> flock_modes(const physics::Equations& equations,
                                                  const physics::StationaryState& flock, const Report& report,
                                                  const std::vector<Eigen::Vector2d>& orders) {
    Threads threads(choose_threads(report.scene));
    const auto about = [&](double angle) {
        physics::UniformPoint point = flock.point;
        if (flock.free_direction) {
            const Eigen::Rotation2D<double> turn(angle - physics::direction_of(point));
            point.order = turn * point.order;
            point.velocity = turn * point.velocity;
        }
        return physics::structure_factors(equations, point, report.setting.grid, report.setting.degree, threads);
    };
    if (!flock.free_direction) return about(0.0);
    std::vector<physics::StructureFactor> sum(numerics::modes(report.setting.grid));
    for (const Direction& direction : directions(orders)) {
        const std::vector<physics::StructureFactor> part = about(direction.angle);
        for (std::size_t m = 0; m < sum.size(); ++m) add_scaled(part[m], direction.share, sum[m]);
    }
    return sum;
}

/// Structure factors of the modes of the grid about the state that the run is in; empty, with the reason, when there are none.
std::vector<physics::StructureFactor> predicted_modes(const physics::Equations& equations, Report& report,
                                                      const std::vector<Eigen::Vector2d>& orders) {
    const numerics::System system =
        physics::linear_system(report.scene.model, report.scene.grid, report.scene.dealiasing);
    if (!system.noise) {
        report.no_prediction = "without noise the stationary state of the linear theory is uniform";
        return {};
    }
    const physics::StationaryStates states = physics::stationary_states(equations);
    const physics::StationaryState* state = nearest_state(states, orders);
    if (state == nullptr) {
        report.no_prediction = "there is no uniform stationary state: " + states.no_order;
        return {};
    }
    const std::string size = text("the state \"{}\", |p| = {:.4g} and |v| = {:.4g} mm/s", state->name,
                                  state->point.order.norm(), state->point.velocity.norm());
    const auto explain = [&](const Error& error, const std::string& fastest) {
        report.no_prediction = text("the linear theory about {} has {}{}", size, error.what(), fastest);
    };
    if (physics::is_isotropic(state->point)) {
        try {
            std::vector<physics::StructureFactor> modes = physics::structure_factors(system, report.setting.form);
            report.about = size;
            return modes;
        } catch (const Error& error) {
            const physics::FastestGrowth growth = physics::fastest_growth(system);
            explain(error, text(" (fastest rate {:.3g} /s at |q| = {:.3g} /mm)", growth.rate, growth.q));
            return {};
        }
    }
    try {
        std::vector<physics::StructureFactor> modes = flock_modes(equations, *state, report, orders);
        report.about = size;
        report.about_flock = state->point.order.norm() > 0.0;
        return modes;
    } catch (const Error& error) {
        explain(error, "; see drover stability");
        return {};
    }
}

void predict(const physics::Equations& equations, const std::vector<Eigen::Vector2d>& orders, Report& report) {
    const std::vector<physics::StructureFactor> modes = predicted_modes(equations, report, orders);
    if (modes.empty()) return;
    const auto values_of = [&](double physics::StructureFactor::*part) {
        std::vector<double> values;
        for (const physics::StructureFactor& mode : modes) values.push_back(mode.*part);
        return values;
    };
    using Part = physics::StructureFactor;
    const physics::Form& form = report.setting.form;
    const bool beads = form.bead_density >= 0, rods = form.rod_density >= 0;
    const bool velocity = form.bead_velocity >= 0;  // a slaved velocity is no field of the linear theory
    for (const auto& [name, part, has] :
         {std::tuple{"rods", &Part::rods, rods}, std::tuple{"beads", &Part::beads, beads},
          std::tuple{"beads_rods", &Part::beads_rods, beads && rods},
          std::tuple{"order_along", &Part::order_along, true}, std::tuple{"order_across", &Part::order_across, true},
          std::tuple{"velocity_along", &Part::velocity_along, velocity},
          std::tuple{"velocity_across", &Part::velocity_across, velocity}})
        if (has)
            report.predictions.push_back(
                {text("structure_factor_{}", name),
                 numerics::shell_means(report.setting.grid, report.setting.shells, values_of(part))});
    if (rods) predict_boxes("rod", values_of(&Part::rods), report);
    if (beads) predict_boxes("bead", values_of(&Part::beads), report);
}
}  // namespace

Sampling sampling_of(const files::ArchiveReader& archive, const io::Scene& scene, const std::string& group) {
    const std::vector<double> times = archive.read(group + "/time").values;
    const bool two_alone = scene.output.sample_every == 0.0;
    Sampling sampling{.end = times.empty() ? 0.0 : times.back(),
                      .spacing = two_alone ? scene.time.end : scene.output.sample_every,
                      .samples = 0,
                      .warm_up = std::nullopt};
    sampling.samples = regular_samples(times, sampling.spacing);
    if (scene.analysis.warm_up >= 0.0)
        sampling.warm_up = static_cast<std::size_t>(std::ceil(scene.analysis.warm_up / sampling.spacing - 1e-9));
    return sampling;
}

Report make_report(const files::ArchiveReader& archive) {
    const io::Scene scene = io::parse_scene(archive.text_attribute("scene"), archive.text_attribute("scene_file"));
    return kind_of(scene).report(archive, scene);
}

Report make_field_report(const files::ArchiveReader& archive, const io::Scene& scene) {
    Report report;
    report.scene = scene;
    const physics::Form form = physics::form(scene.model);
    const physics::Equations equations(scene.model);
    const int degree = physics::kept_degree(equations, scene.dealiasing);
    std::vector<std::string> terms;
    if (scene.output.powers) {
        Threads one(1);
        terms = physics::EnergyMeter(equations, scene.grid, scene.dealiasing, one).terms();
    }
    report.setting = measure::make_setting(scene.grid, form, degree, terms);
    const std::vector<measure::Observable> observables = measure::observables(form, scene.output.powers);
    report.axes = observable_axes(report.setting);
    const Sampling sampling = sampling_of(archive, scene, "/observables");
    report.time = sampling.end;
    std::vector<std::vector<double>> series;
    for (const measure::Observable& observable : observables) {
        series.push_back(archive.read("/observables/" + observable.name).values);
        series.back().resize(sampling.samples * measure::size_of(observable, report.setting));
    }
    measure::Recorded recorded{.setting = report.setting,
                               .observables = observables,
                               .series = series,
                               .spacing = sampling.spacing,
                               .warm_up = sampling.warm_up};
    // What is conserved, from the run itself: a start from a file may have another mean than the scene's uniform state.
    for (std::size_t o = 0; o < observables.size(); ++o)
        for (const auto& [name, total] :
             {std::pair{"rods_total", &recorded.rods}, std::pair{"beads_total", &recorded.beads}})
            if (observables[o].name == name && !series[o].empty()) *total = series[o].front();
    report.summary = measure::summarise(recorded);
    predict(equations, mean_orders(observables, series, report.summary.warm_up), report);
    return report;
}

const Prediction* find_prediction(const Report& report, const std::string& name) {
    for (const Prediction& prediction : report.predictions)
        if (prediction.name == name) return &prediction;
    return nullptr;
}

files::ResultTable result_table(const Report& report) {
    files::ResultTable table{.group = "/summary", .axes = report.axes, .quantities = {}, .values = {}};
    for (const measure::SummaryRow& row : report.summary.rows) {
        std::vector<double> means, errors, times;
        for (const measure::Estimate& estimate : row.estimates) {
            means.push_back(estimate.mean);
            errors.push_back(estimate.error.value_or(not_a_number));
            times.push_back(estimate.autocorrelation_time);
        }
        const auto add = [&](const std::string& ending, const std::string& unit, const std::string& meaning,
                             std::vector<double> values) {
            table.quantities.push_back({row.name + ending, unit, meaning, row.axes});
            table.values.push_back(std::move(values));
        };
        add("", row.unit, row.formula, std::move(means));
        add("_error", row.unit, "standard error of " + row.name + "; not-a-number where it was refused",
            std::move(errors));
        add("_autocorrelation_time", "s", "integrated autocorrelation time of " + row.name, std::move(times));
        if (const Prediction* prediction = find_prediction(report, row.name))
            add("_linear", row.unit, "linear theory of " + row.name + " on the same grid", prediction->values);
    }
    table.quantities.push_back({"warm_up", "s", "time left out of means at the start", {}});
    table.values.push_back(
        {static_cast<double>(report.summary.warm_up) *
         (report.scene.output.sample_every == 0.0 ? report.scene.time.end : report.scene.output.sample_every)});
    return table;
}

}  // namespace drover::run
