// physics/terms.cpp: the terms of the rod-bead equations, one line each, in the order of the equations.
#include <algorithm>
#include <cmath>

#include "body_force.hpp"
#include "drover/physics/term.hpp"
#include "term_shapes.hpp"

namespace drover::physics {

namespace {
using numerics::Wavevector;

bool is_dynamic(const CompiledModel& e) { return e.form.velocity == Velocity::dynamic; }

// ---- -div(rho v): beads carried by their own velocity

Term bead_current() {
    return {.name = "bead_current",
            .of = Equation::bead_density,
            .is_active =
                [](const CompiledModel& e) { return e.form.bead_density >= 0 && e.form.velocity != Velocity::absent; },
            .equation = [](const CompiledModel&) -> std::string { return "d_t rho: -div(rho v)"; },
            .linearise =
                [](const CompiledModel&, const UniformPoint& about, const Wavevector& q, Symbol& m) {
                    m(rho, v_x) -= i_unit * q.x * about.bead_density;
                    m(rho, v_y) -= i_unit * q.y * about.bead_density;
                    m(rho, rho) -= i_unit * (q.x * about.velocity.x() + q.y * about.velocity.y());
                },
            .cost =
                [](const CompiledModel&, bool) {
                    return PointCost{.reads = reads(Input::bead_density) | reads_velocity,
                                     .writes = writes(Output::bead_flux),
                                     .degree = 2};
                },
            .remainder =
                [](const CompiledModel&, const Reference& ref, const PointFields& f, const PointRates& r) {
                    const double* density = f[Input::bead_density];
                    const auto v = f.velocity();
                    const auto flux = r.vector(Output::bead_flux);
                    for_points(f.size, [&](std::size_t i) {
                        flux.x[i] += density[i] * v.x[i] - ref.bead_density * f.linear_velocity.x[i];
                        flux.y[i] += density[i] * v.y[i] - ref.bead_density * f.linear_velocity.y[i];
                    });
                }};
}

// ---- -div J, J = u p or u sigma p

Term rod_current() {
    return {.name = "current.speed",
            .of = Equation::rod_density,
            .is_active = [](const CompiledModel& e) { return e.form.rod_density >= 0 && e.model.current.speed != 0.0; },
            .equation =
                [](const CompiledModel& e) {
                    return text("d_t sigma: -div({}), u = {} mm/s", e.form.order_is_density ? "u p" : "u sigma p",
                                e.model.current.speed);
                },
            .linearise =
                [](const CompiledModel& e, const UniformPoint& about, const Wavevector& q, Symbol& m) {
                    const double carried = e.form.order_is_density ? 1.0 : about.rod_density, u = e.model.current.speed;
                    m(sigma, p_x) -= i_unit * q.x * u * carried;
                    m(sigma, p_y) -= i_unit * q.y * u * carried;
                    if (!e.form.order_is_density)
                        m(sigma, sigma) -= i_unit * u * (q.x * about.order.x() + q.y * about.order.y());
                },
            .cost =
                [](const CompiledModel& e, bool) {
                    if (e.form.order_is_density) return PointCost{};
                    return PointCost{.reads = reads(Input::rod_density) | reads_order,
                                     .writes = writes(Output::rod_flux),
                                     .degree = 2};
                },
            .remainder =
                [](const CompiledModel& e, const Reference& ref, const PointFields& f, const PointRates& r) {
                    const double* density = f[Input::rod_density];
                    const auto p = f.order();
                    const auto flux = r.vector(Output::rod_flux);
                    for_points(f.size, [&](std::size_t i) {
                        const double carried = e.model.current.speed * (density[i] - ref.rod_density);
                        flux.x[i] += carried * p.x[i];
                        flux.y[i] += carried * p.y[i];
                    });
                }};
}

// ---- -rho v.grad v, as an acceleration

Term bead_advection() {
    return {.name = "inertia.advection",
            .of = Equation::acceleration,
            .is_active = [](const CompiledModel& e) { return is_dynamic(e) && e.model.inertia.advection; },
            .equation = [](const CompiledModel&) -> std::string { return "m rho d_t v: -m rho v.grad v"; },
            .linearise =
                [](const CompiledModel& e, const UniformPoint& about, const Wavevector& q, Symbol& m) {
                    const double moved = e.model.inertia.bead_mass * about.bead_density;
                    add_diagonal(-i_unit * moved * (q.x * about.velocity.x() + q.y * about.velocity.y()), v_x, v_x, m);
                },
            .cost =
                [](const CompiledModel&, bool) {
                    return PointCost{.reads = reads_velocity | reads(Input::velocity_curl),
                                     .writes = writes(Output::velocity) | writes(Output::velocity_potential),
                                     .degree = 2};
                },
            .remainder =
                [](const CompiledModel&, const Reference&, const PointFields& f, const PointRates& r) {
                    add_self_advection(1.0, f.velocity(), f[Input::velocity_curl], f.size, r.vector(Output::velocity),
                                       r[Output::velocity_potential]);
                }};
}

// ---- alpha_3 |p|^2 p

Term cubic_driving() {
    return product(
        "m rho d_t v: alpha_3 |p|^2 p", "driving.cubic",
        {.reads = reads_order, .writes = writes(Output::force), .degree = 3},
        [](double cubic, const UniformPoint& about, const Wavevector&, Symbol& m) {
            add_diagonal(cubic * about.order.squaredNorm(), v_x, p_x, m);
            for (int i = 0; i < 2; ++i)
                for (int j = 0; j < 2; ++j) m(v_x + i, p_x + j) += 2.0 * cubic * about.order(i) * about.order(j);
        },
        [](double cubic, const PointFields& f, const PointRates& r) {
            const auto p = f.order();
            const auto force = r.vector(Output::force);
            for_points(f.size, [=](std::size_t i) {
                const double strength = cubic * (p.x[i] * p.x[i] + p.y[i] * p.y[i]);
                force.x[i] += strength * p.x[i];
                force.y[i] += strength * p.y[i];
            });
        });
}

// ---- sources

bool has_force(const CompiledModel& e, const char* kind) {
    return e.form.velocity != Velocity::absent && e.model.force.kind == kind;
}

Term uniform_force() {
    return {.name = "force",
            .of = Equation::bead_velocity,
            .is_active = [](const CompiledModel& e) { return has_force(e, "uniform"); },
            .equation =
                [](const CompiledModel& e) {
                    return text("m rho d_t v: uniform force ({}, {}) mg/(mm s^2)", e.model.force.x, e.model.force.y);
                },
            .source =
                [](const CompiledModel& e, const numerics::Grid&, double, const Wavevector&) {
                    return VectorMode{e.model.force.x, e.model.force.y};
                },
            .source_is_uniform = true};
}

Term point_force() {
    return {.name = "force",
            .of = Equation::bead_velocity,
            .is_active = [](const CompiledModel& e) { return has_force(e, "point"); },
            .equation =
                [](const CompiledModel& e) {
                    return text("m rho d_t v: point force ({}, {}) mg mm/s^2", e.model.force.x, e.model.force.y);
                },
            .source = [](const CompiledModel& e, const numerics::Grid& grid, double t,
                         const Wavevector& q) { return point_force_mode(e.model.force, grid, t, q); }};
}

Term orienting_field() {
    return {.name = "orienting_field",
            .is_active =
                [](const CompiledModel& e) {
                    return e.model.orienting_field.x != 0.0 || e.model.orienting_field.y != 0.0;
                },
            .equation =
                [](const CompiledModel& e) {
                    return text("d_t p: h = ({}, {}) [p]/s", e.model.orienting_field.x, e.model.orienting_field.y);
                },
            .source =
                [](const CompiledModel& e, const numerics::Grid&, double, const Wavevector&) {
                    return VectorMode{e.model.orienting_field.x, e.model.orienting_field.y};
                },
            .source_is_uniform = true};
}

// ---- -w p.grad p and -b |p|^2 p

Term self_advection() {
    return product(
        "d_t p: -w p.grad p", "advection.strength",
        {.reads = reads_order | reads(Input::order_curl),
         .writes = writes(Output::order) | writes(Output::order_potential),
         .degree = 2},
        [](double w, const UniformPoint& about, const Wavevector& q, Symbol& m) {
            add_diagonal(-i_unit * w * (q.x * about.order.x() + q.y * about.order.y()), p_x, p_x, m);
        },
        [](double w, const PointFields& f, const PointRates& r) {
            add_self_advection(w, f.order(), f[Input::order_curl], f.size, r.vector(Output::order),
                               r[Output::order_potential]);
        });
}

Term divergence_advection() {
    return product(
        "d_t p: -lambda_2 p div p", "advection.divergence",
        {.reads = reads_order | reads(Input::order_divergence), .writes = writes(Output::order), .degree = 2},
        [](double lambda, const UniformPoint& about, const Wavevector& q, Symbol& m) {
            for (int i = 0; i < 2; ++i) {
                m(p_x + i, p_x) -= i_unit * lambda * about.order(i) * q.x;
                m(p_x + i, p_y) -= i_unit * lambda * about.order(i) * q.y;
            }
        },
        [](double lambda, const PointFields& f, const PointRates& r) {
            const double* divergence = f[Input::order_divergence];
            const auto p = f.order();
            const auto rate = r.vector(Output::order);
            for_points(f.size, [=](std::size_t i) {
                rate.x[i] -= lambda * divergence[i] * p.x[i];
                rate.y[i] -= lambda * divergence[i] * p.y[i];
            });
        });
}

Term gradient_advection() {
    return product(
        "d_t p: -lambda_3 grad |p|^2", "advection.gradient",
        {.reads = reads_order, .writes = writes(Output::order_potential), .degree = 2},
        [](double lambda, const UniformPoint& about, const Wavevector& q, Symbol& m) {
            for (int j = 0; j < 2; ++j) {
                m(p_x, p_x + j) -= 2.0 * i_unit * lambda * q.x * about.order(j);
                m(p_y, p_x + j) -= 2.0 * i_unit * lambda * q.y * about.order(j);
            }
        },
        [](double lambda, const PointFields& f, const PointRates& r) {
            const auto p = f.order();
            double* potential = r[Output::order_potential];
            for_points(f.size, [=](std::size_t i) { potential[i] -= lambda * (p.x[i] * p.x[i] + p.y[i] * p.y[i]); });
        });
}

template <int Vector>
void minus_vector_bilaplacian(double constant, const Wavevector& q, Symbol& m) {
    const double square = q.x * q.x + q.y * q.y;
    for (const int i : {Vector, Vector + 1}) m(i, i) -= constant * square * square;
}

Term of_fourth_degree(Term term) {
    term.degree_in_q = 4;
    return term;
}

Term saturation() {
    return {.name = "relaxation.saturation",
            .is_active = [](const CompiledModel& e) { return e.saturation.is_active(); },
            .equation =
                [](const CompiledModel& e) {
                    return text("d_t p: -b |p|^2 p, b = {} 1/s/[p]^2", e.saturation.text_of());
                },
            .linearise =
                [](const CompiledModel& e, const UniformPoint& about, const Wavevector&, Symbol& m) {
                    const Dependence b = e.saturation.at(about.bead_density, about.rod_density);
                    const double square = about.order.squaredNorm();
                    add_diagonal(-(b.value * square), p_x, p_x, m);
                    for (int i = 0; i < 2; ++i)
                        for (int j = 0; j < 2; ++j)
                            m(p_x + i, p_x + j) -= 2.0 * b.value * about.order(i) * about.order(j);
                    add_slopes(b, about.order, -square, p_x, m);
                },
            .cost =
                [](const CompiledModel& e, bool) {
                    return PointCost{.reads = reads_of(e.saturation) | reads_order,
                                     .writes = writes(Output::order),
                                     .degree = 3 + e.saturation.degree()};
                },
            .remainder =
                [](const CompiledModel& e, const Reference&, const PointFields& f, const PointRates& r) {
                    const auto p = f.order();
                    const auto rate = r.vector(Output::order);
                    for_coefficient(e.saturation, 0.0, f, [&](std::size_t i, double b) {
                        const double decay = b * (p.x[i] * p.x[i] + p.y[i] * p.y[i]);
                        rate.x[i] -= decay * p.x[i];
                        rate.y[i] -= decay * p.y[i];
                    });
                }};
}
}  // namespace

const std::vector<Term>& built_in_terms() {
    // clang-format off
    static const std::vector<Term> terms{
        // d_t rho
        bead_current(),
        linear("d_t rho: D_rho lap rho", "diffusion.beads", laplacian<rho>),

        // d_t sigma
        rod_current(),
        linear("d_t sigma: D_sigma lap sigma", "diffusion.rods", laplacian<sigma>),

        // m rho d_t v
        bead_advection(),
        proportional("m rho d_t v: -Gamma v", "drag.coefficient", -1.0, v_x, v_x),
        linear("m rho d_t v: eta lap v", "viscosity.shear", vector_laplacian<v_x>),
        linear("m rho d_t v: zeta grad(div v)", "viscosity.bulk", gradient_of_divergence<v_x>),
        proportional("m rho d_t v: alpha p", "driving.strength", 1.0, p_x, v_x),
        cubic_driving(),
        linear("m rho d_t v: -E grad rho", "stiffness.beads", minus_gradient<rho, v_x>),
        linear("m rho d_t v: -F grad sigma", "stiffness.rods", minus_gradient<sigma, v_x>),
        uniform_force(),
        point_force(),

        // d_t p
        self_advection(),
        divergence_advection(),
        gradient_advection(),
        proportional("d_t p: -a p", "relaxation.rate", -1.0, p_x, p_x),
        saturation(),
        linear("d_t p: K3 lap p", "elasticity.stiffness", vector_laplacian<p_x>),
        linear("d_t p: K1 grad(div p)", "elasticity.splay", gradient_of_divergence<p_x>),
        of_fourth_degree(linear("d_t p: -K4 lap^2 p", "elasticity.bilaplacian", minus_vector_bilaplacian<p_x>)),
        proportional("d_t p: lambda v", "weathercock.strength", 1.0, v_x, p_x),
        linear("d_t p: -A grad rho", "pressure.beads", minus_gradient<rho, p_x>),
        linear("d_t p: -B grad sigma", "pressure.rods", minus_gradient<sigma, p_x>),
        orienting_field()};
    // clang-format on
    return terms;
}

}  // namespace drover::physics
