// jobs/calibration/calibration_layout.hpp: the measurements of a calibration, assays at points, and their results as a
// table.
#pragma once
#include <string>
#include <vector>

#include "calibrate/table.hpp"
#include "calibrate/trial_set.hpp"
#include "io/scene.hpp"
#include "jobs/campaign/accuracy_target.hpp"

namespace drover::jobs {

/// One assay at one point, with its own trials and errors.
struct CalibrationUnit {
    std::string name;  ///< "drag-bead-0.3-rod-0.05"
    std::size_t assay = 0;
    std::size_t varied = 0, bead = 0,
                rod = 0;               ///< indices into the axes of the table; rod is 0 if it does not depend on rods
    calibrate::Conditions conditions;  ///< the seed follows from run.seed and the point, not from the order
};

/// The plan of a calibration.
struct CalibrationLayout {
    std::vector<calibrate::Assay> assays;
    calibrate::Goal goal;
    calibrate::Table axes;  ///< without rows
    std::vector<CalibrationUnit> units;
    std::string manifest;  ///< the keys that all trials depend on, as scene text, without the plans of the assays
    std::vector<std::string> plans;  ///< of the assays, as scene text
    std::string defaults;            ///< of all keys, as scene text: of those that an older manifest or plan lacks
};

/// Throws an input Error, with its location, for a scene without [calibrate] lists, without a periodic cell, with
/// tilted plates, or with an invalid value.
CalibrationLayout plan_calibration(const io::Scene& scene);

/// Names of the assays that the wanted numbers need.  Throws an input Error for a target that the layout cannot answer.
std::vector<std::string> needed_assays(const CalibrationLayout& layout, const std::vector<AccuracyTarget>& targets);

/// The rows of the assays, with the results so far.
void add_measured_rows(const CalibrationLayout& layout, const std::vector<calibrate::TrialSet>& trial_sets,
                       calibrate::Table& table);
/// The rows that follow from the setups alone.
void add_setup_rows(const CalibrationLayout& layout, calibrate::Table& table);
/// The table of the results so far, with the derived rows.
calibrate::Table table_of(const CalibrationLayout& layout, const std::vector<calibrate::TrialSet>& trial_sets);
/// The complete table as TOML.
std::string calibration_toml(const calibrate::Table& table, const std::string& heading);

}  // namespace drover::jobs
