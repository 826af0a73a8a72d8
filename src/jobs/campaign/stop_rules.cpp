// jobs/campaign/stop_rules.cpp: the table of rules.
#include "jobs/campaign/campaign.hpp"

#include <algorithm>
#include <array>
#include <charconv>

#include "base/duration.hpp"
#include "base/mapped.hpp"
#include "drover/base/error.hpp"
#include "drover/base/text.hpp"

namespace drover::jobs {

namespace {
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
}  // namespace

void set_stop_rules(const std::vector<std::string>& given) { set_rules() = mapped(given, parsed); }

std::vector<std::string> stop_rules() { return mapped(set_rules(), &SetRule::text); }

std::string stop_rules_help() {
    std::string help;
    for (const StopRule& rule : rules) help += text("{}{}: {}", help.empty() ? "" : "; ", rule.name, rule.meaning);
    return help;
}

std::string met_rule(const Progress& progress) {
    for (const SetRule& one : set_rules())
        if (one.rule->reached(progress) >= one.limit) return text("{} {}", option, one.text);
    return "";
}

}  // namespace drover::jobs
