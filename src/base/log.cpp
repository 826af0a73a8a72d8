// base/log.cpp: logging to standard error by spdlog.
#include "base/log.hpp"

#include <spdlog/sinks/stdout_color_sinks.h>
#include <spdlog/spdlog.h>

#include <cstdlib>

namespace drover {

namespace {
spdlog::logger& logger() {
    static const std::shared_ptr<spdlog::logger> shared = [] {
        const char* no_color = std::getenv("NO_COLOR");  // set and not empty: see no-color.org
        const bool plain = no_color != nullptr && *no_color != '\0';
        auto sink = std::make_shared<spdlog::sinks::stderr_color_sink_mt>(plain ? spdlog::color_mode::never
                                                                                : spdlog::color_mode::automatic);
        auto result = std::make_shared<spdlog::logger>("drover", std::move(sink));
        result->set_pattern("drover: %^%v%$");
        result->flush_on(spdlog::level::trace);
        return result;
    }();
    return *shared;
}

spdlog::level::level_enum level_of(LogLevel level) {
    switch (level) {
        case LogLevel::quiet: return spdlog::level::off;
        case LogLevel::warning: return spdlog::level::warn;
        case LogLevel::information: return spdlog::level::info;
        case LogLevel::detail: return spdlog::level::debug;
    }
    return spdlog::level::info;
}

thread_local int pauses = 0;
}  // namespace

LogPause::LogPause() { ++pauses; }
LogPause::~LogPause() { --pauses; }

void set_log_level(LogLevel level) { logger().set_level(level_of(level)); }

void log_line(LogLevel level, std::string_view line) {
    if (pauses > 0) return;
    logger().log(level_of(level), "{}{}", level == LogLevel::warning ? "warning: " : "", printable(line));
}

}  // namespace drover
