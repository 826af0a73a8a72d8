// analysis/onset.cpp: the flocking thresholds of a table, described.
#include "analysis/onset.hpp"

#include "base/constants.hpp"
#include "io/calibration.hpp"
#include "io/scene.hpp"

#include <algorithm>
#include <cmath>

namespace drover::analysis {

namespace {
using calibrate::Convention;
constexpr int subdivisions = 10;  // of an interval between nodes: a crossing and a fall back between them are seen
constexpr Convention conventions[] = {Convention::mean, Convention::single_rod};

const calibrate::Crossings& crossings_of(const calibrate::OnsetCurve& curve, Convention convention) {
    return curve.crossings[static_cast<int>(convention)];
}

std::string convention_text(Convention convention) {
    return convention == Convention::mean ? "lambda = lambda_s/2, g = 2" : "lambda_s in place of lambda";
}

/// The first crossing from few beads to many at which flocks begin, and how many there are.
run::Record crossing_record(const calibrate::Crossings& crossings, Convention convention) {
    const std::string words = ", " + convention_text(convention);
    const auto& all = crossings.all;
    const auto found = std::ranges::find_if(all, [](const calibrate::Crossing& one) { return one.begins; });
    const calibrate::Crossing first =
        found != all.end() ? *found : calibrate::Crossing{.bead_fraction = nan, .low = nan, .high = nan};
    const auto entry = [&](const char* name, const std::string& meaning, double value, int digits) {
        return run::number(name, "1", meaning + words, value, digits);
    };
    return {
        .entries = {
            run::stored_as("", entry("bead_area_fraction", "flocking threshold Phi_b, the first from few beads on",
                                     first.bead_fraction, 4)),
            entry("low", "lower end of its error band (16 to 84 % of the draws predict flocks)", first.low, 3),
            entry("high", "upper end of its error band", first.high, 3),
            run::data_only(entry("error", "half of the width of its error band", 0.5 * (first.high - first.low), 2)),
            entry("crossings", "number of thresholds, at which flocks begin or end", static_cast<double>(all.size()),
                  3),
            entry("share", "fraction of the draws that have a threshold", crossings.any, 3),
            run::data_only(
                entry("share_as_many", "fraction of the draws that have as many thresholds", crossings.as_many, 3)),
            run::data_only(entry("share_more", "fraction of the draws that have more thresholds", crossings.more, 3)),
            run::stored_as("above",
                           run::flag("above_all",
                                     "1: flocks are predicted at the smallest Phi_b of the table already" + words,
                                     crossings.above_all))}};
}

std::string percent(double share) { return text("{:.3g} %", 100.0 * share); }

std::string crossing_text(const calibrate::Crossing& crossing) {
    const auto end = [](double value, const char* beyond) {
        return std::isfinite(value) ? text("{:.3g}", value) : std::string(beyond);
    };
    return text("{} at Phi_b = {:.3g} ({} to {})", crossing.begins ? "begin" : "end", crossing.bead_fraction,
                end(crossing.low, "below the table"), end(crossing.high, "above the table"));
}

/// All thresholds at one area fraction of rods, and how sure they are.
std::string threshold_text(const calibrate::Crossings& crossings) {
    std::vector<std::string> parts;
    if (crossings.above_all) parts.emplace_back("are predicted at the smallest Phi_b of the table");
    for (const calibrate::Crossing& one : crossings.all) parts.push_back(crossing_text(one));
    std::string words = "flocks " + (parts.empty() ? "are not predicted in the table" : joined(parts));
    const bool is_sure =
        std::ranges::all_of(crossings.all, [](const calibrate::Crossing& one) { return one.is_alone; });
    if (!is_sure) words += "; thresholds within one error band are consistent, within errors, with no threshold";
    const std::size_t count = crossings.all.size();
    words += count == 0 ? text("; {} of the draws have a threshold", percent(crossings.any))
                        : text("; {} of the draws have {} threshold{}, {} more", percent(crossings.as_many), count,
                               count == 1 ? "" : "s", percent(crossings.more));
    return words;
}

run::Entry rod_entry(double fraction, const char* dataset) {
    return run::stored_as(dataset, run::number("rod_area_fraction", "1", "Phi_r", fraction));
}

run::Entry bead_entry(double fraction) {
    return run::stored_as("bead_fraction", run::number("bead_area_fraction", "1", "Phi_b", fraction));
}

void add_crossings(const calibrate::OnsetCurve& curve, bool in_text, run::Record& record) {
    for (const Convention convention : conventions) {
        run::Record part = crossing_record(crossings_of(curve, convention), convention);
        part.shown.text = in_text;
        record.parts.emplace_back(name_of(convention), std::move(part));
    }
}

run::Record curve_point(const calibrate::OnsetCurve& curve, std::size_t i, double bead_fraction, bool is_node) {
    const std::string unit = "mm s-1";
    return {.entries = {bead_entry(bead_fraction), run::number("drag", unit, "alpha/Gamma", curve.drag[i].value, 4),
                        run::number("drag_error", unit, "standard error of alpha/Gamma", curve.drag[i].error, 2),
                        run::number("threshold", unit, "(a - c sigma)/lambda", curve.threshold[i].value, 4),
                        run::number("threshold_error", unit, "standard error of (a - c sigma)/lambda",
                                    curve.threshold[i].error, 2),
                        run::number("gain", "1", "g = 2 (lambda alpha/Gamma + c sigma)/a", curve.alignment[i], 3)},
            .shown = {.text = is_node}};
}

/// Text shows the nodes of the table, archives and JSON the points between them too.
run::Record curve_record(const calibrate::Onset& onset, const calibrate::Table& table,
                         const calibrate::OnsetCurve& curve) {
    run::List points{.name = "points", .group = "/curves", .coordinate = "bead_area_fraction"};
    for (std::size_t i = 0; i < onset.bead_fractions.size(); ++i) {
        const double bead = onset.bead_fractions[i];
        const bool is_node = std::ranges::find(table.bead_fractions, bead) != table.bead_fractions.end();
        points.rows.push_back(curve_point(curve, i, bead, is_node));
    }
    run::Record record{.heading = text("rod area fraction {}", curve.rod_fraction),
                       .entries = {run::data_only(rod_entry(curve.rod_fraction, "rod_fraction"))},
                       .lists = {std::move(points)}};
    add_crossings(curve, false, record);
    for (const Convention convention : conventions)
        record.footer.push_back(
            text("{}: {}", convention_text(convention), threshold_text(crossings_of(curve, convention))));
    return record;
}
/// Every threshold of every area fraction of rods.
run::List crossing_list(const calibrate::Onset& onset) {
    run::List list{.name = "crossings",
                   .row = "crossing",
                   .meaning = "thresholds, at which flocks begin or end",
                   .group = "/crossings",
                   .shown = {.text = false}};
    for (const calibrate::OnsetCurve& point : onset.plane)
        for (const Convention convention : conventions)
            for (const calibrate::Crossing& one : crossings_of(point, convention).all)
                list.rows.push_back(
                    {.entries = {rod_entry(point.rod_fraction, "crossing_rod_fraction"),
                                 run::choice("convention", "convention of lambda", name_of(convention),
                                             all_names<Convention>()),
                                 run::number("bead_area_fraction", "1", "Phi_b", one.bead_fraction),
                                 run::number("low", "1", "lower end of its error band; NaN below the table", one.low),
                                 run::number("high", "1", "upper end of its error band; NaN above the table", one.high),
                                 run::flag("begins", "1: flocks are predicted above it; 0: below it", one.begins),
                                 run::flag("alone",
                                           "1: no other threshold is in its error band; 0: consistent, within "
                                           "errors, with no threshold",
                                           one.is_alone)}});
    return list;
}

/// The excess and its error over the plane of both area fractions.
run::List field_list(const calibrate::Onset& onset) {
    run::List list{.name = "field", .coordinate = "rod_area_fraction", .shown = {.text = false}};
    for (const calibrate::OnsetCurve& row : onset.plane) {
        run::List points{.name = "points", .group = "/field", .coordinate = "bead_area_fraction"};
        for (std::size_t i = 0; i < onset.bead_fractions.size(); ++i) {
            run::Record point{.entries = {bead_entry(onset.bead_fractions[i])}};
            for (const Convention convention : conventions) {
                const calibrate::Crossings& at = crossings_of(row, convention);
                const std::string words = ", " + convention_text(convention);
                point.parts.emplace_back(
                    name_of(convention),
                    run::Record{
                        .entries = {run::number("excess", "s-1",
                                                "lambda alpha/Gamma + c sigma - a, positive where flocks form" + words,
                                                at.excess[i]),
                                    run::number("flocks", "1", "fraction of the draws that predict flocks" + words,
                                                at.share[i]),
                                    run::number("deviation", "1",
                                                "excess over its error: -1 to 1 in the error band" + words,
                                                at.deviation[i])}});
            }
            points.rows.push_back(std::move(point));
        }
        list.rows.push_back({.entries = {rod_entry(row.rod_fraction, "rod_fraction")}, .lists = {std::move(points)}});
    }
    return list;
}

/// Curves, over rod and bead area fraction; crossings in both conventions of lambda; and the line through them.
run::Result onset_result(const calibrate::Onset& onset, const calibrate::Table& table) {
    run::List curves{.name = "curves", .coordinate = "rod_area_fraction"};
    for (const calibrate::OnsetCurve& curve : onset.curves) curves.rows.push_back(curve_record(onset, table, curve));
    run::List line{.name = "line",
                   .heading = "\nfirst flocking threshold by rod area fraction, in both conventions of lambda",
                   .group = "/line",
                   .coordinate = "rod_area_fraction"};
    for (const calibrate::OnsetCurve& point : onset.plane) {
        run::Record record{.entries = {rod_entry(point.rod_fraction, "line_rod_fraction")}};
        add_crossings(point, true, record);
        line.rows.push_back(std::move(record));
    }
    return {
        .root = {.header = {"flocks form where the gain g = 2 (lambda alpha/Gamma + c sigma)/a exceeds 2: where "
                            "drag = alpha/Gamma, the bead speed at P = 1, exceeds threshold = (a - c "
                            "sigma)/lambda",
                            text("errors and bands: 16 to 84 % of {} draws of the table within its errors",
                                 onset.draws)},
                 .entries = {run::data_only(run::count("draws", "draws of the table within its errors", onset.draws))},
                 .lists = {std::move(curves), std::move(line), crossing_list(onset), field_list(onset)}}};
}

run::List cell_list(const calibrate::Table& table,
                    const std::vector<std::pair<calibrate::StatePoint, calibrate::CellPrediction>>& cells) {
    const auto is_beyond = [](const std::vector<double>& nodes, double at) {
        return at < nodes.front() || at > nodes.back();
    };
    run::List list{
        .name = "cells",
        .heading =
            "\norder P of the rods of one cell, as of few rods in mean field: mean, mean at g -+ one error, and "
            "deviation in time",
        .row = "cell",
        .meaning = "point",
        .group = "/cells"};
    const auto number = [](const char* name, const char* meaning, double value, int digits) {
        return run::number(name, "1", meaning, value, digits);
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
                         number("order_line", "mean of P at g = 2", cell.line, 2),
                         run::flag("held", "1: beyond the table, whose outermost coefficients are held there",
                                   is_beyond(table.bead_fractions, point.bead_fraction) ||
                                       is_beyond(table.rod_fractions, point.rod_fraction))}});
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
            {.bead_fraction = bead, .rod_fraction = rod, .varied = onset.varied, .outside = numerics::Outside::hold});
    }
    if (states.empty())
        for (const double bead : onset.table.bead_fractions)
            for (const double rod : onset.table.rod_fractions)
                states.push_back({.bead_fraction = bead, .rod_fraction = rod, .varied = onset.varied});
    std::vector<std::pair<calibrate::StatePoint, calibrate::CellPrediction>> cells;
    for (const calibrate::StatePoint& state : states)
        cells.emplace_back(state, calibrate::predict_cell(onset.table, state, side * side));
    onset.result.root.lists.push_back(cell_list(onset.table, cells));
}

TableOnset make_onset(const std::filesystem::path& file, const std::optional<double>& varied, int draws) {
    const files::ArchiveReader archive(file);
    calibrate::Table table = io::read_calibration(archive, file.string());
    const std::size_t index = calibrate::varied_index(table, varied, "--varied", {.file = file.string()});
    run::Result result = onset_result(calibrate::find_onset(table, index, subdivisions, draws), table);
    TableOnset made{.scene = io::parse_scene(archive.text_attribute("scene"), file.string() + " (its scene)"),
                    .table = std::move(table),
                    .varied = index,
                    .result = std::move(result)};
    made.result.attributes.emplace_back("table", file.string());
    return made;
}

}  // namespace drover::analysis
