// run/passed_onset.hpp: how far a ramp of the order has passed the onset of flocking when a run ends.
#pragma once
#include "drover/io/scene.hpp"

namespace drover::run {

struct PassedOnset {
    double rate = 0.0;      ///< at which uniform order grows from the isotropic state at the end [1/s]
    double exponent = 0.0;  ///< by how much it may have grown since the onset: the logarithm of a factor
    double order = 0.0;     ///< at which it saturates at the end
};
/// Of a scene whose relaxation saturates; all 0 where a text is not defined without order.
PassedOnset passed_onset(const io::Scene& scene);

}  // namespace drover::run
