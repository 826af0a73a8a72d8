// run/fields/start_file.hpp: a frame of an archive as the start of a run.
#pragma once
#include <string>
#include <vector>

#include "drover/numerics/field.hpp"
#include "io/scene.hpp"

namespace drover::run {

/// A dataset of frames.
struct FrameField {
    std::string name, unit;
};

/// Coordinates of the points of a field along an axis [mm].
std::vector<double> cell_corners(int count, double side);

/// The frame initial.frame of the archive initial.file.  On other points in the same cell it is taken by the modes that
/// both grids have, and this is logged.  degree: that decides which modes the run keeps.  Throws an input Error at
/// these keys unless it has these fields in these units, in the cell of the scene, with finite values.
numerics::Fields frame_of_file(const io::Scene& scene, const std::vector<FrameField>& fields, int degree);

}  // namespace drover::run
