// numerics/fields/field.cpp: whether arrays are those of a grid.
#include "drover/numerics/field.hpp"

#include "drover/base/error.hpp"

namespace drover::numerics {

void check(const Fields& fields, const Grid& grid, int components) {
    const std::size_t each = points(grid), all = each * static_cast<std::size_t>(components);
    require(fields.size == each && fields.values.size() == all, {},
            "{} values of fields, {} of each; expected {} and {}, those of {} components on a grid of {} by {}",
            fields.values.size(), fields.size, all, each, components, grid.nx, grid.ny);
}

void check(const Spectra& spectra, const Grid& grid, int components) {
    const std::size_t each = modes(grid), all = (each + Spectra::gap) * static_cast<std::size_t>(components);
    require(spectra.size == each && spectra.stride == each + Spectra::gap && spectra.values.size() == all, {},
            "{} numbers of spectra, {} of each; expected {} and {}, those of {} components on a grid of {} by {}",
            spectra.values.size(), spectra.size, all, each, components, grid.nx, grid.ny);
}

}  // namespace drover::numerics
