// base/draws.hpp: draws of uncertain numbers, and quantiles of what follows from them.
#pragma once
#include <cstdint>
#include <span>
#include <string>
#include <vector>

namespace drover {

/// Part of a normal distribution that lies more than one standard deviation below its mean: 16 %.
inline constexpr double below_one_sigma = 0.15865525393145707;

/// The place of each number among all in ascending order; equal ones in the order given.
std::vector<double> ranks_of(std::span<const double> values);

/// The numbers from 0 to count - 1 in a random order that is a function of (number, part, count) only; those of
/// different numbers are independent.
std::vector<double> random_ranks(std::uint64_t number, std::uint64_t part, std::size_t count);

/// One standard normal number for each draw: the middles of equally probable parts in the order of these numbers, so
/// that the draws of one number have exactly its error (McKay, Beckman & Conover, Technometrics 21, 239 (1979)), and
/// those of two the rank correlation of their orders (Iman & Conover, Comm. Stat. B 11, 311 (1982)).
std::vector<double> normal_draws(std::span<const double> order);

/// The part or the number of a name, for draws of its own: FNV-1a.
std::uint64_t number_of_name(const std::string& name);

/// The value below which a part of all values lies, between the two nearest ones; `values` is sorted, may be infinite,
/// and is not empty.
double quantile(const std::vector<double>& values, double part);

/// Half of the distance between the quantiles at one standard deviation; NaN if no value is finite.  NaN are left out.
double half_width(std::vector<double> values);

/// How many standard deviations a number lies above 0: the normal number above which lies the part of the values that
/// is below 0; 1 where 16 % are, -1 where 84 % are.  Where all have one sign, by their middle and width, and no nearer
/// to 0 than so many values can tell: so it interpolates well between places where it jumps from far below 0 to far
/// above.  `values` is sorted and not empty.
double over_error(const std::vector<double>& values);

}  // namespace drover
