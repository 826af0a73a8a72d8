// measure/independent_units.cpp: the jackknife over units of unlike size.
#include "measure/independent_units.hpp"

#include <cmath>
#include <limits>

namespace drover::measure {

std::size_t stretches_of(std::size_t bodies) {
    return bodies == 0 || bodies >= min_units ? 1 : (min_units + bodies - 1) / bodies;
}

Estimate estimate_units(const std::vector<std::vector<double>>& sums, const std::vector<std::vector<double>>& counts,
                        const std::function<double(std::span<const double> means)>& function) {
    const std::size_t quantities = sums.empty() ? 0 : sums[0].size();
    std::vector<double> total(quantities), number(quantities), means(quantities), parts;
    std::vector<std::size_t> filled;
    for (std::size_t u = 0; u < sums.size(); ++u) {
        double held = 0.0;
        for (std::size_t k = 0; k < quantities; ++k) {
            total[k] += sums[u][k];
            number[k] += counts[u][k];
            held += counts[u][k];
        }
        if (held > 0.0) filled.push_back(u);
    }
    for (std::size_t k = 0; k < quantities; ++k) means[k] = total[k] / number[k];
    Estimate result{.mean = quantities > 0 ? function(means) : std::numeric_limits<double>::quiet_NaN()};
    for (const double count : number) result.samples = std::max(result.samples, static_cast<std::size_t>(count));
    if (!std::isfinite(result.mean)) {
        result.refusal = "error refused: there is no finite value";
        return result;
    }
    if (filled.size() < 2) {
        result.refusal =
            "error refused: one unit alone does not tell how units differ; follow more bodies or for longer";
        return result;
    }
    double sum = 0.0, squares = 0.0;
    for (const std::size_t u : filled) {
        for (std::size_t k = 0; k < quantities; ++k) means[k] = (total[k] - sums[u][k]) / (number[k] - counts[u][k]);
        parts.push_back(function(means));
        sum += parts.back();
    }
    const auto units = static_cast<double>(filled.size());
    for (const double part : parts) squares += (part - sum / units) * (part - sum / units);
    const double error = std::sqrt((units - 1.0) / units * squares);
    if (!std::isfinite(error)) {
        result.refusal = "error refused: one unit holds all there is";
        return result;
    }
    result.mean -= (units - 1.0) * (sum / units - result.mean);
    result.error = error;
    result.blocks = filled.size();
    return result;
}

std::vector<Estimate> estimate_each(const std::vector<std::vector<double>>& sums,
                                    const std::vector<std::vector<double>>& counts) {
    std::vector<Estimate> result;
    const std::size_t quantities = sums.empty() ? 0 : sums[0].size();
    for (std::size_t k = 0; k < quantities; ++k) {
        std::vector<std::vector<double>> one_sum, one_count;
        double sum = 0.0, count = 0.0;
        for (std::size_t u = 0; u < sums.size(); ++u) {
            one_sum.push_back({sums[u][k]});
            one_count.push_back({counts[u][k]});
            sum += sums[u][k];
            count += counts[u][k];
        }
        result.push_back(estimate_units(one_sum, one_count, [](auto means) { return means[0]; }));
        result.back().mean =
            sum / count;  // a plain mean has no bias; what the jackknife takes off with unlike units is noise
    }
    return result;
}

}  // namespace drover::measure
