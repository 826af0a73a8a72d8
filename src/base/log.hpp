// base/log.hpp: log lines on standard error.
#pragma once
#include <string_view>

#include "drover/base/text.hpp"

namespace drover {

enum class LogLevel { quiet, warning, information, detail };

/// Suppresses lines less urgent than `level`.  Set once, at program start.
void set_log_level(LogLevel level);

/// This thread logs nothing while it lives.
class LogPause {
public:
    LogPause();
    ~LogPause();
    LogPause(const LogPause&) = delete;
    LogPause& operator=(const LogPause&) = delete;
};

void log_line(LogLevel level, std::string_view line);

template <class... Values>
void log_information(std::string_view pattern, const Values&... values) {
    log_line(LogLevel::information, text(pattern, values...));
}

template <class... Values>
void log_warning(std::string_view pattern, const Values&... values) {
    log_line(LogLevel::warning, text(pattern, values...));
}

}  // namespace drover
