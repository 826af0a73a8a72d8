// theory/maxima.cpp: refined from the maxima, over the waves of a search, of the sums of the largest rates.
#include "theory/maxima.hpp"

#include <algorithm>
#include <cmath>

#include "base/constants.hpp"
#include "numerics/algebra/extremum.hpp"

namespace drover::theory {

namespace {
class Maxima {
public:
    Maxima(const GrowthOfModes& growth, const std::vector<double>& log_q, const std::vector<double>& angles)
        : growth_(growth), log_q_(log_q), angles_(angles), step_(log_q[1] - log_q[0]) {
        for (const double angle : angles)
            for (const double x : log_q) samples_.push_back(descending(x, angle));
    }
    std::vector<WavePlace> places() const {
        std::vector<WavePlace> found;
        for (Eigen::Index count = 1; count <= samples_.front().size(); ++count)
            for (std::size_t a = 0; a < angles_.size(); ++a)
                for (std::size_t k = 0; k < log_q_.size(); ++k)
                    if (may_lead(a, k, count)) found.push_back(refined({log_q_[k], angles_[a]}, count));
        return found;
    }

private:
    Eigen::VectorXd descending(double x, double angle) const {
        Eigen::VectorXd rates = growth_(x, angle);
        rates = rates.array().isNaN().select(-infinite, rates);
        std::ranges::sort(rates, std::greater{});
        return rates;
    }
    const Eigen::VectorXd& sample(std::size_t a, std::size_t k) const { return samples_[a * log_q_.size() + k]; }

    /// Whether the sum of the `count` largest has a maximum at a sample, near which the last of them may be largest.
    bool may_lead(std::size_t a, std::size_t k, Eigen::Index count) const {
        const Eigen::VectorXd& here = sample(a, k);
        const double sum = here.head(count).sum();
        double drop = 0.0;
        for (const std::size_t turned : neighbours_of_angle(a))
            for (std::size_t j = k > 0 ? k - 1 : k; j <= std::min(k + 1, log_q_.size() - 1); ++j) {
                const double other = sample(turned, j).head(count).sum();
                const bool is_before = std::pair{turned, j} < std::pair{a, k};  // of equal ones the first counts
                if (!(is_before ? other < sum : other <= sum) && std::pair{turned, j} != std::pair{a, k}) return false;
                drop = std::max(drop, sum - other);
            }
        // A parabola rises above its samples by at most a quarter of the drop.
        return sum > -infinite && (count == 1 || (drop > 0.0 && here(count - 1) + drop > here(0)));
    }
    std::vector<std::size_t> neighbours_of_angle(std::size_t a) const {
        const std::size_t n = angles_.size();
        if (n == 1) return {a};
        return {(a + n - 1) % n, a, (a + 1) % n};
    }

    double sum_at(const WavePlace& place, Eigen::Index count) const {
        return descending(std::clamp(place.first, log_q_.front(), log_q_.back()), place.second).head(count).sum();
    }
    /// The maximum of the sum, and from there that of the largest rate.
    WavePlace refined(const WavePlace& from, Eigen::Index count) const {
        const WavePlace top = climbed(from, count, step_);
        if (count == 1) return top;
        constexpr double part = 1e-4;  // of a step of the search: another mode may be near
        return climbed(top, 1, part * step_);
    }
    WavePlace climbed(const WavePlace& from, Eigen::Index count, double step) const {
        const auto at = [&](double x, double angle) { return sum_at({x, angle}, count); };
        WavePlace top = from;
        if (angles_.size() == 1) {
            top.first = numerics::climbed_along(from.first, step, [&](double x) { return at(x, from.second); });
        } else {
            const double turn = (angles_[1] - angles_[0]) * step / step_;
            top = numerics::climbed(at, from, {step, turn}, {log_q_.front(), log_q_.back()});
        }
        top.first = std::clamp(top.first, log_q_.front(), log_q_.back());
        return sum_at(top, count) > sum_at(from, count) ? top : from;
    }

    const GrowthOfModes& growth_;
    const std::vector<double>&log_q_, &angles_;
    double step_;
    std::vector<Eigen::VectorXd> samples_;  ///< [angle][wavenumber], descending
};
}  // namespace

GrowthOfModes growth_of_modes(const model::LinearisedAt& at) {
    return [&at](double log_q, double angle) -> Eigen::VectorXd {
        return mode_rates(at, at.wavevector(std::exp(log_q), angle)).real();
    };
}

std::vector<WavePlace> growth_maxima(const GrowthOfModes& growth, const std::vector<double>& log_q,
                                     const std::vector<double>& angles) {
    return Maxima(growth, log_q, angles).places();
}

}  // namespace drover::theory
