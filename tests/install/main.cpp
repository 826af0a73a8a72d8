// tests/install/main.cpp: uses the installed library: a function, an error, the version.
#include <cmath>
#include <iostream>
#include <numbers>

#include "drover/base/error.hpp"
#include "drover/base/version.hpp"
#include "drover/numerics/grid.hpp"

int main() {
    using namespace drover::numerics;
    const Grid grid{.nx = 8, .ny = 6, .lx = 2.0, .ly = 3.0};
    const Wavevector q = wavevector(grid, 1, 5);
    const double error = std::abs(q.x - std::numbers::pi) + std::abs(q.y + 2.0 * std::numbers::pi / 3.0);
    if (!(error < 1e-15 * 8)) {  // a few roundings of numbers near 3
        std::cerr << "consumer: wavevector (1, -1) of a box of 2 mm by 3 mm is off by " << error << "\n";
        return 1;
    }
    try {
        check(Grid{.nx = 7});
        std::cerr << "consumer: a grid of 7 points was accepted; expected an Error\n";
        return 1;
    } catch (const drover::Error&) {
    }
    std::cout << "drover " << drover::version().version << " " << drover::version().git_hash << "\n";
}
