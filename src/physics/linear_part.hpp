// physics/linear_part.hpp: properties of a term's linearisation in q: its isotropic part, its powers.
#pragma once
#include <vector>

#include "drover/physics/term.hpp"

namespace drover::physics {

/// Throws an input Error where a term declares an isotropic linear part that its linearisation does not have, or an
/// action that does not fit its linear part.
void check_linear_part(const CompiledModel& model, const Term& term);

/// Whether the linearisation of a term about a state at rest commutes with rotations and reflections: compared at two
/// angles and three |q|.
bool has_isotropic_linearisation(const CompiledModel& model, const Term& term);

/// Throws an input Error that names a term without a finite derivative in a uniform state.
void require_linearisation(const CompiledModel& model, const std::vector<Term>& terms, const UniformPoint& about);

/// The term's part in the propagator at q along x, about a reference.
void add_isotropic_part(const CompiledModel& model, const Term& term, const Reference& reference, double q, Symbol& m);

/// A symbol in axes turned by an angle of this cosine and sine: R m R^T.
Symbol rotated(const Symbol& m, double cosine, double sine);

using Matrix6 = Eigen::Matrix<double, FieldIndex::count, FieldIndex::count>;

/// Even and odd part of a polynomial of fourth degree along one direction: c0 + c2 s^2 + c4 s^4, c1 s + c3 s^3.
struct Quartic {
    Matrix6 c0, c1, c2, c3, c4;
};

template <class At>
Quartic quartic(At at, double x, double y) {
    const Symbol f0 = at(0.0, 0.0), f1 = at(x, y), f2 = at(2.0 * x, 2.0 * y);
    Quartic p;
    p.c0 = f0.real();
    const Matrix6 d1 = f1.real() - p.c0, d2 = f2.real() - p.c0;
    p.c4 = (d2 - 4.0 * d1) / 12.0;
    p.c2 = d1 - p.c4;
    p.c3 = (f2.imag() - 2.0 * f1.imag()) / 6.0;
    p.c1 = f1.imag() - p.c3;
    return p;
}

}  // namespace drover::physics
