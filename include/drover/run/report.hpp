// run/report.hpp: what a recorded run says, beside the linear theory of the same grid, shells and boxes.
#pragma once
#include <optional>
#include <string>
#include <vector>

#include "drover/files/archive.hpp"
#include "drover/io/scene.hpp"
#include "drover/measure/summary.hpp"

namespace drover::run {

/// Linear theory under the name of the observable that it predicts; not-a-number where it says nothing.
struct Prediction {
    std::string name;
    std::vector<double> values;
};

struct Report {
    io::Scene scene;
    std::vector<files::Axis> axes;  ///< of the results
    measure::Setting setting;       ///< of a run of fields
    measure::Summary summary;
    std::vector<Prediction> predictions;
    std::string no_prediction;  ///< why there is none: "" when there is
    std::string about;          ///< the uniform state that the predictions are about, for people
    bool about_flock = false;   ///< it has order
    double time = 0.0;          ///< of the last sample [s]
};

/// Reads the observables of an archive.  Throws an input Error if it is not an archive of a run.
Report make_report(const files::ArchiveReader& archive);
Report make_field_report(const files::ArchiveReader& archive, const io::Scene& scene);

/// The samples of an archive that stand on the schedule of its scene.
struct Sampling {
    double end = 0.0;      ///< time of the last sample of all [s]
    double spacing = 1.0;  ///< [s]
    std::size_t samples = 0;
    std::optional<std::size_t> warm_up;  ///< samples, where the scene says
};
Sampling sampling_of(const files::ArchiveReader& archive, const io::Scene& scene, const std::string& group);

/// The prediction of a name; nullptr when there is none.
const Prediction* find_prediction(const Report& report, const std::string& name);

/// As the group /summary of an archive: for each result its mean and, as <name>_error, <name>_autocorrelation_time and
/// <name>_linear, what belongs to it; not-a-number where an error was refused.
files::ResultTable result_table(const Report& report);

/// For people: scalars, structure factors and number fluctuations, each beside its prediction.
std::string report_text(const Report& report);

}  // namespace drover::run
