// tests/physics/convergence.cpp: the order of every method on the full equations, small amplitudes, and the energy
// budget.
#include <gtest/gtest.h>

#include "model/energy.hpp"
#include "physics/rod_bead_model.hpp"
#include "solver_support.hpp"

namespace drover::physics::convergence_tests {
namespace {

constexpr numerics::Grid grid{16, 16, 8.0, 8.0};

TEST(Order, of_every_method_on_the_full_equations_with_varying_density_is_what_it_claims) {
    Threads threads(1);
    const Model model = undisturbed(full_model());
    const numerics::WholeRate whole = whole_rate(Equations(model), grid, mean_densities(model), threads);
    const numerics::Spectra start = waves(physics::form(model), model.uniform, grid, 0.8);
    const double time = 1.6;
    const numerics::Spectra exact = evolved(whole.system, "etdrk4-krogstad", time / 2048, 2048, start);
    for (const numerics::StepperTable& table : numerics::stepper_tables()) {
        std::vector<double> errors;
        // Multistep methods approach their order from below, where a step is short beside the time of their history.
        const int coarsest = table.history > 0 ? 64 : 8;
        const double margin = table.history > 0 ? 0.5 : 0.1;
        for (int steps = coarsest; steps <= 8 * coarsest || steps <= 128; steps *= 2)
            errors.push_back(distance(evolved(whole.system, table.name, time / steps, steps, start), exact));
        for (std::size_t i = 0; i + 1 < errors.size(); ++i) {
            if (errors[i + 1] < 1e-13) continue;  // rounding of a thousand steps
            EXPECT_GT(std::log2(errors[i] / errors[i + 1]), table.order - margin)
                << table.name << ", halving " << i + 1 << ": " << errors[i] << " to " << errors[i + 1];
        }
    }
}

/// Deviation from the linear theory after one unit of time, by the same method with the same step: linear terms are
/// exact.
double deviation(const Equations& e, double amplitude) {
    Threads threads(1);
    const numerics::WholeRate whole = whole_rate(e, grid, mean_densities(e.model), threads);
    numerics::System linear = whole.system;
    linear.nonlinear = {};
    const numerics::Spectra start = waves(physics::form(e.model), uniform_of(e.model), grid, amplitude);
    return distance(evolved(whole.system, "etdrk2", 0.1, 10, start), evolved(linear, "etdrk2", 0.1, 10, start));
}

TEST(SmallAmplitude, leaves_a_deviation_from_linear_theory_that_falls_as_its_square_or_faster_for_every_term_and_form) {
    int checked = 0;
    for (const NamedModel& form : all_forms()) {
        const Equations all(undisturbed(form.model));
        std::vector<std::pair<std::string, Equations>> cases{{"all terms", all}};
        for (std::size_t n = 0; n < all.terms().size(); ++n)
            if (!all.right_sides().terms()[n].is_linear && physics::form(all.model).velocity != Velocity::slaved)
                cases.emplace_back(all.terms()[n], with_one_term(all.model, all.terms()[n]));
        for (const auto& [name, e] : cases) {
            const double whole = deviation(e, 2e-3), half = deviation(e, 1e-3);
            ASSERT_GT(half, 0.0) << form.name << ": " << name;
            // Products of two waves: 4, with a part of third order of relative size 1e-3; of three (saturation alone):
            // 8.
            const double ratio = whole / half;
            EXPECT_GT(ratio, 3.96) << form.name << ": " << name;
            EXPECT_LT(ratio, 8.1) << form.name << ": " << name;
            ++checked;
        }
    }
    EXPECT_GT(checked, 25);
}

/// |E(t) - E(0) - integral of the powers|, the largest of any energy.  The integral by Simpson.
double budget_gap(const Equations& e, const std::string& method, int steps) {
    Threads threads(1);
    const numerics::WholeRate whole = whole_rate(e, grid, mean_densities(e.model), threads);
    const model::EnergyMeter meter(e.solver(mean_densities(e.model)), grid, whole.system.degree, threads);
    numerics::Spectra state = waves(physics::form(e.model), uniform_of(e.model), grid, 0.5);
    const double dt = 0.8 / steps;
    numerics::Stepper stepper(whole.system, numerics::stepper_table(method), dt, 1, threads);
    const model::EnergyBudget first = meter.measure(0.0, state);
    std::vector<double> gaps = first.energies;
    for (int i = 0; i <= steps; ++i) {
        const model::EnergyBudget now = meter.measure(i * dt, state);
        const double weight = dt / 3.0 * (i == 0 || i == steps ? 1.0 : i % 2 == 1 ? 4.0 : 2.0);
        for (std::size_t n = 0; n < gaps.size(); ++n) {
            for (const double power : now.powers[n]) gaps[n] += weight * power;
            if (i == steps) gaps[n] = std::abs(gaps[n] - now.energies[n]);
        }
        if (i < steps) stepper.step(i * dt, static_cast<std::uint64_t>(i), state);
    }
    return *std::max_element(gaps.begin(), gaps.end());
}

TEST(EnergyBudget, closes_term_by_term_at_the_order_of_the_method_in_every_form) {
    for (const NamedModel& form : all_forms()) {
        const Equations e(form.model);
        for (const auto& [method, order] : {std::pair{"etdrk2", 2.0}, {"etdrk4", 4.0}}) {
            const double coarse = budget_gap(e, method, 32), fine = budget_gap(e, method, 64);
            // Simpson's rule is of fourth order too; below 1e-12 stand the roundings of energies of order ten.
            if (coarse > 1e-11) {
                EXPECT_GT(std::log2(coarse / fine), order - 0.15)
                    << form.name << ", " << method << ": " << coarse << ", " << fine;
            }
            EXPECT_LT(fine, order == 2.0 ? 1e-2 : 1e-5) << form.name << ", " << method;
        }
    }
}

}  // namespace
}  // namespace drover::physics::convergence_tests
