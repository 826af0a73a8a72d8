// physics/expansion.cpp: coefficients of powers of q.
#include "expansion.hpp"

namespace drover::physics {

Expansion expansion(const Equations& e, const UniformPoint& about) {
    const Matrix6 zero = Matrix6::Zero();
    Expansion r{zero, zero, zero, zero, zero, zero};
    const auto powers = e.powers(about);  // held: another thread may replace what the cache has
    for (const SymbolPower& power : *powers) {
        if (power.x + power.y == 0) r.constant += power.factors;
        else if (power.x == 1 && power.y == 0) r.first_x += power.factors;
        else if (power.x == 0 && power.y == 1) r.first_y += power.factors;
        else if (power.x == 2 && power.y == 0) r.second_xx -= power.factors;
        else if (power.x == 1 && power.y == 1) r.second_xy -= power.factors;
        else if (power.x == 0 && power.y == 2) r.second_yy -= power.factors;
    }
    return r;
}

}  // namespace drover::physics
