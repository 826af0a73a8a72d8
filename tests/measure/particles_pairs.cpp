// tests/measure/particles_pairs.cpp: hexatic order, correlations, number fluctuations and the flow around a rod, where
// they are known.
#include <gtest/gtest.h>

#include "dem/neighbours/bins.hpp"
#include "measure/particles_support.hpp"

namespace drover::measure::particles_pairs_tests {
namespace {

/// Beads on a triangular lattice that fits a periodic cell; rows along x.
ParticleScene lattice(int columns, int rows, double spacing) {
    ParticleScene scene(dem::CellShape::periodic, columns * spacing, rows * spacing * std::sqrt(0.75));
    for (int j = 0; j < rows; ++j)
        for (int i = 0; i < columns; ++i) scene.add_bead((i + 0.5 * (j % 2)) * spacing, j * spacing * std::sqrt(0.75));
    return scene;
}

TEST(Bins, visit_each_point_within_reach_once) {
    for (const dem::CellShape shape : {dem::CellShape::periodic, dem::CellShape::rectangle})
        for (const double reach : {0.7, 3.0, 4.9}) {  // many squares, some, fewer than three along a side
            const ParticleScene scene = random_particles(3, 200, 0, shape, 14.0, 10.0);
            const std::vector<dem::Bead>& beads = scene.bodies.beads;
            dem::Bins bins(scene.setup.cell, reach);
            for (const dem::Bead& bead : beads) bins.add(bead.position);
            const dem::NearestImage nearest(scene.setup.cell);
            for (std::size_t i = 0; i < beads.size(); ++i) {
                std::vector<int> visits(beads.size());
                bins.for_near(beads[i].position, [&](std::size_t j) { ++visits[j]; });
                for (std::size_t j = 0; j < beads.size(); ++j) {
                    const dem::Vector d = nearest(beads[i].position, beads[j].position);
                    ASSERT_TRUE(visits[j] == 1 || (visits[j] == 0 && std::hypot(d.x, d.y) >= reach)) << i << " " << j;
                }
            }
        }
}

TEST(HexaticOrder, of_a_triangular_lattice_is_one) {
    const ParticleScene scene = lattice(20, 24, 0.85);
    EXPECT_NEAR(scene("hexatic_order"), 1.0, 1e-10);  // places near the edge, known to 1e-14, beside a spacing of 0.85
    EXPECT_NEAR(scene("hexatic_order_local"), 1.0, 1e-10);
    EXPECT_NEAR(scene("bead_neighbours"), 6.0, 1e-10);
}

TEST(HexaticOrder, of_a_square_lattice_is_zero) {
    ParticleScene scene(dem::CellShape::periodic, 17.0, 17.0);
    for (int j = 0; j < 20; ++j)
        for (int i = 0; i < 20; ++i) scene.add_bead(0.85 * i, 0.85 * j);
    EXPECT_NEAR(scene("bead_neighbours"), 4.0, 1e-10);      // the diagonals are 1.2 mm away, beyond 1.12
    EXPECT_NEAR(scene("hexatic_order_local"), 0.0, 1e-10);  // <exp(6 i angle)> over 0, 90, 180, 270 degrees
}

TEST(HexaticOrder, of_grains_rotated_by_thirty_degrees_is_only_local) {
    ParticleScene scene(dem::CellShape::circle);
    for (const double turn : {0.0, pi / 6.0})  // two hexagons far from each other
        for (int i = 0; i < 7; ++i)
            scene.add_bead((turn > 0.0 ? 10.0 : -10.0) + (i < 6 ? 0.85 * std::cos(turn + pi * i / 3.0) : 0.0),
                           i < 6 ? 0.85 * std::sin(turn + pi * i / 3.0) : 0.0);
    EXPECT_NEAR(scene("hexatic_order_local"), 1.0,
                1e-10);  // those of the rim too: their neighbours stand 60 degrees apart
    EXPECT_NEAR(scene("hexatic_order"), 0.0, 1e-10);
}

TEST(PairCorrelation, of_an_ideal_gas_is_one_within_errors) {
    // Pairs in a ring are Poisson to a good part: sum over scenes of g has the relative variance 2/(pairs counted
    // twice).
    const int scenes = 40;
    std::vector<double> beads, rods;
    ParticleSetting setting;
    for (int s = 0; s < scenes; ++s) {
        const ParticleScene scene =
            random_particles(100 + static_cast<std::uint64_t>(s), 1000, 200, dem::CellShape::periodic, 45.0, 30.0);
        setting = scene.setting();
        const std::vector<double> g = scene.all("pair_correlation_beads"), h = scene.all("pair_correlation_rods");
        beads.resize(g.size());
        rods.resize(h.size());
        for (std::size_t k = 0; k < g.size(); ++k) beads[k] += g[k] / scenes;
        for (std::size_t k = 0; k < h.size(); ++k) rods[k] += h[k] / scenes;
    }
    const auto chi_square = [&](const std::vector<double>& g, double number, double width) {
        double sum = 0.0;
        for (std::size_t k = 0; k < g.size(); ++k) {
            const double ring = pi * width * width * static_cast<double>(2 * k + 1);
            const double pairs = 0.5 * scenes * number * (number - 1.0) * ring / (45.0 * 30.0);
            sum += (g[k] - 1.0) * (g[k] - 1.0) * pairs;
        }
        return sum;
    };
    // Chi square of n degrees has mean n and variance 2 n (and a little more where few pairs are counted): within four
    // deviations.
    const auto n = static_cast<double>(beads.size()), m = static_cast<double>(rods.size());
    EXPECT_NEAR(chi_square(beads, 1000.0, setting.bead_separations.width), n, 4.0 * std::sqrt(2.0 * n));
    EXPECT_NEAR(chi_square(rods, 200.0, setting.rod_separations.width), m, 4.0 * std::sqrt(2.0 * m));
}

TEST(PairCorrelation, of_a_lattice_has_its_shells_and_coordination_numbers) {
    const ParticleScene scene = lattice(20, 24, 0.85);
    const ParticleSetting setting = scene.setting();
    const std::vector<double> g = scene.all("pair_correlation_beads");
    const double width = setting.bead_separations.width, density = 479.0 / (setting.cell.lx * setting.cell.ly);
    double first = 0.0, below = 0.0;
    for (std::size_t k = 0; k < g.size(); ++k) {
        const double r = (static_cast<double>(k) + 0.5) * width, others = g[k] * density * 2.0 * pi * r * width;
        if (r < 0.8) below += others;
        else if (r < 1.2) first += others;
    }
    EXPECT_EQ(below, 0.0);
    EXPECT_NEAR(first, 6.0, 1e-10);
}

TEST(PairCorrelation, around_a_subset_of_beads_is_that_around_all) {
    // 20,000 beads of a lattice, of which 8192 are centres: all are alike, so nothing may change.
    const ParticleScene few = lattice(20, 24, 0.85), many = lattice(160, 144, 0.85);
    const std::vector<double> a = few.all("pair_correlation_beads"), b = many.all("pair_correlation_beads");
    ASSERT_EQ(a.size(), b.size());
    const double other = (480.0 - 1.0) / 480.0 * 23040.0 / 23039.0;  // each is beside one body fewer than there are
    double sum_a = 0.0,
           sum_b = 0.0;  // up to 4 mm: a shell on the edge of a bin may fall to either side, not so the sum
    for (std::size_t k = 0; k < a.size(); ++k) {
        sum_a += a[k] * static_cast<double>(2 * k + 1) * other;
        sum_b += b[k] * static_cast<double>(2 * k + 1);
    }
    EXPECT_NEAR(sum_b, sum_a, 1e-9 * sum_a);
}

TEST(PolarCorrelation, of_a_flock_is_its_order_without_fluctuations) {
    ParticleScene scene = random_particles(8, 0, 60);
    for (dem::Rod& rod : scene.bodies.rods) rod.axis = {0.6, 0.8, 0.0};
    const std::vector<double> pairs = scene.all("rod_pairs"), order = scene.all("rod_pairs_order"),
                              excess = scene.all("rod_pairs_excess");
    for (std::size_t k = 0; k < pairs.size(); ++k) {
        EXPECT_NEAR(order[k], pairs[k], 1e-12);  // G_tot = 1; sums of some 60 numbers of order 1
        EXPECT_NEAR(excess[k], 0.0, 1e-12);
    }
}

TEST(PolarCorrelation, of_two_rods_is_in_the_bin_of_their_distance) {
    ParticleScene scene;
    scene.add_rod(-22.0, 0.0, 0.0);
    scene.add_rod(22.0, 0.0, pi / 3.0);  // 1 mm apart through the side
    const std::vector<double> pairs = scene.all("rod_pairs"), order = scene.all("rod_pairs_order");
    const auto bin = static_cast<std::size_t>(1.0 / scene.setting().rod_separations.width);
    for (std::size_t k = 0; k < pairs.size(); ++k) {
        EXPECT_NEAR(pairs[k], k == bin ? 1.0 : 0.0, 1e-12);
        EXPECT_NEAR(order[k], k == bin ? 0.5 : 0.0, 1e-12);  // cos 60 degrees
    }
}

TEST(PolarCorrelation, in_a_circle_is_that_of_the_local_frame) {
    ParticleScene scene(dem::CellShape::circle);
    for (int i = 0; i < 12; ++i)
        scene.add_rod(9.0 * std::cos(pi * i / 6.0), 9.0 * std::sin(pi * i / 6.0), pi * i / 6.0 + 0.8);
    const std::vector<double> pairs = scene.all("rod_pairs"), order = scene.all("rod_pairs_order");
    double total = 0.0;
    for (std::size_t k = 0; k < pairs.size(); ++k) {
        EXPECT_NEAR(order[k], pairs[k], 1e-12);  // a vortex is full order there
        total += pairs[k];
    }
    EXPECT_NEAR(total, 11.0, 1e-12);  // the largest distance, 18 mm, is within the bins
}

TEST(NumberFluctuations, of_bodies_at_random_are_binomial) {
    // Over all positions of a box, <DN^2> = N (1 - part) exactly for independent bodies.  Errors from the scenes
    // themselves.
    const int scenes = 200;
    for (const double ly : {45.0, 30.0}) {
        std::vector<double> sum, squares;
        ParticleSetting setting;
        for (int s = 0; s < scenes; ++s) {
            const ParticleScene scene =
                random_particles(300 + static_cast<std::uint64_t>(s), 0, 150, dem::CellShape::periodic, 45.0, ly);
            setting = scene.setting();
            const std::vector<double> variance = scene.all("rod_number_variance");
            sum.resize(variance.size());
            squares.resize(variance.size());
            for (std::size_t b = 0; b < variance.size(); ++b) {
                sum[b] += variance[b];
                squares[b] += variance[b] * variance[b];
            }
        }
        ASSERT_GE(sum.size(), 5u);
        for (std::size_t b = 0; b < sum.size(); ++b) {
            const double mean = sum[b] / scenes, error = std::sqrt((squares[b] / scenes - mean * mean) / (scenes - 1));
            const double expected = 150.0 * setting.fractions[b] * (1.0 - setting.fractions[b]);
            EXPECT_NEAR(mean, expected, 3.5 * error) << ly << " " << b;  // a dozen boxes: 3.5 deviations once in 200
            EXPECT_LT(error, 0.05 * expected);                           // and the test says something
        }
    }
}

TEST(NumberFluctuations, of_a_lattice_are_zero_in_commensurate_boxes) {
    ParticleScene scene(dem::CellShape::periodic, 48.0, 48.0);
    for (int i = 0; i < 576; ++i) scene.add_rod(2.0 * (i % 24) + 0.5, 2.0 * (i / 24) + 0.5, 0.0);
    const ParticleSetting setting = scene.setting();
    const std::vector<double> variance = scene.all("rod_number_variance"), sides = scene.axis("rod_number_variance");
    for (std::size_t b = 0; b < variance.size(); ++b)
        if (setting.boxes[b] % 2 == 0)
            EXPECT_NEAR(variance[b], 0.0, 1e-20) << sides[b];  // exact: a whole number of spacings
        else EXPECT_GT(variance[b], 0.1) << sides[b];
}

TEST(RodFlow, of_a_known_field_is_found_in_the_frame_of_each_rod) {
    // Beads on a fine mesh; each rod is alone with a field that is, in its own frame, that of a dipole with a finite
    // core.
    const double angle = 0.9, c = std::cos(angle), s = std::sin(angle);
    const auto field = [](double a, double b) {
        const double r = a * a + b * b + 4.0;
        return std::pair{40.0 * (1.0 / r + 2.0 * a * a / (r * r)), 80.0 * a * b / (r * r)};
    };
    ParticleScene scene(dem::CellShape::periodic, 33.0, 33.0);
    scene.add_rod(15.0, -14.0, angle);  // across the sides
    for (int j = 0; j < 220; ++j)
        for (int i = 0; i < 220; ++i) {
            const double x = 0.15 * i - 16.5, y = 0.15 * j - 16.5;
            const double dx = std::remainder(x - 15.0, 33.0), dy = std::remainder(y + 14.0, 33.0);
            const auto [along, across] = field(c * dx + s * dy, c * dy - s * dx);
            scene.add_bead(x, y, c * along - s * across, s * along + c * across);
        }
    const std::vector<double> density = scene.all("flow_density"), flux_along = scene.all("flow_flux_along"),
                              flux_across = scene.all("flow_flux_across"), places = scene.axis("flow_density");
    ASSERT_EQ(places.size(), 21u);
    EXPECT_EQ(places[10], 0.0);
    double total = 0.0;
    for (std::size_t i = 0; i < 21; ++i)
        for (std::size_t k = 0; k < 21; ++k) {
            const auto [along, across] = field(places[i], places[k]);
            const std::size_t at = i * 21 + k;
            total += density[at] / (21.0 * 21.0);
            // The mean over a cell of 1.07 mm differs from its middle by width^2/24 of the Laplacian, some 20 at the
            // core: 1; that of the beads in it, 0.15 mm apart, by less.  The field is 10 there and changes by as much
            // over the mesh.
            EXPECT_NEAR(flux_along[at] / density[at], along, 0.8) << i << " " << k;
            EXPECT_NEAR(flux_across[at] / density[at], across, 0.8) << i << " " << k;
        }
    EXPECT_NEAR(total, 1.0 / (0.15 * 0.15),
                0.3);  // one bead in so much, to those on the rim of a square of 22.5 mm: 1 in 150
    EXPECT_GT(flux_along[10 * 21 + 10] / density[10 * 21 + 10], 5.0);
    EXPECT_LT(flux_across[15 * 21 + 5], -0.5 * density[15 * 21 + 5]);  // ahead and to the right: towards the right
}

TEST(RodFlow, of_beads_that_move_with_the_rod_is_along_n_everywhere) {
    ParticleScene scene(dem::CellShape::periodic, 60.0, 60.0);
    scene.add_rod(0.0, 0.0, 2.5);
    const std::vector<double> u = uniform_numbers(20000, 4);
    for (std::size_t i = 0; i < u.size(); i += 2)
        scene.add_bead(60.0 * u[i], 60.0 * u[i + 1], 3.0 * std::cos(2.5), 3.0 * std::sin(2.5));
    const std::vector<double> density = scene.all("flow_density"), along = scene.all("flow_flux_along"),
                              across = scene.all("flow_flux_across");
    double total = 0.0;
    for (std::size_t k = 0; k < density.size(); ++k) {
        EXPECT_NEAR(along[k], 3.0 * density[k], 1e-11 * (1.0 + density[k]));
        EXPECT_NEAR(across[k], 0.0, 1e-11);
        total += density[k] / static_cast<double>(density.size());
    }
    // 10,000 beads in 3600 mm^2; the square of 22.5 mm holds 1406 of them, give or take 35: three of these.
    EXPECT_NEAR(total, 10000.0 / 3600.0, 3.0 * 35.0 / (22.5 * 22.5));
}

}  // namespace
}  // namespace drover::measure::particles_pairs_tests
