// run/wish.cpp: wanted numbers from their texts and from archives.
#include "drover/run/wish.hpp"

#include <algorithm>
#include <charconv>
#include <regex>

#include "drover/base/error.hpp"
#include "drover/base/schema.hpp"
#include "drover/io/trajectory.hpp"
#include "drover/run/field_simulation.hpp"

namespace drover::run {

namespace {
[[noreturn]] void fail_wish(const std::string& given, const std::string& found) {
    fail_input({.file = "--want " + given},
               "{}; expected OBSERVABLE=ERROR, such as polar_order=1% (of the mean), polar_order=0.01 or "
               "structure_factor_rods(q<1)=3%",
               found);
}

double number_in(const std::string& given, const std::string& text) {
    double value = 0.0;
    const auto [end, problem] = std::from_chars(text.data(), text.data() + text.size(), value);
    if (problem != std::errc() || end != text.data() + text.size() || !std::isfinite(value))
        fail_wish(given, "\"" + text + "\" is not a number");
    return value;
}

/// The components of a row that a wish selects.
std::vector<std::size_t> selected(const Wish& wish, const measure::SummaryRow& row) {
    const SourceLocation where{.file = "--want " + wish.text};
    if (row.axes.empty()) {
        require(wish.axis.empty(), where, "{} is one number; expected a range only of an array: leave out ({})",
                wish.observable, wish.axis);
        return {0};
    }
    std::vector<std::size_t> result;
    if (wish.axis.empty()) {
        for (std::size_t i = 0; i < measure::size_of(row.axes); ++i) result.push_back(i);
        return result;
    }
    const std::vector<std::string> names = measure::names_of(row.axes);
    const auto named = std::find(names.begin(), names.end(), wish.axis == "q" ? "wavenumber" : wish.axis);
    require(named != names.end(), where, "{} has no axis \"{}\"; expected {}", wish.observable, wish.axis,
            joined(names));
    const auto axis = static_cast<std::size_t>(named - names.begin());
    std::size_t inner = 1;
    for (std::size_t k = axis + 1; k < row.axes.size(); ++k) inner *= row.axes[k].values.size();
    const std::vector<double>& values = row.axes[axis].values;
    for (std::size_t i = 0; i < measure::size_of(row.axes); ++i) {
        const double value = values[i / inner % values.size()];
        if (wish.min < value && value < wish.max) result.push_back(i);
    }
    require(!result.empty(), where,
            "{} has no component with {:.6g} < {} < {:.6g}; expected a range that meets {:.6g} "
            "to {:.6g}",
            wish.observable, wish.min, wish.axis, wish.max, *std::min_element(values.begin(), values.end()),
            *std::max_element(values.begin(), values.end()));
    return result;
}
}  // namespace

Wish parse_wish(const std::string& given) {
    static const std::regex form(R"(\s*([A-Za-z_0-9]+)\s*(?:\(([^()]*)\))?\s*=\s*([^%\s]+)\s*(%)?\s*)");
    std::smatch parts;
    if (!std::regex_match(given, parts, form)) fail_wish(given, "\"" + given + "\" is not a wanted number");
    Wish wish{.text = parts[1].str(), .observable = parts[1].str(), .is_relative = parts[4].matched};
    if (parts[2].matched) {
        const std::string range = parts[2].str();
        static const std::regex below(R"(\s*([A-Za-z_]+)\s*<\s*(\S+)\s*)"), above(R"(\s*([A-Za-z_]+)\s*>\s*(\S+)\s*)"),
            between(R"(\s*([^<\s]+)\s*<\s*([A-Za-z_]+)\s*<\s*(\S+)\s*)");
        std::smatch found;
        if (std::regex_match(range, found, between)) {
            wish.axis = found[2].str();
            wish.min = number_in(given, found[1].str());
            wish.max = number_in(given, found[3].str());
        } else if (std::regex_match(range, found, below)) {
            wish.axis = found[1].str();
            wish.max = number_in(given, found[2].str());
        } else if (std::regex_match(range, found, above)) {
            wish.axis = found[1].str();
            wish.min = number_in(given, found[2].str());
        } else {
            fail_wish(given, "\"" + range + "\" is not a range");
        }
        wish.text += "(" + range + ")";
    }
    wish.error = number_in(given, parts[3].str()) * (wish.is_relative ? 0.01 : 1.0);
    if (!(wish.error > 0.0)) fail_wish(given, "the error is " + parts[3].str() + ", not above 0");
    return wish;
}

WantedNumber wanted_number(const Wish& wish, const Report& report, const files::ArchiveReader& archive) {
    const measure::SummaryRow* row = measure::find_row(report.summary, wish.observable);
    if (row == nullptr) {
        std::vector<std::string> names;
        for (const measure::SummaryRow& one : report.summary.rows) names.push_back(one.name);
        const std::string near = nearest_name(wish.observable, names);
        fail_input({.file = "--want " + wish.text}, "the run has no observable \"{}\"; {}expected one of {}",
                   wish.observable, near.empty() ? "" : "did you mean " + near + "? ", joined(names));
    }
    const std::vector<std::size_t> components = selected(wish, *row);
    const auto count = static_cast<double>(components.size());
    WantedNumber number{.unit = row->unit};
    double squares = 0.0;
    for (const std::size_t i : components) {
        number.mean += row->estimates[i].mean / count;
        squares += std::pow(row->estimates[i].error.value_or(NAN) / count, 2);
    }
    if (std::isfinite(squares)) number.error = std::sqrt(squares);
    if (const Prediction* prediction = find_prediction(report, row->name)) {
        number.linear_theory = 0.0;
        for (const std::size_t i : components) *number.linear_theory += prediction->values[i] / count;
    }
    const char* group = report.scene.kind == io::SceneKind::fields ? field_samples_group : io::series_group;
    const std::string dataset = std::string(group) + "/" + row->name;
    if (!archive.has(dataset)) return number;
    const std::size_t size = measure::size_of(row->axes);
    const std::vector<double> values = archive.read(dataset).values;
    const std::size_t samples = std::min(values.size() / size, report.summary.samples);
    for (std::size_t s = 0; s < samples; ++s) {
        double mean = 0.0;
        for (const std::size_t i : components) mean += values[s * size + i] / count;
        number.series.push_back(mean);
    }
    return number;
}

}  // namespace drover::run
