// tests/numerics/transform.cpp: transforms against their definition, and the dealiasing of each axis.
#include "drover/numerics/transform.hpp"

#include <fftw3.h>
#include <gtest/gtest.h>

#include <array>
#include <atomic>
#include <cmath>
#include <numbers>
#include <thread>

#include "drover/base/error.hpp"
#include "drover/base/random.hpp"

namespace drover::numerics::transform_tests {
namespace {

Fields random_fields(const Grid& grid, int count) {
    Fields fields(grid, count);
    fill_normal({.seed = 5, .stream = Stream::test}, 0, 1, fields.values);
    return fields;
}

/// a_q = mean of a(r) exp(-i q.r), summed directly.
Complex coefficient(const Grid& grid, std::span<const double> values, int kx, int ky) {
    Complex sum = 0.0;
    for (int j = 0; j < grid.ny; ++j)
        for (int i = 0; i < grid.nx; ++i) {
            const double angle = -2.0 * std::numbers::pi * (double(kx) * i / grid.nx + double(ky) * j / grid.ny);
            sum += values[static_cast<std::size_t>(j * grid.nx + i)] * std::polar(1.0, angle);
        }
    return sum / static_cast<double>(points(grid));
}

TEST(Transform, the_coefficients_are_those_of_the_definition_on_any_even_grid) {
    Threads threads(1);
    for (const Grid grid : {Grid{4, 4, 1, 1}, Grid{6, 10, 2, 1}, Grid{16, 12, 1, 3}, Grid{20, 34, 1, 1}})
        for (const int degree : {1, 2, 3}) {
            const Fields fields = random_fields(grid, 2);
            Spectra spectra(grid, 2);
            Transform(grid, degree, threads).forward(fields, spectra);
            for (int c = 0; c < 2; ++c)
                for (std::size_t j = 0; j < static_cast<std::size_t>(grid.ny); ++j)
                    for (std::size_t i = 0; i < columns(grid); ++i) {
                        const Complex found = spectra[c][j * columns(grid) + i];
                        const Complex expected =
                            is_kept(grid, degree, i, j)
                                ? coefficient(grid, fields[c], static_cast<int>(i), mode_number_y(grid, j))
                                : Complex(0.0);
                        // Rounding of a sum of at most 680 numbers of size 1, divided by as many.
                        EXPECT_NEAR(std::abs(found - expected), 0.0, 1e-14)
                            << grid.nx << "x" << grid.ny << " mode " << i << "," << j;
                    }
        }
}

TEST(Transform, backward_inverts_forward_for_fields_of_kept_modes) {
    for (const int team : {1, 2, 3}) {
        Threads threads(team);
        const Grid grid{24, 18, 1, 1};
        const Transform transform(grid, 2, threads);
        Spectra spectra(grid, 3), again(grid, 3);
        Fields fields(grid, 3);
        transform.forward(random_fields(grid, 3), spectra);
        transform.backward(spectra, fields);
        transform.forward(fields, again);
        for (std::size_t m = 0; m < spectra.values.size(); ++m)
            EXPECT_NEAR(std::abs(again.values[m] - spectra.values[m]), 0.0, 1e-15);
    }
}

// Lines beyond the second-level cache are transformed in two passes.
TEST(Transform, long_lines_have_the_coefficients_of_the_definition_and_are_inverted) {
    Threads threads(2);
    for (const Grid grid : {Grid{16384, 1, 1, 1}, Grid{12288, 1, 1, 1}, Grid{4, 8192, 1, 1}})
        for (const int degree : {1, 2}) {
            const Transform transform(grid, degree, threads);
            const Fields fields = random_fields(grid, 3);  // a pair and one alone
            Spectra spectra(grid, 3), again(grid, 3);
            Fields kept(grid, 3);
            transform.forward(fields, spectra);
            transform.backward(spectra, kept);
            transform.forward(kept, again);
            for (const int k : {0, 1, 777, 2500}) {
                const int kx = grid.ny == 1 ? k : 1, ky = grid.ny == 1 ? 0 : k;
                for (int c = 0; c < 3; ++c) {
                    const Complex found =
                        spectra[c][static_cast<std::size_t>(ky) * columns(grid) + static_cast<std::size_t>(kx)];
                    // Rounding of a direct sum of 16384 numbers of size 1, divided by as many.
                    EXPECT_NEAR(std::abs(found - coefficient(grid, fields[c], kx, ky)), 0.0, 1e-14)
                        << grid.nx << " " << k;
                }
            }
            double largest = 0.0;
            for (std::size_t m = 0; m < spectra.values.size(); ++m)
                largest = std::max(largest, std::abs(again.values[m] - spectra.values[m]));
            EXPECT_LT(largest, 1e-15);  // of coefficients of size 1e-2
        }
}

TEST(Transform, modes_that_are_not_kept_count_as_zero_and_the_input_is_unchanged) {
    Threads threads(1);
    const Grid grid{16, 16, 1, 1};
    const Transform transform(grid, 2, threads);
    Spectra spectra(grid, 1);
    Fields fields(grid, 1);
    // One mode beyond the cut on each axis, and the Nyquist mode; the cut is at |k| < 16/3.
    for (const auto& [column, row] : {std::pair{6, 0}, std::pair{0, 6}, std::pair{8, 0}, std::pair{0, 8}}) {
        spectra.values.assign(spectra.values.size(), Complex(0.0));
        spectra[0][static_cast<std::size_t>(row) * columns(grid) + static_cast<std::size_t>(column)] = 1.0;
        const Spectra before = spectra;
        transform.backward(spectra, fields);
        EXPECT_EQ(spectra.values, before.values);
        for (const double value : fields.values) EXPECT_EQ(value, 0.0);
        Spectra again(grid, 1);
        transform.forward(fields, again);
        for (const Complex value : again.values) EXPECT_EQ(std::abs(value), 0.0);
    }
}

TEST(Transform, the_bytes_do_not_depend_on_the_number_of_threads) {
    const Grid grid{36, 50, 1, 1};
    const Fields fields = random_fields(grid, 4);
    Threads one(1);
    Spectra expected(grid, 4);
    Fields back(grid, 4);
    Transform(grid, 2, one).forward(fields, expected);
    Transform(grid, 2, one).backward(expected, back);
    for (const int team : {2, 3, 5}) {
        Threads threads(team);
        Spectra found(grid, 4);
        Fields again(grid, 4);
        Transform(grid, 2, threads).forward(fields, found);
        Transform(grid, 2, threads).backward(found, again);
        EXPECT_EQ(found.values, expected.values);
        EXPECT_EQ(again.values, back.values);
    }
}

// One mode near the cut on one axis, squared and cubed: the product on the grid must be the exact convolution in the
// kept modes.  For cos(k x)^2 = 1/2 + cos(2 k x)/2: with the modes |k| < N/3 kept, 2 k aliases to N - 2 k > N/3, which
// is cut.
TEST(Transform, a_product_of_its_degree_has_no_alias_on_either_axis) {
    Threads threads(1);
    for (const int degree : {2, 3})
        for (const bool along_x : {true, false}) {
            const Grid grid = along_x ? Grid{32, 8, 1, 1} : Grid{8, 32, 1, 1};
            const Transform transform(grid, degree, threads);
            const int k = (32 - 1) / (degree + 1);  // the last kept mode
            Fields fields(grid, 1);
            for (int j = 0; j < grid.ny; ++j)
                for (int i = 0; i < grid.nx; ++i)
                    fields[0][static_cast<std::size_t>(j * grid.nx + i)] =
                        std::pow(std::cos(2.0 * std::numbers::pi * k * (along_x ? i : j) / 32.0), degree);
            Spectra spectra(grid, 1);
            transform.forward(fields, spectra);
            for (std::size_t j = 0; j < static_cast<std::size_t>(grid.ny); ++j)
                for (std::size_t i = 0; i < columns(grid); ++i) {
                    const int mode = along_x ? static_cast<int>(i) : mode_number_y(grid, j);
                    const bool on_axis = along_x ? j == 0 : i == 0;
                    double expected = 0.0;  // the kept part of cos^2 is 1/2, of cos^3 is 3/4 cos
                    if (on_axis && degree == 2 && mode == 0) expected = 0.5;
                    if (on_axis && degree == 3 && std::abs(mode) == k) expected = 3.0 / 8.0;
                    EXPECT_NEAR(std::abs(spectra[0][j * columns(grid) + i] - expected), 0.0, 1e-15)
                        << "degree " << degree << (along_x ? " x" : " y") << " mode " << mode;
                }
        }
}

// The same through products(): one mode at the cut, of each axis in turn, to the power of the degree, against the
// convolution of its coefficients; the field beside it in the pair must not leak.
TEST(Transform, products_of_a_mode_at_the_cut_of_either_axis_are_the_exact_convolution) {
    Threads threads(2);
    const Grid grid{24, 20, 1, 1};
    for (const int degree : {2, 3})
        for (const bool along_x : {true, false}) {
            const int n = along_x ? grid.nx : grid.ny;
            const int k = (n - 1) / (degree + 1);  // the largest kept: (degree + 1) k < n
            const Transform transform(grid, degree, threads);
            Spectra from(grid, 2), to(grid, 2);
            const auto place = [&](int number) {
                return along_x ? static_cast<std::size_t>(number)
                               : static_cast<std::size_t>((number + grid.ny) % grid.ny) * columns(grid);
            };
            // a = 2 cos(k x + 1): coefficients e^i at k and e^-i at -k; the other field is 3.
            from[0][place(k)] = std::polar(1.0, 1.0);
            if (!along_x) from[0][place(-k)] = std::polar(1.0, -1.0);
            from[1][0] = 3.0;
            const std::array<const Complex*, 2> sources{from[0].data(), from[1].data()};
            const std::array<Complex*, 2> made{to[0].data(), to[1].data()};
            transform.products(sources, made, [&](const Strip& strip) {
                for (std::size_t i = 0; i < strip.size; ++i) {
                    strip.out[0][i] = degree == 2 ? strip.in[0][i] * strip.in[0][i]
                                                  : strip.in[0][i] * strip.in[0][i] * strip.in[0][i];
                    strip.out[1][i] = strip.in[1][i];
                }
            });
            // (e^i z + e^-i/z)^2 = 2 + (2 k beyond the cut); ^3 = 3 (e^i z + e^-i/z) + (3 k beyond it).
            for (std::size_t m = 0; m < to.size; ++m) {
                Complex expected = degree == 2 && m == 0 ? 2.0 : 0.0;
                if (degree == 3 && m == place(k)) expected = 3.0 * std::polar(1.0, 1.0);
                if (degree == 3 && !along_x && m == place(-k)) expected = 3.0 * std::polar(1.0, -1.0);
                EXPECT_NEAR(std::abs(to[0][m] - expected), 0.0, 1e-14) << degree << (along_x ? " x " : " y ") << m;
                EXPECT_NEAR(std::abs(to[1][m] - (m == 0 ? 3.0 : 0.0)), 0.0, 1e-14)
                    << degree << (along_x ? " x " : " y ") << m;
            }
        }
}

TEST(Transform, the_bytes_of_products_do_not_depend_on_the_number_of_threads_for_odd_numbers_of_fields) {
    const Grid grid{36, 50, 1, 1};
    const auto run = [&](int team) {
        Threads threads(team);
        const Transform transform(grid, 2, threads);
        Spectra from(grid, 3), to(grid, 1);
        transform.forward(random_fields(grid, 3), from);
        const std::array<const Complex*, 3> sources{from[0].data(), from[1].data(), from[2].data()};
        const std::array<Complex*, 1> made{to[0].data()};
        transform.products(sources, made, [](const Strip& strip) {
            for (std::size_t i = 0; i < strip.size; ++i)
                strip.out[0][i] = strip.in[0][i] * strip.in[1][i] + strip.in[2][i];
        });
        return to.values;
    };
    const std::vector<Complex> expected = run(1);
    for (const int team : {2, 3, 5}) EXPECT_EQ(run(team), expected);
}

// Arrays of very different size in one call, as a dilute tracer beside a dense bed, or high derivatives beside fields:
// each has the digits it has alone, and the bytes are those of a new transform whatever was transformed before.
TEST(Transform, arrays_of_very_different_size_keep_their_own_digits) {
    const Grid grid{36, 50, 1, 1};
    Threads threads(2);
    Fields random = random_fields(grid, 5);
    const Transform transform(grid, 2, threads);
    Spectra from(grid, 5);
    transform.forward(random, from);
    const std::array<double, 5> sizes{1.0, 1e-12, 1e-25, 3.0, 1e-13};
    const auto squares = [&](const Transform& by, const Spectra& state) {
        Spectra to(grid, 5);
        std::vector<const Complex*> sources;
        std::vector<Complex*> made;
        for (int c = 0; c < 5; ++c) sources.push_back(state[c].data());
        for (int c = 0; c < 5; ++c) made.push_back(to[c].data());
        by.products(sources, made, [&](const Strip& strip) {
            for (std::size_t c = 0; c < 5; ++c)
                for (std::size_t i = 0; i < strip.size; ++i) strip.out[c][i] = strip.in[c][i] * strip.in[c][i];
        });
        return to;
    };
    const Spectra expected = squares(transform, from);
    Spectra scaled = from;
    Fields values(grid, 5), scaled_values(grid, 5);
    Spectra again(grid, 5);
    for (int c = 0; c < 5; ++c)
        for (Complex& mode : scaled[c]) mode *= sizes[static_cast<std::size_t>(c)];
    transform.backward(from, values);
    transform.backward(scaled, scaled_values);
    transform.forward(scaled_values, again);
    const Spectra found = squares(transform, scaled);
    for (int c = 0; c < 5; ++c) {
        const double size = sizes[static_cast<std::size_t>(c)];
        for (std::size_t m = 0; m < from.size; ++m) {
            // Modes of random fields are of size 1/42: rounding of 1800 numbers, as above.
            EXPECT_NEAR(std::abs(found[c][m] / (size * size) - expected[c][m]), 0.0, 1e-15) << c;
            EXPECT_NEAR(std::abs(again[c][m] / size - from[c][m]), 0.0, 1e-15) << c;
        }
        for (std::size_t i = 0; i < values.size; ++i) EXPECT_NEAR(scaled_values[c][i] / size, values[c][i], 1e-14) << c;
    }
    EXPECT_EQ(squares(transform, from).values, expected.values);
    EXPECT_EQ(squares(Transform(grid, 2, threads), scaled).values, found.values);
}

TEST(Transform, an_invalid_grid_is_rejected) {
    Threads threads(1);
    for (const Grid grid : {Grid{2, 8, 1, 1}, Grid{7, 8, 1, 1}, Grid{8, 8, 0, 1}, Grid{8, 8, 1, -1}})
        EXPECT_ANY_THROW(Transform(grid, 1, threads));
}

// What one thread frees of FFTW's memory is looked up while others plan: a block that they free must not be read.
TEST(TransformLong, may_be_made_while_other_threads_free_memory_of_fftw) {
    std::atomic<bool> stops = false;
    std::vector<std::thread> threads;
    for (int thread = 0; thread < 3; ++thread)
        threads.emplace_back([&stops] {
            while (!stops) fftw_free(fftw_malloc(64));
        });
    Threads one(1);
    for (int k = 0; k < 2000; ++k) {
        const Grid grid{.nx = 16 + 2 * (k % 5), .ny = 16, .lx = 1.0, .ly = 1.0};
        const Fields fields = random_fields(grid, 1);
        Spectra spectra(grid, 1);
        Transform(grid, 1, one).forward(fields, spectra);
        double sum = 0.0;
        for (const double value : fields.values) sum += value;
        EXPECT_NEAR(spectra[0][0].real(), sum / static_cast<double>(points(grid)), 1e-14);  // rounding
    }
    stops = true;
    for (std::thread& thread : threads) thread.join();
}

TEST(Transform, rejects_arrays_of_another_grid_or_number_of_components) {
    Threads threads(1);
    const Grid grid{8, 6, 1, 1}, other{8, 8, 1, 1};
    const Transform transform(grid, 1, threads);
    Fields fields(grid, 2), large(other, 2), none;
    Spectra spectra(grid, 2), wide(other, 2), one(grid, 1);
    EXPECT_THROW(transform.forward(large, spectra), Error);
    EXPECT_THROW(transform.forward(none, spectra), Error);
    EXPECT_THROW(transform.forward(fields, wide), Error);
    EXPECT_THROW(transform.forward(fields, one), Error);
    EXPECT_THROW(transform.backward(wide, fields), Error);
    EXPECT_THROW(transform.backward(spectra, large), Error);
}

}  // namespace
}  // namespace drover::numerics::transform_tests
