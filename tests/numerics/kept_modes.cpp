// tests/numerics/kept_modes.cpp: nothing but zeros is left out of a state.
#include "numerics/steppers/kept_modes.hpp"

#include <gtest/gtest.h>

namespace drover::numerics::kept_modes_tests {
namespace {

TEST(KeptModes, are_those_that_are_kept_and_give_the_state_back) {
    for (const Grid& grid :
         {Grid{.nx = 12, .ny = 8, .lx = 1.0, .ly = 2.0}, Grid{.nx = 16, .ny = 1, .lx = 1.0, .ly = 1.0},
          Grid{.nx = 4, .ny = 24, .lx = 1.0, .ly = 1.0}})
        for (const int degree : {1, 2, 3}) {
            const System system{.grid = grid, .layout = scalars_and_vectors(1, 1), .degree = degree};
            Spectra state(grid, 3);
            const std::size_t width = columns(grid);
            std::size_t kept = 0;
            for (int c = 0; c < 3; ++c)
                for (std::size_t m = 0; m < state.size; ++m)
                    if (is_kept(grid, degree, m % width, m / width))
                        state[c][m] = {static_cast<double>(++kept), static_cast<double>(c)};
            KeptModes modes{7.0};  // of an earlier state
            store_kept(system, state, modes);
            EXPECT_EQ(modes.size(), kept) << grid.nx << " by " << grid.ny << ", degree " << degree;
            EXPECT_EQ(with_kept(system, modes).values, state.values);
        }
}

}  // namespace
}  // namespace drover::numerics::kept_modes_tests
