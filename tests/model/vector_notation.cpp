// tests/model/vector_notation.cpp: vector notation equals its formulas by components; conservation and parity.
#include <gtest/gtest.h>

#include <random>

#include "base/refusal.hpp"
#include "drover/model/equations.hpp"
#include "numerics/steppers/linear_operator.hpp"

namespace drover::model::vector_notation_tests {
namespace {

using numerics::Complex;
using numerics::Spectra;
constexpr numerics::Grid grid{.nx = 24, .ny = 20, .lx = 9.0, .ly = 7.0};

Model with(Field field, bool chiral = false) {
    Model model;
    field.symbol = "s", field.name = "field";
    model.fields = {std::move(field),
                    {.name = "density", .symbol = "sigma"},
                    {.name = "order", .symbol = "p", .spin = 1},
                    {.name = "velocity", .symbol = "v", .spin = 1},
                    {.name = "nematic", .symbol = "Q", .spin = 2, .left = LeftSide::balance},
                    {.name = "vorticity", .symbol = "omega", .odd = true, .left = LeftSide::balance}};
    // Any field can be read where it is in balance: here of the others, so that the layout has scalars and vectors.
    model.fields[4].equation = {"sym(grad v) - Q", {}};
    model.fields[5].equation = {"curl v - omega", {}};
    if (model.fields[0].spin == 1) {  // a third vector would be one too many for a layout
        model.fields[3].left = LeftSide::balance;
        model.fields[3].equation = {"grad sigma + 0.3 lap p - v", {}};
    }
    if (chiral) model.fields[4].left = model.fields[5].left = LeftSide::rate;  // a balance must be isotropic
    model.chiral = chiral;
    return model;
}

/// The rate of the first field on random waves.
Spectra rate_of(const Field& field) {
    Threads threads(1);
    const Equations equations(with(field));
    const numerics::System system = equations.system(grid, threads);
    std::mt19937 random(11);
    std::normal_distribution<double> normal;
    const int count = static_cast<int>(equations.state_components().size());
    Spectra state(grid, count), rate(grid, count);
    const std::size_t width = numerics::columns(grid);
    for (const std::size_t component : {1u, 2u, 3u, 4u, 5u})  // sigma, p, v: the same whatever the first field is
        for (const std::size_t mode : {std::size_t{0}, std::size_t{1}, width + 1, width * 19 + 1}) {
            const Complex value(normal(random), mode == 0 ? 0.0 : normal(random));
            const auto& arrays = equations.state_components();
            const int shift = components(field) - 1;
            const auto place = std::find(arrays.begin(), arrays.end(), static_cast<int>(component) + shift);
            if (place != arrays.end()) state[static_cast<int>(place - arrays.begin())][mode] = value;
        }
    if (system.nonlinear) system.nonlinear(0.0, state, rate);
    numerics::LinearOperator(system).add(state, rate);
    const int first = field.spin == 0 ? 0 : 1;  // after sigma
    Spectra result(grid, components(field));
    for (int k = 0; k < components(field); ++k) std::ranges::copy(rate[first + k], result[k].begin());
    return result;
}

/// The rates differ by rounding of some tens of operations and of the transforms.
void expect_equal(const Spectra& a, const Spectra& b, const std::string& what) {
    double size = 0.0, difference = 0.0;
    for (int k = 0; k < a.count(); ++k)
        for (std::size_t m = 0; m < a.size; ++m) {
            size = std::max(size, std::abs(a[k][m]));
            difference = std::max(difference, std::abs(a[k][m] - b[k][m]));
        }
    EXPECT_GT(size, 0.01) << what;
    EXPECT_LT(difference, 1e-13 * std::max(size, 1.0)) << what;
}

TEST(VectorNotation, of_a_scalar_is_its_formula_by_components) {
    for (const auto& [notation, by_components] :
         {std::pair{"p.v", "p_x v_x + p_y v_y"},
          {"p.grad sigma", "p_x d_x sigma + p_y d_y sigma"},
          {"div p", "d_x p_x + d_y p_y"},
          {"lap sigma", "d_x d_x sigma + d_y d_y sigma"},
          {"div div Q", "d_x d_x Q_xx + 2 d_x d_y Q_xy - d_y d_y Q_xx"},
          {"Q:Q", "2 Q_xx^2 + 2 Q_xy^2"},
          {"Q:grad v", "Q_xx (d_x v_x - d_y v_y) + Q_xy (d_x v_y + d_y v_x)"},
          {"Q:outer(p, v)", "Q_xx (p_x v_x - p_y v_y) + Q_xy (p_x v_y + p_y v_x)"},
          {"p.Q.v", "Q_xx (p_x v_x - p_y v_y) + Q_xy (p_x v_y + p_y v_x)"},
          {"(grad v):grad v", "(d_x v_x)^2 + (d_x v_y)^2 + (d_y v_x)^2 + (d_y v_y)^2"},
          {"omega curl v", "omega (d_x v_y - d_y v_x)"},
          {"p.perp v curl v", "(p_y v_x - p_x v_y) (d_x v_y - d_y v_x)"},
          {"omega^2 + |p|^2", "omega omega + p_x^2 + p_y^2"}}) {
        const auto rate = [](const char* text) { return rate_of({.equation = {text, {}}}); };
        expect_equal(rate(notation), rate(by_components), notation);
    }
}

TEST(VectorNotation, of_a_vector_is_its_formula_by_components) {
    const auto rate = [](const std::string& text) { return rate_of({.spin = 1, .equation = {text, {}}}); };
    for (const auto& [notation, along_x, along_y] :
         {std::array{"p.grad p", "p_x d_x p_x + p_y d_y p_x", "p_x d_x p_y + p_y d_y p_y"},
          {"p.grad v", "p_x d_x v_x + p_y d_y v_x", "p_x d_x v_y + p_y d_y v_y"},
          {"div Q", "d_x Q_xx + d_y Q_xy", "d_x Q_xy - d_y Q_xx"},
          {"Q.p", "Q_xx p_x + Q_xy p_y", "Q_xy p_x - Q_xx p_y"},
          {"p.Q", "Q_xx p_x + Q_xy p_y", "Q_xy p_x - Q_xx p_y"},
          {"omega perp p", "-omega p_y", "omega p_x"},
          {"perp grad omega", "-d_y omega", "d_x omega"},
          {"grad(div v)", "d_x d_x v_x + d_x d_y v_y", "d_x d_y v_x + d_y d_y v_y"},
          {"div outer(p, v)", "d_x(p_x v_x) + d_y(p_y v_x)", "d_x(p_x v_y) + d_y(p_y v_y)"},
          {"div sym(grad v)", "0.5 (d_x(d_x v_x - d_y v_y) + d_y(d_x v_y + d_y v_x))",
           "0.5 (d_x(d_x v_y + d_y v_x) - d_y(d_x v_x - d_y v_y))"},
          {"sigma p div p", "sigma p_x (d_x p_x + d_y p_y)", "sigma p_y (d_x p_x + d_y p_y)"}})
        expect_equal(rate(notation), rate(text("({}) e_x + ({}) e_y", along_x, along_y)), notation);
}

TEST(VectorNotation, of_a_nematic_is_its_formula_by_components) {
    // The two components through a contraction: T:sym(grad p) = T_1 (d_x p_x - d_y p_y) + T_2 (d_x p_y + d_y p_x).
    const auto rate = [](const std::string& text) { return rate_of({.equation = {text, {}}}); };
    for (const auto& [notation, first, second] :
         {std::array{"sym(grad v)", "0.5 (d_x v_x - d_y v_y)", "0.5 (d_x v_y + d_y v_x)"},
          {"sym(outer(p, v))", "0.5 (p_x v_x - p_y v_y)", "0.5 (p_x v_y + p_y v_x)"},
          {"omega perp Q", "-omega Q_xy", "omega Q_xx"},
          {"(p.grad Q)", "p_x d_x Q_xx + p_y d_y Q_xx", "p_x d_x Q_xy + p_y d_y Q_xy"}})
        expect_equal(rate(text("({}):sym(grad p)", notation)),
                     rate(text("({}) (d_x p_x - d_y p_y) + ({}) (d_x p_y + d_y p_x)", first, second)), notation);
}

std::string why_no_error(const std::string& equation, bool conserved, bool odd = false, bool chiral = false) {
    return refusal_of([&] {
        const Equations equations(
            with({.odd = odd, .equation = {equation, {"test", 1, 1}}, .conserved = conserved}, chiral));
    });
}

TEST(Conservation, holds_for_what_is_a_divergence_although_it_is_not_written_as_one) {
    for (const char* divergence :
         {"-div(sigma p)", "lap sigma", "p.grad sigma + sigma div p", "(p.grad sigma + sigma div p)",
          "p.grad sigma + lap s + sigma div p", "sigma lap s - s lap sigma", "lap(s^3 - s - lap s)",
          "grad(s).grad(sigma) + s lap sigma", "d_x s d_y sigma - d_y s d_x sigma", "omega curl grad s", "s^2 d_x s",
          "d_x(p_x^2)"})
        EXPECT_EQ(why_no_error(divergence, true), "no refusal") << divergence;
    EXPECT_EQ(why_no_error("p.perp grad sigma + sigma curl p", true, true), "no refusal");
    for (const char* source : {"p.grad sigma", "sigma div p", "p.grad sigma - sigma div p", "s lap s", "1", "s - s^2",
                               "lap s + 1e-9", "p_x d_y s", "grad(s).grad(sigma)"})
        EXPECT_NE(why_no_error(source, true).find("no divergence"), std::string::npos) << source;
}

TEST(Parity, of_a_pseudoscalar_fits_curl_and_needs_chiral_for_a_true_scalar) {
    EXPECT_EQ(why_no_error("curl v - s + lap s", false, true), "no refusal");
    EXPECT_NE(why_no_error("sigma + omega", false).find("chiral = true"), std::string::npos);
    EXPECT_EQ(why_no_error("sigma + omega", false, false, true), "no refusal");
    EXPECT_NE(why_no_error("sigma omega", false).find("a pseudoscalar; expected a scalar"), std::string::npos);
    EXPECT_NE(why_no_error("2^omega", false).find("the exponent is a pseudoscalar"), std::string::npos);
}

TEST(Mass, divides_every_force_that_does_not_have_exactly_the_mass_as_its_first_factors) {
    const auto rate = [](const std::string& mass, const std::string& force) {
        Model model{.fields = {{.name = "s", .symbol = "s", .mass = {mass, {}}, .equation = {force, {}}}},
                    .coefficients = {{"m", 2.0}, {"k", 5.0}}};
        return Equations(model).uniform_rates({0.5})(0);
    };
    // Two or three operations each: at most a few units in the last place.
    EXPECT_NEAR(rate("m", "m / k"), 2.0 / 5.0 / 2.0, 1e-15);
    EXPECT_NEAR(rate("m", "m k s"), 5.0 * 0.5, 1e-15);
    EXPECT_NEAR(rate("1 + s^2", "(1 - s^2) s"), 0.75 * 0.5 / 1.25, 1e-15);
    EXPECT_NEAR(rate("1 + s^2", "(1 + s^2) s"), 0.5, 1e-15);
}

}  // namespace
}  // namespace drover::model::vector_notation_tests
