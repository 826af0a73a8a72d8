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
    for (const double q : wavenumbers) {
        subtracted_.push_back(Symbol::Zero());
        for (const Term* term : whole) add_isotropic_part(equations, *term, reference, q, subtracted_.back());
    }
    const bool none =
        std::all_of(subtracted_.begin(), subtracted_.end(), [](const Symbol& m) { return m.isZero(0.0); });
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
    const double c = inverse == 0.0 ? 1.0 : q.x * inverse, s = inverse == 0.0 ? 0.0 : q.y * inverse;
    const auto turned = [](FieldModes f, double cosine, double sine) {
        for (const int x : {v_x, p_x}) {
            const std::complex<double> along = cosine * f(x) + sine * f(x + 1),
                                       across = cosine * f(x + 1) - sine * f(x);
            f(x) = along;
            f(x + 1) = across;
        }
        return f;
    };
    const FieldModes in = turned(fields, c, s);
    const Symbol& m = subtracted_[n];
    FieldModes out;  // along q and across q do not mix
    for (const int row : {rho, sigma, v_x, p_x})
        out(row) = m(row, rho) * in(rho) + m(row, sigma) * in(sigma) + m(row, v_x) * in(v_x) + m(row, p_x) * in(p_x);
    for (const int row : {v_y, p_y}) out(row) = m(row, v_y) * in(v_y) + m(row, p_y) * in(p_y);
    return turned(out, c, -s);
}

}  // namespace drover::physics
