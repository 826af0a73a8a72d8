// numerics/effort.cpp: measured constants of the work of steps (valgrind --tool=callgrind, 32 to 128 points squared).
#include "drover/numerics/effort.hpp"

#include <algorithm>

namespace drover::numerics {

double Effort::seconds_a_step() const {
    constexpr double per_second = 9e9;  // on one core, of the machine on which instructions were counted
    return work_a_step / per_second;
}

double Effort::allowed(double steps) const {
    // Every run is taken to be longer by the first, since errors change fastest at the start; a short run [s].
    constexpr double start = 0.1, shorter = 10.0;
    const double seconds = start + steps * seconds_a_step();
    return part * std::min(2.0 * seconds, std::max(shorter, seconds)) / seconds_a_step();
}

double Effort::credit() const {
    constexpr double seconds = 0.005;
    return seconds / seconds_a_step();
}

double weighed_points(const Grid& grid) {
    const auto weight = [](int length) {
        while (length % 2 == 0) length /= 2;
        return length == 1 ? 1.0 : length == 3 ? 1.06 : length == 5 ? 1.16 : 1.25;
    };
    constexpr double calls = 100.0;  // what a grid of few points costs, too
    return (static_cast<double>(points(grid)) + calls) * weight(grid.nx) * weight(grid.ny);
}

double work_of_right_hand_side(const Grid& grid, int components, int inverse, int forward) {
    constexpr double of_two_transforms = 22.0, of_component = 19.0;  // for each point
    const double pairs = (inverse + 1) / 2 + (forward + 1) / 2;
    return (of_two_transforms * pairs + of_component * components) * weighed_points(grid);
}

}  // namespace drover::numerics
