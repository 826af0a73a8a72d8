// tests/dem/packing.cpp: packings have no overlaps, no order, and are as dense as they were asked to be.
#include "dem/packing/packing.hpp"

#include <gtest/gtest.h>

#include <cstring>
#include <numbers>
#include <set>

#include "dem/packing_support.hpp"

namespace drover::dem::packing_tests {
namespace {

using std::numbers::pi;

/// Packs, and looks at every pair, plate and wall.
Bodies packed(const dem::Setup& setup, std::uint64_t seed = 1) {
    const Bodies result = pack(setup, seed);
    EXPECT_LE(deepest(setup, result), 0.0);
    const double x = half_width(setup.cell), y = half_height(setup.cell);
    for (const Bead& bead : result.beads)
        EXPECT_TRUE(std::abs(bead.position.x) <= x && std::abs(bead.position.y) <= y && length(bead.velocity) == 0.0);
    for (const Rod& rod : result.rods) {
        EXPECT_TRUE(std::abs(rod.position.x) <= x && std::abs(rod.position.y) <= y && length(rod.velocity) == 0.0);
        EXPECT_NEAR(length(rod.axis), 1.0, 1e-14);
    }
    return result;
}

double covered(const Bodies& bodies, const Cell& cell) {
    double sum = 0.0;
    for (const Bead& bead : bodies.beads) sum += bodies.shapes[bead.shape].projected_area;
    for (const Rod& rod : bodies.rods) sum += bodies.shapes[rod.shape].projected_area;
    return sum / area(cell);
}

std::string rejection(const dem::Setup& setup, Fault fault) {
    try {
        static_cast<void>(pack(setup, 1));
    } catch (const Error& error) {
        EXPECT_EQ(error.fault(), fault) << error.what();
        return error.what();
    }
    return "accepted";
}

TEST(Packing, has_no_overlaps_at_every_density_of_the_experiment) {
    for (const auto& [beads, rods] : {std::pair{0.0, 0.05}, {0.2, 0.11}, {0.6, 0.11}, {0.7, 0.05}, {0.75, 0.08}}) {
        const auto setup = mixture(45.0, beads, rods);
        EXPECT_NEAR(covered(packed(setup), setup.cell), beads + rods, 0.002);  // one rod is 0.002 of this cell
    }
}

TEST(Packing, is_found_for_rods_too_dense_for_sequential_placement) {
    packed(mixture(30.0, 0.4, 0.35));
    packed(mixture(30.0, 0.0, 0.6));
}

TEST(Packing, fills_circle_flower_and_rectangle) {
    auto setup = mixture(40.0, 0.6, 0.11);
    setup.cell.ly = 25.0;
    for (const CellShape shape : {CellShape::rectangle, CellShape::circle, CellShape::flower}) {
        setup.cell.shape = shape;
        EXPECT_NEAR(covered(packed(setup), setup.cell), 0.71, 0.004) << name_of(shape);
    }
}

TEST(Packing, is_found_for_mixtures_of_beads_and_unequal_rods) {
    auto setup = mixture(40.0, 0.65, 0.08);
    setup.beads.diameters = {0.6, 0.7, 0.8, 0.9, 1.0};
    setup.beads.proportions = {1.0, 1.0, 1.0, 1.0, 1.0};
    setup.rods.size_tolerance = 0.02;
    const Bodies bodies = packed(setup);
    EXPECT_EQ(bodies.shapes.size(), 5 + bodies.rods.size());
}

TEST(Packing, is_found_for_beads_ten_times_smaller_than_others) {
    auto setup = mixture(12.0, 0.6, 0.0);
    setup.beads.diameters = {0.1, 1.0};
    setup.beads.proportions = {50.0, 1.0};
    EXPECT_GT(packed(setup).beads.size(), 1000U);
}

TEST(Packing, is_found_for_few_bodies_and_for_none) {
    EXPECT_TRUE(packed(dem::Setup{}).beads.empty());
    auto setup = mixture(3.0, 0.0, 0.0);
    setup.beads.count = 1;
    EXPECT_EQ(packed(setup).beads.size(), 1U);
    setup = mixture(10.0, 0.0, 0.0);
    setup.rods.count = 1;
    EXPECT_EQ(packed(setup).rods.size(), 1U);
}

TEST(Packing, of_a_rod_in_a_cell_of_its_length_avoids_overlap_with_its_images) {
    auto setup = mixture(4.5, 0.0, 0.0);
    setup.rods.count = 1;
    for (std::uint64_t seed = 0; seed < 200; ++seed) packed(setup, seed);
    setup.beads.count = 15;  // 0.57 of the area together
    for (std::uint64_t seed = 0; seed < 20; ++seed) packed(setup, seed);
}

TEST(Packing, uses_the_height_between_the_plates) {
    const Bodies bodies = packed(mixture(45.0, 0.6, 0.11));
    double low = 1e300, high = -1e300;
    for (const Bead& bead : bodies.beads) {
        low = std::min(low, bead.position.z);
        high = std::max(high, bead.position.z);
    }
    EXPECT_NEAR(low, 0.08 + 0.4, 0.01);
    EXPECT_NEAR(high, 0.08 + 0.8, 0.01);
}

TEST(Packing, is_found_in_a_gap_slightly_wider_than_a_rod_and_without_a_lid) {
    auto setup = mixture(30.0, 0.5, 0.1);
    setup.plates.gap = 1.1005;
    packed(setup);
    setup.plates.lid = false;
    setup.plates.gap = 0.5;  // of no meaning then
    packed(setup);
}

TEST(Packing, aligned_has_every_rod_exactly_along_x) {
    auto setup = mixture(45.0, 0.6, 0.11);
    setup.packing.kind = PackingKind::aligned;
    for (const Rod& rod : packed(setup).rods) EXPECT_TRUE(rod.axis.x == 1.0 && rod.axis.y == 0.0 && rod.axis.z == 0.0);
}

TEST(Packing, is_bitwise_equal_for_equal_seeds_and_differs_for_others) {
    const auto setup = mixture(20.0, 0.6, 0.11);
    const Bodies a = packed(setup, 7), b = packed(setup, 7), c = packed(setup, 8);
    EXPECT_EQ(std::memcmp(a.beads.data(), b.beads.data(), a.beads.size() * sizeof(Bead)), 0);
    EXPECT_EQ(std::memcmp(a.rods.data(), b.rods.data(), a.rods.size() * sizeof(Rod)), 0);
    EXPECT_NE(a.beads[0].position.x, c.beads[0].position.x);
    EXPECT_NE(a.rods[0].axis.x, c.rods[0].axis.x);
}

TEST(Packing, that_is_impossible_fails_with_the_remaining_overlap) {
    const std::string dense = rejection(mixture(20.0, 0.0, 0.95), Fault::run);
    EXPECT_NE(dense.find("no packing without overlaps was found for 0 beads and 92 rods: after "), std::string::npos)
        << dense;
    const std::string full = rejection(mixture(20.0, 0.8, 0.3), Fault::input);
    EXPECT_NE(full.find("expected no more than 1 together"), std::string::npos) << full;
    auto setup = mixture(20.0, 0.1, 0.1);
    setup.packing.kind = PackingKind::file;
    setup.packing.file = "start.h5";
    EXPECT_NE(rejection(setup, Fault::input).find("packing.kind = \"file\""), std::string::npos);
}

TEST(Packing, of_rods_that_do_not_fit_the_cell_is_rejected) {
    dem::Setup setup;
    setup.cell = {.shape = CellShape::rectangle,
                  .lx = 4.2,
                  .ly = 2.0};  // its diagonal is longer than a rod, which is too thick for it
    setup.rods.count = 1;
    EXPECT_NE(rejection(setup, Fault::run).find("overlap by"), std::string::npos);
}

/// Orders of many packings, and all angles.
struct Orders {
    double polar = 0.0, nematic = 0.0;  ///< means of N |order|^2: 1 for independent directions
    std::vector<double> bins;           ///< of angles
    double rods = 0.0;
};
Orders orders(const dem::Setup& setup, int seeds) {
    Orders result{.bins = std::vector<double>(16)};
    for (int seed = 0; seed < seeds; ++seed) {
        const Bodies bodies = pack(setup, static_cast<std::uint64_t>(seed));
        const auto count = static_cast<double>(bodies.rods.size());
        result.polar += count * std::norm(order(bodies, 1)) / seeds;
        result.nematic += count * std::norm(order(bodies, 2)) / seeds;
        for (const Rod& rod : bodies.rods)
            ++result.bins[static_cast<std::size_t>((std::atan2(rod.axis.y, rod.axis.x) / pi + 1.0) * 7.99999)];
        result.rods += count;
    }
    return result;
}
double chi_square(const Orders& orders) {
    double sum = 0.0;
    const double expected = orders.rods / static_cast<double>(orders.bins.size());
    for (const double bin : orders.bins) sum += (bin - expected) * (bin - expected) / expected;
    return sum;
}

TEST(PackingStatistics, directions_of_rods_are_independent) {
    // N|P|^2 of independent directions: mean 1, standard deviation 1 a packing: 0.063 of 250; 4 of these.
    for (const auto& [beads, rods] : {std::pair{0.6, 0.11}, {0.7, 0.05}}) {
        const Orders found = orders(mixture(30.0, beads, rods), 250);
        EXPECT_NEAR(found.polar, 1.0, 0.25);
        EXPECT_NEAR(found.nematic, 1.0, 0.25);
        EXPECT_LT(chi_square(found), 44.3);  // 15 degrees of freedom: once in 1e4
    }
}

TEST(PackingStatistics, positions_are_uniform_in_the_cell) {
    // Rods at (.60, .11), 24 a packing: counts of a quarter of the cell, their mean 6 over 200 seeds within 4 of
    // 2.1/sqrt(200).
    double quarters[4] = {};
    for (std::uint64_t seed = 0; seed < 200; ++seed)
        for (const Rod& rod : pack(mixture(30.0, 0.6, 0.11), seed).rods)
            ++quarters[(rod.position.x > 0.0 ? 1 : 0) + (rod.position.y > 0.0 ? 2 : 0)];
    for (const double quarter : quarters) EXPECT_NEAR(quarter / 200, 6.0, 0.6);
}

TEST(PackingSlow, of_the_paper_size_is_found) {
    const Bodies bodies = packed(mixture(247.95, 0.6, 0.11));
    EXPECT_EQ(bodies.beads.size(), 73385U);
    EXPECT_EQ(bodies.rods.size(), 1642U);
}

TEST(PackingSlow, directions_of_rods_are_independent_at_many_sizes_and_seeds) {
    for (const auto& [side, beads, rods] :
         {std::tuple{45.0, 0.6, 0.11}, {45.0, 0.7, 0.05}, {20.0, 0.6, 0.11}, {45.0, 0.2, 0.2}}) {
        const Orders found = orders(mixture(side, beads, rods), 900);
        EXPECT_NEAR(found.polar, 1.0, 0.14);  // 4 of 1/sqrt(900)
        EXPECT_NEAR(found.nematic, 1.0, 0.14);
        EXPECT_LT(chi_square(found), 44.3);
    }
}

}  // namespace
}  // namespace drover::dem::packing_tests
