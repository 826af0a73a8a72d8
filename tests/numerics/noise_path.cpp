// tests/numerics/noise_path.cpp: noise does not depend on how time is divided, nor on the grid.
#include "numerics/steppers/noise_path.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "drover/numerics/transform.hpp"
#include "numerics/rod_bead_operator.hpp"
#include "numerics/steppers/adaptive_stepper.hpp"

namespace drover::numerics::noise_path_tests {
namespace {

/// Rods and beads with inertia; noise on the densities and on the order.
System rods_and_beads(int n) {
    System system{
        .grid = {n, n, 5.0, 5.0}, .layout = scalars_and_vectors(2, 2), .linear = {}, .nonlinear = {}, .noise = {}};
    system.linear = [](double q) { return test::rod_bead_operator({}, q); };
    system.noise = [](double q) {
        IsotropicBlocks noise{Block(4), Block(2)};
        noise.even(0, 0) = 0.3 * q * q;
        noise.even(1, 1) = 0.2 * q * q;
        noise.even(3, 3) = noise.odd(1, 1) = 0.7;
        return noise;
    };
    return system;
}

struct Modes {
    std::vector<double> values;
    double size() const {
        double sum = 0.0;
        for (const double value : values) sum += value * value;
        return std::sqrt(sum / static_cast<double>(values.size()));
    }
};

Modes increments(NoisePath& path, const System& system, const NoiseInterval& interval) {
    path.compute(interval);
    const DistinctWavenumbers wavenumbers = distinct_wavenumbers(system.grid, system.degree);
    const std::size_t numbers = 2 * static_cast<std::size_t>(components(system.layout));
    Modes result;
    for (std::size_t row = 0; row < static_cast<std::size_t>(system.grid.ny); ++row) {
        const double* values = path.row(interval.level, row);
        const std::size_t kept = kept_in_row(system.grid, wavenumbers, row);
        result.values.insert(result.values.end(), values, values + numbers * kept);
    }
    return result;
}

/// A field that decays at this rate at every wavenumber.
System decaying(double rate, std::uint64_t path) {
    System system{
        .grid = {64, 64, 5.0, 5.0}, .layout = scalars_and_vectors(1, 0), .linear = {}, .nonlinear = {}, .noise = {}};
    const auto blocks = [](double value) {
        IsotropicBlocks result{Block(1), Block(0)};
        result.even(0, 0) = value;
        return result;
    };
    system.linear = [=](double) { return blocks(-rate); };
    system.noise = [=](double) { return blocks(1.0); };
    system.noise_path = path;
    return system;
}

TEST(NoisePath,
     of_another_law_in_the_middle_of_an_interval_is_not_correlated_with_what_has_been_if_its_number_differs) {
    // Of one path, the halves of 8 s by these laws have the correlation 0.336.
    Threads threads(1);
    const auto correlation = [&](std::uint64_t after) {
        const System one = decaying(0.01, 0), other = decaying(0.2, after);
        NoisePath before_change(one, 1.0, 7, threads), after_change(other, 1.0, 7, threads);
        const Modes first = increments(before_change, one, {1, 0}), second = increments(after_change, other, {1, 1});
        double product = 0.0;
        for (std::size_t k = 0; k < first.values.size(); ++k) product += first.values[k] * second.values[k];
        return product / static_cast<double>(first.values.size()) / (first.size() * second.size());
    };
    const double certain = 4.0 / 64.0;  // of some 4096 numbers
    EXPECT_NEAR(correlation(0), 0.336, certain);
    EXPECT_LT(std::abs(correlation(1)), certain);
}

TEST(NoisePath, the_halves_of_an_interval_compose_to_its_own_increment) {
    Threads threads(1);
    const System system = rods_and_beads(16);
    const DistinctWavenumbers wavenumbers = distinct_wavenumbers(system.grid, system.degree);
    for (const double dt : {1e-5, 0.01, 0.3, 40.0}) {
        NoisePath path(system, dt, 7, threads);
        for (int level = 0; level < path.level() + 4; ++level) {
            const std::uint64_t index = (std::uint64_t{1} << level) - 1 + (std::uint64_t{3} << level);
            const Modes whole = increments(path, system, {level, index}),
                        first = increments(path, system, {level + 1, 2 * index}),
                        second = increments(path, system, {level + 1, 2 * index + 1});
            const double half = std::ldexp(dt, path.level() - level - 1);
            std::size_t at = 0;
            for (std::size_t row = 0; row < 16; ++row)
                for (std::size_t i = 0; i < kept_in_row(system.grid, wavenumbers, row); ++i, at += 12) {
                    const auto n = static_cast<std::size_t>(wavenumbers.of_mode[row * 9 + i]);
                    const IsotropicBlocks m = system.linear(wavenumbers.q[n]);
                    const Block along = phi_functions(m.even, half)[0], across = phi_functions(m.odd, half)[0];
                    for (std::size_t k = 0; k < 12; ++k) {
                        const bool is_along = k < 8;
                        const Block& propagator = is_along ? along : across;
                        const std::size_t begin = is_along ? 0 : 8;
                        double composed = second.values[at + k], size = std::abs(composed);
                        for (int j = 0; j < propagator.size; ++j) {
                            const double part = propagator(static_cast<int>((k - begin) / 2), j) *
                                                first.values[at + begin + 2 * static_cast<std::size_t>(j) + k % 2];
                            composed += part;
                            size += std::abs(part);
                        }
                        // Rounding of five numbers.
                        EXPECT_NEAR(composed, whole.values[at + k], 1e-13 * size) << "dt " << dt << ", level " << level;
                    }
                }
        }
    }
}

TEST(NoisePath, of_a_step_and_of_half_a_step_is_the_same) {
    Threads threads(1);
    const System system = rods_and_beads(12);
    for (const double dt : {1e-4, 0.02, 0.25, 0.7, 3.0}) {
        NoisePath coarse(system, dt, 3, threads), fine(system, 0.5 * dt, 3, threads);
        ASSERT_EQ(fine.level(), coarse.level() + 1);
        for (const std::uint64_t step : {0u, 1u, 2u, 77u})
            EXPECT_EQ(increments(coarse, system, {coarse.level(), step}).values,
                      increments(fine, system, {coarse.level(), step}).values)
                << dt;
    }
}

TEST(NoisePath, of_shared_modes_has_the_same_bits_on_twice_the_points) {
    Threads one(1), two(2);
    for (const bool square : {true, false}) {
        System coarse = rods_and_beads(12), fine = rods_and_beads(24);
        if (!square) coarse.grid.ly = fine.grid.ly = 3.0;
        coarse.degree = fine.degree = 2;
        NoisePath few(coarse, 0.25, 3, one), many(fine, 0.25, 3, two);
        const DistinctWavenumbers wavenumbers = distinct_wavenumbers(coarse.grid, 2);
        for (int level = 0; level < 6; ++level)
            for (const std::uint64_t index : {5u, 6u}) {
                few.compute({level, index});
                many.compute({level, index});
                for (std::size_t row = 0; row < 12; ++row) {
                    const std::size_t kept = kept_in_row(coarse.grid, wavenumbers, row);
                    if (kept == 0) continue;
                    const double *a = few.row(level, row), *b = many.row(level, row < 6 ? row : row + 12);
                    EXPECT_EQ(std::vector(a, a + 12 * kept), std::vector(b, b + 12 * kept)) << level << " " << row;
                }
            }
    }
}

TEST(NoisePath, is_the_same_in_any_order_of_intervals) {
    Threads threads(1);
    const System system = rods_and_beads(8);
    NoisePath forward(system, 0.25, 3, threads), other(system, 0.25, 3, threads);
    std::vector<Modes> expected;
    for (std::uint64_t index = 0; index < 16; ++index) expected.push_back(increments(forward, system, {5, index}));
    for (const std::uint64_t index : {9u, 3u, 2u, 2u, 15u, 0u, 1u, 8u, 7u, 6u}) {
        increments(other, system, {3, index % 4});
        EXPECT_EQ(increments(other, system, {5, index}).values, expected[index].values);
    }
}

TEST(NoisePath, of_growing_and_of_undriven_modes_is_finite) {
    Threads threads(1);
    System system = rods_and_beads(8);
    system.linear = [](double q) { return test::rod_bead_operator({.decay = -300.0}, q); };
    for (const double dt : {1e-6, 1e-3, 0.5}) {
        NoisePath path(system, dt, 3, threads);
        for (int level = 0; level < path.level() + 3; ++level)
            for (const double value : increments(path, system, {level, 1}).values) ASSERT_TRUE(std::isfinite(value));
    }
}

/// Sum of the products of two increments of one mode, at the same and at other times.
TEST(NoisePathStatistics, of_halves_has_the_covariance_of_their_length_and_none_between_them) {
    Threads threads(1);
    const System system = rods_and_beads(4);
    const DistinctWavenumbers wavenumbers = distinct_wavenumbers(system.grid, system.degree);
    const std::size_t mode = 1;  // q = 2 pi/L along x
    const auto n = static_cast<std::size_t>(wavenumbers.of_mode[mode]);
    const IsotropicBlocks m = system.linear(wavenumbers.q[n]), noise = system.noise(wavenumbers.q[n]);
    for (const double dt : {0.01, 0.5, 16.0}) {
        NoisePath path(system, dt, 11, threads);
        const int level = path.level() + 2;
        const Block expected = noise_tree(m.even, noise.even, 0.25 * dt, 0).covariance;
        constexpr int samples = 20000;
        std::vector<double> same(16), next(16), before(4);
        for (std::uint64_t index = 0; index < samples; ++index) {
            path.compute({level, index});
            const double* values = path.row(level, 0) + 12 * mode;
            for (std::size_t i = 0; i < 4; ++i)
                for (std::size_t j = 0; j < 4; ++j) {
                    same[4 * i + j] += values[2 * i] * values[2 * j];
                    next[4 * i + j] += values[2 * i] * before[j];
                }
            for (std::size_t i = 0; i < 4; ++i) before[i] = values[2 * i];
        }
        for (std::size_t i = 0; i < 4; ++i)
            for (std::size_t j = 0; j < 4; ++j) {
                const auto at = [&](std::size_t a, std::size_t b) {
                    return expected(static_cast<int>(a), static_cast<int>(b)) / (2.0 * area(system.grid));
                };
                // Of a product of two normal numbers; four of its standard errors, in 32 comparisons each.
                const double error = 4.0 * std::sqrt((at(i, i) * at(j, j) + at(i, j) * at(i, j)) / samples);
                EXPECT_NEAR(same[4 * i + j] / samples, at(i, j), error) << i << j << " dt " << dt;
                EXPECT_NEAR(next[4 * i + j] / samples, 0.0, error) << i << j << " dt " << dt;
            }
    }
}

/// One wave of order that relaxes at a rate that rises with its square: large increments need short steps.
System stiffening(double strength) {
    System system{
        .grid = {4, 4, 2.0, 2.0}, .layout = scalars_and_vectors(0, 1), .linear = {}, .nonlinear = {}, .noise = {}};
    system.linear = [](double) {
        IsotropicBlocks rates{Block(1), Block(1)};
        rates.even(0, 0) = rates.odd(0, 0) = -1.0;
        return rates;
    };
    system.noise = [](double q) {
        IsotropicBlocks noise{Block(1), Block(1)};
        if (q == 0.0) noise.even(0, 0) = 8.0;  // variance 1 at strength 0, in a cell of 4 mm^2
        return noise;
    };
    system.nonlinear = [strength](double, const Spectra& state, Spectra& rate) {
        std::fill(rate.values.begin(), rate.values.end(), Complex(0.0));
        const double p = state[0][0].real();
        rate[0][0] = -strength * p * p * p;
    };
    return system;
}

TEST(AdaptiveStepperStatistics, with_noise_rejected_steps_leave_the_stationary_variance_unbiased) {
    // <p^2> of dp = -(p + s p^3) dt + sqrt(2) dW: the density is exp(-p^2/2 - s p^4/4).
    Threads threads(1);
    constexpr double strength = 2.0;
    double norm = 0.0, square = 0.0;
    for (double p = -8.0; p < 8.0; p += 1e-3) {
        const double weight = std::exp(-0.5 * p * p - 0.25 * strength * p * p * p * p);
        norm += weight;
        square += p * p * weight;
    }
    for (const double tolerance : {0.1, 0.01}) {
        AdaptiveStepper stepper({.method = "etdrk2", .dt = 0.5, .tolerance = tolerance}, stiffening(strength), 5,
                                threads);
        Spectra state(stepper.system().grid, 2);
        constexpr int steps = 20000;
        double sum = 0.0;
        for (int n = 0; n < steps; ++n) {
            stepper.advance(n, state);
            sum += std::norm(state[0][0]);
        }
        EXPECT_GT(stepper.count().rejected, 300) << "the test needs rejected steps";
        // <p^4> - <p^2>^2 is near 0.13, and p^2 forgets within 0.3 s: less than one sample.  Four standard errors, and
        // the error of the steps themselves, which falls with the tolerance.
        EXPECT_NEAR(sum / steps, square / norm, 4.0 * std::sqrt(0.13 / steps) + 0.02 * tolerance) << tolerance;
    }
}

TEST(AdaptiveStepper, a_part_that_is_rejected_in_the_middle_of_dt_is_divided_where_it_begins) {
    // The rate jumps in the second half: its first part is accepted, its second rejected.
    Threads threads(1);
    System system = stiffening(0.0);
    system.noise = {};
    system.nonlinear = [](double t, const Spectra&, Spectra& rate) {
        std::fill(rate.values.begin(), rate.values.end(), Complex(0.0));
        rate[0][0] = 1.0 + 10.0 * (1.0 + std::tanh((t - 0.75) / 0.02));
    };
    AdaptiveStepper stepper({.method = "etdrk2", .dt = 1.0, .tolerance = 1e-4}, system, 5, threads);
    stepper.set_division(2);
    Spectra state(system.grid, 2), fine(system.grid, 2);
    stepper.advance(0, state);
    Stepper exact(system, stepper_table("etdrk4"), 1.0 / 1024, 5, threads);
    for (int step = 0; step < 1024; ++step) exact.step(step / 1024.0, static_cast<std::uint64_t>(step), fine);
    EXPECT_GT(stepper.count().rejected, 0);
    EXPECT_NEAR(state[0][0].real(), fine[0][0].real(), 0.01 * fine[0][0].real());  // 1e-4 a part, of some hundred
}

TEST(AdaptiveStepper, takes_a_run_error_within_an_attempt_as_a_rejected_step) {
    Threads threads(1);
    System system = stiffening(0.0);
    system.noise = {};
    system.nonlinear = [](double, const Spectra& state, Spectra& rate) {
        std::fill(rate.values.begin(), rate.values.end(), Complex(0.0));
        const double p = state[0][0].real();
        if (p < 0.5) fail_run("p = {}; expected at least 0.5", p);  // a step of dt from 1 at rate -4 ends far below
        rate[0][0] = -4.0 * (p - 1.0) - 3.0;
    };
    AdaptiveStepper stepper({.method = "etdrk2", .dt = 4.0, .tolerance = 1e-3}, system, 5, threads);
    Spectra state(system.grid, 2);
    state[0][0] = 10.0;
    try {
        stepper.advance(0, state);
        FAIL() << "the solution itself leaves the domain";
    } catch (const Error& error) {
        EXPECT_NE(std::string(error.what()).find("expected at least 0.5"), std::string::npos) << error.what();
        EXPECT_NE(std::string(error.what()).find("no step down to"), std::string::npos) << error.what();
    }
    EXPECT_GT(stepper.count().accepted, 3);
}

}  // namespace
}  // namespace drover::numerics::noise_path_tests
