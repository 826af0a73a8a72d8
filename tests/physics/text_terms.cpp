// tests/physics/text_terms.cpp: models written as text against the same models of built-in terms.
#include "text_terms.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "drover/numerics/stepper.hpp"
#include "evolution.hpp"
#include "initial_spectra.hpp"
#include "linear_modes.hpp"
#include "physics/rod_bead_model.hpp"
#include "planes.hpp"
#include "symbols.hpp"

namespace drover::physics::text_terms_tests {
namespace {

/// Landau's equation of the order.
Model landau() {
    return {.fields = {.bead_density = false, .rod_density = false, .bead_velocity = "absent"},
            .relaxation = {.rate = -0.5, .saturation = 0.8}};
}
Model landau_as_text() {
    Model model = landau();
    model.relaxation = {.rate = 0.0};
    model.parameters = {{"a", -0.5}, {"b", 0.8}};
    model.text_terms = {
        text_term("order", {"-(a + b (order_x^2 + order_y^2)) order_x", "-(a + b (order_x^2 + order_y^2)) order_y"})};
    return model;
}

/// Burgers' equation in the plane.
Model burgers() {
    return {.fields = {.bead_density = false, .rod_density = false, .bead_velocity = "absent"},
            .relaxation = {.rate = 0.0},
            .elasticity = {.stiffness = 0.2, .splay = 0.1},
            .advection = {.strength = 0.9}};
}
Model burgers_as_text() {
    Model model = burgers();
    model.advection = {};
    model.elasticity = {};
    model.parameters = {{"w", 0.9}, {"K1", 0.1}, {"K3", 0.2}};
    model.text_terms = {
        text_term("order", {"-w (order_x d_x order_x + order_y d_y order_x) + K3 lap order_x + K1 grad_div_x order",
                            "-w (order_x d_x order_y + order_y d_y order_y) + K3 lap order_y + K1 grad_div_y order"})};
    return model;
}

/// All of models/band.toml.
Model band() {
    return {.uniform = {.rod_density = 49.0 / 48.0},
            .current = {.speed = 1.0},
            .relaxation = {.rate = 1.0, .rate_terms = {"-1 sigma"}, .saturation = 1.0},
            .elasticity = {.stiffness = 0.5, .splay = 0.5},
            .advection = {.strength = 1.0},
            .pressure = {.rods = 1.0}};
}
Model band_as_text() {
    Model model{.uniform = band().uniform, .relaxation = {.rate = 0.0}};
    model.parameters = {{"B", 1.0}, {"K", 0.5}, {"a", 1.0}, {"b", 1.0}, {"mu", 1.0}, {"u", 1.0}, {"w", 1.0}};
    const std::string decay = "-(a - mu rod_density + b (order_x^2 + order_y^2)) ";
    model.text_terms = {text_term("rod_density", {"-u div order"}),
                        text_term("order", {decay + "order_x", decay + "order_y"}),
                        text_term("order",
                                  {"K lap order_x + K grad_div_x order", "K lap order_y + K grad_div_y order"}),
                        text_term("order", {"-B d_x rod_density", "-B d_y rod_density"}),
                        text_term("order", {"-w order_x d_x order_x - w order_y d_y order_x",
                                            "-w order_x d_x order_y - w order_y d_y order_y"})};
    return model;
}

/// The largest difference of the fields after some steps, beside the size of the fields.
double difference(const Model& a, const Model& b, const numerics::Grid& grid, const std::vector<FieldFunction>& start,
                  double dt, int steps) {
    Evolution by_rows(a, grid), by_text(b, grid);
    EXPECT_EQ(by_rows.whole.system.degree, by_text.whole.system.degree) << "the same modes are kept";
    numerics::Spectra first = by_rows.spectra(start), second = by_text.spectra(start);
    by_rows.advance(first, "etdrk2", dt, steps);
    by_text.advance(second, "etdrk2", dt, steps);
    return largest_difference(by_rows.fields(first), by_text.fields(second));
}

FieldFunction wave(double mean, double amplitude, double phase) {
    return [=](double x, double y) {
        return mean + amplitude * (std::cos(0.5 * x + phase) + 0.6 * std::sin(0.5 * y - 0.25 * x + 2.0 * phase));
    };
}
constexpr double pi = 3.14159265358979323846;
constexpr numerics::Grid square{32, 32, 8.0 * pi, 8.0 * pi};

// The same linear parts and the same products, up to their rounding: 1e-12 of fields of order one.
TEST(TextTerms, give_landau_s_growth_as_the_built_in_terms_do) {
    EXPECT_LT(difference(landau(), landau_as_text(), square, {wave(0.1, 0.05, 0.2), wave(0.0, 0.08, 1.1)}, 0.1, 100),
              1e-12);
}

TEST(TextTerms, give_burgers_equation_as_the_built_in_terms_do) {
    EXPECT_LT(difference(burgers(), burgers_as_text(), square, {wave(0.1, 0.4, 0.2), wave(0.0, 0.3, 1.1)}, 0.05, 100),
              1e-12);
}

TEST(TextTerms, give_the_travelling_band_as_the_built_in_terms_do) {
    constexpr numerics::Grid grid{256, 8, 128.0, 4.0};
    const auto profile = [](double x) {
        return 1.0 / (1.0 + std::exp((x - 80.0) / std::sqrt(3.0))) +
               1.0 / (1.0 + std::exp(-(x - 32.0) / std::sqrt(12.0))) - 1.0;
    };
    const std::vector<FieldFunction> start{[&](double x, double) { return 5.0 / 6.0 + 0.5 * profile(x); },
                                           [&](double x, double) { return profile(x) / std::sqrt(3.0); },
                                           [](double x, double y) {
                                               return 1e-3 * std::cos(pi / 32.0 * x + pi / 2.0 * y);
                                           }};
    EXPECT_LT(difference(band(), band_as_text(), grid, start, 0.05, 200), 1e-12);
}

TEST(TextTerms, have_the_uniform_states_modes_and_structure_factors_of_the_built_in_terms) {
    Model rows = band(), texts = band_as_text();
    for (Model* model : {&rows, &texts}) {
        model->uniform.rod_density = 1.4;
        model->noise = {.order = 0.01, .rods = 0.002};
    }
    const Equations a(rows), b(texts);
    const StationaryStates by_rows = stationary_states(a), by_text = stationary_states(b);
    ASSERT_EQ(by_rows.states.size(), 2u);
    ASSERT_EQ(by_text.states.size(), 2u);
    for (std::size_t n = 0; n < 2; ++n) {
        EXPECT_LT((by_rows.states[n].point.order - by_text.states[n].point.order).norm(), 1e-12);
        EXPECT_EQ(by_rows.states[n].free_direction, by_text.states[n].free_direction);
    }
    const UniformPoint flock = by_rows.states[1].point;
    for (const numerics::Wavevector& q : {numerics::Wavevector{0.3, 0.0}, {0.0, 0.4}, {0.5, -0.7}}) {
        EXPECT_LT((linear_symbol(a, flock, q) - linear_symbol(b, flock, q)).norm(), 1e-12);
        EXPECT_LT((structure_matrix(a, flock, {3.0 * q.x, 3.0 * q.y}) -
                   structure_matrix(b, flock, {3.0 * q.x, 3.0 * q.y}))
                      .norm(),
                  1e-12);
        const numerics::Block rates = linear_system(a, square, {}).linear(std::hypot(q.x, q.y)).even,
                              rates_by_text = linear_system(b, square, {}).linear(std::hypot(q.x, q.y)).even;
        for (int i = 0; i < rates.size; ++i)
            for (int k = 0; k < rates.size; ++k) EXPECT_NEAR(rates(i, k), rates_by_text(i, k), 1e-12);
    }
    const EffectiveCoefficients of_rows = effective_coefficients(a, 1.0, 1.4),
                                of_text = effective_coefficients(b, 1.0, 1.4);
    for (const auto member : {&EffectiveCoefficients::relaxation, &EffectiveCoefficients::relaxation_by_rods,
                              &EffectiveCoefficients::pressure_rods, &EffectiveCoefficients::stiffness_across,
                              &EffectiveCoefficients::stiffness_along, &EffectiveCoefficients::sound_stiffness})
        EXPECT_NEAR(of_rows.*member, of_text.*member, 1e-12);
}

TEST(TextTerms, have_the_phase_boundaries_of_the_built_in_terms) {
    const auto margins_of = [&](const Model& model, auto set) {
        Plane plane{.model = model,
                    .x = {.name = "sigma",
                          .unit = "",
                          .from = 0.5,
                          .to = 2.0,
                          .set = [](Model& m, double value) { m.uniform.rod_density = value; }},
                    .y = {.name = "b", .unit = "", .from = 0.5, .to = 2.0, .set = set}};
        std::vector<double> values;
        for (const Limit limit : {Limit::onset, Limit::banding, Limit::oblique})
            for (const Margin& margin : margins(plane, {{0.7, 0.8}, {1.3, 1.1}, {1.9, 1.7}}, limit))
                values.push_back(margin.value);
        return values;
    };
    const std::vector<double> by_rows = margins_of(band(), [](Model&m, double b) { m.relaxation.saturation = b; }),
                              by_text = margins_of(band_as_text(), [](Model&m, double b) { m.parameters["b"] = b; });
    for (std::size_t i = 0; i < by_rows.size(); ++i) {
        if (std::isnan(by_rows[i])) EXPECT_TRUE(std::isnan(by_text[i]));
        else EXPECT_NEAR(by_rows[i], by_text[i], 1e-12 * (1.0 + std::abs(by_rows[i]))) << i;
    }
}

TEST(TextTerms, that_depend_on_position_or_time_run_but_have_no_uniform_state) {
    Model model = landau();
    model.relaxation = {.rate = 0.3};
    model.parameters = {{"h", 0.2}};
    model.text_terms = {text_term("order", {"h cos(0.25 x) + 0.1 t", "0"})};
    const numerics::Grid grid{16, 16, 8.0 * pi, 8.0 * pi};
    Evolution evolution(model, grid);
    numerics::Spectra state = evolution.spectra({wave(0.0, 0.0, 0.0), wave(0.0, 0.0, 0.0)});
    evolution.advance(state, "etdrk4", 0.05, 40);
    // p = h cos(x/4) (1 - e^{-a t})/a + 0.1 (t/a - (1 - e^{-a t})/a^2), at t = 2; ETDRK4 integrates a source that is
    // linear in time exactly.
    const double a = 0.3, t = 2.0, grown = (1.0 - std::exp(-a * t)) / a;
    const numerics::Fields fields = evolution.fields(state);
    for (std::size_t i = 0; i < fields.size; ++i)
        EXPECT_NEAR(fields[0][i], 0.2 * std::cos(0.25 * evolution.x(i)) * grown + 0.1 * (t - grown) / a, 1e-12);
    EXPECT_THROW(linear_symbol(Equations(model), {}, {}), Error);
    EXPECT_TRUE(stationary_states(Equations(model)).states.empty());
}

/// What a text is rejected with, as an error at the column of its slip.
std::string rejection(const TextTerm& term, const Model& model = landau()) {
    try {
        Model with = model;
        with.text_terms = {term};
        static_cast<void>(Equations(with));
    } catch (const Error& error) {
        return error.what();
    }
    return "accepted";
}

TEST(TextTerms, that_do_not_fit_the_model_are_rejected_with_a_remedy) {
    using testing::HasSubstr;
    EXPECT_THAT(rejection(text_term("orde", {"1", "0"})), HasSubstr("expected one of bead_density"));
    EXPECT_THAT(rejection(text_term("order", {"order_x"})), HasSubstr("two, the x and y components"));
    EXPECT_THAT(rejection(text_term("rod_density", {"1"})), HasSubstr("this model excludes"));
    EXPECT_THAT(rejection(text_term("order", {"rod_density", "0"})), HasSubstr("rod_density"));
    EXPECT_THAT(rejection(text_term("order", {}, {"1", "1"})), HasSubstr("only a density has a flux"));
    EXPECT_THAT(rejection(text_term("rod_density", {"order_x"}), band()), HasSubstr("use a flux"));
    Model slaved{.fields = {.bead_density = false, .rod_density = true, .bead_velocity = "slaved"},
                 .drag = {.coefficient = 1.0}};
    EXPECT_THAT(rejection(text_term("bead_velocity", {"-bead_velocity_x", "0"}), slaved), HasSubstr("dynamic"));
    slaved.viscosity.shear = 1.0;
    EXPECT_THAT(rejection(text_term("bead_velocity", {"order_x^2", "0"}), slaved), HasSubstr("viscosity"));
}

TEST(TextTerms, of_a_density_conserve_its_number) {
    Model model = with_texts(
        {.current = {.speed = 0.5}, .relaxation = {.rate = 0.4, .saturation = 1.0}, .elasticity = {.stiffness = 0.3}});
    Evolution evolution(model, square);
    numerics::Spectra state = evolution.spectra({wave(1.0, 0.1, 0.3), wave(0.1, 0.05, 0.2), wave(0.0, 0.08, 1.1)});
    const double before = state[0][0].real();
    evolution.advance(state, "etdrk2", 0.05, 40);
    EXPECT_NEAR(state[0][0].real(), before, 1e-13);
}

}  // namespace
}  // namespace drover::physics::text_terms_tests
