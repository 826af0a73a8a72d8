// run/onset.cpp: tables of an onset.
#include "drover/run/onset.hpp"

#include <algorithm>
#include <cmath>

namespace drover::run {

namespace {
using calibrate::Convention;
constexpr Convention conventions[] = {Convention::mean, Convention::single_rod};

std::string uncertain_text(const calibrate::Uncertain& number) {
    return text("{:.4g} +- {:.2g}", number.value, number.error);
}

const calibrate::Crossing& crossing(const calibrate::OnsetCurve& curve, Convention convention) {
    return curve.crossings[static_cast<int>(convention)];
}

void add_curve(const calibrate::Onset& onset, const calibrate::Table& table, const calibrate::OnsetCurve& curve,
               std::string& out) {
    out += text("\nrod area fraction {}\n  {:>6} {:>22} {:>22} {:>8}\n", curve.rod_fraction, "Phi_b",
                "alpha/Gamma [mm/s]", "a/lambda [mm/s]", "g");
    for (std::size_t i = 0; i < onset.bead_fractions.size(); ++i) {
        const double bead = onset.bead_fractions[i];
        if (std::find(table.bead_fractions.begin(), table.bead_fractions.end(), bead) == table.bead_fractions.end())
            continue;
        out += text("  {:>6.4g} {:>22} {:>22} {:>8.3g}\n", bead, uncertain_text(curve.drag[i]),
                    uncertain_text(curve.threshold[i]), 2.0 * curve.drag[i].value / curve.threshold[i].value);
    }
    for (const Convention convention : conventions)
        out += text("  flocks ({}): {}\n",
                    convention == Convention::mean ? "lambda = lambda_s/2, g = 2" : "lambda_s taken for lambda, g = 1",
                    crossing_text(crossing(curve, convention)));
}
}  // namespace

std::string crossing_text(const calibrate::Crossing& crossing) {
    const std::string share = text("{:.0f} % of tables redrawn within their errors cross", 100.0 * crossing.share);
    if (std::isnan(crossing.bead_fraction))
        return (crossing.above_all ? "from the least area fraction of beads on; " : "no_location in the table; ") +
               share;
    return text("{}from Phi_b = {:.3g} +- {:.2g}; {}",
                crossing.above_all ? "at the least area fraction of beads, and after a dip " : "",
                crossing.bead_fraction, crossing.error, share);
}

std::string onset_text(const calibrate::Onset& onset, const calibrate::Table& table) {
    std::string out =
        "alpha/Gamma, the speed of the beads at P = 1, against a/lambda, which a flock has to have: g = 2 "
        "(alpha/Gamma)/(a/lambda)\n";
    for (const calibrate::OnsetCurve& curve : onset.curves) add_curve(onset, table, curve, out);
    out += text("\nthe line in the plane of both area fractions\n  {:>8} {:>22} {:>22}\n", "Phi_r", "Phi_b (mean)",
                "Phi_b (single-rod)");
    const auto place = [](const calibrate::Crossing& one) {
        if (std::isnan(one.bead_fraction)) return std::string(one.above_all ? "below the table" : "beyond the table");
        return text("{:.4g} +- {:.2g}", one.bead_fraction, one.error);
    };
    for (const calibrate::OnsetCurve& point : onset.line)
        out += text("  {:>8.4g} {:>22} {:>22}\n", point.rod_fraction, place(crossing(point, Convention::mean)),
                    place(crossing(point, Convention::single_rod)));
    return out;
}

std::vector<files::ResultTable> onset_tables(const calibrate::Onset& onset) {
    std::vector<double> rods, line_rods;
    std::vector<std::vector<double>> curves(4), line(8);
    for (const calibrate::OnsetCurve& curve : onset.curves) {
        rods.push_back(curve.rod_fraction);
        for (std::size_t i = 0; i < onset.bead_fractions.size(); ++i) {
            const double numbers[]{curve.drag[i].value, curve.drag[i].error, curve.threshold[i].value,
                                   curve.threshold[i].error};
            for (std::size_t c = 0; c < curves.size(); ++c) curves[c].push_back(numbers[c]);
        }
    }
    for (const calibrate::OnsetCurve& point : onset.line) {
        line_rods.push_back(point.rod_fraction);
        for (const Convention convention : conventions) {
            const calibrate::Crossing& one = crossing(point, convention);
            const std::size_t first = 4 * static_cast<std::size_t>(convention);
            line[first].push_back(one.bead_fraction);
            line[first + 1].push_back(one.error);
            line[first + 2].push_back(one.share);
            line[first + 3].push_back(one.above_all ? 1.0 : 0.0);
        }
    }
    const std::vector<std::string> both{"rod_fraction", "bead_fraction"}, rod{"line_rod_fraction"};
    const char* of_mean = "lambda = lambda_s/2: ";
    const char* of_single = "lambda_s taken for lambda: ";
    const auto words = [](const char* start, const char* rest) { return std::string(start) + rest; };
    const char *where = "Phi_b from which flocks are expected", *error = "standard error of it",
               *share = "part of the tables redrawn within their errors that cross",
               *above = "1: flocks are expected at the least Phi_b of the table already";
    return {{.group = "/curves",
             .axes = {{"rod_fraction", "1", "Phi_r", rods}, {"bead_fraction", "1", "Phi_b", onset.bead_fractions}},
             .quantities = {{"drag", "mm s-1", "alpha/Gamma", both},
                            {"drag_error", "mm s-1", "standard error of alpha/Gamma", both},
                            {"threshold", "mm s-1", "a/lambda", both},
                            {"threshold_error", "mm s-1", "standard error of a/lambda", both}},
             .values = curves},
            {.group = "/line",
             .axes = {{"line_rod_fraction", "1", "Phi_r", line_rods}},
             .quantities = {{"mean", "1", words(of_mean, where), rod},
                            {"mean_error", "1", words(of_mean, error), rod},
                            {"mean_share", "1", words(of_mean, share), rod},
                            {"mean_above", "1", words(of_mean, above), rod},
                            {"single_rod", "1", words(of_single, where), rod},
                            {"single_rod_error", "1", words(of_single, error), rod},
                            {"single_rod_share", "1", words(of_single, share), rod},
                            {"single_rod_above", "1", words(of_single, above), rod}},
             .values = line}};
}

}  // namespace drover::run
