// tests/physics/transverse.cpp: order across its own gradient, (0, p_y(x)): standing kinks, and fronts that invade
// disorder.
#include <gtest/gtest.h>

#include <cmath>

#include "kink_model.hpp"

namespace drover::physics::transverse_tests {
namespace {

constexpr int rows = 8;  // nothing depends on y, but may: one pair of modes along y is kept at least

/// The largest rate of any component in any cell.
double residual(int n, const Sector& sector) {
    const KinkLattice lattice(sector);
    Evolution run(sector.model, {n, rows, lattice.period, 3.0});
    const numerics::Spectra start = run.spectra(sector.fields([&](double x, double) { return lattice(x); }));
    return largest_difference(run.fields(run.whole(0.0, start)), numerics::Fields(run.grid, start.count()));
}

TEST(TransverseSector, rate_of_a_kink_lattice_falls_spectrally_with_the_resolution) {
    const Sector sector;
    // Modes |k| < n/5 are kept of a series that falls as 0.37^k: 0.37^7 = 1e-3, 0.37^13 = 2e-6, 0.37^27 = 2e-12.
    const double coarse = residual(32, sector), middle = residual(64, sector), fine = residual(128, sector),
                 finest = residual(256, sector);
    EXPECT_LT(coarse, 0.01);
    EXPECT_GT(coarse / middle, 100.0) << coarse << ", " << middle;
    EXPECT_GT(middle / fine, 10.0 * coarse / middle) << coarse << ", " << middle << ", " << fine;
    EXPECT_LT(fine, 1e-10);
    // Rounding: 1e-16 of coefficients of order one, times K3 q^2 = 0.35 (51 * 2 pi/12)^2 = 250 of the last mode kept,
    // for some ten coefficients that count.
    EXPECT_LT(finest, 3e-13);
}

TEST(TransverseSector, kink_lattice_is_stationary_in_a_fluid_with_every_term_but_viscosity) {
    const Sector sector;
    const KinkLattice lattice(sector);
    Evolution run(sector.model, {128, rows, lattice.period, 3.0});
    const std::vector<FieldFunction> exact = sector.fields([&](double x, double) { return lattice(x); });
    numerics::Spectra state = run.spectra(exact);
    run.advance(state, "etdrk4", 0.05, 240);
    // Six relaxation times 1/|abar|.  The start errs by the modes that are left out, 2e-12 of it; neighbouring kinks
    // attract, which grows slower than |abar|: e^6 = 400 times.
    EXPECT_LT(largest_difference(run.fields(state), run.sampled(exact)), 1e-9);
}

TEST(TransverseSector, kink_of_tanh_is_stationary_between_two_halves_of_opposite_order) {
    const Sector sector;
    const double sharpness = std::sqrt(kink_growth / (2.0 * sector.stiffness)), side = 64.0;
    // A kink at 16 and an antikink at 48: tails of e^(-2 sharpness 32) = 1e-23 of one at the other.
    const FieldFunction pair = [&](double x, double) {
        return sector.saturated() * (x < 32.0 ? std::tanh(sharpness * (x - 16.0)) : std::tanh(sharpness * (48.0 - x)));
    };
    Evolution run(sector.model, {768, rows, side, 3.0});
    numerics::Spectra state = run.spectra(sector.fields(pair));
    run.advance(state, "etdrk4", 0.05, 240);
    // At the edges of the halves the formula has a kink of its own, of e^(-2 sharpness 16) = 2e-12, which grows by e^6
    // at the most.
    // Modes are kept up to 153 * 2 pi/64 = 15 /mm, where the series has fallen to e^(-pi q/(2 sharpness)) = 8e-13.
    EXPECT_LT(largest_difference(run.fields(state), run.sampled(sector.fields(pair))), 1e-10);
}

TEST(TransverseSector, front_of_order_invades_disorder_with_its_exact_speed_and_profile) {
    Sector sector;
    sector.model.fields.bead_velocity = "slaved";
    sector.model.inertia.advection = false;
    const double sharpness = std::sqrt(kink_growth / (2.0 * sector.stiffness)),
                 speed = 3.0 * std::sqrt(kink_growth * sector.stiffness / 2.0), side = 80.0, half_width = 16.0;
    // Order between two fronts that part, each cell of the period with its own pair: their sum solves the equation up
    // to the tail of one front at another, e^(-sharpness distance) with distances of 32 mm at first and of 80 - 2 *
    // 23.1 mm at the end: 2e-12.
    const auto pairs = [&](double x, double t) {
        const auto front = [&](double z) { return 1.0 / (1.0 + std::exp(sharpness * z)); };
        const double reach = half_width + speed * t;
        double sum = 0.0;
        for (int image = -2; image <= 2; ++image) {
            const double from_middle = x - side / 2.0 + image * side;
            sum += front(from_middle - reach) + front(-from_middle - reach) - 1.0;
        }
        return sector.saturated() * sum;
    };
    const auto at = [&](double t) { return sector.fields([&, t](double x, double) { return pairs(x, t); }); };
    Evolution run(sector.model, {640, rows, side, 3.0});
    numerics::Spectra state = run.spectra(at(0.0));
    const double dt = 0.02, end = 8.0;
    run.advance(state, "etdrk4", dt, static_cast<int>(std::lround(end / dt)));
    const numerics::Fields found = run.fields(state), exact = run.sampled(at(end));
    // Ahead of the fronts rounding and the tails grow by e^(|abar| t) = 55: 1e-10; the method leaves (rate dt)^4/120
    // with rates of 2 |abar| = 1: 1e-9.
    EXPECT_LT(largest_difference(found, exact), 3e-9);
    // The speed, from where the front stands at the end: at the cell nearest to it, ln(p0/p - 1) = sharpness (x - c t).
    const int component = run.form.polar_order + 1;
    std::size_t nearest = 0;
    for (std::size_t i = 0; i < static_cast<std::size_t>(run.grid.nx); ++i)
        if (run.x(i) > side / 2.0 && std::abs(found[component][i] - 0.5 * sector.saturated()) <
                                         std::abs(found[component][nearest] - 0.5 * sector.saturated()))
            nearest = i;
    const double stands =
        run.x(nearest) - std::log(sector.saturated() / found[component][nearest] - 1.0) / sharpness - side / 2.0;
    // 3e-9 of the order over its slope p0 sharpness/4, over the time: 2e-9 mm/s.
    EXPECT_NEAR((stands - half_width) / end, speed, 1e-8);
}

}  // namespace
}  // namespace drover::physics::transverse_tests
