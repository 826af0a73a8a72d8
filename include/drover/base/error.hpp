// base/error.hpp: the exception type of drover, with the location in the scene that it refers to.
#pragma once
#include <array>
#include <functional>
#include <stdexcept>
#include <string>
#include <string_view>

#include "drover/base/text.hpp"

namespace drover {

/// A location in an input file.  line and column count from 1; 0: unknown.
struct SourceLocation {
    std::string file;
    int line = 0;
    int column = 0;
};

/// "flock.toml:14:3", "flock.toml:14", "flock.toml", or "" if unknown.
std::string location_text(const SourceLocation& where);

/// The location of a key of a scene, such as "grid.nx": for checks of several keys.
using Locate = std::function<SourceLocation(const std::string& key)>;
inline SourceLocation no_location(const std::string&) { return {}; }

/// The kind of an error.  It determines the exit status of the program, and whether the error is a property of the
/// scene, so that a record may keep it: see is_of_scene.
enum class Fault {
    input,        ///< the scene, the command line or the content of an input file: exit status 2
    unavailable,  ///< a file that cannot be used under its name, or a machine too small: exit status 2
    run,          ///< a run that its scene makes fail, such as a blow-up: exit status 1
    environment,  ///< a failing or full disk, too little memory, a limit, a signal: exit status 1
    defect        ///< a mistake in drover: exit status 1
};

constexpr auto names_of(Fault) { return std::array{"input", "unavailable", "run", "environment", "defect"}; }

/// Whether the same scene gives the same error again, on any machine and at any time.
inline bool is_of_scene(Fault fault) { return fault == Fault::input || fault == Fault::run; }

/// The message gives location, value found, value expected and a suggested fix.
class Error : public std::runtime_error {
public:
    Error(Fault fault, const SourceLocation& where, const std::string& message);
    Fault fault() const { return fault_; }
    const std::string& place() const { return place_; }      ///< as location_text()
    const std::string& message() const { return message_; }  ///< without the place

private:
    Fault fault_;
    std::string place_, message_;
};

template <class... Values>
[[noreturn]] void fail_input(const SourceLocation& where, std::string_view pattern, const Values&... values) {
    throw Error(Fault::input, where, text(pattern, values...));
}

template <class... Values>
[[noreturn]] void fail_run(std::string_view pattern, const Values&... values) {
    throw Error(Fault::run, {}, text(pattern, values...));
}

template <class... Values>
[[noreturn]] void fail_environment(std::string_view pattern, const Values&... values) {
    throw Error(Fault::environment, {}, text(pattern, values...));
}

inline constexpr const char* no_memory_text = "not enough memory; choose a smaller grid or cell, or free memory";

/// Any exception as an Error: those of memory and of system calls are the environment's, others that are no Error are a
/// defect.
Error error_of(const std::exception& exception);

/// Throws an input Error at `where` unless `holds`.
template <class... Values>
void require(bool holds, const SourceLocation& where, std::string_view pattern, const Values&... values) {
    if (!holds) fail_input(where, pattern, values...);
}

}  // namespace drover
