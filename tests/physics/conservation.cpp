// tests/physics/conservation.cpp: the totals of rods and beads, from the fields on the grid, in every form.
#include <gtest/gtest.h>

#include "drover/numerics/transform.hpp"
#include "physics/rod_bead_model.hpp"
#include "solver_support.hpp"

namespace drover::physics::conservation_tests {
namespace {

constexpr numerics::Grid grid{12, 12, 8.0, 8.0};

/// Sums over the cells, as a reader of the archive would form them.
std::vector<double> totals(const Form& form, const numerics::Spectra& state, const numerics::Transform& transform) {
    numerics::Fields fields(grid, state.count());
    transform.backward(state, fields);
    std::vector<double> result;
    for (const int component : {form.bead_density, form.rod_density}) {
        if (component < 0) continue;
        double sum = 0.0;
        for (const double value : fields[component]) sum += value;
        result.push_back(sum);
    }
    return result;
}

void expect_conserved(int steps) {
    Threads threads(1);
    for (const NamedModel& form : all_forms()) {
        Model model = form.model;
        model.noise = {.order = 1e-3,
                       .rods = model.fields.rod_density ? 1e-4 : 0.0,
                       .beads = model.fields.bead_density ? 1e-4 : 0.0};
        const Equations e(model);
        const numerics::WholeRate whole = whole_rate(e, grid, mean_densities(model), threads);
        const numerics::Transform transform(grid, whole.system.degree, threads);
        const numerics::Spectra start = waves(physics::form(e.model), model.uniform, grid, 0.3);
        const std::vector<double> before = totals(physics::form(e.model), start, transform),
                                  after = totals(physics::form(e.model),
                                                 evolved(whole.system, "etdrk2", 0.02, steps, start), transform);
        for (std::size_t i = 0; i < before.size(); ++i)
            EXPECT_NEAR(after[i] / before[i], 1.0, 1e-12)
                << form.name;  // rounding of a sum over 144 cells; the mode q = 0 is exact
    }
}

TEST(Conservation, of_rods_and_beads_in_every_form_with_noise_over_2000_steps) { expect_conserved(2000); }

TEST(ConservationSlow, of_rods_and_beads_in_every_form_with_noise_over_100000_steps) { expect_conserved(100000); }

}  // namespace
}  // namespace drover::physics::conservation_tests
