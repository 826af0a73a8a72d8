// model/explicit_part.cpp: L, N and Q of equations for a stepper, with noise that multiplies fields; how fast the
// linear part is that the solver leaves to the explicit part, and where both nearly cancel.
#include "model/explicit_part.hpp"

#include <algorithm>
#include <cmath>

#include "base/mapped.hpp"
#include "drover/model/linearised_at.hpp"
#include "model/compiled.hpp"
#include "numerics/algebra/dense.hpp"

namespace drover::model {

namespace {
using numerics::Complex;
using numerics::Spectra;
using numerics::Wavevector;

/// A slope of an output by an atom.
struct Slope {
    const RateFunction* output;
    int slot;
    Expression value;
};

std::vector<Slope> slopes_of(const CompiledEquations& c, bool& reads_position) {
    std::vector<Slope> slopes;
    for (const std::vector<RateFunction>* outputs : {&c.outputs, &c.forces})
        for (const RateFunction& output : *outputs)
            for (const int slot : c.slots_read(output.value)) {
                if (slot == slot_x || slot == slot_y) reads_position = true;
                if (slot < first_atom) continue;
                Expression slope = c.slope(output.value, slot);
                if (!is_zero(slope)) slopes.push_back({&output, slot, std::move(slope)});
            }
    return slopes;
}

/// At most `max_count` of 0, ..., count - 1, from the last one down to 0.
std::vector<std::size_t> sampled(std::size_t count, std::size_t max_count) {
    std::vector<std::size_t> result;
    const std::size_t taken = std::min(count, max_count);
    for (std::size_t i = taken; i-- > 0;) result.push_back(taken < 2 ? 0 : i * (count - 1) / (taken - 1));
    return result;
}

/// Kept modes, long wavevectors first.
std::vector<Wavevector> sampled_modes(const numerics::Grid& grid, int degree) {
    std::size_t columns = 0;
    while (numerics::is_kept(grid, degree, columns, 0)) ++columns;
    std::vector<std::size_t> rows;
    for (std::size_t j = 0; j < static_cast<std::size_t>(grid.ny); ++j)
        if (numerics::is_kept(grid, degree, 0, j)) rows.push_back(j);
    std::ranges::sort(rows, [&](std::size_t a, std::size_t b) {
        return numerics::mode_number_y(grid, a) < numerics::mode_number_y(grid, b);
    });
    std::vector<Wavevector> result;
    for (const std::size_t i : sampled(columns, 32))
        for (const std::size_t j : sampled(rows.size(), 63))  // odd: with the row 0 between those of both signs
            result.push_back(numerics::wavevector(grid, i, rows[j]));
    const auto square = [](const Wavevector& q) { return q.x * q.x + q.y * q.y; };
    std::ranges::stable_sort(result, [&](const Wavevector& a, const Wavevector& b) { return square(a) > square(b); });
    return result;
}

/// Symbols at one q without fields in balance.
class AtWave {
public:
    AtWave(const CompiledEquations& c, const Wavevector& q) : c_(c), q_(q), linear_(c.form_symbol(c.linear, q)) {
        const double length = std::hypot(q.x, q.y), cosine = length > 0.0 ? q.x / length : 1.0,
                     sine = length > 0.0 ? q.y / length : 0.0;
        propagated_ = c.in_frame(c.eliminated(c.averaged(c.linear, length)), cosine, sine, true);
    }
    /// What the propagator does not have of the linear part and this one, of the state.
    Symbol rest(const Symbol& m) const {
        Symbol whole = linear_ + m;
        c_.add_pressure(whole, q_);
        return (c_.eliminated(whole) - propagated_)(c_.state, c_.state);
    }

    /// The propagator's part of the state, and all of a linearisation.
    Symbol propagated() const { return propagated_(c_.state, c_.state); }
    Symbol all(Symbol whole) const {
        c_.add_pressure(whole, q_);
        return c_.eliminated(whole)(c_.state, c_.state);
    }

private:
    const CompiledEquations& c_;
    Wavevector q_;
    Symbol linear_, propagated_;
};

/// 0, and along both axes modes at powers of two up to the last kept one.
std::vector<Wavevector> waves_of_all_sizes(const numerics::Grid& grid, int degree) {
    std::vector<Wavevector> result{{}};
    for (std::size_t i = 1; numerics::is_kept(grid, degree, i, 0); i *= 2)
        result.push_back(numerics::wavevector(grid, i, 0));
    for (std::size_t j = 1; 2 * j < static_cast<std::size_t>(grid.ny) && numerics::is_kept(grid, degree, 0, j); j *= 2)
        result.push_back(numerics::wavevector(grid, 0, j));
    return result;
}

/// phi_1(z) = (e^z - 1)/z of a matrix: a block of an exponential.
Symbol first_phi(const Symbol& z) {
    const Eigen::Index n = z.rows();
    Symbol larger = Symbol::Zero(2 * n, 2 * n);
    larger.topLeftCorner(n, n) = z;
    larger.topRightCorner(n, n).setIdentity();
    return numerics::exponential(larger).topRightCorner(n, n);
}

/// A first-order step of u' = L u + (M - L) u changes u by dt phi_1(dt L) M u.  Of an eigenvector of M, of eigenvalue
/// s, that is v^-1 phi_1(dt L) v times dt s; exact is phi_1(dt s) dt s.
double smallest_part(const Symbol& m, const Symbol& l, double dt) {
    constexpr double slow = 1.0;  // of |s| dt: faster modes follow the others whatever the step
    if (m.rows() == 0 || !m.allFinite() || !l.allFinite()) return 1.0;
    const Eigen::VectorXd scale = numerics::balance(m);
    const auto scaled = [&](const Symbol& a) -> Symbol {
        return scale.cwiseInverse().asDiagonal() * a * scale.asDiagonal();
    };
    const numerics::DenseEigen modes = numerics::dense_eigen(scaled(m));
    if (!modes.has_converged || !numerics::is_invertible(modes.vectors)) return 1.0;
    const Symbol change = numerics::inverse(modes.vectors) * first_phi(dt * scaled(l)) * modes.vectors;
    double smallest = 1.0;
    for (Eigen::Index k = 0; k < m.rows(); ++k) {
        const std::complex<double> z = dt * modes.values(k);
        if (!(std::abs(z) <= slow) || !std::isfinite(std::abs(change(k, k)))) continue;
        const Symbol exact = first_phi(Symbol::Constant(1, 1, z));
        smallest = std::min(smallest, std::abs(change(k, k)) / std::abs(exact(0, 0)));
    }
    return smallest;
}

/// What noise makes of the fields by products.
struct ProductsOfNoise {
    struct Driven {
        ExplicitPart part;
        std::string field;
        std::vector<int> increments, arrays;  ///< of its noises, and of its components in a state
    };
    std::vector<Driven> driven;
    Spectra rate;

    void add(double t, const Spectra& state, const Spectra& increments, Spectra& to) {
        for (int array = 0; array < state.count(); ++array)
            if (!std::isfinite(state[array][1].real())) return;  // the run has diverged, which it says itself
        for (Driven& one : driven) {
            one.part.set_given(mapped(one.increments, [&](int array) { return increments[array].data(); }));
            one.part(t, state, rate);
            for (const int array : one.arrays) {
                const std::span<const Complex> from = std::as_const(rate)[array];
                // What is not finite at a point is so in all modes; a conserved mean is 0.
                if (!std::isfinite(from[1].real()))
                    fail_run(
                        "the noise of {} is not finite at t = {:.6g}: it has the square root of a field below 0, or a "
                        "quotient by 0; expected a strength that is finite for all values that noise reaches, such as "
                        "sqrt(max({}, 0)), or a coarser grid, on which the field fluctuates less",
                        one.field, t, one.field);
                std::transform(from.begin(), from.end(), to[array].begin(), to[array].begin(), std::plus<>());
            }
        }
    }
};
}  // namespace

double Equations::explicit_rate(const numerics::Grid& grid, double t) const {
    const CompiledEquations& c = *compiled_;
    bool reads_position = false;
    const std::vector<Slope> slopes = slopes_of(c, reads_position);
    if (slopes.empty() && c.is_isotropic) return 0.0;
    std::vector<std::vector<double>> values;  // of the slopes, at each position; those that are not finite are no rates
    constexpr int positions = 8;
    for (int k = 0; k < (reads_position ? positions * positions : 1); ++k) {
        std::vector<double> slots = c.slots_at(c.about);
        slots[slot_x] = grid.lx / positions * (k % positions);
        slots[slot_y] = grid.ly / positions * (k / positions);
        slots[slot_t] = t;
        values.emplace_back();
        for (const Slope& slope : slopes) {
            const double value = evaluate(slope.value, slots);
            values.back().push_back(std::isfinite(value) ? value : 0.0);
        }
    }
    double largest = 0.0;
    for (const Wavevector& q : sampled_modes(grid, c.degree)) {
        const AtWave wave(c, q);
        for (const std::vector<double>& at_position : values) {
            Symbol m = Symbol::Zero(c.components, c.components);
            for (std::size_t n = 0; n < slopes.size(); ++n)
                for (const RateFunction::Use& use : slopes[n].output->uses)
                    c.add_form(c.form_of(slopes[n].slot), use.order, use.factor * at_position[n], q, use.component, m);
            const Symbol rest = wave.rest(m);
            // No eigenvalue is above the norm.
            if (rest.norm() > largest)
                largest = std::max(largest, numerics::dense_eigenvalues(rest).cwiseAbs().maxCoeff());
        }
    }
    return largest;
}

double Equations::part_of_slow_change(const UniformState& at, const numerics::Grid& grid, double dt) const {
    if (placed_term() != nullptr) return 1.0;
    for (std::size_t n = 0; n < terms().size(); ++n)
        if (!has_derivative(n, at)) return 1.0;
    const CompiledEquations& c = *compiled_;
    const LinearisedAt linearised(*this, at);
    double smallest = 1.0;
    for (const Wavevector& q : waves_of_all_sizes(grid, c.degree)) {
        const AtWave wave(c, q);
        smallest = std::min(smallest, smallest_part(wave.all(linearised.whole(q)), wave.propagated(), dt));
    }
    return smallest;
}

numerics::System Equations::system(const numerics::Grid& grid, Threads& threads, int kept_degree,
                                   std::shared_ptr<ExplicitPart>* seen) const {
    numerics::System system = linear_system(grid, kept_degree);
    if (!has_nonlinear_part()) return system;
    const auto part = std::make_shared<ExplicitPart>(*this, system, threads);
    if (seen != nullptr) *seen = part;
    system.nonlinear = [part](double t, const numerics::Spectra& state, numerics::Spectra& rate) {
        (*part)(t, state, rate);
    };
    for (const std::vector<Term>* terms : {&compiled_->terms, &compiled_->substitutes})
        for (const Term& term : *terms) system.is_timed = system.is_timed || term.summary.is_timed;
    for (const Field& field : model().fields)
        system.is_timed = system.is_timed || (field.left == LeftSide::given &&
                                              std::hypot(field.source.velocity_x, field.source.velocity_y) > 0.0);
    const auto products = std::make_shared<ProductsOfNoise>();
    int increment = 0;
    for (const NoiseProducts& one : compiled_->products) {
        ProductsOfNoise::Driven driven{.part = ExplicitPart(Equations(one.equations), system, threads),
                                       .field = model().fields[one.field].symbol,
                                       .increments = {},
                                       .arrays = {}};
        for (int k = components(); k < one.equations->components; ++k) driven.increments.push_back(increment++);
        for (int k = 0; k < components(); ++k)
            if (compiled_->field(k) == one.field) driven.arrays.push_back(compiled_->array_of[std::size_t(k)]);
        products->driven.push_back(std::move(driven));
    }
    if (!compiled_->products.empty()) {
        products->rate = Spectra(grid, static_cast<int>(state_components().size()));
        auto noise = std::make_shared<numerics::ProductNoise>(*system.product_noise);
        noise->add = [products](double t, const Spectra& state, const Spectra& increments, Spectra& to) {
            products->add(t, state, increments, to);
        };
        system.product_noise = std::move(noise);
    }
    if (!compiled_->masses.empty())
        system.set_step = [part, products](double dt) {
            part->set_step(dt);
            for (ProductsOfNoise::Driven& one : products->driven) one.part.set_step(dt);
        };
    return system;
}

}  // namespace drover::model
