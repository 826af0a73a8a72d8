// calibrate/contact_alignment.cpp: c of rods that align where they meet, from the alignment of many rods.
#include <algorithm>
#include <cmath>
#include <optional>

#include "calibrate/alignment.hpp"
#include "calibrate/closures.hpp"

namespace drover::calibrate {

namespace {
/// A point of a table.
struct Point {
    const Table& table;
    std::size_t varied, bead, rod = 0;

    /// The entry of a row; nullptr if it is missing.
    const TableEntry* at(const char* name) const {
        const TableRow* row = find_row(table, name);
        if (row == nullptr) return nullptr;
        const TableEntry& entry = row->entries[entry_index(table, *row, varied, bead, rod)];
        return entry.origin == Origin::missing ? nullptr : &entry;
    }
    double rate() const { return at(name_of(relaxation))->value; }
};

/// 2 c sigma = a g - 2 lambda alpha/Gamma, and its error without those of a and lambda, which is its weight.
struct Estimate {
    double value, error;
    int trials;
};

/// Error of constant + x slope, from those of both and of constant + reference slope.
double combined_error(const TableEntry& constant, const TableEntry& slope, const TableEntry& referred, double reference,
                      double x) {
    const double variance = constant.error * constant.error + x * x * slope.error * slope.error +
                            x * twice_covariance(constant, slope, referred, reference);
    return std::sqrt(std::max(variance, 0.0));
}

/// From the drag assay, whose rods align by flow and contacts: by the flow at the orders of its fields, which is that
/// of a straight line.
std::optional<Estimate> of_free_beads(const Point& point) {
    const TableEntry *steady = point.at("alignment_steady"), *drift = point.at("alignment_drift"),
                     *referred = point.at("alignment_reference"), *straight = point.at(straight_drag),
                     *flow = straight ? straight : point.at(name_of(drag)), *turn = point.at(name_of(weathercock));
    if (!steady || !drift || !referred || !flow || !turn) return std::nullopt;
    const double a = point.rate(), turning = single_rod_factor * turn->value;
    const double error = combined_error(*steady, *drift, *referred, reference_time, 1.0 / a);
    return Estimate{.value = a * steady->value + drift->value - turning * flow->value,
                    .error = std::hypot(a * error, turning * flow->error),
                    .trials = steady->trials};
}

/// From the alignment assay, whose beads are held.
std::optional<Estimate> of_held_beads(const Point& point) {
    const TableEntry *steady = point.at("contact_steady"), *slope = point.at("contact_slope"),
                     *referred = point.at("contact_reference");
    if (!steady || !slope || !referred) return std::nullopt;
    const double a = point.rate();
    return Estimate{.value = 2.0 * (steady->value + a * slope->value),
                    .error = 2.0 * combined_error(*steady, *slope, *referred, reference_rate, a),
                    .trials = steady->trials};
}

/// Weighted mean of c over area fractions of rods and both assays.  Its error is what these disagree by beyond their
/// own: that by which sqrt(chi^2/degrees of freedom) enlarges the error of the mean.
TableEntry pooled(Point point, double area) {
    double weights = 0.0, sum = 0.0, squares = 0.0;
    TableEntry entry{.origin = Origin::measured};
    int count = 0;
    for (point.rod = 0; point.rod < point.table.rod_fractions.size(); ++point.rod)
        for (const auto& estimate : {of_free_beads(point), of_held_beads(point)}) {
            if (!estimate || estimate->error == 0.0) continue;
            const double scale = 0.5 * area / point.table.rod_fractions[point.rod];  // c = value/(2 sigma)
            const double c = scale * estimate->value, weight = 1.0 / std::pow(scale * estimate->error, 2);
            weights += weight, sum += weight * c, squares += weight * c * c;
            entry.trials += estimate->trials;
            ++count;
        }
    if (count == 0) return missing("no assay of many rods was run at this point");
    entry.value = sum / weights;
    const double chi_square = std::max(squares - sum * sum / weights, 0.0);
    if (count > 1) entry.error = std::sqrt(std::max(chi_square / (count - 1) - 1.0, 0.0) / weights);
    entry.remark = text("from {} measurements: chi^2 = {:.2g} for {} degrees of freedom", count, chi_square, count - 1);
    return entry;
}

/// g_total - g_held - g_flow, which is zero if flow and contacts are all that aligns rods, and add.
TableEntry excess_at(const Point& point) {
    const auto total = of_free_beads(point), held = of_held_beads(point);
    if (!total || !held) return missing("the assays drag and alignment were not both run at this point");
    return {.value = (total->value - held->value) / point.rate(),
            .trials = std::min(total->trials, held->trials),
            .origin = Origin::measured};
}
}  // namespace

const std::vector<std::string>& contact_rows() {
    static const std::vector<std::string> rows{"alignment_steady", "alignment_drift",   "alignment_reference",
                                               name_of(drag),      name_of(relaxation), "contact_steady",
                                               "contact_slope",    "contact_reference", name_of(weathercock),
                                               straight_drag};
    return rows;
}

double twice_covariance(const TableEntry& constant, const TableEntry& slope, const TableEntry& referred,
                        double reference) {
    return (referred.error * referred.error - constant.error * constant.error -
            reference * reference * slope.error * slope.error) /
           reference;
}

bool has_contact_rows(const Table& table) {
    return find_row(table, name_of(rod_area)) && find_row(table, name_of(relaxation)) &&
           (find_row(table, "contact_steady") || find_row(table, "alignment_steady"));
}

void add_contact_alignment(Table& table) {
    if (find_row(table, name_of(contact)) != nullptr) return;
    TableRow c{.name = name_of(contact), .unit = "mm^2/s", .formula = "c: rods that touch align, a -> a - c sigma"};
    const bool has_held = find_row(table, "contact_steady") != nullptr,
               has_total = find_row(table, "alignment_steady") != nullptr;
    if (!has_contact_rows(table)) {
        c.formula += "; c = 0: not measured";
        c.entries.assign(count_of(table, false), {.origin = Origin::set});
        table.rows.push_back(std::move(c));
        return;
    }
    TableRow excess{.name = "alignment_excess",
                    .unit = "1",
                    .formula = "g_total - g_held - lambda_s alpha/(Gamma D_r): 0 if flow and contacts add",
                    .by_rods = true};
    const TableRow& areas = *find_row(table, name_of(rod_area));
    const TableEntry no_rate = missing(text("{} is missing", name_of(relaxation)));
    for (std::size_t varied = 0; varied < table.varied.size(); ++varied)
        for (std::size_t bead = 0; bead < table.bead_fractions.size(); ++bead) {
            Point point{.table = table, .varied = varied, .bead = bead};
            const bool has_rate = point.at(name_of(relaxation)) != nullptr;
            c.entries.push_back(has_rate ? pooled(point, areas.entries[c.entries.size()].value) : no_rate);
            for (; point.rod < table.rod_fractions.size(); ++point.rod)
                excess.entries.push_back(has_rate ? excess_at(point) : no_rate);
        }
    table.rows.push_back(std::move(c));
    if (has_held && has_total) table.rows.push_back(std::move(excess));
}

}  // namespace drover::calibrate
