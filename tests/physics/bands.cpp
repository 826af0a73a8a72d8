// tests/physics/bands.cpp: travelling bands of rods alone, where order grows where rods are dense.
#include <gtest/gtest.h>

#include <cmath>

#include "band_model.hpp"
#include "drover/numerics/transform.hpp"
#include "physics/rod_bead_model.hpp"
#include "solver_support.hpp"

namespace drover::physics::bands_tests {
namespace {

numerics::Spectra band_state(const Band& band, const numerics::Grid& grid, int degree, double shift) {
    Threads threads(1);
    numerics::Fields fields(grid, 3);
    for (int j = 0; j < grid.ny; ++j)
        for (int i = 0; i < grid.nx; ++i) {
            const auto cell = static_cast<std::size_t>(j * grid.nx + i);
            const double p = band_order(band, length / grid.nx * i, shift);
            fields[1][cell] = p;
            fields[0][cell] = band.gas + p / band.c;
        }
    numerics::Spectra state(grid, 3);
    numerics::Transform(grid, degree, threads).forward(fields, state);
    return state;
}

/// Largest error of the band after it has moved for a time, against the formula moved by c t.
double error_after(int n, double dt, int steps) {
    Threads threads(1);
    const Band band;
    const numerics::Grid grid{n, 8, length, height};
    const Model model = model_of(band);
    const numerics::WholeRate whole = whole_rate(Equations(model), grid, mean_densities(model), threads);
    const numerics::Spectra start = band_state(band, grid, whole.system.degree, 0.0),
                            expected = band_state(band, grid, whole.system.degree, band.c * dt * steps);
    const numerics::Spectra found = evolved(whole.system, "etdrk4", dt, steps, start);
    numerics::Spectra wrong = found;
    for (std::size_t m = 0; m < wrong.values.size(); ++m) wrong.values[m] -= expected.values[m];
    numerics::Fields fields(grid, 3);
    numerics::Transform(grid, whole.system.degree, threads).backward(wrong, fields);
    double largest = 0.0;
    for (const double value : fields.values) largest = std::max(largest, std::abs(value));
    return largest;
}

TEST(TravellingBand, keeps_its_shape_and_moves_at_the_speed_of_the_formula) {
    // Steps of 0.01: etdrk4 errs by less than 1e-10 in time 1, see the halved step.
    const double fine = error_after(2048, 0.01, 100);
    EXPECT_LT(fine, 1e-9);
    EXPECT_LT(error_after(2048, 0.005, 200), 1e-9);
}

TEST(TravellingBand, converges_faster_than_any_power_of_the_grid) {
    std::vector<double> errors;
    for (const int n : {256, 512, 1024, 2048}) errors.push_back(error_after(n, 0.01, 20));
    // Fronts of width 1/kappa: the spectrum falls as exp(-pi^2 k ...): each doubling squares the error, until rounding.
    for (std::size_t i = 0; i + 1 < errors.size() && errors[i + 1] > 1e-12; ++i)
        EXPECT_LT(errors[i + 1], std::pow(errors[i], 1.6)) << "from " << errors[i] << " to " << errors[i + 1];
    EXPECT_LT(errors.back(), 1e-10);
}

}  // namespace
}  // namespace drover::physics::bands_tests
