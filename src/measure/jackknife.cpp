// measure/jackknife.cpp: the jackknife over groups of unequal size.
#include "measure/jackknife.hpp"
#include "base/constants.hpp"

#include <cmath>

namespace drover::measure {

Estimate jackknife(const GroupSums& group_sums, const std::function<double(std::span<const double> means)>& function) {
    const auto& [sums, counts] = group_sums;
    const std::size_t quantities = sums.empty() ? 0 : sums[0].size();
    std::vector<double> total(quantities), number(quantities), means(quantities), left_out;
    std::vector<std::size_t> filled;
    for (std::size_t g = 0; g < sums.size(); ++g) {
        double values = 0.0;
        for (std::size_t k = 0; k < quantities; ++k) {
            total[k] += sums[g][k];
            number[k] += counts[g][k];
            values += counts[g][k];
        }
        if (values > 0.0) filled.push_back(g);
    }
    for (std::size_t k = 0; k < quantities; ++k) means[k] = total[k] / number[k];
    Estimate result{.mean = quantities > 0 ? function(means) : nan};
    for (const double count : number) result.samples = std::max(result.samples, static_cast<std::size_t>(count));
    if (!std::isfinite(result.mean)) {
        result.why_no_error = "no error estimate: there is no finite value";
        return result;
    }
    if (filled.size() < 2) {
        result.why_no_error =
            "no error estimate: there is only one independent value; follow more bodies, or for longer";
        return result;
    }
    double sum = 0.0, squares = 0.0;
    for (const std::size_t g : filled) {
        for (std::size_t k = 0; k < quantities; ++k) means[k] = (total[k] - sums[g][k]) / (number[k] - counts[g][k]);
        left_out.push_back(function(means));
        sum += left_out.back();
    }
    const auto groups = static_cast<double>(filled.size());
    for (const double value : left_out) squares += (value - sum / groups) * (value - sum / groups);
    const double error = std::sqrt((groups - 1.0) / groups * squares);
    if (!std::isfinite(error)) {
        result.why_no_error = "no error estimate: all values of one quantity are in one group";
        return result;
    }
    result.mean -= (groups - 1.0) * (sum / groups - result.mean);
    result.error = error;
    result.blocks = filled.size();
    return result;
}

std::vector<Estimate> jackknife_means(const GroupSums& group_sums) {
    const auto& [sums, counts] = group_sums;
    std::vector<Estimate> result;
    const std::size_t quantities = sums.empty() ? 0 : sums[0].size();
    for (std::size_t k = 0; k < quantities; ++k) {
        GroupSums one(sums.size(), 1);
        double sum = 0.0, count = 0.0;
        for (std::size_t g = 0; g < sums.size(); ++g) {
            one.sums[g][0] = sums[g][k];
            one.counts[g][0] = counts[g][k];
            sum += sums[g][k];
            count += counts[g][k];
        }
        result.push_back(jackknife(one, [](auto means) { return means[0]; }));
        result.back().mean = sum / count;  // a plain mean has no bias: the correction for unequal groups is noise
    }
    return result;
}

}  // namespace drover::measure
