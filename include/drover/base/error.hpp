// base/error.hpp: the exception type of drover, with the location in the scene that it refers to.
#pragma once
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
using LocationOf = std::function<SourceLocation(const std::string& key)>;
inline SourceLocation no_location(const std::string&) { return {}; }

/// The cause of an error, which determines the exit status of the program.
enum class Fault {
    input,  ///< the scene, the command line or an input file: exit status 2
    run     ///< a run that failed (blow-up, full disk): exit status 1
};

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

/// Throws an input Error at `where` unless `holds`.
template <class... Values>
void require(bool holds, const SourceLocation& where, std::string_view pattern, const Values&... values) {
    if (!holds) fail_input(where, pattern, values...);
}

}  // namespace drover
