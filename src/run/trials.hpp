// run/trials.hpp: runs of scenes in a folder, on local workers, each kept, extended where needed, with its cost.
#pragma once
#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "drover/files/record_file.hpp"
#include "drover/io/scene.hpp"

namespace drover::run {

/// One run to make.
struct Trial {
    io::Scene scene;         ///< with its end
    bool rounds_up = false;  ///< floating-point numbers are rounded up, not to the nearest
};

/// What is known of it.
struct TrialResult {
    std::filesystem::path archive;
    double end = 0.0;            ///< reached [s]
    double start_seconds = 0.0;  ///< of a core, before and after the steps
    double step_seconds = 0.0;   ///< of a core, for all steps
    std::string run_id;          ///< of the archive; "" in records of earlier versions
    std::string failure;         ///< why the run failed; else ""
    bool is_recorded = true;     ///< false for a failure of this machine: the next command tries again
    double seconds() const { return start_seconds + step_seconds; }
};

/// The trials of one folder.
class Trials {
public:
    /// Reads what the folder holds.  Throws an input Error when another process works there, and, with the first
    /// difference, when its records are those of another scene than this one (its resolved text).
    Trials(const std::filesystem::path& folder, const std::string& scene, int workers);

    /// Runs what is not there yet; a run that is too short is continued from its checkpoint.  Returns false when a
    /// signal stopped it.  A failure of the scene is recorded; one of the environment stops all trials and is thrown.
    bool run(const std::vector<Trial>& trials);

    /// The result of a trial that was run; nullptr when there is none, or a shorter one that did not fail.
    const TrialResult* find(const Trial& trial) const;

    /// Throws an input Error, with the first difference, unless the archive of a result is what the trial wrote.
    void require_archive(const Trial& trial, const TrialResult& result) const;

private:
    std::string name_of(const Trial& trial) const;
    void take(const std::string& record);

    std::filesystem::path folder_;
    int workers_;
    files::RecordFile records_;
    std::map<std::string, TrialResult> results_;
};

}  // namespace drover::run
