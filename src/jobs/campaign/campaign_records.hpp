// jobs/campaign/campaign_records.hpp: the records of a campaign as bytes, and the folder of those that processes have
// appended.
#pragma once
#include <map>
#include <set>
#include <string>
#include <vector>

#include "files/record_folder.hpp"
#include "jobs/campaign/job_options.hpp"
#include "measure/summary.hpp"

namespace drover::jobs {

/// How a unit ended.
enum class UnitState : std::int64_t {
    done,
    failed,  ///< by its scene: it fails again, on any machine
    lost     ///< its process died, or its machine was too small: it may succeed elsewhere
};

/// What a unit gives.  It is the same, to the byte, whoever computes it, but for times that are measured.
struct UnitResult {
    std::string content;
    std::string shared = {};  ///< the part that many units have in common, which each file of records holds once
    bool operator==(const UnitResult&) const = default;
};

/// What is kept of a run: all results with their axes, and its warnings.
struct RunResults {
    std::vector<measure::SummaryRow> rows;
    std::vector<std::string> warnings;
};

/// Names, units and axes are the shared part.  Of arrays the autocorrelation times and the reasons of missing errors
/// are not kept.
UnitResult encode(const RunResults& results);

/// Throws an input Error for other bytes.
RunResults decode(const UnitResult& result);

/// One unit that has ended, as stored.
struct UnitRecord {
    std::string key;
    UnitState state = UnitState::done;
    UnitResult result;          ///< of a failed unit what its plan keeps; empty if its process died
    std::string reason;         ///< why it is not done
    double seconds = 0.0;       ///< that it took
    std::string program;        ///< the drover that computed it
    bool is_new = false;        ///< computed by this process, in this call; not stored
    double core_seconds = 0.0;  ///< for which it had cores, at least `seconds`; of a new one, not stored
    bool operator==(const UnitRecord&) const = default;
};

/// For a pipe.
std::string unit_bytes(const UnitRecord& record);
UnitRecord unit_of(const std::string& bytes);

/// The records in a folder, with the shared parts put back.
class UnitStore {
public:
    UnitStore(const std::filesystem::path& folder, const files::RecordIdentity& identity, const Share& share);

    /// Of other processes, since the last call.
    std::vector<UnitRecord> read_new();
    void append(UnitRecord record);
    void sync() { folder_.sync(); }

private:
    files::RecordFolder folder_;
    std::map<std::uint64_t, std::string> shared_;  ///< by hash
    std::set<std::uint64_t> stored_;               ///< of them, those in this process's file
};

/// The records of a campaign: of each unit the one that is done, else the last failure; by key.
std::vector<UnitRecord> campaign_records(const std::filesystem::path& folder, const files::RecordIdentity& identity);

}  // namespace drover::jobs
