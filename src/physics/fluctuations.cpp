// physics/fluctuations.cpp: structure factors from Lyapunov equations.
#include "drover/physics/fluctuations.hpp"

#include <cmath>
#include <limits>

#include "drover/model/theory.hpp"
#include "drover/physics/long_waves.hpp"

namespace drover::physics {

namespace {
/// Parts along and across q: with the components (x, y) of a vector that starts at a place.
void parts(const Symbol& s, int place, double c, double sn, double& along, double& across) {
    const double xx = s(place, place).real(), yy = s(place + 1, place + 1).real(), xy = s(place, place + 1).real();
    along = c * c * xx + 2.0 * c * sn * xy + sn * sn * yy;
    across = sn * sn * xx - 2.0 * c * sn * xy + c * c * yy;
}

StructureFactor structure_factor_of(const Symbol& s, const numerics::Wavevector& q) {
    const double size = std::hypot(q.x, q.y), c = q.x / size, sn = q.y / size;
    StructureFactor r{.rods = s(FieldIndex::rod_density, FieldIndex::rod_density).real(),
                      .beads = s(FieldIndex::bead_density, FieldIndex::bead_density).real(),
                      .beads_rods = s(FieldIndex::bead_density, FieldIndex::rod_density).real()};
    parts(s, FieldIndex::polar_order_x, c, sn, r.order_along, r.order_across);
    parts(s, FieldIndex::bead_velocity_x, c, sn, r.velocity_along, r.velocity_across);
    return r;
}
}  // namespace

Symbol structure_matrix(const Equations& equations, const UniformPoint& about, const numerics::Wavevector& q) {
    const auto at = equations.linearised(about);
    model::Symbol covariance;
    const double growth = model::solve_covariance(*at, q, covariance);
    if (!(growth < 0.0))
        fail_run("no stationary state: a mode at q = ({:.4g}, {:.4g}) /mm grows at {:.3g} /s", q.x, q.y, growth);
    return of_all_fields(equations, covariance, at->state_components());
}

Symbol dynamic_structure_matrix(const Equations& equations, const UniformPoint& about, const numerics::Wavevector& q,
                                double omega) {
    const auto at = equations.linearised(about);
    const std::vector<int>& state = at->state_components();
    return of_all_fields(equations, model::dynamic_structure(*at, q, omega)(state, state), state);
}

std::vector<StructureFactor> structure_factors(const Equations& equations, const UniformPoint& about,
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

double direction_diffusion(const Equations& equations, const StationaryState& about) {
    if (!about.free_direction) return 0.0;
    // The slow mode behind those of the densities is a turn of p and v together; noise turns it by its dual, which is
    // normal to p.
    const LongWaves waves = long_waves(equations, about);
    if (!waves.why_none.empty()) return std::numeric_limits<double>::quiet_NaN();
    const auto at = equations.linearised(about.point);
    const Eigen::Index turn = (equations.form.bead_density >= 0 ? 1 : 0) + (equations.form.rod_density >= 0 ? 1 : 0);
    const std::vector<int>& state = at->state_components();
    const Eigen::VectorXd force = waves.left.row(turn).transpose();
    const Eigen::VectorXd rate = force(state).cwiseProduct(at->moved()(state));
    return 0.5 * rate.dot(at->noise({}).real() * rate);
}

}  // namespace drover::physics
