// base/error.hpp: the one exception of drover, with the place in the scene that it speaks of.
#pragma once
#include <functional>
#include <stdexcept>
#include <string>
#include <string_view>

#include "drover/base/text.hpp"

namespace drover {

/// A place in a text a person wrote.  line and column count from 1; 0: not known.
struct SourceLocation {
    std::string file;
    int line = 0;
    int column = 0;
};

/// "flock.toml:14:3", "flock.toml:14", "flock.toml", or "" when nothing is known.
std::string location_text(const SourceLocation& where);

/// Where a key of a scene, "grid.nx", was given: for checks that hold several keys against each other.
using LocationOf = std::function<SourceLocation(const std::string& key)>;
inline SourceLocation no_location(const std::string&) { return {}; }

/// Whose fault an error is: it decides the exit status of the program.
enum class Fault {
    input,  ///< the scene, the command line or a file given to us: exit status 2
    run     ///< a run that could not go on (blow-up, full disk): exit status 1
};

/// What went wrong, as one sentence that says where, what was found, what was expected and what to do.
class Error : public std::runtime_error {
public:
    Error(Fault fault, const SourceLocation& where, const std::string& message);
    Fault fault() const { return fault_; }

private:
    Fault fault_;
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
