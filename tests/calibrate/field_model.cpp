// tests/calibrate/field_model.cpp: models from tables, in both normalisations of p, and their physics.
#include "calibrate/field_model.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "base/draws.hpp"
#include "base/refusal.hpp"
#include "calibrate/alignment.hpp"
#include "drover/base/random.hpp"
#include "numerics/solvers/fastest_growth.hpp"
#include "physics/structure.hpp"
#include "physics/whole_rate.hpp"

namespace drover::calibrate::field_model_tests {
namespace {

/// a = 0.1, lambda = 0.1, alpha/Gamma = 2 to 3, tau = 2, u = 3: g = 4 to 6.
Table flocking_table() {
    Table table{.varied_key = {}, .bead_fractions = {0.2, 0.4, 0.6}, .rod_fractions = {0.05, 0.1}, .rows = {}};
    const auto add = [&](const char* name, bool by_rods, std::vector<double> values, double part, Origin origin) {
        TableRow row{.name = name, .unit = "x", .formula = "x", .by_rods = by_rods};
        for (const double value : values)
            row.entries.push_back({.value = value, .error = part * value, .trials = 20, .origin = origin});
        table.rows.push_back(std::move(row));
    };
    add("relaxation_rate", false, {0.1, 0.1, 0.1}, 0.05, Origin::measured);
    add("weathercock", false, {0.1, 0.1, 0.1}, 0.1, Origin::measured);
    add("drag", true, {2.0, 2.2, 2.4, 2.6, 2.8, 3.0}, 0.04, Origin::measured);
    add("response_time", true, {2.0, 2.0, 2.0, 2.0, 2.0, 2.0}, 0.1, Origin::measured);
    add("propulsion", false, {3.0, 3.0, 3.0}, 0.02, Origin::measured);
    add("viscosity_kinematic", false, {5.0, 6.0, 7.0}, 0.1, Origin::measured);
    add("stiffness", false, {300.0, 400.0, 500.0}, 0.1, Origin::measured);
    add("bead_mass", false, {0.7, 0.7, 0.7}, 0.0, Origin::set);
    add("bead_area", false, {0.5, 0.5, 0.5}, 0.0, Origin::set);
    add("rod_area", false, {4.0, 4.0, 4.0}, 0.0, Origin::set);
    return table;
}
constexpr StatePoint dense{.bead_fraction = 0.6, .rod_fraction = 0.1};

double value_of(const std::string& key, OrderKind kind = OrderKind::orientation, const StatePoint& point = dense) {
    return field_number(flocking_table(), key, point, kind).number.value;
}

/// A model with every number from the table.
physics::Model model_of(const StatePoint& point, OrderKind kind) {
    const auto number = [&](const char* key) { return value_of(key, kind, point); };
    physics::Model model;
    model.fields = {.bead_density = true, .bead_velocity = "dynamic"};
    model.uniform = {.rod_density = number("uniform.rod_density"), .bead_density = number("uniform.bead_density")};
    model.current = {.speed = number("current.speed"), .kind = kind == OrderKind::density ? "order" : "density-order"};
    model.inertia.bead_mass = number("inertia.bead_mass");
    model.drag.coefficient = number("drag.coefficient");
    model.viscosity = {.shear = number("viscosity.shear"), .bulk = number("viscosity.bulk")};
    model.driving.strength = number("driving.strength");
    model.stiffness = {.beads = number("stiffness.beads"), .rods = number("stiffness.rods")};
    model.relaxation.rate = number("relaxation.rate");
    model.relaxation.saturation = number("relaxation.saturation");
    model.elasticity = {.stiffness = number("elasticity.stiffness"), .splay = number("elasticity.splay")};
    model.weathercock.strength = number("weathercock.strength");
    model.pressure = {.beads = number("pressure.beads"), .rods = number("pressure.rods")};
    model.noise.order = number("noise.order");
    return model;
}

TEST(FieldModel, has_the_expected_numbers) {
    const double sigma = 0.1 / 4.0, rho = 0.6 / 0.5, gamma = 0.7 * rho / 2.0, g = 2.0 * 0.1 * 3.0 / 0.1;
    const double order = order_of_alignment(g);
    const std::pair<const char*, double> expected[]{{"uniform.rod_density", sigma},
                                                    {"uniform.bead_density", rho},
                                                    {"drag.coefficient", gamma},
                                                    {"driving.strength", 3.0 * gamma},
                                                    {"viscosity.shear", 7.0 * 0.7 * rho},
                                                    {"stiffness.beads", 500.0},
                                                    {"relaxation.rate", 0.1},
                                                    {"relaxation.saturation", 0.1 * (0.5 * g - 1.0) / (order * order)},
                                                    {"elasticity.stiffness", 9.0 / 1.6},
                                                    {"weathercock.strength", 0.1},
                                                    {"advection.strength", 3.0 / 16.0 * g * 3.0},
                                                    {"pressure.rods", 1.5 / sigma},
                                                    {"noise.order", 0.1 / sigma}};
    for (const auto& [key, value] : expected) EXPECT_NEAR(value_of(key), value, 1e-12 * value) << key;
    for (const char* zero : {"viscosity.bulk", "stiffness.rods", "elasticity.splay", "pressure.beads"}) {
        const FieldNumber found = field_number(flocking_table(), zero, dense, OrderKind::orientation);
        EXPECT_EQ(found.number.value, 0.0) << zero;
        EXPECT_EQ(found.number.error, 0.0) << zero;
    }
}

TEST(FieldModel, of_a_flow_that_bends_has_the_flock_of_the_mean_field) {
    Table table = flocking_table();
    TableRow bend{.name = "drag_cubic", .unit = "x", .formula = "x", .by_rods = true};
    for (int i = 0; i < 6; ++i) bend.entries.push_back({.value = 0.8, .error = 0.1, .origin = Origin::measured});
    table.rows.push_back(bend);
    const auto number = [&](const char* key) { return field_number(table, key, dense, OrderKind::orientation).number; };
    const double a = 0.1, lambda = 0.1, g = 2.0 * lambda * 3.0 / a, cubic = 2.0 * lambda * 0.8 / a;
    const double order = order_of_alignment(g, cubic), gamma = number("drag.coefficient").value;
    EXPECT_NEAR(number("driving.cubic").value, 0.8 * gamma, 1e-9);
    const MeanField field = mean_field(table, dense);
    EXPECT_NEAR(field.order.value, order, 1e-9);
    EXPECT_NEAR(field.bead_velocity.value, (3.0 + 0.8 * order * order) * order, 1e-9);
    EXPECT_NEAR(predict_cell(table, dense, 2000.0).order, order_of_rods(50, g, cubic).mean, 1e-9);
    // The uniform flock of the equations: -a p + lambda v - b p^3 = 0 with v = (alpha + alpha_3 p^2) p/Gamma.
    const double flow = (number("driving.strength").value + number("driving.cubic").value * order * order) / gamma;
    EXPECT_NEAR(a + number("relaxation.saturation").value * order * order, lambda * flow, 1e-9);
    // For p = sigma P.
    const double sigma = 0.1 / 4.0;
    EXPECT_NEAR(field_number(table, "driving.cubic", dense, OrderKind::density).number.value,
                0.8 * gamma / std::pow(sigma, 3), 1e-6);
    // A table that fitted a straight line does not count its zero as measured.
    EXPECT_EQ(field_number(flocking_table(), "driving.cubic", dense, OrderKind::orientation).origin, Origin::set);
}

TEST(FieldModel, has_the_alignment_of_flow_and_contacts) {
    Table table = flocking_table();
    TableRow c{.name = "contact_alignment", .unit = "x", .formula = "x"};
    for (int i = 0; i < 3; ++i) c.entries.push_back({.value = 1.6, .error = 0.2, .origin = Origin::measured});
    table.rows.push_back(c);
    const double sigma = 0.1 / 4.0, a = 0.1, flow = 2.0 * 0.1 * 3.0 / a, g = flow + 2.0 * 1.6 * sigma / a;
    const auto number = [&](const char* key) { return field_number(table, key, dense, OrderKind::orientation).number; };
    const double order = order_of_alignment(g);
    EXPECT_NEAR(number("relaxation.contact").value, 1.6, 1e-12);
    EXPECT_NEAR(number("relaxation.saturation").value, a * (0.5 * g - 1.0) / (order * order), 1e-9);
    const MeanField field = mean_field(table, dense);
    EXPECT_NEAR(field.alignment.value, g, 1e-9);
    EXPECT_NEAR(field.effective_relaxation.value, a - 1.6 * sigma - 0.1 * 3.0, 1e-9);
    EXPECT_NEAR(field.order.value, order, 1e-9);
    // Local coefficients have a - c sigma at the nodes.
    const physics::TableData local = density_table(table, dense, OrderKind::orientation);
    EXPECT_NEAR(local.columns.at("relaxation.rate").values.back(), a - 1.6 * sigma, 1e-9);
    const CellPrediction cell = predict_cell(table, dense, 4.0 * 50.0 / 0.1);
    EXPECT_EQ(cell.rods, 50);
    EXPECT_NEAR(cell.order, order_of_rods(50, g).mean, 1e-9);
    EXPECT_LT(cell.low, cell.order);
    EXPECT_GT(cell.high, cell.order);
}

/// The power of sigma by which a coefficient is multiplied when p changes from P to sigma P: -1 for driving.strength,
/// 1 for weathercock.strength.
double power_of_density(const std::string& key, double sigma) {
    return std::round(std::log(value_of(key, OrderKind::density) / value_of(key)) / std::log(sigma));
}

TEST(FieldModel, of_the_current_has_the_closures_of_independent_rods) {
    // With p the current sigma u P, as in the Methods: J = p, so u = 1 there; from sigma P by powers of u.
    const double sigma = 0.1 / 4.0, u = 3.0, a = 0.1, g = 2.0;
    const auto current = [&](const char* key) {
        return value_of(key, OrderKind::density) * std::pow(u, power_of_density(key, sigma));
    };
    EXPECT_NEAR(current("noise.order"), a * sigma * u * u, 1e-12);
    EXPECT_NEAR(current("pressure.rods"), 0.5 * u * u, 1e-12);
    EXPECT_NEAR(current("weathercock.strength") * current("driving.strength"),
                value_of("weathercock.strength") * value_of("driving.strength"), 1e-12);
    EXPECT_NEAR(saturation_of_alignment(g) * a / std::pow(sigma * u, 2), a * g * g / (8.0 * std::pow(sigma * u, 2)),
                1e-9);
}

TEST(FieldModel, has_the_same_growth_and_fluctuations_in_both_normalisations) {
    // Rates do not depend on the normalisation of p; of the order coefficients the models share only a and K3.
    const physics::Model a = model_of(dense, OrderKind::orientation), b = model_of(dense, OrderKind::density);
    const numerics::Grid grid{.nx = 16, .ny = 16, .lx = 45.0, .ly = 45.0};
    const auto growth_a = numerics::fastest_growth(physics::linear_system(a, grid)),
               growth_b = numerics::fastest_growth(physics::linear_system(b, grid));
    EXPECT_GT(growth_a.rate, 0.0);
    EXPECT_NEAR(growth_a.rate, growth_b.rate, 1e-10 * growth_a.rate);
    EXPECT_NEAR(numerics::fastest_rate(physics::linear_system(a, grid)),
                numerics::fastest_rate(physics::linear_system(b, grid)), 1e-9);
    // Stationary structure factors below onset: equal for rods, a factor sigma^2 for the order.
    Table weak = flocking_table();
    for (TableEntry& entry : weak.rows[1].entries) entry.value *= 0.25;
    const auto structure = [&](OrderKind kind) {
        physics::Model model = model_of(dense, kind);
        model.weathercock.strength = field_number(weak, "weathercock.strength", dense, kind).number.value;
        return physics::structure_factor(physics::linear_system(model, grid), physics::form(model), 0.5);
    };
    const double sigma = 0.1 / 4.0;
    const physics::StructureFactor p = structure(OrderKind::orientation), w = structure(OrderKind::density);
    EXPECT_NEAR(w.rods, p.rods, 1e-9 * p.rods);
    EXPECT_NEAR(w.order_across, p.order_across * sigma * sigma, 1e-9 * w.order_across);
}

TEST(FieldModel, of_non_interacting_rods_has_the_fluctuations_of_independent_rods) {
    // sigma <|P_q|^2> = 1/2 per component for random directions and any diffusion; K3 > 0 lowers it only at q > 0.
    Table weak = flocking_table();
    for (TableEntry& entry : weak.rows[1].entries) entry.value = 0.0;
    physics::Model model = model_of(dense, OrderKind::orientation);
    model.weathercock.strength = 0.0;
    const numerics::Grid grid{.nx = 16, .ny = 16, .lx = 1e4, .ly = 1e4};
    const auto found = physics::structure_factor(physics::linear_system(model, grid), physics::form(model), 1e-6);
    EXPECT_NEAR(found.order_across * model.uniform.rod_density, 0.5, 1e-6);
}

TEST(FieldModel, has_a_uniform_flock_with_mean_field_order_and_flow) {
    for (const OrderKind kind : {OrderKind::orientation, OrderKind::density}) {
        const physics::Equations equations(model_of(dense, kind));
        const physics::StationaryStates states = physics::stationary_states(equations);
        ASSERT_EQ(states.states.size(), 2u) << states.no_order;
        const double unit = kind == OrderKind::density ? uniform_of(equations.model).rod_density : 1.0;
        const MeanField expected = mean_field(flocking_table(), dense);
        EXPECT_NEAR(states.states[1].point.order.norm() / unit, expected.order.value, 1e-10);
        EXPECT_NEAR(states.states[1].point.velocity.norm(), expected.bead_velocity.value, 1e-10);
        EXPECT_NEAR(expected.alignment.value, 6.0, 1e-12);
        EXPECT_NEAR(expected.effective_relaxation.value,
                    physics::effective_coefficients(equations, uniform_of(equations.model).bead_density,
                                                    uniform_of(equations.model).rod_density)
                        .relaxation,
                    1e-12);
    }
}

TEST(FieldModel, has_errors_that_match_the_spread_over_redrawn_tables) {
    const Table table = flocking_table();
    for (const char* key : {"driving.strength", "relaxation.saturation", "elasticity.stiffness"}) {
        const double error = field_number(table, key, dense, OrderKind::density).number.error;
        std::vector<double> values;
        constexpr int draws = 4000;
        for (int i = 0; i < draws; ++i) {
            Table redrawn = table;
            std::vector<double> normal(200);
            fill_normal({.seed = static_cast<std::uint64_t>(i), .stream = Stream::test}, 0, 1, normal);
            std::size_t next = 0;
            for (TableRow& row : redrawn.rows)
                for (TableEntry& entry : row.entries) entry.value += entry.error * normal[next++];
            values.push_back(field_values(redrawn, {key}, dense, OrderKind::density).front());
        }
        // Half of the distance of two quantiles is known to 5 % from 400 draws and to 1.6 % from 4000.
        EXPECT_NEAR(half_width(values) / error, 1.0, 0.13) << key;
    }
}

TEST(FieldModel, has_the_error_of_the_table_for_a_coefficient_that_is_one_of_its_rows) {
    Table table = flocking_table();
    const TableEntry& a = table.rows[0].entries[1];
    // The draws of one number have its error: 400 parts of equal probability, and quantiles between their middles.
    EXPECT_NEAR(field_number(table, "relaxation.rate", {.bead_fraction = 0.4, .rod_fraction = 0.1}, OrderKind::density)
                    .number.error,
                a.error, 1e-4 * a.error);
}

TEST(RedrawnModels, have_the_errors_of_their_numbers_and_keep_what_a_scene_has_changed) {
    const Table table = flocking_table();
    physics::ModelValues model = model_of(dense, OrderKind::orientation);
    const std::vector<std::string> keys{"relaxation.rate", "weathercock.strength"};
    fill_model(table, dense, keys, model);
    const auto spread_of_rate = [&] {
        std::vector<double> rates;
        for (const physics::ModelValues& one : redrawn_models(table, dense, keys, model, 100))
            rates.push_back(number(one, "relaxation.rate"));
        return half_width(rates);
    };
    const double error = field_number(table, "relaxation.rate", dense, OrderKind::orientation).number.error;
    EXPECT_NEAR(spread_of_rate(), error, 1e-3 * error);  // 100 parts of equal probability
    number_in(model, "relaxation.rate") *= 1.01;
    EXPECT_EQ(spread_of_rate(), 0.0);
}

TEST(DensityTable, has_the_coefficients_of_a_uniform_state_at_and_between_the_nodes_of_the_table) {
    Table table = flocking_table();
    const std::vector<double> response{2.0, 1.8, 0.9, 0.8, 0.3, 0.2};  // Gamma grows tenfold
    for (std::size_t i = 0; i < response.size(); ++i) {
        table.rows[3].entries[i].value = response[i];
        table.rows[3].entries[i].error = 0.01;
    }
    const physics::TableData data = density_table(table, dense, OrderKind::orientation);
    const auto local = [&](const char* key, double bead, double rod) {
        const numerics::SplineTable spline(data.nodes[0], data.nodes[1], data.column(key).values,
                                           numerics::Outside::refuse);
        return spline.at(bead / 0.5, rod / 4.0).value;
    };
    // At nodes within rounding.  Between them quotients of splines through these nodes alone differ from the measured
    // alpha/Gamma by 0.03 to 0.7, at the ends by 0.13; a quarter of the distance leaves (1/4)^2 of that there, 0.008,
    // and less inside.
    for (const double bead : table.bead_fractions)
        for (const double rod : table.rod_fractions)
            for (const char* key : {"driving.strength", "drag.coefficient"})
                EXPECT_NEAR(local(key, bead, rod) / field_values(table, {key},
                                                                 {.bead_fraction = bead, .rod_fraction = rod},
                                                                 OrderKind::orientation)[0],
                            1.0, 1e-12);
    const SmoothCoefficient measured(table, "drag");
    for (const double bead : {0.23, 0.31, 0.47, 0.55, 0.59})
        for (const double rod : {0.06, 0.085})
            EXPECT_NEAR(local("driving.strength", bead, rod) / local("drag.coefficient", bead, rod),
                        measured.at(bead, rod).value, 0.01);
    physics::ModelValues model = model_of(dense, OrderKind::orientation);
    model.table = data;
    physics::check(model);
}

TEST(FieldModel, names_what_is_missing_in_the_table) {
    Table table = flocking_table();
    const auto why_no_error = [&](const char* key, StatePoint point = dense) {
        return refusal_of([&] { field_number(table, key, point, OrderKind::orientation); });
    };
    EXPECT_EQ(why_no_error("noise.beads"), "noise.beads is not a key that a table of coefficients provides");
    EXPECT_NE(why_no_error("relaxation.rate", {.bead_fraction = 0.7, .rod_fraction = 0.1})
                  .find("the table covers 0.2 to 0.6"),
              std::string::npos);
    EXPECT_EQ(field_number(table, "relaxation.rate",
                           {.bead_fraction = 0.7, .rod_fraction = 0.1, .outside = numerics::Outside::hold},
                           OrderKind::orientation)
                  .number.value,
              0.1);
    table.rows[6].entries[1] = {.value = NAN, .error = NAN, .origin = Origin::missing, .remark = "too soft"};
    EXPECT_NE(why_no_error("stiffness.beads").find("no value of stiffness at bead area fraction 0.4"),
              std::string::npos);
    EXPECT_NEAR(value_of("relaxation.rate"), 0.1, 1e-15);  // does not depend on that row
}

TEST(FieldModel, rejects_divisors_that_may_be_zero) {
    Table table = flocking_table();
    for (TableEntry& entry : table.rows[0].entries) entry.error = 0.4 * entry.value;
    const auto why_no_error = [&](const char* key) {
        return refusal_of([&] { field_number(table, key, dense, OrderKind::orientation); });
    };
    EXPECT_EQ(why_no_error("elasticity.stiffness"),
              "elasticity.stiffness: the divisor relaxation_rate = 0.1 +- 0.04 is not significantly different from 0; "
              "expected a smaller error: run more trials, or set elasticity.stiffness in the scene");
    EXPECT_NE(why_no_error("relaxation.saturation").find("not significantly different from 0"), std::string::npos);
    EXPECT_EQ(why_no_error("noise.order"), "no refusal");  // not a divisor
    EXPECT_NE(refusal_of([&] {
                  mean_field(table, dense);
              }).find("the order of the mean field: the divisor relaxation_rate"),
              std::string::npos);
}

TEST(FieldModel, counts_as_short_if_a_node_around_it_is) {
    Table table = flocking_table();
    table.rows[1].entries[1].origin = Origin::measured_short;  // lambda at Phi_b = 0.4
    const auto origin = [&](const char* key, double beads) {
        return field_number(table, key, {.bead_fraction = beads, .rod_fraction = 0.1}, OrderKind::orientation).origin;
    };
    for (const double beads : {0.3, 0.4, 0.5})
        EXPECT_EQ(origin("weathercock.strength", beads), Origin::measured_short) << beads;
    for (const double beads : {0.2, 0.6}) EXPECT_EQ(origin("weathercock.strength", beads), Origin::measured) << beads;
    EXPECT_EQ(origin("relaxation.rate", 0.4), Origin::measured);
    EXPECT_EQ(origin("relaxation.saturation", 0.4), Origin::closure);
}

}  // namespace
}  // namespace drover::calibrate::field_model_tests
