// calibrate/field_model.cpp: numbers of the equations as functions of what was measured, with errors to first order.
#include "drover/calibrate/field_model.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <map>

namespace drover::calibrate {

namespace {
/// Rows of the table that formulas are made of, in the order of `row_names`.
enum Input { bead_area, rod_area, bead_mass, relaxation, weathercock, drag, response, speed, viscosity, stiffness };
constexpr std::array<const char*, 10> row_names{"bead_area",       "rod_area",    "bead_mass",
                                                "relaxation_rate", "weathercock", "drag",
                                                "response_time",   "propulsion",  "viscosity_kinematic",
                                                "compressibility"};

/// The numbers that one formula needs; others are left at zero.
struct Measured {
    std::array<double, row_names.size()> numbers{};
    StatePoint point;

    double operator[](Input row) const { return numbers[row]; }
    double bead_density() const { return point.bead_fraction / numbers[bead_area]; }
    double rod_density() const { return point.rod_fraction / numbers[rod_area]; }
    double mass_density() const { return numbers[bead_mass] * bead_density(); }
    double friction() const { return mass_density() / numbers[response]; }
    /// lambda_s is 2 lambda.
    double alignment() const { return 2.0 * numbers[weathercock] * numbers[drag] / numbers[relaxation]; }
};

struct Formula {
    std::string key;
    Origin origin;
    std::vector<Input> rows;
    std::function<double(const Measured&)> value;
};

const std::vector<Formula>& formulas() {
    using M = const Measured&;
    const auto zero = [](M) { return 0.0; };
    static const std::vector<Formula> all{
        {"uniform.rod_density", Origin::set, {rod_area}, [](M m) { return m.rod_density(); }},
        {"uniform.bead_density", Origin::set, {bead_area}, [](M m) { return m.bead_density(); }},
        {"uniform.rod_area", Origin::set, {rod_area}, [](M m) { return m[rod_area]; }},
        {"uniform.bead_area", Origin::set, {bead_area}, [](M m) { return m[bead_area]; }},
        {"current.speed", Origin::measured, {speed}, [](M m) { return m[speed]; }},
        {"inertia.bead_mass", Origin::set, {bead_mass}, [](M m) { return m[bead_mass]; }},
        {"drag.coefficient", Origin::measured, {bead_area, bead_mass, response}, [](M m) { return m.friction(); }},
        {"viscosity.shear",
         Origin::measured,
         {bead_area, bead_mass, viscosity},
         [](M m) { return m[viscosity] * m.mass_density(); }},
        {"viscosity.bulk", Origin::set, {}, zero},
        {"driving.strength",
         Origin::measured,
         {bead_area, bead_mass, response, drag},
         [](M m) { return m[drag] * m.friction(); }},
        {"compressibility.beads", Origin::measured, {stiffness}, [](M m) { return m[stiffness]; }},
        {"compressibility.rods", Origin::set, {}, zero},
        {"relaxation.rate", Origin::measured, {relaxation}, [](M m) { return m[relaxation]; }},
        {"relaxation.saturation",
         Origin::closure,
         {relaxation, weathercock, drag},
         [](M m) { return m[relaxation] * saturation_of_alignment(m.alignment()); }},
        {"elasticity.stiffness",
         Origin::closure,
         {speed, relaxation},
         [](M m) { return m[speed] * m[speed] / (16.0 * m[relaxation]); }},
        {"elasticity.splay", Origin::closure, {}, zero},
        {"weathercock.strength", Origin::measured, {weathercock}, [](M m) { return m[weathercock]; }},
        {"advection.strength", Origin::set, {}, zero},
        {"pressure.beads", Origin::set, {}, zero},
        {"pressure.rods", Origin::closure, {speed, rod_area}, [](M m) { return 0.5 * m[speed] / m.rod_density(); }},
        {"noise.order", Origin::closure, {relaxation, rod_area}, [](M m) { return m[relaxation] / m.rod_density(); }}};
    return all;
}

const Formula& formula_of(const std::string& key) {
    const auto found =
        std::find_if(formulas().begin(), formulas().end(), [&](const Formula& one) { return one.key == key; });
    require(found != formulas().end(), {}, "{} is nothing that a table of coefficients gives", key);
    return *found;
}

constexpr double slope_part = 1e-3;  // of an error: a slope, also where the error is large

/// The value at what was measured, and what each error changes, added in squares: half of what lies between `part` of the error to either side.
Uncertain evaluated(const Table& table, const std::vector<Input>& rows, const StatePoint& point,
                    const std::function<double(const Measured&)>& value, double part = slope_part) {
    Measured measured{.point = point};
    std::map<Input, double> errors;
    for (const Input row : rows) {
        const Uncertain found = SmoothCoefficient(table, row_names[row], point.varied, point.outside)
                                    .at(point.bead_fraction, point.rod_fraction);
        measured.numbers[row] = found.value;
        errors[row] = found.error;
    }
    double squares = 0.0;
    for (const auto& [row, error] : errors) {
        const double held = measured[row];
        measured.numbers[row] = held + part * error;
        const double above = value(measured);
        measured.numbers[row] = held - part * error;
        const double slope = 0.5 * (above - value(measured)) / part;
        measured.numbers[row] = held;
        squares += slope * slope;
    }
    return {.value = value(measured), .error = std::sqrt(squares)};
}
}  // namespace

double power_of_density(const std::string& key) {
    static const std::map<std::string, double> powers{
        {"driving.strength", -1.0},   {"weathercock.strength", 1.0}, {"relaxation.saturation", -2.0},
        {"advection.strength", -1.0}, {"pressure.beads", 1.0},       {"pressure.rods", 1.0},
        {"noise.order", 2.0}};
    const auto found = powers.find(key);
    return found == powers.end() ? 0.0 : found->second;
}

const std::vector<std::string>& calibrated_keys() {
    static const std::vector<std::string> keys = [] {
        std::vector<std::string> names;
        for (const Formula& one : formulas()) names.push_back(one.key);
        return names;
    }();
    return keys;
}

FieldNumber field_number(const Table& table, const std::string& key, const StatePoint& point, OrderKind kind) {
    const Formula& formula = formula_of(key);
    const double power = kind == OrderKind::density ? power_of_density(key) : 0.0;
    std::vector<Input> rows = formula.rows;
    if (power != 0.0 && std::find(rows.begin(), rows.end(), rod_area) == rows.end()) rows.push_back(rod_area);
    const auto value = [&](const Measured& measured) {
        const double found = formula.value(measured);
        return power == 0.0 ? found : found * std::pow(measured.rod_density(), power);
    };
    const bool all_set = !rows.empty() && std::all_of(rows.begin(), rows.end(), [&](Input row) {
        const TableRow* held = find_row(table, row_names[row]);
        return held != nullptr && held->known.front().origin == Origin::set;
    });
    return {.number = evaluated(table, rows, point, value), .origin = all_set ? Origin::set : formula.origin};
}

physics::TableData density_table(const Table& table, const StatePoint& point, OrderKind kind) {
    require(!table.rod_fractions.empty(), {}, "the table has no area fractions of rods; expected one that has");
    physics::TableData data;
    const auto number = [&](const char* key, double beads, double rods) {
        StatePoint node = point;
        node.bead_fraction = beads;
        node.rod_fraction = rods;
        return field_number(table, key, node, kind).number;
    };
    const double beads = table.bead_fractions.front(), rods = table.rod_fractions.front();
    for (const double fraction : table.bead_fractions)
        data.bead_density.push_back(number("uniform.bead_density", fraction, rods).value);
    for (const double fraction : table.rod_fractions)
        data.rod_density.push_back(number("uniform.rod_density", beads, fraction).value);
    const auto add = [](const Uncertain& found, std::vector<double>& values, std::vector<double>& errors) {
        values.push_back(found.value);
        errors.push_back(found.error);
    };
    for (const double bead : table.bead_fractions)
        for (const double rod : table.rod_fractions) {
            add(number("relaxation.rate", bead, rod), data.relaxation_rate, data.relaxation_rate_error);
            data.relaxation_saturation.push_back(number("relaxation.saturation", bead, rod).value);
            add(number("weathercock.strength", bead, rod), data.weathercock_strength, data.weathercock_strength_error);
            data.drag_coefficient.push_back(number("drag.coefficient", bead, rod).value);
            const Uncertain ratio = SmoothCoefficient(table, row_names[drag], point.varied).at(bead, rod);
            const double driving = number("driving.strength", bead, rod).value;
            add({.value = driving, .error = std::abs(driving / ratio.value) * ratio.error}, data.driving_strength,
                data.driving_strength_error);
        }
    data.outside = point.outside == physics::Outside::hold ? "hold" : "refuse";
    return data;
}

double order_of_alignment(double alignment) {
    if (!(alignment > 2.0)) return 0.0;
    // I1(x)/I0(x) > x/2 (1 - x^2/8), so P lies above that root; x = gP solves I1(x)/I0(x) = x/g, whose left side is concave.
    const auto excess = [&](double x) {
        // Beyond some hundreds the functions leave the range of numbers; the terms of the series that are left out are below 1e-10 there.
        constexpr double large = 500.0;
        const double ratio = x < large ? std::cyl_bessel_i(1.0, x) / std::cyl_bessel_i(0.0, x)
                                       : 1.0 - 0.5 / x - 0.125 / (x * x) - 0.125 / (x * x * x);
        return ratio - x / alignment;
    };
    double low = 0.0, high = alignment;
    constexpr int halvings = 100;
    for (int i = 0; i < halvings; ++i) {
        const double middle = 0.5 * (low + high);
        (excess(middle) > 0.0 ? low : high) = middle;
    }
    return 0.5 * (low + high) / alignment;
}

double saturation_of_alignment(double alignment) {
    // Nearer than this P^2 = (g - 2)(1 - 5/6 (g - 2)) loses its digits; the limit is off by as little.
    constexpr double near = 1e-6;
    if (alignment < 2.0 + near) return 0.125 * alignment * alignment;
    const double order = order_of_alignment(alignment);
    return (0.5 * alignment - 1.0) / (order * order);
}

MeanField mean_field(const Table& table, const StatePoint& point) {
    const auto of = [&](std::vector<Input> rows, const std::function<double(const Measured&)>& value) {
        return evaluated(table, rows, point, value);
    };
    const std::vector<Input> all{relaxation, weathercock, drag};
    // P has no slope below g = 2 and an infinite one above it: the whole of an error to either side.
    const auto over_errors = [&](const std::function<double(const Measured&)>& value) {
        return evaluated(table, all, point, value, 1.0);
    };
    using M = const Measured&;
    return {.alignment = of(all, [](M m) { return m.alignment(); }),
            .effective_relaxation = of(all, [](M m) { return m[relaxation] - m[weathercock] * m[drag]; }),
            .order = over_errors([](M m) { return order_of_alignment(m.alignment()); }),
            .bead_velocity = over_errors([](M m) { return m[drag] * order_of_alignment(m.alignment()); }),
            .response_time = of({response}, [](M m) { return m[response]; })};
}

}  // namespace drover::calibrate
