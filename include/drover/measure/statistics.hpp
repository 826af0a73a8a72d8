// measure/statistics.hpp: means of correlated series with standard errors, given only where the series is long enough.
#pragma once
#include <algorithm>
#include <cstddef>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "drover/base/axis.hpp"

namespace drover::measure {

/// How the samples of a run become one number.
enum class Averaging {
    mean,
    rate,       ///< the mean rate of what is counted since the start of the run
    direction,  ///< of an angle [rad] of which 2 pi is none, followed beyond pi
    maximum     ///< the last of the largest values since the start: one run gives it no error
};

/// A mean over time with its standard error.
struct Estimate {
    double mean = 0.0;
    std::optional<double> error = {};   ///< standard error of the mean, from blocks; absent when not available
    double autocorrelation_time = 0.0;  ///< integrated, tau = dt (1/2 + sum rho_k), in the unit of the spacing
    double warm_up = 0.0;               ///< time left out at the start
    std::size_t samples = 0;            ///< samples used
    std::size_t blocks = 0;         ///< used for the error: (mean - truth)/error is Student's t with blocks - 1 degrees
    std::string why_no_error = {};  ///< why there is no error, with the run length needed; else ""
    Averaging averaging = Averaging::mean;
};

using drover::Axis;

/// Values per sample: the product of the lengths of the axes; 1 without axes.
inline std::size_t size_of(std::span<const Axis> axes) {
    std::size_t size = 1;
    for (const Axis& axis : axes) size *= axis.values.size();
    return size;
}

inline std::vector<std::string> names_of(std::span<const Axis> axes) {
    std::vector<std::string> names;
    for (const Axis& axis : axes) names.push_back(axis.name);
    return names;
}

/// The quantity to which the rounding error of a number is proportional.  Tables print 0 for numbers within their
/// rounding error.
enum class Nature {
    number,       ///< the largest number of its field, or of its unit if that is not 1
    energy,       ///< the largest number of its unit: energies and powers
    square,       ///< the square of its field
    square_area,  ///< the same times the area of the cell: structure factors, and products of two fields
    ratio         ///< itself
};

/// One result: a single number, or an array over the axes.
struct SummaryRow {
    std::string name;
    std::string unit;  ///< UDUNITS text
    std::string formula;
    std::vector<Axis> axes;           ///< slowest first; none: a single number
    std::vector<Estimate> estimates;  ///< size_of(axes)
    Nature nature = Nature::number;
};

/// The row of that name; nullptr when there is none.
template <class Row>
const Row* find_row(const std::vector<Row>& rows, const std::string& name) {
    const auto found = std::ranges::find_if(rows, [&](const Row& row) { return row.name == name; });
    return found == rows.end() ? nullptr : &*found;
}

/// Samples of one run at equal times.  All series of one analysis have the same length.
struct Samples {
    std::vector<std::vector<double>> series = {};
    double spacing = 1.0;         ///< time between samples [s]
    std::size_t skip = 0;         ///< samples of warm-up left out of every analysis
    std::string time_unit = "s";  ///< what messages call the unit of the spacing; "1": numbers without a unit
};

/// A time for messages, "20 s", rounded to three digits, upwards on request.
std::string time_text(double time, const std::string& unit, bool up = false);

/// Errors of correlations along trajectories come from groups of values that are taken as independent: bodies when
/// there are min_groups or more of them, else segments of time of each body, at least min_groups in all.  In a flock
/// rods are not independent: such errors are too small there; use runs with different seeds.  Each estimate is the
/// jackknife over groups; `blocks` is their number: (mean - truth)/error is Student's t with blocks - 1 degrees of
/// freedom.  With fewer than two groups there is no error, and `why_no_error` gives the reason.
inline constexpr std::size_t min_groups = 16;

inline constexpr double autocorrelation_times_per_block = 10.0;
inline constexpr std::size_t min_blocks = 8;
inline constexpr std::size_t max_blocks = 64;

/// A series whose spread is below this fraction of its largest value is constant: a conserved total, up to rounding.
inline constexpr double rounding_spread = 1e-12;

/// How long a series is correlated, in samples; at least 1/2.
struct CorrelationTimes {
    double integrated = 0.5;  ///< 1/2 + sum rho_k: the variance of a mean of n samples is 2 integrated/n times theirs
    double coherence = 0.5;   ///< 1/2 + 2 sum rho_k^2: the time in which a wave loses its phase, whatever its period
};

/// The sums up to the self-consistent window of 5 times the longer of both times; the integrated one also up to 5 times
/// itself, of which the larger counts, and corrected for the bias from subtracting the sample mean.  Its relative
/// variance is 2 (2 W + 1)/n, W the window.  O(n log n).  1/2 for a constant series and for fewer than two values; NaN
/// if a value is not finite.  Where correlations decay without oscillating, the coherence time is the shorter one.
/// Source: Sokal, "Monte Carlo methods in statistical mechanics" (1996), sec. 3; variance: Madras & Sokal, J. Stat.
/// Phys. 50, 109 (1988), for W far beyond tau; sample mean: Wolff, Comput. Phys. Commun. 156, 143 (2004).
CorrelationTimes correlation_times(std::span<const double> values);
inline double autocorrelation_time(std::span<const double> values) { return correlation_times(values).integrated; }

/// Where the warm-up of a series ends, in samples, at most half of the series: the first cut such that what lies
/// between it and the cut that minimises the error of the rest (MSER-5, White, Simulation 69, 323 (1997)) has the mean
/// of the rest within four standard errors and its mean square within six.  The cut of MSER-5 itself would bias means
/// of skewed values.  A cut at half of the series means that the warm-up may not have ended.  0 for a constant series,
/// for one shorter than four batches of five, and if a value is not finite.
std::size_t warm_up_length(std::span<const double> values);

/// Mean of one series of the samples.  A constant series has the error 0.  Blocks are 10 integrated times long, and 10
/// coherence times where 8 of these fit: the ends of shorter ones cut waves, which makes errors too large.
Estimate estimate_mean(const Samples& samples, std::size_t series);

/// A mean over a series from sample `skip` on.  The error is always given: that of a series too short for an estimate
/// follows from its autocorrelation time, which it finds too short, with one independent value in four at most.
struct RoughMean {
    double value = 0.0, error = 0.0;
    double least_error = 0.0;  ///< as if one value in four were independent: a drift looks like a correlation
};
RoughMean rough_mean(std::span<const double> values, std::size_t skip);
/// Of a - b, sample by sample: two runs on one noise path differ by less than each fluctuates.  Throws an input Error
/// for series of different lengths.
RoughMean paired_difference(std::span<const double> a, std::span<const double> b, std::size_t skip);

/// A smooth function of the means of all series (a susceptibility, a Binder cumulant, an exponent), bias and error by
/// the jackknife over blocks; the blocks are long enough for the slowest series.  Samples that fill no block are left
/// out at the start.  The variance is corrected for correlations across the ends of blocks, assumed exponential: by at
/// most a tenth.  Throws an input Error when the series have different lengths or the spacing is not
/// positive.
Estimate estimate_function(const Samples& samples,
                           const std::function<double(std::span<const double> means)>& function);

/// Susceptibility  area (<P^2> - <P>^2)  of an order parameter, one series of the samples.
Estimate estimate_susceptibility(const Samples& samples, std::size_t series, double area);

/// Binder cumulant  1 - <P^4>/(3 <P^2>^2)  of an order parameter: 2/3 in order, 1/3 for a two-component Gaussian.
Estimate estimate_binder_cumulant(const Samples& samples, std::size_t series);

/// Square root of the mean of a series of variances.
Estimate estimate_deviation(const Samples& samples, std::size_t series);

/// Local exponent  d ln DN / d ln N  between two boxes, from the series of their variances DN^2 and N_large/N_small.
/// Throws an input Error for a ratio that is not above 0, finite and other than 1.
Estimate estimate_local_exponent(const Samples& samples, std::size_t small, std::size_t large, double ratio);

}  // namespace drover::measure
