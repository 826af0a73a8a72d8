// jobs/sweep/sweep_plan.hpp: the runs of a sweep, those included that results so far ask for.
#pragma once
#include <functional>
#include <map>
#include <string>
#include <vector>

#include "io/scene.hpp"
#include "jobs/campaign/run_record.hpp"
#include "jobs/sweep/sweep_table.hpp"

namespace drover::jobs {

/// What the rules by which a sweep asks for more runs read of one run, by the name of the observable.
using RunMarks = std::map<std::string, measure::Estimate>;
/// Of runs that have ended, by the name of the run.
using Marks = std::map<std::string, RunMarks>;

/// The points that the first sweep of a folder numbered, by their values: their runs are "point-0003-seed-7", with any
/// seed.  Those that later ones add are "relaxation.rate=0.5,seed=7".
struct NumberedPoints {
    std::vector<std::string> keys;
    std::map<std::vector<double>, std::size_t> points;
};
/// Empty for a ramp, all points of which have numbers.
NumberedPoints numbered_points(const io::Scene& first);

bool is_ramp(const io::Scene& scene);

/// With the points between those that differ, and the seeds that wanted errors need, as far as marks are known.
SweepLayout plan_sweep(const io::Scene& scene, const Marks& marks, const NumberedPoints& numbered);

/// Throws an input Error for an observable that the runs do not have.
RunMarks marks_of(const io::Scene& scene, const RunResults& results);

/// For each point of a sweep that has ended, what a rule asked for and the runs do not give.
std::vector<std::string> unmet_targets(const io::Scene& scene, const SweepLayout& layout, const SweepTable& table);

/// A value between two for each key, as fine as a refined sweep may have it; empty without refinement.
std::vector<std::string> finest_overrides(const io::Scene& scene);

/// Ascending values along each axis.
using Axes = std::vector<std::vector<double>>;

/// Whether something differs between two points; the same either way.
using Differs = std::function<bool(const std::vector<double>& a, const std::vector<double>& b)>;

/// The points of a grid, and of finer ones: a cell with two points that differ, within it or on its border, is halved
/// along each axis, `levels` times at most.  Sorted.  Points that are not known yet differ from none: as more become
/// known more points are wanted, and in the end always the same ones, whatever the order.
std::vector<std::vector<double>> refined_points(const Axes& axes, int levels, const Differs& differs);

}  // namespace drover::jobs
