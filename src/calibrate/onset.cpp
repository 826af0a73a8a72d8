// calibrate/onset.cpp: crossings of two smooth functions of a table, and of tables redrawn within their errors.
#include "drover/calibrate/onset.hpp"

#include <array>
#include <cmath>
#include <limits>

#include "drover/base/random.hpp"
#include "numerics/bracket.hpp"

namespace drover::calibrate {

const char* convention_name(Convention convention) { return convention == Convention::mean ? "mean" : "single-rod"; }

namespace {
constexpr double none = std::numeric_limits<double>::quiet_NaN();
constexpr std::array<const char*, 3> rows{"drag", "relaxation_rate", "weathercock"};

/// The nodes with places between them: equal parts of each interval.
std::vector<double> refined(const std::vector<double>& nodes, int parts) {
    std::vector<double> places;
    for (std::size_t i = 0; i + 1 < nodes.size(); ++i)
        for (int k = 0; k < parts; ++k) places.push_back(nodes[i] + (nodes[i + 1] - nodes[i]) * k / parts);
    places.push_back(nodes.back());
    return places;
}

/// The coefficients of one table, measured or redrawn.
struct Coefficients {
    SmoothCoefficient drag, relaxation, weathercock;
    Coefficients(const Table& table, std::size_t varied)
        : drag(table, rows[0], varied), relaxation(table, rows[1], varied), weathercock(table, rows[2], varied) {}

    /// Above 0 where flocks are expected; lambda alpha/Gamma - a, which knows of lambda = 0 and below.
    double excess(double bead, double rod, Convention convention) const {
        const double lambda = (convention == Convention::mean ? 1.0 : 2.0) * weathercock.table().at(bead, rod).value;
        return lambda * drag.table().at(bead, rod).value - relaxation.table().at(bead, rod).value;
    }
};

Table only(const Table& table) {
    Table few = table;
    few.rows.clear();
    for (const char* name : rows)
        if (const TableRow* row = find_row(table, name)) few.rows.push_back(*row);
    return few;
}

/// Every number moved by its error times a normal number of its own.
Table redrawn_table(const Table& table, std::uint64_t number) {
    Table moved = table;
    std::uint64_t part = 0;
    for (TableRow& row : moved.rows) {
        std::vector<double> normal(row.known.size());
        RandomKey key{.seed = number, .stream = Stream::bootstrap};
        key.substep = static_cast<std::uint32_t>(part++);
        fill_normal(key, 0, 1, normal);
        for (std::size_t i = 0; i < normal.size(); ++i) row.known[i].value += normal[i] * row.known[i].error;
    }
    return moved;
}

/// The first place where flocks begin; not-a-number when there is none.
double first_crossing(const Coefficients& coefficients, const std::vector<double>& beads, double rod,
                      Convention convention) {
    constexpr double tolerance = 1e-10;
    double before = coefficients.excess(beads.front(), rod, convention);
    for (std::size_t i = 1; i < beads.size(); ++i) {
        const double here = coefficients.excess(beads[i], rod, convention);
        if (before < 0.0 && here >= 0.0) {
            const auto at = [&](double t) {
                return coefficients.excess(beads[i - 1] + t * (beads[i] - beads[i - 1]), rod, convention);
            };
            std::size_t calls = 0;
            return beads[i - 1] +
                   numerics::sign_change(at, before, at(0.5), here, tolerance, calls) * (beads[i] - beads[i - 1]);
        }
        before = here;
    }
    return none;
}

Crossing crossing_of(const Coefficients& measured, const std::vector<Coefficients>& redrawn,
                     const std::vector<double>& beads, double rod, Convention convention) {
    Crossing crossing{.bead_fraction = first_crossing(measured, beads, rod, convention),
                      .error = none,
                      .above_all = measured.excess(beads.front(), rod, convention) >= 0.0};
    double count = 0.0, sum = 0.0, squares = 0.0;
    for (const Coefficients& one : redrawn) {
        const double place = first_crossing(one, beads, rod, convention);
        if (std::isnan(place)) continue;
        // About the crossing that was measured, or some place: sums of small numbers.
        const double from = std::isnan(crossing.bead_fraction) ? beads.front() : crossing.bead_fraction;
        count += 1.0, sum += place - from, squares += (place - from) * (place - from);
    }
    if (!redrawn.empty()) crossing.share = count / static_cast<double>(redrawn.size());
    if (count > 1.0 && !std::isnan(crossing.bead_fraction))
        crossing.error = std::sqrt((squares - sum * sum / count) / (count - 1.0));
    return crossing;
}

Uncertain threshold_of(const Uncertain& a, const Uncertain& lambda) {
    const double value = a.value / lambda.value;
    return {.value = value, .error = std::abs(value) * std::hypot(a.error / a.value, lambda.error / lambda.value)};
}
}  // namespace

Onset find_onset(const Table& table, std::size_t varied, int parts, int redrawn) {
    require(parts >= 1 && redrawn >= 0, {}, "{} parts of an interval, {} tables redrawn; expected 1 or more, 0 or more",
            parts, redrawn);
    require(table.bead_fractions.size() >= 2 && !table.rod_fractions.empty(), {},
            "the table has {} area fractions of beads and {} of rods; a boundary needs two or more, and one",
            table.bead_fractions.size(), table.rod_fractions.size());
    const Table few = only(table);
    const Coefficients measured(few, varied);
    std::vector<Coefficients> others;
    for (int i = 0; i < redrawn; ++i) others.emplace_back(redrawn_table(few, static_cast<std::uint64_t>(i)), varied);
    Onset onset{.bead_fractions = refined(table.bead_fractions, parts), .curves = {}, .line = {}};
    const auto crossings = [&](OnsetCurve& curve) {
        for (const Convention convention : {Convention::mean, Convention::single_rod})
            curve.crossings[static_cast<int>(convention)] =
                crossing_of(measured, others, onset.bead_fractions, curve.rod_fraction, convention);
    };
    for (const double rod : table.rod_fractions) {
        OnsetCurve curve{.rod_fraction = rod, .drag = {}, .threshold = {}};
        for (const double bead : onset.bead_fractions) {
            curve.drag.push_back(measured.drag.at(bead, rod));
            curve.threshold.push_back(
                threshold_of(measured.relaxation.at(bead, rod), measured.weathercock.at(bead, rod)));
        }
        crossings(curve);
        onset.curves.push_back(std::move(curve));
    }
    for (const double rod : refined(table.rod_fractions, parts)) {
        OnsetCurve point{.rod_fraction = rod, .drag = {}, .threshold = {}};
        crossings(point);
        onset.line.push_back(point);
    }
    return onset;
}

}  // namespace drover::calibrate
