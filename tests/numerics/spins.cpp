// tests/numerics/spins.cpp: fields of any spins, against their equations in components.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cmath>
#include <numbers>

#include "drover/base/error.hpp"
#include "drover/base/random.hpp"
#include "drover/numerics/stepper.hpp"
#include "drover/numerics/transform.hpp"
#include "numerics/spin_equations.hpp"
#include "numerics/steppers/isotropic.hpp"
#include "numerics/steppers/linear_operator.hpp"
#include "numerics/steppers/noise_path.hpp"
#include "numerics/steppers/sundials_stepper.hpp"

namespace drover::numerics::spins_tests {
namespace {

using Eigen::MatrixXcd;
using Eigen::VectorXcd;

/// Spins 0 to 3 of both parities, not in order.
const Layout all_kinds{
    .fields = {{.spin = 2, .odd = true}, {}, {.spin = 1}, {.odd = true}, {3, true}, {2}, {.spin = 3}, {1, true}}};
/// Three scalars, a pseudoscalar, a vector, a nematic and a field of spin 3.
const Layout many_fields{.fields = {{}, {}, {}, {.odd = true}, {.spin = 1}, {.spin = 2}, {.spin = 3}}};
const Layout hexatic{.fields = {{.spin = 6}, {.spin = 1}, {}}};
Layout chiral(Layout layout) {
    layout.chiral = true;
    return layout;
}

constexpr Grid grid{10, 8, 5.0, 3.0};
constexpr double largest_q = 2.0 * std::numbers::pi * 10 / 2 / 5.0 * 1.7;

SpinEquations equations_of(const Layout& layout, unsigned seed = 1) { return {layout, 3.0, 0.1, largest_q, seed}; }

System system_of(const SpinEquations& equations) {
    System system{.grid = grid, .layout = equations.layout, .linear = {}, .nonlinear = {}, .noise = {}};
    system.linear = [equations](double q) { return equations.blocks(q); };
    return system;
}

Spectra random_state(const Layout& layout) {
    Threads threads(1);
    Fields fields(grid, components(layout));
    fill_normal({.seed = 3, .stream = Stream::test}, 0, 1, fields.values);
    Spectra state(grid, components(layout));
    Transform(grid, 1, threads).forward(fields, state);
    return state;
}

VectorXcd mode_of(const Spectra& state, std::size_t mode) {
    VectorXcd result(state.count());
    for (int c = 0; c < state.count(); ++c) result(c) = state[c][mode];
    return result;
}

/// body(mode, q) for the kept modes.
template <class Body>
void for_modes(Body body) {
    for (std::size_t mode = 0; mode < modes(grid); ++mode)
        if (const std::size_t column = mode % columns(grid), row = mode / columns(grid); is_kept(grid, 1, column, row))
            body(mode, wavevector(grid, column, row));
}

/// The largest difference of a mode from expected(q, mode before), relative to the size of that mode.
template <class Expected>
double largest_error(const Spectra& before, const Spectra& after, Expected expected) {
    double largest = 0.0;
    for_modes([&](std::size_t mode, const Wavevector& q) {
        const VectorXcd from = mode_of(before, mode);
        largest = std::max(largest, (mode_of(after, mode) - expected(q, from)).norm() / from.norm());
    });
    return largest;
}

TEST(Spins, the_parts_of_a_layout_are_even_or_odd_by_spin_and_parity) {
    const Layout layout{.fields = {{.odd = true}, {.spin = 1}, {}, {.spin = 2, .odd = true}}};
    const auto places = [](const std::vector<Part>& parts) {
        std::vector<std::pair<int, int>> result;
        for (const Part& part : parts) result.emplace_back(part.component, part.spin);
        return result;
    };
    using Places = std::vector<std::pair<int, int>>;
    const BlockParts parts = block_parts(layout), joined = block_parts(chiral(layout));
    EXPECT_EQ(places(parts.even), (Places{{1, 1}, {3, 0}, {5, 2}}));
    EXPECT_EQ(places(parts.odd), (Places{{0, 0}, {2, 1}, {4, 2}}));
    EXPECT_EQ(places(joined.even), (Places{{1, 1}, {3, 0}, {5, 2}, {0, 0}, {2, 1}, {4, 2}}));
    EXPECT_TRUE(joined.odd.empty());
    EXPECT_EQ(components(layout), 6);
    EXPECT_EQ(scalar_components(layout), (std::vector<int>{0, 3}));
}

TEST(Spins, isotropic_equations_have_real_blocks_that_do_not_depend_on_the_angle_nor_join_even_and_odd_parts) {
    for (const Layout& layout : {all_kinds, chiral(all_kinds), hexatic}) {
        const SpinEquations equations = equations_of(layout);
        const BlockParts parts = block_parts(layout);
        std::vector<Part> all = parts.even;
        all.insert(all.end(), parts.odd.begin(), parts.odd.end());
        for (const double q : {0.0, 0.7, 9.0}) {
            double wrong = 0.0;
            const IsotropicBlocks blocks = equations.blocks(q, &wrong);
            EXPECT_LT(wrong, 4e-15) << q;
            for (const double theta : {0.3, 2.0, 3.9, 5.5}) {
                // The rotation of IsotropicBlocks, written with the angle.
                const auto count = static_cast<Eigen::Index>(all.size());
                MatrixXcd turn = MatrixXcd::Zero(count, count);
                int component = 0;
                for (const FieldKind& kind : layout.fields) {
                    const double angle = q > 0.0 ? kind.spin * theta : 0.0;
                    const Complex factor = std::pow(Complex(0.0, 1.0), q > 0.0 ? kind.spin : 0);
                    for (Eigen::Index k = 0; k < count; ++k) {
                        const int part = all[static_cast<std::size_t>(k)].component - component;
                        if (part < 0 || part >= components(kind)) continue;
                        turn(k, component) = factor * (part == 0 ? std::cos(angle) : -std::sin(angle));
                        if (kind.spin > 0)
                            turn(k, component + 1) = factor * (part == 0 ? std::sin(angle) : std::cos(angle));
                    }
                    component += components(kind);
                }
                const MatrixXcd turned =
                    turn * equations.matrix({q * std::cos(theta), q * std::sin(theta)}) * turn.adjoint();
                double difference = 0.0;
                for (int i = 0; i < count; ++i)
                    for (int k = 0; k < count; ++k) {
                        const int even = blocks.even.size;
                        const double expected = i < even && k < even     ? blocks.even(i, k)
                                                : i >= even && k >= even ? blocks.odd(i - even, k - even)
                                                                         : 0.0;
                        difference = std::max(difference, std::abs(turned(i, k) - expected));
                    }
                EXPECT_LT(difference, 8e-15) << q << " " << theta;  // rounding of some 20 operations on rates of 3
            }
        }
    }
}

TEST(Spins, a_linear_operator_is_the_equations_in_components_at_every_wavevector) {
    for (const Layout& layout : {all_kinds, chiral(all_kinds), many_fields, hexatic, scalars_and_vectors(2, 2),
                                 scalars_and_vectors(3, 0), Layout{.fields = {{.spin = 1}, {}}}}) {
        const SpinEquations equations = equations_of(layout);
        const LinearOperator linear(system_of(equations)), inverse = linear.shifted_inverse(0.2);
        const Spectra state = random_state(layout);
        Spectra rate(grid, components(layout)), solved = rate;
        linear.add(state, rate);
        inverse.add(state, solved);
        const auto expected = [&](const Wavevector& q, const VectorXcd& from) -> VectorXcd {
            return equations.matrix(q) * from;
        };
        const auto solution = [&](const Wavevector& q, const VectorXcd& from) -> VectorXcd {
            const MatrixXcd one = MatrixXcd::Identity(from.size(), from.size());
            return (one - 0.2 * equations.matrix(q)).partialPivLu().solve(from);
        };
        // Rounding of some 20 operations on rates of size 5.
        EXPECT_LT(largest_error(state, rate, expected), 2e-14) << components(layout);
        EXPECT_LT(largest_error(state, solved, solution), 2e-14) << components(layout);
    }
}

TEST(Spins, a_step_of_a_linear_system_is_the_matrix_exponential_of_its_equations_in_components) {
    Threads threads(1);
    for (const Layout& layout : {many_fields, chiral(many_fields), all_kinds, hexatic}) {
        const SpinEquations equations = equations_of(layout);
        Stepper stepper(system_of(equations), stepper_table("etdrk2"), 0.8, 1, threads);
        const Spectra before = random_state(layout);
        Spectra after = before;
        stepper.step(0.0, 0, after);
        const auto expected = [&](const Wavevector& q, const VectorXcd& from) -> VectorXcd {
            return exp_by_series(0.8 * equations.matrix(q)) * from;
        };
        EXPECT_LT(largest_error(before, after, expected), 1e-14) << components(layout);  // rounding
        // A real field stays real: the modes of q and -q in column 0 are conjugate to the bit.
        const auto rows = static_cast<std::size_t>(grid.ny);
        for (int c = 0; c < after.count(); ++c)
            for (std::size_t row = 1; row < rows; ++row)  // modes that are not kept are zero
                EXPECT_EQ(after[c][row * columns(grid)], std::conj(after[c][(rows - row) * columns(grid)]));
    }
}

/// The equations `linear` exactly, and `rest` as the nonlinear part.
System split_system(const SpinEquations& linear, const SpinEquations& rest) {
    System system = system_of(linear);
    system.nonlinear = [rest](double, const Spectra& state, Spectra& rate) {
        for_modes([&](std::size_t mode, const Wavevector& q) {
            const VectorXcd found = rest.matrix(q) * mode_of(state, mode);
            for (int c = 0; c < state.count(); ++c) rate[c][mode] = found(c);
        });
    };
    return system;
}

TEST(SpinsLong, every_stepper_follows_a_split_system_of_any_layout_with_its_own_error) {
    Threads threads(1);
    const double end = 0.5;
    for (const Layout& layout : {many_fields, chiral(hexatic)}) {
        const SpinEquations linear = equations_of(layout), rest(layout, -0.5, 0.05, largest_q, 2);
        const System system = split_system(linear, rest);
        const Spectra before = random_state(layout);
        const auto expected = [&](const Wavevector& q, const VectorXcd& from) -> VectorXcd {
            return exp_by_series(end * (linear.matrix(q) + rest.matrix(q))) * from;
        };
        // Of 10 steps of 0.05: powers of |rest| dt = 0.03 to the order of the method, with a margin.
        for (const auto& [name, error] :
             {std::pair{"exponential-euler", 0.1}, {"etdrk2", 5e-3}, {"etdrk4-krogstad", 1e-5}, {"etd-abm4", 1e-4}}) {
            Spectra after = before;
            Stepper stepper(system, stepper_table(name), 0.05, 1, threads);
            for (std::uint64_t step = 0; step < 10; ++step) stepper.step(0.05 * static_cast<double>(step), step, after);
            EXPECT_LT(largest_error(before, after, expected), error) << name;
        }
        for (const char* name : {"cvode-bdf", "arkode-ark436l2sa"}) {
            Spectra after = before;
            SundialsStepper stepper(system, time_method(name), end, 1e-8);
            stepper.advance(0, after);
            EXPECT_LT(largest_error(before, after, expected), 1e-5) << name;  // local errors of 1e-8, hundreds of steps
        }
    }
}

/// Mean of f f^H, f the samples of modes divided by the root of their covariance; and of f f^T.
struct Whitened {
    MatrixXcd hermitian, symmetric;
    double count = 0.0;
    void add(const MatrixXcd& covariance, const VectorXcd& mode) {
        const VectorXcd f = covariance.llt().matrixL().solve(mode);
        if (count == 0.0) hermitian = symmetric = MatrixXcd::Zero(f.size(), f.size());
        hermitian += f * f.adjoint();
        symmetric += f * f.transpose();
        count += 1.0;
    }
    void expect_standard() const {
        const MatrixXcd one = MatrixXcd::Identity(hermitian.rows(), hermitian.cols());
        // Five standard errors: each of some hundred entries exceeds them with probability exp(-25).
        const double error = 5.0 / std::sqrt(count);
        EXPECT_LT((hermitian / count - one).cwiseAbs().maxCoeff(), error);
        EXPECT_LT((symmetric / count).cwiseAbs().maxCoeff(), std::numbers::sqrt2 * error);
    }
};

/// Noise of the covariance a a^H, a the matrix of the equations `root`.
System noisy_system(const SpinEquations& equations, const SpinEquations& root) {
    System system = system_of(equations);
    system.noise = [root](double q) {
        const auto square = [](const Block& a) {
            Block result(a.size);
            for (int i = 0; i < a.size; ++i)
                for (int j = 0; j < a.size; ++j)
                    for (int k = 0; k < a.size; ++k) result(i, j) += a(i, k) * a(j, k);
            return result;
        };
        const IsotropicBlocks a = root.blocks(q);
        return IsotropicBlocks{square(a.even), square(a.odd)};
    };
    return system;
}

/// The modes whose conjugates are not stored, in directions of all quadrants.
template <class Body>
void for_sampled_modes(Body body) {
    for_modes([&](std::size_t mode, const Wavevector& q) {
        if (const std::size_t column = mode % columns(grid); column == 1 || column == 2) body(mode, q);
    });
}

TEST(SpinsStatistics, noise_of_any_layout_has_the_covariance_of_its_equations_in_components) {
    Threads threads(1);
    const double dt = 0.4;
    for (const Layout& layout : {many_fields, chiral(hexatic)}) {
        const SpinEquations equations = equations_of(layout), root(layout, 1.0, 0.6, largest_q, 5);
        const System system = noisy_system(equations, root);
        std::vector<MatrixXcd> of_step(modes(grid)), stationary(modes(grid));
        for_sampled_modes([&](std::size_t mode, const Wavevector& q) {
            const MatrixXcd m = equations.matrix(q), a = root.matrix(q);
            const auto count = m.rows();
            // By Simpson's rule with 33 points: an error of 1e-8.
            MatrixXcd covariance = MatrixXcd::Zero(count, count);
            const MatrixXcd part = exp_by_series(dt / 32.0 * m);
            MatrixXcd e = a;
            for (int k = 0; k <= 32; ++k, e = part * e)
                covariance += (k == 0 || k == 32 ? 1.0 : k % 2 == 1 ? 4.0 : 2.0) * dt / 96.0 * (e * e.adjoint());
            of_step[mode] = covariance / area(grid);
            // s = c(dt) + exp(m dt) s exp(m dt)^H, by doubling until exp has decayed.
            MatrixXcd propagator = exp_by_series(dt * m);
            for (; propagator.norm() > 1e-12; propagator = propagator * propagator)
                covariance += propagator * covariance * propagator.adjoint();
            stationary[mode] = covariance / area(grid);
        });
        Stepper stepper(system, stepper_table("etdrk2"), dt, 9, threads);
        Whitened steps, states;
        for (std::uint64_t n = 0; n < 400; ++n) {
            Spectra increment(grid, components(layout)), state = increment;
            stepper.step(0.0, n, increment);
            draw_stationary(system, {.seed = 4, .stream = Stream::stationary_state, .step = n}, state);
            for_sampled_modes([&](std::size_t mode, const Wavevector&) {
                steps.add(of_step[mode], mode_of(increment, mode));
                if (n < 40) states.add(stationary[mode], mode_of(state, mode));
            });
            if (n >= 40) continue;
            for (const Spectra* of : {&increment, &state})
                for (int c = 0; c < of->count(); ++c) {
                    EXPECT_EQ((*of)[c][0].imag(), 0.0);
                    for (std::size_t row = 1; row < 8; ++row)
                        EXPECT_EQ((*of)[c][row * columns(grid)], std::conj((*of)[c][(8 - row) * columns(grid)]));
                }
        }
        steps.expect_standard();
        states.expect_standard();
    }
}

TEST(Spins, the_kernel_of_any_layout_gives_the_bits_of_the_fixed_ones) {
    std::vector<double> numbers(400), matrix(100);
    fill_normal({.seed = 8, .stream = Stream::test}, 0, 1, numbers);
    fill_normal({.seed = 9, .stream = Stream::test}, 0, 1, matrix);
    std::vector<Complex> modes_of_fields(200);
    for (std::size_t k = 0; k < 200; ++k) modes_of_fields[k] = {numbers[2 * k], numbers[2 * k + 1]};
    const auto result = [&]<class Number>(const auto& kernel, const Direction& d, Number) {
        std::vector<Complex> out(modes_of_fields.size());
        auto sum = load_parts<Number>(kernel, numbers.data(), numbers.data() + 100);
        const auto frame = kernel.frame(d);
        EXPECT_EQ(add_blocks(kernel, matrix.data(), parts_of<Number>(kernel, {modes_of_fields.data(), 20, 7}, frame),
                             sum) -
                      matrix.data(),
                  static_cast<std::ptrdiff_t>(kernel.entries));
        write_parts(kernel, sum, modes_of_fields.data() + 3, {out.data(), 20, 7}, frame);
        return out;
    };
    for (int scalars = 0; scalars <= 2; ++scalars)
        for (int vectors = scalars == 0 ? 1 : 0; vectors <= 2; ++vectors) {
            const Layout layout = scalars_and_vectors(scalars, vectors);
            ASSERT_EQ(fixed_kernel(layout), 10 * scalars + vectors);
            for_layout(layout, [&](const auto& fixed) {
                for (const Direction& d : {Direction{}, Direction{0.6, 0.8, true}, Direction{0.28, -0.96, true}}) {
                    const AnyKernel any(layout);
                    EXPECT_EQ(result(fixed, d, Pair{}), result(any, d, Pair{})) << scalars << " " << vectors;
                    EXPECT_EQ(result(fixed, d, Quad{}), result(any, d, Quad{})) << scalars << " " << vectors;
                }
            });
        }
    for (const Layout& layout : {chiral(scalars_and_vectors(1, 1)), Layout{.fields = {{.spin = 1}, {}}},
                                 Layout{.fields = {{.odd = true}}}, scalars_and_vectors(3, 0), Layout{}})
        EXPECT_EQ(fixed_kernel(layout), layout.fields.empty() ? 0 : -1);
}

TEST(Spins, layouts_and_blocks_that_do_not_fit_are_input_errors) {
    const auto fault_of = [](auto body) {
        try {
            body();
        } catch (const Error& error) {
            return std::string(error.fault() == Fault::input ? "" : "a run Error: ") + error.what();
        }
        return std::string("no Error");
    };
    using testing::HasSubstr;
    EXPECT_THAT(fault_of([] { block_parts({}); }), HasSubstr("without fields; expected at least one"));
    EXPECT_THAT(fault_of([] { block_parts({.fields = {{.spin = -1}}}); }), HasSubstr("spin -1; expected 0 to 12"));
    EXPECT_THAT(fault_of([] { block_parts({.fields = {{.spin = 13}}}); }), HasSubstr("spin 13; expected 0 to 12"));
    EXPECT_EQ(block_parts(scalars_and_vectors(0, 24)).odd.size(), 24u);
    EXPECT_THAT(fault_of([] { block_parts(scalars_and_vectors(1, 24)); }), HasSubstr("25 rows; expected at most 24"));
    EXPECT_THAT(fault_of([] { block_parts(chiral(scalars_and_vectors(1, 12))); }), HasSubstr("25 rows"));
    System system = system_of(equations_of(many_fields));
    system.linear = [](double) { return IsotropicBlocks{Block(6), Block(3)}; };
    EXPECT_THAT(fault_of([&] { LinearOperator{system}; }),
                HasSubstr("blocks of 6 and 3 rows; expected 6 and 4, as its fields have"));
}

}  // namespace
}  // namespace drover::numerics::spins_tests
