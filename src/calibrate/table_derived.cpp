// calibrate/table_derived.cpp: coefficients that are products of powers of others: conversions and closures.
#include <algorithm>
#include <cmath>
#include <limits>

#include "drover/calibrate/table.hpp"

namespace drover::calibrate {

namespace {
struct Factor {
    const char* name;
    double power;
};

/// factor * product of rows to their powers; no factors: the number itself.
struct DerivedRow {
    const char *name, *unit, *formula;
    Origin origin;
    double number;
    std::vector<Factor> factors;
};

// D_r is relaxation_rate, P the mean orientation, p = sigma u P the current.
const std::vector<DerivedRow>& derived_rows() {
    static const std::vector<DerivedRow> rows{
        {"friction",
         "mg/(mm^2 s)",
         "Gamma = m rho/tau: plates and rods together",
         Origin::measured,
         1.0,
         {{"bead_mass_density", 1}, {"response_time", -1}}},
        {"friction_of_plates",
         "mg/(mm^2 s)",
         "[Gamma/(m rho)] m rho, without rods",
         Origin::measured,
         1.0,
         {{"damping_rate", 1}, {"bead_mass_density", 1}}},
        {"viscosity",
         "mg/s",
         "eta = [eta/(m rho)] m rho",
         Origin::measured,
         1.0,
         {{"viscosity_kinematic", 1}, {"bead_mass_density", 1}}},
        {"relaxation_over_weathercock",
         "mm/s",
         "a/lambda: a flock forms where alpha/Gamma is more",
         Origin::measured,
         1.0,
         {{"relaxation_rate", 1}, {"weathercock", -1}}},
        {"alignment",
         "1",
         "g = lambda_s alpha/(Gamma D_r): a flock forms above 2",
         Origin::measured,
         1.0,
         {{"weathercock_single", 1}, {"drag", 1}, {"relaxation_rate", -1}}},
        {"driving_strength",
         "mg/s",
         "alpha = (alpha/Gamma) Gamma/(sigma u), for p = sigma u P",
         Origin::measured,
         1.0,
         {{"drag", 1}, {"bead_mass_density", 1}, {"response_time", -1}, {"rod_density", -1}, {"propulsion", -1}}},
        {"weathercock_strength",
         "1/(mm^2 s)",
         "lambda sigma u, for p = sigma u P",
         Origin::measured,
         1.0,
         {{"weathercock", 1}, {"rod_density", 1}, {"propulsion", 1}}},
        {"noise_order",
         "1/s^3",
         "Delta = D_r sigma u^2, for p = sigma u P",
         Origin::closure,
         1.0,
         {{"relaxation_rate", 1}, {"rod_density", 1}, {"propulsion", 2}}},
        {"pressure_rods", "mm^2/s^2", "B = u^2/2, for p = sigma u P", Origin::closure, 0.5, {{"propulsion", 2}}},
        {"elasticity_stiffness",
         "mm^2/s",
         "K3 = u^2/(16 D_r)",
         Origin::closure,
         1.0 / 16.0,
         {{"propulsion", 2}, {"relaxation_rate", -1}}},
        {"elasticity_splay", "mm^2/s", "K1 = 0", Origin::closure, 0.0, {}},
        {"relaxation_saturation",
         "mm^2 s",
         "b = D_r g^2/(8 sigma^2 u^2), for p = sigma u P",
         Origin::closure,
         0.125,
         {{"weathercock_single", 2}, {"drag", 2}, {"relaxation_rate", -1}, {"rod_density", -2}, {"propulsion", -2}}},
        {"compressibility", "mg mm^2/s^2", "E = 0: its assay was not made", Origin::set, 0.0, {}},
        {"advection", "mm^2", "w = 0: no assay and no closure", Origin::set, 0.0, {}},
        {"pressure_beads", "mm^2/s^2", "A = 0: no assay and no closure", Origin::set, 0.0, {}},
        {"compressibility_rods", "mg mm^2/s^2", "F = 0: no assay and no closure", Origin::set, 0.0, {}},
        {"viscosity_bulk", "mg/s", "zeta = 0: no assay and no closure", Origin::set, 0.0, {}}};
    return rows;
}

constexpr double errors_from_zero = 3.0;  // of what is divided by

Known refused(const std::string& why) {
    constexpr double none = std::numeric_limits<double>::quiet_NaN();
    return {.value = none, .error = none, .origin = Origin::refused, .remark = why};
}

Known product(const DerivedRow& row, const std::vector<const Known*>& of) {
    Known result{.value = row.number, .trials = std::numeric_limits<int>::max(), .origin = row.origin};
    for (std::size_t i = 0; i < of.size(); ++i) {
        const Factor& factor = row.factors[i];
        if (of[i]->origin == Origin::refused) return refused(text("{} is refused", factor.name));
        if (factor.power < 0.0 && std::abs(of[i]->value) <= errors_from_zero * of[i]->error)
            return refused(text("{} = {:.3g} +- {:.2g}, by which it is divided, cannot be told from 0", factor.name,
                                of[i]->value, of[i]->error));
        if (of[i]->origin == Origin::measured_short && row.origin == Origin::measured)
            result.origin = Origin::measured_short;
        if (of[i]->origin == Origin::measured_short)
            result.remark +=
                text("{}{} is not as well known as was asked", result.remark.empty() ? "" : "; ", factor.name);
        if (of[i]->origin != Origin::set) result.trials = std::min(result.trials, of[i]->trials);
        result.value *= std::pow(of[i]->value, factor.power);
    }
    double squares = 0.0;
    for (std::size_t i = 0; i < of.size(); ++i) {
        double slope = row.number * row.factors[i].power * std::pow(of[i]->value, row.factors[i].power - 1.0);
        for (std::size_t k = 0; k < of.size(); ++k)
            if (k != i) slope *= std::pow(of[k]->value, row.factors[k].power);
        squares += slope * slope * of[i]->error * of[i]->error;
    }
    result.error = std::sqrt(squares);
    if (result.trials == std::numeric_limits<int>::max()) result.trials = 0;
    return result;
}
}  // namespace

void add_derived(Table& table) {
    for (const DerivedRow& derived : derived_rows()) {
        if (find_row(table, derived.name) != nullptr) continue;
        std::vector<const TableRow*> from;
        for (const Factor& factor : derived.factors) from.push_back(find_row(table, factor.name));
        if (std::find(from.begin(), from.end(), nullptr) != from.end()) continue;
        TableRow row{.name = derived.name, .unit = derived.unit, .formula = derived.formula};
        for (const TableRow* one : from) row.by_rods = row.by_rods || one->by_rods;
        const std::size_t rods = row.by_rods ? table.rod_fractions.size() : 1;
        for (std::size_t place = 0; place < count_of(table, row.by_rods); ++place) {
            std::vector<const Known*> of;
            for (const TableRow* one : from) of.push_back(&one->known[one->by_rods ? place : place / rods]);
            row.known.push_back(product(derived, of));
        }
        table.rows.push_back(std::move(row));
    }
}

}  // namespace drover::calibrate
