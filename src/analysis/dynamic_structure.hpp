// analysis/dynamic_structure.hpp: S(q, omega) of the linear theory about the uniform state nearest to a run.
#pragma once
#include <map>
#include <string>
#include <vector>

#include "drover/numerics/grid.hpp"
#include "io/scene.hpp"

namespace drover::analysis {

struct DynamicStructure {
    std::string state;           ///< name of the uniform state
    std::vector<double> values;  ///< [wave][frequency]; NaN where a wave grows
    std::string why_none;        ///< why there is no prediction; values are then empty
};

/// Of one component of a frame ("rod_density", "polar_order_x") about the uniform state nearest to the means of all, by
/// name, turned to the direction of their order.  The integral over omega/(2 pi) is S(q); a wave exp(i q.r - i omega t)
/// is at q and omega.  Of frames at an interval [s], in which faster waves appear at lower frequencies.  Throws an
/// input Error for a component that the scene does not have.
DynamicStructure dynamic_structure(const io::Scene& scene, const std::map<std::string, double>& means,
                                   const std::string& component, const std::vector<numerics::Wavevector>& waves,
                                   const std::vector<double>& frequencies, double interval);

}  // namespace drover::analysis
