// tests/physics/point_force.cpp: a force at a point of the bead fluid, at rest and moving: screened, incompressible,
// and between.
#include <gtest/gtest.h>

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <complex>

#include "evolution.hpp"
#include "physics/rod_bead_model.hpp"

namespace drover::physics::point_force_tests {
namespace {

constexpr double pi = std::numbers::pi, tiny = 1e-9;  // so weak a force that what is quadratic in it is below rounding
constexpr double middle = 10.0;                       // where it stands, in cells of 20 mm

/// ell = sqrt(eta/Gamma) as given.
Model bead_fluid(double ell, double stiffness) {
    const double drag = 0.8;
    return {
        .fields = {.bead_density = true, .rod_density = false, .bead_velocity = "dynamic"},
        .uniform = {.bead_density = 1.3},
        .inertia = {.bead_mass = 0.5},
        .drag = {.coefficient = drag},
        .viscosity = {.shear = drag * ell * ell},
        .stiffness = {.beads = stiffness},
        .relaxation = {.rate = 1.0},
        .force = {.kind = "point", .x = 0.6 * tiny, .y = 0.8 * tiny, .at_x = middle, .at_y = middle, .width = 0.27}};
}

/// The force over 2 pi eta; the velocity over it has no unit.
Eigen::Vector2d scale(const Model& model) {
    return Eigen::Vector2d(model.force.x, model.force.y) / (2.0 * pi * model.viscosity.shear);
}

/// v(r) of a fluid that was at rest.  A fixed force is constant in time, and the exponential method exact for it.
numerics::Fields settled(Evolution& run, double dt, int steps) {
    numerics::Spectra state(run.grid, numerics::components(run.whole.system.layout));
    state[run.form.bead_density][0] = 1.3;
    run.advance(state, "exponential-euler", dt, steps);
    return run.fields(state);
}

/// body(place from the force, cell) for every cell whose distance lies within.
template <class Body>
void around(const Evolution& run, double least, double most, Body body) {
    for (std::size_t i = 0; i < points(run.grid); ++i) {
        const Eigen::Vector2d r(run.x(i) - middle, run.y(i) - middle);
        if (r.norm() >= least && r.norm() <= most) body(r, i);
    }
}

/// sum over (m, n) != 0 of 1/(m + i n)^power, power a multiple of 4: the square lattice of images.
double lattice_sum(int power) {
    if (power == 4) return std::pow(std::tgamma(0.25), 8) / (960.0 * pi * pi);  // Hurwitz; too slow to be summed
    double sum = 0.0;
    for (int m = -40; m <= 40; ++m)
        for (int n = -40; n <= 40; ++n)
            if (m != 0 || n != 0) sum += std::pow(numerics::Complex(m, n), -power).real();
    return sum;
}

/// The screened part of the flow at r = ell z: compressible K0; incompressible delta K0 - d_i d_j K0, which is -K1/z
/// along z and K0 + K1/z across.
Eigen::Matrix2d screened(const Eigen::Vector2d& z, bool compressible) {
    const double d = z.norm(), k0 = std::cyl_bessel_k(0.0, d), k1 = std::cyl_bessel_k(1.0, d);
    if (compressible) return k0 * Eigen::Matrix2d::Identity();
    const Eigen::Matrix2d along = z * z.transpose() / (d * d), across = Eigen::Matrix2d::Identity() - along;
    return -k1 / d * along + (k0 + k1 / d) * across;
}

/// Over images of the force, of which those three cells away and more are below e^(-55/ell).  A Gaussian that the
/// force is spread over multiplies what is screened, outside it, by exp(width^2/(2 ell^2)).
Eigen::Matrix2d screened_images(const Eigen::Vector2d& r, const Model& model, double ell, double side,
                                bool compressible) {
    Eigen::Matrix2d sum = Eigen::Matrix2d::Zero();
    for (int m = -2; m <= 2; ++m)
        for (int n = -2; n <= 2; ++n) sum += screened((r - side * Eigen::Vector2d(m, n)) / ell, compressible);
    return sum * std::exp(0.5 * std::pow(model.force.width / ell, 2));
}

TEST(PointForce, moves_compressible_beads_parallel_to_itself_everywhere_by_the_screened_function_k0) {
    const double ell = 1.0;
    const Model model = bead_fluid(ell, 0.0);
    Evolution run(model, {256, 256, 2.0 * middle, 2.0 * middle});
    const numerics::Fields found = settled(run, 1.0, 25);  // drag over mass is 1.23 /s: e^(-31) of the start is left
    int cells = 0;
    around(run, 2.0 * ell, 5.0 * ell, [&](const Eigen::Vector2d& r, std::size_t i) {
        const Eigen::Vector2d v(found[run.form.bead_velocity][i], found[run.form.bead_velocity + 1][i]);
        const Eigen::Vector2d exact = screened_images(r, model, ell, 2.0 * middle, true) * scale(model);
        // K0(5) = 4e-3; the Gaussian is at e^(-27) of its height at 2 mm, and at e^(-26) where the modes of the grid
        // end.
        ASSERT_LT((v - exact).norm(), 1e-11 * scale(model).norm()) << r.transpose();
        ASSERT_LT(std::abs(v.x() * 0.8 - v.y() * 0.6), 1e-12 * scale(model).norm()) << r.transpose();
        // The formula for a plane: the nearest image is K0(17)/K0(3) = 4e-7 at the most; the Gaussian gives its
        // exp(0.036).
        if (r.norm() < 3.0) {
            ASSERT_NEAR(v.norm() / scale(model).norm() / std::exp(0.5 * 0.27 * 0.27) / std::cyl_bessel_k(0.0, r.norm()),
                        1.0, 1e-6);
        }
        ++cells;
    });
    EXPECT_GT(cells, 10000);
}

TEST(PointForce, fixed_in_beads_of_any_stiffness_ends_in_the_incompressible_flow_with_its_backflow) {
    const double ell = 2.0, side = 2.0 * middle;
    Model model = bead_fluid(ell, 7.0);
    model.force.x = tiny;
    model.force.y = 0.0;
    Evolution run(model, {256, 256, side, side});
    // Sound of the longest wave, sqrt(E/m) 0.314 = 1.2 rad/s, and every other dies at half of drag over mass, 0.6 /s
    // and faster.
    const numerics::Fields found = settled(run, 1.0, 60);
    const double s4 = lattice_sum(4), s8 = lattice_sum(8), s12 = lattice_sum(12);
    int ahead = 0;
    std::vector<std::pair<double, double>> abreast;  // z, v in its unit
    around(run, 1.9, 5.0, [&](const Eigen::Vector2d& r, std::size_t i) {
        const Eigen::Vector2d v(found[run.form.bead_velocity][i], found[run.form.bead_velocity + 1][i]);
        // The algebraic part ell^2 d_i d_j G, -lap G = delta - 1/area:
        // 2 pi G = -ln r + pi r^2/(2 area) + Re sum S_n ((x + i y)/side)^n/n.
        const numerics::Complex place(r.x(), r.y()), lattice = place / side;
        const numerics::Complex own = 1.0 / (place * place),
                                images = (3.0 * s4 * std::pow(lattice, 2) + 7.0 * s8 * std::pow(lattice, 6) +
                                          11.0 * s12 * std::pow(lattice, 10)) /
                                         (side * side);
        const auto hessian = [&](const numerics::Complex& second) {
            return Eigen::Matrix2d{{second.real(), -second.imag()}, {-second.imag(), -second.real()}};
        };
        const Eigen::Matrix2d background = pi / (side * side) * Eigen::Matrix2d::Identity(),
                              mended = ell * ell * (hessian(images) + background);
        const Eigen::Vector2d exact =
            (screened_images(r, model, ell, side, false) + ell * ell * hessian(own) + mended) * scale(model);
        // The next term of the images, 15 S16 (r/side)^14 (ell/side)^2 = 2e-9 at 5 mm; the Gaussian is at e^(-25) at
        // 1.9 mm.
        ASSERT_LT((v - exact).norm(), 1e-8 * scale(model).norm()) << r.transpose();
        // On the line of the force and across it: with the algebraic part of the images taken off, the formulas for a
        // plane.
        const double z = r.norm() / ell, width = model.force.width / ell, spread = std::exp(0.5 * width * width);
        const double rest = (v - mended * scale(model)).x() / scale(model).x();
        const double image_error = 1e-3;  // screened parts of four images, K1((20 - 5)/2) = 3e-4 each at the most
        if (std::abs(r.y()) < 1e-9) {
            ++ahead;
            ASSERT_NEAR(rest, 1.0 / (z * z) - spread * std::cyl_bessel_k(1.0, z) / z, image_error) << r.transpose();
            ASSERT_GT(v.x(), 0.0);
        }
        if (std::abs(r.x()) < 1e-9 && r.y() > 0.0) {
            abreast.emplace_back(z, (rest + 1.0 / (z * z)) / spread - 1.0 / (z * z));
            ASSERT_NEAR(abreast.back().second,
                        std::cyl_bessel_k(0.0, z) + std::cyl_bessel_k(1.0, z) / z - 1.0 / (z * z), image_error);
        }
    });
    EXPECT_GT(ahead, 70);
    ASSERT_GT(abreast.size(), 35u);
    // Beads flow back beyond z = 1.1144.  The slope there is -0.18, the screened parts of images are below 1e-4 so
    // near the force, and cells are 0.04 apart: the line between two of them bends by 1e-4.
    const auto turns = std::find_if(abreast.begin(), abreast.end(), [](const auto& at) { return at.second < 0.0; });
    ASSERT_TRUE(turns != abreast.begin() && turns != abreast.end());
    const auto [z0, v0] = turns[-1];
    const auto [z1, v1] = turns[0];
    EXPECT_NEAR(z0 + (z1 - z0) * v0 / (v0 - v1), 1.1144, 2e-3);
}

/// The flow of a force that has moved at U for ever, mode by mode: m rho d_t is -i m rho q.U, and rho follows the
/// divergence.
Eigen::Vector2d moving_flow(const Model& m, const numerics::Grid& grid, int most_x, int most_y, double t, double x,
                            double y) {
    const double rho = m.uniform.bead_density;
    const Eigen::Vector2d force(m.force.x, m.force.y), velocity(m.force.velocity_x, m.force.velocity_y);
    const Eigen::Vector2d place = Eigen::Vector2d(x - m.force.at_x, y - m.force.at_y) - velocity * t;
    Eigen::Vector2d sum = Eigen::Vector2d::Zero();
    for (int kx = -most_x; kx <= most_x; ++kx)
        for (int ky = -most_y; ky <= most_y; ++ky) {
            const Eigen::Vector2d q(2.0 * pi / grid.lx * kx, 2.0 * pi / grid.ly * ky);
            const double q2 = q.squaredNorm(), turn = q.dot(velocity);
            const numerics::Complex across(m.drag.coefficient + m.viscosity.shear * q2,
                                           -m.inertia.bead_mass * rho * turn);
            const numerics::Complex along =
                across + numerics::Complex(m.viscosity.bulk * q2, q2 > 0.0 ? m.stiffness.beads * rho * q2 / turn : 0.0);
            const Eigen::Vector2d pushed_along = q2 > 0.0 ? Eigen::Vector2d(q * q.dot(force) / q2) : force;
            const numerics::Complex wave =
                std::polar(std::exp(-0.5 * std::pow(m.force.width, 2) * q2) / (grid.lx * grid.ly), q.dot(place));
            for (int axis = 0; axis < 2; ++axis)
                sum(axis) += (wave * (pushed_along(axis) / along + (force(axis) - pushed_along(axis)) / across)).real();
        }
    return sum;
}

/// The largest error of v a long time after the force set out, over the largest v.
double moving_error(double stiffness, double bulk, double dt) {
    Model model = bead_fluid(0.7, stiffness);
    model.viscosity.bulk = bulk;
    model.force.at_x = 3.0;
    model.force.at_y = 1.0;
    model.force.velocity_x = 0.5;
    model.force.velocity_y = 0.31;
    model.force.width = 0.4;
    Evolution run(model, {48, 40, 10.0, 8.0});
    numerics::Spectra state(run.grid, numerics::components(run.whole.system.layout));
    state[run.form.bead_density][0] = model.uniform.bead_density;
    const double end = 42.0;  // e^(-0.6 end) = 1e-11 of the start is left: half of drag over mass, as for sound
    run.advance(state, "etdrk4", dt, static_cast<int>(std::lround(end / dt)));
    const numerics::Fields found = run.fields(state);
    double wrong = 0.0, most = 0.0;
    for (std::size_t i = 0; i < points(run.grid); i += 7) {
        // Modes along x are kept below 48/3, along y below 40/3.
        const Eigen::Vector2d exact = moving_flow(model, run.grid, 15, 13, end, run.x(i), run.y(i));
        const Eigen::Vector2d v(found[run.form.bead_velocity][i], found[run.form.bead_velocity + 1][i]);
        wrong = std::max(wrong, (v - exact).norm());
        most = std::max(most, exact.norm());
    }
    return wrong / most;
}

TEST(PointForceLong, moving_through_beads_without_and_with_stiffness_drags_the_flow_predicted_by_linear_theory) {
    // A step takes the force in by a rule of three points, which errs by (q.U dt)^4/2880; at q = 5, where the Gaussian
    // is e^(-2), q.U dt = 0.074: 1e-8.
    EXPECT_LT(moving_error(0.0, 0.0, 0.025), 1e-7);
    EXPECT_LT(moving_error(4.0, 0.3, 0.025), 1e-7);
    EXPECT_GT(std::log2(moving_error(4.0, 0.3, 0.1) / moving_error(4.0, 0.3, 0.05)), 3.7);
}

}  // namespace
}  // namespace drover::physics::point_force_tests
