// analysis/lagged_waves.hpp: correlations in time of linear theory about the uniform state nearest to a run.
#pragma once
#include <complex>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "drover/numerics/grid.hpp"
#include "io/scene.hpp"

namespace drover::analysis {

struct LaggedWaves {
    std::string state;                         ///< name of the uniform state
    std::vector<std::complex<double>> values;  ///< [wave][lag]; NaN for a wave without a prediction
    /// Why there is none: values are then empty; or why the first such wave has none.
    std::optional<std::string> why_none;
};

/// <a_q(t + n interval) a_q(t)*>/area for n = 0 .. lags - 1, of one component of a frame ("rod_density",
/// "polar_order_x") about the uniform state nearest to the means of all, by name, turned to the direction of their
/// order.  The interval [s].  Throws an input Error for a component that the scene does not have.
LaggedWaves lagged_waves(const io::Scene& scene, const std::map<std::string, double>& means,
                         const std::string& component, const std::vector<numerics::Wavevector>& waves, double interval,
                         std::size_t lags);

}  // namespace drover::analysis
