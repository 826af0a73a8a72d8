// measure/field_setting.hpp: the grid, modes, boxes and bins that the observables of fields share.
#pragma once
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "drover/numerics/grid.hpp"
#include "drover/numerics/shells.hpp"
#include "drover/physics/form.hpp"

namespace drover::measure {

/// What the observables of a run need, prepared once.
struct FieldSetting {
    numerics::Grid grid;
    physics::Form form;
    numerics::Shells shells;
    numerics::Sectors sectors;
    std::vector<int> boxes;                         ///< box sides, in cells: a box has as many cells along x as along y
    std::vector<int> long_boxes;                    ///< shorter sides of the boxes with the aspect ratio 4, in cells
    int degree = 1;                                 ///< of the products: sets which modes are kept
    std::vector<double> separations;                ///< mean distance in each bin of the pair correlation [mm]
    std::vector<int> separation_bin;                ///< of each grid point as a displacement, -1 for none
    std::optional<std::vector<std::string>> terms;  ///< whose powers are measured; nullopt: no energy budget
    bool watches_error = true;                      ///< the run estimates the error of its time steps
};
FieldSetting make_field_setting(const numerics::Grid& grid, const physics::Form& form, int degree,
                                std::optional<std::vector<std::string>> power_terms = {});

/// Boxes of one shape, by size.  The names of their observables end in `ending`.
struct BoxFamily {
    const char* ending;
    const char* shape;                      ///< for people
    std::vector<int> FieldSetting::*sides;  ///< the shorter side, in cells
    int along_x, along_y;                   ///< sides in units of the shorter one
};
/// Squares, and boxes with the aspect ratio 4 along x and along y, which resolve the directions of a flock.
std::span<const BoxFamily> box_families();

}  // namespace drover::measure
