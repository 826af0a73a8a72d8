// tests/physics/coefficient.cpp: coefficients that depend on the densities: polynomials as written, tables as smooth
// surfaces.
#include "drover/physics/coefficient.hpp"

#include <gtest/gtest.h>

#include <array>
#include <cmath>

#include "drover/physics/equations.hpp"

namespace drover::physics::coefficient_tests {
namespace {

TEST(Monomial, is_read_as_it_is_written) {
    const Monomial m = read_monomial("-0.5 rho sigma^2", {});
    EXPECT_EQ(m.factor, -0.5);
    EXPECT_EQ(m.beads, 1);
    EXPECT_EQ(m.rods, 2);
    EXPECT_EQ(read_monomial("3 sigma", {}).rods, 1);
    EXPECT_EQ(read_monomial("1e-3 rho rho", {}).beads, 2);
}

TEST(Monomial, invalid_text_is_rejected_with_its_location_and_the_expected_form) {
    for (const char* written :
         {"", "rho", "2", "1 tau", "1 rho^", "1 rho^-1", "1 rho^9", "nan rho", "1 rho^1.5", "2rho"})
        try {
            read_monomial(written, {.file = "flock.toml", .line = 7});
            ADD_FAILURE() << written << " was read";
        } catch (const Error& error) {
            EXPECT_EQ(std::string(error.what()).rfind("flock.toml:7: ", 0), 0u) << error.what();
            EXPECT_NE(std::string(error.what()).find("expected"), std::string::npos) << error.what();
        }
}

TEST(Coefficient, of_monomials_has_the_value_the_slopes_and_the_degree_of_the_polynomial) {
    const Coefficient c(0.3, {{.factor = 2.0, .beads = 1, .rods = 2}, {.factor = -1.0, .beads = 0, .rods = 3}});
    const Dependence d = c.at(1.5, 0.5);
    EXPECT_DOUBLE_EQ(d.value, 0.3 + 2.0 * 1.5 * 0.25 - 0.125);
    EXPECT_DOUBLE_EQ(d.by_beads, 2.0 * 0.25);
    EXPECT_DOUBLE_EQ(d.by_rods, 2.0 * 1.5 * 2.0 * 0.5 - 3.0 * 0.25);
    EXPECT_EQ(c.degree(), 3);
    EXPECT_TRUE(c.depends_on_beads());
    EXPECT_FALSE(Coefficient(1.0).varies());
    const std::array<double, 2> beads{1.5, 2.0}, rods{0.5, 1.0};
    std::array<double, 2> out{};
    c.evaluate(beads.data(), rods.data(), 0.1, out);
    EXPECT_DOUBLE_EQ(out[0], d.value - 0.1);
    EXPECT_DOUBLE_EQ(out[1], c.at(2.0, 1.0).value - 0.1);
}

CoefficientTable table_of(double (*f)(double, double), Outside outside = Outside::refuse) {
    const std::vector<double> beads{0.2, 0.35, 0.4, 0.6, 0.7}, rods{0.05, 0.08, 0.11};
    std::vector<double> values;
    for (const double b : beads)
        for (const double r : rods) values.push_back(f(b, r));
    return {beads, rods, values, outside};
}

TEST(CoefficientTable, of_a_bilinear_function_is_that_function) {
    // Cubic splines with natural ends leave straight lines alone.
    const CoefficientTable table = table_of([](double b, double r) { return 1.0 + 2.0 * b - 3.0 * r + 4.0 * b * r; });
    for (const double b : {0.2, 0.27, 0.5, 0.7})
        for (const double r : {0.05, 0.1, 0.11}) {
            const Dependence d = table.at(b, r);
            EXPECT_NEAR(d.value, 1.0 + 2.0 * b - 3.0 * r + 4.0 * b * r, 1e-13);
            EXPECT_NEAR(d.by_beads, 2.0 + 4.0 * r, 1e-12);
            EXPECT_NEAR(d.by_rods, -3.0 + 4.0 * b, 1e-12);
        }
}

TEST(CoefficientTable, passes_through_its_nodes_and_its_slopes_are_those_of_its_values) {
    const auto f = [](double b, double r) { return std::sin(5.0 * b) * std::exp(10.0 * r); };
    const CoefficientTable table = table_of(f);
    EXPECT_NEAR(table.at(0.35, 0.08).value, f(0.35, 0.08), 1e-14);
    EXPECT_NEAR(table.at(0.7, 0.11).value, f(0.7, 0.11), 1e-14);
    for (const double b : {0.23, 0.35, 0.47, 0.62})
        for (const double r : {0.06, 0.08, 0.1}) {
            // Central differences: truncation 1e-12 times third derivatives of order 1e3 for rods, rounding 1e-16/1e-6.
            const double h = 1e-6, rounding = 1e-7;
            EXPECT_NEAR(table.at(b, r).by_beads, (table.at(b + h, r).value - table.at(b - h, r).value) / (2 * h),
                        rounding);
            EXPECT_NEAR(table.at(b, r).by_rods, (table.at(b, r + h).value - table.at(b, r - h).value) / (2 * h),
                        rounding);
        }
}

TEST(CoefficientTable, of_one_node_or_two_is_constant_or_straight) {
    const CoefficientTable constant({0.0}, {0.0}, {2.5}, Outside::refuse);
    EXPECT_EQ(constant.at(3.0, -1.0).value, 2.5);
    EXPECT_FALSE(constant.depends_on_beads());
    const CoefficientTable line({0.0, 2.0}, {0.0}, {1.0, 5.0}, Outside::refuse);
    EXPECT_DOUBLE_EQ(line.at(0.5, 0.0).value, 2.0);
    EXPECT_DOUBLE_EQ(line.at(0.5, 0.0).by_beads, 2.0);
}

TEST(CoefficientTable, outside_its_nodes_returns_nan_or_holds_the_edge_value) {
    const auto f = [](double b, double r) { return b + r; };
    EXPECT_TRUE(std::isnan(table_of(f).at(0.71, 0.08).value));
    EXPECT_TRUE(std::isnan(table_of(f).at(0.5, 0.04).value));
    const Dependence held = table_of(f, Outside::hold).at(0.9, 0.08);
    EXPECT_NEAR(held.value, 0.78, 1e-14);
    EXPECT_EQ(held.by_beads, 0.0);
    EXPECT_NEAR(held.by_rods, 1.0, 1e-12);
}

TEST(CoefficientTable, with_inconsistent_sizes_is_rejected) {
    EXPECT_THROW(CoefficientTable({0.0, 1.0}, {0.0}, {1.0}, Outside::refuse), Error);
    EXPECT_THROW(CoefficientTable({1.0, 1.0}, {0.0}, {1.0, 2.0}, Outside::refuse), Error);
    EXPECT_THROW(CoefficientTable({}, {0.0}, {}, Outside::refuse), Error);
    EXPECT_THROW(CoefficientTable({0.0}, {0.0}, {NAN}, Outside::refuse), Error);
}

TEST(Model, with_a_table_and_a_polynomial_for_one_coefficient_is_rejected) {
    Model model{.relaxation = {.rate_terms = {"1 sigma"}},
                .table = {.rod_density = {0.5, 2.0}, .columns = {{"relaxation.rate", {{0.1, 0.2}, {}}}}}};
    EXPECT_THROW(check(model), Error);
    model.relaxation.rate_terms.clear();
    EXPECT_NO_THROW(check(model));
    EXPECT_NEAR(Equations(model).relaxation.at(0.0, 1.25).value, 0.15, 1e-15);
    model.uniform.rod_density = 3.0;
    EXPECT_THROW(check(model), Error) << "the uniform state lies outside the table";
}

TEST(Coefficient, of_relaxation_is_lowered_by_the_contacts_of_rods) {
    Model model{.fields = {.rod_density = true}, .uniform = {.rod_density = 0.5}};
    model.relaxation = {.rate = 0.4, .rate_terms = {"0.1 sigma^2"}, .contact = 0.3};
    const CompiledModel rods(model);
    EXPECT_NEAR(rods.relaxation.at(0.0, 2.0).value, 0.4 + 0.1 * 4.0 - 0.3 * 2.0, 1e-15);
    EXPECT_NEAR(rods.relaxation.at(0.0, 2.0).by_rods, 0.1 * 4.0 - 0.3, 1e-15);
    // A form without rod density has the contacts of the uniform one.
    model.fields.rod_density = false;
    model.relaxation.rate_terms = {};
    EXPECT_NEAR(CompiledModel(model).relaxation.at(0.0, 0.0).value, 0.4 - 0.3 * 0.5, 1e-15);
    model.table = {.rod_density = {0.1, 1.0}, .columns = {{"relaxation.rate", {{0.4, 0.3}, {}}}}};
    EXPECT_THROW(CompiledModel{model}, Error);
}

}  // namespace
}  // namespace drover::physics::coefficient_tests
