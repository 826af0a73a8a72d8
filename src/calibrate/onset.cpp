// calibrate/onset.cpp: crossings of two interpolated rows of a table, with errors from draws.
#include "calibrate/onset.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

#include "base/constants.hpp"
#include "base/draws.hpp"
#include "base/mapped.hpp"
#include "calibrate/closures.hpp"
#include "numerics/algebra/bracket.hpp"

namespace drover::calibrate {

namespace {
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

/// The coefficients of one table, measured or drawn.
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
    double by_contacts(double bead, double rod) const {
        if (!contact || !area) return 0.0;
        return contact->table().at(bead, rod).value * rod / area->table().at(bead, rod).value;
    }
    /// lambda alpha/Gamma + c sigma - a: positive where flocks are expected, and valid for lambda <= 0.
    double excess(double bead, double rod, Convention convention = Convention::mean) const {
        const double lambda =
            (convention == Convention::mean ? 1.0 : single_rod_factor) * weathercock.table().at(bead, rod).value;
        return lambda * drag.table().at(bead, rod).value + by_contacts(bead, rod) -
               relaxation.table().at(bead, rod).value;
    }
    double alignment(double bead, double rod) const {
        const double a = relaxation.table().at(bead, rod).value;
        return 2.0 * (excess(bead, rod) + a) / a;
    }
    double threshold(double bead, double rod) const {
        const double a = relaxation.table().at(bead, rod).value;
        return (a - by_contacts(bead, rod)) / weathercock.table().at(bead, rod).value;
    }
};

/// Changes of the sign of the excess along the area fraction of beads.
std::vector<Crossing> crossings_of(const Coefficients& coefficients, const std::vector<double>& beads, double rod,
                                   Convention convention) {
    constexpr double tolerance = 1e-10;
    std::vector<Crossing> found;
    double before = coefficients.excess(beads.front(), rod, convention);
    for (std::size_t i = 1; i < beads.size(); ++i) {
        const double here = coefficients.excess(beads[i], rod, convention);
        if ((before < 0.0) != (here < 0.0)) {
            const auto at = [&](double t) {
                return coefficients.excess(beads[i - 1] + t * (beads[i] - beads[i - 1]), rod, convention);
            };
            std::size_t calls = 0;
            const double part = numerics::sign_change(at, before, at(0.5), here, tolerance, calls);
            found.push_back({.bead_fraction = beads[i - 1] + part * (beads[i] - beads[i - 1]),
                             .begins = before < 0.0,
                             .low = nan,
                             .high = nan});
        }
        before = here;
    }
    return found;
}

/// The excess in all draws.
std::vector<double> excesses(const std::vector<Coefficients>& drawn, double bead, double rod, Convention convention) {
    return mapped(drawn, [&](const Coefficients& one) { return one.excess(bead, rod, convention); });
}

/// From a place with this deviation on, over the samples first, first + step, ...: where the linear interpolation of
/// their deviations passes -1 or 1.  NaN if it does not, or if one is NaN.
double band_end(double from, double deviation_there, int first, int step, const std::vector<double>& places,
                const std::vector<double>& deviations) {
    if (!(std::abs(deviation_there) <= 1.0)) return nan;
    double before = from, at_before = deviation_there;
    for (int i = first; i >= 0 && i < static_cast<int>(places.size()); i += step) {
        const double here = places[static_cast<std::size_t>(i)], at_here = deviations[static_cast<std::size_t>(i)];
        if (std::isnan(at_here)) return nan;
        if (std::abs(at_here) > 1.0)
            return before + (here - before) * (std::copysign(1.0, at_here) - at_before) / (at_here - at_before);
        before = here, at_before = at_here;
    }
    return nan;
}

/// The ends of the error band around each crossing.
void add_intervals(const std::vector<Coefficients>& drawn, const std::vector<double>& beads, double rod,
                   Convention convention, Crossings& crossings) {
    for (Crossing& one : crossings.all) {
        const int above = static_cast<int>(std::ranges::upper_bound(beads, one.bead_fraction) - beads.begin());
        std::vector<double> values = excesses(drawn, one.bead_fraction, rod, convention);
        std::ranges::sort(values);
        const double here = over_error(values);
        one.low = band_end(one.bead_fraction, here, above - 1, -1, beads, crossings.deviation);
        one.high = band_end(one.bead_fraction, here, above, 1, beads, crossings.deviation);
        one.is_alone = std::ranges::none_of(crossings.all, [&](const Crossing& other) {
            const bool below = std::isfinite(one.low) && other.bead_fraction < one.low;
            const bool beyond = std::isfinite(one.high) && other.bead_fraction > one.high;
            return other.bead_fraction != one.bead_fraction && !below && !beyond;
        });
    }
}

Crossings find_all(const Coefficients& measured, const std::vector<Coefficients>& drawn,
                   const std::vector<double>& beads, double rod, Convention convention) {
    Crossings found{.all = crossings_of(measured, beads, rod, convention),
                    .above_all = measured.excess(beads.front(), rod, convention) >= 0.0};
    for (const double bead : beads) found.excess.push_back(measured.excess(bead, rod, convention));
    if (drawn.empty()) {
        found.share = found.deviation = std::vector<double>(beads.size(), nan);
        return found;
    }
    const auto count = static_cast<double>(drawn.size());
    std::vector<std::size_t> changes(drawn.size(), 0);
    std::vector<bool> is_flock(drawn.size());
    for (std::size_t i = 0; i < beads.size(); ++i) {
        std::vector<double> values = excesses(drawn, beads[i], rod, convention);
        double flocks = 0.0;
        for (std::size_t k = 0; k < values.size(); ++k) {
            const bool here = values[k] >= 0.0;
            if (i > 0 && here != is_flock[k]) ++changes[k];
            is_flock[k] = here;
            flocks += here ? 1.0 : 0.0;
        }
        found.share.push_back(flocks / count);
        std::ranges::sort(values);
        found.deviation.push_back(over_error(values));
    }
    for (const std::size_t crossings : changes) {
        if (crossings > 0) found.any += 1.0;
        if (crossings == found.all.size()) found.as_many += 1.0;
        if (crossings > found.all.size()) found.more += 1.0;
    }
    for (double* share : {&found.any, &found.as_many, &found.more}) *share /= count;
    add_intervals(drawn, beads, rod, convention, found);
    return found;
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
        const std::vector<Crossing> all = crossings_of(measured, beads, rod, Convention::mean);
        const auto first = std::ranges::find_if(all, [](const Crossing& one) { return one.begins; });
        OnsetPlace place{.bead_fraction = first == all.end() ? nan : first->bead_fraction,
                         .excess = measured.excess(beads.front(), rod)};
        place.above_all = place.excess >= 0.0;
        constexpr double step = 1e-4;
        const double low = std::max(place.bead_fraction - step, beads.front()),
                     high = std::min(place.bead_fraction + step, beads.back());
        place.slope = std::isnan(place.bead_fraction)
                          ? nan
                          : (measured.excess(high, rod) - measured.excess(low, rod)) / (high - low);
        if (!place.above_all)
            for (const double bead : table.bead_fractions)
                place.excess = std::max(place.excess, measured.excess(bead, rod));
        places.push_back(place);
    }
    return places;
}

Onset find_onset(const Table& table, std::size_t varied, int subdivisions, int draws) {
    require(subdivisions >= 1 && draws >= 0, {},
            "{} subdivisions of an interval, {} draws; expected at least 1 and at least 0", subdivisions, draws);
    check_axes(table);
    const Coefficients measured(table, varied);
    const std::vector<Coefficients> drawn = mapped(redrawn_tables(table, {rows.begin(), rows.end()}, draws),
                                                   [&](const Table& one) { return Coefficients(one, varied); });
    Onset onset{.draws = draws, .bead_fractions = refined(table.bead_fractions, subdivisions)};
    const auto point_of = [&](double rod) {
        OnsetCurve point{.rod_fraction = rod};
        for (const Convention convention : {Convention::mean, Convention::single_rod})
            point.crossings[static_cast<int>(convention)] =
                find_all(measured, drawn, onset.bead_fractions, rod, convention);
        return point;
    };
    for (const double rod : table.rod_fractions) {
        OnsetCurve curve = point_of(rod);
        for (const double bead : onset.bead_fractions) {
            const auto with_error = [&](auto value_in) {
                return Uncertain{.value = value_in(measured), .error = half_width(mapped(drawn, value_in))};
            };
            curve.drag.push_back(
                with_error([&](const Coefficients& in) { return in.drag.table().at(bead, rod).value; }));
            curve.threshold.push_back(with_error([&](const Coefficients& in) { return in.threshold(bead, rod); }));
            curve.alignment.push_back(measured.alignment(bead, rod));
        }
        onset.curves.push_back(std::move(curve));
    }
    for (const double rod : refined(table.rod_fractions, subdivisions)) onset.plane.push_back(point_of(rod));
    return onset;
}

}  // namespace drover::calibrate
