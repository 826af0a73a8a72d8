// jobs/campaign/accuracy_target.cpp: wanted numbers from their texts and from archives.
#include "jobs/campaign/accuracy_target.hpp"

#include <algorithm>
#include <cctype>
#include <charconv>

#include "base/mapped.hpp"
#include "drover/base/error.hpp"
#include "drover/base/schema.hpp"
#include "io/trajectory.hpp"
#include "run/number_lists.hpp"

namespace drover::jobs {

namespace {
[[noreturn]] void fail_target(const std::string& given, const std::string& found) {
    std::string name = trimmed(given.substr(0, given.find_first_of("=(")));
    if (name.empty()) name = "variance";
    fail_input({.file = "wanted number " + given},
               "{}; expected OBSERVABLE=ERROR, such as {}=1% (of its value), {}=0.01 or, of a part of an array, "
               "structure_factor(q<1)=3%",
               found, name, name);
}

double number_in(const std::string& given, const std::string& text) {
    double value = 0.0;
    const auto [end, problem] = std::from_chars(text.data(), text.data() + text.size(), value);
    if (problem != std::errc() || end != text.data() + text.size() || !std::isfinite(value))
        fail_target(given, "\"" + text + "\" is not a number");
    return value;
}

/// "q<1", "q>1" or "0.5<q<1".
AxisRange read_range(const std::string& given, const std::string& range) {
    AxisRange read;
    std::vector<std::string> parts;
    std::string signs;
    for (std::size_t from = 0;;) {
        const std::size_t sign = range.find_first_of("<>", from);
        parts.push_back(trimmed(range.substr(from, sign - from)));
        if (sign == std::string::npos) break;
        signs += range[sign];
        from = sign + 1;
    }
    if (signs == "<" || signs == ">") {
        read.axis = parts[0];
        (signs == "<" ? read.max : read.min) = number_in(given, parts[1]);
    } else if (signs == "<<") {
        read.min = number_in(given, parts[0]);
        read.axis = parts[1];
        read.max = number_in(given, parts[2]);
    }
    if (read.axis.empty()) fail_target(given, "\"" + range + "\" is not a range");
    return read;
}

/// The components of a row that a target selects.
std::vector<std::size_t> selected(const AccuracyTarget& target, const measure::SummaryRow& row) {
    const SourceLocation where{.file = "wanted number " + target.text};
    if (row.axes.empty()) {
        require(target.ranges.empty(), where, "{} is one number; expected a range only of an array: leave out ({})",
                target.observable, target.ranges.empty() ? "" : target.ranges.front().axis);
        return {0};
    }
    std::vector<std::size_t> result;
    if (target.ranges.empty()) {
        // Some components are undefined by their nature, such as the exponent of the largest box.
        for (std::size_t i = 0; i < measure::size_of(row.axes); ++i)
            if (row.estimates.size() <= i || !std::isnan(row.estimates[i].mean)) result.push_back(i);
        require(!result.empty(), where, "{} is undefined (NaN) in the whole run; expected a number", target.observable);
        return result;
    }
    require(target.ranges.size() == 1, where, "{} ranges; expected one", target.ranges.size());
    const AxisRange& range = target.ranges.front();
    const std::vector<std::string> names = measure::names_of(row.axes);
    const auto named = std::ranges::find(names, range.axis == "q" ? "wavenumber" : range.axis);
    require(named != names.end(), where, "{} has no axis \"{}\"; expected {}", target.observable, range.axis,
            joined(names));
    const auto axis = static_cast<std::size_t>(named - names.begin());
    std::size_t inner = 1;
    for (std::size_t k = axis + 1; k < row.axes.size(); ++k) inner *= row.axes[k].values.size();
    const std::vector<double>& values = row.axes[axis].values;
    for (std::size_t i = 0; i < measure::size_of(row.axes); ++i) {
        if (range.holds(values[i / inner % values.size()])) result.push_back(i);
    }
    require(!result.empty(), where,
            "{} has no component with {:.6g} < {} < {:.6g}; expected a range that meets {:.6g} "
            "to {:.6g}",
            target.observable, range.min, range.axis, range.max, *std::ranges::min_element(values),
            *std::ranges::max_element(values));
    return result;
}

/// value: what the number is, or is at most.
void require_small_error(const AccuracyTarget& target, const std::string& unit, double value, const char* is) {
    if (target.is_relative) return;
    const SourceLocation where{.file = "wanted number " + target.text};
    require(target.unit.empty() || target.unit == unit, where, "the error is in {}; expected {}, the unit of {}",
            target.unit, unit, target.text);
    require(!target.unit.empty() || target.error < 0.5 * std::abs(value), where,
            "the error {:.6g} has no unit, and the value {} {:.4g}{}; expected {}={:.6g}% (of its value), or with the "
            "unit {}=\"{:.6g} {}\"",
            target.error, is, value, unit == "1" ? "" : " " + unit, target.text, target.error, target.text,
            target.error, unit);
}

const measure::SummaryRow& row_of(const AccuracyTarget& target, const measure::Summary& summary) {
    if (const measure::SummaryRow* row = measure::find_row(summary.rows, target.observable)) return *row;
    const std::vector<std::string> names = mapped(summary.rows, &measure::SummaryRow::name);
    fail_input({.file = "wanted number " + target.text}, "the run has no observable \"{}\"; {}expected one of {}",
               target.observable, suggestion(target.observable, names, "", "did you mean {}? "), joined(names));
}
}  // namespace

AccuracyTarget parse_accuracy_target(const std::string& given) {
    const std::size_t equals = given.rfind('=');
    if (equals == std::string::npos) fail_target(given, "\"" + given + "\" is not a wanted number");
    std::string name = trimmed(given.substr(0, equals)), error = trimmed(given.substr(equals + 1));
    AccuracyTarget target;
    target.is_relative = error.ends_with('%');
    if (target.is_relative) error = trimmed(error.substr(0, error.size() - 1));
    const std::size_t open = name.find('(');
    if (open != std::string::npos && name.ends_with(')')) {
        target.text = name;
        target.ranges = mapped(run::split(name.substr(open + 1, name.size() - open - 2), ','),
                               [&](const std::string& range) { return read_range(given, range); });
        if (target.ranges.empty()) fail_target(given, "() holds no range");
        name = trimmed(name.substr(0, open));
    }
    const bool is_name = !name.empty() && std::ranges::all_of(name, [](char c) {
        return std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '_';
    });
    if (!is_name) fail_target(given, "\"" + name + "\" is not the name of an observable");
    target.observable = name;
    if (target.text.empty()) target.text = name;
    if (const std::size_t space = error.find(' '); !target.is_relative && space != std::string::npos) {
        target.unit = trimmed(error.substr(space));
        error = error.substr(0, space);
    }
    target.error = number_in(given, error) * (target.is_relative ? 0.01 : 1.0);
    if (!(target.error > 0.0)) fail_target(given, "the error is " + error + ", not above 0");
    return target;
}

std::vector<AccuracyTarget> parse_accuracy_targets(const std::vector<std::string>& given) {
    std::vector<AccuracyTarget> targets;
    for (const std::string& one : given) {
        targets.push_back(parse_accuracy_target(one));
        const auto is_same = [&](const AccuracyTarget& other) { return other.text == targets.back().text; };
        require(std::ranges::count_if(targets, is_same) == 1, {}, "wanted number {} is given twice; expected each once",
                targets.back().text);
    }
    return targets;
}

TargetOptions target_options(JobOptions job, const std::vector<std::string>& targets, double budget) {
    // Before the options: GCC 12 destroys their folder twice where a later initialiser throws.
    std::vector<AccuracyTarget> wanted = parse_accuracy_targets(targets);
    return {std::move(job), std::move(wanted), budget, budget};
}

void require_unit(const AccuracyTarget& target, const std::string& unit, double value) {
    require_small_error(target, unit, value, "is");
}

void require_plausible(const AccuracyTarget& target, const std::string& unit, bool is_fraction) {
    const bool is_at_most_1 = is_fraction || target.observable == "onset" || target.observable == "nematic_order" ||
                              target.observable.ends_with("area_fraction");
    require_small_error(target, unit, is_at_most_1 ? 1.0 : INFINITY, "is at most");
}

void require_plausible(const AccuracyTarget& target, const measure::Summary& summary) {
    const measure::SummaryRow& row = row_of(target, summary);
    selected(target, row);
    const bool is_size_of_order = measure::find_row(summary.rows, target.observable + "_binder") != nullptr;
    require_plausible(target, row.unit, is_size_of_order);
}

TargetNumber target_number(const AccuracyTarget& target, const run::Report& report,
                           const files::ArchiveReader& archive) {
    const measure::SummaryRow* row = &row_of(target, report.summary);
    const std::vector<std::size_t> components = selected(target, *row);
    const auto count = static_cast<double>(components.size());
    const auto mean_over = [&](const auto& value_of) {
        double mean = 0.0;
        for (const std::size_t i : components) mean += value_of(i) / count;
        return mean;
    };
    TargetNumber number{.mean = mean_over([&](std::size_t i) { return row->estimates[i].mean; }),
                        .unit = row->unit,
                        .spacing = report.scene.output.sample_every};
    // Of components that may rise and fall together, as boxes within boxes.
    const double error = mean_over([&](std::size_t i) { return row->estimates[i].error.value_or(NAN); });
    if (std::isfinite(error)) number.error = error;
    if (const run::Prediction* prediction = measure::find_row(report.predictions, row->name))
        number.linear_theory = mean_over([&](std::size_t i) { return prediction->values[i]; });
    const char* group = io::has_grid(report.scene.kind) ? run::field_samples_group : io::series_group;
    const std::string dataset = std::string(group) + "/" + row->name;
    if (!archive.has(dataset)) return number;
    const std::size_t size = measure::size_of(row->axes);
    const std::vector<double> values = archive.read(dataset).values;
    const std::size_t samples = std::min(values.size() / size, report.summary.samples);
    for (std::size_t s = 0; s < samples; ++s)
        number.series.push_back(mean_over([&](std::size_t i) { return values[s * size + i]; }));
    return number;
}

}  // namespace drover::jobs
