// tests/theory/nearly_equal.cpp: fluctuations of modes of nearly equal rates beside faster fields and in other units.
#include "theory/models.hpp"

namespace drover::theory::nearly_equal_tests {
namespace {

Covariance found_at(const model::Model& model, double q) {
    const model::UniformState rest(model.fields.size(), 0.0);
    return covariance(model::LinearisedAt(model::Equations(model), rest), {q, 0.0});
}

/// X'' + 2 X' + (1 + e) X = noise, critically damped at e = 0, beside a third field; noise of v and of that field.
model::Model oscillator(double e, const std::string& third, double k = 1.0) {
    model::Model model{.fields = {scalar("X", "v"), scalar("v", "-(1 + e) X - 2 v"), scalar("f", third)},
                       .definitions = {},
                       .coefficients = {{"e", e}, {"k", k}}};
    model.fields[1].noise = model.fields[2].noise = 1.0;
    return model;
}

// 1e-9: the modes are e^(1/2) apart, and a rounding error of 1e-19 of the fast rate, 1e11 at most, is 1e-8 of theirs.
constexpr double tolerance = 1e-9;

TEST(NearlyEqualModes, beside_a_faster_field_have_the_fluctuations_that_they_have_alone) {
    for (const double k : {1.0, 1e9, 1e11, 1e15})
        for (const double e : {0.0, 1e-15, 1e-8, 1e-2}) {
            const Covariance found = found_at(oscillator(e, "-k f", k), 0.7);
            ASSERT_EQ(found.why_none, "") << k;
            EXPECT_NEAR(found.matrix(0, 0).real(), 0.25 / (1.0 + e), tolerance) << k << " " << e;
            EXPECT_NEAR(found.matrix(1, 1).real(), 0.25, tolerance) << k << " " << e;
            EXPECT_NEAR(found.matrix(2, 2).real() * k, 0.5, tolerance) << k;
        }
    for (const double k : {1e9, 1e11}) {  // coupled: what f adds is of the size 1/k
        const Covariance found = found_at(oscillator(0.0, "-k f + X", k), 0.7);
        ASSERT_EQ(found.why_none, "") << k;
        EXPECT_NEAR(found.matrix(0, 0).real(), 0.25, 1e-8) << k;
    }
}

TEST(NearlyEqualModes, at_every_wavenumber_and_beside_a_conserved_field_at_q_0_have_theirs) {
    for (const double q : {0.0, 100.0, 316.0, 317.0, 1e4}) {
        model::Model model = oscillator(0.0, "-lap lap f");
        model.fields[2].conserved = model.fields[2].noise_conserves = true;
        const Covariance found = found_at(model, q);
        ASSERT_EQ(found.why_none, "") << q;
        EXPECT_NEAR(found.matrix(0, 0).real(), 0.25, tolerance) << q;
        EXPECT_EQ(std::abs(found.matrix(2, 2)) == 0.0, q == 0.0);
        const Correlations spectrum =
            dynamic_structures(model::LinearisedAt(model::Equations(model), {0.0, 0.0, 0.0}), {q, 0.0}, {0.5});
        ASSERT_EQ(spectrum.why_none, "");  // |w^2 - 1 + 2 i w|^-2
        EXPECT_NEAR(spectrum.matrices.at(0)(0, 0).real(), 1.0 / (1.25 * 1.25), 1e-8) << q;
    }
}

TEST(NearlyEqualModes, do_not_depend_on_the_unit_of_a_field) {
    const auto of_a = [](double c) {
        model::Model model{.fields = {scalar("a", "-a + c b"), scalar("b", "-1.0001 b + d"), scalar("d", "-0.9999 d")},
                           .definitions = {},
                           .coefficients = {{"c", c}}};
        model.fields[1].noise = model.fields[2].noise = 1.0;
        const Covariance found = found_at(model, 0.7);
        EXPECT_EQ(found.why_none, "") << c;
        return found.matrix(0, 0).real() / (c * c);
    };
    const double exact = of_a(1.0);  // at one scale, where double precision suffices
    for (const double c : {1e-11, 1e5, 1e10, 1e11, 1e13}) EXPECT_NEAR(of_a(c), exact, tolerance * exact) << c;
}

TEST(NearlyEqualModes, beside_a_field_at_rest_have_the_fluctuations_and_spectra_that_they_have_alone) {
    for (const double e : {0.0, 1e-15, 1e-12, 1e-8}) {
        model::Model model = oscillator(e, "");
        model.fields[2].noise = 0.0;
        const Covariance found = found_at(model, 0.7);
        ASSERT_EQ(found.why_none, "") << e;
        EXPECT_NEAR(found.matrix(0, 0).real(), 0.25 / (1.0 + e), tolerance) << e;
        EXPECT_EQ(std::abs(found.matrix(2, 2)), 0.0);
        const model::LinearisedAt at(model::Equations(model), {0.0, 0.0, 0.0});
        const Correlations spectrum = dynamic_structures(at, {0.7, 0.0}, {0.5});
        ASSERT_EQ(spectrum.why_none, "") << e;  // |w^2 - 1 - e + 2 i w|^-2
        EXPECT_NEAR(spectrum.matrices.at(0)(0, 0).real(), 1.0 / (std::pow(0.75 + e, 2) + 1.0), tolerance) << e;
        EXPECT_EQ(std::abs(spectrum.matrices.at(0)(2, 2)), 0.0);
    }
    model::Model alone{.fields = {scalar("f", "")}};  // which nothing moves
    EXPECT_EQ(std::abs(found_at(alone, 0.7).matrix(0, 0)), 0.0);
    alone.fields[0].noise = 1.0;
    EXPECT_NE(found_at(alone, 0.7).why_none, "");
}

TEST(NearlyEqualModes, that_move_with_one_that_does_not_decay_are_refused_and_not_wrong) {
    model::Model model = oscillator(0.0, "");
    model.fields[1].equation = {.text = "-(1 + e) X - 2 v + f"};
    model.fields[2].noise = 0.0;
    const Covariance found = found_at(model, 0.7);
    if (found.why_none.empty()) EXPECT_NEAR(found.matrix(0, 0).real(), 0.25, tolerance);
    else EXPECT_NE(found.why_none.find("too nearly equal"), std::string::npos) << found.why_none;
}

TEST(NearlyEqualModes, that_no_noise_reaches_do_not_fluctuate_and_hide_no_others) {
    model::Model model{.fields = {scalar("a", "-a + 0.3 b + 0.4 c + 0.2 d"), scalar("b", "-1.1 b + 0.5 c + 0.3 d"),
                                  scalar("c", "-2.3 c - 0.7 b + 0.1 d"), scalar("d", "-1.7 d + 0.6 b - 0.4 c"),
                                  scalar("g", "")}};
    model.fields[0].noise = 1.0;
    const Covariance found = found_at(model, 0.5);
    ASSERT_EQ(found.why_none, "");
    EXPECT_NEAR(found.matrix(0, 0).real(), 0.5, 1e-14);
    EXPECT_EQ(found.matrix.bottomRightCorner(4, 4).norm(), 0.0);
}

TEST(ConservedMeans, beside_a_table_that_ends_are_seen_in_all_units) {
    for (const bool has_table : {false, true}) {
        model::Model model{.fields = {scalar("a", "1e14 b - a"), scalar("b", "-b"), scalar("c", "2e14 b - c"),
                                      scalar("n", has_table ? "1 - n sqrt((n - 0.5) (1.5 - n))" : "1 - n")}};
        model.fields[3].reference = 1.0;
        EXPECT_EQ(conserved_means(model::Equations(model)).rows(), 0) << has_table;
    }
}

TEST(ConservedMeans, of_a_field_that_reacts_beyond_a_threshold_are_none_for_any_reference) {
    for (const double reference : {0.0, 0.1, 1.0, 4.0}) {
        model::Model model{.fields = {scalar("u", "lap u + 0.1 max(u - 3, 0) (6 - u)")}};
        model.fields[0].reference = reference;
        model.fields[0].noise = 0.1;
        const model::Equations equations(model);
        EXPECT_EQ(conserved_means(equations).rows(), 0) << reference;
        const std::vector<StationaryState> states = stationary_states(equations).states;
        const bool has_upper = std::ranges::any_of(states, [](const StationaryState& state) {
            return std::abs(state.values[0] - 6.0) < 1e-9;
        });
        EXPECT_TRUE(has_upper) << reference;
        const Covariance found = covariance(model::LinearisedAt(equations, {6.0}), {});
        ASSERT_EQ(found.why_none, "") << reference;
        EXPECT_NEAR(found.matrix(0, 0).real(), 0.1 / (2.0 * 0.3), 1e-12);  // its slope there is -0.3
    }
}

}  // namespace
}  // namespace drover::theory::nearly_equal_tests
