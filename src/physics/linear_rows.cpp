// physics/linear_rows.cpp: linear parts of the terms, sorted by where they are applied.
#include "linear_rows.hpp"

#include <algorithm>
#include <cmath>

#include "linear_part.hpp"
#include "term_shapes.hpp"

namespace drover::physics {

VelocityRow velocity_row(const Equations& e, const Reference& reference, double q) {
    Symbol m = Symbol::Zero();
    for (const Term& term : e.active)
        if (!term.whole) add_isotropic_part(e, term, reference, q, m);
    VelocityRow row{.to_beads = m(rho, v_x),
                    .to_rods = m(sigma, v_x),
                    .to_order_along = m(p_x, v_x),
                    .to_order_across = m(p_y, v_y)};
    if (e.form.velocity == Velocity::slaved) {
        row.held_along = -m(v_x, v_x).real();
        row.held_across = -m(v_y, v_y).real();
        // Zero without drag: then no term acts on the beads.
        for (const int line : {v_x, v_y}) {
            const std::complex<double> held = -m(line, line);
            if (held != 0.0) m.row(line) /= held;
            m(line, line) = 0.0;
        }
    }
    // Times i for the vectors: i F = a rho + b sigma + c (i v) + d (i p).
    row.along = {-m(v_x, rho).imag(), -m(v_x, sigma).imag(), m(v_x, v_x).real(), m(v_x, p_x).real()};
    row.across = {m(v_y, v_y).real(), m(v_y, p_y).real()};
    return row;
}

LinearRemainder::LinearRemainder(const Equations& equations, const Reference& reference,
                                 const std::vector<double>& wavenumbers)
    : equations_(equations), reference_(reference) {
    std::vector<const Term*> whole;
    for (const Term& term : equations.active) {
        if (term.linear_part != LinearPart::averaged) continue;
        (term.whole ? whole : anisotropic_).push_back(&term);
    }
    require(equations.form.velocity != Velocity::slaved ||
                std::none_of(anisotropic_.begin(), anisotropic_.end(),
                             [](const Term* term) { return term->of == Equation::bead_velocity; }),
            {}, "a slaved velocity admits linear forces that are isotropic; give the force an action at points");
    if (whole.empty()) return;
    const std::array along{rho, sigma, v_x, p_x};
    const std::array across{v_y, p_y};
    bool none = true;
    for (const double q : wavenumbers) {
        Symbol m = Symbol::Zero();
        for (const Term* term : whole) add_isotropic_part(equations, *term, reference, q, m);
        none = none && m.isZero(0.0);
        const auto entry = [&](int row, int column) {
            const auto turn = [](int field) { return field >= v_x ? i_unit : std::complex<double>(1.0); };
            return (turn(row) * m(row, column) / turn(column)).real();
        };
        Blocks blocks;
        for (std::size_t r = 0; r < 4; ++r)
            for (std::size_t k = 0; k < 4; ++k) blocks.along[4 * r + k] = entry(along[r], along[k]);
        for (std::size_t r = 0; r < 2; ++r)
            for (std::size_t k = 0; k < 2; ++k) blocks.across[2 * r + k] = entry(across[r], across[k]);
        subtracted_.push_back(blocks);
    }
    if (none) subtracted_.clear();
}

namespace {
/// An isotropic symbol from axes along and across q to x and y.
Symbol from_axes_of(const numerics::Wavevector& q, const Symbol& m) {
    const double size = std::hypot(q.x, q.y);
    return size > 0.0 ? rotated(m, q.x / size, q.y / size) : m;
}
}  // namespace

Symbol LinearRemainder::added(const numerics::Wavevector& q) const {
    Symbol whole = Symbol::Zero(), propagated = Symbol::Zero();
    for (const Term* term : anisotropic_) {
        term->linearise(equations_, at_rest(reference_), q, whole);
        add_isotropic_part(equations_, *term, reference_, std::hypot(q.x, q.y), propagated);
    }
    return whole - from_axes_of(q, propagated);
}

FieldModes LinearRemainder::subtracted(std::size_t n, const numerics::Wavevector& q, double inverse,
                                       const FieldModes& fields) const {
    using Complex = std::complex<double>;
    const double c = inverse == 0.0 ? 1.0 : q.x * inverse, s = inverse == 0.0 ? 0.0 : q.y * inverse;
    const auto times_i = [](const Complex& a) { return Complex(-a.imag(), a.real()); };
    const auto times_minus_i = [](const Complex& a) { return Complex(a.imag(), -a.real()); };
    std::array<Complex, 4> in{fields(rho), fields(sigma), 0.0, 0.0};
    std::array<Complex, 2> in_across{};
    for (std::size_t v = 0; v < 2; ++v) {
        const int x = v == 0 ? v_x : p_x;
        in[2 + v] = times_i(c * fields(x) + s * fields(x + 1));
        in_across[v] = times_i(c * fields(x + 1) - s * fields(x));
    }
    const Blocks& m = subtracted_[n];
    const auto row = [&](std::size_t r) {
        return m.along[4 * r] * in[0] + m.along[4 * r + 1] * in[1] + m.along[4 * r + 2] * in[2] +
               m.along[4 * r + 3] * in[3];
    };
    FieldModes out;
    out(rho) = row(0);
    out(sigma) = row(1);
    for (std::size_t v = 0; v < 2; ++v) {
        const int x = v == 0 ? v_x : p_x;
        const Complex along = times_minus_i(row(2 + v)),
                      across = times_minus_i(m.across[2 * v] * in_across[0] + m.across[2 * v + 1] * in_across[1]);
        out(x) = c * along - s * across;
        out(x + 1) = s * along + c * across;
    }
    return out;
}

}  // namespace drover::physics
