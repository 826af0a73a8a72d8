// tests/physics/structure.hpp: structure factors of rods and beads by field, about any uniform state and from the
// blocks of the exact linear part.
#pragma once
#include <cmath>
#include <vector>

#include "drover/theory/theory.hpp"
#include "numerics/fields/shells.hpp"
#include "physics/integrated.hpp"
#include "uniform_points.hpp"

namespace drover::physics {

/// The matrix of some components of forces() by FieldIndex; rows and columns of the others are zero.
inline Symbol of_all_fields(const Equations& equations, const model::Symbol& m, const std::vector<int>& components) {
    Symbol result = Symbol::Zero();
    std::vector<int> places;
    for (int k = 0; k < FieldIndex::count; ++k)
        if (std::count(components.begin(), components.end(), component(equations, k)) > 0) places.push_back(k);
    result(places, places) = m;
    return result;
}

/// Stationary structure factors of the linear model at |q| [1/mm]; zero for absent fields.  Cross structure factors are
/// those of a density and i times the component of p along q.  Source: m S + S m^T + Q = 0 for each block.
struct StructureFactor {
    double rods = 0.0, beads = 0.0;                      ///< of sigma, of rho [1/mm^2]
    double order_along = 0.0, order_across = 0.0;        ///< of the components of p along and across q [[p]^2 mm^2]
    double velocity_along = 0.0, velocity_across = 0.0;  ///< of v [mm^4/s^2]
    double beads_rods = 0.0;                             ///< of rho and sigma [1/mm^2]
};

/// Parts along and across q: with the components (x, y) of a vector that starts at a place.
inline void parts(const Symbol& s, int place, double c, double sn, double& along, double& across) {
    const double xx = s(place, place).real(), yy = s(place + 1, place + 1).real(), xy = s(place, place + 1).real();
    along = c * c * xx + 2.0 * c * sn * xy + sn * sn * yy;
    across = sn * sn * xx - 2.0 * c * sn * xy + c * c * yy;
}

inline StructureFactor structure_factor_of(const Symbol& s, const numerics::Wavevector& q) {
    const double size = std::hypot(q.x, q.y), c = q.x / size, sn = q.y / size;
    StructureFactor r{.rods = s(FieldIndex::rod_density, FieldIndex::rod_density).real(),
                      .beads = s(FieldIndex::bead_density, FieldIndex::bead_density).real(),
                      .beads_rods = s(FieldIndex::bead_density, FieldIndex::rod_density).real()};
    parts(s, FieldIndex::polar_order_x, c, sn, r.order_along, r.order_across);
    parts(s, FieldIndex::bead_velocity_x, c, sn, r.velocity_along, r.velocity_across);
    return r;
}
inline Symbol structure_matrix(const Equations& equations, const UniformPoint& about, const numerics::Wavevector& q) {
    const auto at = linearised(equations, about);
    model::Symbol covariance;
    const double growth = theory::solve_covariance(*at, q, covariance);
    if (!(growth < 0.0))
        fail_run("no stationary state: a mode at q = ({:.4g}, {:.4g}) /mm grows at {:.3g} /s", q.x, q.y, growth);
    return of_all_fields(equations, covariance, at->state_components());
}

inline Symbol dynamic_structure_matrix(const Equations& equations, const UniformPoint& about,
                                       const numerics::Wavevector& q, double omega) {
    const auto at = linearised(equations, about);
    const std::vector<int>& state = at->state_components();
    return of_all_fields(equations, theory::dynamic_structure(*at, q, omega)(state, state), state);
}

inline std::vector<StructureFactor> structure_factors(const Equations& equations, const UniformPoint& about,
                                                      const numerics::Grid& grid, int degree, Threads& threads) {
    std::vector<StructureFactor> result(numerics::modes(grid));
    const std::size_t width = numerics::columns(grid);
    threads.for_chunks(static_cast<std::size_t>(grid.ny), 1, [&](std::size_t begin, std::size_t end) {
        for (std::size_t row = begin; row < end; ++row)
            for (std::size_t column = 0; column < width; ++column) {
                if ((row == 0 && column == 0) || !numerics::is_kept(grid, degree, column, row)) continue;
                const numerics::Wavevector q = numerics::wavevector(grid, column, row);
                result[row * width + column] = structure_factor_of(structure_matrix(equations, about, q), q);
            }
    });
    return result;
}

inline StructureFactor structure_factor(const numerics::System& system, const Form& form, double q) {
    const numerics::IsotropicBlocks rates = system.linear(q), noise = system.noise(q);
    const numerics::Block along = numerics::stationary_covariance(rates.even, noise.even);
    const numerics::Block across = numerics::stationary_covariance(rates.odd, noise.odd);
    const int order = along.size - 1, velocity = order - 1;
    StructureFactor result{.order_along = along(order, order),
                           .order_across = across(across.size - 1, across.size - 1)};
    if (form.rod_density >= 0) result.rods = along(form.rod_density, form.rod_density);
    if (form.bead_density >= 0) result.beads = along(form.bead_density, form.bead_density);
    if (form.rod_density >= 0 && form.bead_density >= 0) result.beads_rods = along(form.bead_density, form.rod_density);
    if (form.bead_velocity >= 0) {
        result.velocity_along = along(velocity, velocity);
        result.velocity_across = across(0, 0);
    }
    return result;
}

inline std::vector<StructureFactor> structure_factors(const numerics::System& system, const Form& form) {
    const numerics::DistinctWavenumbers wavenumbers = numerics::distinct_wavenumbers(system.grid, system.degree);
    std::vector<StructureFactor> of_q(wavenumbers.q.size());
    for (std::size_t n = 1; n < of_q.size(); ++n) of_q[n] = structure_factor(system, form, wavenumbers.q[n]);
    std::vector<StructureFactor> result;
    result.reserve(wavenumbers.of_mode.size());
    for (const std::int32_t n : wavenumbers.of_mode)
        result.push_back(n < 0 ? StructureFactor{} : of_q[static_cast<std::size_t>(n)]);
    return result;
}

}  // namespace drover::physics
