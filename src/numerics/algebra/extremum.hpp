// numerics/algebra/extremum.hpp: searches for maxima of functions, and fits of lines.
#pragma once
#include <algorithm>
#include <cmath>
#include <functional>
#include <span>
#include <utility>
#include <vector>

#include "base/constants.hpp"

namespace drover::numerics {

/// The logarithms of `count` values from `min` to `max`, evenly spaced.
std::vector<double> even_logarithms(double min, double max, int count);

/// The largest value of a function between two places, by golden sections.
template <class Function>
double golden_maximum(double low, double high, Function function) {
    constexpr double part = 0.38196601125010515;
    double left = low + part * (high - low), right = high - part * (high - low);
    double at_left = function(left), at_right = function(right);
    while (high - low > 1e-9 * (1.0 + std::abs(low))) {
        if (at_left > at_right) {
            high = right, right = left, at_right = at_left;
            at_left = function(left = low + part * (high - low));
        } else {
            low = left, left = right, at_left = at_right;
            at_right = function(right = high - part * (high - low));
        }
    }
    return 0.5 * (low + high);
}

/// Climbs from a place to the nearest maximum of a function, in growing steps of which this is the first.
template <class Function>
double climbed_along(double from, double step, Function function) {
    double highest = function(from), behind = from, ahead = from;
    for (const double side : {-1.0, 1.0}) {
        std::swap(behind, ahead);
        for (double length = step;; length *= 2.0) {
            ahead = from + side * length;
            const double next = function(ahead);
            if (!(next > highest)) break;
            highest = next, behind = from, from = ahead;
        }
    }
    const double fine = golden_maximum(behind, ahead, function);
    return function(fine) > highest ? fine : from;
}

/// The largest of the values of a function at some places.
struct Largest {
    double value = -infinite, place = 0.0;
};
template <class Function>
Largest largest_of(const std::vector<double>& places, Function function) {
    Largest largest{.place = places.front()};
    for (const double place : places)
        if (const double value = function(place); value > largest.value) largest = {value, place};
    return largest;
}

/// The maximum about a place, no further away than the next of these evenly spaced places.
template <class Function>
double refined_maximum(const std::vector<double>& places, double from, Function function) {
    const double step = places[1] - places[0];
    const double fine =
        golden_maximum(std::max(from - step, places.front()), std::min(from + step, places.back()), function);
    return function(fine) > function(from) ? fine : from;
}

/// Climbs from a place to the nearest maximum of a function of two variables, by the simplex of Nelder and Mead with
/// these first steps.  Ends where nothing more is gained, and soon after the first variable has left `range`.
std::pair<double, double> climbed(const std::function<double(double, double)>& function, std::pair<double, double> from,
                                  std::pair<double, double> steps, std::pair<double, double> range);

/// y = at_zero + slope x.
struct Line {
    double at_zero = 0.0, slope = 0.0;
};

/// The line that minimises sum weights (y - at_zero - slope x)^2; points with weight 0 are ignored.  NaN where the
/// line is not unique.  x, y and weights have the same length.
Line fit_line(std::span<const double> x, std::span<const double> y, std::span<const double> weights);
/// As fit_line, with the weights 1/x^2: y scatters in proportion to x, as displacements in a time do.
Line fit_line_of_times(std::span<const double> x, std::span<const double> y);

/// Coefficients of these columns in the least-squares fit to y; NaN if the columns are linearly dependent.
std::vector<double> least_squares(const std::vector<std::vector<double>>& columns, const std::vector<double>& y);

}  // namespace drover::numerics
