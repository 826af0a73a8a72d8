// jobs/campaign/campaign.cpp: claims units, gives them to workers in groups, keeps their records, and waits for other
// processes; the table of rules that stop a job.
#include "jobs/campaign/campaign.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <map>
#include <set>
#include <thread>

#include "base/duration.hpp"
#include "base/log.hpp"
#include "base/mapped.hpp"
#include "drover/base/error.hpp"
#include "drover/base/text.hpp"
#include "drover/base/threads.hpp"
#include "files/archive_reader.hpp"
#include "files/checkpoint.hpp"
#include "jobs/campaign/worker_pool.hpp"
#include "run/loop/provenance.hpp"
#include "run/loop/signals.hpp"
#include "run/loop/simulation.hpp"

namespace drover::jobs {

namespace {
using namespace std::chrono_literals;

constexpr double group_seconds = 1.0;  ///< of work that a worker gets at a time
constexpr auto second_look = 1s;       ///< at what another process had, or may have done meanwhile
constexpr auto max_delay = 1s;         ///< of a record on its way to the disk
constexpr int max_losses = 3;          ///< of a unit, for a share

double count_of(const std::string& given, const std::string& option) {
    int count = 0;
    const auto [end, problem] = std::from_chars(given.data(), given.data() + given.size(), count);
    require(problem == std::errc() && end == given.data() + given.size() && count > 0, {.file = option},
            "\"{}\" is no count; expected an integer above 0, such as 5", given);
    return count;
}

/// "name=limit" stops when `reached` is at least the limit.
struct StopRule {
    const char *name, *meaning;
    double (*limit_of)(const std::string& given, const std::string& option);
    double (*reached)(const Progress& progress);
};

constexpr std::array rules{
    StopRule{"jobs", "this number of jobs of the command has ended", &count_of,
             [](const Progress& so_far) { return static_cast<double>(so_far.ended); }},
    StopRule{"failures", "this number of jobs has failed", &count_of,
             [](const Progress& so_far) { return static_cast<double>(so_far.failed); }},
    StopRule{"core-time", "the jobs have used this core time in total, such as 90min or 2h", &seconds_of,
             [](const Progress& so_far) { return so_far.core_seconds; }},
};

constexpr const char* option = "--stop-when";

struct SetRule {
    std::string text;
    const StopRule* rule;
    double limit;
};

// A property of the process, as the time of --max-time is: set before there are workers.
std::vector<SetRule>& set_rules() {
    static std::vector<SetRule> set;
    return set;
}

SetRule parsed(const std::string& given) {
    const std::size_t equals = given.find('=');
    const std::string name = trimmed(given.substr(0, equals));
    const auto found = std::ranges::find_if(rules, [&](const StopRule& rule) { return rule.name == name; });
    const auto names = mapped(rules, [](const StopRule& rule) { return std::string(rule.name); });
    require(found != rules.end() && equals != std::string::npos, {.file = option},
            "\"{}\" is no rule; expected NAME=LIMIT with one of {}, such as failures=5", given, joined(names));
    const std::string place = text("{} {}", option, name);
    return {given, &*found, found->limit_of(trimmed(given.substr(equals + 1)), place)};
}

/// The first rule that is met; "": none.
std::string met_rule(const Progress& progress) {
    for (const SetRule& one : set_rules())
        if (one.rule->reached(progress) >= one.limit) return text("{} {}", option, one.text);
    return "";
}
}  // namespace

struct Campaign::State {
    State(UnitPlan plan, CampaignOptions options)
        : plan_(std::move(plan)),
          options_(std::move(options)),
          claims_(options_.job.folder / "claims",
                  files::this_process(options_.job.share.number, options_.job.share.count, options_.job.workers),
                  options_.times),
          store_(options_.job.folder, options_.identity, options_.job.share) {
        refresh();
        if (options_.job.share.is_plain()) {  // what had failed may be tried again
            std::erase_if(ended_, [](const auto& unit) { return unit.second.state != UnitState::done; });
            for (auto& [key, unit] : ended_) unit.losses = 0;
        }
    }

    CampaignOutcome run() {
        const run::StopSignals signals;
        outcome_ = {};
        is_new_ = true;
        const Jobs jobs{.next = [this] { return next(); },
                        .work = [this](std::size_t job, const Send& send) { return work(job, send); },
                        .received = [this](std::size_t job, const std::string& bytes) { keep(job, unit_of(bytes)); },
                        .ended = [this](std::size_t job, int status) { end(job, status); },
                        .idle = [this] { tend(); }};
        const PoolOptions pool{.workers = options_.job.workers, .grace_period = options_.grace_period};
        for (;;) {
            try {
                outcome_.stopped = run_jobs(jobs, pool);
            } catch (...) {
                flush();  // what has ended is kept
                throw;
            }
            flush();
            const bool waits = options_.job.share.is_plain() || options_.shares_wait;
            if (outcome_.stopped || held_.empty() || (!waits && are_alive())) break;
            report_waiting();
            std::this_thread::sleep_for(200ms);
            tend();
        }
        outcome_.held = held_.size();
        return outcome_;
    }

private:
    struct Ended {
        UnitState state = UnitState::done;
        int losses = 0;
    };
    struct HeldUnit {
        files::Held by = files::Held::maybe;
        Clock::time_point looked = Clock::now();
    };

    bool is_over(const std::string& key) const {
        const auto found = ended_.find(key);
        if (found == ended_.end()) return false;
        const Ended& unit = found->second;
        const bool is_given_up = !options_.job.share.is_plain() && unit.losses >= max_losses;
        return unit.state != UnitState::lost || is_given_up || lost_here_.contains(key);
    }

    void take(const UnitRecord& record) {
        if (!record.is_new && record.state == UnitState::done && plan_.holds && !plan_.holds(record)) return;
        Ended& unit = ended_.try_emplace(record.key, Ended{.state = record.state}).first->second;
        if (record.state == UnitState::lost) ++unit.losses;
        unit.state = std::min(unit.state, record.state);
        held_.erase(record.key);
        plan_.take(record);
    }

    void refresh() {
        for (const UnitRecord& record : store_.read_new()) take(record);
    }

    /// The next group.  Its units were claimed, and then looked for among the records of others.
    std::optional<std::size_t> next() {
        tend();
        if (!is_new_ && Clock::now() - gathered_ < second_look) return std::nullopt;  // nothing was found a moment ago
        std::vector<std::string> group;
        do group = gather();
        while (!group.empty() && others_have_done(group));  // then there may be units that it did not come to
        gathered_ = Clock::now();
        is_new_ = !group.empty();
        if (group.empty()) return std::nullopt;
        groups_.push_back(std::move(group));
        return groups_.size() - 1;
    }

    /// Leaves out the units of a group that are over, by a look at the records of others; whether none is left.  A
    /// claim is released when its record is on the disk: so processes that see the same folder compute no unit
    /// twice, and take no different results of one.
    bool others_have_done(std::vector<std::string>& group) {
        refresh();
        std::erase_if(group, [this](const std::string& key) {
            if (is_over(key)) busy_.erase(key), released_.insert(claim_of(key));
            return is_over(key);
        });
        return group.empty();
    }

    std::string claim_of(const std::string& key) const { return plan_.claim ? plan_.claim(key) : key; }

    /// Requests a stop where a rule is met.  Called where there is more to do: a job that is complete was not stopped.
    bool stop_by_rule() const {
        const std::string rule = met_rule(progress_);
        if (!rule.empty()) run::request_stop(SIGALRM, rule);
        return !rule.empty();
    }

    std::vector<std::string> gather() {
        const double seconds_each =
            progress_.ended > 0 ? progress_.core_seconds / static_cast<double>(progress_.ended) : group_seconds;
        const auto limit = static_cast<std::size_t>(
            std::clamp(group_seconds / std::max(seconds_each, 1e-9), 1.0, static_cast<double>(options_.max_group)));
        std::vector<std::string> group;
        std::map<std::string, HeldUnit> held;
        plan_.wanted([&](const std::string& key) {
            if (is_over(key) || busy_.contains(key)) return true;
            if (stop_by_rule()) return false;
            const auto before = held_.find(key);
            if (before != held_.end() && Clock::now() - before->second.looked < second_look) held.insert(*before);
            else if (const std::string name = claim_of(key); claims_.claim(name))
                group.push_back(key), busy_.insert(key), released_.erase(name);
            else held[key] = {.by = claims_.holder(name)};
            return group.size() < limit;
        });
        held_ = std::move(held);
        return group;
    }

    /// In the worker.
    int work(std::size_t job, const Send& send) const {
        for (const std::string& key : groups_[job]) {
            if (run::stop_signal() != 0) return run::exit_stopped;
            const auto start = Clock::now();
            const double core_start = run::core_seconds();
            UnitRecord record{.key = key, .result = {}, .reason = {}, .program = run::this_program()};
            try {
                auto result = plan_.run(key);
                if (!result) return run::exit_stopped;
                record.result = std::move(*result);
            } catch (const run::MixedFiles&) {
                throw;
            } catch (const Error& error) {
                // A signal, also to this process alone, before the run began.
                if (error.fault() == Fault::environment && run::stop_signal() != 0) return run::exit_stopped;
                if (!is_of_scene(error.fault()) && error.fault() != Fault::unavailable) throw;
                record.state = is_of_scene(error.fault()) ? UnitState::failed : UnitState::lost;
                record.reason = error.what();
                if (plan_.failed) record.result = plan_.failed(key, run::core_seconds() - core_start);
            }
            record.seconds = seconds_since(start);
            record.core_seconds = std::max(record.seconds, run::core_seconds() - core_start);
            send(unit_bytes(record));
        }
        return run::exit_done;
    }

    void keep(std::size_t job, UnitRecord record) {
        record.is_new = true;
        std::erase(groups_[job], record.key);
        store_.append(record);
        if (record.state == UnitState::lost) lost_here_.insert(record.key);
        busy_.erase(record.key);
        released_.insert(claim_of(record.key));
        ++outcome_.ran;
        ++progress_.ended;
        progress_.core_seconds += record.core_seconds;
        if (record.state != UnitState::done) ++progress_.failed;
        take(record);
        if (!busy_.empty()) stop_by_rule();
    }

    void end(std::size_t job, int status) {
        const bool is_crash = status != run::exit_done && status != run::exit_stopped && run::stop_signal() == 0;
        // By a signal to that process alone, such as that of a limit of its time: this meets the next one too.
        const bool is_stuck = status == run::exit_stopped && run::stop_signal() == 0 && !groups_[job].empty() &&
                              ++stops_[groups_[job].front()] == max_losses;
        if ((is_crash || is_stuck) && !groups_[job].empty())
            keep(job, {.key = groups_[job].front(),
                       .state = UnitState::lost,
                       .reason = is_stuck ? text("a signal stopped its process, {} times", max_losses)
                                          : text("its process ended with status {}", status),
                       .program = run::this_program()});
        for (const std::string& key : groups_[job]) busy_.erase(key), released_.insert(claim_of(key));
        groups_[job].clear();
        is_new_ = true;
    }

    void tend() {
        claims_.renew();
        if (Clock::now() - flushed_ > max_delay) flush();
    }

    /// A claim is released when its record is on the disk.
    void flush() {
        flushed_ = Clock::now();
        store_.sync();
        for (const std::string& name : released_) claims_.release(name);
        released_.clear();
    }

    bool are_alive() const {
        return std::ranges::all_of(held_, [](const auto& unit) { return unit.second.by == files::Held::certainly; });
    }

    void report_waiting() {
        if (options_.job.quiet || Clock::now() - reported_ < 30s) return;
        reported_ = Clock::now();
        log_information("waiting for {} jobs of other processes in {}", held_.size(), options_.job.folder.string());
    }

    UnitPlan plan_;
    CampaignOptions options_;
    files::Claims claims_;
    UnitStore store_;
    CampaignOutcome outcome_;
    std::map<std::string, Ended> ended_;
    std::map<std::string, int> stops_;        ///< of units, by signals to their processes
    std::set<std::string> busy_, lost_here_;  ///< claimed by this process; lost in it
    std::map<std::string, HeldUnit> held_;    ///< wanted, but of other processes
    std::set<std::string> released_;          ///< claims that go with the next flush
    std::vector<std::vector<std::string>> groups_;
    Progress progress_;
    bool is_new_ = true;  ///< something happened since nothing was wanted
    Clock::time_point gathered_ = {}, flushed_ = Clock::now(), reported_ = Clock::now();
};

Campaign::Campaign(UnitPlan plan, CampaignOptions options)
    : state_(std::make_unique<State>(std::move(plan), std::move(options))) {}
Campaign::~Campaign() = default;
CampaignOutcome Campaign::run() { return state_->run(); }

Share read_share(const std::string& written) {
    Share share;
    int used = 0;
    const bool is_whole = std::sscanf(written.c_str(), "%9d/%9d%n", &share.number, &share.count, &used) == 2 &&
                          used == static_cast<int>(written.size());
    require(is_whole && share.number >= 1 && share.number <= share.count, {},
            "--share {}; expected I/N with I from 1 to N, such as 2/8", written);
    return share;
}

JobOptions with_workers(JobOptions options, int of_scene) {
    if (options.workers == 0) options.workers = of_scene > 0 ? of_scene : usable_cores();
    return options;
}

Working working_in(const std::filesystem::path& folder) {
    Working working;
    for (const files::ClaimHolder& holder : files::claim_holders(folder / "claims")) {
        if (!holder.is_alive || holder.claimant.workers == 0) continue;
        ++working.processes;
        working.workers += static_cast<std::size_t>(holder.claimant.workers);
        working.units += holder.keys;
    }
    return working;
}

EndedRun run_or_resume(const io::Scene& scene, bool rounds_up,
                       const std::function<bool(const std::filesystem::path& archive)>& has_ended) {
    const std::filesystem::path path = run::archive_path(scene);
    const run::RunOptions options{.overwrite = true, .quiet = true, .rounds_up = rounds_up};
    constexpr int max_tries = 100;
    for (int i = 0; files::is_being_written(path) && i < max_tries; ++i) std::this_thread::sleep_for(50ms);
    const auto ended = [](RunEnd end, run::RunOutcome outcome) {
        return EndedRun{outcome.loop.signal != 0 ? RunEnd::stopped : end, std::move(outcome)};
    };
    if (run::stop_signal() != 0) return {};
    RunEnd end = RunEnd::completed;
    try {
        if (std::filesystem::exists(path)) {
            if (has_ended(path)) return {.end = RunEnd::found};
            if (files::has_checkpoint(path))
                return ended(RunEnd::continued,
                             run::restart_run(path, std::vector{text("time.end={:.17g}", scene.time.end)}, options));
        }
    } catch (const run::MixedFiles&) {
        throw;
    } catch (const Error& error) {
        if (error.fault() != Fault::input || files::is_being_written(path)) throw;
        if (run::stop_signal() != 0) return {};
        const std::filesystem::path kept = path.string() + ".damaged";
        log_warning("{}; {} is run again from its start, and the file is kept as {}", error.what(),
                    path.stem().string(), kept.filename().string());
        files::remove_checkpoints(path);  // first: a kill must not leave them beside the archive of the new run
        std::filesystem::rename(path, kept);
        end = RunEnd::repeated;
    }
    return ended(end, run::run_scene(scene, options));
}

void require_folder(const std::filesystem::path& folder, const char* command) {
    require(std::filesystem::is_directory(folder), {.file = folder.string()},
            "no such folder; expected the output folder of drover {}: set it with --output", command);
}

void conclude(const JobOptions& job, const std::function<bool()>& read,
              const std::function<void(bool is_complete)>& write) {
    const bool is_complete = read();
    if (!job.share.is_plain() && !is_complete) return;
    files::Claims claims(job.folder / "claims", files::this_process(1, 1, 0));
    constexpr int max_tries = 6000;
    for (int tries = 0; !claims.claim("table") && tries < max_tries; ++tries) {
        std::this_thread::sleep_for(100ms);
        claims.renew();
    }
    read();  // anew: not what was there before the table of another process
    write(is_complete);
    // While others work, a claim of the dead keeps its place below theirs.
    if (is_complete && working_in(job.folder).processes == 0) claims.remove_dead();
}

std::string other_program_text(const std::string& made_by, const char* what) {
    return text("{}, and this is drover {}: if a change between them affects results, repeat {} in another folder",
                made_by, run::this_program(), what);
}

std::string campaign_status(const std::filesystem::path& folder, const std::vector<UnitRecord>& records,
                            const std::vector<std::string>& keys) {
    std::map<std::string, const UnitRecord*> known;
    for (const UnitRecord& record : records) known[record.key] = &record;
    std::size_t done = 0, failed = 0, timed = 0;
    double seconds = 0.0;
    for (const std::string& key : keys) {
        const auto found = known.find(key);
        if (found == known.end()) continue;
        ++(found->second->state == UnitState::done ? done : failed);
        if (found->second->state == UnitState::lost) continue;
        ++timed;
        seconds += found->second->seconds;
    }
    const auto [shares, workers, running] = working_in(folder);
    const std::size_t left = keys.size() - done - failed;
    std::string line = text("{} of {} done, {} failed, {} running in {} processes", done, keys.size(), failed,
                            std::min(running, left), shares);
    if (timed == 0 || workers == 0 || left == 0) return line;
    const double rate = static_cast<double>(workers) * static_cast<double>(timed) / std::max(seconds, 1e-9);
    return line + text("; {:.3g} a minute, {} left", 60.0 * rate, duration_text(static_cast<double>(left) / rate));
}

void set_stop_rules(const std::vector<std::string>& given) { set_rules() = mapped(given, parsed); }

std::vector<std::string> stop_rules() { return mapped(set_rules(), &SetRule::text); }

std::string stop_rules_help() {
    std::string help;
    for (const StopRule& rule : rules) help += text("{}{}: {}", help.empty() ? "" : "; ", rule.name, rule.meaning);
    return help;
}

}  // namespace drover::jobs
