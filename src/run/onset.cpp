// run/onset.cpp: the flocking thresholds of a table, described.
#include "drover/run/onset.hpp"

#include "drover/io/calibration.hpp"
#include "drover/io/scene_text.hpp"

#include <algorithm>
#include <cmath>

namespace drover::run {

namespace {
using calibrate::Convention;
constexpr Convention conventions[] = {Convention::mean, Convention::single_rod};

const calibrate::Crossing& crossing_of(const calibrate::OnsetCurve& curve, Convention convention) {
    return curve.crossings[static_cast<int>(convention)];
}

std::string convention_text(Convention convention) {
    return convention == Convention::mean ? "lambda = lambda_s/2, g = 2" : "lambda_s in place of lambda, g = 1";
}

/// Beyond the table: NaN, as a threshold that does not exist.
Entry quantile(const char* name, const char* percent, double value) {
    return {.name = name,
            .unit = "1",
            .meaning =
                text("{} % of the resampled tables have a threshold at or below; none in the table: not a number",
                     percent),
            .value = std::isfinite(value) ? value : std::nan(""),
            .digits = 3,
            .shown = {.text = false}};
}

Record crossing_record(const calibrate::Crossing& crossing, Convention convention) {
    const std::string words = ", " + convention_text(convention);
    return {.entries = {{.name = "bead_area_fraction",
                         .unit = "1",
                         .meaning = "flocking threshold Phi_b" + words,
                         .value = crossing.bead_fraction,
                         .dataset = "",
                         .digits = 4},
                        {.name = "error",
                         .unit = "1",
                         .meaning = "standard error of the flocking threshold" + words,
                         .value = crossing.error,
                         .digits = 2},
                        quantile("quantile_16", "16", crossing.quantiles[0]),
                        quantile("quantile_50", "50", crossing.quantiles[1]),
                        quantile("quantile_84", "84", crossing.quantiles[2]),
                        {.name = "share",
                         .unit = "1",
                         .meaning = "fraction of the resampled tables that have a threshold" + words,
                         .value = crossing.share,
                         .digits = 3},
                        {.name = "above_all",
                         .unit = "1",
                         .meaning = "1: flocks are predicted at the smallest Phi_b of the table already" + words,
                         .value = crossing.above_all,
                         .dataset = "above"}}};
}

std::string quantile_text(double value) {
    return std::isfinite(value) ? text("{:.3g}", value) : value > 0.0 ? "above the table" : "below the table";
}

std::string threshold_text(const calibrate::Crossing& crossing) {
    const std::string share =
        text("{:.0f} % of the tables resampled within their errors have one (16, 50, 84 %: {}, {}, {})",
             100.0 * crossing.share, quantile_text(crossing.quantiles[0]), quantile_text(crossing.quantiles[1]),
             quantile_text(crossing.quantiles[2]));
    const char* below = "below the smallest bead area fraction of the table";
    if (std::isnan(crossing.bead_fraction)) return (crossing.above_all ? below : "none in the table") + ("; " + share);
    return text("{}Phi_b = {}; {}", crossing.above_all ? text("{}, and again from ", below) : "",
                measured_text_with_error(crossing.bead_fraction, crossing.error), share);
}

Entry rod_entry(double fraction, const char* dataset) {
    return {.name = "rod_area_fraction", .unit = "1", .meaning = "Phi_r", .value = fraction, .dataset = dataset};
}

void add_crossings(const calibrate::OnsetCurve& curve, bool in_text, Record& record) {
    for (const Convention convention : conventions) {
        Record part = crossing_record(crossing_of(curve, convention), convention);
        part.shown.text = in_text;
        record.parts.emplace_back(calibrate::convention_name(convention), std::move(part));
    }
}

Record curve_point(const calibrate::OnsetCurve& curve, std::size_t i, double bead_fraction, bool is_node) {
    const auto speed = [](const char* name, const char* meaning, double value, int digits) {
        return Entry{.name = name, .unit = "mm s-1", .meaning = meaning, .value = value, .digits = digits};
    };
    return {.entries = {{.name = "bead_area_fraction",
                         .unit = "1",
                         .meaning = "Phi_b",
                         .value = bead_fraction,
                         .dataset = "bead_fraction"},
                        speed("drag", "alpha/Gamma", curve.drag[i].value, 4),
                        speed("drag_error", "standard error of alpha/Gamma", curve.drag[i].error, 2),
                        speed("threshold", "(a - c sigma)/lambda", curve.threshold[i].value, 4),
                        speed("threshold_error", "standard error of (a - c sigma)/lambda", curve.threshold[i].error, 2),
                        {.name = "gain",
                         .unit = "1",
                         .meaning = "g = 2 (lambda alpha/Gamma + c sigma)/a",
                         .value = curve.alignment[i],
                         .digits = 3}},
            .shown = {.text = is_node}};
}

/// Text shows the nodes of the table, archives and JSON the points between them too.
Record curve_record(const calibrate::Onset& onset, const calibrate::Table& table, const calibrate::OnsetCurve& curve) {
    List points{.name = "points", .group = "/curves", .coordinate = "bead_area_fraction"};
    for (std::size_t i = 0; i < onset.bead_fractions.size(); ++i) {
        const double bead = onset.bead_fractions[i];
        const bool is_node =
            std::find(table.bead_fractions.begin(), table.bead_fractions.end(), bead) != table.bead_fractions.end();
        points.rows.push_back(curve_point(curve, i, bead, is_node));
    }
    Record record{.heading = text("rod area fraction {}", curve.rod_fraction),
                  .entries = {rod_entry(curve.rod_fraction, "rod_fraction")},
                  .lists = {std::move(points)}};
    record.entries.front().shown.text = false;
    add_crossings(curve, false, record);
    for (const Convention convention : conventions)
        record.footer.push_back(text("flocking threshold ({}): {}", convention_text(convention),
                                     threshold_text(crossing_of(curve, convention))));
    return record;
}
}  // namespace

Result onset_result(const calibrate::Onset& onset, const calibrate::Table& table) {
    List curves{.name = "curves", .coordinate = "rod_area_fraction"};
    for (const calibrate::OnsetCurve& curve : onset.curves) curves.rows.push_back(curve_record(onset, table, curve));
    List line{.name = "line",
              .heading = "\nflocking threshold by rod area fraction, in both conventions of lambda",
              .group = "/line",
              .coordinate = "rod_area_fraction"};
    for (const calibrate::OnsetCurve& point : onset.line) {
        Record record{.entries = {rod_entry(point.rod_fraction, "line_rod_fraction")}};
        add_crossings(point, true, record);
        line.rows.push_back(std::move(record));
    }
    return {
        .root = {.header = {"flocks form where the gain g = 2 (lambda alpha/Gamma + c sigma)/a exceeds 2: where drag "
                            "= alpha/Gamma, the bead speed at P = 1, exceeds threshold = (a - c sigma)/lambda"},
                 .lists = {std::move(curves), std::move(line)}}};
}

namespace {
List cell_list(const std::vector<std::pair<calibrate::StatePoint, calibrate::CellPrediction>>& cells) {
    List list{.name = "cells",
              .heading =
                  "\norder P of the rods of one cell, as of few rods in mean field: mean, mean at g -+ one error, and "
                  "deviation in time",
              .row = "cell",
              .meaning = "point",
              .group = "/cells"};
    const auto number = [](const char* name, const char* meaning, double value, int digits) {
        return Entry{.name = name, .unit = "1", .meaning = meaning, .value = value, .digits = digits};
    };
    for (const auto& [point, cell] : cells)
        list.rows.push_back(
            {.entries = {number("bead_area_fraction", "Phi_b", point.bead_fraction, 4),
                         number("rod_area_fraction", "Phi_r", point.rod_fraction, 4),
                         number("rods", "number of rods of the cell", cell.rods, 6),
                         number("alignment", "g; above 2 a flock", cell.alignment.value, 3),
                         number("alignment_error", "standard error of g", cell.alignment.error, 2),
                         number("order", "mean of P, the mean orientation of these rods", cell.order, 3),
                         number("order_low", "the same at one standard error of g below", cell.low, 3),
                         number("order_high", "the same at one standard error of g above", cell.high, 3),
                         number("order_deviation", "standard deviation of P in time", cell.deviation, 2),
                         number("order_line", "mean of P at g = 2", cell.line, 2)}});
    return list;
}
}  // namespace

void add_cells(TableOnset& onset, double side, const std::vector<AreaFractions>& points) {
    require(side > 0.0, {.file = "--cell"}, "{} mm; expected the side of a cell, above 0", side);
    std::vector<calibrate::StatePoint> states;
    for (const auto& [bead, rod] : points) {
        require(bead > 0.0 && rod > 0.0, {.file = "--point"},
                "{},{}; expected area fractions of beads and rods above 0, such as 0.35,0.14", bead, rod);
        states.push_back(
            {.bead_fraction = bead, .rod_fraction = rod, .varied = onset.varied, .outside = physics::Outside::hold});
    }
    if (states.empty())
        for (const double bead : onset.table.bead_fractions)
            for (const double rod : onset.table.rod_fractions)
                states.push_back({.bead_fraction = bead, .rod_fraction = rod, .varied = onset.varied});
    std::vector<std::pair<calibrate::StatePoint, calibrate::CellPrediction>> cells;
    for (const calibrate::StatePoint& state : states)
        cells.emplace_back(state, calibrate::predict_cell(onset.table, state, side * side));
    onset.result.root.lists.push_back(cell_list(cells));
}

TableOnset make_onset(const std::filesystem::path& file, const std::optional<double>& varied) {
    const files::ArchiveReader archive(file);
    calibrate::Table table = io::read_calibration(archive, file.string());
    const std::size_t index = calibrate::varied_index(table, varied, "--varied", {.file = file.string()});
    Result result = onset_result(calibrate::find_onset(table, index), table);
    TableOnset made{.scene = io::parse_scene(archive.text_attribute("scene"), file.string() + " (its scene)"),
                    .table = std::move(table),
                    .varied = index,
                    .result = std::move(result)};
    made.result.attributes.emplace_back("table", file.string());
    return made;
}

}  // namespace drover::run
