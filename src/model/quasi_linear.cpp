// model/quasi_linear.cpp: derivatives along the short waves, by differences that are exact for cubics.
#include "model/quasi_linear.hpp"

#include <algorithm>
#include <cmath>

namespace drover::model {

using numerics::Complex;
using numerics::Spectra;

namespace {
/// Whether the rate of a uniform state is not uniform, or has sources at points.
bool depends_on_place(const Equations& equations) {
    const std::vector<Field>& fields = equations.model().fields;
    return equations.placed_term() != nullptr ||
           std::any_of(fields.begin(), fields.end(), [](const Field& one) { return one.left == LeftSide::given; });
}
}  // namespace

int quasi_linear_evaluations(const Equations& equations) { return depends_on_place(equations) ? 5 : 4; }

QuasiLinear::QuasiLinear(const Equations& equations, double long_waves, const numerics::Grid& grid, int degree)
    : depends_on_place_(depends_on_place(equations)) {
    if (std::isinf(long_waves)) return;
    for (std::size_t j = 0; j < static_cast<std::size_t>(grid.ny); ++j)
        for (std::size_t i = 0; i < numerics::columns(grid); ++i) {
            const numerics::Wavevector q = numerics::wavevector(grid, i, j);
            if (numerics::is_kept(grid, degree, i, j) && std::hypot(q.x, q.y) > long_waves)
                short_.push_back(j * numerics::columns(grid) + i);
        }
    if (!short_.empty()) displaced_ = other_ = Spectra(grid, static_cast<int>(equations.state_components().size()));
}

/// The state with its short waves times a factor.
void QuasiLinear::displace(const Spectra& state, double factor) {
    displaced_ = state;
    for (int c = 0; c < state.count(); ++c)
        for (const std::size_t m : short_) displaced_[c][m] *= factor;
}

void QuasiLinear::write(const Spectra& state, const Rate& full, Spectra& rate) {
    if (short_.empty()) return full(state, rate);
    const auto of_short = [&](auto body) {
        for (int c = 0; c < state.count(); ++c)
            for (const std::size_t m : short_) body(rate[c][m], other_[c][m]);
    };
    // With D(e) = (N(l + e h) - N(l - e h))/2, N'(l) h = (8 D(1/2) - D(1))/3.
    full(state, rate);
    displace(state, -1.0);
    full(displaced_, other_);
    std::vector<Complex> slopes;
    of_short([&](Complex plus, Complex minus) { slopes.push_back((minus - plus) / 6.0); });
    for (std::size_t k = 0; k < rate.values.size(); ++k) rate.values[k] = 0.5 * (rate.values[k] + other_.values[k]);
    for (const double half : {0.5, -0.5}) {
        displace(state, half);
        full(displaced_, other_);
        std::size_t n = 0;
        of_short([&](Complex, Complex at) { slopes[n++] += std::copysign(4.0 / 3.0, half) * at; });
    }
    std::size_t n = 0;
    of_short([&](Complex& to, Complex) { to = slopes[n++]; });
    if (!depends_on_place_) return;
    std::fill(displaced_.values.begin(), displaced_.values.end(), Complex(0.0));
    for (int c = 0; c < state.count(); ++c) displaced_[c][0] = state[c][0];
    full(displaced_, other_);
    of_short([&](Complex& to, Complex source) { to += source; });
}

}  // namespace drover::model
