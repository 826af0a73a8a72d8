// measure/trajectories.cpp: speeds along rods.
#include "measure/trajectories.hpp"

#include <cmath>
#include <numeric>

#include "drover/base/error.hpp"
#include "measure/jackknife.hpp"

namespace drover::measure {

Speeds speeds_along(std::span<const Path> rods, std::span<const std::vector<double>> angles, double spacing) {
    require(spacing > 0.0, {}, "frames {} s apart; expected a positive time", spacing);
    require(rods.size() == angles.size(), {}, "{} paths and angles of {} rods; expected equal numbers", rods.size(),
            angles.size());
    Speeds result;
    const std::size_t segments = segments_per_body(rods.size());
    GroupSums groups(rods.size() * segments, 1);
    for (std::size_t r = 0; r < rods.size(); ++r) {
        const Path& rod = rods[r];
        require(rod.x.size() == angles[r].size() && rod.y.size() == angles[r].size(), {},
                "rod {}: {} positions and {} angles; expected equal numbers", r, rod.x.size(), angles[r].size());
        const std::size_t frames = angles[r].empty() ? 0 : angles[r].size() - 1;
        std::vector<double> speeds;
        for (std::size_t i = 0; i < frames; ++i) {
            const double vx = (rod.x[i + 1] - rod.x[i]) / spacing, vy = (rod.y[i + 1] - rod.y[i]) / spacing;
            speeds.push_back(vx * std::cos(angles[r][i]) + vy * std::sin(angles[r][i]));
            groups.add(r * segments + segment_of(i, frames, segments), 0, speeds.back());
        }
        if (frames > 0)
            result.of_rods.push_back(std::accumulate(speeds.begin(), speeds.end(), 0.0) / static_cast<double>(frames));
    }
    const std::vector<Estimate> means = jackknife_means(groups.sums, groups.counts);
    if (!means.empty()) result.mean = means.front();
    return result;
}

}  // namespace drover::measure
