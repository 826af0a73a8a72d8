// jobs/tradeoff/tradeoff.hpp: speed for accuracy, measured on one scene: the cheapest run that is as accurate as
// required.
#pragma once
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "io/scene.hpp"
#include "jobs/campaign/trials.hpp"
#include "run/result.hpp"

namespace drover::jobs {

struct Tradeoff {
    run::Result result;                    ///< the front, the recommended run, what every axis does
    std::optional<io::Scene> recommended;  ///< none when no setting meets the targets within the budget
    std::vector<std::string> reasons;      ///< of the recommendation, sentences
    std::string why_none;                  ///< why there is none; else ""
    std::string recommended_text;          ///< TOML with the reason of each choice
    double seconds = 0.0;                  ///< of a core, for all trials
    double expected_seconds = 0.0;         ///< of a core, for the recommended run
    bool stopped = false;                  ///< by a signal: call again to resume
};

/// Trials of the scene with other steps, methods, grids, models and durations, in `folder`, which keeps every one: call
/// it again to resume, or with other targets.  Writes tradeoff.json there, and recommended.toml.  Throws an input Error
/// when the folder holds the trials of another scene, and for a target that the run does not answer; a run Error when
/// the scene as given cannot be run within the budget.
Tradeoff study_tradeoff(const io::Scene& scene, const TargetOptions& options);

/// One line over all processes in the folder of a study: trials done, failed and running.
std::string tradeoff_status(const io::Scene& scene, const std::filesystem::path& folder);

/// The scene of the run that is as accurate as required, found by trials that take a tenth of the time of the given
/// scene, in a folder beside its archive (.tradeoff for .h5), with the output file of the given one.  Nothing when a
/// signal stopped the trials: call it again to resume.  Throws a run Error when there is none.
std::optional<io::Scene> with_accuracy(const io::Scene& scene, const std::vector<AccuracyTarget>& targets, bool quiet);

}  // namespace drover::jobs
