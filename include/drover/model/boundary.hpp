// model/boundary.hpp: margins of stability, and the lines of a plane on which they vanish.
#pragma once
#include <array>
#include <cstddef>
#include <functional>
#include <vector>

#include "drover/model/theory.hpp"
#include "drover/numerics/contour.hpp"

namespace drover::model {

/// Positive where a state is stable.  Only the sign and the zeros are meaningful.
struct Margin {
    double value = 0.0;      ///< NaN: the state does not exist
    double angle = 0.0;      ///< of the least stable wave, from the direction of the state [rad]
    double q = 0.0;          ///< its |q|; 0: a uniform change, or the limit of long waves
    double frequency = 0.0;  ///< its -Im s
    bool is_uniform = false;
};

/// The margin at a point; with a wave, of that wave alone.
using MarginOf = std::function<Margin(const numerics::PlanePoint&, const Margin* wave)>;

/// A number with a standard error that shifts a line: the margins when it is larger by this part of its error.  Errors
/// of different numbers are independent.
using UncertainMargin = std::function<MarginOf(double part)>;

struct BoundaryPoint {
    double x = 0.0, y = 0.0;
    /// Standard error of the position of the line: (x, y) +- (error_x, error_y), along the gradient of the margin in
    /// the plane scaled to a square.  NaN where the margin has no gradient (a cusp or corner).
    double error_x = 0.0, error_y = 0.0;
    Margin at = {};  ///< the least stable wave
};

struct BoundaryLine {
    bool closed = false;  ///< otherwise it ends at the edge of the plane or where its state ceases to exist
    std::vector<BoundaryPoint> points;
};

struct Boundary {
    std::vector<BoundaryLine> lines;
    std::vector<numerics::PlanePoint> singular_points;  ///< unresolved cusps and double points
    std::size_t evaluations = 0;
    bool complete = true;
};

/// Finds every closed curve wider than a sampling cell, see numerics/contour.hpp.  Several threads or processes
/// call the margins at once.
Boundary trace_boundary(const numerics::Rectangle& plane, const MarginOf& margin,
                        const std::vector<UncertainMargin>& uncertain, const numerics::ContourOptions& options,
                        const ComputeAll& compute);

/// The state of a margin: the isotropic one nearest to the references, or the one of the largest order.
enum class MarginState { isotropic, ordered };

/// Of all waves of a search, of uniform changes and of the limit of long waves, where a conserved density or a turn of
/// the order changes slowly: at most 0 as soon as one of them grows.  Modes that neither grow nor decay at q = 0 count
/// through that limit.  An isotropic state is searched from `guesses`, which are states of like models: see
/// stationary_states_near; an ordered one by the whole search, which takes tens of milliseconds.  Throws as
/// stationary_states and as LinearisedAt.
Margin margin(const Equations& equations, MarginState which, const std::vector<UniformState>& guesses,
              const GrowthSearch& search, const Margin* wave = nullptr);

}  // namespace drover::model
