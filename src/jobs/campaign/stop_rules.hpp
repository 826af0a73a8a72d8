// jobs/campaign/stop_rules.hpp: when a command with many jobs stops before its end.
#pragma once
#include <string>
#include <vector>

namespace drover::jobs {

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

/// The first rule that is met; "": none.
std::string met_rule(const Progress& progress);

}  // namespace drover::jobs
