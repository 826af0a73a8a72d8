// physics/right_hand_side.cpp: fields to the grid, every active term at its points, and back.
#include "drover/physics/right_hand_side.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <mutex>

#include "body_force.hpp"
#include "drover/numerics/transform.hpp"
#include "drover/numerics/wavenumbers.hpp"
#include "drover/physics/term.hpp"
#include "point_arrays.hpp"

namespace drover::physics {

namespace {
using numerics::Complex;
using numerics::Spectra;
using numerics::Wavevector;
constexpr std::size_t points_in_cache = 256;  // of some twenty arrays: the first-level cache

Complex times_i(Complex a) { return {-a.imag(), a.real()}; }

/// Rows of the linear operator that give the force on the beads (dynamic) or their velocity (slaved): along q from both densities
/// and the parts of v and p along q; across q from those across.
struct VelocityRow {
    std::array<double, 4> along{};
    std::array<double, 2> across{};
};

VelocityRow velocity_row(const Equations& e, const Reference& ref, double q) {
    const UniformPoint about{.bead_density = ref.bead_density, .rod_density = ref.rod_density};
    Symbol m = force_symbol(e, about, {.x = q, .y = 0.0});
    if (e.form.velocity == Velocity::slaved) {
        // Zero where nothing holds the beads back: there is no such term then.
        for (const int row : {FieldIndex::bead_velocity_x, FieldIndex::bead_velocity_y}) {
            const Complex held = -m(row, row);
            if (held != 0.0) m.row(row) /= held;
            m(row, row) = 0.0;
        }
    }
    // Times i for the vectors: i F = a rho + b sigma + c (i v) + d (i p).
    return {.along = {-m(FieldIndex::bead_velocity_x, FieldIndex::bead_density).imag(),
                      -m(FieldIndex::bead_velocity_x, FieldIndex::rod_density).imag(),
                      m(FieldIndex::bead_velocity_x, FieldIndex::bead_velocity_x).real(),
                      m(FieldIndex::bead_velocity_x, FieldIndex::polar_order_x).real()},
            .across = {m(FieldIndex::bead_velocity_y, FieldIndex::bead_velocity_y).real(),
                       m(FieldIndex::bead_velocity_y, FieldIndex::polar_order_y).real()}};
}

}  // namespace

struct RightHandSide::Work {
    Equations e;
    Reference ref;
    numerics::Grid grid;
    int degree;
    Threads& threads;
    Arrays arrays;
    numerics::Transform transform;
    numerics::DistinctWavenumbers wavenumbers;
    std::vector<VelocityRow> velocity_rows;  // of each |q|
    std::vector<const Term*> acting;         // those that are not linear
    bool forced;                             // by the term "force"
    Spectra made;                            // force or slaved velocity (2), curls, then what comes back
    double drag_ref, driving_ref;
    bool force_varies;  // with the densities, at given v and p
    std::mutex mutex;
    Extremes extremes{};

    Work(const Equations& equations, const numerics::System& linear, const Reference& reference, Threads& the_threads);
    void prepare(double t, const Spectra& state);
    void at_points(const numerics::Strip& strip);
    void balance_velocity(const PointFields& f, const VectorStrip<double>& velocity) const;
    void divide_by_mass(const PointFields& f, const PointRates& r) const;
    void add_force(double t, Spectra& rate);
    ForceMode slaved_by(const ForceMode& force, const Wavevector& q) const;
    void assemble(double t, Spectra& rate);
    std::vector<Complex*> targets(Spectra& rate);
    std::vector<const Complex*> sources(const Spectra& state) const;
    void note_extremes(const numerics::Strip& strip);
    void check_densities() const;

    // Places in `made`.
    int made_velocity() const { return 0; }
    int made_curls() const { return 2; }
    int made_rates() const { return 4; }
    const Complex* of_state(const Spectra& state, int component) const {
        return component < 0 ? nullptr : state[component].data();
    }
    /// body(mode, |q| index, q) for every kept mode, on any thread.
    template <class Body>
    void for_modes(Body body) {
        const std::size_t width = numerics::columns(grid);
        threads.for_chunks(static_cast<std::size_t>(grid.ny), 8, [&](std::size_t begin, std::size_t end) {
            for (std::size_t j = begin; j < end; ++j)
                for (std::size_t i = 0; i < width; ++i) {
                    const std::int32_t n = wavenumbers.of_mode[j * width + i];
                    if (n < 0) break;  // a row's kept modes are its first
                    body(j * width + i, static_cast<std::size_t>(n), numerics::wavevector(grid, i, j));
                }
        });
    }
};

RightHandSide::Work::Work(const Equations& equations, const numerics::System& linear, const Reference& reference,
                          Threads& the_threads)
    : e(equations),
      ref(reference),
      grid(linear.grid),
      degree(linear.degree),
      threads(the_threads),
      arrays(arrays_of(e)),
      transform(grid, degree, threads),
      wavenumbers(numerics::distinct_wavenumbers(grid, degree)),
      forced(has_term(e, "force")),
      made(grid, made_rates() + arrays.forth),
      drag_ref(e.drag.at(ref.bead_density, ref.rod_density).value),
      driving_ref(e.driving.at(ref.bead_density, ref.rod_density).value),
      force_varies(e.form.velocity == Velocity::dynamic && (e.drag.varies() || e.driving.varies())) {
    for (const Term* term : e.active)
        if (term->act && term->cost(e).writes != 0) acting.push_back(term);
    if (e.form.velocity != Velocity::absent)
        for (const double q : wavenumbers.q) velocity_rows.push_back(velocity_row(e, ref, q));
}

/// The force on the beads, or their slaved velocity, and the curls.
void RightHandSide::Work::prepare(double t, const Spectra& state) {
    const Form& form = e.form;
    const Complex *beads = of_state(state, form.bead_density), *rods = of_state(state, form.rod_density),
                  *vx = of_state(state, form.bead_velocity), *px = of_state(state, form.polar_order);
    const Complex *vy = vx ? vx + state.stride : nullptr, *py = px + state.stride;
    const bool slaved = form.velocity == Velocity::slaved;
    const bool needs_velocity = slaved && (arrays.velocity >= 0 || forced), needs_force = arrays.force >= 0;
    if (!needs_velocity && !needs_force && arrays.velocity_curl < 0 && arrays.order_curl < 0) return;
    Complex *out_x = made[made_velocity()].data(), *out_y = out_x + made.stride, *curl_v = made[made_curls()].data(),
            *curl_p = curl_v + made.stride;
    for_modes([&](std::size_t m, std::size_t n, const Wavevector& q) {
        if (arrays.order_curl >= 0) curl_p[m] = times_i(q.x * py[m] - q.y * px[m]);
        if (arrays.velocity_curl >= 0) curl_v[m] = times_i(q.x * vy[m] - q.y * vx[m]);
        if (!needs_velocity && !needs_force) return;
        const double inverse = wavenumbers.inverse[n], cx = inverse == 0.0 ? 1.0 : q.x * inverse, cy = q.y * inverse;
        const VelocityRow& row = velocity_rows[n];
        Complex scalars = 0.0;
        if (beads) scalars += row.along[0] * beads[m];
        if (rods) scalars += row.along[1] * rods[m];
        Complex along = -times_i(scalars) + row.along[3] * (cx * px[m] + cy * py[m]),
                across = row.across[1] * (cx * py[m] - cy * px[m]);
        if (vx) {
            along += row.along[2] * (cx * vx[m] + cy * vy[m]);
            across += row.across[0] * (cx * vy[m] - cy * vx[m]);
        }
        out_x[m] = cx * along - cy * across;
        out_y[m] = cy * along + cx * across;
        if (!forced) return;
        const ForceMode force = force_mode(e.model.force, grid, t, q);
        if (!slaved) {
            out_x[m] += force.x;
            out_y[m] += force.y;
            return;
        }
        const ForceMode v = slaved_by(force, q);
        out_x[m] += v.x;
        out_y[m] += v.y;
    });
}

std::vector<const Complex*> RightHandSide::Work::sources(const Spectra& state) const {
    std::vector<const Complex*> from(static_cast<std::size_t>(arrays.back), nullptr);
    const auto put = [&](int at, const Complex* values, int width, std::size_t stride) {
        for (int i = 0; at >= 0 && i < width; ++i)
            from[static_cast<std::size_t>(at + i)] = values + static_cast<std::size_t>(i) * stride;
    };
    const bool slaved = e.form.velocity == Velocity::slaved;
    put(arrays.beads, of_state(state, e.form.bead_density), 1, 0);
    put(arrays.rods, of_state(state, e.form.rod_density), 1, 0);
    put(arrays.velocity, slaved ? made[made_velocity()].data() : of_state(state, e.form.bead_velocity), 2, made.stride);
    put(arrays.order, of_state(state, e.form.polar_order), 2, made.stride);
    put(arrays.force, made[made_velocity()].data(), 2, made.stride);
    put(arrays.velocity_curl, made[made_curls()].data(), 1, 0);
    put(arrays.order_curl, made[made_curls() + 1].data(), 1, 0);
    return from;
}

void RightHandSide::Work::note_extremes(const numerics::Strip& strip) {
    const auto range = [&](int at) {
        double least = std::numeric_limits<double>::infinity(), most = -least;
        if (at < 0) return std::pair{least, most};
        const double* values = strip.in[static_cast<std::size_t>(at)];
        for (std::size_t i = 0; i < strip.size; ++i) {
            least = values[i] < least ? values[i] : least;
            most = values[i] > most ? values[i] : most;
        }
        return std::pair{least, most};
    };
    const auto [min_bead, max_bead] = range(arrays.beads);
    const auto [min_rod, max_rod] = range(arrays.rods);
    const std::lock_guard lock(mutex);
    extremes = {std::min(extremes.min_bead, min_bead), std::max(extremes.max_bead, max_bead),
                std::min(extremes.min_rod, min_rod), std::max(extremes.max_rod, max_rod)};
}

/// Every active term on the points of a strip, a few at a time: all it needs is then in the first-level cache.
void RightHandSide::Work::at_points(const numerics::Strip& strip) {
    note_extremes(strip);
    std::array<std::array<double, points_in_cache>, 4> room;  // force, slaved velocity
    for (std::size_t begin = 0; begin < strip.size; begin += points_in_cache) {
        const std::size_t count = std::min(points_in_cache, strip.size - begin);
        const auto in = [&](int at, int i = 0) {
            return at < 0 ? nullptr : strip.in[static_cast<std::size_t>(at + i)] + begin;
        };
        const auto out = [&](int at, int i = 0) -> double* {
            if (at < 0) return nullptr;
            double* values = strip.out[static_cast<std::size_t>(at + i)] + begin;
            std::fill_n(values, count, 0.0);
            return values;
        };
        PointFields f{.size = count,
                      .bead_density = in(arrays.beads),
                      .rod_density = in(arrays.rods),
                      .velocity = {in(arrays.velocity), in(arrays.velocity, 1)},
                      .linear_velocity = {in(arrays.velocity), in(arrays.velocity, 1)},
                      .order = {in(arrays.order), in(arrays.order, 1)},
                      .linear_force = {in(arrays.force), in(arrays.force, 1)},
                      .velocity_curl = in(arrays.velocity_curl),
                      .order_curl = in(arrays.order_curl)};
        if (force_varies)
            for (auto& values : {&room[0], &room[1]}) std::fill_n(values->data(), count, 0.0);
        const PointRates r{.bead_flux = {out(arrays.bead_flux), out(arrays.bead_flux, 1)},
                           .rod_flux = {out(arrays.rod_flux), out(arrays.rod_flux, 1)},
                           .force = {room[0].data(), room[1].data()},
                           .velocity = {out(arrays.velocity_rate), out(arrays.velocity_rate, 1)},
                           .order = {out(arrays.order_rate), out(arrays.order_rate, 1)},
                           .velocity_head = out(arrays.velocity_head),
                           .order_head = out(arrays.order_head)};
        if (slaved_varies(e) && arrays.velocity >= 0) {
            balance_velocity(f, {room[2].data(), room[3].data()});
            f.velocity = {room[2].data(), room[3].data()};
        }
        for (const Term* term : acting) term->act(e, ref, f, r);
        if (e.form.velocity == Velocity::dynamic && arrays.velocity_rate >= 0) divide_by_mass(f, r);
    }
}

/// v = (Gamma_ref v_linear + (alpha - alpha_ref) p)/Gamma: the balance of forces with Gamma and alpha at the point.
void RightHandSide::Work::balance_velocity(const PointFields& f, const VectorStrip<double>& velocity) const {
    std::array<double, points_in_cache> gamma, driven;
    e.drag.evaluate(f.bead_density, f.rod_density, 0.0, std::span(gamma.data(), f.size));
    e.driving.evaluate(f.bead_density, f.rod_density, driving_ref, std::span(driven.data(), f.size));
    for (std::size_t i = 0; i < f.size; ++i) {
        velocity.x[i] = (drag_ref * f.linear_velocity.x[i] + driven[i] * f.order.x[i]) / gamma[i];
        velocity.y[i] = (drag_ref * f.linear_velocity.y[i] + driven[i] * f.order.y[i]) / gamma[i];
    }
}

/// d_t v += (linear force + the rest)/(m rho) - (linear force)/(m rho_ref).
void RightHandSide::Work::divide_by_mass(const PointFields& f, const PointRates& r) const {
    const double mass = e.model.inertia.bead_mass, moved_ref = 1.0 / (mass * ref.bead_density);
    const bool has_linear = arrays.force >= 0;
    for (std::size_t i = 0; i < f.size; ++i) {
        const double moved = has_linear ? 1.0 / (mass * f.bead_density[i]) : moved_ref;
        if (force_varies) {
            r.velocity.x[i] += moved * r.force.x[i];
            r.velocity.y[i] += moved * r.force.y[i];
        }
        if (!has_linear) continue;
        r.velocity.x[i] += (moved - moved_ref) * f.linear_force.x[i];
        r.velocity.y[i] += (moved - moved_ref) * f.linear_force.y[i];
    }
}

/// Where the transforms put what the points made: rates of vectors straight into `rate`, fluxes and heads into `made`.
std::vector<Complex*> RightHandSide::Work::targets(Spectra& rate) {
    std::vector<Complex*> to;
    for (int c = 0; c < arrays.forth; ++c) to.push_back(made[made_rates() + c].data());
    const auto straight = [&](int at, int component) {
        for (int i = 0; at >= 0 && i < 2; ++i) to[static_cast<std::size_t>(at + i)] = rate[component + i].data();
    };
    straight(arrays.velocity_rate, e.form.bead_velocity);
    straight(arrays.order_rate, e.form.polar_order);
    return to;
}

/// Divergences of the fluxes and gradients of the heads; what no term made is zero.
void RightHandSide::Work::assemble(double t, Spectra& rate) {
    const Form& form = e.form;
    const auto back = [&](int at) { return at < 0 ? nullptr : made[made_rates() + at].data(); };
    const std::size_t stride = made.stride;
    const auto density = [&](int component, const Complex* flux) {
        if (component < 0) return;
        Complex* out = rate[component].data();
        for_modes([=](std::size_t m, std::size_t, const Wavevector& q) {
            out[m] = flux ? -times_i(q.x * flux[m] + q.y * flux[m + stride]) : Complex(0.0);
        });
    };
    const auto vector = [&](int component, bool is_made, const Complex* head) {
        if (component < 0 || (is_made && !head)) return;
        Complex *x = rate[component].data(), *y = rate[component + 1].data();
        for_modes([=](std::size_t m, std::size_t, const Wavevector& q) {
            const Complex slope = head ? times_i(head[m]) : Complex(0.0);
            x[m] = (is_made ? x[m] : Complex(0.0)) + q.x * slope;
            y[m] = (is_made ? y[m] : Complex(0.0)) + q.y * slope;
        });
    };
    density(form.bead_density, back(arrays.bead_flux));
    density(form.rod_density, back(arrays.rod_flux));
    vector(form.bead_velocity, arrays.velocity_rate >= 0, back(arrays.velocity_head));
    vector(form.polar_order, arrays.order_rate >= 0, back(arrays.order_head));
    if (forced) add_force(t, rate);
    if (has_term(e, "orienting_field")) {
        rate[form.polar_order][0] += e.model.orienting_field.x;
        rate[form.polar_order + 1][0] += e.model.orienting_field.y;
    }
}

/// The force from outside through the linear part, which has no place for it: on the velocity, or through the slaved one on the
/// order and the beads.
void RightHandSide::Work::add_force(double t, Spectra& rate) {
    const Form& form = e.form;
    const bool slaved = form.velocity == Velocity::slaved, carries = has_term(e, "bead_current");
    const double lambda = has_term(e, "weathercock") ? e.weathercock.at(ref.bead_density, ref.rod_density).value : 0.0;
    const double moved_ref = 1.0 / (e.model.inertia.bead_mass * ref.bead_density);
    for_modes([&](std::size_t m, std::size_t, const Wavevector& q) {
        const ForceMode force = force_mode(e.model.force, grid, t, q);
        if (!slaved) {
            rate[form.bead_velocity][m] += moved_ref * force.x;
            rate[form.bead_velocity + 1][m] += moved_ref * force.y;
            return;
        }
        const ForceMode v = slaved_by(force, q);
        rate[form.polar_order][m] += lambda * v.x;
        rate[form.polar_order + 1][m] += lambda * v.y;
        if (carries) rate[form.bead_density][m] -= ref.bead_density * times_i(q.x * v.x + q.y * v.y);
    });
}

/// The velocity that drag and viscosity leave to a force.
ForceMode RightHandSide::Work::slaved_by(const ForceMode& force, const Wavevector& q) const {
    const double square = q.x * q.x + q.y * q.y, held = drag_ref + e.model.viscosity.shear * square,
                 held_along = held + e.model.viscosity.bulk * square;
    const Complex along = (q.x * force.x + q.y * force.y) * (square > 0.0 ? 1.0 / square : 0.0);
    return {(force.x - q.x * along) / held + q.x * along / held_along,
            (force.y - q.y * along) / held + q.y * along / held_along};
}

/// What cannot be gone on with.  A number that is none is left to the health check, which says where it is.
void RightHandSide::Work::check_densities() const {
    if (arrays.force >= 0 && extremes.min_bead <= 0.0)
        fail_run(
            "the bead density reached {:.4g} mm-2 on the grid, and the inertia of beads divides by it; a vacuum needs "
            "fields.bead_velocity = \"slaved\"; else expected a density > 0: take a finer grid, a smaller dt or less "
            "noise",
            extremes.min_bead);
    if (slaved_varies(e) && arrays.velocity >= 0 && !e.drag.table()) {
        for (const double beads : {extremes.min_bead, extremes.max_bead})
            for (const double rods : {extremes.min_rod, extremes.max_rod})
                if (std::isfinite(beads) && std::isfinite(rods) && e.drag.at(beads, rods).value <= 0.0)
                    fail_run(
                        "drag.coefficient is {:.4g} where the bead density is {:.4g} and the rod density {:.4g}; "
                        "expected > 0: "
                        "a slaved velocity divides by it",
                        e.drag.at(beads, rods).value, beads, rods);
    }
    for (const auto& [name, c] : named(e)) {
        if (!c->table()) continue;
        // No term of this right-hand side reads the coefficient: its densities are not on the grid.
        if ((c->depends_on_beads() && !std::isfinite(extremes.min_bead)) ||
            (c->depends_on_rods() && !std::isfinite(extremes.min_rod)))
            continue;
        const auto finite = [](double value) { return std::isfinite(value) ? value : 0.0; };
        for (const auto& [beads, rods] :
             {std::pair{extremes.min_bead, extremes.min_rod}, std::pair{extremes.max_bead, extremes.max_rod}})
            if (std::isnan(c->at(finite(beads), finite(rods)).value))
                fail_run(
                    "the densities reached {:.4g} (beads) and {:.4g} (rods) mm-2, outside the table of {}: {}; give a "
                    "wider table, or "
                    "table.outside = \"hold\"",
                    beads, rods, name, c->table()->range_text());
    }
}

RightHandSide::RightHandSide(const Equations& equations, const numerics::System& linear, const Reference& reference,
                             Threads& threads)
    : work_(std::make_unique<Work>(equations, linear, reference, threads)) {}
RightHandSide::~RightHandSide() = default;

void RightHandSide::operator()(double t, const Spectra& state, Spectra& rate) {
    Work& w = *work_;
    constexpr double infinite = std::numeric_limits<double>::infinity();
    w.extremes = {infinite, -infinite, infinite, -infinite};
    w.prepare(t, state);
    if (w.arrays.forth > 0) {
        w.transform.products(w.sources(state), w.targets(rate),
                             [&](const numerics::Strip& strip) { w.at_points(strip); });
        w.check_densities();
    }
    w.assemble(t, rate);
}

Extremes RightHandSide::extremes() const { return work_->extremes; }

TransformCount transform_count(const Equations& equations) {
    const Arrays arrays = arrays_of(equations);
    return {.back = arrays.forth > 0 ? arrays.back : 0, .forth = arrays.forth};
}

bool is_nonlinear(const Equations& equations) {
    return arrays_of(equations).forth > 0 || has_term(equations, "force") || has_term(equations, "orienting_field");
}

double right_hand_side_bytes(const Equations& equations, const numerics::Grid& grid, int degree) {
    if (!is_nonlinear(equations)) return 0.0;
    const Arrays arrays = arrays_of(equations);
    const double spectra = static_cast<double>(numerics::modes(grid)) * sizeof(Complex);
    return spectra * (4.0 + arrays.forth + 2.0 * (arrays.back + arrays.forth) / (degree + 1));
}

}  // namespace drover::physics
