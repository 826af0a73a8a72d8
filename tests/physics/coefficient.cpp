// tests/physics/coefficient.cpp: coefficients that depend on the densities: polynomials as written, tables as smooth
// surfaces.
#include "physics/compiled_model.hpp"

#include <gtest/gtest.h>

#include <array>

#include "physics/rod_bead_model.hpp"

namespace drover::physics::coefficient_tests {
namespace {

TEST(Monomial, is_read_as_it_is_written) {
    const Monomial m = read_monomial("-0.5 rho sigma^2", {});
    EXPECT_EQ(m.factor, -0.5);
    EXPECT_EQ(m.powers, (std::array{1, 2}));
    EXPECT_EQ(read_monomial("3 sigma", {}).powers, (std::array{0, 1}));
    EXPECT_EQ(read_monomial("1e-3 rho rho", {}).powers, (std::array{2, 0}));
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

TEST(Coefficient, of_monomials_has_the_value_the_degree_and_the_text_of_the_polynomial) {
    const Coefficient c(0.3, {{.factor = 2.0, .powers = {1, 2}}, {.factor = -1.0, .powers = {0, 3}}});
    EXPECT_DOUBLE_EQ(c.at({1.5, 0.5}), 0.3 + 2.0 * 1.5 * 0.25 - 0.125);
    EXPECT_EQ(c.degree(), 3);
    EXPECT_TRUE(c.depends_on(0));
    EXPECT_FALSE(Coefficient(1.0).varies());
    EXPECT_EQ(c.text_of(), "0.3 + 2 rho sigma^2 - 1 sigma^3");
}

TEST(Model, with_a_table_and_a_polynomial_for_one_coefficient_is_rejected) {
    Model model{.relaxation = {.rate_terms = {"1 sigma"}},
                .table = {.rod_density = {0.5, 2.0}, .columns = {{"relaxation.rate", {{0.1, 0.2}, {}}}}}};
    EXPECT_THROW(check(model), Error);
    model.relaxation.rate_terms.clear();
    EXPECT_NO_THROW(check(model));
    EXPECT_NEAR(Equations(model).coefficient("relaxation.rate").at({0.0, 1.25}), 0.15, 1e-15);
    model.uniform.rod_density = 3.0;
    EXPECT_THROW(check(model), Error) << "the uniform state lies outside the table";
}

TEST(Coefficient, of_relaxation_is_lowered_by_the_contacts_of_rods) {
    Model model{.fields = {.rod_density = true}, .uniform = {.rod_density = 0.5}};
    model.relaxation = {.rate = 0.4, .rate_terms = {"0.1 sigma^2"}, .contact = 0.3};
    const CompiledModel rods(model);
    EXPECT_NEAR(rods.coefficient("relaxation.rate").at({0.0, 2.0}), 0.4 + 0.1 * 4.0 - 0.3 * 2.0, 1e-15);
    // A form without rod density has the contacts of the uniform one.
    model.fields.rod_density = false;
    model.relaxation.rate_terms = {};
    EXPECT_NEAR(CompiledModel(model).coefficient("relaxation.rate").at({}), 0.4 - 0.3 * 0.5, 1e-15);
    model.table = {.rod_density = {0.1, 1.0}, .columns = {{"relaxation.rate", {{0.4, 0.3}, {}}}}};
    EXPECT_THROW(CompiledModel{model}, Error);
}

}  // namespace
}  // namespace drover::physics::coefficient_tests
