// run/report/step_bias_estimate.hpp: the bias of each result of a run by its time step, with its uncertainty.
#pragma once
#include <cmath>
#include <map>
#include <string>
#include <vector>

#include "files/archive_reader.hpp"
#include "io/scene.hpp"
#include "measure/summary.hpp"
#include "run/fields/step_bias.hpp"

namespace drover::run {

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
        bool is_of_model = true;  ///< or of the grid
    };
    std::vector<Row> rows = {};
    std::vector<std::string> densities = {};  ///< "rod": those that are counted in boxes
    bool has_all = true;                      ///< false: the archive is of a version with other observables
};

/// From what the archive of a run of fields has recorded, for the rows of its summary.
/// is_exact: every term is linear.
StepBiases step_biases(const files::ArchiveReader& archive, const io::Scene& scene, bool is_exact,
                       const BiasedRows& measured, const measure::Summary& summary);

/// Of results that are wrong by more than a tenth, beyond their uncertainties: one warning at most.
std::vector<std::string> step_bias_warnings(const StepBiases& biases, const io::Scene& scene,
                                            const measure::Summary& summary);

/// "-0.3 +- 0.1 %" of the value, or in its unit where the value may be zero; "not resolved (effort 5 %)",
/// "not measured", "exact".
std::string step_bias_text(const StepBiases& biases, const io::Scene& scene, const std::string& row,
                           std::size_t component, const measure::Estimate& estimate);

}  // namespace drover::run
