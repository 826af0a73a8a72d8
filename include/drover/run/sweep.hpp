// run/sweep.hpp: many runs of one scene, over a grid of parameters, seeds or a ramp, and their table.
#pragma once
#include <filesystem>
#include <string>
#include <vector>

#include "drover/io/scene.hpp"
#include "drover/measure/statistics.hpp"

namespace drover::run {

/// One run of a sweep.
struct SweepRun {
    std::string name;                    ///< of its archive in the sweep's folder, without .h5
    std::size_t point = 0;               ///< row of the table
    std::vector<std::string> overrides;  ///< of the scene
};

/// One row of the table.
struct SweepPoint {
    std::vector<double> values;  ///< of the varied keys
    std::string branch;          ///< "up" or "down" on a ramp, else ""
};

/// All runs of a sweep.  Runs of one chain are sequential; chains are independent.
struct SweepLayout {
    std::vector<std::string> keys;
    std::vector<SweepPoint> points;
    std::vector<std::vector<SweepRun>> chains;
};

/// Throws an input Error, at the place of sweep.vary, for a text that is not "key = a, b, c" or "key = a:b:n", a ramp
/// of more than one key, or a value that the scene does not allow.
SweepLayout plan_sweep(const io::Scene& scene);

/// Results of one row: the mean over its seeds.
struct SweepRow {
    SweepPoint point;
    int seeds = 0;  ///< finished runs
    std::vector<measure::Estimate> estimates;
};

struct SweepTable {
    std::vector<std::string> keys;
    std::vector<std::string> names, units;  ///< of the estimates
    std::vector<SweepRow> rows;
    std::vector<std::string> warnings = {};  ///< other versions of drover; of the runs: "point-0000-seed-7: ..."
};

struct SweepOutcome {
    SweepTable table;
    std::size_t runs = 0, already_done = 0, failed = 0;
    bool stopped = false;
    std::vector<std::string> failures = {};  ///< why: "point-0000-seed-7: ..."
};

/// Runs what is not finished in `folder`, which keeps one archive per run and the scene of the sweep: call it again to
/// resume.  Writes table.csv there.  Throws an input Error if the folder holds another sweep.
SweepOutcome run_sweep(const io::Scene& scene, const std::filesystem::path& folder, bool quiet);

/// For people.
std::string table_text(const SweepTable& table);
/// With a header line; means and errors in separate columns, the error empty where it is not available.
std::string table_csv(const SweepTable& table);

}  // namespace drover::run
