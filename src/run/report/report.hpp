// run/report/report.hpp: the results of a recorded run, with the linear theory on the same grid, shells and boxes.
#pragma once
#include <cmath>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "files/archive.hpp"
#include "io/scene.hpp"
#include "measure/fields.hpp"
#include "measure/summary.hpp"
#include "run/fields/step_bias.hpp"

namespace drover::run {

/// Linear theory of the observable of that name; NaN where there is no prediction.
struct Prediction {
    std::string name;
    std::vector<double> values;
};

/// The value less that of a step of zero length, and its uncertainty, in the unit of the value; NaN: not resolved.
struct StepBiasEstimate {
    double bias = std::nan(""), error = std::nan("");
    bool is_resolved() const { return std::isfinite(bias) && std::isfinite(error); }
};

struct StepBiases {
    StepBiasState state = StepBiasState::measured;            ///< exact: every term is linear, no step makes an error
    std::vector<std::string> exact;                           ///< rows that no state changes: conserved numbers
    std::map<std::string, std::vector<StepBiasEstimate>> of;  ///< by row of the summary, for each of its estimates
    const StepBiasEstimate* find(const std::string& row, std::size_t component) const;
};

/// The observables of a run of which differences are recorded.
struct BiasedRows {
    struct Row {
        std::string name;
        std::size_t values = 1;
        bool is_of_model = true;    ///< or of the grid
        bool is_of_shells = false;  ///< its last axis is |q|
    };
    std::vector<Row> rows = {};
    std::vector<std::string> densities = {};  ///< "rod": those that are counted in boxes
    bool has_all = true;                      ///< false: the archive is of a version with other observables
    /// For each shell of |q|, whether the coarse grid of the error of the steps has its modes.
    std::vector<bool> has_shell = {};
};

struct Report {
    io::Scene scene;
    measure::FieldSetting setting;  ///< of a run of fields
    measure::Summary summary;
    std::vector<Prediction> predictions;
    StepBiases step_bias;               ///< of a run of fields
    std::vector<std::string> warnings;  ///< see run/warnings/warnings.hpp
    std::string no_prediction;          ///< why there is none; else ""
    std::string about;                  ///< the uniform state of the predictions, for people
    bool about_flock = false;           ///< that state has a direction
    double time = 0.0;                  ///< of the last sample [s]
};

/// Whether a report includes linear theory, which for a large grid takes longer than all else.
enum class Theory { included, omitted };

/// The report of an archive of fields; see make_report() of run/simulation_type.hpp.
Report make_field_report(const files::ArchiveReader& archive, const io::Scene& scene, Theory theory);

/// Number of samples or frames on the schedule: the last one may be off it.
std::size_t rows_on_schedule(const std::vector<double>& times, double spacing);

/// The samples of an archive that are on the schedule of its scene.
struct Sampling {
    double end = 0.0;      ///< time of the last sample of all [s]
    double spacing = 1.0;  ///< [s]
    std::size_t samples = 0;
    std::optional<std::size_t> warm_up;  ///< in samples, where the scene sets it
    bool leaves_out_last = false;        ///< the last sample is off the schedule
};
Sampling sampling_of(const files::ArchiveReader& archive, const io::Scene& scene, const std::string& group);

/// A report with the summary of what was recorded, whose sampling it sets.
Report summary_report(const io::Scene& scene, const Sampling& sampling, measure::Recorded& recorded);

/// "-0.3 +- 0.1 %" of the value, or in its unit where the value may be zero; "not resolved (effort 5 %)",
/// "not measured", "exact".
std::string step_bias_text(const StepBiases& biases, const io::Scene& scene, const std::string& row,
                           std::size_t component, const measure::Estimate& estimate);

/// The group /summary of an archive: for each result its mean and, as <name>_error, <name>_autocorrelation_time and
/// <name>_linear, its error, autocorrelation time and prediction; NaN where there is no error estimate.
files::ResultTable result_table(const Report& report);

}  // namespace drover::run
