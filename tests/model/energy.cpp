// tests/model/energy.cpp: energies of any model change by the sum of their powers.
#include "model/energy.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <numeric>
#include <random>

#include "base/refusal.hpp"
#include "drover/numerics/stepper.hpp"

namespace drover::model::energy_tests {
namespace {

using numerics::Complex;
using numerics::Spectra;

constexpr numerics::Grid grid{.nx = 24, .ny = 20, .lx = 9.0, .ly = 7.0};

struct Named {
    const char* name;
    Model model;
};

/// 1 + exp(u): a function of the calling program.
GivenFunction exponential() {
    return {.has_finite_degree = false,
            .values =
                [](std::size_t size, std::span<const PointArgument> given, std::span<double* const> out) {
                    for (std::size_t i = 0; i < size; ++i)
                        out[0][i] = 1.0 + std::exp(given[0].values != nullptr ? given[0].values[i] : given[0].number);
                },
            .slopes = [](std::span<const double> at) { return std::vector<double>{std::exp(at[0])}; }};
}

/// A pattern, Burgers' equation, a compressible fluid, masses that depend on other fields and their derivatives, on
/// position and on a function, balances of each kind, and a solenoidal flow.
std::vector<Named> models() {
    const Field density{
        .name = "rho", .symbol = "rho", .equation = {"-div(rho v) + 0.1 lap rho"}, .conserved = true, .reference = 2.0};
    const Field flow{.name = "v",
                     .symbol = "v",
                     .spin = 1,
                     .mass = {"m rho"},
                     .equation = {"-m rho v.grad v - grad rho + 0.3 lap v - 0.2 v + rho e_x"}};
    Field curved = flow, placed = flow, given = flow;
    curved.mass = {"1 + 0.1 (lap rho)^2 + 0.2 |grad rho|^2"};
    curved.equation = placed.equation = given.equation = {"-grad rho + 0.3 lap v"};
    placed.mass = {"rho (2 + cos(2 pi x / 9))"};
    given.mass = {"grown(0.1 rho)"};
    const Field carried{.name = "c", .symbol = "c", .equation = {"-div(c v) + 0.2 lap c"}, .reference = 1.0};
    Field pointwise = flow, by_waves = flow, still = flow;
    pointwise.mass = by_waves.mass = {};
    pointwise.left = by_waves.left = LeftSide::balance;
    pointwise.equation = {"-(1 + 0.1 c^2) v - 0.2 grad c + 0.1 e_x"};
    by_waves.equation = {"-v + lap v - c grad c"};
    still.mass = {"3"};
    still.solenoidal = true;
    still.equation = {"-v.grad v + 0.1 lap v + c e_y"};
    const Field pattern{.name = "u", .symbol = "u", .equation = {"-0.7 u - 2 lap u - lap lap u + u^2 - u^3"}};
    return {{"pattern", {.fields = {pattern}}},
            {"Burgers", {.fields = {{.name = "u", .symbol = "u", .equation = {"-u d_x u + 0.2 lap u"}}}}},
            {"fluid", {.fields = {density, flow}, .coefficients = {{"m", 0.7}}}},
            {"curved mass", {.fields = {density, curved}}},
            {"placed mass", {.fields = {density, placed}}},
            {"given mass", {.fields = {density, given}, .functions = {{"grown", exponential()}}}},
            {"balance of points", {.fields = {carried, pointwise}}},
            {"balance of waves", {.fields = {carried, by_waves}}},
            {"solenoidal", {.fields = {carried, still}}}};
}

/// Long waves about the references, divergence-free where a field is so.
Spectra waves(const Equations& equations, unsigned seed) {
    std::mt19937 random(seed);
    std::normal_distribution<double> normal;
    const std::vector<int>& components = equations.state_components();
    Spectra state(grid, static_cast<int>(components.size()));
    const std::size_t width = numerics::columns(grid);
    for (int c = 0; c < state.count(); ++c) {
        state[c][0] = equations.reference()[static_cast<std::size_t>(components[static_cast<std::size_t>(c)])];
        state[c][1] = 0.1 * Complex(normal(random), normal(random));
        state[c][width + 2] = 0.1 * Complex(normal(random), normal(random));
    }
    for (std::size_t n = 0, first = 0; n < equations.model().fields.size(); ++n) {
        const Field& field = equations.model().fields[n];
        if (field.left != LeftSide::rate) continue;
        for (const std::size_t m : {std::size_t{1}, width + 2}) {
            if (!field.solenoidal) continue;
            const numerics::Wavevector q = numerics::wavevector(grid, m % width, m / width);
            const int x = static_cast<int>(first);
            const Complex along = (q.x * state[x][m] + q.y * state[x + 1][m]) / (q.x * q.x + q.y * q.y);
            state[x][m] -= q.x * along;
            state[x + 1][m] -= q.y * along;
        }
        first += static_cast<std::size_t>(model::components(field));
    }
    return state;
}

double sum(const std::vector<double>& values) { return std::accumulate(values.begin(), values.end(), 0.0); }

TEST(ModelEnergy, changes_by_the_sum_of_the_powers_of_the_terms) {
    Threads threads(1);
    constexpr double h = 1e-3;  // its fourth power times the fifth derivative of an energy is below 1e-9 of the powers
    for (const Named& one : models()) {
        const Equations equations(one.model);
        const numerics::System system = equations.system(grid, threads);
        const EnergyMeter meter(equations, grid, system.degree, threads);
        Spectra state = waves(equations, 4);
        numerics::Stepper stepper(system, numerics::stepper_table("etdrk4-krogstad"), h, 1, threads);
        std::vector<EnergyBudget> budgets;
        for (int i = 0; i < 5; ++i) {
            budgets.push_back(meter.measure(i * h, state));
            stepper.step(i * h, static_cast<std::uint64_t>(i), state);
        }
        ASSERT_EQ(budgets[0].energies.size(), energies_of(equations).size());
        for (std::size_t n = 0; n < budgets[0].energies.size(); ++n) {
            const auto energy = [&](std::size_t i) { return budgets[i].energies[n]; };
            const double slope = (energy(0) - 8.0 * energy(1) + 8.0 * energy(3) - energy(4)) / (12.0 * h);
            double size = 0.0;
            for (const double power : budgets[2].powers[n]) size += std::abs(power);
            EXPECT_EQ(budgets[2].powers[n].size(), terms_with_power(equations).size());
            EXPECT_GT(size, 1e-3) << one.name;
            EXPECT_NEAR(sum(budgets[2].powers[n]), slope, 1e-8 * size) << one.name << ", " << n;
        }
    }
}

/// Of one wave A cos(q x) of a field that diffuses and decays.
TEST(ModelEnergy, of_a_wave_is_dissipated_at_twice_the_rate_of_its_decay) {
    Threads threads(1);
    const Equations equations({.fields = {{.name = "c", .symbol = "c", .equation = {"D lap c - a c + a sin(c)"}}},
                               .coefficients = {{"D", 0.3}, {"a", 0.2}}});
    Spectra state(grid, 1);
    const double amplitude = 0.4, q = 2.0 * std::numbers::pi / 9.0;
    state[0][1] = 0.5 * amplitude;
    const EnergyBudget budget = EnergyMeter(equations, grid, 2, threads).measure(0.0, state);
    const double energy = 0.25 * amplitude * amplitude * 63.0;
    EXPECT_NEAR(budget.energies.at(0), energy, 1e-13);
    EXPECT_NEAR(budget.powers.at(0).at(0), -2.0 * 0.3 * q * q * energy, 1e-13);
    EXPECT_NEAR(budget.powers.at(0).at(1), -2.0 * 0.2 * energy, 1e-13);
    // The average of A cos sin(A cos) is A J_1(A).
    EXPECT_NEAR(budget.powers.at(0).at(2), 0.2 * amplitude * std::cyl_bessel_j(1.0, amplitude) * 63.0, 1e-13);
}

TEST(ModelEnergy, of_a_flow_has_the_power_of_its_forces_and_of_the_current_that_carries_its_mass) {
    Threads threads(1);
    const Equations equations(
        {.fields = {{.name = "rho", .symbol = "rho", .equation = {"b rho"}, .reference = 2.0},
                    {.name = "v", .symbol = "v", .spin = 1, .mass = {"m rho"}, .equation = {"-g v + m rho v"}}},
         .coefficients = {{"m", 0.7}, {"g", 0.2}, {"b", 0.3}}});
    Spectra state(grid, 3);
    state[0][0] = 2.0;
    state[1][0] = 0.5;
    state[2][0] = -1.0;
    const EnergyBudget budget = EnergyMeter(equations, grid, 2, threads).measure(0.0, state);
    const double square = 1.25, energy = 0.5 * 0.7 * 2.0 * square * 63.0;
    EXPECT_NEAR(budget.energies.at(0), 0.5 * 4.0 * 63.0, 1e-12);
    EXPECT_NEAR(budget.energies.at(1), energy, 1e-12);
    EXPECT_NEAR(budget.powers.at(0).at(0), 0.3 * 4.0 * 63.0, 1e-12);
    EXPECT_NEAR(budget.powers.at(1).at(0), 0.3 * energy, 1e-12) << "the mass grows";
    EXPECT_NEAR(budget.powers.at(1).at(1), -0.2 * square * 63.0, 1e-12);
    EXPECT_NEAR(budget.powers.at(1).at(2), 2.0 * energy, 1e-12);
}

TEST(ModelEnergy, is_named_by_its_field_or_as_that_says_and_belongs_to_both_parts_of_a_complex_field) {
    Field named{.name = "velocity", .symbol = "v", .spin = 1, .equation = {"-v"}, .observed = {.energy = "flow"}};
    named.observed.drawn = 1;
    const Equations equations(
        {.fields = {{.name = "psi_re", .symbol = "A_re", .equation = {"-A"}, .part = Part::real},
                    {.name = "psi_im", .symbol = "A_im", .equation = {"-A"}, .part = Part::imaginary},
                    {.name = "s", .symbol = "s", .equation = {"-s"}, .observed = {.energy = "none"}},
                    named,
                    {.name = "b", .symbol = "b", .left = LeftSide::balance, .equation = {"s - b"}}},
         .definitions = {{"A", {"A_re + i A_im"}}},
         .coefficients = {},
         .functions = {{"re", {}}, {"im", {}}, {"conj", {}}}});
    const std::vector<Energy> energies = energies_of(equations);
    ASSERT_EQ(energies.size(), 2);
    EXPECT_EQ(energies[0].name, "psi");
    EXPECT_EQ(energies[0].fields, (std::vector<std::size_t>{0, 1}));
    EXPECT_EQ(energies[1].name, "flow");
    EXPECT_EQ(energies[1].fields, (std::vector<std::size_t>{3}));
}

TEST(ModelEnergy, refuses_a_mass_that_depends_on_time_or_on_a_field_without_a_rate) {
    Threads threads(1);
    const auto measured = [&](const char* mass) {
        return refusal_of([&] {
            const Equations equations(
                {.fields = {{.name = "u", .symbol = "u", .mass = {mass}, .equation = {"-u"}},
                            {.name = "b", .symbol = "b", .left = LeftSide::balance, .equation = {"u - b + lap b"}}},
                 .coefficients = {}});
            EnergyMeter(equations, grid, 2, threads);
        });
    };
    EXPECT_NE(measured("2 + sin(t)").find("depends on time"), std::string::npos);
    EXPECT_NE(measured("2 + b^2").find("depends on b, which has no rate"), std::string::npos);
}

}  // namespace
}  // namespace drover::model::energy_tests
