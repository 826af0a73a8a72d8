// dem/neighbours/nearest_image.hpp: displacements to the nearest periodic image.
#pragma once

#include "drover/dem/bodies.hpp"
#include "drover/dem/setup.hpp"

namespace drover::dem {

/// The shortest displacement between images, or the plain displacement in a cell that is not periodic.
class NearestImage {
public:
    explicit NearestImage(const Cell& cell) {
        if (!is_periodic(cell)) return;
        lx_ = cell.lx, ly_ = cell.ly, per_x_ = 1.0 / cell.lx, per_y_ = 1.0 / cell.ly;
    }
    double x(double dx) const { return dx - lx_ * __builtin_roundeven(dx * per_x_); }
    double y(double dy) const { return dy - ly_ * __builtin_roundeven(dy * per_y_); }
    Vector operator()(const Vector& from, const Vector& to) const {
        const Vector d = to - from;
        return {x(d.x), y(d.y), d.z};
    }

private:
    double lx_ = 0.0, ly_ = 0.0, per_x_ = 0.0, per_y_ = 0.0;  // sides [mm] and their inverses, 0 where not periodic
};

}  // namespace drover::dem
