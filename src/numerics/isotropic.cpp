// numerics/isotropic.cpp: the error for layouts without a block.
#include "isotropic.hpp"

#include "drover/base/error.hpp"

namespace drover::numerics {

void refuse_layout(const Layout& layout) {
    fail_input({}, "a layout of {} scalars and {} vectors; expected at most 2 of each and at least one field",
               layout.scalars, layout.vectors);
}

void append_entries(const IsotropicBlocks& blocks, std::vector<double>& to) {
    for (const Block* block : {&blocks.along, &blocks.across})
        to.insert(to.end(), block->values.begin(), block->values.begin() + block->size * block->size);
}

}  // namespace drover::numerics
