// calibrate/onset.cpp: crossings of two interpolated rows of a table, with errors from redrawn tables.
#include "drover/calibrate/onset.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>

#include "calibrate/redraw.hpp"
#include "drover/physics/coefficients.hpp"
#include "numerics/bracket.hpp"

namespace drover::calibrate {

const char* convention_name(Convention convention) { return convention == Convention::mean ? "mean" : "single-rod"; }

namespace {
constexpr double none = std::numeric_limits<double>::quiet_NaN();
constexpr std::array<const char*, 5> rows{"drag", "relaxation_rate", "weathercock", "contact_alignment", "rod_area"};

std::optional<SmoothCoefficient> if_present(const Table& table, const char* name, std::size_t varied) {
    if (find_row(table, name) == nullptr) return std::nullopt;
    return SmoothCoefficient(table, name, varied);
}

/// The nodes and the points that divide each interval between them evenly.
std::vector<double> refined(const std::vector<double>& nodes, int subdivisions) {
    std::vector<double> points;
    for (std::size_t i = 0; i + 1 < nodes.size(); ++i)
        for (int k = 0; k < subdivisions; ++k)
            points.push_back(nodes[i] + (nodes[i + 1] - nodes[i]) * k / subdivisions);
    points.push_back(nodes.back());
    return points;
}

/// The coefficients of one table, measured or redrawn.
struct Coefficients {
    SmoothCoefficient drag, relaxation, weathercock;
    std::optional<SmoothCoefficient> contact, area;
    Coefficients(const Table& table, std::size_t varied)
        : drag(table, rows[0], varied),
          relaxation(table, rows[1], varied),
          weathercock(table, rows[2], varied),
          contact(if_present(table, rows[3], varied)),
          area(if_present(table, rows[4], varied)) {}

    /// c sigma; 0 in a table without c.
    Uncertain by_contacts(double bead, double rod) const {
        if (!contact || !area) return {};
        const double sigma = rod / area->at(bead, rod).value;
        const Uncertain c = contact->at(bead, rod);
        return {.value = c.value * sigma, .error = c.error * sigma};
    }
    /// lambda alpha/Gamma + c sigma - a: positive where flocks are expected, and valid for lambda <= 0.
    double excess(double bead, double rod, Convention convention) const {
        const double lambda = (convention == Convention::mean ? 1.0 : physics::single_rod_factor) *
                              weathercock.table().at(bead, rod).value;
        return lambda * drag.table().at(bead, rod).value + by_contacts(bead, rod).value -
               relaxation.table().at(bead, rod).value;
    }
    double alignment(double bead, double rod) const {
        const double a = relaxation.at(bead, rod).value;
        return 2.0 * (excess(bead, rod, Convention::mean) + a) / a;
    }
    Uncertain threshold(double bead, double rod) const {
        const Uncertain a = relaxation.at(bead, rod), lambda = weathercock.at(bead, rod), c = by_contacts(bead, rod);
        const double left = a.value - c.value, value = left / lambda.value;
        return {.value = value,
                .error = std::hypot(std::hypot(a.error, c.error), value * lambda.error) / std::abs(lambda.value)};
    }
};

/// The smallest area fraction of beads at which the excess becomes positive; NaN if there is none.
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
    std::vector<double> places;
    for (const Coefficients& one : redrawn) {
        const double crossed = first_crossing(one, beads, rod, convention);
        const bool above = std::isnan(crossed) && one.excess(beads.front(), rod, convention) >= 0.0;
        constexpr double beyond = std::numeric_limits<double>::infinity();
        places.push_back(!std::isnan(crossed) ? crossed : above ? -beyond : beyond);
        if (std::isnan(crossed)) continue;
        // Relative to the measured crossing, if any, to avoid cancellation.
        const double from = std::isnan(crossing.bead_fraction) ? beads.front() : crossing.bead_fraction;
        count += 1.0, sum += crossed - from, squares += (crossed - from) * (crossed - from);
    }
    if (!redrawn.empty()) crossing.share = count / static_cast<double>(redrawn.size());
    crossing.quantiles = quantiles_of(std::move(places));
    if (count > 1.0 && !std::isnan(crossing.bead_fraction))
        crossing.error = std::sqrt((squares - sum * sum / count) / (count - 1.0));
    return crossing;
}

void check_axes(const Table& table) {
    require(table.bead_fractions.size() >= 2 && !table.rod_fractions.empty(), {},
            "the table has {} area fractions of beads and {} of rods; a boundary needs at least two of beads and one "
            "of rods",
            table.bead_fractions.size(), table.rod_fractions.size());
}
}  // namespace

std::vector<OnsetPlace> find_crossings(const Table& table, std::size_t varied, const std::vector<double>& rod_fractions,
                                       int subdivisions) {
    check_axes(table);
    const Coefficients measured(table, varied);
    const std::vector<double> beads = refined(table.bead_fractions, subdivisions);
    std::vector<OnsetPlace> places;
    for (const double rod : rod_fractions) {
        OnsetPlace place{.bead_fraction = first_crossing(measured, beads, rod, Convention::mean),
                         .excess = measured.excess(beads.front(), rod, Convention::mean)};
        place.above_all = place.excess >= 0.0;
        constexpr double step = 1e-4;
        const double low = std::max(place.bead_fraction - step, beads.front()),
                     high = std::min(place.bead_fraction + step, beads.back());
        place.slope =
            std::isnan(place.bead_fraction)
                ? none
                : (measured.excess(high, rod, Convention::mean) - measured.excess(low, rod, Convention::mean)) /
                      (high - low);
        if (!place.above_all)
            for (const double bead : table.bead_fractions)
                place.excess = std::max(place.excess, measured.excess(bead, rod, Convention::mean));
        places.push_back(place);
    }
    return places;
}

Onset find_onset(const Table& table, std::size_t varied, int subdivisions, int redrawn) {
    require(subdivisions >= 1 && redrawn >= 0, {},
            "{} subdivisions of an interval, {} redrawn tables; expected at least 1 and at least 0", subdivisions,
            redrawn);
    check_axes(table);
    const Coefficients measured(table, varied);
    std::vector<Coefficients> others;
    for (const Table& one : redrawn_tables(table, {rows.begin(), rows.end()}, redrawn))
        others.emplace_back(one, varied);
    Onset onset{.bead_fractions = refined(table.bead_fractions, subdivisions), .curves = {}, .line = {}};
    const auto crossings = [&](OnsetCurve& curve) {
        for (const Convention convention : {Convention::mean, Convention::single_rod})
            curve.crossings[static_cast<int>(convention)] =
                crossing_of(measured, others, onset.bead_fractions, curve.rod_fraction, convention);
    };
    for (const double rod : table.rod_fractions) {
        OnsetCurve curve{.rod_fraction = rod, .drag = {}, .threshold = {}, .alignment = {}};
        for (const double bead : onset.bead_fractions) {
            curve.drag.push_back(measured.drag.at(bead, rod));
            curve.threshold.push_back(measured.threshold(bead, rod));
            curve.alignment.push_back(measured.alignment(bead, rod));
        }
        crossings(curve);
        onset.curves.push_back(std::move(curve));
    }
    for (const double rod : refined(table.rod_fractions, subdivisions)) {
        OnsetCurve point{.rod_fraction = rod, .drag = {}, .threshold = {}, .alignment = {}};
        crossings(point);
        onset.line.push_back(point);
    }
    return onset;
}

}  // namespace drover::calibrate
