// calibrate/assays/plan_support.hpp: setups, forces and fits shared by several assays.
#pragma once
#include <algorithm>
#include <cmath>
#include <functional>
#include <span>
#include <vector>

#include "drover/base/error.hpp"
#include "drover/calibrate/assay.hpp"
#include "numerics/algebra/extremum.hpp"

namespace drover::calibrate {

/// The setup without rods.
inline dem::Setup beads_alone(dem::Setup setup) {
    setup.rods.count = 0;
    setup.rods.area_fraction = 0.0;
    setup.packing = {};
    setup.forces = {};
    return setup;
}

/// The setup with its rods along x or in random directions, and with no force but one that holds the mean velocity of
/// any beads at zero: in a small periodic cell a rod would follow its own wake.
inline dem::Setup with_rods(dem::Setup setup, bool aligned) {
    setup.packing = {.kind = aligned ? dem::PackingKind::aligned : dem::PackingKind::random};
    setup.forces = {.hold_beads = setup.beads.any()};
    return setup;
}

inline void require_beads(const dem::Setup& setup, const char* assay) {
    require(setup.beads.any(), {}, "{}: the setup has no beads; expected beads.area_fraction or beads.count > 0",
            assay);
}

/// Whether values ascend strictly, as quantities that are named after them require.
inline bool is_ascending(const std::vector<double>& values) {
    return std::ranges::adjacent_find(values, std::greater_equal<>{}) == values.end();
}

/// Number of frames in a time, at least 1.
inline std::size_t frames_in(double time, double frame) {
    return static_cast<std::size_t>(std::max(1.0, std::round(time / frame)));
}

/// The rods of a system of this setup at the end of the warm-up and in each frame after it.
template <class Plan>
std::vector<std::vector<RodPose>> rod_frames(const Plan& plan, const SystemFactory& make, const dem::Setup& setup,
                                             std::uint64_t seed) {
    const auto system = make(setup, seed);
    std::vector<std::vector<RodPose>> rods;
    for (std::size_t frame = 0; frame <= frames_in(plan.time, plan.frame); ++frame) {
        system->advance_to(plan.warm_up + static_cast<double>(frame) * plan.frame);
        rods.push_back(system->rods());
    }
    return rods;
}

/// Mean of each number over all trials.
inline std::vector<double> means_over(std::span<const Trial> trials) {
    std::vector<double> means(trials.front().size(), 0.0);
    for (const Trial& trial : trials)
        for (std::size_t i = 0; i < means.size(); ++i) means[i] += trial[i] / static_cast<double>(trials.size());
    return means;
}

/// The estimator of an assay that takes the same one for any trials.
inline std::function<Estimator(std::span<const Trial>)> always(Estimator estimator) {
    return [estimator](std::span<const Trial>) { return estimator; };
}

using numerics::fit_line;
using numerics::least_squares;
using numerics::Line;

}  // namespace drover::calibrate
