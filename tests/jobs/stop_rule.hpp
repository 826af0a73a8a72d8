// tests/jobs/stop_rule.hpp: a rule of --stop-when for as long as an object lives.
#pragma once
#include <string>

#include "jobs/campaign/campaign.hpp"
#include "run/loop/signals.hpp"

namespace drover::jobs {

/// A rule of the process; it, and the request to stop that it made, are gone at the end.
struct ScopedStopRule {
    explicit ScopedStopRule(const std::string& rule) { set_stop_rules({rule}); }
    ~ScopedStopRule() {
        set_stop_rules({});
        run::request_stop(0);
    }
    ScopedStopRule(const ScopedStopRule&) = delete;
    ScopedStopRule& operator=(const ScopedStopRule&) = delete;
};

}  // namespace drover::jobs
