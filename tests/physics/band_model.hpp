// tests/physics/band_model.hpp: the exact travelling band of rods alone, where order grows where rods are dense.
#pragma once
#include <cmath>

#include "physics/rod_bead_model.hpp"

namespace drover::physics {

// a = -mu (sigma - sigma_c): with sigma = sigma_gas + p/c and z = x - c t,
//     K p'' + (c - B/c) p' - w p p' - b p (p - p_l/2)(p - p_l) = 0,
// solved by p_l/(1 + exp(kappa z)) with 2 K kappa^2 - w p_l kappa - b p_l^2 = 0: one root ahead of the band, one
// behind, both for c^2 = B + w mu/(3 b), p_l = 2 mu/(3 b c), sigma_gas = sigma_c - 2 mu/(9 b c^2).
struct Band {
    double mu = 0.9, sigma_c = 1.1, b = 0.8, pressure = 1.2, advection = 0.7, stiffness = 0.5, splay = 0.3;
    double c = std::sqrt(pressure + advection * mu / (3.0 * b));
    double order = 2.0 * mu / (3.0 * b * c);
    double gas = sigma_c - 2.0 * mu / (9.0 * b * c * c);
    double kappa(double sign) const {
        const double k = stiffness + splay;
        return order * (advection + sign * std::sqrt(advection * advection + 8.0 * k * b)) / (4.0 * k);
    }
};

inline constexpr double length = 240.0, height = 4.0;

inline Model model_of(const Band& band) {
    return {.uniform = {.rod_density = band.gas},
            .current = {.speed = 1.0},
            .relaxation = {.rate = band.mu * band.sigma_c,
                           .rate_terms = {text("{} sigma", -band.mu)},
                           .saturation = band.b},
            .elasticity = {.stiffness = band.stiffness, .splay = band.splay},
            .advection = {.strength = band.advection},
            .pressure = {.rods = band.pressure}};
}

/// The order of a band with fronts at 60 and 180 mm, displaced: their overlap is exp(-120 * 0.36) = 1e-19.
inline double band_order(const Band& band, double x, double shift) {
    double p = 0.0;
    for (const double image : {-length, 0.0, length}) {
        const double z = x - shift + image;
        p += band.order / (1.0 + std::exp(band.kappa(1.0) * (z - 180.0))) +
             band.order / (1.0 + std::exp(band.kappa(-1.0) * (z - 60.0))) - band.order;
    }
    return p;
}

}  // namespace drover::physics
