// run/calibration.hpp: assays over area fractions: trials on workers, resumable at any time, into one table.
#pragma once
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "drover/calibrate/table.hpp"
#include "drover/calibrate/trial_set.hpp"
#include "drover/files/archive.hpp"
#include "drover/io/scene.hpp"

namespace drover::run {

/// One assay at one point, with its own trials and errors.
struct CalibrationUnit {
    std::string name;  ///< of its trial file, without .trials: "drag-bead-0.3-rod-0.05"
    std::size_t assay = 0;
    std::size_t varied = 0, bead = 0,
                rod = 0;               ///< indices into the axes of the table; rod is 0 if it does not depend on rods
    calibrate::Conditions conditions;  ///< the seed follows from run.seed and the point, not from the order
    std::uint64_t identity = 0;        ///< fingerprint of everything that its trials depend on
};

/// The plan of a calibration.
struct CalibrationLayout {
    std::vector<calibrate::Assay> assays;
    calibrate::Goal goal;
    calibrate::Table axes;  ///< without rows
    std::vector<CalibrationUnit> units;
    std::string manifest;  ///< the keys that all trials depend on, as scene text, without the plans of the assays
};

/// Throws an input Error, with its location, for a scene without [calibrate] lists, without a periodic cell, or with an
/// invalid value.
CalibrationLayout plan_calibration(const io::Scene& scene);

struct CalibrationOptions {
    std::filesystem::path folder;
    int share = 1, shares = 1;  ///< runs the units share - 1, share - 1 + shares, ... of the layout; 1 of 1: all
    bool collect = false;       ///< runs nothing; writes the table of the trials present
    bool quiet = false;
};

struct CalibrationOutcome {
    std::size_t units = 0;          ///< of this share
    std::size_t trials = 0;         ///< run in this call
    std::size_t already = 0;        ///< trials that were present
    std::size_t failed = 0;         ///< units without a result: too many failed trials, or no finite estimate
    std::size_t unfinished = 0;     ///< units that need more trials
    std::size_t unmet_targets = 0;  ///< units that ended with a larger error than requested
    bool stopped = false;
    std::optional<calibrate::Table> table;  ///< not for a share
    std::filesystem::path file;             ///< of the table; "" for a share
};

/// Runs the missing trials in `folder`, which has a trial file for each unit.  Call it again to resume after a stop,
/// also after kill -9: completed trials are never lost.  Then writes table.h5 and table.toml there, whose bytes depend
/// on the scene and the trials alone.  The same folder accepts other goals, more points and more assays of the same
/// scene.  Throws an input Error if it holds the trials of another scene, or if another process is using it.
CalibrationOutcome run_calibration(const io::Scene& scene, const CalibrationOptions& options);

/// The table of the results so far, with the derived rows.
calibrate::Table table_of(const CalibrationLayout& layout, const std::vector<calibrate::TrialSet>& trial_sets);

/// Human-readable: one line per point, then remarks.
std::string calibration_text(const calibrate::Table& table);
/// The complete table as TOML.
std::string calibration_toml(const calibrate::Table& table, const std::string& heading);

}  // namespace drover::run
