// tests/physics/sundials.cpp: the methods of SUNDIALS on the full equations, beside the exponential ones.
#include <gtest/gtest.h>

#include "numerics/steppers/time_method.hpp"
#include "physics/integrated.hpp"
#include "physics/rod_bead_model.hpp"
#include "solver_support.hpp"

namespace drover::physics::sundials_tests {
namespace {

constexpr numerics::Grid grid{16, 16, 8.0, 8.0};

/// A run by FieldEvolution, whose reference density may change.
struct Case {
    Model model;
    double dt = 0.1, end = 0.8;
    numerics::Spectra start;

    numerics::Spectra by(const std::string& method, double tolerance, int parts = 1, int thread_count = 1) const {
        Threads threads(thread_count);
        model::FieldEvolution evolution(integrated(model), grid,
                                        {.method = method, .dt = dt / parts, .tolerance = tolerance}, 1, threads);
        numerics::Spectra state = start;
        evolution.start(state);
        const auto steps = static_cast<std::int64_t>(std::lround(end * parts / dt));
        for (std::int64_t step = 0; step < steps; ++step) evolution.advance(step, state);
        return state;
    }
};

Case run_of(const Model& model, double amplitude) {
    return {.model = model, .start = waves(physics::form(model), model.uniform, grid, amplitude)};
}

/// Methods of SUNDIALS at a tolerance of 1e-11 agree with ETDRK4 at a step that errs by less.
void expect_agreement(const Case& run, int parts, double within) {
    const numerics::Spectra exact = run.by("etdrk4-krogstad", 0.0, 2 * parts);
    EXPECT_LT(distance(run.by("etdrk4-krogstad", 0.0, parts), exact), within) << "the reference";
    for (const std::string method : {"cvode-bdf", "cvode-adams", "arkode-ark437l2sa", "arkode-ark548l2sa"})
        EXPECT_LT(distance(run.by(method, 1e-11), exact), within) << method;
}

TEST(Sundials, agrees_with_etdrk4_to_1e_10_where_every_coefficient_depends_on_the_densities) {
    expect_agreement(run_of(undisturbed(full_model()), 0.8), 128, 1e-10);
}

TEST(SundialsLong, agrees_with_etdrk4_to_1e_10_where_the_velocity_is_slaved) {
    for (const NamedModel& named : all_forms())
        if (physics::form(named.model).velocity == Velocity::slaved) {
            SCOPED_TRACE(named.name);
            expect_agreement(run_of(undisturbed(named.model), 0.4), 128, 1e-10);
        }
}

TEST(SundialsLong, agrees_with_etdrk4_to_1e_10_on_a_stiff_flock) {
    // A drag of 1e3 /s and sound of 30 q beside rates of order one; from the state that the fast modes leave.
    Model model = undisturbed(full_model());
    model.drag = {.coefficient = 1e3};
    model.driving = {.strength = 1e3};
    model.stiffness = {.beads = 1e3, .rods = 1e2};
    model.viscosity = {.shear = 1e2};
    Case run = run_of(model, 0.1);
    run.start = run.by("etdrk4-krogstad", 0.0, 64);
    expect_agreement(run, 64, 1e-10);
}

TEST(Sundials, gives_the_same_bits_on_any_number_of_threads) {
    const Case run = run_of(undisturbed(full_model()), 0.5);
    for (const std::string method : {"cvode-bdf", "arkode-ark548l2sa"})
        EXPECT_EQ(run.by(method, 1e-6).values, run.by(method, 1e-6, 1, 3).values) << method;
}

TEST(Sundials, runs_whose_reference_density_changes_agree_with_etdrk4) {
    const Case run = run_of(undisturbed(full_model()), 0.7);  // beads of 1.3 - 0.7 at the least: below 1.3/1.7
    const numerics::Spectra exact = run.by("etdrk4-krogstad", 0.0, 64);
    for (const std::string method : {"cvode-bdf", "arkode-ark548l2sa"}) {
        Threads threads(1);
        model::FieldEvolution evolution(integrated(run.model), grid, {.method = method, .dt = 0.1, .tolerance = 1e-9},
                                        1, threads);
        numerics::Spectra state = run.start;
        evolution.start(state);
        for (std::int64_t step = 0; step < 8; ++step) evolution.advance(step, state);
        EXPECT_GT(evolution.reference_changes(), 0) << method;
        EXPECT_LT(distance(state, exact), 1e-7) << method;
    }
}

TEST(Sundials, the_step_error_of_a_run_is_of_the_size_of_its_error) {
    const Case run = run_of(undisturbed(full_model()), 0.8);
    const numerics::Spectra exact = run.by("etdrk4-krogstad", 0.0, 64);
    for (const std::string method : {"cvode-bdf", "arkode-ark436l2sa"}) {
        Threads threads(1);
        model::FieldEvolution evolution(integrated(run.model), grid,
                                        {.method = method, .dt = run.dt, .tolerance = 1e-4}, 1, threads);
        numerics::Spectra state = run.start;
        evolution.start(state);
        for (std::int64_t step = 0; step < 8; ++step) evolution.advance(step, state);
        const double estimated = evolution.step_error().error, error = distance(state, exact);
        // Relative, of all modes, against the largest of one: a factor of ten.  Above, errors of interpolation, which
        // do not add up from step to step but are taken to.
        EXPECT_GT(estimated, 0.1 * error) << method;
        EXPECT_LT(estimated, 100.0 * error) << method;
    }
}

}  // namespace
}  // namespace drover::physics::sundials_tests
