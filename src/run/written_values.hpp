// run/written_values.hpp: "section.key = numbers", as sweeps and boundaries have them.
#pragma once
#include <string>
#include <vector>

#include "drover/base/error.hpp"

namespace drover::run {

/// A key and what stands behind its equals sign.
struct Written {
    std::string key, value;
};

/// Splits "key = value" of the scene's key `list`; `example` says what was expected.  Throws an input Error at `where`.
Written read_written(const std::string& written, const std::string& list, const std::string& example,
                     const SourceLocation& where);

/// "1, 2, 3" or "0.5:2" by its separator.
std::vector<std::string> split(const std::string& words, char separator);

/// A finite number.  Throws an input Error that names the word.
double read_number(const std::string& word, const std::string& written, const std::string& list,
                   const std::string& example, const SourceLocation& where);

}  // namespace drover::run
