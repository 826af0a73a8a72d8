// physics/coefficient_table.hpp: measured coefficients as smooth functions of the two densities.
#pragma once
#include <string>
#include <vector>

namespace drover::physics {

/// A number and its slopes in the bead density rho and the rod density sigma.
struct Dependence {
    double value = 0.0;
    double by_beads = 0.0;  ///< d/d rho
    double by_rods = 0.0;   ///< d/d sigma
};

/// What happens to a density outside the table.
enum class Outside {
    refuse,  ///< not-a-number: the caller stops and says so
    hold     ///< the value at the edge, with slope zero beyond it
};

/// Values on a rectangular mesh of densities, joined by bicubic patches: value and slopes are continuous.  On the
/// nodes the slopes are those of cubic splines through the values (natural ends) along each axis, taken by GSL.  An
/// axis of one node: no dependence on that density; of two: straight lines.
class CoefficientTable {
public:
    /// values: [bead][rod], rods fastest; errors: their standard errors, independent of each other, or none.  Throws
    /// an input Error unless the axes ascend, the numbers are finite and as many as the nodes, and errors not negative.
    CoefficientTable(std::vector<double> bead_densities, std::vector<double> rod_densities, std::vector<double> values,
                     Outside outside, std::vector<double> errors = {});

    Dependence at(double bead_density, double rod_density) const;

    /// Standard error of the value: exact, for the value is linear in those of the nodes, sum w_k y_k, with the
    /// variance sum w_k^2 e_k^2.
    /// 0 without errors of the nodes.  What lies between them and is no cubic is not in it; nor is, beyond the edge,
    /// that the value there is held.
    double standard_error(double bead_density, double rod_density) const;
    bool depends_on_beads() const { return beads_.size() > 1; }
    bool depends_on_rods() const { return rods_.size() > 1; }

    /// "bead density 0.2 to 0.7, rod density 0.05 to 0.11": for messages.
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
