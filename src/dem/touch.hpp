// dem/touch.hpp: pairs of spheres, and spheres and side walls, that overlap at the end of a step, and the impulses they give each other.
#pragma once
#include <cstdint>
#include <vector>

#include "drover/base/threads.hpp"
#include "drover/dem/world.hpp"
#include "neighbours.hpp"
#include "spheres.hpp"
#include "walls.hpp"

namespace drover::dem {

/// An overlap.
struct Touch {
    std::uint32_t first = 0, second = no_sphere;  ///< spheres; second = no_sphere: a wall
    std::uint32_t first_body = 0, second_body = no_sphere;
    Vector apart;        ///< from second (or the wall) to first, along which they overlap [mm]
    double reach = 0.0;  ///< distance at which they touch [mm]
    double since = 0.0;  ///< time since they touched [s]
    Vector normal;       ///< towards first when they touched
    static constexpr std::uint32_t no_sphere = 0xffffffffu;
};

/// Of the two spheres, or of the one that touches a wall [mm].
double smaller_radius(const Touch& touch, const Spheres& spheres);

/// Coefficients by the kinds that meet.
struct TouchRules {
    Restitution restitution;
    Friction friction;
    ImpactLaw law;
    Vector acceleration, bead_force;  ///< for the books
    double dt = 0.0;
    double max_overlap = 0.0;
    double together = 0.0;  ///< a body this near to a plate stands on it [mm]
    Flight base;            ///< at the end of the step
    double lid = 0.0;       ///< height of the lid then [mm]; never: none
};

void add(const EnergyBalance& part, EnergyBalance& whole);
void add(const Counts& part, Counts& whole);

/// What one part of the work saw; parts are added in order.
struct TouchReport {
    EnergyBalance balance;
    Counts counts;
    Touch deepest;        ///< of this step
    double depth = -1.0;  ///< its overlap beside the smaller radius
};

/// Space that is used again from step to step.
class TouchSolver {
public:
    /// Finds all overlaps and resolves those groups in which something approaches; moves bodies back out as far as they came in too late.
    /// Returns what the step adds to the balance and the counts, with its deepest overlap.
    TouchReport step(const Walls& walls, Spheres& spheres, const Neighbours& neighbours, const TouchRules& rules,
                     Threads& threads);

private:
    void find(const Walls& walls, const Spheres& spheres, const Neighbours& neighbours, Threads& threads);
    void group(std::size_t bodies);

    std::vector<Touch> touches_;
    std::vector<std::vector<Touch>> found_;  // by chunk
    std::vector<std::uint32_t> last_;        // of each body: its newest touch of this step, else nothing
    std::vector<std::uint32_t> parent_, size_, order_, start_;
    std::vector<TouchReport> reports_;
};

}  // namespace drover::dem
