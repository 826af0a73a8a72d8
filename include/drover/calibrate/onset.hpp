// calibrate/onset.hpp: where the coefficients of a table say that flocks begin.
#pragma once
#include <string>
#include <vector>

#include "drover/calibrate/table.hpp"

namespace drover::calibrate {

/// What is taken for lambda in  alpha/Gamma = a/lambda.
enum class Convention {
    mean,       ///< lambda = lambda_s/2 of the equations: order begins at g = lambda_s alpha/(Gamma D_r) = 2
    single_rod  ///< lambda_s of one rod, as an assay of one rod measures it: g = 1, too low by a factor of two
};
inline constexpr int convention_count = 2;
/// "mean", "single-rod": the words of weathercock.convention.
const char* convention_name(Convention convention);

/// Where alpha/Gamma overtakes a/lambda as the area fraction of beads grows.
struct Crossing {
    double bead_fraction = 0.0;  ///< not-a-number: no_location in the table
    double error = 0.0;  ///< standard deviation of it in tables redrawn within their errors; not-a-number without
    double share = 0.0;  ///< of redrawn tables that cross at all
    bool above_all =
        false;  ///< alpha/Gamma is the larger one at the first node already; a crossing is then one after a dip
};

/// The curves of one area fraction of rods.
struct OnsetCurve {
    double rod_fraction = 0.0;
    std::vector<Uncertain> drag;                ///< alpha/Gamma [mm/s], [bead]
    std::vector<Uncertain> threshold;           ///< a/lambda [mm/s], [bead], lambda as Convention::mean has it
    Crossing crossings[convention_count] = {};  ///< by convention
};

struct Onset {
    std::vector<double> bead_fractions;  ///< at which curves are given: the nodes and places between them
    std::vector<OnsetCurve> curves;      ///< of each area fraction of rods of the table
    std::vector<OnsetCurve>
        line;  ///< of as many and ones between them, without the curves: the line in the plane of both fractions
};

/// From the rows drag, relaxation_rate and weathercock.  Between nodes as SmoothCoefficient has them.  Errors of crossings from `redrawn`
/// tables of normal numbers, drawn by counter: the same table gives the same errors.  The first crossing from few beads to many is taken; a
/// table that falls back below the threshold is told by the curves.  Throws an input Error for a table without these rows or with holes in them.
/// `parts`: of each interval between nodes.
Onset find_onset(const Table& table, std::size_t varied = 0, int parts = 10, int redrawn = 400);

}  // namespace drover::calibrate
