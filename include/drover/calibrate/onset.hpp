// calibrate/onset.hpp: the flocking threshold predicted by the coefficients of a table.
#pragma once
#include <array>
#include <string>
#include <vector>

#include "drover/calibrate/table.hpp"

namespace drover::calibrate {

/// The value used for lambda in  alpha/Gamma = (a - c sigma)/lambda.
enum class Convention {
    mean,       ///< lambda = lambda_s/2 of the equations: order begins at g = lambda_s alpha/(Gamma D_r) = 2
    single_rod  ///< lambda_s of one rod, as the assay measures it: g = 1, too low by a factor of two
};
inline constexpr int convention_count = 2;
/// "mean", "single-rod": the values of the key weathercock.convention.
const char* convention_name(Convention convention);

/// The point at which alpha/Gamma overtakes (a - c sigma)/lambda as the area fraction of beads grows.
struct Crossing {
    double bead_fraction = 0.0;  ///< NaN if there is no crossing in the table
    double error = 0.0;          ///< standard deviation over tables redrawn within their errors; NaN if there is none
    /// 16, 50 and 84 % of redrawn tables cross at or below these area fractions; infinite beyond the table, where the
    /// tables that do not cross are counted.
    std::array<double, 3> quantiles{};
    double share = 0.0;      ///< fraction of redrawn tables that have a crossing
    bool above_all = false;  ///< alpha/Gamma exceeds the threshold at the first node; a crossing then follows a dip
};

/// The curves at one area fraction of rods.
struct OnsetCurve {
    double rod_fraction = 0.0;
    std::vector<Uncertain> drag;                ///< alpha/Gamma [mm/s], [bead]
    std::vector<Uncertain> threshold;           ///< (a - c sigma)/lambda [mm/s], [bead], lambda of Convention::mean
    std::vector<double> alignment;              ///< g, [bead]
    Crossing crossings[convention_count] = {};  ///< by convention
};

struct Onset {
    std::vector<double> bead_fractions;  ///< at which curves are given: the nodes and points between them
    std::vector<OnsetCurve> curves;      ///< at each area fraction of rods of the table
    std::vector<OnsetCurve> line;  ///< threshold in the plane of both area fractions: crossings without curves, also
                                   ///< between the area fractions of rods of the table
};

/// Onset from the rows drag, relaxation_rate, weathercock and, if present, contact_alignment and rod_area, interpolated
/// by SmoothCoefficient.  Errors of crossings
/// come from `redrawn` tables with normal errors, drawn by counter: the same table gives the same errors.
/// Crossings are the first from few beads to many; the curves show a later fall below the threshold.
/// `subdivisions`: of each interval between nodes.
/// Throws an input Error for a table without these rows or with missing entries in them.
Onset find_onset(const Table& table, std::size_t varied = 0, int subdivisions = 10, int redrawn = 400);

/// The measured crossing of Convention::mean, without its error.
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
