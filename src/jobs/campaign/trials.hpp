// jobs/campaign/trials.hpp: runs of scenes in a folder, shared with other processes, each kept, extended where needed,
// with its cost.
#pragma once
#include <filesystem>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "io/scene.hpp"
#include "jobs/campaign/accuracy_target.hpp"
#include "jobs/campaign/campaign.hpp"

namespace drover::jobs {

/// One run to make.
struct TrialRun {
    io::Scene scene;         ///< with its end
    bool rounds_up = false;  ///< floating-point numbers are rounded up, not to the nearest
};

/// What is known of it.
struct TrialResult {
    std::filesystem::path archive;
    double end = 0.0;                    ///< reached [s]
    double start_seconds = 0.0;          ///< of a core, before and after the steps
    double step_seconds = 0.0;           ///< of a core, for the steps that were timed: a kill loses the times before it
    double timed = 0.0;                  ///< simulated time of these steps [s]
    std::string host;                    ///< name of the machine on which it ended
    std::string program;                 ///< the drover that ended it
    std::string run_id;                  ///< of the archive
    std::optional<std::string> failure;  ///< why the run failed, if it did
    double seconds() const { return start_seconds + step_seconds; }
};

/// The trials of one folder, in which any number of processes may work.
class Trials {
public:
    /// Reads what the folder holds.  `scene`: the resolved text of the scene that the trials change.  Throws an input
    /// Error, with the first difference, when the records are those of another one.
    Trials(const std::string& scene, const JobOptions& options);
    Trials(const Trials&) = delete;
    Trials& operator=(const Trials&) = delete;

    /// Returns when all of them have ended, here or in other processes; a run that is too short is continued from its
    /// checkpoint.  False when a signal stopped it.  A failure of the scene is recorded; one of the environment stops
    /// all trials and is thrown.
    bool run(const std::vector<TrialRun>& trials);

    /// Numbers that all processes in the folder take from the one that came first, such as what follows from a timing.
    /// Nothing when a signal came.
    std::optional<std::vector<double>> agreed(const std::string& name,
                                              const std::function<std::vector<double>()>& compute);

    /// The result of a trial that was run; nullptr when there is none, or a shorter one that did not fail.
    const TrialResult* find(const TrialRun& trial) const;

    /// Throws an input Error, with the first difference, unless the archive of a result is what the trial wrote.
    void require_archive(const TrialRun& trial, const TrialResult& result) const;

private:
    /// A trial to run, or numbers to agree on.
    struct Wanted {
        std::string key, name;
        TrialRun trial = {};
        std::function<std::vector<double>()> compute = {};
    };
    UnitPlan plan();
    const Wanted& wanted(const std::string& key) const;
    std::optional<UnitResult> run_one(const Wanted& wanted) const;
    static UnitResult failed(const Wanted& wanted, double core_seconds);
    void take(const UnitRecord& record);
    void keep(const UnitRecord& record);
    bool run_wanted();

    JobOptions options_;                                   ///< with workers
    std::map<std::string, TrialResult> results_, failed_;  ///< by name; a longer run may fail
    std::map<std::string, std::vector<double>> agreed_;    ///< by key
    std::vector<Wanted> wanted_;
    std::set<std::string> taken_;             ///< keys of records that are in the results
    std::map<std::string, UnitRecord> lost_;  ///< by key, whose process died, or whose machine was too small
    Campaign campaign_;
};

/// One line over all processes in the folder.
std::string trials_status(const std::filesystem::path& folder, const std::string& scene);

}  // namespace drover::jobs
