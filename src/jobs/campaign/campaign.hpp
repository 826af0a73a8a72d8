// jobs/campaign/campaign.hpp: the engine of all jobs: units of work that processes on any number of machines share in a
// folder.
#pragma once
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "base/compute_all.hpp"
#include "base/constants.hpp"
#include "files/claims.hpp"
#include "jobs/campaign/campaign_records.hpp"
#include "run/run_scene.hpp"

namespace drover::jobs {

/// Takes a key that is to run now; returns whether more are welcome.
using Offer = std::function<bool(const std::string& key)>;

/// A plan of units.  Keys are plain file names.
struct UnitPlan {
    /// Offers the keys of the units that can run now, those that other processes have or have done included, most
    /// wanted first, until `offer` returns false.  Called again and again: what is wanted may depend on what has ended.
    std::function<void(const Offer& offer)> wanted;
    /// Computes a unit, in a worker process, which computes several one after another.  Nothing: a signal stopped it.
    /// An Error of the scene, or of a machine too small for it, is the failure of this unit, which the campaign records
    /// and counts; another one, or MixedFiles, ends the campaign.
    std::function<std::optional<UnitResult>(const std::string& key)> run;
    /// A unit has ended, here or elsewhere.  A key may come twice: a failure, and a success later.
    std::function<void(const UnitRecord& record)> take;
    /// Whether a record of a unit that is done still counts: false where the unit left a file that is not there any
    /// more.  May be empty.
    std::function<bool(const UnitRecord& record)> holds = {};
    /// In the worker, what to keep of a unit that failed after these core seconds.  May be empty: nothing.
    std::function<UnitResult(const std::string& key, double core_seconds)> failed = {};
    /// What is claimed for a unit: units with one name, as those that write one file, do not run at the same time.  May
    /// be empty: its key.
    std::function<std::string(const std::string& key)> claim = {};
};

struct CampaignOptions {
    JobOptions job;  ///< with workers
    files::RecordIdentity identity;
    double grace_period = infinite;  ///< for workers after a signal [s]
    bool shares_wait = false;        ///< for units of other processes, as those that end may make more wanted
    std::size_t max_group = 1000;    ///< units that a worker gets at a time, at most a second of work
    files::ClaimTimes times = {};
};

struct CampaignOutcome {
    std::size_t ran = 0;   ///< units that ended in this call
    bool stopped = false;  ///< by a signal
    std::size_t held = 0;  ///< units that other processes, which live, are still computing
};

/// The part of one process in a campaign.
class Campaign {
public:
    /// Takes the units that have ended before.  A plain process computes units again that had failed; a share, of more
    /// than one, does not, and gives up a unit that was lost three times.
    Campaign(UnitPlan plan, CampaignOptions options);
    ~Campaign();

    /// Computes what the plan wants and no other process has, until nothing is left; may be called again when more is
    /// wanted.  A plain process also waits for the units of other processes, and takes them if these die.  A share ends
    /// when it knows that they live, unless shares wait.
    CampaignOutcome run();

private:
    struct State;
    std::unique_ptr<State> state_;
};

/// What a loop throws that does not end in this process: a signal came, or numbers are missing and it only collects.
struct Interrupted {};

/// The loops of a calculation whose course depends on their numbers alone: every process goes through the same loops,
/// and computes of each what no other has.  Numbers of a loop that is over are not computed again, so that a process
/// that starts later, or anew, goes through all that is known in a moment.  Calls throw Interrupted, and a run Error
/// for numbers that failed.
ComputeAll shared_compute(CampaignOptions options);

/// How a run that may have been begun before has ended: it had ended already, or it was made from its start, from a
/// checkpoint, or from its start as its archive is damaged.
enum class RunEnd { stopped, found, completed, continued, repeated };
struct EndedRun {
    RunEnd end = RunEnd::stopped;
    run::RunOutcome outcome = {};
};

/// Runs a scene, or resumes it.  `has_ended` tells, of an archive that is there, whether nothing is left to run; it
/// throws an input Error for a damaged one, which is then kept beside the new one, and MixedFiles, which is thrown on.
/// Waits up to five seconds for another writer of the archive: a killed process may have workers that end a moment
/// later.
EndedRun run_or_resume(const io::Scene& scene, bool rounds_up,
                       const std::function<bool(const std::filesystem::path& archive)>& has_ended);

/// Throws an input Error unless there is this folder, of a command.
void require_folder(const std::filesystem::path& folder, const char* command);

/// Concludes a job: `read` takes what has ended anywhere and tells whether nothing is left to do; then a plain process,
/// or the share that was last, calls `read` again and `write` while no other process of the job does; waits for one, up
/// to ten minutes.  Where nothing is left, what killed processes left of their claims is removed.
void conclude(const JobOptions& job, const std::function<bool()>& read,
              const std::function<void(bool is_complete)>& write);

/// A warning of results that another version made: "the trials were made by drover 0.1"; `what`: to be repeated.
std::string other_program_text(const std::string& made_by, const char* what);

/// The processes that work now.
struct Working {
    std::size_t processes = 0, workers = 0, units = 0;
};
Working working_in(const std::filesystem::path& folder);

/// One line: units done, failed, running, the rate and the time left.
std::string campaign_status(const std::filesystem::path& folder, const std::vector<UnitRecord>& records,
                            const std::vector<std::string>& keys);

// ---- When a command with many jobs stops before its end

/// What this process has run so far.
struct Progress {
    std::size_t ended = 0;      ///< jobs
    std::size_t failed = 0;     ///< of them
    double core_seconds = 0.0;  ///< of all jobs together
};

/// Replaces the rules by these, such as "failures=5", for all campaigns of this process.  Throws an input Error for a
/// text that is no rule.
void set_stop_rules(const std::vector<std::string>& rules);

/// As they were given.
std::vector<std::string> stop_rules();

/// The names of all rules with their meanings, for the help of a command.
std::string stop_rules_help();

}  // namespace drover::jobs
