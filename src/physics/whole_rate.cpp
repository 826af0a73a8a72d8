// physics/whole_rate.cpp: sum of the linear part and the remainder.
#include "physics/whole_rate.hpp"

#include <algorithm>

namespace drover::physics {

WholeRate::WholeRate(const Equations& equations, const numerics::Grid& grid, const Densities& about, Threads& threads,
                     const Dealiasing& dealiasing)
    : WholeRate(model::system_of(integrated(equations, about, dealiasing), grid, threads)) {}

void WholeRate::write(double t, const numerics::Spectra& state, numerics::Spectra& rate) const {
    std::fill(rate.values.begin(), rate.values.end(), numerics::Complex(0.0));
    if (system.nonlinear) system.nonlinear(t, state, rate);
    linear.add(state, rate);
}

numerics::Spectra WholeRate::operator()(double t, const numerics::Spectra& state) const {
    numerics::Spectra rate(system.grid, state.count());
    write(t, state, rate);
    return rate;
}

}  // namespace drover::physics
