// run/report_text.cpp: the results of a run as tables for people.
#include <algorithm>
#include <cmath>

#include "drover/dem/bodies.hpp"
#include "drover/run/report.hpp"
#include "run/step_bias.hpp"

namespace drover::run {

namespace {
/// A number with at most five digits, and none below its rounding.
std::string cell(double value, double rounding = 0.0) {
    if (!std::isfinite(value)) return text("{:>11}", "-");
    if (std::abs(value) <= rounding) return text("{:>11}", 0);
    const double digits = rounding > 0.0 ? std::ceil(std::log10(std::abs(value) / rounding)) : 5.0;
    return text("{:>11.{}g}", value, std::clamp(static_cast<int>(digits), 1, 5));
}

/// The largest number in the table of the same unit.
double largest_of_unit(const Report& report, const std::string& unit) {
    double largest = 0.0;
    for (const measure::SummaryRow& row : report.summary.rows) {
        if (!row.axes.empty() || row.unit != unit) continue;
        if (const double mean = row.estimates.front().mean; std::isfinite(mean))
            largest = std::max(largest, std::abs(mean));
    }
    return largest;
}

/// What a number may be that would be zero without rounding: fields and energies are sums of terms as large as the
/// largest number of their unit, variances and structure factors are squares of fields.
double rounding_of(const Report& report, const measure::SummaryRow& row) {
    constexpr double relative = 1e-12;
    const bool is_structure_factor = row.name.starts_with("structure_factor_");
    if (!is_structure_factor && !row.name.starts_with("variance_") && !row.name.ends_with("_susceptibility"))
        return row.axes.empty() ? relative * largest_of_unit(report, row.unit) : 0.0;
    const auto is_of = [&](const char* field) { return row.name.find(field) != std::string::npos; };
    const char* field = is_of("order")      ? "polar_order_mean_x"
                        : is_of("velocity") ? "bead_velocity_mean_x"
                        : is_of("rod")      ? "max_rod_density"
                                            : "max_bead_density";
    const measure::SummaryRow* sized = measure::find_row(report.summary, field);
    const double amplitude = relative * (sized ? largest_of_unit(report, sized->unit) : 1.0);
    const bool is_variance = row.name.starts_with("variance_");
    const double area =
        io::has_grid(report.scene.kind) ? numerics::area(report.scene.grid) : dem::area(report.scene.particles.cell);
    return amplitude * amplitude * (is_variance ? 1.0 : area);
}

/// Whether a number without an error bar is zero up to rounding: its series is nothing but rounding.
bool is_zero(const measure::Estimate& estimate, double rounding) {
    return !estimate.error.value_or(0.0) && std::abs(estimate.mean) <= rounding;
}

std::string exponent_cell(double value) { return std::isfinite(value) ? text("{:>9.4f}", value) : text("{:>9}", "-"); }

std::string error_cell(const measure::Estimate& estimate, double rounding = 0.0) {
    if (is_zero(estimate, rounding)) return text("{:>9}", 0);
    return estimate.error ? text("{:>9.2g}", *estimate.error) : text("{:>9}", "n/a");
}

/// Bias by the time step.
std::string step_cell(const Report& report, const measure::SummaryRow& row, std::size_t component) {
    if (row.name == "step_error") return "";
    return "   " + step_bias_text(report.step_bias, report.scene, row.name, component, row.estimates[component]);
}

std::string mean_cell(const measure::Estimate& estimate, double rounding = 0.0) {
    if (!std::isfinite(estimate.mean) || !estimate.error) return cell(estimate.mean, rounding);
    return text("{:>11}", measured_text(estimate.mean, *estimate.error));
}

/// (measured - predicted) in standard errors.
std::string deviation_cell(const measure::Estimate& estimate, double predicted) {
    if (!estimate.error || !(*estimate.error > 0.0) || !std::isfinite(predicted)) return text("{:>7}", "-");
    return text("{:>+7.1f}", (estimate.mean - predicted) / *estimate.error);
}

void add_scalars(const Report& report, std::string& out) {
    const bool has_step = report.scene.kind != io::SceneKind::particles;
    out += text("{:<28} {:>8} {:>11} {:>9} {:>9}{}\n", "observable", "unit", "mean", "error", "tau [s]",
                has_step ? "   step" : "");
    for (const measure::SummaryRow& row : report.summary.rows) {
        if (!row.axes.empty()) continue;
        const measure::Estimate& estimate = row.estimates.front();
        const double tau = estimate.autocorrelation_time, rounding = rounding_of(report, row);
        if (row.name == "step_error" && std::isnan(estimate.mean)) {
            out += text("{:<28} {:>8} not resolved (effort {:.3g} %)\n", row.name, row.unit,
                        100.0 * effort_of_estimates(report.scene));
            continue;
        }
        const bool has_tau = std::isfinite(tau) && !is_zero(estimate, rounding);
        out += text("{:<28} {:>8} {} {} {:>9}{}\n", row.name, row.unit, mean_cell(estimate, rounding),
                    error_cell(estimate, rounding), has_tau ? text("{:.2g}", tau) : "-",
                    !has_step                     ? ""
                    : is_zero(estimate, rounding) ? "   -"
                                                  : step_cell(report, row, 0));
    }
}

/// One measured array with its prediction, at the chosen indices.
void add_array(const Report& report, const std::string& name, const std::string& heading, std::span<const double> axis,
               const std::vector<std::size_t>& chosen, std::string& out) {
    const measure::SummaryRow* row = measure::find_row(report.summary, name);
    if (row == nullptr) return;
    const Prediction* prediction = find_prediction(report, name);
    out += text("\n{} [{}]\n{:>11} {:>11} {:>9} {:>11} {:>7}   step\n", name, row->unit, heading, "measured", "error",
                "linear", "sigmas");
    const double rounding = rounding_of(report, *row);
    for (const std::size_t i : chosen) {
        const double predicted = prediction ? prediction->values[i] : NAN;
        out += text("{} {} {} {} {}{}\n", cell(axis[i]), mean_cell(row->estimates[i], rounding),
                    error_cell(row->estimates[i], rounding), cell(predicted),
                    deviation_cell(row->estimates[i], predicted), step_cell(report, *row, i));
    }
}

void add_boxes(const Report& report, const std::string& what, const measure::BoxFamily& family, std::string& out) {
    const auto row = [&](const char* result) {
        return measure::find_row(report.summary, what + result + family.ending);
    };
    const measure::SummaryRow *number = row("_number"), *deviation = row("_number_deviation"),
                              *exponent = row("_number_exponent");
    if (number == nullptr || deviation == nullptr || exponent == nullptr) return;
    const Prediction* linear = find_prediction(report, deviation->name);
    const Prediction* linear_exponent = find_prediction(report, exponent->name);
    out += text("\nfluctuations of the number of {}s, each in a {}: DN ~ N^exponent from each box to the next\n", what,
                family.shape);
    out +=
        text("{:>11} {:>11} {:>11} {:>9} {:>11} {:>7}   {:>9} {:>9} {:>9}   step (of DN)\n",
             family.along_x == family.along_y ? text("side [{}]", io::renamed("mm", report.scene.units)) : "short side",
             "N", "DN", "error", "linear", "sigmas", "exponent", "error", "linear");
    for (std::size_t b = 0; b < number->estimates.size(); ++b) {
        const double side = number->axes.front().values[b];
        const double predicted = linear ? linear->values[b] : NAN;
        out += text("{} {} {} {} {} {}", cell(side), mean_cell(number->estimates[b]),
                    mean_cell(deviation->estimates[b]), error_cell(deviation->estimates[b]), cell(predicted),
                    deviation_cell(deviation->estimates[b], predicted));
        if (b + 1 < number->estimates.size())
            out += text("   {} {} {}", exponent_cell(exponent->estimates[b].mean), error_cell(exponent->estimates[b]),
                        exponent_cell(linear_exponent ? linear_exponent->values[b] : NAN));
        else out += std::string(32, ' ');
        out += step_cell(report, *deviation, b) + '\n';
    }
}

/// At most `max` indices below `count`, evenly spaced on a logarithmic scale.
std::vector<std::size_t> log_spaced(std::size_t count, std::size_t max) {
    std::vector<std::size_t> chosen;
    for (std::size_t i = 0; i < std::min(count, max); ++i) {
        const double power = max <= 1 ? 0.0 : static_cast<double>(i) / static_cast<double>(std::min(count, max) - 1);
        auto index = static_cast<std::size_t>(std::lround(std::pow(static_cast<double>(count), power))) - 1;
        if (!chosen.empty()) index = std::max(index, chosen.back() + 1);
        if (index < count) chosen.push_back(index);
    }
    return chosen;
}
}  // namespace

namespace {
/// The arrays of a run of fields.
void add_field_arrays(const Report& report, std::string& out) {
    const std::vector<std::size_t> shells = log_spaced(report.setting.shells.q.size(), 12);
    const std::string wavenumber = text("|q| [{}]", io::renamed("1/mm", report.scene.units));
    for (const char* name :
         {"structure_factor_rods", "structure_factor_beads", "structure_factor_order_along",
          "structure_factor_order_across", "structure_factor_velocity_along", "structure_factor_velocity_across"})
        add_array(report, name, wavenumber, report.setting.shells.q, shells, out);
    // Long boxes differ from square ones only in a flock; the archive and --json always contain them.
    for (const measure::BoxFamily& family : measure::box_families())
        if (family.along_x == family.along_y || report.about_flock)
            for (const char* what : {"rod", "bead"}) add_boxes(report, what, family, out);
    if (!report.about.empty()) out += "\nlinear: the linear theory about " + report.about + ", on the same grid\n";
    if (!report.no_prediction.empty()) out += "\nno linear prediction: " + report.no_prediction + "\n";
}

/// Every array over one axis, at some of its coordinates, with its prediction.
void add_arrays(const Report& report, std::string& out) {
    const bool has_step = report.scene.kind != io::SceneKind::particles;
    for (const measure::SummaryRow& row : report.summary.rows) {
        if (row.axes.size() != 1) continue;
        const measure::Axis& axis = row.axes.front();
        const Prediction* prediction = find_prediction(report, row.name);
        out +=
            text("\n{} [{}]\n{:>20} {:>11} {:>9}{}{}\n", row.name, row.unit, axis.name + " [" + axis.unit + "]", "mean",
                 "error", prediction ? text(" {:>11} {:>7}", "linear", "(m-l)/e") : "", has_step ? "   step" : "");
        for (const std::size_t i : log_spaced(axis.values.size(), 12)) {
            out += text("{:>20.5g} {} {}", axis.values[i], mean_cell(row.estimates[i]), error_cell(row.estimates[i]));
            if (prediction)
                out += text(" {} {}", cell(prediction->values[i]),
                            deviation_cell(row.estimates[i], prediction->values[i]));
            out += (has_step ? step_cell(report, row, i) : "") + "\n";
        }
    }
    if (!report.about.empty()) out += "\nlinear: the linear theory about " + report.about + ", on the same grid\n";
    if (!report.no_prediction.empty()) out += "\nno linear prediction: " + report.no_prediction + "\n";
}
}  // namespace

std::string report_text(const Report& report) {
    const measure::Summary& summary = report.summary;
    std::string out = text("t = 0 to {:.6g} s, {} samples, the first {} left out as warm-up\n", report.time,
                           summary.samples, summary.warm_up);
    for (const std::string& warning : report.warnings) out += "warning: " + warning + "\n";
    add_scalars(report, out);
    if (report.scene.kind == io::SceneKind::fields) add_field_arrays(report, out);
    else add_arrays(report, out);
    if (!summary.note.empty()) out += "\nnote: " + summary.note + "\n";
    const measure::SummaryRow* slowest = nullptr;  // the one that needs the longest run
    for (const measure::SummaryRow& row : summary.rows)
        if (row.axes.empty() && !row.estimates.front().error &&
            (slowest == nullptr ||
             row.estimates.front().autocorrelation_time > slowest->estimates.front().autocorrelation_time))
            slowest = &row;
    if (slowest != nullptr) out += "\nnote: " + slowest->name + ": " + slowest->estimates.front().refusal + "\n";
    return out;
}

}  // namespace drover::run
