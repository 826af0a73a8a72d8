// calibrate/closures.cpp: conversions of measured quantities, closures for independent rods, and c of rods that align
// where they meet, from the alignment of many rods.
#include "calibrate/closures.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

#include "calibrate/alignment.hpp"
#include "physics/model_file.hpp"

namespace drover::calibrate {

namespace {
using M = const ClosureNumbers&;

/// A number of a model that is an input itself.
Closure input_as(const char* key, Input input, Origin origin) {
    return {.key = key, .origin = origin, .of = {input}, .value = [input](M m) { return m[input]; }};
}

// D_r is the relaxation rate, P the mean orientation.
std::vector<Closure> table_of_closures() {
    return {
        {.key = "uniform.rod_density",
         .of = {rod_area},
         .under = {rod_area},
         .value = [](M m) { return m.rod_density(); }},
        {.key = "uniform.bead_density",
         .of = {bead_area},
         .under = {bead_area},
         .value = [](M m) { return m.bead_density(); }},
        input_as("uniform.rod_area", rod_area, Origin::set),
        input_as("uniform.bead_area", bead_area, Origin::set),
        input_as("current.speed", speed, Origin::measured),
        input_as("inertia.bead_mass", bead_mass, Origin::set),
        {.row = "friction",
         .key = "drag.coefficient",
         .formula = "Gamma = m rho/tau: friction of plates and rods",
         .origin = Origin::measured,
         .of = {bead_area, bead_mass, response},
         .under = {bead_area},
         .value = [](M m) { return m.friction(); }},
        {.row = "friction_of_plates",
         .unit = "mg/(mm^2 s)",
         .formula = "[Gamma/(m rho)] m rho, without rods",
         .origin = Origin::measured,
         .of = {bead_area, bead_mass, damping},
         .under = {bead_area},
         .value = [](M m) { return m[damping] * m.mass_density(); }},
        {.row = "viscosity",
         .key = "viscosity.shear",
         .formula = "eta = [eta/(m rho)] m rho",
         .origin = Origin::measured,
         .of = {bead_area, bead_mass, viscosity},
         .under = {bead_area},
         .value = [](M m) { return m[viscosity] * m.mass_density(); }},
        {.row = "viscosity_bulk", .key = "viscosity.bulk", .formula = "zeta = 0: no assay and no closure"},
        {.row = "driving_strength",
         .key = "driving.strength",
         .unit = "mg/s",
         .formula = "alpha = (alpha/Gamma) Gamma/(sigma u), for p = sigma u P",
         .origin = Origin::measured,
         .of = {bead_area, bead_mass, response, drag},
         .under = {bead_area},
         .value = [](M m) { return m[drag] * m.friction(); }},
        {.row = "driving_cubic",
         .key = "driving.cubic",
         .unit = "mg mm^2 s",
         .formula = "alpha_3 = (alpha_3/Gamma) Gamma/(sigma u)^3, for p = sigma u P",
         .origin = Origin::measured,
         .of = {bead_area, bead_mass, response, cubic},
         .under = {bead_area},
         .value = [](M m) { return m[cubic] * m.friction(); }},
        input_as("stiffness.beads", stiffness, Origin::measured),
        {.row = "stiffness_rods", .key = "stiffness.rods", .formula = "F = 0: no assay and no closure"},
        input_as("relaxation.rate", relaxation, Origin::measured),
        {.row = "relaxation_saturation",
         .key = "relaxation.saturation",
         .unit = "mm^2 s",
         .formula = "b = D_r [(g/2 - 1)/P^2 + g3/2]/(sigma u)^2 at P = I1(x)/I0(x), x = gP + g3 P^3, "
                    "D_r g^2/(8 sigma^2 u^2) below onset, for p = sigma u P; g3 = lambda_s alpha_3/(Gamma D_r)",
         .origin = Origin::closure,
         .of = {relaxation, weathercock, drag, cubic, contact, rod_area},
         .under = {relaxation, rod_area},
         .value = [](M m) { return m[relaxation] * saturation_of_alignment(m.alignment(), m.alignment_cubic()); }},
        input_as("relaxation.contact", contact, Origin::measured),
        {.row = "elasticity_stiffness",
         .key = "elasticity.stiffness",
         .formula = "K3 = u^2/(16 D_r)",
         .origin = Origin::closure,
         .of = {speed, relaxation},
         .under = {relaxation},
         .value = [](M m) { return m[speed] * m[speed] / (16.0 * m[relaxation]); }},
        {.row = "elasticity_splay", .key = "elasticity.splay", .formula = "K1 = 0", .origin = Origin::closure},
        {.row = "weathercock_strength",
         .key = "weathercock.strength",
         .unit = "1/(mm^2 s)",
         .formula = "lambda sigma u, for p = sigma u P",
         .origin = Origin::measured,
         .of = {weathercock},
         .value = [](M m) { return m[weathercock]; }},
        {.row = "advection",
         .key = "advection.strength",
         .unit = "mm^2",
         .formula = "w = 3 g/(16 sigma), for p = sigma u P",
         .origin = Origin::closure,
         .of = {relaxation, weathercock, drag, contact, rod_area, speed},
         .under = {relaxation, rod_area},
         .value = [](M m) { return 3.0 / 16.0 * m.alignment() * m[speed]; }},
        {.row = "pressure_beads",
         .key = "pressure.beads",
         .unit = "mm^2/s^2",
         .formula = "A = 0: no assay and no closure"},
        {.row = "pressure_rods",
         .key = "pressure.rods",
         .unit = "mm^2/s^2",
         .formula = "B = u^2/2, for p = sigma u P",
         .origin = Origin::closure,
         .of = {speed, rod_area},
         .under = {rod_area},
         .value = [](M m) { return 0.5 * m[speed] / m.rod_density(); }},
        {.row = "noise_order",
         .key = "noise.order",
         .unit = "1/s^3",
         .formula = "Delta = D_r sigma u^2, for p = sigma u P",
         .origin = Origin::closure,
         .of = {relaxation, rod_area},
         .under = {rod_area},
         .value = [](M m) { return m[relaxation] / m.rod_density(); }},
        {.row = "relaxation_over_weathercock",
         .unit = "mm/s",
         .formula = "a/lambda: without contacts, a flock forms where alpha/Gamma is larger",
         .origin = Origin::measured,
         .of = {relaxation, weathercock},
         .under = {weathercock},
         .value = [](M m) { return m[relaxation] / m[weathercock]; }},
        {.row = "alignment_by_flow",
         .unit = "1",
         .formula = "lambda_s alpha/(Gamma D_r)",
         .origin = Origin::measured,
         .of = {relaxation, weathercock, drag},
         .under = {relaxation},
         .value = [](M m) { return m.alignment_by_flow(); }},
        {.row = "alignment",
         .unit = "1",
         .formula = "g = (lambda_s alpha/Gamma + 2 c sigma)/D_r: a flock forms above 2",
         .origin = Origin::measured,
         .of = {relaxation, weathercock, drag, contact, rod_area},
         .under = {relaxation, rod_area},
         .value = [](M m) { return m.alignment(); }},
        // From collisions of pairs (scattering assay) and the flow, without a fit to a flock: psi_3 = 0, psi_2 follows
        // psi_1 (Bertin, Droz & Gregoire, J. Phys. A 42, 445001 (2009)).  Without collisions these are the closures
        // above.
        {.row = "alignment_kinetic",
         .unit = "1",
         .formula = "g = (lambda_s alpha/Gamma + 2 c sigma)/D_r, c of pairs of rods",
         .origin = Origin::measured,
         .of = {relaxation, weathercock, drag, rod_area, scattered},
         .under = {relaxation, rod_area},
         .value = [](M m) { return m.alignment(scattered); }},
        {.row = "saturation_kinetic",
         .unit = "1/s",
         .formula = "b for p = P, from collisions of pairs and the flow",
         .origin = Origin::closure,
         .of = {relaxation, weathercock, drag, rod_area, scattered_second, scattered_excitation, scattered_saturation},
         .under = {relaxation, rod_area},
         .value = [](M m) { return m.reaction() * m.excitation() / m.second_rate(); }},
        {.row = "advection_kinetic",
         .unit = "mm/s",
         .formula = "w for p = P, from collisions of pairs and the flow",
         .origin = Origin::closure,
         .of = {relaxation, weathercock, drag, rod_area, scattered_second, scattered_excitation, scattered_saturation,
                speed},
         .under = {relaxation, rod_area},
         .value = [](M m) { return m[speed] * (m.excitation() - 0.5 * m.reaction()) / m.second_rate(); }},
        {.row = "elasticity_kinetic",
         .unit = "mm^2/s",
         .formula = "K3 = u^2/(16 D_r - 4 J sigma), J of the second moment, of pairs of rods",
         .origin = Origin::closure,
         .of = {relaxation, rod_area, speed, scattered_second},
         .under = {relaxation, rod_area},
         .value = [](M m) { return 0.25 * m[speed] * m[speed] / m.second_rate(); }}};
}

/// The unit of a coefficient that does not depend on that of p, and the power of sigma that it takes with p.
void take_from_registry(Closure& closure) {
    const auto& rows = physics::shipped_model().coefficients;
    const auto row = std::ranges::find_if(rows, [&](const auto& one) { return one.key() == closure.key; });
    if (row == rows.end()) return;
    closure.order_power = row->order_power;
    if (row->order_power == 0) closure.unit = row->unit;
}

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

const std::vector<Closure>& closures() {
    static const std::vector<Closure> all = [] {
        std::vector<Closure> list = table_of_closures();
        for (Closure& closure : list) take_from_registry(closure);
        return list;
    }();
    return all;
}

Closure scaled(Closure closure, const std::vector<Input>& scale_of, const Formula& scale) {
    if (closure.order_power == 0.0 || closure.of.empty()) return closure;
    for (const Input input : scale_of) {
        if (std::ranges::find(closure.of, input) == closure.of.end()) closure.of.push_back(input);
        if (closure.order_power < 0.0) closure.under.push_back(input);
    }
    closure.value = [unscaled = closure.value, scale, power = closure.order_power](const ClosureNumbers& at) {
        return unscaled(at) * std::pow(scale(at), power);
    };
    return closure;
}

std::string divisor_refusal(Input input, double value, double error) {
    constexpr double errors_from_zero = 3.0;
    if (std::abs(value) > errors_from_zero * error) return "";
    return text("the divisor {} = {:.3g} +- {:.2g} is not significantly different from 0", name_of(input), value,
                error);
}

void put(ClosureNumbers& at, Input input, double value, double error) {
    at.numbers[input] = is_below_error(input, value, error) ? error : value;
    at.errors[input] = error;
}

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
