// physics/right_hand_side.cpp: fields to the grid, every active term at its points, and back.
#include "drover/physics/right_hand_side.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <mutex>

#include "drover/numerics/transform.hpp"
#include "drover/numerics/wavenumbers.hpp"
#include "linear_rows.hpp"
#include "moving_density.hpp"
#include "point_arrays.hpp"
#include "quasi_linear.hpp"
#include "term_shapes.hpp"

namespace drover::physics {

namespace {
using numerics::Complex;
using numerics::Spectra;
using numerics::Wavevector;
constexpr std::size_t points_in_cache = 256;  // of some twenty arrays: the first-level cache

Complex times_i(Complex a) { return {-a.imag(), a.real()}; }
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
    LinearRemainder remainder;
    QuasiLinear quasi_linear;
    std::vector<const Term*> force_terms, point_terms;  // slaved: forces apart, for they make the velocity
    std::vector<const Term*> sources;
    Spectra scratch;                          // velocity or force (2), derived inputs, outputs
    std::array<int, Input::count> derived{};  // positions of derived inputs in scratch, -1: none
    int outputs_begin = 2;                    // position of the outputs in scratch
    bool pointwise_velocity, reads_place, reads_velocity_field;
    double drag_ref;
    double density_floor = 0.0;  // of the mass that moves
    std::mutex mutex;
    Extremes extremes{};

    Work(const Equations& equations, const numerics::System& linear, const Reference& reference, Threads& the_threads);
    void evaluate(double t, const Spectra& state, Spectra& rate);
    void prepare(double t, const Spectra& state);
    void compute_linear_velocity(double t, const Spectra& state);
    numerics::Fields bead_velocity(double t, const Spectra& state, const numerics::Transform& to);
    void add_velocity_sources(double t);
    void derive_inputs(const Spectra& state);
    using Row = std::array<double, points_in_cache>;
    void at_points(double t, const numerics::Strip& strip);
    void act(const Term& term, const PointFields& f, const PointRates& r) const;
    void set_position(std::size_t first, PointFields& f, Row& x, Row& y) const;
    VectorMode slaved_by(std::size_t n, const VectorMode& force, const Wavevector& q) const;
    void balance_velocity(const PointFields& f, const VectorStrip<const double>& force,
                          const VectorStrip<double>& velocity) const;
    void divide_by_mass(const PointFields& f, double least_density, const PointRates& r) const;
    void assemble(double t, const Spectra& state, Spectra& rate);
    void add_sources(double t, Spectra& rate);
    void add_linear_remainder(const Spectra& state, Spectra& rate) const;
    std::vector<Complex*> targets(Spectra& rate);
    std::vector<const Complex*> sources_of_inputs(const Spectra& state) const;
    Extremes note_extremes(const numerics::Strip& strip);

    bool is_slaved() const { return e.form.velocity == Velocity::slaved; }
    double inverse_moved() const { return 1.0 / (e.model.inertia.bead_mass * ref.bead_density); }
    bool needs_linear_velocity() const {
        return is_slaved() && (reads_velocity_field || !sources.empty() || remainder.subtracts() || remainder.adds());
    }
    /// Coefficients of a field: of the state, or of the slaved velocity.
    const Complex* field(const Spectra& state, int index) const;
    const Complex* component(const Spectra& state, int c) const { return c < 0 ? nullptr : state[c].data(); }
    FieldModes mode_of(const Spectra& state, std::size_t m) const;
    template <class Body>
    void for_modes(Body body) const {
        numerics::for_kept_modes(grid, wavenumbers, threads, body);
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
      remainder(e, ref, wavenumbers.q),
      quasi_linear(e, grid, degree),
      pointwise_velocity(has_pointwise_velocity(e)),
      reads_place(false),
      reads_velocity_field(false),
      drag_ref(e.drag.at(ref.bead_density, ref.rod_density).value) {
    for (const Term& term : e.active) {
        if (term.source) sources.push_back(&term);
        const PointCost cost = point_cost(e, term);
        if (cost.writes == 0) continue;
        reads_place = reads_place || (cost.reads & (reads(Input::x) | reads(Input::y)));
        (is_slaved() && term.of == Equation::bead_velocity ? force_terms : point_terms).push_back(&term);
    }
    if (e.form.velocity != Velocity::absent)
        for (const double q : wavenumbers.q) velocity_rows.push_back(velocity_row(e, ref, q));
    for (int input = 0; input < Input::x; ++input)
        if (arrays.in[static_cast<std::size_t>(input)] >= 0 && is_of_velocity(input)) reads_velocity_field = true;
    derived.fill(-1);
    for (int input = Input::d_x; input < Input::x; ++input)
        if (arrays.in[static_cast<std::size_t>(input)] >= 0) derived[static_cast<std::size_t>(input)] = outputs_begin++;
    scratch = Spectra(grid, outputs_begin + arrays.forward);
}

const Complex* RightHandSide::Work::field(const Spectra& state, int index) const {
    const Form& form = e.form;
    const int second = index == FieldIndex::bead_velocity_y || index == FieldIndex::polar_order_y ? 1 : 0;
    if (index == FieldIndex::bead_density) return component(state, form.bead_density);
    if (index == FieldIndex::rod_density) return component(state, form.rod_density);
    if (index >= FieldIndex::polar_order_x) return component(state, form.polar_order + second);
    if (is_slaved()) return scratch[second].data();
    return form.bead_velocity < 0 ? nullptr : component(state, form.bead_velocity + second);
}

void RightHandSide::Work::prepare(double t, const Spectra& state) {
    if (needs_linear_velocity() || arrays.linear_force >= 0) compute_linear_velocity(t, state);
    derive_inputs(state);
}

/// The force on the beads, or their slaved velocity, by the linear parts and the sources.
void RightHandSide::Work::compute_linear_velocity(double t, const Spectra& state) {
    const Form& form = e.form;
    const Complex *beads = component(state, form.bead_density), *rods = component(state, form.rod_density),
                  *vx = component(state, form.bead_velocity), *px = component(state, form.polar_order);
    const Complex *vy = vx ? vx + state.stride : nullptr, *py = px + state.stride;
    Complex *out_x = scratch[0].data(), *out_y = scratch[1].data();
    const bool adds = remainder.adds() && !is_slaved();
    for_modes([&](std::size_t m, std::size_t n, const Wavevector& q) {
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
        if (!adds) return;
        const auto forces = (remainder.added(q).middleRows<2>(FieldIndex::bead_velocity_x) * mode_of(state, m)).eval();
        out_x[m] += forces(0);
        out_y[m] += forces(1);
    });
    add_velocity_sources(t);
}

/// Forces from outside, on the beads or through the balance of a slaved velocity.
void RightHandSide::Work::add_velocity_sources(double t) {
    for (const Term* term : sources) {
        if (term->of != Equation::bead_velocity) continue;
        for_modes([&](std::size_t m, std::size_t n, const Wavevector& q) {
            if (term->source_is_uniform && n != 0) return;
            const VectorMode force = term->source(e, grid, t, q), v = is_slaved() ? slaved_by(n, force, q) : force;
            scratch[0][m] += v.x;
            scratch[1][m] += v.y;
        });
    }
}

/// Derivatives of fields that terms read.
void RightHandSide::Work::derive_inputs(const Spectra& state) {
    const auto derive = [&](int input, auto of_mode) {
        const int at = derived[static_cast<std::size_t>(input)];
        if (at < 0) return;
        Complex* out = scratch[at].data();
        for_modes([=](std::size_t m, std::size_t, const Wavevector& q) { out[m] = of_mode(m, q); });
    };
    for (int index = 0; index < FieldIndex::count; ++index) {
        const Complex* f = field(state, index);
        if (!f) continue;
        derive(Input::d_x + index, [f](std::size_t m, const Wavevector& q) { return times_i(q.x * f[m]); });
        derive(Input::d_y + index, [f](std::size_t m, const Wavevector& q) { return times_i(q.y * f[m]); });
        derive(Input::laplacian + index,
               [f](std::size_t m, const Wavevector& q) { return -(q.x * q.x + q.y * q.y) * f[m]; });
    }
    for (const auto& [first, curl, divergence, grad_div] :
         {std::array<int, 4>{FieldIndex::bead_velocity_x, Input::velocity_curl, Input::velocity_divergence,
                             Input::velocity_grad_div},
          std::array<int, 4>{FieldIndex::polar_order_x, Input::order_curl, Input::order_divergence,
                             Input::order_grad_div}}) {
        const Complex *x = field(state, first), *y = field(state, first + 1);
        if (!x) continue;
        derive(curl, [x, y](std::size_t m, const Wavevector& q) { return times_i(q.x * y[m] - q.y * x[m]); });
        derive(divergence, [x, y](std::size_t m, const Wavevector& q) { return times_i(q.x * x[m] + q.y * y[m]); });
        derive(grad_div, [x, y](std::size_t m, const Wavevector& q) { return -q.x * (q.x * x[m] + q.y * y[m]); });
        derive(grad_div + 1, [x, y](std::size_t m, const Wavevector& q) { return -q.y * (q.x * x[m] + q.y * y[m]); });
    }
}

std::vector<const Complex*> RightHandSide::Work::sources_of_inputs(const Spectra& state) const {
    std::vector<const Complex*> from(static_cast<std::size_t>(arrays.inverse), nullptr);
    for (int input = 0; input < Input::x; ++input) {
        const int at = arrays.in[static_cast<std::size_t>(input)], made = derived[static_cast<std::size_t>(input)];
        if (at >= 0) from[static_cast<std::size_t>(at)] = made >= 0 ? scratch[made].data() : field(state, input);
    }
    for (int i = 0; arrays.linear_force >= 0 && i < 2; ++i)
        from[static_cast<std::size_t>(arrays.linear_force + i)] = scratch[i].data();
    return from;
}

Extremes RightHandSide::Work::note_extremes(const numerics::Strip& strip) {
    const auto values = [&](Input::Value input) {
        const int at = arrays.of(input);
        return at < 0 ? nullptr : strip.in[static_cast<std::size_t>(at)];
    };
    const Extremes found = extremes_of(values(Input::bead_density), values(Input::rod_density), strip.size);
    const std::lock_guard lock(mutex);
    extremes = joined(extremes, found);
    return found;
}

/// Every active term on the points of a strip, a few at a time: all it needs is then in the first-level cache.
void RightHandSide::Work::at_points(double t, const numerics::Strip& strip) {
    const Extremes found = note_extremes(strip);
    std::array<Row, 6> room;  // force, slaved velocity, position
    for (std::size_t begin = 0; begin < strip.size; begin += points_in_cache) {
        PointFields f{.size = std::min(points_in_cache, strip.size - begin), .time = t};
        PointRates r;
        for (std::size_t i = 0; i < Input::count; ++i)
            if (arrays.in[i] >= 0) f.values[i] = strip.in[static_cast<std::size_t>(arrays.in[i])] + begin;
        for (std::size_t i = 0; i < Output::count; ++i) {
            // The second component of a vector follows the first.
            if (arrays.out[i] < 0) continue;
            r.values[i] = strip.out[static_cast<std::size_t>(arrays.out[i])] + begin;
            std::fill_n(r.values[i], f.size, 0.0);
        }
        f.linear_velocity = f.velocity();
        if (arrays.linear_force >= 0) {
            const auto at = static_cast<std::size_t>(arrays.linear_force);
            f.linear_force = {strip.in[at] + begin, strip.in[at + 1] + begin};
        }
        for (std::size_t i : {0, 1}) {
            r.values[Output::force + i] = room[i].data();
            std::fill_n(room[i].data(), f.size, 0.0);
        }
        if (reads_place) set_position(strip.first + begin, f, room[4], room[5]);
        if (pointwise_velocity && f.velocity().x) {
            for (const Term* term : force_terms) act(*term, f, r);
            balance_velocity(f, {room[0].data(), room[1].data()}, {room[2].data(), room[3].data()});
            f.values[Input::bead_velocity_x] = room[2].data();
            f.values[Input::bead_velocity_y] = room[3].data();
        }
        for (const Term* term : point_terms) act(*term, f, r);
        if (e.form.velocity == Velocity::dynamic && r[Output::velocity]) divide_by_mass(f, found.min_bead, r);
    }
}

void RightHandSide::Work::act(const Term& term, const PointFields& f, const PointRates& r) const {
    (term.whole ? term.whole : term.remainder)(e, ref, f, r);
}

void RightHandSide::Work::set_position(std::size_t first, PointFields& f, Row& x, Row& y) const {
    const auto width = static_cast<std::size_t>(grid.nx);
    for (std::size_t i = 0; i < f.size; ++i) {
        x[i] = grid.lx / grid.nx * static_cast<double>((first + i) % width);
        y[i] = grid.ly / grid.ny * static_cast<double>((first + i) / width);
    }
    f.values[Input::x] = x.data();
    f.values[Input::y] = y.data();
}

/// v = (Gamma_ref v_linear + the other forces' remainder)/Gamma: the balance of forces at each point.
void RightHandSide::Work::balance_velocity(const PointFields& f, const VectorStrip<const double>& force,
                                           const VectorStrip<double>& velocity) const {
    Row gamma;
    e.drag.evaluate(f[Input::bead_density], f[Input::rod_density], 0.0, std::span(gamma.data(), f.size));
    for_points(f.size, [&](std::size_t i) {
        velocity.x[i] = (drag_ref * f.linear_velocity.x[i] + force.x[i]) / gamma[i];
        velocity.y[i] = (drag_ref * f.linear_velocity.y[i] + force.y[i]) / gamma[i];
    });
}

/// d_t v += (linear force + the rest)/(m rho) - (linear force)/(m rho_ref).
void RightHandSide::Work::divide_by_mass(const PointFields& f, double least_density, const PointRates& r) const {
    const double moved_ref = inverse_moved();
    const auto rate = r.vector(Output::velocity), force = r.vector(Output::force);
    if (arrays.linear_force < 0) {
        for_points(f.size, [=](std::size_t i) { rate.x[i] += moved_ref * force.x[i]; });
        for_points(f.size, [=](std::size_t i) { rate.y[i] += moved_ref * force.y[i]; });
        return;
    }
    Row moved;
    const MovingMass mass{.of_bead = e.model.inertia.bead_mass, .floor = density_floor, .least_density = least_density};
    invert(mass, f[Input::bead_density], f.size, moved.data());
    for_points(f.size, [&](std::size_t i) {
        const double more = moved[i] - moved_ref;
        rate.x[i] += moved[i] * force.x[i] + more * f.linear_force.x[i];
        rate.y[i] += moved[i] * force.y[i] + more * f.linear_force.y[i];
    });
}

/// Where the transforms put the results: rates of vectors straight into `rate`, the others into `scratch`.
std::vector<Complex*> RightHandSide::Work::targets(Spectra& rate) {
    std::vector<Complex*> to;
    for (int c = 0; c < arrays.forward; ++c) to.push_back(scratch[outputs_begin + c].data());
    const auto straight = [&](int at, int component) {
        for (int i = 0; at >= 0 && i < 2; ++i) to[static_cast<std::size_t>(at + i)] = rate[component + i].data();
    };
    straight(arrays.of(Output::velocity), e.form.bead_velocity);
    straight(arrays.of(Output::order), e.form.polar_order);
    return to;
}

/// Divergences of the fluxes and gradients of the potentials; what no term wrote is zero.
void RightHandSide::Work::assemble(double t, const Spectra& state, Spectra& rate) {
    const Form& form = e.form;
    const auto output = [&](int at) { return at < 0 ? nullptr : scratch[outputs_begin + at].data(); };
    const std::size_t stride = scratch.stride;
    const auto density = [&](int component, const Complex* flux, const Complex* direct) {
        if (component < 0) return;
        Complex* out = rate[component].data();
        for_modes([=](std::size_t m, std::size_t, const Wavevector& q) {
            out[m] = flux ? -times_i(q.x * flux[m] + q.y * flux[m + stride]) : Complex(0.0);
            if (direct) out[m] += direct[m];
        });
    };
    const auto vector = [&](int component, bool is_made, const Complex* potential) {
        if (component < 0 || (is_made && !potential)) return;
        Complex *x = rate[component].data(), *y = rate[component + 1].data();
        for_modes([=](std::size_t m, std::size_t, const Wavevector& q) {
            const Complex slope = potential ? times_i(potential[m]) : Complex(0.0);
            x[m] = (is_made ? x[m] : Complex(0.0)) + q.x * slope;
            y[m] = (is_made ? y[m] : Complex(0.0)) + q.y * slope;
        });
    };
    density(form.bead_density, output(arrays.of(Output::bead_flux)), output(arrays.of(Output::bead_rate)));
    density(form.rod_density, output(arrays.of(Output::rod_flux)), output(arrays.of(Output::rod_rate)));
    vector(form.bead_velocity, arrays.of(Output::velocity) >= 0, output(arrays.of(Output::velocity_potential)));
    vector(form.polar_order, arrays.of(Output::order) >= 0, output(arrays.of(Output::order_potential)));
    add_sources(t, rate);
    if (remainder.adds() || remainder.subtracts()) add_linear_remainder(state, rate);
}

/// Sources through the linear part, which has no place for them: on the velocity or, through a slaved one, on what it
/// drives; and on the order.
void RightHandSide::Work::add_sources(double t, Spectra& rate) {
    const Form& form = e.form;
    const double moved_ref = inverse_moved();
    for (const Term* term : sources)
        for_modes([&](std::size_t m, std::size_t n, const Wavevector& q) {
            if (term->source_is_uniform && n != 0) return;
            const VectorMode source = term->source(e, grid, t, q);
            if (term->of == Equation::polar_order || !is_slaved()) {
                const bool force = term->of == Equation::bead_velocity;
                const int component = force ? form.bead_velocity : form.polar_order;
                rate[component][m] += (force ? moved_ref : 1.0) * source.x;
                rate[component + 1][m] += (force ? moved_ref : 1.0) * source.y;
                return;
            }
            const VelocityRow& row = velocity_rows[n];
            const VectorMode v = slaved_by(n, source, q);
            const double inverse = wavenumbers.inverse[n], cx = inverse == 0.0 ? 1.0 : q.x * inverse,
                         cy = q.y * inverse;
            const Complex along = cx * v.x + cy * v.y, across = cx * v.y - cy * v.x;
            if (form.bead_density >= 0) rate[form.bead_density][m] += row.to_beads * along;
            if (form.rod_density >= 0) rate[form.rod_density][m] += row.to_rods * along;
            rate[form.polar_order][m] += cx * row.to_order_along * along - cy * row.to_order_across * across;
            rate[form.polar_order + 1][m] += cy * row.to_order_along * along + cx * row.to_order_across * across;
        });
}

/// The velocity of slaved beads under a force from outside.
VectorMode RightHandSide::Work::slaved_by(std::size_t n, const VectorMode& force, const Wavevector& q) const {
    const double inverse = wavenumbers.inverse[n], cx = inverse == 0.0 ? 1.0 : q.x * inverse, cy = q.y * inverse;
    const Complex along = (cx * force.x + cy * force.y) / velocity_rows[n].held_along,
                  across = (cx * force.y - cy * force.x) / velocity_rows[n].held_across;
    return {cx * along - cy * across, cy * along + cx * across};
}

FieldModes RightHandSide::Work::mode_of(const Spectra& state, std::size_t m) const {
    FieldModes mode;
    for (int index = 0; index < FieldIndex::count; ++index) {
        const Complex* f = field(state, index);
        mode(index) = f ? f[m] : Complex(0.0);
    }
    return mode;
}

void RightHandSide::Work::add_linear_remainder(const Spectra& state, Spectra& rate) const {
    const Form& form = e.form;
    std::array<const Complex*, FieldIndex::count> from{};
    std::array<Complex*, FieldIndex::count> to{};
    std::array<double, FieldIndex::count> factor{1.0, 1.0, inverse_moved(), inverse_moved(), 1.0, 1.0};
    for (int index = 0; index < FieldIndex::count; ++index) from[static_cast<std::size_t>(index)] = field(state, index);
    const auto set = [&](int index, int component) {
        if (component >= 0) to[static_cast<std::size_t>(index)] = rate[component].data();
    };
    set(FieldIndex::bead_density, form.bead_density);
    set(FieldIndex::rod_density, form.rod_density);
    for (const int i : {0, 1}) {
        if (form.bead_velocity >= 0) set(FieldIndex::bead_velocity_x + i, form.bead_velocity + i);
        set(FieldIndex::polar_order_x + i, form.polar_order + i);
    }
    for_modes([&](std::size_t m, std::size_t n, const Wavevector& q) {
        FieldModes fields, change = FieldModes::Zero();
        for (std::size_t i = 0; i < from.size(); ++i)
            fields(static_cast<Eigen::Index>(i)) = from[i] ? from[i][m] : Complex(0.0);
        if (remainder.adds()) change += remainder.added(q) * fields;
        if (remainder.subtracts()) change -= remainder.subtracted(n, q, wavenumbers.inverse[n], fields);
        for (std::size_t i = 0; i < to.size(); ++i)
            if (to[i]) to[i][m] += factor[i] * change(static_cast<Eigen::Index>(i));
    });
}

/// The linear velocity to the grid and, where it is not the whole, the balance of forces at every point.
numerics::Fields RightHandSide::Work::bead_velocity(double t, const Spectra& state, const numerics::Transform& to) {
    numerics::Fields result(grid, 2);
    compute_linear_velocity(t, state);
    Spectra velocity(grid, 2);
    for (const int i : {0, 1}) std::copy(scratch[i].begin(), scratch[i].end(), velocity[i].begin());
    to.backward(velocity, result);
    if (!pointwise_velocity) return result;
    numerics::Fields fields(grid, state.count());
    to.backward(state, fields);
    Row force_x, force_y, x, y;
    for (std::size_t begin = 0; begin < result.size; begin += points_in_cache) {
        PointFields f{.size = std::min(points_in_cache, result.size - begin), .time = t};
        const auto set = [&](int input, int component) {
            if (component >= 0) f.values[static_cast<std::size_t>(input)] = fields[component].data() + begin;
        };
        set(Input::bead_density, e.form.bead_density);
        set(Input::rod_density, e.form.rod_density);
        set(Input::polar_order_x, e.form.polar_order);
        set(Input::polar_order_y, e.form.polar_order + 1);
        set_position(begin, f, x, y);
        const VectorStrip<double> v{result[0].data() + begin, result[1].data() + begin};
        f.linear_velocity = {v.x, v.y};
        force_x.fill(0.0);
        force_y.fill(0.0);
        PointRates r;
        r.values[Output::force] = force_x.data();
        r.values[Output::force + 1] = force_y.data();
        for (const Term* term : force_terms) act(*term, f, r);
        balance_velocity(f, {force_x.data(), force_y.data()}, v);
    }
    return result;
}

RightHandSide::RightHandSide(const Equations& equations, const numerics::System& linear, const Reference& reference,
                             Threads& threads)
    : work_(std::make_unique<Work>(equations, linear, reference, threads)) {}
RightHandSide::~RightHandSide() = default;

void RightHandSide::Work::evaluate(double t, const Spectra& state, Spectra& rate) {
    prepare(t, state);
    if (arrays.forward > 0) {
        transform.products(sources_of_inputs(state), targets(rate),
                           [&](const numerics::Strip& strip) { at_points(t, strip); });
        check_extremes(e, extremes,
                       {.by_bead_density = arrays.linear_force >= 0,
                        .by_drag = pointwise_velocity && arrays.of(Input::bead_velocity_x) >= 0});
    }
    assemble(t, state, rate);
}

void RightHandSide::operator()(double t, const Spectra& state, Spectra& rate) {
    Work& w = *work_;
    w.extremes = {};
    w.quasi_linear.write(
        state, [&](const Spectra& at, Spectra& to) { w.evaluate(t, at, to); }, rate);
}

void RightHandSide::set_step(double dt) {
    Work& w = *work_;
    const Model& model = w.e.model;
    if (w.e.form.velocity != Velocity::dynamic || w.arrays.linear_force < 0) return;
    const double drag = w.e.drag.at(model.uniform.bead_density, model.uniform.rod_density).value;
    w.density_floor = std::min(drag * dt / model.inertia.bead_mass, 0.5 * model.uniform.bead_density);
}

Extremes RightHandSide::extremes() const { return work_->extremes; }

double RightHandSide::min_moving_density() const {
    return moving_density(work_->extremes.min_bead, work_->density_floor);
}

numerics::Fields RightHandSide::bead_velocity(double t, const Spectra& state, const numerics::Transform& transform) {
    return work_->bead_velocity(t, state, transform);
}

}  // namespace drover::physics
