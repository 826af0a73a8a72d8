// run/calibration.hpp: assays over area fractions, trial by trial on workers, resumable at any moment, into one table.
#pragma once
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "drover/calibrate/table.hpp"
#include "drover/calibrate/trial_set.hpp"
#include "drover/io/archive.hpp"
#include "drover/io/scene.hpp"

namespace drover::run {

/// One assay at one point: what has an error and a number of trials of its own.
struct CalibrationUnit {
    std::string name;  ///< of its file in the folder, without .trials: "drag-bead-0.3-rod-0.05"
    std::size_t assay = 0;
    std::size_t varied = 0, bead = 0,
                rod = 0;               ///< indices into the axes of the table; rod 0 where it does not depend on rods
    calibrate::Conditions conditions;  ///< its seed is fixed by run.seed and the place, not by the order
    std::uint64_t identity = 0;        ///< of all that its trials depend on
};

/// What a calibration will do.
struct CalibrationLayout {
    std::vector<calibrate::Assay> assays;
    calibrate::Goal goal;
    calibrate::Table axes;  ///< without rows
    std::vector<CalibrationUnit> units;
    std::string manifest;  ///< the keys that all trials depend on, as scene text, without the plans of the assays
};

/// Throws an input Error, at its place, for a scene without [calibrate] lists, without a periodic cell, or with a value that the scene refuses.
CalibrationLayout plan_calibration(const io::Scene& scene);

struct CalibrationOptions {
    std::filesystem::path folder;
    int share = 1, shares = 1;  ///< works on the units share - 1, share - 1 + shares, ... of the layout; 1 of 1: all
    bool collect = false;       ///< runs nothing: the table of what is there
    bool quiet = false;
};

struct CalibrationOutcome {
    std::size_t units = 0;       ///< of this share
    std::size_t trials = 0;      ///< run now
    std::size_t already = 0;     ///< trials found done
    std::size_t refused = 0;     ///< units without a result: too many of their trials failed, or no number came of them
    std::size_t unfinished = 0;  ///< units that want more trials
    std::size_t shortfalls = 0;  ///< units that ended with a larger error than asked
    bool stopped = false;
    std::optional<calibrate::Table> table;  ///< none of a share
    std::filesystem::path file;             ///< of the table; "" of a share
};

/// Runs what is not done yet in `folder`, which keeps a file of trials for each unit: given again after a stop, also one by kill -9, it goes on and
/// loses no trial that had ended.  Then writes table.h5 and table.toml there, whose bytes are a function of the scene and the trials alone.  The folder takes
/// other goals and more points of the same scene.  Throws an input Error if it holds another scene's trials, or another process is at work on them.
CalibrationOutcome run_calibration(const io::Scene& scene, const CalibrationOptions& options);

/// The table of what has been found so far, with the derived rows.
calibrate::Table table_of(const CalibrationLayout& layout, const std::vector<calibrate::TrialSet>& campaigns);

/// For people: a line a point, then remarks.
std::string calibration_text(const calibrate::Table& table);
/// The whole table, for people and programs.
std::string calibration_toml(const calibrate::Table& table, const std::string& heading);

}  // namespace drover::run
