// base/log_pause.hpp: silence for what is repeated.
#pragma once

namespace drover {

/// This thread logs nothing while it lives.
class LogPause {
public:
    LogPause();
    ~LogPause();
    LogPause(const LogPause&) = delete;
    LogPause& operator=(const LogPause&) = delete;
};

}  // namespace drover
