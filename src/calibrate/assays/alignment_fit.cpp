// calibrate/assays/alignment_fit.cpp: least squares of concentrations against order and torque.
#include "calibrate/assays/alignment_fit.hpp"

#include <cmath>

#include "calibrate/alignment.hpp"
#include "calibrate/assays/plan_support.hpp"

namespace drover::calibrate {

namespace {
/// One midpoint of two windows, or the only window of a field.
struct Point {
    double torque = 0.0, order = 0.0, change = 0.0;  ///< d_t P
};

std::vector<Point> points_of(std::span<const OrderInField> fields, double window) {
    std::vector<Point> points;
    for (const OrderInField& field : fields) {
        const std::vector<double>& orders = field.orders;
        if (orders.size() == 1) points.push_back({.torque = field.torque, .order = orders.front()});
        for (std::size_t w = 1; w < orders.size(); ++w)
            points.push_back({.torque = field.torque,
                              .order = 0.5 * (orders[w - 1] + orders[w]),
                              .change = (orders[w] - orders[w - 1]) / window});
    }
    return points;
}

/// Columns and right-hand sides, weighted.
struct Regression {
    std::vector<double> order, torque, concentration, lag;

    explicit Regression(const std::vector<Point>& points) {
        for (const Point& point : points) {
            const double kappa = concentration_of_order(point.order);
            constexpr double small = 1e-6;
            const double ratio = std::abs(point.order) < small ? 2.0 : kappa / point.order;
            const double weight = 1.0 - 1.0 / ratio - point.order * point.order;  // dP/dkappa
            order.push_back(weight * point.order);
            torque.push_back(weight * point.torque);
            concentration.push_back(weight * kappa);
            lag.push_back(weight * ratio * point.change);
        }
    }
};
}  // namespace

LinearAlignmentFit fit_alignment(std::span<const OrderInField> fields, double window) {
    const Regression r(points_of(fields, window));
    const std::vector<double> steady = least_squares({r.order, r.torque}, r.concentration),
                              drift = least_squares({r.order, r.torque}, r.lag);
    return {.steady = {.alignment = steady[0], .response = steady[1]},
            .drift = {.alignment = drift[0], .response = drift[1]}};
}

}  // namespace drover::calibrate
