// run/report.cpp: results of an archive and their predictions by linear theory.
#include "drover/run/report.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <tuple>

#include "drover/physics/fluctuations.hpp"
#include "drover/run/field_simulation.hpp"
#include "drover/run/warnings.hpp"
#include "run/sample_recording.hpp"

namespace drover::run {

namespace {
constexpr double nan = std::numeric_limits<double>::quiet_NaN();

/// Number of samples on the schedule: the last one may be off it.
std::size_t regular_samples(const std::vector<double>& times, double spacing) {
    std::size_t count = 0;
    while (count < times.size() && std::abs(times[count] - spacing * static_cast<double>(count)) < 1e-6 * spacing)
        ++count;
    return count;
}

/// The mean order of each sample after the warm-up.
std::vector<Eigen::Vector2d> mean_orders(const std::vector<measure::RecordedSeries>& series, std::size_t warm_up) {
    const std::vector<double>&x = measure::find_row(series, "polar_order_mean_x")->values,
          &y = measure::find_row(series, "polar_order_mean_y")->values;
    std::vector<Eigen::Vector2d> result;
    for (std::size_t i = warm_up; i < x.size(); ++i) result.emplace_back(x[i], y[i]);
    return result;
}

/// Number fluctuations in boxes from the structure factor of each mode.
void predict_boxes(const std::string& what, std::span<const double> structure_factor, Report& report) {
    const measure::FieldSetting& setting = report.setting;
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
                                          : nan);
        }
        report.predictions.insert(report.predictions.end(), {variance, deviation, exponent});
    }
}

/// Directions of the mean order of a run, with their fraction of its samples.  p and -p are equivalent: S(q) is the
/// same.
struct Direction {
    double angle = 0.0, fraction = 0.0;
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
                              .fraction = counts[bin] / static_cast<double>(orders.size())});
    return result;
}

/// The stationary state nearest to that of a run: by the mean order as a vector where a field sets its direction, else
/// by its magnitude.
const physics::StationaryState* nearest_state(const physics::StationaryStates& found,
                                              const std::vector<Eigen::Vector2d>& orders) {
    double size = 0.0;
    Eigen::Vector2d mean = Eigen::Vector2d::Zero();
    for (const Eigen::Vector2d& one : orders) {
        size += one.norm() / static_cast<double>(orders.size());
        mean += one / static_cast<double>(orders.size());
    }
    const bool is_oriented = std::none_of(found.states.begin(), found.states.end(),
                                          [](const auto& state) { return state.point.order.norm() == 0.0; });
    const auto distance = [&](const physics::StationaryState& state) {
        return is_oriented ? (state.point.order - mean).norm() : std::abs(state.point.order.norm() - size);
    };
    const physics::StationaryState* nearest = nullptr;
    for (const physics::StationaryState& state : found.states)
        if (!nearest || distance(state) < distance(*nearest)) nearest = &state;
    return nearest;
}

/// Structure factors about a flock, averaged over its directions, or about a state whose direction is imposed.
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
        const std::vector<physics::StructureFactor> modes = about(direction.angle);
        for (std::size_t m = 0; m < sum.size(); ++m) add_scaled(modes[m], direction.fraction, sum[m]);
    }
    return sum;
}

/// Structure factors of the modes of the grid about the state of the run; empty, with the reason, when there are none.
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
    const bool velocity = form.bead_velocity >= 0;  // a slaved velocity is not a field of the linear theory
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

Report summary_report(const io::Scene& scene, const Sampling& sampling, measure::Recorded& recorded) {
    recorded.spacing = sampling.spacing;
    recorded.warm_up = sampling.warm_up;
    Report report;
    report.scene = scene;
    report.time = sampling.end;
    report.summary = measure::summarise(recorded);
    return report;
}

Report make_field_report(const files::ArchiveReader& archive, const io::Scene& scene) {
    const physics::Equations equations(scene.model);
    measure::FieldSetting setting = measure::make_field_setting(scene.grid, physics::form(scene.model),
                                                                physics::kept_degree(equations, scene.dealiasing));
    if (scene.output.powers) {
        Threads one(1);
        setting.terms = physics::EnergyMeter(equations, scene.grid, scene.dealiasing, one).terms();
    }
    setting.watches_error = scene.time.max_error > 0.0;
    const Sampling sampling = sampling_of(archive, scene, field_samples_group);
    measure::Recorded recorded =
        measure::field_recording(setting, read_series(archive, field_samples_group, measure::field_observables(setting),
                                                      sampling.samples));
    Report report = summary_report(scene, sampling, recorded);
    report.setting = std::move(setting);
    predict(equations, mean_orders(recorded.series, report.summary.warm_up), report);
    report.warnings = field_warnings(archive, scene);
    return report;
}

std::vector<files::Axis> file_axes(const std::vector<measure::Axis>& axes) {
    std::vector<files::Axis> result;
    for (const measure::Axis& axis : axes) result.push_back({axis.name, axis.unit, axis.meaning, axis.values});
    return result;
}

const Prediction* find_prediction(const Report& report, const std::string& name) {
    for (const Prediction& prediction : report.predictions)
        if (prediction.name == name) return &prediction;
    return nullptr;
}

files::ResultTable result_table(const Report& report) {
    files::ResultTable table{.group = "/summary",
                             .axes = file_axes(measure::axes_of(report.summary.rows)),
                             .quantities = {},
                             .values = {},
                             .warnings = report.warnings};
    for (const measure::SummaryRow& row : report.summary.rows) {
        std::vector<double> means, errors, times;
        for (const measure::Estimate& estimate : row.estimates) {
            means.push_back(estimate.mean);
            errors.push_back(estimate.error.value_or(nan));
            times.push_back(estimate.autocorrelation_time);
        }
        const auto add = [&](const std::string& ending, const std::string& unit, const std::string& meaning,
                             std::vector<double> values) {
            table.quantities.push_back({row.name + ending, unit, meaning, measure::names_of(row.axes)});
            table.values.push_back(std::move(values));
        };
        add("", row.unit, row.formula, std::move(means));
        add("_error", row.unit, "standard error of " + row.name + "; NaN where there is no error estimate",
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
