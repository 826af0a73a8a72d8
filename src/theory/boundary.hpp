// theory/boundary.hpp: margins of stability, the lines of a plane on which they vanish, and their error bands.
#pragma once
#include <cstddef>
#include <functional>
#include <optional>
#include <vector>

#include "base/constants.hpp"
#include "drover/theory/theory.hpp"
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

struct BoundaryPoint {
    double x = 0.0, y = 0.0;
    Margin at = {};      ///< the least stable wave
    BandEnds band = {};  ///< with draws
};

struct BoundaryLine {
    bool closed = false;  ///< otherwise it ends at the edge of the plane or where its state ceases to exist
    std::vector<BoundaryPoint> points;
};

struct Boundary {
    std::vector<BoundaryLine> lines;
    std::vector<numerics::PlanePoint> singular_points;  ///< unresolved cusps and double points
    double stable = nan, unstable = nan;                ///< fractions of the plane; elsewhere the state does not exist
    std::size_t evaluations = 0;                        ///< of the margin without errors
    bool complete = true;
    std::size_t poles = 0;  ///< vertices that are left out: the margin changes its sign there by diverging
    std::optional<DrawField> field = std::nullopt;  ///< with draws
};

/// Finds every closed curve wider than a sampling cell, see numerics/contour.hpp; vertices that a polyline within
/// options.chord does not need are left out, and poles of the margin, not its jumps.  `draws`: the margins with other
/// values of uncertain numbers, for the error band; without any there is none.  Several threads or processes call the
/// margins at once.
Boundary trace_boundary(const numerics::Rectangle& plane, const MarginOf& margin, const std::vector<MarginOf>& draws,
                        const numerics::ContourOptions& options, const ComputeAll& compute);

/// A margin over a plane, and the same with other values of uncertain numbers.
struct PlaneMargins {
    MarginOf at;
    std::vector<MarginOf> draws = {};
};
/// NaN, as where a state does not exist, where a margin throws an Error of the scene.
MarginOf where_valid(MarginOf margin);

/// The state of a margin: the isotropic one nearest to the references, or the one of the largest order.
enum class MarginState { isotropic, ordered };

/// How many states are not isotropic.
std::size_t ordered_states(const StationaryStates& found);

/// States of some models like the one of a margin, by whole searches.
struct KnownStates {
    std::vector<model::UniformState> values;
    std::size_t ordered = 0;  ///< the number of ordered states in a model that has the largest number
};

/// Of all waves of a search, of uniform changes and of the limit of long waves, where a conserved density or a turn of
/// the order changes slowly: at most 0 as soon as one of them grows.  Modes that neither grow nor decay at q = 0 count
/// through that limit.  The state is searched from those of like models: see stationary_states_near; an ordered one
/// elsewhere too, and by the whole search, which takes tens of milliseconds, where that finds fewer ordered states than
/// they have.  Throws as stationary_states and as LinearisedAt.
Margin margin(const model::Equations& equations, MarginState which, const KnownStates& known,
              const GrowthSearch& search);

}  // namespace drover::theory
