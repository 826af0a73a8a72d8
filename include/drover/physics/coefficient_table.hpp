// physics/coefficient_table.hpp: measured coefficients as smooth functions of the two densities.
#pragma once
#include <string>
#include <vector>

namespace drover::physics {

/// A value and its derivatives with respect to the bead density rho and the rod density sigma.
struct Dependence {
    double value = 0.0;
    double by_beads = 0.0;  ///< d/d rho
    double by_rods = 0.0;   ///< d/d sigma
};

/// Treatment of densities outside the table.
enum class Outside {
    refuse,  ///< NaN; the caller reports an error
    hold     ///< the value at the edge, with zero derivative
};

/// Bicubic interpolation on a rectangular mesh of densities; the value and its first derivatives are continuous.  The
/// derivatives at the nodes are those of natural cubic splines along each axis, computed by GSL.  With one node on an
/// axis the coefficient does not depend on that density; with two nodes the interpolation is linear.
class CoefficientTable {
public:
    /// values: [bead][rod], rods fastest; errors: their independent standard errors, or empty.  Throws an input Error
    /// unless the axes ascend, all numbers are finite, there is one per node, and no error is negative.
    CoefficientTable(std::vector<double> bead_densities, std::vector<double> rod_densities, std::vector<double> values,
                     Outside outside, std::vector<double> errors = {});

    Dependence at(double bead_density, double rod_density) const;

    /// Standard error of the value.  The value is linear in the nodal values, sum w_k y_k, so its variance is exactly
    /// sum w_k^2 e_k^2.  Zero if the nodes have no errors.  Excludes the error of interpolation between nodes and of
    /// holding the value constant beyond the edge.
    double standard_error(double bead_density, double rod_density) const;
    bool depends_on_beads() const { return beads_.size() > 1; }
    bool depends_on_rods() const { return rods_.size() > 1; }

    /// For messages: "bead density 0.2 to 0.7, rod density 0.05 to 0.11".
    std::string range_text() const;

private:
    struct Node {
        double value = 0.0, by_beads = 0.0, by_rods = 0.0, by_both = 0.0;
    };
    std::vector<double> beads_, rods_;
    std::vector<Node> nodes_;  // [bead][rod]
    std::vector<double> errors_;
    Outside outside_;
};

}  // namespace drover::physics
