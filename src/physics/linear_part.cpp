// physics/linear_part.cpp: linearisations in axes along and across q, compared and averaged over directions.
#include "linear_part.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "term_shapes.hpp"

namespace drover::physics {

namespace {
using numerics::Wavevector;

Symbol symbol_of(const CompiledModel& model, const Term& term, const UniformPoint& about, const Wavevector& q) {
    Symbol m = Symbol::Zero();
    if (term.linearise) term.linearise(model, about, q, m);
    return m;
}

Symbol symbol_at_angle(const CompiledModel& model, const Term& term, const UniformPoint& about, double q,
                       double angle) {
    const double c = std::cos(angle), s = std::sin(angle);
    return rotated(symbol_of(model, term, about, {.x = q * c, .y = q * s}), c, -s);
}

/// What of a symbol along and across q an isotropic operator can have: no part that joins along and across, and
/// parities that make it real with the factor i on vectors.
Symbol even_part(const Symbol& m) {
    const std::array along{rho, sigma, v_x, p_x};
    const std::array across{v_y, p_y};
    Symbol result = Symbol::Zero();
    for (const int row : along)
        for (const int column : along)
            result(row, column) = (row >= v_x) == (column >= v_x) ? std::complex<double>(m(row, column).real(), 0.0)
                                                                  : std::complex<double>(0.0, m(row, column).imag());
    for (const int row : across)
        for (const int column : across) result(row, column) = m(row, column).real();
    return result;
}
}  // namespace

Symbol rotated(const Symbol& m, double cosine, double sine) {
    Symbol rotation = Symbol::Identity();
    for (const int vector : {v_x, p_x}) rotation.block<2, 2>(vector, vector) << cosine, -sine, sine, cosine;
    return rotation * m * rotation.transpose();
}

namespace {
/// Whether a linearisation is a polynomial in q of the declared degree, even powers real and odd ones imaginary.
bool has_declared_degree(const CompiledModel& model, const Term& term, const UniformPoint& about) {
    if (!term.linearise || term.degree_in_q < 0) return true;
    if (term.degree_in_q > 4) return false;
    const auto at = [&](double x, double y) {
        Symbol m = Symbol::Zero();
        term.linearise(model, about, {.x = x, .y = y}, m);
        return m;
    };
    for (const auto& [x, y] : {std::pair{0.6, 0.8}, std::pair{-0.8, 0.6}}) {
        const Quartic p = quartic(at, x, y);
        const double size = p.c0.cwiseAbs().maxCoeff() + p.c1.cwiseAbs().maxCoeff() + p.c2.cwiseAbs().maxCoeff() +
                            p.c3.cwiseAbs().maxCoeff() + p.c4.cwiseAbs().maxCoeff();
        const Symbol found = at(3.0 * x, 3.0 * y);
        const double wrong = (found.real() - p.c0 - 9.0 * p.c2 - 81.0 * p.c4).cwiseAbs().maxCoeff() +
                             (found.imag() - 3.0 * p.c1 - 27.0 * p.c3).cwiseAbs().maxCoeff() +
                             (term.degree_in_q <= 2 ? p.c3.cwiseAbs().maxCoeff() + p.c4.cwiseAbs().maxCoeff() : 0.0);
        if (wrong > 1e-11 * size) return false;  // rounding of 81 c4: 1e-14
    }
    return true;
}
}  // namespace

void check_linear_part(const CompiledModel& model, const Term& term) {
    require(!term.remainder || term.linear_part == LinearPart::isotropic, {},
            "{}: a term that sets `remainder` must have an isotropic linear part; set `whole` instead", term.name);
    require(!term.whole || !term.remainder, {}, "{}: a term sets either `remainder` or `whole`, not both", term.name);
    require(term.linear_part != LinearPart::none || term.whole, {},
            "{}: a term without a linear part in the propagator must set `whole`", term.name);
    require(term.linear_part != LinearPart::isotropic || has_isotropic_linearisation(model, term), {},
            "{}: the term declares an isotropic linear part, but its linearisation depends on the direction of q; "
            "declare the linear part averaged or none",
            term.name);
    // A state without any symmetry.
    const UniformPoint about{.bead_density = 1.1, .rod_density = 0.7, .velocity = {0.3, -0.5}, .order = {0.6, 0.2}};
    require(has_declared_degree(model, term, about), {},
            "{}: its linearisation is not a polynomial in q of the declared degree {}", term.name, term.degree_in_q);
}

bool has_isotropic_linearisation(const CompiledModel& model, const Term& term) {
    const UniformPoint rest = at_rest(reference(model.model.uniform));
    for (const double q : {0.0, 0.9, 2.3}) {
        const Symbol along_x = symbol_of(model, term, rest, {.x = q, .y = 0.0});
        double wrong = (along_x - even_part(along_x)).cwiseAbs().maxCoeff();
        for (const double angle : {0.7, 1.9})
            wrong = std::max(wrong, (symbol_at_angle(model, term, rest, q, angle) - along_x).cwiseAbs().maxCoeff());
        // The rotation rounds at 1e-16; an anisotropy is of the size of the term.
        if (wrong > 1e-12 * along_x.cwiseAbs().maxCoeff()) return false;
    }
    return true;
}

void require_linearisation(const CompiledModel& model, const std::vector<Term>& terms, const UniformPoint& about) {
    for (const Term& term : terms) {
        if (!term.linearise) continue;
        Symbol m = Symbol::Zero();
        term.linearise(model, about, {.x = 0.6, .y = 0.8}, m);
        require(m.allFinite(), {},
                "{} has no finite derivative in the uniform state of |p| = {:.4g}; expected one: linear theory about "
                "this state does not exist",
                term.name, about.order.norm());
    }
}

void add_isotropic_part(const CompiledModel& model, const Term& term, const Reference& reference, double q, Symbol& m) {
    const UniformPoint rest = at_rest(reference);
    if (term.linear_part == LinearPart::isotropic && term.linearise) term.linearise(model, rest, {.x = q, .y = 0.0}, m);
    if (term.linear_part != LinearPart::averaged) return;
    // Harmonics of the angle up to the power of q and four of the rotations: exact up to q^11.
    constexpr int angles = 16;
    Symbol sum = Symbol::Zero();
    for (int n = 0; n < angles; ++n) sum += symbol_at_angle(model, term, rest, q, 2.0 * std::numbers::pi * n / angles);
    m += even_part(sum / angles);
}

}  // namespace drover::physics
