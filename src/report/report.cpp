// report/report.cpp: the results of a run as tables for people, and as JSON.
#include <algorithm>
#include <cmath>
#include <map>
#include <nlohmann/json.hpp>

#include "drover/dem/bodies.hpp"
#include "report/shown.hpp"
#include "run/fields/step_bias.hpp"

namespace drover::report {

using run::Report;

namespace {
using measure::Nature;

/// A number with at most five digits, and none below its rounding.
std::string cell(double value, double rounding = 0.0) {
    if (!std::isfinite(value)) return text("{:>11}", "-");
    if (std::abs(value) <= rounding) return text("{:>11}", 0);
    const double digits = rounding > 0.0 ? std::ceil(std::log10(std::abs(value) / rounding)) : 5.0;
    return text("{:>11.{}g}", value, std::clamp(static_cast<int>(digits), 1, 5));
}

bool is_square(const measure::SummaryRow& row) {
    return row.nature == Nature::square || row.nature == Nature::square_area;
}

/// The field of which a row is: that of the longest name in its own.
const measure::MeasuredField* field_of(const Report& report, const measure::SummaryRow& row) {
    const std::string words = "_" + row.name + "_";
    const measure::MeasuredField* found = nullptr;
    std::size_t longest = 0;
    for (const measure::MeasuredField& field : report.setting.fields)
        for (const std::string& name : {field.name, field.short_name})
            if (name.size() > longest && words.find("_" + name + "_") != std::string::npos) {
                found = &field;
                longest = name.size();
            }
    return found;
}

/// Which numbers one may be a difference of: those of the field, or of its unit, and energies and powers of it; "":
/// of itself alone.
std::string summands_of(const Report& report, const measure::SummaryRow& row) {
    if (row.nature == Nature::ratio || is_square(row)) return "";
    const measure::MeasuredField* field = field_of(report, row);
    if (field != nullptr && row.unit == io::renamed(field->unit, report.scene.units)) return "field " + field->name;
    return row.nature == Nature::energy || row.unit != "1" ? "unit " + row.unit : "";
}

/// The largest of these numbers in the table.
double largest_of(const Report& report, const std::string& summands) {
    double largest = 0.0;
    for (const measure::SummaryRow& row : report.summary.rows) {
        const double mean = row.axes.empty() ? row.estimates.front().mean : 0.0;
        if (std::isfinite(mean) && summands_of(report, row) == summands) largest = std::max(largest, std::abs(mean));
    }
    return largest;
}

constexpr double rounding_error = 1e-12;  // of the largest of the numbers that a sum is of

/// Of a row that is a square of a field, or the product of two.
double rounding_of_square(const Report& report, const measure::SummaryRow& row) {
    const auto amplitude = [&](const measure::MeasuredField* field) {
        return rounding_error * (field ? largest_of(report, "field " + field->name) : 1.0);
    };
    const double area =
        io::has_grid(report.scene.kind) ? numerics::area(report.scene.grid) : dem::area(report.scene.particles.cell);
    for (const measure::MeasuredField& a : report.setting.fields)
        for (const measure::MeasuredField& b : report.setting.fields)
            if (row.name == measure::cross_name(a, b)) return amplitude(&a) * amplitude(&b) * area;
    const double one = amplitude(field_of(report, row));
    return one * one * (row.nature == Nature::square ? 1.0 : area);
}

/// What a number may be that would be zero without rounding: fields and energies are sums of terms as large as the
/// largest of them, variances and structure factors are squares of fields.
double rounding_of(const Report& report, const measure::SummaryRow& row) {
    if (is_square(row)) return rounding_of_square(report, row);
    if (!row.axes.empty() || row.nature == Nature::ratio) return 0.0;
    const std::string summands = summands_of(report, row);
    if (!summands.empty()) return rounding_error * largest_of(report, summands);
    // Other numbers without a unit, such as an order parameter, are of the order of 1 where they are not zero.
    return report.scene.kind == io::SceneKind::model ? 0.0 : rounding_error;
}

/// Whether a number without an error bar is zero up to rounding: its series is nothing but rounding.
bool is_zero(const measure::Estimate& estimate, double rounding) {
    return !estimate.error.value_or(0.0) && std::abs(estimate.mean) <= rounding;
}

std::string error_cell(const measure::Estimate& estimate, double rounding = 0.0) {
    if (is_zero(estimate, rounding)) return text("{:>9}", 0);
    return estimate.error ? text("{:>9.2g}", *estimate.error) : text("{:>9}", "n/a");
}

/// Bias by the time step.
std::string step_cell(const Report& report, const measure::SummaryRow& row, std::size_t component) {
    if (row.name == "step_error") return "";
    return "   " + run::step_bias_text(report.step_bias, report.scene, row.name, component, row.estimates[component]);
}

std::string mean_cell(const measure::Estimate& estimate, double rounding = 0.0) {
    if (!std::isfinite(estimate.mean) || !estimate.error || is_zero(estimate, rounding))
        return cell(estimate.mean, rounding);
    return text("{:>11}", measured_text(estimate.mean, *estimate.error));
}

double prediction_of(const Report& report, const measure::SummaryRow& row, std::size_t component) {
    const run::Prediction* prediction = measure::find_row(report.predictions, row.name);
    return prediction ? prediction->values[component] : NAN;
}

/// Mean and error; of a run of fields the prediction too, and (measured - predicted) in standard errors.
std::string cells(const Report& report, const measure::SummaryRow& row, std::size_t component, double rounding) {
    const measure::Estimate& estimate = row.estimates[component];
    const std::string measured = mean_cell(estimate, rounding) + " " + error_cell(estimate, rounding);
    if (!io::has_grid(report.scene.kind)) return measured;
    const double predicted = prediction_of(report, row, component), difference = estimate.mean - predicted;
    const bool has_deviation = estimate.error.value_or(0.0) > 0.0 && std::isfinite(predicted);
    return measured + " " + cell(predicted) + " " +
           (!has_deviation                     ? text("{:>7}", "-")
            : std::abs(difference) <= rounding ? text("{:>7}", "0.0")
                                               : text("{:>+7.1f}", difference / *estimate.error));
}

void add_scalars(const Report& report, std::string& out) {
    const bool has_step = report.scene.kind != io::SceneKind::particles;
    out += text("{:<28} {:>8} {:>11} {:>9} {:>9}{}\n", "observable", "unit", "mean", "error",
                text("tau [{}]", io::renamed("s", report.scene.units)), has_step ? "   step" : "");
    for (const measure::SummaryRow& row : report.summary.rows) {
        if (!row.axes.empty()) continue;
        const measure::Estimate& estimate = row.estimates.front();
        const double tau = estimate.autocorrelation_time, rounding = rounding_of(report, row);
        if (row.name == "step_error" && std::isnan(estimate.mean)) {
            out += text("{:<28} {:>8} not resolved (effort {:.3g} %)\n", row.name, row.unit,
                        100.0 * run::effort_of_estimates(report.scene));
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

/// One measured array over one axis, with the prediction of a run of fields.
void add_array(const Report& report, const measure::SummaryRow& row, std::string& out) {
    const measure::Axis& axis = row.axes.front();
    const bool is_of_fields = io::has_grid(report.scene.kind);
    const std::string heading = axis.name == "wavenumber" ? text("|q| [{}]", io::renamed("1/mm", report.scene.units))
                                                          : text("{} [{}]", axis.name, axis.unit);
    const std::size_t width = std::max<std::size_t>(11, heading.size());
    out += text("\n{} [{}]\n{:>{}} {:>11} {:>9}{}\n", row.name, row.unit, heading, width, "measured", "error",
                is_of_fields ? text(" {:>11} {:>7}   step", "linear", "sigmas") : "");
    const double rounding = rounding_of(report, row);
    for (const std::size_t i : log_spaced(axis.values.size(), 12))
        out += text("{:>{}.5g} {}{}\n", axis.values[i], width, cells(report, row, i, rounding),
                    is_of_fields ? step_cell(report, row, i) : "");
}

void add_boxes(const Report& report, const measure::MeasuredField& field, const measure::BoxFamily& family,
               std::string& out) {
    const std::string& what = field.counted;
    const auto row = [&](const char* result) {
        return measure::find_row(report.summary.rows, what + result + family.ending);
    };
    const measure::SummaryRow *number = row("_number"), *deviation = row("_number_deviation"),
                              *exponent = row("_number_exponent");
    if (number == nullptr || deviation == nullptr || exponent == nullptr) return;
    out += text("\nfluctuations of the {}, each in a {}: DN ~ N^exponent from each box to the next\n",
                what == field.name ? "amount of " + what : text("number of {}s", what), family.shape);
    out +=
        text("{:>11} {:>11} {:>11} {:>9} {:>11} {:>7}   {:>9} {:>9} {:>9}   step (of DN)\n",
             family.along_x == family.along_y ? text("side [{}]", io::renamed("mm", report.scene.units)) : "short side",
             "N", "DN", "error", "linear", "sigmas", "exponent", "error", "linear");
    const auto exponent_cell = [](double value) {
        return std::isfinite(value) ? text("{:>9.4f}", value) : text("{:>9}", "-");
    };
    for (std::size_t b = 0; b < number->estimates.size(); ++b) {
        const std::string exponents =
            b + 1 == number->estimates.size()
                ? std::string(32, ' ')
                : text("   {} {} {}", exponent_cell(exponent->estimates[b].mean), error_cell(exponent->estimates[b]),
                       exponent_cell(prediction_of(report, *exponent, b)));
        out += text("{} {} {}{}{}\n", cell(number->axes.front().values[b]), mean_cell(number->estimates[b]),
                    cells(report, *deviation, b, 0.0), exponents, step_cell(report, *deviation, b));
    }
}

/// Of a run of fields structure factors and number fluctuations; the archive and --json have all arrays.
void add_arrays(const Report& report, std::string& out) {
    const bool is_of_fields = io::has_grid(report.scene.kind);
    for (const measure::SummaryRow& row : report.summary.rows)
        if (row.axes.size() == 1 && (!is_of_fields || row.axes.front().name == "wavenumber"))
            add_array(report, row, out);
    // Long boxes differ from square ones only in a flock.
    for (const measure::BoxFamily& family : measure::box_families())
        if (family.along_x == family.along_y || report.about_flock)
            for (const measure::MeasuredField& field : report.setting.fields) add_boxes(report, field, family, out);
    if (!report.about.empty()) out += "\nlinear: the linear theory about " + report.about + ", on the same grid\n";
    if (!report.no_prediction.empty()) out += "\nno linear prediction: " + report.no_prediction + "\n";
}
}  // namespace

std::string text_of(const Report& report) {
    const measure::Summary& summary = report.summary;
    std::string out =
        text("t = 0 to {}, {} samples, the first {} left out as warm-up\n",
             io::in_unit("{:.6g}", report.time, "s", report.scene.units), summary.samples, summary.warm_up);
    for (const std::string& warning : report.warnings) out += "warning: " + warning + "\n";
    add_scalars(report, out);
    add_arrays(report, out);
    if (!summary.note.empty()) out += "\nnote: " + summary.note + "\n";
    const measure::SummaryRow* slowest = nullptr;  // the one that needs the longest run
    for (const measure::SummaryRow& row : summary.rows)
        if (row.axes.empty() && !row.estimates.front().error &&
            row.estimates.front().averaging != measure::Averaging::maximum &&
            row.name != "energy_balance" &&  // rounding alone
            (slowest == nullptr ||
             row.estimates.front().autocorrelation_time > slowest->estimates.front().autocorrelation_time))
            slowest = &row;
    std::string shown = slowest != nullptr ? slowest->estimates.front().why_no_error : "";
    if (slowest != nullptr) out += "\nnote: " + slowest->name + ": " + shown + "\n";
    for (const measure::SummaryRow& row : summary.rows) {
        if (!row.axes.empty() || std::isfinite(row.estimates.front().mean)) continue;
        const std::string& why_no_error = row.estimates.front().why_no_error;
        if (!why_no_error.empty() && why_no_error != shown) out += "note: " + row.name + ": " + why_no_error + "\n";
        shown = why_no_error;  // rows with the same reason follow each other
    }
    return out;
}

nlohmann::json json_of(const Report& report) {
    const files::ResultTable table = run::result_table(report);
    std::map<std::string, std::vector<double>> numbers;
    for (std::size_t i = 0; i < table.values.size(); ++i) numbers[table.quantities[i].name] = table.values[i];
    nlohmann::json rows = nlohmann::json::object();
    for (const measure::SummaryRow& row : report.summary.rows) {
        nlohmann::json& entry = rows[row.name] = {{"unit", row.unit}, {"formula", row.formula}};
        std::vector<nlohmann::json> estimates;
        for (const measure::Estimate& estimate : row.estimates) {
            estimates.push_back({{"warm_up", run::number_json(estimate.warm_up)}, {"samples", estimate.samples}});
            if (!estimate.why_no_error.empty()) estimates.back()["refusal"] = estimate.why_no_error;
        }
        for (const std::string ending : measure::result_endings) {
            const std::vector<double>& values = numbers[row.name + ending];
            const std::string name = ending.empty() ? "mean" : ending.substr(1);
            for (std::size_t i = 0; i < values.size(); ++i)
                (ending == "_linear" ? entry[name][i] : estimates[i][name]) = run::number_json(values[i]);
        }
        if (row.axes.empty()) entry.update(estimates.front());
        else if (!estimates.empty()) entry["values"] = std::move(estimates);
    }
    return {{"time", report.time},
            {"samples", report.summary.samples},
            {"warm_up_samples", report.summary.warm_up},
            {"note", report.summary.note},
            {"warnings", report.warnings},
            {"no_prediction", report.no_prediction},
            {"linear_about", report.about},
            {"no_step_bias", name_of(report.step_bias.state)},
            {"results", std::move(rows)}};
}

}  // namespace drover::report
