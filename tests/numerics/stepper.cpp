// tests/numerics/stepper.cpp: order of each method, exactness on linear systems, and independence of threads.
#include "drover/numerics/stepper.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <numbers>

#include "drover/base/error.hpp"
#include "drover/numerics/transform.hpp"
#include "numerics/extended.hpp"
#include "numerics/rod_bead_operator.hpp"
#include "numerics/small_flock.hpp"

namespace drover::numerics::stepper_tests {
namespace {

Spectra after(const System& system, const StepperTable& table, int steps, double end, const Spectra& from,
              Threads& threads, std::uint64_t seed = 1) {
    Stepper stepper(system, table, end / steps, seed, threads);
    Spectra state = from;
    for (int n = 0; n < steps; ++n) stepper.step(end * n / steps, static_cast<std::uint64_t>(n), state);
    return state;
}

TEST(Stepper, every_method_has_its_order_over_four_halvings) {
    Threads threads(1);
    const Transform transform(small_grid, 3, threads);
    const System system = small_flock(transform);
    const Spectra from = start(transform);
    constexpr double end = 1.0;
    const Spectra exact = after(system, stepper_table("etdrk4-krogstad"), 2048, end, from, threads);
    for (const StepperTable& table : stepper_tables()) {
        // Multistep methods reach their order only where a step is short beside the time of their history.
        const int coarsest = table.history > 2 ? 64 : table.order >= 4 ? 8 : 32;
        double before = distance(after(system, table, coarsest, end, from, threads), exact);
        for (int halving = 1; halving <= 4; ++halving) {
            const double error = distance(after(system, table, coarsest << halving, end, from, threads), exact);
            if (before < 1e-11) break;  // rounding of the reference
            // The order is approached from either side; the margin is a tenth.
            EXPECT_GE(std::log2(before / error), table.order - 0.1)
                << table.name << ", halving " << halving << ", error " << error;
            before = error;
        }
        EXPECT_LT(before, table.order == 1 ? 1e-2 : table.order == 2 ? 1e-4 : 1e-8) << table.name;
    }
}

TEST(Stepper, every_method_is_exact_for_a_constant_rate) {
    // da/dt = L a + n with n constant in time: a(t) = exp(L t) a + t phi_1(L t) n for any step.
    Threads threads(1);
    const Transform transform(small_grid, 3, threads);
    System system = small_flock(transform);
    const Spectra from = start(transform);
    system.nonlinear = [&from](double, const Spectra&, Spectra& rate) {
        for (std::size_t m = 0; m < rate.values.size(); ++m) rate.values[m] = 0.1 * from.values[m];
    };
    const Spectra exact = after(system, stepper_table("exponential-euler"), 1, 2.0, from, threads);
    for (const StepperTable& table : stepper_tables())
        for (const int steps : {1, 3})
            EXPECT_LT(distance(after(system, table, steps, 2.0, from, threads), exact), 1e-13) << table.name;
}

TEST(MultistepStepper, resumes_with_its_history_to_the_same_bits_from_any_step) {
    Threads threads(1);
    const Transform transform(small_grid, 3, threads);
    const System system = small_flock(transform);
    const StepperTable& table = stepper_table("etd-abm5");
    const double dt = 0.05;
    const auto advance = [&](Stepper& stepper, int first, int last, Spectra& state) {
        for (int n = first; n < last; ++n) stepper.step(n * dt, static_cast<std::uint64_t>(n), state);
    };
    Stepper whole(system, table, dt, 1, threads);
    Spectra state = start(transform), error = state;
    advance(whole, 0, 12, state);
    for (const int middle : {0, 1, 2, 3, 4, 8}) {
        Stepper first(system, table, dt, 1, threads), second(system, table, dt, 1, threads),
            without(system, table, dt, 1, threads);
        Spectra resumed = start(transform);
        advance(first, 0, middle, resumed);
        first.last_error(middle * dt, resumed, error);  // which knows the rate at the new state already
        Spectra cold = resumed;
        second.restore_history(first.save_history());
        advance(second, middle, 12, resumed);
        EXPECT_EQ(resumed.values, state.values) << middle;
        advance(without, middle, 12, cold);
        EXPECT_EQ(cold.values == state.values, middle == 0) << middle << ": a start instead of the history";
        std::vector<double> wrong = first.save_history();
        if (middle == 0) continue;
        wrong.pop_back();
        EXPECT_THROW(second.restore_history(wrong), Error);
    }
}

TEST(MultistepStepper, starts_anew_where_a_step_does_not_follow_the_last_one) {
    Threads threads(1);
    const Transform transform(small_grid, 3, threads);
    const System system = small_flock(transform);
    const double dt = 0.05;
    Stepper used(system, stepper_table("etd-abm4"), dt, 1, threads),
        fresh(system, stepper_table("etd-abm4"), dt, 1, threads);
    Spectra state = start(transform), expected = start(transform);
    for (std::uint64_t n = 0; n < 6; ++n) used.step(static_cast<double>(n) * dt, n, state);
    state = start(transform);
    for (std::uint64_t n = 20; n < 26; ++n) {
        used.step(static_cast<double>(n) * dt, n, state);
        fresh.step(static_cast<double>(n) * dt, n, expected);
    }
    EXPECT_EQ(state.values, expected.values);
}

TEST(MultistepStepper, estimates_the_error_of_each_step) {
    Threads threads(1);
    const Transform transform(small_grid, 3, threads);
    const System system = small_flock(transform);
    for (const char* method : {"etd-abm3", "etd-abm4", "etd-abm5", "etd-abm6"}) {
        const StepperTable& table = stepper_table(method);
        const double dt = 1.0 / 64.0;
        Stepper stepper(system, table, dt, 1, threads),
            fine(system, stepper_table("etdrk4-krogstad"), dt / 32.0, 1, threads);
        Spectra state = start(transform), exact = state, estimate = state;
        for (std::uint64_t n = 0; n < 18; ++n) {
            const double t = static_cast<double>(n) * dt;
            exact = state;
            for (std::uint64_t part = 0; part < 32; ++part)
                fine.step(t + static_cast<double>(part) * dt / 32.0, 32 * n + part, exact);
            stepper.step(t, n, state);
            // Its corrector of the next order needs one rate more than a step.
            const auto needed = static_cast<std::uint64_t>(table.history) + 1;
            ASSERT_EQ(stepper.last_error(t + dt, state, estimate), n >= needed) << method << ", step " << n;
            if (n < 14) continue;  // the first errors change within a step
            Spectra difference = state;
            for (std::size_t k = 0; k < difference.values.size(); ++k) difference.values[k] -= exact.values[k];
            // The terms of the next order.
            const double size = distance(difference, Spectra(small_grid, 3));
            EXPECT_LT(distance(estimate, difference), 0.3 * size) << method << ", step " << n;
        }
    }
}

TEST(MultistepStepper, rejects_noise) {
    Threads threads(1);
    const Transform transform(small_grid, 3, threads);
    System system = small_flock(transform);
    system.noise = noise_on_order(1e-3);
    EXPECT_THROW(Stepper(system, stepper_table("etd-abm4"), 0.1, 1, threads), Error);
}

TEST(Stepper, shares_its_arrays_with_others_and_keeps_its_bits) {
    Threads threads(1);
    const Transform transform(small_grid, 3, threads);
    const System system = small_flock(transform);
    const StepperTable& table = stepper_table("etdrk4-krogstad");
    const auto scratch = std::make_shared<StepperScratch>();
    Stepper alone(system, table, 0.1, 1, threads), sharing(system, table, 0.1, 1, threads, scratch),
        other(system, table, 0.05, 1, threads, scratch);
    Spectra expected = start(transform), state = expected, elsewhere = expected;
    for (std::uint64_t n = 0; n < 5; ++n) {
        alone.step(0.1 * static_cast<double>(n), n, expected);
        sharing.step(0.1 * static_cast<double>(n), n, state);
        other.step(0.05 * static_cast<double>(n), n, elsewhere);
    }
    EXPECT_EQ(state.values, expected.values);
    EXPECT_NE(elsewhere.values, expected.values);
}

TEST(Stepper, one_step_of_a_linear_system_equals_many) {
    Threads threads(1);
    System system{
        .grid = {12, 10, 5.0, 3.0}, .layout = scalars_and_vectors(2, 2), .linear = {}, .nonlinear = {}, .noise = {}};
    system.linear = [](double q) { return test::rod_bead_operator({}, q); };
    Spectra from(system.grid, 6);
    Threads one(1);
    Fields fields(system.grid, 6);
    fill_normal({.seed = 9, .stream = Stream::test}, 0, 1, fields.values);
    Transform(system.grid, 1, one).forward(fields, from);
    const StepperTable& table = stepper_table("etdrk2");
    const Spectra once = after(system, table, 1, 1.5, from, threads),
                  often = after(system, table, 300, 1.5, from, threads);
    EXPECT_LT(distance(once, often), 1e-12 * distance(from, Spectra(system.grid, 6)));  // 300 roundings
}

// An independent Cartesian form of the operator: d/dt of every field at one wavevector.
TEST(Stepper, the_blocks_are_the_cartesian_equations_in_every_direction) {
    Threads threads(1);
    const test::RodBeadCoefficients c;
    System system{
        .grid = {8, 8, 3.0, 4.0}, .layout = scalars_and_vectors(2, 2), .linear = {}, .nonlinear = {}, .noise = {}};
    system.linear = [&c](double q) { return test::rod_bead_operator(c, q); };
    const double dt = 1e-9;
    Stepper stepper(system, stepper_table("exponential-euler"), dt, 1, threads);
    Spectra from(system.grid, 6);
    Fields fields(system.grid, 6);
    fill_normal({.seed = 4, .stream = Stream::test}, 0, 1, fields.values);
    Transform(system.grid, 1, threads).forward(fields, from);
    Spectra to = from;
    stepper.step(0.0, 0, to);
    const std::size_t width = columns(system.grid);
    const Complex i(0.0, 1.0);
    for (std::size_t m = 0; m < from.size; ++m) {
        if (!is_kept(system.grid, 1, m % width, m / width)) continue;
        const Wavevector q = wavevector(system.grid, m % width, m / width);
        const double q2 = q.x * q.x + q.y * q.y;
        const Complex rho = from[0][m], sigma = from[1][m], vx = from[2][m], vy = from[3][m], px = from[4][m],
                      py = from[5][m];
        const Complex div_v = i * (q.x * vx + q.y * vy), div_p = i * (q.x * px + q.y * py);
        const auto velocity = [&](Complex v, double k, Complex p) {
            return (-c.drag * v - c.eta * q2 * v + c.zeta * i * k * div_v + c.alpha * p -
                    i * k * (c.bead_pressure * rho + c.rod_pressure * sigma)) /
                   c.rho0;
        };
        const auto order = [&](Complex p, double k, Complex v) {
            return -c.decay * p + c.splay * i * k * div_p - c.stiffness * q2 * p + c.weathercock * v -
                   i * k * (c.order_beads * rho + c.order_rods * sigma);
        };
        const Complex expected[] = {-c.rho0 * div_v,       -c.speed * div_p,   velocity(vx, q.x, px),
                                    velocity(vy, q.y, py), order(px, q.x, vx), order(py, q.y, vy)};
        for (int f = 0; f < 6; ++f)
            // (a(dt) - a)/dt: half dt times a second derivative of order 1e4, and the rounding 1e-16/1e-9 of a.
            EXPECT_NEAR(std::abs((to[f][m] - from[f][m]) / dt - expected[f]), 0.0, 1e-5)
                << "field " << f << " mode " << m;
    }
}

TEST(Stepper, with_noise_the_bytes_do_not_depend_on_the_number_of_threads) {
    Threads one(1);
    const Transform transform(small_grid, 3, one);
    System system = small_flock(transform);
    system.noise = noise_on_order(0.01);
    for (const char* name : {"exponential-euler", "etdrk2", "etdrk4"}) {
        const Spectra expected = after(system, stepper_table(name), 5, 0.5, start(transform), one);
        for (const int team : {2, 4}) {
            Threads threads(team);
            EXPECT_EQ(after(system, stepper_table(name), 5, 0.5, start(transform), threads).values, expected.values)
                << name;
        }
        EXPECT_NE(after(system, stepper_table(name), 5, 0.5, start(transform), one, 2).values, expected.values) << name;
    }
}

TEST(Stepper, fields_stay_real_where_order_grows) {
    // Column 0 has q and -q: their non-conjugate parts are invisible in real space and would grow as exp(t).
    Threads threads(1);
    const Transform transform(small_grid, 3, threads);
    const Spectra state = after(small_flock(transform), stepper_table("etdrk2"), 800, 80.0, start(transform), threads);
    const std::size_t width = columns(small_grid);
    for (int c = 0; c < 3; ++c)
        for (std::size_t j = 1; j < 8; ++j) EXPECT_EQ(state[c][j * width], std::conj(state[c][(16 - j) * width]));
}

TEST(StepperTables, have_a_citation_an_order_and_a_last_stage_at_the_end_of_the_step) {
    for (const StepperTable& table : stepper_tables()) {
        EXPECT_FALSE(table.citation.empty());
        EXPECT_EQ(table.stages.back().c, 1.0);
        double before = 0.0;
        for (const StepperStage& stage : table.stages) {
            EXPECT_GE(stage.c, before) << "noise is drawn in the order of the stages";
            before = stage.c;
        }
    }
    EXPECT_THROW(stepper_table("rk9"), Error);
}

TEST(Stepper, keeps_its_own_table_and_rejects_one_that_it_cannot_use) {
    Threads threads(1);
    const Transform transform(small_grid, 3, threads);
    const System system = small_flock(transform);
    auto table = std::make_unique<StepperTable>(stepper_table("etdrk2"));
    Spectra expected = start(transform), state = expected;
    Stepper(system, *table, 0.1, 1, threads).step(0.0, 0, expected);
    Stepper stepper(system, *table, 0.1, 1, threads);
    table.reset();
    stepper.step(0.0, 0, state);
    EXPECT_EQ(state.values, expected.values);
    const auto rejects = [&](auto change) {
        StepperTable changed = stepper_table("etdrk2");
        change(changed);
        EXPECT_THROW(Stepper(system, changed, 0.1, 1, threads), Error);
    };
    for (const int order : {-1, 0, max_phi + 1, 20})
        rejects([&](StepperTable& t) { t.stages[1].terms[0][0].order = order; });
    rejects([](StepperTable& t) { t.stages.back().c = 0.5; });
    rejects([](StepperTable& t) { t.stages.clear(); });
    rejects([](StepperTable& t) { t.stages[0].terms.resize(3); });
    StepperTable high = stepper_table("exponential-euler");  // phi_1 = 1 + z phi_2 = 1 + z/2 + z^2 phi_3: all in bounds
    high.stages[0].terms[0].push_back({.weight = 0.0, .order = max_phi});
    EXPECT_NO_THROW(Stepper(system, high, 0.1, 1, threads).step(0.0, 0, state));
}

TEST(Stepper, rejects_arrays_and_scratch_of_another_grid_or_layout) {
    Threads threads(1);
    const Transform transform(small_grid, 3, threads);
    System system = small_flock(transform);
    const StepperTable& table = stepper_table("etdrk2");
    const auto scratch = std::make_shared<StepperScratch>();
    Stepper stepper(system, table, 0.1, 1, threads, scratch);
    Spectra state = start(transform), next = state, error = state, none;
    const Spectra few(small_grid, state.count() - 1), small({.nx = 8, .ny = 8}, state.count());
    for (Spectra other : {none, few, small}) {
        EXPECT_THROW(stepper.step(0.0, 0, other), Error);
        EXPECT_THROW(stepper.attempt(0.0, 0, state, other, error), Error);
        EXPECT_THROW(stepper.attempt(0.0, 0, state, next, other), Error);
    }
    EXPECT_THROW(Stepper(system, stepper_table("etdrk4"), 0.1, 1, threads, scratch), Error);
    system.grid = {.nx = 8, .ny = 8, .lx = 6.0, .ly = 6.0};
    EXPECT_THROW(Stepper(system, table, 0.1, 1, threads, scratch), Error);
    for (const auto& [nx, ny] : {std::pair{7, 8}, {8, 0}, {262144, 8}}) {
        system.grid.nx = nx, system.grid.ny = ny;
        EXPECT_THROW(Stepper(system, table, 0.1, 1, threads), Error);
    }
}

}  // namespace
}  // namespace drover::numerics::stepper_tests
