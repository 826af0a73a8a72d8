// tests/model/field_evolution.cpp: the reference of the linear part that follows a scalar of any model.
#include "model/field_evolution.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "drover/numerics/transform.hpp"

namespace drover::model::field_evolution_tests {
namespace {

constexpr double pi = std::numbers::pi;

/// Beads of mass 2 n that a drag stops: n is pushed by nothing.
Model beads_with_drag(double drag) {
    Model model;
    model.fields = {{.name = "n", .symbol = "n", .equation = {"0.01 lap n", {}}, .conserved = true, .reference = 1.0},
                    {.name = "v", .symbol = "v", .mass = {"2 n", {}}, .equation = {"F - G v", {}}}};
    model.coefficients = {{"F", 1.5}, {"G", drag}};
    return model;
}

Model one_scalar(const std::string& equation, double reference) {
    Model model;
    model.fields = {{.name = "n", .symbol = "n", .equation = {equation, {}}, .reference = reference}};
    return model;
}

TEST(FollowedScalar, is_one_with_which_a_damping_grows_or_that_a_mass_is_made_of) {
    const auto found = [](const Model& model) { return followed_scalar(Equations(model), 10.0); };
    const auto mass = found(beads_with_drag(3.0));
    ASSERT_TRUE(mass);
    EXPECT_EQ(mass->component, 0);
    EXPECT_FALSE(mass->by_largest);
    EXPECT_EQ(mass->mass_field, 1u);
    const auto damping = found(one_scalar("div(n grad n)", 0.5));
    ASSERT_TRUE(damping);
    EXPECT_TRUE(damping->by_largest);
    EXPECT_FALSE(found(one_scalar("div(n grad n)", 0.0))) << "there is nothing to multiply";
    EXPECT_FALSE(found(one_scalar("lap n - n^3", 0.5))) << "at short waves the damping is that of the Laplacian";
    EXPECT_FALSE(found(one_scalar("lap n + 0.1 div(n grad n)", 0.5))) << "the exact part is stable as it is";
    EXPECT_FALSE(found(one_scalar("0.01 lap n - 4 n^2", 1.0))) << "a reaction is as fast in long waves";
    EXPECT_FALSE(found(one_scalar("-n/(1 + n)", 1.0))) << "a damping that falls is no mass";
    Model falling = beads_with_drag(3.0);
    falling.fields[1].equation = {"F - (20 - 12 n) v", {}};
    EXPECT_TRUE(found(falling)) << "a mass is followed whatever the drag is";
}

TEST(FollowedScalar, has_a_rung_within_the_limits_of_stability) {
    for (const bool by_largest : {false, true})
        for (int reference_level = -12; reference_level <= 12; ++reference_level)
            for (double part = 1.0 / 64.0; part <= 64.0; part *= 1.1) {
                const int next = followed_level(by_largest, part, reference_level);
                const double reference = std::exp2(0.5 * next);
                if (by_largest) EXPECT_GE(reference, part / 1.7 * (1.0 - 1e-12)) << part << " at " << reference_level;
                else EXPECT_LE(reference, part * 1.7 * (1.0 + 1e-12)) << part << " at " << reference_level;
                EXPECT_EQ(followed_level(by_largest, part, next), next) << "the same values ask for the same level";
            }
    // A checkpoint has levels up to 200.
    EXPECT_EQ(followed_level(false, 1e-300, 0), -200);
    EXPECT_EQ(followed_level(true, 1e300, 0), 200);
}

struct Ended {
    numerics::Fields fields;
    std::int64_t changes = 0;
};

/// n(x, 0) as given at points of a line, the other fields 0.
Ended run(const Model& model, const numerics::Grid& line, const std::function<double(double x)>& start, double dt,
          double end, const std::string& method = "etdrk4-krogstad") {
    Threads threads(1);
    FieldEvolution evolution({.equations = Equations(model)}, line,
                             {.method = method, .dt = dt, .tolerance = 0.0, .watches_error = false}, 1, threads);
    Ended result{.fields = numerics::Fields(line, numerics::components(evolution.linear().layout))};
    for (int i = 0; i < line.nx; ++i) result.fields[0][std::size_t(i)] = start(line.lx / line.nx * i);
    numerics::Transform transform(line, evolution.linear().degree, threads);
    numerics::Spectra state(line, result.fields.count());
    transform.forward(result.fields, state);
    evolution.start(state);
    for (std::int64_t step = 0; step < std::llround(end / dt); ++step) evolution.advance(step, state);
    transform.backward(state, result.fields);
    result.changes = evolution.reference_changes();
    return result;
}

TEST(FieldEvolution, follows_a_damping_that_grows_with_a_density) {
    // d_t n = div(n grad n): a peak of 40 times the reference, which damps 40 times as fast, spreads.  About the
    // reference alone steps of 4 ms, 9 times the stability limit of the remainder, 1/(n q^2), diverge.
    const numerics::Grid line{.nx = 96, .ny = 1, .lx = 12.0, .ly = 1.0};
    const auto start = [](double x) { return 0.2 + 8.0 * std::exp(-(x - 6.0) * (x - 6.0) / 2.0); };
    const Model model = one_scalar("div(n grad n)", 0.2);
    const Ended coarse = run(model, line, start, 4e-3, 0.4), fine = run(model, line, start, 1.25e-4, 0.4);
    EXPECT_GT(coarse.changes, 1);
    double worst = 0.0, mean = 0.0, mean_before = 0.0;
    for (int i = 0; i < line.nx; ++i) {
        const auto at = static_cast<std::size_t>(i);
        worst = std::max(worst, std::abs(coarse.fields[0][at] - fine.fields[0][at]));
        mean += coarse.fields[0][at];
        mean_before += start(line.lx / line.nx * i);
    }
    EXPECT_LT(worst, 0.02) << "of a peak of 4 that falls at 10 /s: second order in steps of stiff waves";
    EXPECT_NEAR(mean, mean_before, 1e-11 * mean_before) << "the linear part and its remainder conserve n";
}

TEST(FieldEvolution, follows_a_density_that_a_mass_is_made_of) {
    // Where n is small the drag rate G/(2 n) is large.  Without waves of v, 2 n d_t v = F - G v at every point, and
    // n hardly spreads: v = F/G (1 - exp(-G t/(2 n))).
    const numerics::Grid line{.nx = 64, .ny = 1, .lx = 64.0, .ly = 1.0};
    const auto start = [](double x) { return 1.0 - 0.85 * std::pow(std::cos(pi * (x - 32.0) / 64.0), 8.0); };
    const Ended ended = run(beads_with_drag(3.0), line, start, 0.02, 1.0);
    EXPECT_GT(ended.changes, 0);
    for (int i = 0; i < line.nx; ++i) {
        const double n = ended.fields[0][std::size_t(i)];
        // n changes by 1e-3 of itself in the run, and v by as much at most.
        EXPECT_NEAR(ended.fields[1][std::size_t(i)], 0.5 * -std::expm1(-3.0 / (2.0 * n)), 2e-3) << i;
    }
}

}  // namespace
}  // namespace drover::model::field_evolution_tests
