// physics/phase_boundary.hpp: lines in a plane of two numbers of a model on which a uniform state gains or loses
// stability.
#pragma once
#include <functional>
#include <string>
#include <vector>

#include "drover/numerics/contour.hpp"
#include "drover/physics/equations.hpp"
#include "drover/physics/long_waves.hpp"

namespace drover::physics {

/// What is lost or gained at a line.
enum class Limit {
    onset,             ///< abar = a - lambda alpha/Gamma = 0: the isotropic state gives way to a flock
    phase_separation,  ///< of the isotropic state, where abar > 0: a combination of the densities stops diffusing
    banding,           ///< of the flock: long waves along p0 grow
    oblique  ///< of the flock: long waves at some angle off p0 grow, however small: where banding does, so does this
};
/// "onset", "phase-separation", "banding", "oblique".
std::string limit_name(Limit limit);
Limit limit_of(const std::string& name);  ///< throws an input Error with the names that there are

/// Above 0 on the stable side.  Of long waves, q -> 0: exact there, by second-order perturbation; waves of finite
/// length may grow first, which physics/stability.hpp tells.  Its size has no meaning beyond its sign and its zero.
struct Margin {
    double value =
        /// Not-a-number: the state of which the limit speaks does not exist, or a coefficient refuses the densities
        0.0;
    double angle = 0.0;  ///< of the wave that decides, from p0 [rad]
};
Margin margin(const Equations& equations, double bead_density, double rod_density, Limit limit);

/// One side of a plane of models.
struct PlaneAxis {
    std::string name;  ///< its key in the scene, or bead_area_fraction, rod_area_fraction
    std::string unit;
    double from = 0.0, to = 1.0;
    std::function<void(Model&, double)> set;
    bool is_density = false;  ///< changes the uniform densities alone: the coefficients need no new making
};

/// A number that is known up to its standard error; errors of different numbers are independent of each other.
struct Uncertain {
    std::string name;
    double error = 0.0;
    std::function<void(Model&, double)> add;  ///< adds to it
};

/// Every value in the model's table that has an error.
std::vector<Uncertain> table_errors(const Model& model);

struct BoundaryPoint {
    double x = 0.0, y = 0.0;
    /// Standard error of where the line runs: it lies at (x, y) +- (error_x, error_y), which is along the gradient of
    /// the margin in the plane scaled to a square.  Not-a-number where the margin has no slope there (a cusp, a
    /// corner).
    double error_x = 0.0, error_y = 0.0;
    double angle = 0.0;  ///< of the wave that decides [rad]
};

struct BoundaryLine {
    Limit limit = Limit::onset;
    bool closed = false;  ///< an island; else it ends at the edge of the plane, or of where its state exists
    std::vector<BoundaryPoint> points;
};

struct Boundary {
    std::vector<BoundaryLine> lines;
    std::vector<numerics::PlanePoint> singular_points;  ///< cusps and double points that are not resolved further
    std::size_t evaluations = 0;
    bool complete = true;
};

struct Plane {
    Model model;
    PlaneAxis x, y;
};

/// The margin at points of a plane.  Throws an input Error that names the point where a model cannot be.
std::vector<Margin> margins(const Plane& plane, const std::vector<numerics::PlanePoint>& points, Limit limit,
                            Threads& threads);

/// Traces the lines of one limit: every island wider than a sampling cell is found, see numerics/contour.hpp.
Boundary trace_boundary(const Plane& plane, Limit limit, const std::vector<Uncertain>& uncertain,
                        const numerics::ContourOptions& options, Threads& threads);

}  // namespace drover::physics
