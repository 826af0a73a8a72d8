// physics/expansion.cpp: coefficients of powers of q, from values of the linearisations.
#include "expansion.hpp"

#include <algorithm>

#include "linear_part.hpp"

namespace drover::physics {

namespace {
/// Second derivatives along x, y and the diagonal.
template <class Second>
void add_second(Expansion& sum, Second second) {
    const Matrix6 xx = second(1.0, 0.0), yy = second(0.0, 1.0);
    sum.second_xx += xx;
    sum.second_yy += yy;
    sum.second_xy += second(1.0, 1.0) - xx - yy;
}
}  // namespace

Expansion expansion(const Equations& e, const UniformPoint& about) {
    const auto sum_of = [&](double x, double y, auto chosen) {
        Symbol m = Symbol::Zero();
        for (const Term& term : e.active)
            if (term.linearise && chosen(term)) term.linearise(e, about, {.x = x, .y = y}, m);
        return m;
    };
    for (const Term& term : e.active) {
        require(term.degree_in_q >= 0, {},
                "{}: its linearisation is not a polynomial in q, so it has no long-wave expansion", term.name);
        require(term.is_uniform_in_space, {},
                "{} depends on position or time: no uniform state exists, so linear wave theory does not apply",
                term.name);
    }
    require_linearisation(e, e.active, about);
    const auto at = [&](double x, double y) {
        return sum_of(x, y, [](const Term& term) { return term.degree_in_q <= 2; });
    };
    const Matrix6 zero = Matrix6::Zero();
    Expansion r{.constant = at(0.0, 0.0).real(),
                .first_x = at(1.0, 0.0).imag(),
                .first_y = at(0.0, 1.0).imag(),
                .second_xx = zero,
                .second_yy = zero,
                .second_xy = zero};
    // At a large q, a power of two, the even part is that in q^2, with the rounding of neither.
    constexpr double large = 0x1p20;
    add_second(r, [&](double x, double y) -> Matrix6 {
        return (at(large * x, large * y).real() - r.constant) / (large * large);
    });
    const auto is_higher = [](const Term& term) { return term.degree_in_q > 2; };
    if (std::none_of(e.active.begin(), e.active.end(), is_higher)) return r;
    const auto higher = [&](double x, double y) { return sum_of(x, y, is_higher); };
    r.constant += higher(0.0, 0.0).real();
    r.first_x += quartic(higher, 1.0, 0.0).c1;
    r.first_y += quartic(higher, 0.0, 1.0).c1;
    add_second(r, [&](double x, double y) { return quartic(higher, x, y).c2; });
    return r;
}

}  // namespace drover::physics
