// numerics/algebra/spline_table.hpp: a smooth function of one or two numbers through values on a rectangular mesh.
#pragma once
#include <array>
#include <vector>

namespace drover::numerics {

/// A value and its derivatives with respect to the first and the second number.
struct TableValue {
    double value = 0.0;
    double by_first = 0.0, by_second = 0.0;
};

/// Treatment of points outside the table.
enum class Outside {
    refuse,  ///< NaN; the caller reports an error
    hold     ///< the value at the edge, with zero derivative
};
constexpr auto names_of(Outside) { return std::array{"refuse", "hold"}; }

/// Bicubic interpolation on a rectangular mesh; the value and its first derivatives are continuous.  The derivatives at
/// the nodes are those of natural cubic splines along each axis, computed by GSL.  With one node on an axis the
/// function does not depend on that number; with two nodes the interpolation is linear.
class SplineTable {
public:
    /// values: [first][second], the second fastest; errors: their independent standard errors, or empty.  Throws an
    /// input Error unless the axes ascend, all numbers are finite, there is one per node, and no error is negative.
    SplineTable(std::vector<double> first, std::vector<double> second, std::vector<double> values, Outside outside,
                std::vector<double> errors = {});

    TableValue at(double first, double second) const;

    /// Standard error of the value.  The value is linear in the nodal values, sum w_k y_k, so its variance is exactly
    /// sum w_k^2 e_k^2.  Zero if the nodes have no errors.  Excludes the error of interpolation between nodes and of
    /// values held at the edge; NaN outside a table that refuses.
    double standard_error(double first, double second) const;

    const std::vector<double>& first() const { return first_; }
    const std::vector<double>& second() const { return second_; }
    bool depends_on_first() const { return first_.size() > 1; }
    bool depends_on_second() const { return second_.size() > 1; }

private:
    struct Node {
        double value = 0.0, by_first = 0.0, by_second = 0.0, by_both = 0.0;
    };
    std::vector<double> first_, second_, errors_;
    std::vector<Node> nodes_;  ///< [first][second]
    Outside outside_;
};

}  // namespace drover::numerics
