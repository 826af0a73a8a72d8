// tests/numerics/shells.cpp: shells and sectors of q against the whole lattice, box windows against real space.
#include "numerics/fields/shells.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <utility>

#include "drover/base/error.hpp"
#include "drover/base/random.hpp"

namespace drover::numerics::shells_tests {
namespace {

const std::vector<Grid> grids{{.nx = 16, .ny = 16, .lx = 16.0, .ly = 16.0},
                              {.nx = 24, .ny = 16, .lx = 9.0, .ly = 10.0},  // cells that are not square
                              {.nx = 12, .ny = 30, .lx = 8.0, .ly = 5.0}};

std::vector<double> random_numbers(std::size_t size, std::uint64_t seed) {
    std::vector<double> numbers(size);
    fill_normal({.seed = seed, .stream = Stream::test}, 0, 1, numbers);
    return numbers;
}

/// |a_q|^2 of each stored mode, by the sum that defines it.
std::vector<double> powers_by_definition(const Grid& grid, const std::vector<double>& field) {
    std::vector<double> powers(modes(grid));
    for (std::size_t j = 0, mode = 0; j < static_cast<std::size_t>(grid.ny); ++j)
        for (std::size_t i = 0; i < columns(grid); ++i, ++mode) {
            Complex sum = 0.0;
            for (int y = 0; y < grid.ny; ++y)
                for (int x = 0; x < grid.nx; ++x)
                    sum += field[static_cast<std::size_t>(y * grid.nx + x)] *
                           std::polar(1.0, -2.0 * std::numbers::pi *
                                               (static_cast<double>(i) * x / grid.nx +
                                                static_cast<double>(j) * y / grid.ny));
            powers[mode] = std::norm(sum / static_cast<double>(points(grid)));
        }
    return powers;
}

/// The variance of the integral over a box, from all positions of the box.
double variance_by_positions(const Grid& grid, const std::vector<double>& field, int cells_x, int cells_y) {
    const double cell = area(grid) / static_cast<double>(points(grid));
    double sum = 0.0, squares = 0.0;
    for (int y0 = 0; y0 < grid.ny; ++y0)
        for (int x0 = 0; x0 < grid.nx; ++x0) {
            double inside = 0.0;
            for (int y = y0; y < y0 + cells_y; ++y)
                for (int x = x0; x < x0 + cells_x; ++x)
                    inside += cell * field[static_cast<std::size_t>((y % grid.ny) * grid.nx + x % grid.nx)];
            sum += inside;
            squares += inside * inside;
        }
    const auto count = static_cast<double>(points(grid));
    return squares / count - sum / count * (sum / count);
}

/// |q| in units of 2 pi/longest side.
double reduced_size(const Grid& grid, int kx, int ky) {
    const double longest = std::max(grid.lx, grid.ly);
    return std::hypot(kx * longest / grid.lx, ky * longest / grid.ly);
}

TEST(Shells, contain_every_mode_of_the_unbounded_lattice_and_no_further_shell_does) {
    for (const Grid& grid : grids)
        for (const int degree : {1, 2, 3}) {
            const Shells result = shells(grid, degree);
            ASSERT_GT(result.q.size(), 0u);
            std::vector<double> count(result.q.size()), sum(result.q.size());
            bool next_is_whole = true;
            for (int ky = -grid.ny; ky <= grid.ny; ++ky)
                for (int kx = -grid.nx; kx <= grid.nx; ++kx) {
                    const double size = reduced_size(grid, kx, ky);
                    if (size == 0.0) continue;
                    const auto n = static_cast<std::size_t>(size - 0.5);
                    const bool kept = std::abs(kx) * (degree + 1) < grid.nx && std::abs(ky) * (degree + 1) < grid.ny;
                    if (n < count.size()) {
                        EXPECT_TRUE(kept);
                        count[n] += 1.0;
                        sum[n] += size * 2.0 * std::numbers::pi / std::max(grid.lx, grid.ly);
                    }
                    if (n == count.size() && !kept) next_is_whole = false;
                }
            EXPECT_FALSE(next_is_whole);
            for (std::size_t n = 0; n < count.size(); ++n) {
                EXPECT_EQ(result.weight[n], count[n]);
                EXPECT_NEAR(result.q[n], sum[n] / count[n], 1e-12 * result.q[n]);  // rounding of about a hundred terms
            }
        }
}

TEST(Shells, the_mean_over_a_shell_weights_all_modes_of_the_plane_equally) {
    for (const Grid& grid : grids) {
        const Shells all = shells(grid, 1);
        const std::vector<double> values = random_numbers(modes(grid), 3);
        std::vector<double> sums(all.q.size());
        for (int ky = 1 - grid.ny / 2; ky < grid.ny / 2; ++ky)
            for (int kx = 1 - grid.nx / 2; kx < grid.nx / 2; ++kx) {
                const auto shell = static_cast<int>(std::floor(reduced_size(grid, kx, ky) - 0.5));
                if (shell < 0 || shell >= static_cast<int>(sums.size())) continue;
                const int row =
                    (kx < 0 ? -ky : ky) + grid.ny;  // a mode left of the half plane is stored as its mirror image
                sums[static_cast<std::size_t>(shell)] +=
                    values[static_cast<std::size_t>(row % grid.ny) * columns(grid) +
                           static_cast<std::size_t>(std::abs(kx))];
            }
        const std::vector<double> means = shell_means(grid, all, values);
        for (std::size_t n = 0; n < sums.size(); ++n)
            EXPECT_NEAR(means[n] * all.weight[n], sums[n], 1e-12 * all.weight[n]);  // rounding
    }
}

TEST(Shells, a_grid_too_small_for_a_complete_shell_has_none) {
    const Grid grid{.nx = 4, .ny = 4, .lx = 1.0, .ly = 1.0};
    const Shells none = shells(grid, 3);
    EXPECT_TRUE(none.q.empty());
    EXPECT_EQ(none.of_mode, std::vector<int>(modes(grid), -1));
}

TEST(Sectors, are_centred_on_x_and_y_and_rotate_with_q) {
    const Grid grid{.nx = 16, .ny = 16, .lx = 5.0, .ly = 5.0};
    for (const int count : {4, 8, 12}) {
        const Sectors result = sectors(grid, count);
        const auto at = [&](int kx, int ky) {
            if (kx < 0) kx = -kx, ky = -ky;
            const int row = (ky + grid.ny) % grid.ny;
            return result.of_mode[static_cast<std::size_t>(row) * columns(grid) + static_cast<std::size_t>(kx)];
        };
        EXPECT_EQ(at(0, 0), -1);
        EXPECT_EQ(at(3, 0), 0);
        EXPECT_EQ(at(0, 3), count / 2);
        EXPECT_EQ(at(0, -3), count / 2);
        EXPECT_EQ(at(4, 4), count / 4);
        EXPECT_EQ(at(4, -4), 3 * count / 4);
        EXPECT_EQ(at(7, -1),
                  count == 12 ? 11 : 0);  // 8.1 degrees below x: across the seam of [0, pi); 12: 7.5 degrees wide
        for (int kx = -7; kx <= 7; ++kx)
            for (int ky = -7; ky <= 7; ++ky) {
                if (kx == 0 && ky == 0) continue;
                EXPECT_EQ(at(-ky, kx), (at(kx, ky) + count / 2) % count) << kx << " " << ky;
            }
    }
}

TEST(Shells, of_a_line_hold_one_wave_each_whatever_its_other_side) {
    for (const double ly : {0.5, 16.0, 64.0}) {
        const Shells line = shells({.nx = 16, .ny = 1, .lx = 16.0, .ly = ly}, 1);
        ASSERT_EQ(line.q.size(), 7u);
        for (std::size_t n = 0; n < line.q.size(); ++n)
            EXPECT_DOUBLE_EQ(line.q[n], static_cast<double>(n + 1) * 2.0 * std::numbers::pi / 16.0);
    }
}

TEST(Sectors, their_means_add_up_to_the_mean_over_the_shell) {
    const Grid grid = grids[1];
    const Shells all = shells(grid, 1);
    const Sectors directions = sectors(grid, 8);
    const std::vector<double> values = random_numbers(modes(grid), 5), ones(modes(grid), 1.0);
    std::map<std::pair<int, int>, double> weight;
    for (std::size_t mode = 0; mode < modes(grid); ++mode)
        weight[{directions.of_mode[mode], all.of_mode[mode]}] += mode_weight(grid, mode % columns(grid));
    const std::vector<double> by_sector = sector_means(grid, all, directions, values);
    const std::vector<double> by_shell = shell_means(grid, all, values);
    int empty = 0;
    for (std::size_t n = 0; n < all.q.size(); ++n) {
        double sum = 0.0;
        for (int s = 0; s < 8; ++s) {
            const double mean = by_sector[static_cast<std::size_t>(s) * all.q.size() + n];
            const auto found = weight.find({s, static_cast<int>(n)});
            EXPECT_EQ(std::isnan(mean), found == weight.end());
            if (found == weight.end()) ++empty;
            else sum += found->second * mean;
        }
        EXPECT_NEAR(sum, all.weight[n] * by_shell[n], 1e-12 * all.weight[n]);  // rounding
    }
    EXPECT_GT(empty, 0);  // the first shell has fewer modes than sectors: the case occurs
}

TEST(BoxVariance, is_the_variance_over_all_positions_of_the_box_in_real_space) {
    for (const Grid& grid :
         {Grid{.nx = 12, .ny = 8, .lx = 3.0, .ly = 5.0}, Grid{.nx = 6, .ny = 10, .lx = 2.0, .ly = 2.0}}) {
        std::vector<double> field = random_numbers(points(grid), 7);
        for (double& value : field) value += 0.3;  // the mean must have no effect
        const std::vector<double> powers = powers_by_definition(grid, field);
        for (int cells_x = 1; cells_x <= grid.nx; ++cells_x)
            for (int cells_y = 1; cells_y <= grid.ny; ++cells_y)  // finally the entire cell: no variance
                EXPECT_NEAR(box_variance(grid, powers, cells_x, cells_y),
                            variance_by_positions(grid, field, cells_x, cells_y),
                            1e-12 * std::pow(area(grid), 2));  // rounding
    }
}

TEST(BoxVariance, of_one_cosine_wave_is_the_closed_form) {
    const Grid grid{.nx = 32, .ny = 16, .lx = 6.0, .ly = 4.0};
    std::vector<double> powers(modes(grid));
    powers[3 * columns(grid) + 2] = 0.25;  // cos(q.r), mode numbers (2, 3); its mirror image is not stored
    const double qx = 2.0 * 2.0 * std::numbers::pi / grid.lx, qy = 3.0 * 2.0 * std::numbers::pi / grid.ly;
    const double dx = grid.lx / grid.nx, dy = grid.ly / grid.ny;
    for (const int cells : {1, 3, 5, 8}) {
        const double amplitude = dx * std::sin(qx * cells * dx / 2.0) / std::sin(qx * dx / 2.0) * dy *
                                 std::sin(qy * cells * dy / 2.0) / std::sin(qy * dy / 2.0);
        EXPECT_NEAR(box_variance(grid, powers, cells, cells), amplitude * amplitude / 2.0, 1e-14);  // rounding
    }
}

TEST(BoxVariance, of_independent_cells_grows_as_the_area_of_the_box) {
    const Grid grid{.nx = 64, .ny = 64, .lx = 8.0, .ly = 8.0};
    std::vector<double> powers(modes(grid), 1.0);  // S(q) = area: a flat spectrum, less the mode q = 0 of the total
    for (const int cells : box_ladder(64)) {
        const double part = static_cast<double>(cells) * cells / 4096.0;
        // L^2 cells (1 - part) of variance 4096/area * (cell area)^2: the hypergeometric factor of a fixed total.
        EXPECT_NEAR(box_variance(grid, powers, cells, cells) / (64.0 * 64.0 * part * (1.0 - part)), 1.0,
                    1e-12);  // rounding
    }
}

TEST(BoxVariance, a_box_that_is_empty_or_larger_than_the_cell_is_rejected) {
    const Grid grid{.nx = 8, .ny = 4, .lx = 1.0, .ly = 1.0};
    const std::vector<double> powers(modes(grid));
    EXPECT_THROW(box_variance(grid, powers, 0, 1), Error);
    EXPECT_THROW(box_variance(grid, powers, 4, 5), Error);
}

TEST(BoxLadder, doubles_with_one_step_between_up_to_half_of_the_cell) {
    EXPECT_EQ(box_ladder(32), (std::vector{1, 2, 3, 4, 6, 8, 12, 16}));
    EXPECT_EQ(box_ladder(4), (std::vector{1, 2}));
    EXPECT_EQ(box_ladder(100), (std::vector{1, 2, 3, 4, 6, 8, 12, 16, 24, 32, 48}));
    EXPECT_EQ(box_ladder(256).back(), 128);
}

}  // namespace
}  // namespace drover::numerics::shells_tests
