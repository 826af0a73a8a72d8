// jobs/sweep/sweep_plan.hpp: the runs of a sweep, those included that results so far ask for; their results as a table
// and as arrays.
#pragma once
#include <array>
#include <filesystem>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "io/scene.hpp"
#include "jobs/campaign/campaign_records.hpp"
#include "measure/replicates.hpp"

namespace drover::jobs {

/// One run of a sweep.
struct SweepRun {
    std::string name;                        ///< of its archive in the sweep's folder, without .h5
    std::size_t point = 0;                   ///< row of the table
    int seed = 0;                            ///< number of the seed at its point, from 0
    std::vector<std::string> overrides;      ///< of the scene
    std::optional<std::size_t> before = {};  ///< on a ramp: the run from whose last frame it starts
};

/// Of a ramp.
enum class Branch { none, up, down };
constexpr auto names_of(Branch) { return std::array{"", "up", "down"}; }

/// One row of the table.
struct SweepPoint {
    std::vector<double> values;  ///< of the varied keys
    Branch branch = Branch::none;
};

/// All runs of a sweep.
struct SweepLayout {
    std::vector<std::string> keys;
    std::vector<SweepPoint> points;
    std::vector<SweepRun> runs;
    int seeds = 1;              ///< the largest number of them at a point
    bool finds_warm_up = true;  ///< each run by itself
    bool is_adaptive = false;   ///< results may ask for more runs
};

/// Results of one row, over its seeds.
struct SweepRow {
    SweepPoint point;
    int seeds = 0;  ///< finished runs
    std::vector<measure::Replicates> results;
};

struct SweepTable {
    std::vector<std::string> keys;
    std::vector<std::string> names, units;  ///< of the results
    std::vector<SweepRow> rows;
    std::vector<std::string> warnings = {};  ///< other versions of drover; of the runs: "point-0000-seed-7: ..."
};

/// Of the runs that have ended, by name.
SweepTable sweep_table(const SweepLayout& layout, const std::map<std::string, RunResults>& results);

/// With a header line; means, errors and own errors in separate columns, empty where they are not available.
std::string table_csv(const SweepTable& table);

/// Writes the file, which netCDF-4 libraries open: over the varied keys, the branch of a ramp and its own axes, each
/// result as <name> with <name>_error, the mean over the seeds, and with several seeds <name>_of_runs and its error,
/// which have the axis seed too.  NaN: not there.  Where runs differ in an axis of a result, as in the wavenumbers of
/// different cells, that axis counts from 0, and <axis>_values has its values at each point.  Where two points have the
/// same values, as on a ramp that comes back, the axis of all is `point`, and the keys are results.  `table`: of the
/// same results, of which it holds the single numbers.
void write_sweep_dataset(const std::filesystem::path& file, const io::Scene& scene, const SweepLayout& layout,
                         const std::map<std::string, RunResults>& results, const SweepTable& table);

// ---- The plan

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

/// For each point of a sweep that has ended, the errors that were wanted and the runs do not give.
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
