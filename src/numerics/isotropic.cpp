// numerics/isotropic.cpp: layouts that no block can hold.
#include "isotropic.hpp"

#include "drover/base/error.hpp"

namespace drover::numerics {

void refuse_layout(const Layout& layout) {
    fail_input({}, "a layout of {} scalars and {} vectors; expected at most 2 of each and at least one field",
               layout.scalars, layout.vectors);
}

}  // namespace drover::numerics
