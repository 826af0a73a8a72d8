// tests/physics/kink_model.hpp: order across its own gradient, (0, p_y(x)), and its lattice of kinks.
#pragma once
#include <cmath>
#include <numbers>

#include "evolution.hpp"
#include "physics/rod_bead_model.hpp"

namespace drover::physics {

inline constexpr double kink_growth = 0.5;  // -abar [1/s]

/// Every term but viscosity and what pushes from outside: advection, the pressures A, B, E and F, the splay K1, the
/// rod current and the inertia of the beads must all drop out of this sector by themselves.
struct Sector {
    Model model = full_model();
    double drag, driving, saturation, stiffness;  // saturation: with the part of the cubic driving

    Sector() {
        const double rho = model.uniform.bead_density, sigma = model.uniform.rod_density;
        drag = 1.1 + 0.3 * rho + 0.2 * sigma;
        driving = 0.9 + 0.4 * sigma - 0.1 * rho * sigma;
        stiffness = model.elasticity.stiffness;
        const double weathercock = 0.75 - 0.2 * rho;
        saturation = 0.8 + 0.3 * rho - weathercock * model.driving.cubic / drag;
        model.viscosity = {};
        // A square of p_y alone has a gradient along x; lap^2 changes the profile.
        model.advection.gradient = model.elasticity.bilaplacian = 0.0;
        model.force = {};
        model.orienting_field = {};
        model.relaxation.rate = -kink_growth + weathercock * driving / drag + 0.5 * sigma - 0.2 * rho * rho;
    }
    double saturated() const { return std::sqrt(kink_growth / saturation); }
    /// rho, sigma, v = (alpha + alpha_3 p^2) p/Gamma (dynamic), p.
    std::vector<FieldFunction> fields(const FieldFunction& order) const {
        const auto constant = [](double value) { return [value](double, double) { return value; }; };
        std::vector<FieldFunction> made{constant(model.uniform.bead_density), constant(model.uniform.rod_density)};
        if (model.fields.bead_velocity == "dynamic") {
            made.push_back(constant(0.0));
            made.push_back([=, alpha = driving, cubic = model.driving.cubic, gamma = drag](double x, double y) {
                const double p = order(x, y);
                return (alpha + cubic * p * p) * p / gamma;
            });
        }
        made.push_back(constant(0.0));
        made.push_back(order);
        return made;
    }
};

/// p_m sn(kappa x|k), one period long.
struct KinkLattice {
    double modulus = 0.95;
    double quarter = std::comp_ellint_1(modulus), complement = std::comp_ellint_1(std::sqrt(1.0 - modulus * modulus));
    double kappa, amplitude, period;

    explicit KinkLattice(const Sector& sector)
        : kappa(std::sqrt(kink_growth / (sector.stiffness * (1.0 + modulus * modulus)))),
          amplitude(std::sqrt(2.0 * modulus * modulus * kink_growth / ((1.0 + modulus * modulus) * sector.saturation))),
          period(4.0 * quarter / kappa) {}
    /// By its Fourier series in the nome, which falls as 0.37^n: 45 odd terms are below rounding.
    double operator()(double x) const {
        constexpr double pi = std::numbers::pi;
        const double nome = std::exp(-pi * complement / quarter);
        double sum = 0.0;
        for (int n = 0; n < 45; ++n)
            sum += std::pow(nome, n + 0.5) / (1.0 - std::pow(nome, 2 * n + 1)) *
                   std::sin((2 * n + 1) * pi * kappa * x / (2.0 * quarter));
        return amplitude * 2.0 * pi / (modulus * quarter) * sum;
    }
};

}  // namespace drover::physics
