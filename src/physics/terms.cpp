// physics/terms.cpp: the terms, each as its linearisation about any uniform state and its action at points of the grid.
#include <algorithm>
#include <array>
#include <cmath>

#include "drover/physics/term.hpp"
#include "point_arrays.hpp"

namespace drover::physics {

namespace {
using numerics::Wavevector;
using std::complex;
constexpr complex<double> i_unit{0.0, 1.0};

bool has_beads(const Equations& e) { return e.form.bead_density >= 0; }
bool has_rods(const Equations& e) { return e.form.rod_density >= 0; }
bool has_velocity(const Equations& e) { return e.form.velocity != Velocity::absent; }
bool is_dynamic(const Equations& e) { return e.form.velocity == Velocity::dynamic; }

Dependence at(const Coefficient& c, const UniformPoint& point) { return c.at(point.bead_density, point.rod_density); }

/// The rows that follow `row` get factor * vector; in the columns of the densities, slopes of a coefficient times a vector.
void add_slopes(const Dependence& c, const Eigen::Vector2d& vector, double sign, FieldIndex::Value row, Symbol& m) {
    for (int i = 0; i < 2; ++i) {
        m(row + i, FieldIndex::bead_density) += sign * c.by_beads * vector(i);
        m(row + i, FieldIndex::rod_density) += sign * c.by_rods * vector(i);
    }
}
void add_diagonal(complex<double> factor, FieldIndex::Value row, FieldIndex::Value column, Symbol& m) {
    m(row, column) += factor;
    m(row + 1, column + 1) += factor;
}
/// laplacian * lap + divergence * grad div of a vector.
void add_elastic(double laplacian, double divergence, const Wavevector& q, FieldIndex::Value place, Symbol& m) {
    add_diagonal(-laplacian * (q.x * q.x + q.y * q.y), place, place, m);
    const std::array<double, 2> k{q.x, q.y};
    for (int i = 0; i < 2; ++i)
        for (int j = 0; j < 2; ++j)
            m(place + i, place + j) -= divergence * k[static_cast<std::size_t>(i)] * k[static_cast<std::size_t>(j)];
}
/// -strength grad of a density.
void add_gradient(double strength, const Wavevector& q, FieldIndex::Value row, FieldIndex::Value density, Symbol& m) {
    m(row, density) -= i_unit * strength * q.x;
    m(row + 1, density) -= i_unit * strength * q.y;
}

/// Points at a time whose coefficients stand on the stack.
constexpr std::size_t max_strip = 256;
using Strip = std::array<double, max_strip>;

/// body(i, value of the coefficient less a reference) at every point.
template <class Body>
void for_coefficient(const Coefficient& c, double reference_value, const PointFields& f, Body body) {
    Strip values;
    for (std::size_t begin = 0; begin < f.size; begin += max_strip) {
        const std::size_t count = std::min(max_strip, f.size - begin);
        c.evaluate(f.bead_density ? f.bead_density + begin : nullptr, f.rod_density ? f.rod_density + begin : nullptr,
                   reference_value, std::span(values.data(), count));
        for (std::size_t i = 0; i < count; ++i) body(begin + i, values[i]);
    }
}

/// out += sign * (coefficient - its reference) * vector.
void add_varying(const Coefficient& c, const Reference& ref, double sign, const PointFields& f,
                 const VectorStrip<const double>& vector, const VectorStrip<double>& out) {
    for_coefficient(c, c.at(ref.bead_density, ref.rod_density).value, f, [&](std::size_t i, double value) {
        out.x[i] += sign * value * vector.x[i];
        out.y[i] += sign * value * vector.y[i];
    });
}

/// -strength v.grad v = -strength [grad v^2/2 + curl v (z x v)].
void add_self_advection(double strength, const VectorStrip<const double>& v, const double* curl, std::size_t size,
                        const VectorStrip<double>& rate, double* head) {
    for (std::size_t i = 0; i < size; ++i) {
        const double turning = strength * curl[i];
        rate.x[i] += turning * v.y[i];
        rate.y[i] -= turning * v.x[i];
        head[i] -= 0.5 * strength * (v.x[i] * v.x[i] + v.y[i] * v.y[i]);
    }
}

// ---- d_t rho = -div(rho v) + D lap rho

const Term bead_current{.name = "bead_current",
                        .is_active = [](const Equations& e) { return has_beads(e) && has_velocity(e); },
                        .equation = [](const Equations&) -> std::string { return "d_t rho: -div(rho v)"; },
                        .linearise =
                            [](const Equations&, const UniformPoint& about, const Wavevector& q, Symbol& m) {
                                m(FieldIndex::bead_density, FieldIndex::bead_velocity_x) -=
                                    i_unit * q.x * about.bead_density;
                                m(FieldIndex::bead_density, FieldIndex::bead_velocity_y) -=
                                    i_unit * q.y * about.bead_density;
                                m(FieldIndex::bead_density, FieldIndex::bead_density) -=
                                    i_unit * (q.x * about.velocity.x() + q.y * about.velocity.y());
                            },
                        .cost =
                            [](const Equations& e) {
                                return Action{.reads = reads_beads | reads_velocity,
                                              .writes = writes_bead_flux,
                                              .degree = slaved_varies(e) ? 3 : 2};
                            },
                        .act =
                            [](const Equations&, const Reference& ref, const PointFields& f, const PointRates& r) {
                                for (std::size_t i = 0; i < f.size; ++i) {
                                    r.bead_flux.x[i] +=
                                        f.bead_density[i] * f.velocity.x[i] - ref.bead_density * f.linear_velocity.x[i];
                                    r.bead_flux.y[i] +=
                                        f.bead_density[i] * f.velocity.y[i] - ref.bead_density * f.linear_velocity.y[i];
                                }
                            }};

const Term bead_diffusion{
    .name = "diffusion.beads",
    .is_active = [](const Equations& e) { return has_beads(e) && e.model.diffusion.beads != 0.0; },
    .equation = [](const Equations& e) { return text("d_t rho: D lap rho, D = {} mm^2/s", e.model.diffusion.beads); },
    .linearise =
        [](const Equations& e, const UniformPoint&, const Wavevector& q, Symbol& m) {
            m(FieldIndex::bead_density, FieldIndex::bead_density) -= e.model.diffusion.beads * (q.x * q.x + q.y * q.y);
        }};

// ---- d_t sigma = -div J + D lap sigma

const Term rod_current{.name = "current",
                       .is_active = [](const Equations& e) { return has_rods(e) && e.model.current.speed != 0.0; },
                       .equation =
                           [](const Equations& e) {
                               return text("d_t sigma: -div({}), u = {} mm/s",
                                           e.form.order_is_density ? "u p" : "u sigma p", e.model.current.speed);
                           },
                       .linearise =
                           [](const Equations& e, const UniformPoint& about, const Wavevector& q, Symbol& m) {
                               const double carried = e.form.order_is_density ? 1.0 : about.rod_density;
                               m(FieldIndex::rod_density, FieldIndex::polar_order_x) -=
                                   i_unit * q.x * e.model.current.speed * carried;
                               m(FieldIndex::rod_density, FieldIndex::polar_order_y) -=
                                   i_unit * q.y * e.model.current.speed * carried;
                               if (!e.form.order_is_density)
                                   m(FieldIndex::rod_density, FieldIndex::rod_density) -=
                                       i_unit * e.model.current.speed * (q.x * about.order.x() + q.y * about.order.y());
                           },
                       .cost =
                           [](const Equations& e) {
                               if (e.form.order_is_density) return Action{};
                               return Action{.reads = reads_rods | reads_order, .writes = writes_rod_flux, .degree = 2};
                           },
                       .act =
                           [](const Equations& e, const Reference& ref, const PointFields& f, const PointRates& r) {
                               for (std::size_t i = 0; i < f.size; ++i) {
                                   const double carried = e.model.current.speed * (f.rod_density[i] - ref.rod_density);
                                   r.rod_flux.x[i] += carried * f.order.x[i];
                                   r.rod_flux.y[i] += carried * f.order.y[i];
                               }
                           }};

const Term rod_diffusion{.name = "diffusion.rods",
                         .is_active = [](const Equations& e) { return has_rods(e) && e.model.diffusion.rods != 0.0; },
                         .equation =
                             [](const Equations& e) {
                                 return text("d_t sigma: D lap sigma, D = {} mm^2/s", e.model.diffusion.rods);
                             },
                         .linearise =
                             [](const Equations& e, const UniformPoint&, const Wavevector& q, Symbol& m) {
                                 m(FieldIndex::rod_density, FieldIndex::rod_density) -=
                                     e.model.diffusion.rods * (q.x * q.x + q.y * q.y);
                             }};

// ---- m rho d_t v = -m rho v.grad v - Gamma v + eta lap v + zeta grad div v + alpha p - E grad rho - F grad sigma + force

const Term bead_advection{.name = "inertia.advection",
                          .is_active = [](const Equations& e) { return is_dynamic(e) && e.model.inertia.advection; },
                          .equation = [](const Equations&) -> std::string { return "m rho d_t v: -m rho v.grad v"; },
                          .linearise =
                              [](const Equations& e, const UniformPoint& about, const Wavevector& q, Symbol& m) {
                                  const double moved = e.model.inertia.bead_mass * about.bead_density;
                                  add_diagonal(-i_unit * moved * (q.x * about.velocity.x() + q.y * about.velocity.y()),
                                               FieldIndex::bead_velocity_x, FieldIndex::bead_velocity_x, m);
                              },
                          .cost =
                              [](const Equations&) {
                                  return Action{.reads = reads_velocity | reads_velocity_curl,
                                                .writes = writes_velocity | writes_velocity_head,
                                                .degree = 2};
                              },
                          .act =
                              [](const Equations&, const Reference&, const PointFields& f, const PointRates& r) {
                                  add_self_advection(1.0, f.velocity, f.velocity_curl, f.size, r.velocity,
                                                     r.velocity_head);
                              }};

const Term drag{.name = "drag",
                .is_active = [](const Equations& e) { return has_velocity(e) && e.drag.is_active(); },
                .equation =
                    [](const Equations& e) {
                        return text("m rho d_t v: -Gamma v, Gamma = {} mg/(mm^2 s)", e.drag.text_of());
                    },
                .linearise =
                    [](const Equations& e, const UniformPoint& about, const Wavevector&, Symbol& m) {
                        const Dependence gamma = at(e.drag, about);
                        add_diagonal(-gamma.value, FieldIndex::bead_velocity_x, FieldIndex::bead_velocity_x, m);
                        add_slopes(gamma, about.velocity, -1.0, FieldIndex::bead_velocity_x, m);
                    },
                .cost =
                    [](const Equations& e) {
                        if (!e.drag.varies() || !is_dynamic(e)) return Action{};
                        return Action{.reads = reads_of(e.drag) | reads_velocity,
                                      .writes = writes_force,
                                      .degree = 1 + e.drag.degree()};
                    },
                .act = [](const Equations& e, const Reference& ref, const PointFields& f,
                          const PointRates& r) { add_varying(e.drag, ref, -1.0, f, f.velocity, r.force); }};

const Term viscosity{.name = "viscosity",
                     .is_active =
                         [](const Equations& e) {
                             return has_velocity(e) &&
                                    (e.model.viscosity.shear != 0.0 || e.model.viscosity.bulk != 0.0);
                         },
                     .equation =
                         [](const Equations& e) {
                             return text("m rho d_t v: eta lap v + zeta grad(div v), eta = {}, zeta = {} mg/s",
                                         e.model.viscosity.shear, e.model.viscosity.bulk);
                         },
                     .linearise =
                         [](const Equations& e, const UniformPoint&, const Wavevector& q, Symbol& m) {
                             add_elastic(e.model.viscosity.shear, e.model.viscosity.bulk, q,
                                         FieldIndex::bead_velocity_x, m);
                         }};

const Term driving{.name = "driving",
                   .is_active = [](const Equations& e) { return has_velocity(e) && e.driving.is_active(); },
                   .equation =
                       [](const Equations& e) {
                           return text("m rho d_t v: alpha p, alpha = {} mg/(mm s^2)/[p]", e.driving.text_of());
                       },
                   .linearise =
                       [](const Equations& e, const UniformPoint& about, const Wavevector&, Symbol& m) {
                           const Dependence alpha = at(e.driving, about);
                           add_diagonal(alpha.value, FieldIndex::bead_velocity_x, FieldIndex::polar_order_x, m);
                           add_slopes(alpha, about.order, 1.0, FieldIndex::bead_velocity_x, m);
                       },
                   .cost =
                       [](const Equations& e) {
                           if (!e.driving.varies() || !is_dynamic(e)) return Action{};
                           return Action{.reads = reads_of(e.driving) | reads_order,
                                         .writes = writes_force,
                                         .degree = 1 + e.driving.degree()};
                       },
                   .act = [](const Equations& e, const Reference& ref, const PointFields& f,
                             const PointRates& r) { add_varying(e.driving, ref, 1.0, f, f.order, r.force); }};

const Term bead_pressure{
    .name = "stiffness.beads",
    .is_active = [](const Equations& e) { return has_velocity(e) && has_beads(e) && e.model.stiffness.beads != 0.0; },
    .equation =
        [](const Equations& e) {
            return text("m rho d_t v: -E grad rho, E = {} mg mm^2/s^2", e.model.stiffness.beads);
        },
    .linearise =
        [](const Equations& e, const UniformPoint&, const Wavevector& q, Symbol& m) {
            add_gradient(e.model.stiffness.beads, q, FieldIndex::bead_velocity_x, FieldIndex::bead_density, m);
        }};

const Term rod_pressure{
    .name = "stiffness.rods",
    .is_active = [](const Equations& e) { return has_velocity(e) && has_rods(e) && e.model.stiffness.rods != 0.0; },
    .equation =
        [](const Equations& e) {
            return text("m rho d_t v: -F grad sigma, F = {} mg mm^2/s^2", e.model.stiffness.rods);
        },
    .linearise =
        [](const Equations& e, const UniformPoint&, const Wavevector& q, Symbol& m) {
            add_gradient(e.model.stiffness.rods, q, FieldIndex::bead_velocity_x, FieldIndex::rod_density, m);
        }};

const Term body_force{.name = "force",
                      .is_active = [](const Equations& e) { return has_velocity(e) && e.model.force.kind != "none"; },
                      .equation =
                          [](const Equations& e) {
                              return text("m rho d_t v: a {} force of ({}, {})", e.model.force.kind, e.model.force.x,
                                          e.model.force.y);
                          },
                      .linearise = [](const Equations&, const UniformPoint&, const Wavevector&, Symbol&) {}};

// ---- d_t p = -w p.grad p - (a + b p^2) p + K3 lap p + K1 grad div p + lambda v - A grad rho - B grad sigma + h

const Term self_advection{
    .name = "advection",
    .is_active = [](const Equations& e) { return e.model.advection.strength != 0.0; },
    .equation =
        [](const Equations& e) { return text("d_t p: -w p.grad p, w = {} mm/s/[p]", e.model.advection.strength); },
    .linearise =
        [](const Equations& e, const UniformPoint& about, const Wavevector& q, Symbol& m) {
            add_diagonal(-i_unit * e.model.advection.strength * (q.x * about.order.x() + q.y * about.order.y()),
                         FieldIndex::polar_order_x, FieldIndex::polar_order_x, m);
        },
    .cost =
        [](const Equations&) {
            return Action{.reads = reads_order | reads_order_curl,
                          .writes = writes_order | writes_order_head,
                          .degree = 2};
        },
    .act =
        [](const Equations& e, const Reference&, const PointFields& f, const PointRates& r) {
            add_self_advection(e.model.advection.strength, f.order, f.order_curl, f.size, r.order, r.order_head);
        }};

const Term relaxation{
    .name = "relaxation",
    .is_active = [](const Equations& e) { return e.relaxation.is_active() || e.saturation.is_active(); },
    .equation =
        [](const Equations& e) {
            return text("d_t p: -(a + b |p|^2) p, a = {} 1/s, b = {} 1/s/[p]^2", e.relaxation.text_of(),
                        e.saturation.text_of());
        },
    .linearise =
        [](const Equations& e, const UniformPoint& about, const Wavevector&, Symbol& m) {
            const Dependence a = at(e.relaxation, about), b = at(e.saturation, about);
            const double square = about.order.squaredNorm();
            add_diagonal(-(a.value + b.value * square), FieldIndex::polar_order_x, FieldIndex::polar_order_x, m);
            for (int i = 0; i < 2; ++i)
                for (int j = 0; j < 2; ++j)
                    m(FieldIndex::polar_order_x + i, FieldIndex::polar_order_x + j) -=
                        2.0 * b.value * about.order(i) * about.order(j);
            add_slopes(a, about.order, -1.0, FieldIndex::polar_order_x, m);
            add_slopes(b, about.order, -square, FieldIndex::polar_order_x, m);
        },
    .cost =
        [](const Equations& e) {
            if (!e.relaxation.varies() && !e.saturation.is_active()) return Action{};
            return Action{.reads = reads_of(e.relaxation) | reads_of(e.saturation) | reads_order,
                          .writes = writes_order,
                          .degree = std::max(e.relaxation.varies() ? 1 + e.relaxation.degree() : 1,
                                             e.saturation.is_active() ? 3 + e.saturation.degree() : 1)};
        },
    .act =
        [](const Equations& e, const Reference& ref, const PointFields& f, const PointRates& r) {
            if (e.relaxation.varies()) add_varying(e.relaxation, ref, -1.0, f, f.order, r.order);
            if (!e.saturation.is_active()) return;
            for_coefficient(e.saturation, 0.0, f, [&](std::size_t i, double b) {
                const double decay = b * (f.order.x[i] * f.order.x[i] + f.order.y[i] * f.order.y[i]);
                r.order.x[i] -= decay * f.order.x[i];
                r.order.y[i] -= decay * f.order.y[i];
            });
        }};

const Term elasticity{.name = "elasticity",
                      .is_active =
                          [](const Equations& e) {
                              return e.model.elasticity.stiffness != 0.0 || e.model.elasticity.splay != 0.0;
                          },
                      .equation =
                          [](const Equations& e) {
                              return text("d_t p: K3 lap p + K1 grad(div p), K3 = {}, K1 = {} mm^2/s",
                                          e.model.elasticity.stiffness, e.model.elasticity.splay);
                          },
                      .linearise =
                          [](const Equations& e, const UniformPoint&, const Wavevector& q, Symbol& m) {
                              add_elastic(e.model.elasticity.stiffness, e.model.elasticity.splay, q,
                                          FieldIndex::polar_order_x, m);
                          }};

const Term weathercock{
    .name = "weathercock",
    .is_active = [](const Equations& e) { return has_velocity(e) && e.weathercock.is_active(); },
    .equation = [](const Equations& e) { return text("d_t p: lambda v, lambda = {} [p]/mm", e.weathercock.text_of()); },
    .linearise =
        [](const Equations& e, const UniformPoint& about, const Wavevector&, Symbol& m) {
            const Dependence lambda = at(e.weathercock, about);
            add_diagonal(lambda.value, FieldIndex::polar_order_x, FieldIndex::bead_velocity_x, m);
            add_slopes(lambda, about.velocity, 1.0, FieldIndex::polar_order_x, m);
        },
    .cost =
        [](const Equations& e) {
            if (!e.weathercock.varies() && !slaved_varies(e)) return Action{};
            return Action{.reads = reads_of(e.weathercock) | reads_velocity,
                          .writes = writes_order,
                          .degree = 1 + e.weathercock.degree() + (slaved_varies(e) ? 1 : 0)};
        },
    .act =
        [](const Equations& e, const Reference& ref, const PointFields& f, const PointRates& r) {
            const double lambda_ref = e.weathercock.at(ref.bead_density, ref.rod_density).value;
            for_coefficient(e.weathercock, 0.0, f, [&](std::size_t i, double lambda) {
                r.order.x[i] += lambda * f.velocity.x[i] - lambda_ref * f.linear_velocity.x[i];
                r.order.y[i] += lambda * f.velocity.y[i] - lambda_ref * f.linear_velocity.y[i];
            });
        }};

const Term bead_crowding{.name = "pressure.beads",
                         .is_active = [](const Equations& e) { return has_beads(e) && e.model.pressure.beads != 0.0; },
                         .equation =
                             [](const Equations& e) {
                                 return text("d_t p: -A grad rho, A = {} [p] mm^3/s", e.model.pressure.beads);
                             },
                         .linearise =
                             [](const Equations& e, const UniformPoint&, const Wavevector& q, Symbol& m) {
                                 add_gradient(e.model.pressure.beads, q, FieldIndex::polar_order_x,
                                              FieldIndex::bead_density, m);
                             }};

const Term rod_crowding{.name = "pressure.rods",
                        .is_active = [](const Equations& e) { return has_rods(e) && e.model.pressure.rods != 0.0; },
                        .equation =
                            [](const Equations& e) {
                                return text("d_t p: -B grad sigma, B = {} [p] mm^3/s", e.model.pressure.rods);
                            },
                        .linearise =
                            [](const Equations& e, const UniformPoint&, const Wavevector& q, Symbol& m) {
                                add_gradient(e.model.pressure.rods, q, FieldIndex::polar_order_x,
                                             FieldIndex::rod_density, m);
                            }};

const Term orienting_field{.name = "orienting_field",
                           .is_active =
                               [](const Equations& e) {
                                   return e.model.orienting_field.x != 0.0 || e.model.orienting_field.y != 0.0;
                               },
                           .equation =
                               [](const Equations& e) {
                                   return text("d_t p: h = ({}, {}) [p]/s", e.model.orienting_field.x,
                                               e.model.orienting_field.y);
                               },
                           .linearise = [](const Equations&, const UniformPoint&, const Wavevector&, Symbol&) {}};
}  // namespace

std::span<const Term> terms() {
    static const std::array all{bead_current,  bead_diffusion, rod_current,    rod_diffusion, bead_advection,
                                drag,          viscosity,      driving,        bead_pressure, rod_pressure,
                                body_force,    self_advection, relaxation,     elasticity,    weathercock,
                                bead_crowding, rod_crowding,   orienting_field};
    return all;
}

}  // namespace drover::physics
