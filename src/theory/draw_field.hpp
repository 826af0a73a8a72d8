// theory/draw_field.hpp: margins of stability over draws of uncertain numbers, and the band that they give.
#pragma once
#include <cstddef>
#include <functional>
#include <vector>

#include "base/constants.hpp"
#include "numerics/algebra/contour.hpp"

namespace drover::theory {

/// Positive where a state is stable.  Only the sign and the zeros are meaningful.
struct Margin {
    double value = 0.0;      ///< NaN: the state does not exist
    double angle = 0.0;      ///< of the least stable wave, from the direction of the state [rad]
    double q = 0.0;          ///< its |q|; 0: a uniform change, or the limit of long waves
    double frequency = 0.0;  ///< its -Im s
    bool is_uniform = false;
};

using MarginOf = std::function<Margin(const numerics::PlanePoint&)>;

/// Margins over draws of the uncertain numbers, at side x side points of the plane from corner to corner, rows of y
/// first.  Both numbers are over those draws in which the state exists; NaN where it exists in fewer than half of them.
struct DrawField {
    std::size_t draws = 0;
    int side = 0;
    std::vector<double> share;  ///< fraction of the draws in which the state is unstable
    /// The margin over its error, see over_error(): 1 where 16 % of the draws are unstable, -1 where 84 % are.
    std::vector<double> deviation;
    double with_line = 0.0;  ///< fraction of the draws that have a line in the plane
    double with_more = 0.0;  ///< fraction that has more lines than the plane without errors
};

/// Ends of the error band through a point of a line at constant y, and at constant x; NaN where the plane ends before
/// the band, where the band ends with its state, and where the point itself is neither in it nor on its edge.
struct BandEnds {
    double x_low = none, x_high = none, y_low = none, y_high = none;

    static constexpr double none = nan;
};

/// On `cells` cells along each side, at most 40 and a multiple of 4.
DrawField draw_field(const numerics::Rectangle& plane, const MarginOf& margin, const std::vector<MarginOf>& draws,
                     int cells, const ComputeAll& compute);

/// The ends of the band through each of these points.
std::vector<BandEnds> band_ends(const numerics::Rectangle& plane, const DrawField& field,
                                const std::vector<MarginOf>& draws, const std::vector<numerics::PlanePoint>& points,
                                const ComputeAll& compute);

}  // namespace drover::theory
