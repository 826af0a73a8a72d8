// measure/independent_units.hpp: estimates from units taken as independent, by the jackknife.
#pragma once
#include <functional>
#include <span>
#include <vector>

#include "drover/measure/trajectories.hpp"

namespace drover::measure {

/// How many stretches of time each of some bodies is cut into.
std::size_t stretches_of(std::size_t bodies);

/// Sums of values and their numbers, [unit][quantity].
struct UnitSums {
    std::vector<std::vector<double>> sums, counts;
    UnitSums(std::size_t units, std::size_t quantities)
        : sums(units, std::vector<double>(quantities)), counts(units, std::vector<double>(quantities)) {}
    void add(std::size_t unit, std::size_t quantity, double value) {
        sums[unit][quantity] += value;
        counts[unit][quantity] += 1.0;
    }
};

/// Which stretch the origin i of so many belongs to.
inline std::size_t stretch_of(std::size_t i, std::size_t origins, std::size_t stretches) {
    return i * stretches / origins;
}

/// `function` of the means over all units of the quantities.  Units that hold nothing are left out.
Estimate estimate_units(const std::vector<std::vector<double>>& sums, const std::vector<std::vector<double>>& counts,
                        const std::function<double(std::span<const double> means)>& function);

/// The mean of each quantity by itself: sum over number, whatever the sizes of units, and its error by the jackknife.
std::vector<Estimate> estimate_each(const std::vector<std::vector<double>>& sums,
                                    const std::vector<std::vector<double>>& counts);

}  // namespace drover::measure
