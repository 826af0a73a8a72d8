// tests/numerics/sundials_stepper.cpp: order, tolerance, restart and errors of the methods of SUNDIALS.
#include "numerics/steppers/sundials_stepper.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "drover/base/error.hpp"
#include "drover/numerics/stepper.hpp"
#include "numerics/small_flock.hpp"
#include "numerics/steppers/time_method.hpp"

namespace drover::numerics::sundials_stepper_tests {
namespace {

constexpr double end_time = 1.0;

Spectra exact_end(const System& system, const Spectra& from, Threads& threads) {
    constexpr int steps = 2048;
    Stepper stepper(system, stepper_table("etdrk4-krogstad"), end_time / steps, 1, threads);
    Spectra state = from;
    for (int n = 0; n < steps; ++n) stepper.step(end_time * n / steps, static_cast<std::uint64_t>(n), state);
    return state;
}

std::vector<TimeMethod> sundials_methods() {
    std::vector<TimeMethod> methods = time_methods();
    std::erase_if(methods, [](const TimeMethod& method) { return method.is_exponential; });
    return methods;
}

/// At end_time, after `steps` calls.
Spectra after(const System& system, const std::string& method, int steps, double tolerance, Spectra state) {
    SundialsStepper stepper(system, time_method(method), end_time / steps, tolerance);
    for (int n = 0; n < steps; ++n) stepper.advance(n, state);
    return state;
}

struct Flock {
    Threads threads{1};
    Transform transform{small_grid, 3, threads};
    System system = small_flock(transform);
    Spectra from = start(transform);
};

TEST(SundialsStepper, every_additive_method_has_its_order_in_steps_of_fixed_length) {
    Flock flock;
    const Spectra exact = exact_end(flock.system, flock.from, flock.threads);
    int checked = 0;
    for (const TimeMethod& method : sundials_methods()) {
        if (method.stages == 0) continue;
        double before = distance(after(flock.system, method.name, 16, 0.0, flock.from), exact);
        for (const int steps : {32, 64, 128}) {
            const double error = distance(after(flock.system, method.name, steps, 0.0, flock.from), exact);
            // The order is approached from either side; below 1e-12 stand the roundings.
            if (error > 1e-12) {
                EXPECT_GE(std::log2(before / error), method.order - 0.25) << method.name << ", " << steps << " steps";
            }
            before = error;
        }
        EXPECT_LT(before, method.order == 3 ? 1e-6 : 1e-8) << method.name;
        ++checked;
    }
    EXPECT_EQ(checked, 5);
}

TEST(SundialsStepper, the_error_follows_the_tolerance_down_to_1e_10) {
    Flock flock;
    const Spectra exact = exact_end(flock.system, flock.from, flock.threads);
    for (const TimeMethod& method : sundials_methods()) {
        for (const double tolerance : {1e-5, 1e-8, 1e-12}) {
            const double error = distance(after(flock.system, method.name, 10, tolerance, flock.from), exact);
            // Tens to hundreds of steps, each wrong by the tolerance at most.
            EXPECT_LT(error, 100.0 * tolerance) << method.name << ", tolerance " << tolerance;
        }
    }
}

TEST(SundialsStepper, a_stiff_linear_system_is_integrated_to_the_tolerance) {
    Flock flock;
    flock.system.nonlinear = {};
    flock.system.linear = [linear = flock.system.linear](double q) {
        IsotropicBlocks m = linear(q);
        m.even(0, 0) -= 1e4 * q * q;  // 1e4 (2 pi/6)^2 = 1e4 /s for the slowest of these modes
        return m;
    };
    const Spectra exact = exact_end(flock.system, flock.from, flock.threads);
    for (const std::string method : {"cvode-bdf", "arkode-ark436l2sa", "arkode-ark548l2sa"}) {
        SundialsStepper stepper(flock.system, time_method(method), 0.1, 1e-8);
        Spectra state = flock.from;
        for (int n = 0; n < 10; ++n) stepper.advance(n, state);
        EXPECT_LT(distance(state, exact), 1e-6) << method;
        // Explicit methods would need 1e4 * 9 (2 pi/6)^2/3 = 3e4 steps for the fastest mode kept.
        EXPECT_LT(stepper.count().accepted, 1000) << method;
    }
}

TEST(SundialsStepper, a_restored_stepper_repeats_its_history_to_the_same_bits) {
    Flock flock;
    for (const std::string method : {"cvode-bdf", "cvode-adams", "arkode-ark548l2sa"}) {
        const TimeMethod& row = time_method(method);
        SundialsStepper whole(flock.system, row, 0.05, 1e-6);
        Spectra state = flock.from, middle;
        std::vector<double> saved;
        for (int n = 0; n < 40; ++n) {
            if (n == 17) {
                saved = whole.save();
                middle = state;
            }
            whole.advance(n, state);
        }
        ASSERT_EQ(saved.size(), whole.saved_numbers());
        SundialsStepper resumed(flock.system, row, 0.05, 1e-6);
        resumed.restore(saved);
        for (int n = 17; n < 40; ++n) resumed.advance(n, middle);
        EXPECT_EQ(state.values, middle.values) << method;
        // Without the history the result is another one: the test is not empty.
        Spectra cold = flock.from;
        SundialsStepper restarted(flock.system, row, 0.05, 1e-6);
        for (int n = 0; n < 40; ++n) {
            if (n == 17) restarted.restore(SundialsStepper(flock.system, row, 0.05, 1e-6).save());
            restarted.advance(n, cold);
        }
        if (method != "arkode-ark548l2sa") {
            EXPECT_NE(state.values, cold.values) << method;
        }
    }
}

TEST(SundialsStepper, a_run_longer_than_its_history_is_restored_to_the_same_bits) {
    Flock flock;
    flock.system.nonlinear = [rest = flock.system.nonlinear](double t, const Spectra& state, Spectra& rate) {
        rest(t, state, rate);
        rate[1][0] += 20.0 * std::sin(100.0 * t);  // so that steps stay short
    };
    const TimeMethod& row = time_method("cvode-bdf");
    SundialsStepper whole(flock.system, row, 0.1, 1e-7);
    Spectra state = flock.from, middle;
    std::vector<double> saved;
    for (int n = 0; n < 60; ++n) {
        if (n == 50) {
            saved = whole.save();
            middle = state;
        }
        whole.advance(n, state);
    }
    ASSERT_GT(whole.count().accepted, 2 * SundialsStepper::steps_between_starts);
    EXPECT_GT(saved[0], 0.0);  // a start without history after the first
    SundialsStepper resumed(flock.system, row, 0.1, 1e-7);
    resumed.restore(saved);
    for (int n = 50; n < 60; ++n) resumed.advance(n, middle);
    EXPECT_EQ(state.values, middle.values);
}

TEST(SundialsStepper, a_mean_without_sources_is_conserved_to_rounding) {
    Flock flock;
    for (const TimeMethod& method : sundials_methods()) {
        const Spectra state = after(flock.system, method.name, 20, 1e-5, flock.from);
        EXPECT_NEAR(state[0][0].real(), flock.from[0][0].real(), 1e-14) << method.name;
    }
}

TEST(SundialsStepper, noise_is_rejected_with_the_remedy) {
    Flock flock;
    flock.system.noise = flock.system.linear;
    try {
        SundialsStepper(flock.system, time_method("cvode-bdf"), 0.1, 1e-6);
        FAIL() << "no error";
    } catch (const Error& error) {
        EXPECT_EQ(error.fault(), Fault::input);
        EXPECT_THAT(error.what(), testing::HasSubstr("choose etdrk2"));
    }
    flock.system.noise = {};
    EXPECT_THROW(SundialsStepper(flock.system, time_method("cvode-adams"), 0.1, 0.0), Error);
}

TEST(SundialsStepper, an_error_of_the_right_hand_side_passes_through_with_its_words) {
    Flock flock;
    flock.system.nonlinear = [](double t, const Spectra&, Spectra&) {
        if (t > 0.35) fail_run("the density vanished at t = {}", t);
    };
    for (const TimeMethod& method : sundials_methods()) {
        SundialsStepper stepper(flock.system, method, 0.1, 1e-6);
        Spectra state = flock.from;
        try {
            for (int n = 0; n < 10; ++n) stepper.advance(n, state);
            FAIL() << "no error by " << method.name;
        } catch (const Error& error) {
            EXPECT_THAT(error.what(), testing::HasSubstr("the density vanished")) << method.name;
        }
    }
}

TEST(SundialsStepper, a_solution_that_diverges_ends_with_a_run_error_that_names_the_tolerance) {
    Flock flock;
    flock.system.nonlinear = [](double, const Spectra& state, Spectra& rate) {
        for (auto& value : rate.values) value = 0.0;
        rate[1][0] = 10.0 * state[1][0] * state[1][0];  // infinite at t = 1/(10 * 0.6)
    };
    for (const std::string method : {"cvode-bdf", "arkode-ark548l2sa"}) {
        SundialsStepper stepper(flock.system, time_method(method), 0.1, 1e-6);
        Spectra state = flock.from;
        try {
            for (int n = 0; n < 10; ++n) stepper.advance(n, state);
            FAIL() << "no error by " << method;
        } catch (const Error& error) {
            EXPECT_EQ(error.fault(), Fault::run);
            EXPECT_THAT(error.what(), testing::HasSubstr("time.tolerance")) << method;
        }
    }
}

TEST(TimeMethod, an_unknown_name_is_rejected_with_all_names) {
    try {
        time_method("cvode");
        FAIL() << "no error";
    } catch (const Error& error) {
        EXPECT_THAT(error.what(), testing::AllOf(testing::HasSubstr("etdrk2"), testing::HasSubstr("cvode-bdf")));
    }
}

}  // namespace
}  // namespace drover::numerics::sundials_stepper_tests
