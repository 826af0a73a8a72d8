// tests/physics/terms.cpp: every term, in every form: its linearisation against the solver's own right-hand side.
#include <gtest/gtest.h>

#include <atomic>
#include <cmath>

#include "drover/base/random.hpp"
#include "drover/base/threads.hpp"
#include "full_model.hpp"
#include "modes.hpp"
#include "physics/integrated.hpp"
#include "physics/rod_bead_model.hpp"
#include "text_terms.hpp"

namespace drover::physics::terms_tests {
namespace {

using numerics::Complex;

constexpr numerics::Grid grid{20, 24, 7.0, 9.0};  // modes |k| < 4 are kept for products up to degree 4

/// Numbers between -1 and 1 that do not repeat.
class Numbers {
public:
    explicit Numbers(std::uint64_t seed) : values_(64) {
        fill_normal({.seed = seed, .stream = Stream::test}, 0, 1, values_);
    }
    double next() { return std::tanh(values_[at_++ % values_.size()]); }

private:
    std::vector<double> values_;
    std::size_t at_ = 0;
};

UniformPoint random_point(Numbers& numbers) {
    const auto vector = [&] { return Eigen::Vector2d(numbers.next(), numbers.next()); };
    return {.bead_density = 1.2 + 0.5 * numbers.next(),
            .rod_density = 0.8 + 0.4 * numbers.next(),
            .velocity = vector(),
            .order = vector()};
}

/// A slaved velocity in balance at the point: what the eliminated symbol is about.
void balance(const Equations& e, UniformPoint& point) {
    if (physics::form(e.model).velocity != Velocity::slaved) return;
    // Every force but drag is what it is without a velocity.
    point.velocity.setZero();
    const Eigen::Vector2d force = uniform_rates(e, point).segment<2>(FieldIndex::bead_velocity_x);
    const double gamma = e.coefficient("drag.coefficient").at({point.bead_density, point.rod_density});
    point.velocity = force / (gamma > 0.0 ? gamma : 1.0);
}

/// Largest difference between the symbol and a central difference of the right-hand side, relative to the largest
/// entry.
double difference(const Equations& e, UniformPoint point, const Densities& about, int kx, int ky, Threads& threads) {
    if (physics::form(e.model).bead_density < 0)
        point.bead_density = uniform_of(e.model).bead_density;  // not a field: the mass that moves is the scene's
    numerics::WholeRate rate = whole_rate(e, grid, about, threads);
    const std::size_t row = static_cast<std::size_t>((ky + grid.ny) % grid.ny),
                      mode = row * numerics::columns(grid) + static_cast<std::size_t>(kx);
    const numerics::Wavevector q = numerics::wavevector(grid, static_cast<std::size_t>(kx), row);
    const Symbol symbol = linear_symbol(e, point, q);
    const auto at = components(physics::form(e.model));
    // Of a small symbol, as of cubic terms at little order, the truncation shows: 2.5e-9 times third derivatives.
    double wrong = 0.0, largest = 1e-2;
    for (std::size_t column = 0; column < FieldIndex::count; ++column) {
        if (at[column] < 0) continue;
        constexpr double step = 5e-5;  // truncation step^2 = 2.5e-9, rounding 1e-16/step = 2e-12
        numerics::Spectra rates[2];
        for (int sign : {0, 1}) {
            numerics::Spectra state = uniform_state(physics::form(e.model), grid, point);
            state[at[column]][mode] += (sign == 0 ? 0.5 : -0.5) * step;
            if (kx == 0)
                state[at[column]][static_cast<std::size_t>(grid.ny - ky) * numerics::columns(grid)] =
                    state[at[column]][mode];
            rates[sign] = rate(0.0, state);
        }
        for (std::size_t line = 0; line < FieldIndex::count; ++line) {
            if (at[line] < 0) continue;
            const Complex found = (rates[0][at[line]][mode] - rates[1][at[line]][mode]) / step;
            const Complex expected = symbol(static_cast<int>(line), static_cast<int>(column));
            wrong = std::max(wrong, std::abs(found - expected));
            largest = std::max(largest, std::abs(expected));
        }
    }
    return wrong / largest;
}

std::vector<NamedModel> forms_and_table() {
    std::vector<NamedModel> forms = all_forms();
    forms.push_back(tabulated());
    // Every form with terms as text besides; functions without degree are cut off by the grid.
    for (const NamedModel& form : all_forms()) forms.push_back({form.name + ", with texts", with_texts(form.model)});
    return forms;
}

/// Returns the number of comparisons.
int compare_each_alone(int trials) {
    Threads threads(1);
    int checked = 0;
    for (const NamedModel& form : forms_and_table()) {
        const Equations all(form.model);
        for (const std::string& term : all.terms()) {
            // The terms of the model file are tested in the forms without texts.
            if (!all.model.text_terms.empty() && !term.starts_with("terms[")) continue;
            // A slaved velocity is the balance of all forces; a term by itself has none.
            const bool is_slaved = physics::form(all.model).velocity == Velocity::slaved;
            const Equations alone(is_slaved ? all.model : with_one_term(all.model, term));
            Numbers numbers(17 + static_cast<std::uint64_t>(checked));
            for (int trial = 0; trial < trials; ++trial) {
                UniformPoint point = random_point(numbers);
                balance(alone, point);
                const Densities about{1.1, 0.9};
                const int kx = trial % 4, ky = kx == 0 ? 1 + trial % 3 : (3 * trial) % 7 - 3;
                // 1e-6: the truncation of the difference is 1e-8 times third derivatives of order ten.
                EXPECT_LT(difference(alone, point, about, kx, ky, threads), 1e-6) << form.name << ": " << term;
                ++checked;
            }
        }
    }
    return checked;
}

TEST(Terms, each_alone_has_the_linearisation_of_its_own_action_at_random_uniform_states) {
    EXPECT_GT(compare_each_alone(4), 240);
}

TEST(TermsStatistics, each_alone_has_the_linearisation_of_its_own_action_at_fifty_random_uniform_states) {
    EXPECT_GT(compare_each_alone(50), 3000);
}

void compare_all_together(int trials) {
    Threads threads(1);
    for (const NamedModel& form : forms_and_table()) {
        const Equations all(form.model);
        for (int trial = 0; trial < trials; ++trial) {
            Numbers numbers(1000 + static_cast<std::uint64_t>(trial));
            UniformPoint point = random_point(numbers);
            balance(all, point);
            const Densities about{1.0 + 0.2 * numbers.next(), 0.8 + 0.2 * numbers.next()};
            const int kx = 1 + trial % 3, ky = trial % 7 - 3;
            EXPECT_LT(difference(all, point, about, kx, ky, threads), 1e-6) << form.name << ", trial " << trial;
        }
    }
}

TEST(Terms, all_together_have_the_linearisation_of_their_action_at_random_uniform_states) { compare_all_together(4); }

TEST(TermsStatistics, all_together_have_the_linearisation_of_their_action_at_fifty_random_uniform_states) {
    compare_all_together(50);
}

TEST(Terms, the_linear_part_about_the_reference_leaves_no_linear_remainder_there) {
    // N must be of second order: its own derivative at the reference state is zero.
    Threads threads(1);
    for (const NamedModel& form : all_forms()) {
        Model model = form.model;
        model.force.kind = "none";  // else beads at rest are no balance
        const Equations e(model);
        const Densities about{1.15, 0.85};
        numerics::WholeRate rate = whole_rate(e, grid, about, threads);
        const UniformPoint rest = at_rest(about);
        constexpr double step = 1e-5;
        numerics::Spectra state = uniform_state(physics::form(e.model), grid, rest), found(grid, state.count());
        for (int c = 0; c < state.count(); ++c)
            state[c][2 * numerics::columns(grid) + 1] += Complex(step, 0.3 * step * c);
        if (rate.system.nonlinear) rate.system.nonlinear(0.0, state, found);
        for (int c = 0; c < state.count(); ++c)
            // Second order, step^2, times coefficients of order one and wavenumbers up to 3; the uniform field h stays.
            EXPECT_LT(std::abs(found[c][2 * numerics::columns(grid) + 1]), 1e-8) << form.name << " component " << c;
    }
}

TEST(Terms, that_share_what_was_compiled_have_their_own_constants) {
    // Boundaries ask for many models that differ in a few numbers: equations that share with those of another model are
    // those that are compiled anew, to the rounding of a ratio of two numbers.
    std::vector<NamedModel> forms = all_forms();
    forms.push_back(tabulated());
    Model constants = full_model();
    constants.drag.coefficient_terms = constants.driving.strength_terms = constants.relaxation.rate_terms =
        constants.relaxation.saturation_terms = constants.weathercock.strength_terms = {};
    for (const std::string kind : {"order", "density-order"}) {
        constants.current.kind = kind;
        forms.push_back({"constants, " + kind, constants});
    }
    int checked = 0;
    for (const NamedModel& form : forms) {
        const Equations like(form.model);
        Numbers numbers(31);
        for (const CoefficientRow& row : shipped_model().coefficients) {
            ModelValues model = form.model;
            if (number(model, row.key()) == 0.0) continue;
            number_in(model, row.key()) *= 0.35;
            const Equations shared(model, like), compiled(model);
            const UniformPoint point = random_point(numbers);
            const numerics::Wavevector q{.x = 0.8, .y = -1.3};
            const Symbol expected = force_symbol(compiled, point, q);
            EXPECT_LT((force_symbol(shared, point, q) - expected).norm(), 1e-14 * expected.norm())
                << form.name << ": " << row.key();
            const auto rates = uniform_rates(compiled, point);
            EXPECT_LT((uniform_rates(shared, point) - rates).norm(), 1e-14 * rates.norm() + 1e-300)
                << form.name << ": " << row.key();
            EXPECT_EQ(shared.terms(), compiled.terms());
            ++checked;
        }
    }
    EXPECT_GT(checked, 100);
}

TEST(Terms, that_are_inactive_cost_no_transform) {
    Model model = full_model();
    model.advection.divergence = model.advection.gradient = model.driving.cubic = 0.0;
    model.current.kind = "order";
    model.inertia.advection = false;
    model.drag.coefficient_terms = model.driving.strength_terms = model.relaxation.rate_terms =
        model.relaxation.saturation_terms = model.weathercock.strength_terms = {};
    // rho, v, p, the force, curl p; rho v, d_t v, d_t p, p^2/2.
    EXPECT_EQ(transforms_of(integrated(model)).inverse, 8);
    EXPECT_EQ(transforms_of(integrated(model)).forward, 7);
    model.advection.strength = 0.0;
    EXPECT_EQ(transforms_of(integrated(model)).inverse, 7);
    EXPECT_EQ(transforms_of(integrated(model)).forward, 6);
    model.relaxation.saturation = 0.0;
    EXPECT_EQ(transforms_of(integrated(model)).inverse, 5);
    EXPECT_EQ(transforms_of(integrated(model)).forward, 4);
}

TEST(Terms, of_a_form_with_fewer_fields_cost_fewer_transforms) {
    const auto count = [](const Model& model) {
        const model::TransformCount c = transforms_of(integrated(model));
        return c.inverse + c.forward;
    };
    std::vector<NamedModel> forms = all_forms();
    EXPECT_LT(count(forms.at(6).model), count(forms.at(2).model)) << "polar < dilute";
    EXPECT_LT(count(forms.at(2).model), count(forms.at(0).model)) << "dilute < full";
}

TEST(Terms, symbols_are_those_of_their_state_while_other_threads_ask_about_other_states) {
    const Equations e(full_model());
    constexpr std::size_t states = 8, calls = 4000;
    const auto about = [](std::size_t n) {
        return UniformPoint{.bead_density = 1.0 + 0.1 * static_cast<double>(n % states), .rod_density = 0.7};
    };
    const numerics::Wavevector q{0.6, -0.9};
    std::vector<Symbol> expected;
    for (std::size_t n = 0; n < states; ++n) expected.push_back(force_symbol(e, about(n), q));
    std::atomic<int> wrong = 0;
    Threads(4).for_chunks(calls, 1, [&](std::size_t begin, std::size_t end) {
        for (std::size_t n = begin; n < end; ++n)
            if (force_symbol(e, about(n), q) != expected[n % states]) ++wrong;
    });
    EXPECT_EQ(wrong, 0);  // the same operations: equal to the bit
}

}  // namespace
}  // namespace drover::physics::terms_tests
