// numerics/steppers/effort.cpp: measured constants of work (valgrind --tool=callgrind, 32 to 128 points squared).
#include "numerics/steppers/effort.hpp"

#include <algorithm>

namespace drover::numerics {

namespace {
constexpr double a_second = 9e9;  // on one core of the machine on which instructions were counted
}

StepWork step_work(const Grid& grid, const WorkCounts& counts) {
    constexpr double of_two_transforms = 22.0, of_component = 19.0, of_noise = 39.0;  // for each point
    const double pairs = (counts.inverse + 1) / 2 + (counts.forward + 1) / 2;
    const double rate = of_two_transforms * pairs + of_component * counts.components;
    return {.rate = rate * weighed_points(grid),
            .rate_a_point = rate,
            .noise = of_noise * counts.noisy * weighed_points(grid)};
}

double work_of_observing(const Grid& grid, int components) {
    constexpr double of_value = 190.0, of_row = 1e6;
    return of_value * static_cast<double>(points(grid)) * components + of_row;
}

double weighed_points(const Grid& grid) {
    const auto weight = [](int length) {
        while (length % 2 == 0) length /= 2;
        return length == 1 ? 1.0 : length == 3 ? 1.06 : length == 5 ? 1.16 : 1.25;
    };
    constexpr double calls = 100.0;  // what a grid of few points costs, too
    return (static_cast<double>(points(grid)) + calls) * weight(grid.nx) * weight(grid.ny);
}

double Effort::allowed(double work) const {
    constexpr double start = 0.1 * a_second, shorter = 10.0 * a_second;  // a start; a short run
    const double all = start + work;
    // Twice as much of the first third of a short run, so that its rest has some, too.
    return part * std::min(2.0 * all, std::max(0.5 * (shorter + all), all));
}

double owed_work() { return 0.005 * a_second; }

}  // namespace drover::numerics
