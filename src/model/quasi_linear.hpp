// model/quasi_linear.hpp: the generalised quasi-linear approximation: short waves interact with long ones only.
#pragma once
#include <functional>
#include <vector>

#include "drover/model/equations.hpp"
#include "drover/numerics/field.hpp"

namespace drover::model {

/// The generalised quasi-linear approximation (Marston, Chini & Tobias, Phys. Rev. Lett. 116, 214501 (2016)) of a
/// rate N: with long waves l, |q| <= long_waves, and short waves h,
///     long:  N(l) + N''(l) h h/2,     short:  N'(l) h + N(mean).
/// N(mean) is what acts on short waves from outside.  Exact for products of up to three fields.
class QuasiLinear {
public:
    using Rate = std::function<void(const numerics::Spectra& state, numerics::Spectra& rate)>;

    /// `degree`: as for numerics::is_kept.
    QuasiLinear(const Equations& equations, double long_waves, const numerics::Grid& grid, int degree);

    /// As many evaluations as quasi_linear_evaluations() says; one where no kept wave is short.
    void write(const numerics::Spectra& state, const Rate& full, numerics::Spectra& rate);

private:
    void displace(const numerics::Spectra& state, double factor);

    std::vector<std::size_t> short_;  // their modes
    bool depends_on_place_;
    numerics::Spectra displaced_, other_;
};

/// Evaluations of N for one of the approximation.
int quasi_linear_evaluations(const Equations& equations);

}  // namespace drover::model
