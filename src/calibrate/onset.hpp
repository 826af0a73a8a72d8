// calibrate/onset.hpp: the flocking threshold predicted by the coefficients of a table.
#pragma once
#include <array>
#include <vector>

#include "calibrate/table.hpp"

namespace drover::calibrate {

/// The value used for lambda in  alpha/Gamma = (a - c sigma)/lambda.
enum class Convention {
    mean,       ///< lambda = lambda_s/2 of the equations: order begins at g = lambda_s alpha/(Gamma D_r) = 2
    single_rod  ///< lambda_s of one rod, as the assay measures it: too large by a factor of two
};
inline constexpr int convention_count = 2;
constexpr auto names_of(Convention) { return std::array{"mean", "single-rod"}; }  ///< of weathercock.convention

/// An area fraction of beads at which alpha/Gamma and (a - c sigma)/lambda are equal.
struct Crossing {
    double bead_fraction = 0.0;
    bool begins = true;  ///< flocks are predicted above it, otherwise below
    /// The interval around it in which 16 to 84 % of the draws predict flocks: its error.  NaN: beyond the table.
    double low = 0.0, high = 0.0;
    bool is_alone = true;  ///< no other crossing is in that interval; otherwise they may as well not be there
};

/// All crossings at one area fraction of rods, from few beads to many.
struct Crossings {
    std::vector<Crossing> all;
    bool above_all = false;  ///< flocks are predicted at the smallest area fraction of beads
    /// Fractions of the draws that have a crossing, that have as many as the table, and that have more.
    double any = 0.0, as_many = 0.0, more = 0.0;
    /// At each area fraction of beads: lambda alpha/Gamma + c sigma - a [1/s], which is positive where flocks are
    /// predicted; the fraction of draws in which it is; and the excess over its error, -1 to 1 in the error band.
    std::vector<double> excess, share, deviation;
};

/// The curves at one area fraction of rods.
struct OnsetCurve {
    double rod_fraction = 0.0;
    std::vector<Uncertain> drag;                 ///< alpha/Gamma [mm/s], [bead]
    std::vector<Uncertain> threshold;            ///< (a - c sigma)/lambda [mm/s], [bead], lambda of Convention::mean
    std::vector<double> alignment;               ///< g, [bead]
    Crossings crossings[convention_count] = {};  ///< by convention
};

struct Onset {
    int draws = 0;
    std::vector<double> bead_fractions;  ///< at which curves are given: the nodes and points between them
    std::vector<OnsetCurve> curves;      ///< at each area fraction of rods of the table
    std::vector<OnsetCurve> plane;       ///< crossings without curves, also between the area fractions of rods
};

/// Onset from the rows drag, relaxation_rate, weathercock and, if present, contact_alignment and rod_area, interpolated
/// by SmoothCoefficient.  All errors are half of the distance from 16 to 84 % over `draws` tables redrawn within their
/// errors, drawn by counter: the same table gives the same errors.  `subdivisions`: of each interval between nodes.
/// Throws an input Error for a table without these rows or with missing entries in them.
Onset find_onset(const Table& table, std::size_t varied = 0, int subdivisions = 10, int draws = error_draws);

/// The first crossing from few beads to many at which flocks begin, of Convention::mean, without its error.
struct OnsetPlace {
    double bead_fraction = 0.0;  ///< NaN if there is none
    /// lambda alpha/Gamma + c sigma - a [1/s] that decides whether there is one: at the smallest area fraction of beads
    /// where flocks are predicted there already, else the largest at those of the table.
    double excess = 0.0;
    bool above_all = false;  ///< flocks are predicted at the smallest area fraction of beads
    double slope = 0.0;  ///< of the excess by the area fraction of beads at the crossing [1/s]; NaN if there is none
};
/// At each of these area fractions of rods; throws as find_onset().
std::vector<OnsetPlace> find_crossings(const Table& table, std::size_t varied, const std::vector<double>& rod_fractions,
                                       int subdivisions = 10);

}  // namespace drover::calibrate
