// jobs/sweep/sweep_table.hpp: the runs of a sweep and their results, as a table and as arrays.
#pragma once
#include <array>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "io/scene.hpp"
#include "jobs/campaign/run_record.hpp"
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

}  // namespace drover::jobs
