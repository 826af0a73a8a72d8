// calibrate/contact_alignment.cpp: c of rods that align where they meet, from the alignment of many rods.
#include <algorithm>
#include <cmath>
#include <optional>

#include "calibrate/alignment.hpp"
#include "calibrate/closures.hpp"

namespace drover::calibrate {

namespace {
constexpr const char* excess_row = "alignment_excess";
constexpr double factor = single_rod_factor;

/// The entry of a row at a point; nullptr if it is missing.
const TableEntry* entry_at(const Table& table, const char* name, std::size_t varied, std::size_t bead,
                           std::size_t rod) {
    const TableRow* row = find_row(table, name);
    if (row == nullptr) return nullptr;
    const TableEntry& entry = row->entries[entry_index(table, *row, varied, bead, rod)];
    return entry.origin == Origin::missing ? nullptr : &entry;
}

/// What all estimates at one area fraction of beads share.
struct Shared {
    const TableEntry *relaxation, *weathercock;
};

Shared shared_at(const Table& table, std::size_t varied, std::size_t bead) {
    return {.relaxation = entry_at(table, row_name(relaxation), varied, bead, 0),
            .weathercock = entry_at(table, row_name(weathercock), varied, bead, 0)};
}

/// 2 c sigma = a g - 2 lambda alpha/Gamma: a value with its own error, and its slopes by what is shared.
struct Estimate {
    double value, error, by_relaxation, by_weathercock, by_drag;
    std::size_t rod;
    int trials;
};

/// Error of constant + x slope, from those of both and of constant + reference slope.
double combined_error(double constant, double slope, double referred, double reference, double x) {
    const double twice_covariance =
        (referred * referred - constant * constant - reference * reference * slope * slope) / reference;
    return std::sqrt(std::max(constant * constant + x * x * slope * slope + x * twice_covariance, 0.0));
}

/// From the drag assay, whose rods align by flow and contacts: by the flow at the orders of its fields, which is that
/// of a straight line.
std::optional<Estimate> of_free_beads(const Table& table, const Shared& shared, std::size_t varied, std::size_t bead,
                                      std::size_t rod) {
    const auto at = [&](const char* name) { return entry_at(table, name, varied, bead, rod); };
    const TableEntry *steady = at("alignment_steady"), *drift = at("alignment_drift"),
                     *referred = at("alignment_reference"), *straight = at(straight_drag),
                     *flow = straight ? straight : at(row_name(drag));
    if (!steady || !drift || !referred || !flow || !shared.weathercock) return std::nullopt;
    const double a = shared.relaxation->value, turning = factor * shared.weathercock->value;
    const double error = combined_error(steady->error, drift->error, referred->error, reference_time, 1.0 / a);
    return Estimate{.value = a * steady->value + drift->value - turning * flow->value,
                    .error = std::hypot(a * error, turning * flow->error),
                    .by_relaxation = steady->value,
                    .by_weathercock = -factor * flow->value,
                    .by_drag = straight ? 0.0 : -turning,
                    .rod = rod,
                    .trials = steady->trials};
}

/// From the alignment assay, whose beads are held.
std::optional<Estimate> of_held_beads(const Table& table, const Shared& shared, std::size_t varied, std::size_t bead,
                                      std::size_t rod) {
    const auto at = [&](const char* name) { return entry_at(table, name, varied, bead, rod); };
    const TableEntry *steady = at("contact_steady"), *slope = at("contact_slope"), *referred = at("contact_reference");
    if (!steady || !slope || !referred) return std::nullopt;
    const double a = shared.relaxation->value;
    return Estimate{.value = 2.0 * (steady->value + a * slope->value),
                    .error = 2.0 * combined_error(steady->error, slope->error, referred->error, reference_rate, a),
                    .by_relaxation = 2.0 * slope->value,
                    .by_weathercock = 0.0,
                    .by_drag = 0.0,
                    .rod = rod,
                    .trials = steady->trials};
}

struct Pooled {
    TableEntry entry;
    ContactSlopes slopes = {};
};

/// Weighted mean of c over area fractions of rods and both assays.  Where they disagree, the error grows by
/// sqrt(chi^2/degrees of freedom).
Pooled pooled(const Table& table, const Shared& shared, double area, std::size_t varied, std::size_t bead) {
    double weights = 0.0, sum = 0.0, squares = 0.0, by_relaxation = 0.0, by_weathercock = 0.0;
    std::vector<double> by_drag(table.rod_fractions.size(), 0.0);
    TableEntry entry{.origin = Origin::measured};
    int count = 0;
    for (std::size_t rod = 0; rod < table.rod_fractions.size(); ++rod)
        for (const auto& estimate :
             {of_free_beads(table, shared, varied, bead, rod), of_held_beads(table, shared, varied, bead, rod)}) {
            if (!estimate || estimate->error == 0.0) continue;
            const double scale = 0.5 * area / table.rod_fractions[rod];  // c = value/(2 sigma)
            const double c = scale * estimate->value, weight = 1.0 / std::pow(scale * estimate->error, 2);
            weights += weight, sum += weight * c, squares += weight * c * c;
            by_relaxation += weight * scale * estimate->by_relaxation;
            by_weathercock += weight * scale * estimate->by_weathercock;
            by_drag[estimate->rod] += weight * scale * estimate->by_drag;
            entry.trials += estimate->trials;
            ++count;
        }
    if (count == 0) return {.entry = missing("no assay of many rods was run at this point")};
    entry.value = sum / weights;
    const double chi_square = std::max(squares - sum * sum / weights, 0.0);
    const double apart = count > 1 ? std::max(1.0, std::sqrt(chi_square / (count - 1))) : 1.0;
    const double turning = shared.weathercock ? shared.weathercock->error : 0.0;
    const double alone = apart / std::sqrt(weights);
    entry.error =
        std::hypot(alone, by_relaxation / weights * shared.relaxation->error, by_weathercock / weights * turning);
    double by_flow = 0.0;
    for (std::size_t rod = 0; rod < table.rod_fractions.size(); ++rod)
        if (const TableEntry* flow = entry_at(table, row_name(drag), varied, bead, rod))
            by_flow = std::hypot(by_flow, by_drag[rod] / weights * flow->error);
    entry.remark = text("from {} measurements: chi^2 = {:.2g} for {} degrees of freedom", count, chi_square, count - 1);
    for (double& slope : by_drag) slope /= weights;
    return {.entry = entry,
            .slopes = {.by_relaxation = by_relaxation / weights,
                       .by_weathercock = by_weathercock / weights,
                       .by_drag = by_drag,
                       .own_error = std::sqrt(std::max(alone * alone - by_flow * by_flow, 0.0))}};
}

bool has_assays(const Table& table) {
    return find_row(table, row_name(rod_area)) && find_row(table, row_name(relaxation)) &&
           (find_row(table, "contact_steady") || find_row(table, "alignment_steady"));
}

/// c at one area fraction of beads.
Pooled contact_at(const Table& table, std::size_t varied, std::size_t bead) {
    const Shared shared = shared_at(table, varied, bead);
    if (!shared.relaxation) return {.entry = missing(text("{} is missing", row_name(relaxation)))};
    const TableRow& area = *find_row(table, row_name(rod_area));
    return pooled(table, shared, area.entries[entry_index(table, area, varied, bead, 0)].value, varied, bead);
}

/// g_total - g_held - g_flow, which is zero if flow and contacts are all that aligns rods, and add.
TableEntry excess_at(const Table& table, const Shared& shared, std::size_t varied, std::size_t bead, std::size_t rod) {
    const auto total = of_free_beads(table, shared, varied, bead, rod),
               held = of_held_beads(table, shared, varied, bead, rod);
    if (!total || !held) return missing("the assays drag and alignment were not both run at this point");
    const double a = shared.relaxation->value, value = total->value - held->value;
    return {.value = value / a,
            .error = std::hypot(std::hypot(total->error, held->error) / a,
                                (total->by_relaxation - held->by_relaxation - value / a) / a * shared.relaxation->error,
                                total->by_weathercock / a * shared.weathercock->error),
            .trials = std::min(total->trials, held->trials),
            .origin = Origin::measured};
}
}  // namespace

void add_contact_alignment(Table& table) {
    if (find_row(table, row_name(contact)) != nullptr) return;
    TableRow c{.name = row_name(contact), .unit = "mm^2/s", .formula = "c: rods that touch align, a -> a - c sigma"};
    const bool has_held = find_row(table, "contact_steady") != nullptr,
               has_total = find_row(table, "alignment_steady") != nullptr;
    if (!has_assays(table)) {
        c.formula += "; c = 0: not measured";
        c.entries.assign(count_of(table, false), {.origin = Origin::set});
        table.rows.push_back(std::move(c));
        return;
    }
    TableRow excess{.name = excess_row,
                    .unit = "1",
                    .formula = "g_total - g_held - lambda_s alpha/(Gamma D_r): 0 if flow and contacts add",
                    .by_rods = true};
    for (std::size_t varied = 0; varied < table.varied.size(); ++varied)
        for (std::size_t bead = 0; bead < table.bead_fractions.size(); ++bead) {
            const Shared shared = shared_at(table, varied, bead);
            c.entries.push_back(contact_at(table, varied, bead).entry);
            for (std::size_t rod = 0; rod < table.rod_fractions.size(); ++rod)
                excess.entries.push_back(shared.relaxation ? excess_at(table, shared, varied, bead, rod)
                                                           : missing(text("{} is missing", row_name(relaxation))));
        }
    table.rows.push_back(std::move(c));
    if (has_held && has_total) table.rows.push_back(std::move(excess));
}

namespace {
/// c from the rows as they are; empty where the table does not derive it.
std::optional<Pooled> derived_at(const Table& table, std::size_t varied, std::size_t bead) {
    const TableEntry* entry = entry_at(table, row_name(contact), varied, bead, 0);
    if (entry == nullptr || entry->origin != Origin::measured || !has_assays(table)) return std::nullopt;
    return contact_at(table, varied, bead);
}
}  // namespace

std::optional<ContactSlopes> contact_slopes(const Table& table, std::size_t varied, std::size_t bead) {
    std::optional<Pooled> derived = derived_at(table, varied, bead);
    if (!derived) return std::nullopt;
    return std::move(derived->slopes);
}

std::vector<Uncertain> contact_alone(const Table& table) {
    std::vector<Uncertain> found;
    const TableRow* row = find_row(table, row_name(contact));
    if (row == nullptr) return found;
    for (std::size_t varied = 0; varied < table.varied.size(); ++varied)
        for (std::size_t bead = 0; bead < table.bead_fractions.size(); ++bead) {
            const TableEntry& entry = row->entries[entry_index(table, *row, varied, bead, 0)];
            const std::optional<Pooled> derived = derived_at(table, varied, bead);
            found.push_back(derived ? Uncertain{.value = derived->entry.value, .error = derived->slopes.own_error}
                                    : Uncertain{.value = entry.value, .error = entry.error});
        }
    return found;
}

}  // namespace drover::calibrate
