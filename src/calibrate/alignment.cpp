// calibrate/alignment.cpp: mean-field theory of rods that align with their mean orientation.
#include "calibrate/alignment.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "base/constants.hpp"
#include "drover/base/error.hpp"

namespace drover::calibrate {

namespace {
// The Bessel functions are slow from here on and overflow beyond several hundred; the omitted terms of the asymptotic
// series (Abramowitz & Stegun, 9.7.1) are below 1e-11 there.
constexpr double large = 80.0;

/// I1(x)/I0(x).
double bessel_ratio(double x) {
    if (x < large) return std::cyl_bessel_i(1.0, x) / std::cyl_bessel_i(0.0, x);
    const double y = 1.0 / x;
    return 1.0 - y * (0.5 + y * (0.125 + y * (0.125 + y * (25.0 / 128.0 + y * 13.0 / 32.0))));
}

/// d/dx of it; the difference of its exact form cancels at large x.
double bessel_ratio_slope(double x, double ratio) {
    if (x < 1e-4) return 0.5;
    return x < large ? 1.0 - ratio / x - ratio * ratio : (0.5 + (0.25 + 0.375 / x) / x) / (x * x);
}

double log_bessel(double x) {
    if (x < large) return std::log(std::cyl_bessel_i(0.0, x));
    return x - 0.5 * std::log(2.0 * std::numbers::pi * x) +
           std::log1p((0.125 + (9.0 / 128.0 + 75.0 / 1024.0 / x) / x) / x);
}

/// The density of |P| without alignment, as its logarithm without the part that is proportional to N.
struct OrderNode {
    double order, log_weight, entropy;  ///< entropy: per rod
};
const std::vector<OrderNode>& order_nodes() {
    static const std::vector<OrderNode> nodes = [] {
        constexpr int count = 400;
        std::vector<OrderNode> made;
        for (int i = 0; i < count; ++i) {
            const double order = (i + 0.5) / count, x = concentration_of_order(order);
            // The saddle point: det of the Hessian is (P/kappa) dP/dkappa; the plane has P dP.
            const double determinant = order / x * bessel_ratio_slope(x, order);
            made.push_back({order, std::log(order) - 0.5 * std::log(determinant), log_bessel(x) - x * order});
        }
        return made;
    }();
    return nodes;
}
}  // namespace

double order_of_alignment(double alignment, double cubic) {
    const auto excess = [&](double order) {
        const double pull = order * (alignment + cubic * order * order);
        return (pull > 0.0 ? bessel_ratio(pull) : 0.0) - order;
    };
    // Below P = 1, where it is negative.  Without g3 it is concave: there is one root, and none for g <= 2.
    double low = 0.0, high = 1.0;
    if (cubic != 0.0) {
        constexpr int steps = 400;
        int step = steps - 1;
        while (step > 0 && excess(static_cast<double>(step) / steps) <= 0.0) --step;
        low = static_cast<double>(step) / steps;
        high = static_cast<double>(step + 1) / steps;
    }
    if (low == 0.0 && !(alignment > 2.0)) return 0.0;
    constexpr int halvings = 100;
    for (int i = 0; i < halvings; ++i) {
        const double middle = 0.5 * (low + high);
        (excess(middle) > 0.0 ? low : high) = middle;
    }
    return 0.5 * (low + high);
}

double saturation_of_alignment(double alignment, double cubic) {
    // Closer to onset P^2 = (g - 2)(1 - 5/6 (g - 2)) suffers from cancellation; the limit is as accurate there.
    constexpr double near = 1e-6;
    if (alignment < 2.0 + near) return std::max(0.125 * alignment * alignment, 0.5 * cubic);
    const double order = order_of_alignment(alignment, cubic);
    return (0.5 * alignment - 1.0) / (order * order) + 0.5 * cubic;
}

double concentration_of_order(double order) {
    const double size = std::abs(order);
    if (!(size < 1.0)) return nan;
    // Newton's method from the approximation of Banerjee et al., J. Mach. Learn. Res. 6, 1345 (2005).
    double x = size * (2.0 - size * size) / (1.0 - size * size);
    constexpr int steps = 20;
    for (int i = 0; i < steps; ++i) {
        const double ratio = bessel_ratio(x), step = (ratio - size) / bessel_ratio_slope(x, ratio);
        x = std::max(x - step, 0.0);
        if (std::abs(step) < 1e-12 * x) break;
    }
    return std::copysign(x, order);
}

RodsOrder order_of_rods(int rods, double alignment, double cubic) {
    require(rods >= 2, {}, "the order of {} rods; expected at least 2", rods);
    const double n = rods;
    const std::vector<OrderNode>& nodes = order_nodes();
    std::vector<double> logs;
    for (const OrderNode& node : nodes) {
        const double square = node.order * node.order;
        logs.push_back(node.log_weight + n * (node.entropy + (0.5 * alignment + 0.25 * cubic * square) * square));
    }
    const double max_log = *std::ranges::max_element(logs);
    double norm = 0.0, square = 0.0;
    RodsOrder result;
    for (std::size_t i = 0; i < nodes.size(); ++i) {
        const double weight = std::exp(logs[i] - max_log), order = nodes[i].order;
        norm += weight;
        result.mean += weight * order;
        square += weight * order * order;
    }
    result.mean /= norm;
    result.deviation = std::sqrt(std::max(square / norm - result.mean * result.mean, 0.0));
    return result;
}

}  // namespace drover::calibrate
