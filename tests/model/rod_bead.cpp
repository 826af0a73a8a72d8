// tests/model/rod_bead.cpp: the rod-bead equations as text beside the built-in terms.
#include "model/rod_bead.hpp"

#include <gtest/gtest.h>

#include <random>

#include "drover/numerics/linear_operator.hpp"
#include "drover/physics/evaluation_cost.hpp"
#include "physics/full_model.hpp"

namespace drover::model {
namespace {

using numerics::Spectra;
constexpr numerics::Grid grid{.nx = 24, .ny = 20, .lx = 9.0, .ly = 7.0};

/// Random waves about the uniform state, of few modes: products of any degree here are free of aliases on the grid.
Spectra random_state(const physics::Model& m, int components) {
    std::mt19937 random(7);
    std::normal_distribution<double> normal;
    Spectra state(grid, components);
    const std::size_t width = numerics::columns(grid);
    for (int c = 0; c < components; ++c)
        for (const std::size_t mode : {std::size_t{1}, width + 1, width * 19 + 1, std::size_t{0}})
            state[c][mode] = 0.05 * numerics::Complex(normal(random), mode == 0 ? 0.0 : normal(random));
    const physics::Form form = physics::form(m);
    if (form.bead_density >= 0) state[form.bead_density][0] = m.uniform.bead_density;
    if (form.rod_density >= 0) state[form.rod_density][0] = m.uniform.rod_density;
    return state;
}

TEST(RodBeadText, has_the_rates_of_the_built_in_terms_in_every_form) {
    Threads threads(1);
    for (const auto& [name, built_in] : physics::all_forms()) {
        const physics::Equations terms(built_in);
        const physics::WholeRate whole(terms, grid, physics::reference(built_in.uniform), threads);
        const Equations equations(rod_bead(built_in));
        numerics::System system = equations.system(grid, threads);
        const int degree = std::max(system.degree, whole.system.degree);  // of modes that both keep
        const Spectra state = random_state(built_in, numerics::components(system.layout));
        const Spectra expected = whole(0.0, state);
        Spectra found(grid, state.count());
        system.nonlinear(0.0, state, found);
        numerics::LinearOperator(system).add(state, found);
        for (int c = 0; c < state.count(); ++c) {
            double size = 0.0, difference = 0.0;
            for (std::size_t m = 0; m < state.size; ++m) {
                const std::size_t width = numerics::columns(grid);
                if (!numerics::is_kept(grid, degree, m % width, m / width)) continue;
                size = std::max(size, std::abs(expected[c][m]));
                difference = std::max(difference, std::abs(expected[c][m] - found[c][m]));
            }
            EXPECT_LT(difference, 1e-13 * std::max(size, 1.0))
                << name << ", component " << c;  // rounding of some 30 terms
        }
    }
}

TEST(RodBeadText, has_the_symbol_of_the_built_in_terms_about_any_uniform_state) {
    for (const auto& [name, built_in] : physics::all_forms()) {
        const physics::Equations terms(built_in);
        const Equations equations(rod_bead(built_in));
        physics::UniformPoint about{.bead_density = built_in.fields.bead_density ? 1.1 : built_in.uniform.bead_density,
                                    .rod_density = 0.9,
                                    .velocity = {0.3, -0.2},
                                    .order = {0.5, 0.4}};
        const bool moves = built_in.fields.bead_velocity != "absent";
        if (built_in.fields.bead_velocity == "slaved") {  // in balance: the text has no other velocity
            about.velocity.setZero();
            const physics::UniformRates forces = physics::uniform_rates(terms, about);
            about.velocity = forces.segment<2>(physics::FieldIndex::bead_velocity_x) /
                             terms.drag.at(about.bead_density, about.rod_density).value;
        }
        UniformState state;
        std::vector<int> rows;
        const auto add = [&](bool is_there, int row, double value) {
            if (!is_there) return;
            state.push_back(value);
            rows.push_back(row);
        };
        add(built_in.fields.bead_density, physics::FieldIndex::bead_density, about.bead_density);
        add(built_in.fields.rod_density, physics::FieldIndex::rod_density, about.rod_density);
        for (int i = 0; i < 2; ++i) add(moves, physics::FieldIndex::bead_velocity_x + i, about.velocity(i));
        for (int i = 0; i < 2; ++i) add(true, physics::FieldIndex::polar_order_x + i, about.order(i));
        // A dynamic velocity whose forces do not balance adds -F/(m rho) drho/rho; the built-in symbol leaves it out.
        const bool is_balanced = built_in.fields.bead_velocity != "dynamic" || !built_in.fields.bead_density;
        for (const numerics::Wavevector q : {numerics::Wavevector{0.0, 0.0}, {0.6, 0.0}, {-0.4, 0.7}, {0.1, 1.9}}) {
            const Symbol found = equations.symbol(state, q);
            const physics::Symbol expected = physics::linear_symbol(terms, about, q);
            double difference = 0.0;
            for (std::size_t i = 0; i < rows.size(); ++i)
                for (std::size_t j = 0; j < rows.size(); ++j)
                    if (is_balanced || rows[j] != physics::FieldIndex::bead_density)
                        difference = std::max(difference, std::abs(found(static_cast<int>(i), static_cast<int>(j)) -
                                                                   expected(rows[i], rows[j])));
            EXPECT_LT(difference, 1e-13 * (1.0 + expected.cwiseAbs().maxCoeff())) << name;  // rounding
        }
    }
}

TEST(RodBeadText, takes_no_more_transforms_than_the_built_in_terms) {
    for (const auto& [name, built_in] : physics::all_forms()) {
        const physics::TransformCount cost = physics::transform_count(physics::Equations(built_in));
        const TransformCount found = Equations(rod_bead(built_in)).transforms();
        EXPECT_LE(found.inverse + found.forward, cost.inverse + cost.forward)
            << name << ": " << found.inverse << " inverse, " << found.forward << " forward";
    }
}

}  // namespace
}  // namespace drover::model
