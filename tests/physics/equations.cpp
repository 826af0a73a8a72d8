// tests/physics/equations.cpp: the solver's right-hand side against the equations as they are written, point by point.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "drover/numerics/transform.hpp"
#include "full_model.hpp"
#include "physics/rod_bead_model.hpp"

namespace drover::physics::equations_tests {
namespace {

using numerics::Complex;
using numerics::Fields;
using numerics::Grid;
using numerics::Spectra;
using Values = std::vector<double>;

// Fields of the two lowest modes on a grid that resolves every product of them, 1/rho included: its series in an
// amplitude of 0.15 falls below rounding before the cut at |k| < 64/5.
constexpr Grid grid{64, 64, 7.0, 9.0};
constexpr double time = 0.7;

/// Derivatives by multiplication with i q, of every mode below the Nyquist ones.
class Calculus {
public:
    explicit Calculus(Threads& threads) : transform_(grid, 1, threads) {}
    Values x(const Values& f) const {
        return with(f, [](const numerics::Wavevector& q) { return Complex(0.0, q.x); });
    }
    Values y(const Values& f) const {
        return with(f, [](const numerics::Wavevector& q) { return Complex(0.0, q.y); });
    }
    Values lap(const Values& f) const {
        return with(f, [](const numerics::Wavevector& q) { return Complex(-q.x * q.x - q.y * q.y); });
    }
    template <class Factor>
    Values with(const Values& f, Factor factor) const {
        Fields field(grid, 1);
        std::copy(f.begin(), f.end(), field.values.begin());
        Spectra spectra(grid, 1);
        transform_.forward(field, spectra);
        for (std::size_t m = 0; m < spectra.size; ++m)
            spectra[0][m] *=
                factor(numerics::wavevector(grid, m % numerics::columns(grid), m / numerics::columns(grid)));
        transform_.backward(spectra, field);
        return {field.values.begin(), field.values.end()};
    }

private:
    numerics::Transform transform_;
};

template <class Function>
Values at_each(Function f) {
    Values result(numerics::points(grid));
    for (std::size_t i = 0; i < result.size(); ++i) result[i] = f(i);
    return result;
}

struct State {
    Values rho, sigma, vx, vy, px, py;
};

State smooth_state(const UniformState& mean) {
    const auto waves = [](double constant, double size, double phase) {
        return at_each([=](std::size_t i) {
            const double a = 2.0 * std::numbers::pi * static_cast<double>(i % 64) / 64,
                         b = 2.0 * std::numbers::pi * static_cast<double>(i / 64) / 64;
            return constant +
                   size * (std::cos(a + phase) + 0.7 * std::cos(b - 2.0 * phase) + 0.4 * std::cos(a - b + 3.0 * phase));
        });
    };
    return {waves(1.1 * mean.bead_density, 0.07 * mean.bead_density, 0.3),
            waves(0.9 * mean.rod_density, 0.2 * mean.rod_density, 1.1),
            waves(0.2, 0.5, 1.9),
            waves(-0.3, 0.4, 2.3),
            waves(0.4, 0.5, 0.8),
            waves(0.1, 0.6, 3.1)};
}

/// The external force [mg/(mm s^2)]: uniform, or a Gaussian at a moving point, with its images.
struct Force {
    Values x, y;
};
Force outside_force(const BodyForce& force) {
    const Values size = at_each([&](std::size_t i) {
        if (force.kind != "point") return force.kind == "uniform" ? 1.0 : 0.0;
        const double x = grid.lx * static_cast<double>(i % 64) / 64 - force.at_x - force.velocity_x * time,
                     y = grid.ly * static_cast<double>(i / 64) / 64 - force.at_y - force.velocity_y * time;
        double sum = 0.0;
        for (int m = -4; m <= 4; ++m)
            for (int n = -4; n <= 4; ++n)
                sum += std::exp(-0.5 * (std::pow(x + m * grid.lx, 2) + std::pow(y + n * grid.ly, 2)) /
                                (force.width * force.width));
        return sum / (2.0 * std::numbers::pi * force.width * force.width);
    });
    return {at_each([&](std::size_t i) { return force.x * size[i]; }),
            at_each([&](std::size_t i) { return force.y * size[i]; })};
}

/// Every force on the beads but drag and viscosity: alpha p - E grad rho - F grad sigma + outside.
Force driving_force(const Equations& e, const State& s, const Calculus& d) {
    const Model m = written(e.model);
    const Force outside = outside_force(m.force);
    const Values rx = d.x(s.rho), ry = d.y(s.rho), sx = d.x(s.sigma), sy = d.y(s.sigma);
    const auto one = [&](const Values& p, const Values& r, const Values& g, const Values& f) {
        return at_each([&](std::size_t i) {
            const double square = s.px[i] * s.px[i] + s.py[i] * s.py[i];
            return (e.coefficient("driving.strength").at({s.rho[i], s.sigma[i]}) + m.driving.cubic * square) * p[i] -
                   m.stiffness.beads * r[i] - m.stiffness.rods * g[i] + f[i];
        });
    };
    return {one(s.px, rx, sx, outside.x), one(s.py, ry, sy, outside.y)};
}

/// 0 = -Gamma v + eta lap v + zeta grad(div v) + force.  With viscosity Gamma is a number.
void balance(const Equations& e, State& s, const Calculus& d) {
    const Force force = driving_force(e, s, d);
    const Viscosity viscosity = written(e.model).viscosity;
    const auto held = [&](std::size_t i) { return e.coefficient("drag.coefficient").at({s.rho[i], s.sigma[i]}); };
    if (viscosity.shear == 0.0 && viscosity.bulk == 0.0) {
        s.vx = at_each([&](std::size_t i) { return force.x[i] / held(i); });
        s.vy = at_each([&](std::size_t i) { return force.y[i] / held(i); });
        return;
    }
    const double gamma = held(0);
    // div v = div force/(Gamma + (eta + zeta) q^2), then each component.
    const auto solve = [&](const Values& f, double eta) {
        return d.with(f, [&](const numerics::Wavevector& q) {
            return Complex(1.0 / (gamma + eta * (q.x * q.x + q.y * q.y)));
        });
    };
    const Values fx = d.x(force.x), fy = d.y(force.y);
    const Values divergence =
        solve(at_each([&](std::size_t i) { return fx[i] + fy[i]; }), viscosity.shear + viscosity.bulk);
    const Values gx = d.x(divergence), gy = d.y(divergence);
    s.vx = solve(at_each([&](std::size_t i) { return force.x[i] + viscosity.bulk * gx[i]; }), viscosity.shear);
    s.vy = solve(at_each([&](std::size_t i) { return force.y[i] + viscosity.bulk * gy[i]; }), viscosity.shear);
}

/// -div of a flux + diffusion.
Values density_rate(const Values& density, double diffusion, const Values& fx, const Values& fy, const Calculus& d) {
    const Values x = d.x(fx), y = d.y(fy), spread = d.lap(density);
    return at_each([&](std::size_t i) { return -x[i] - y[i] + diffusion * spread[i]; });
}

/// One component of d_t v: -v.grad v + (force - Gamma v + eta lap v + zeta grad div v)/(m rho).
Values velocity_rate(const Equations& e, const State& s, const Values& v, const Values& force, const Values& grad_div,
                     const Calculus& d) {
    const Model m = written(e.model);
    const Values x = d.x(v), y = d.y(v), spread = d.lap(v);
    return at_each([&](std::size_t i) {
        const double carried = m.inertia.advection ? s.vx[i] * x[i] + s.vy[i] * y[i] : 0.0;
        return -carried + (force[i] - e.coefficient("drag.coefficient").at({s.rho[i], s.sigma[i]}) * v[i] +
                           m.viscosity.shear * spread[i] + m.viscosity.bulk * grad_div[i]) /
                              (m.inertia.bead_mass * s.rho[i]);
    });
}

Values product(const Values& a, const Values& b) {
    return at_each([&](std::size_t i) { return a[i] * b[i]; });
}
Values divergence(const Values& x, const Values& y, const Calculus& d) {
    const Values dx = d.x(x), dy = d.y(y);
    return at_each([&](std::size_t i) { return dx[i] + dy[i]; });
}

/// One component of d_t p, the densities' gradients along it given.
Values order_rate(const Equations& e, const State& s, const Values& p, const Values& v, const Values& grad_div,
                  const Values& grad_rho, const Values& grad_sigma, const Values& grad_square, double field,
                  const Calculus& d) {
    const Model m = written(e.model);
    const Values x = d.x(p), y = d.y(p), spread = d.lap(p), bilaplacian = d.lap(spread),
                 div = divergence(s.px, s.py, d);
    return at_each([&](std::size_t i) {
        const double a = e.coefficient("relaxation.rate").at({s.rho[i], s.sigma[i]}),
                     b = e.coefficient("relaxation.saturation").at({s.rho[i], s.sigma[i]}),
                     lambda = e.coefficient("weathercock.strength").at({s.rho[i], s.sigma[i]});
        return -m.advection.strength * (s.px[i] * x[i] + s.py[i] * y[i]) - m.advection.divergence * p[i] * div[i] -
               m.advection.gradient * grad_square[i] - m.elasticity.bilaplacian * bilaplacian[i] -
               (a + b * (s.px[i] * s.px[i] + s.py[i] * s.py[i])) * p[i] + m.elasticity.stiffness * spread[i] +
               m.elasticity.splay * grad_div[i] + lambda * v[i] - m.pressure.beads * grad_rho[i] -
               m.pressure.rods * grad_sigma[i] + field;
    });
}

/// The equations of rod_bead_model.hpp, line by line.
std::vector<Values> written_rates(const Equations& e, const State& s, const Calculus& d) {
    const Model m = written(e.model);
    std::vector<Values> rates;
    if (physics::form(e.model).bead_density >= 0)
        rates.push_back(density_rate(s.rho, m.diffusion.beads, product(s.rho, s.vx), product(s.rho, s.vy), d));
    if (physics::form(e.model).rod_density >= 0) {
        const Values carried =
            at_each([&](std::size_t i) { return m.current.speed * (m.current.kind == "order" ? 1.0 : s.sigma[i]); });
        rates.push_back(density_rate(s.sigma, m.diffusion.rods, product(carried, s.px), product(carried, s.py), d));
    }
    if (physics::form(e.model).bead_velocity >= 0) {
        const Values div = divergence(s.vx, s.vy, d);
        const Force force = driving_force(e, s, d);
        rates.push_back(velocity_rate(e, s, s.vx, force.x, d.x(div), d));
        rates.push_back(velocity_rate(e, s, s.vy, force.y, d.y(div), d));
    }
    const Values div = divergence(s.px, s.py, d);
    const Values square = at_each([&](std::size_t i) { return s.px[i] * s.px[i] + s.py[i] * s.py[i]; });
    rates.push_back(
        order_rate(e, s, s.px, s.vx, d.x(div), d.x(s.rho), d.x(s.sigma), d.x(square), m.orienting_field.x, d));
    rates.push_back(
        order_rate(e, s, s.py, s.vy, d.y(div), d.y(s.rho), d.y(s.sigma), d.y(square), m.orienting_field.y, d));
    return rates;
}

/// Largest difference from the solver's rate, relative to the largest rate, about a reference that is not the mean.
double difference(const Model& model, Threads& threads) {
    const Equations e(model);
    const Calculus d(threads);
    State s = smooth_state(model.uniform);
    // Absent fields are uniform: their gradients are zero, and no coefficient depends on them.
    if (physics::form(e.model).bead_density < 0) s.rho.assign(s.rho.size(), model.uniform.bead_density);
    if (physics::form(e.model).rod_density < 0) s.sigma.assign(s.sigma.size(), model.uniform.rod_density);
    if (physics::form(e.model).velocity == Velocity::slaved) balance(e, s, d);
    const Densities about = physics::form(e.model).bead_density < 0 ? mean_densities(model) : Densities{1.2, 0.8};
    numerics::WholeRate rate = whole_rate(e, grid, about, threads);
    const numerics::Transform transform(grid, rate.system.degree, threads);
    Fields fields(grid, numerics::components(rate.system.layout));
    const auto put = [&](int component, const Values& values) {
        if (component >= 0) std::copy(values.begin(), values.end(), fields[component].begin());
    };
    put(physics::form(e.model).bead_density, s.rho);
    put(physics::form(e.model).rod_density, s.sigma);
    put(physics::form(e.model).bead_velocity, s.vx);
    if (physics::form(e.model).bead_velocity >= 0) put(physics::form(e.model).bead_velocity + 1, s.vy);
    put(physics::form(e.model).polar_order, s.px);
    put(physics::form(e.model).polar_order + 1, s.py);
    Spectra state(grid, fields.count());
    transform.forward(fields, state);
    transform.backward(rate(time, state), fields);
    const std::vector<Values> expected = written_rates(e, s, d);
    EXPECT_EQ(expected.size(), static_cast<std::size_t>(fields.count()));
    double wrong = 0.0, largest = 0.0;
    for (std::size_t c = 0; c < expected.size(); ++c)
        for (std::size_t i = 0; i < fields.size; ++i) {
            wrong = std::max(wrong, std::abs(fields[static_cast<int>(c)][i] - expected[c][i]));
            largest = std::max(largest, std::abs(expected[c][i]));
        }
    return wrong / largest;
}

TEST(RightHandSide, matches_the_written_equations_in_every_form) {
    Threads threads(1);
    for (const NamedModel& form : all_forms()) {
        // What a division by the densities leaves beyond the cut, and rounding of derivatives: some 1e-13.
        EXPECT_LT(difference(form.model, threads), 1e-11) << form.name;
        if (form.model.force.kind == "none") continue;
        Model model = form.model;
        model.force = {.kind = "point",
                       .x = 0.9,
                       .y = -0.4,
                       .at_x = 2.0,
                       .at_y = 5.0,
                       .velocity_x = 1.3,
                       .velocity_y = -0.6,
                       .width = 0.9};
        // Of the Gaussian exp(-(8.4 * 0.9)^2/2) = 4e-13 is beyond the cut.
        EXPECT_LT(difference(model, threads), 1e-11) << form.name << ", a force at a point";
    }
}

}  // namespace
}  // namespace drover::physics::equations_tests
