// measure/jackknife.hpp: means and functions of means with errors from the jackknife over independent groups of values.
#pragma once
#include <functional>
#include <span>
#include <vector>

#include "drover/measure/statistics.hpp"

namespace drover::measure {

/// Sums of values and their numbers, [group][quantity].
struct GroupSums {
    std::vector<std::vector<double>> sums, counts;
    GroupSums(std::size_t groups, std::size_t quantities)
        : sums(groups, std::vector<double>(quantities)), counts(groups, std::vector<double>(quantities)) {}
    void add(std::size_t group, std::size_t quantity, double value) {
        sums[group][quantity] += value;
        counts[group][quantity] += 1.0;
    }
};

/// `function` of the means of the quantities over all groups.  Empty groups are left out.
Estimate jackknife(const GroupSums& group_sums, const std::function<double(std::span<const double> means)>& function);

/// The mean of each quantity, sum over number whatever the sizes of the groups, with its error by the jackknife.
std::vector<Estimate> jackknife_means(const GroupSums& group_sums);

}  // namespace drover::measure
