// run/number_lists.hpp: "section.key = numbers", the text of sweeps and boundaries.
#pragma once
#include <string>
#include <vector>

#include "drover/base/error.hpp"

namespace drover::run {

struct Assignment {
    std::string key, value;
};

/// Splits "key = value", an element of the scene's key `list`; messages quote `example`.  Throws an input Error at
/// `where`.
Assignment read_assignment(const std::string& written, const std::string& list, const std::string& example,
                           const SourceLocation& where);

/// "1, 2, 3" or "0.5:2" by its separator, without spaces.
std::vector<std::string> split(const std::string& words, char separator);

/// A finite number.  Throws an input Error that names the word.
double read_number(const std::string& word, const std::string& written, const std::string& list,
                   const std::string& example, const SourceLocation& where);

/// The value after i of n equal steps: 0 where nothing but a rounding error is left.
double between(double first, double last, double i, double n);

/// To 15 digits: 0.1 + 0.2 is 0.3, and the same value however many others are between two ends.
double rounded(double value);

}  // namespace drover::run
