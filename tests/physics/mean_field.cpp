// tests/physics/mean_field.cpp: rods that turn with the beads they drive, in mean field: the model beside all of their
// angles.
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <vector>

#include "evolution.hpp"
#include "physics/rod_bead_model.hpp"

namespace drover::physics::mean_field_tests {
namespace {

// Rods with rotational diffusion D_r turn as dn/dt = lambda_s (1 - nn).v in beads that move with v = alpha P/Gamma, P
// = <n>.  With theta the angle between a rod and v, d_t f = D_r f'' + lambda_s v (f sin theta)'; in f_n = <cos n
// theta>, P = f_1,
//     d_t f_n = -n^2 D_r f_n + (n/2) lambda_s v (f_{n-1} - f_{n+1}),     lambda_s v = g D_r P.
// Stationary: f ~ exp(g P cos theta), so P = I1(gP)/I0(gP).
// The closure keeps f_1 and a stationary f_2 = lambda_s v f_1/(4 D_r):
//     d_t P = -(a - lambda alpha/Gamma + b P^2) P,     a = D_r,     lambda = lambda_s/2,     b = D_r g^2/8.
constexpr double diffusion = 0.7, turning = 1.3, drag = 1.5;  // D_r [1/s], lambda_s [1/mm], Gamma

/// Where a function that falls through zero between two places does so, by halving.
double zero_of(const std::function<double(double)>& falling, double below, double above) {
    for (int i = 0; i < 200; ++i) (falling(0.5 * (below + above)) > 0.0 ? below : above) = 0.5 * (below + above);
    return below;
}

/// I1(gP)/(P I0(gP)) - 1, which falls with P.
double excess(double g, double order) {
    return std::cyl_bessel_i(1.0, g * order) / std::cyl_bessel_i(0.0, g * order) / order - 1.0;
}
double exact_order(double g) {
    return zero_of([g](double order) { return excess(g, order); }, 1e-9, 1.0);
}

/// Rates of f_1, f_2, ...; the last is followed by zero.
std::vector<double> angle_rates(double g, const std::vector<double>& f) {
    std::vector<double> rates(f.size());
    for (std::size_t k = 0; k < f.size(); ++k) {
        const double n = static_cast<double>(k + 1), before = k == 0 ? 1.0 : f[k - 1],
                     after = k + 1 < f.size() ? f[k + 1] : 0.0;
        rates[k] = diffusion * (-n * n * f[k] + 0.5 * n * g * f[0] * (before - after));
    }
    return rates;
}

/// The model with the coefficients of the closure: no densities, beads without inertia.
Model closure(double g) {
    return {.fields = {.bead_density = false, .rod_density = false, .bead_velocity = "slaved"},
            .drag = {.coefficient = drag},
            .driving = {.strength = g * diffusion * drag / turning},
            .relaxation = {.rate = diffusion, .saturation = diffusion * g * g / 8.0},
            .weathercock = {.strength = turning / 2.0}};
}

/// d_t P/P of the model in a uniform state, by its own right-hand side.
class ModelGrowth {
public:
    explicit ModelGrowth(double g) : run_(closure(g), {4, 4, 1.0, 1.0}) {}
    double operator()(double order) {
        const auto constant = [](double value) { return [value](double, double) { return value; }; };
        const numerics::Spectra rate = run_.whole(0.0, run_.spectra({constant(0.6 * order), constant(0.8 * order)}));
        return (0.6 * rate[0][0].real() + 0.8 * rate[1][0].real()) / order;
    }

private:
    Evolution run_;
};
double model_order(double g) {
    ModelGrowth growth(g);
    return zero_of([&](double order) { return growth(order); }, 1e-9, 2.0);
}

TEST(MeanField, of_all_angles_settles_at_the_root_of_its_bessel_functions) {
    for (const double g : {2.5, 4.0}) {
        // The first that is left out is f_16 = I_16(3.5)/I_0(3.5) = 5e-11 at g = 4.
        std::vector<double> f(15, 0.0);
        f[0] = 0.1;
        const double dt = 0.01;  // fastest: 225 D_r = 158 /s, within the 2.78 of this method
        for (int step = 0; step < 6000; ++step) {
            const auto moved = [&](const std::vector<double>& rates, double by) {
                std::vector<double> result = f;
                for (std::size_t k = 0; k < f.size(); ++k) result[k] += by * rates[k];
                return result;
            };
            const std::vector<double> k1 = angle_rates(g, f), k2 = angle_rates(g, moved(k1, 0.5 * dt)),
                                      k3 = angle_rates(g, moved(k2, 0.5 * dt)), k4 = angle_rates(g, moved(k3, dt));
            for (std::size_t k = 0; k < f.size(); ++k) f[k] += dt / 6.0 * (k1[k] + 2.0 * k2[k] + 2.0 * k3[k] + k4[k]);
        }
        // Of the start e^(-0.5 D_r 60 s) = 1e-9 is left at g = 2.5, where P relaxes at 2 (g/2 - 1) D_r.
        EXPECT_NEAR(f[0], exact_order(g), 1e-8) << "g = " << g;
    }
}

TEST(MeanField, of_all_angles_has_order_beyond_twice_its_diffusion_only) {
    for (const double g : {0.5, 1.9, 2.0})
        for (double order = 0.05; order <= 1.0; order += 0.05) EXPECT_LT(excess(g, order), 0.0) << g << ", " << order;
    // I1(x)/I0(x) = x/2 - x^3/16 + ...: P^2 = (g - 2)(1 - (5/6)(g - 2) + ...).
    for (const double beyond : {1e-2, 1e-3, 1e-4})
        // The term after that is (g - 2)^2 times a number of order one; rounding of `excess`, 1e-16/(g - 2).
        EXPECT_NEAR(std::pow(exact_order(2.0 + beyond), 2) / beyond, 1.0 - 5.0 / 6.0 * beyond,
                    2.0 * beyond * beyond + 1e-11);
}

TEST(MeanField, order_of_the_model_grows_out_of_disorder_as_that_of_all_angles) {
    for (const double g : {1.5, 2.0, 3.0}) {
        const double small = 1e-5, of_angles = angle_rates(g, {small, 0.0, 0.0})[0] / small;
        ModelGrowth growth(g);
        // The saturation: b P^2 = 0.8 * 1e-10.  With lambda = lambda_s it would be out by g D_r/2.
        EXPECT_NEAR(growth(small), of_angles, 1e-9) << "g = " << g;
        EXPECT_NEAR(of_angles, diffusion * (0.5 * g - 1.0), 1e-14) << "g = " << g;
    }
}

TEST(MeanField, order_of_the_model_is_that_of_all_angles_to_leading_order_beyond_the_onset) {
    // The model has P^2 = 4 (g - 2)/g^2 = (g - 2)(1 - (g - 2) + ...), all angles have (g - 2)(1 - (5/6)(g - 2) + ...).
    std::vector<double> errors;
    for (const double beyond : {0.04, 0.02, 0.01, 0.005})
        errors.push_back(std::pow(model_order(2.0 + beyond) / exact_order(2.0 + beyond), 2) - 1.0);
    for (std::size_t i = 0; i + 1 < errors.size(); ++i) {
        // The first power of g - 2; the next is worth some (g - 2)/10.
        EXPECT_NEAR(errors[i] / errors[i + 1], 2.0, 0.01) << errors[i] << ", " << errors[i + 1];
    }
    EXPECT_NEAR(errors.back() / 0.005, -1.0 / 6.0, 0.001);
}

}  // namespace
}  // namespace drover::physics::mean_field_tests
