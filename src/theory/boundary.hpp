// theory/boundary.hpp: margins of stability, the lines of a plane on which they vanish, and their error bands.
#pragma once
#include <cstddef>
#include <optional>
#include <vector>

#include "drover/theory/theory.hpp"
#include "numerics/algebra/contour.hpp"
#include "theory/draw_field.hpp"

namespace drover::theory {

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
