// run/number_lists.cpp: reading keys with numbers.
#include "run/number_lists.hpp"

#include <cmath>
#include <cstdlib>
#include <limits>
#include <sstream>

namespace drover::run {

Assignment read_assignment(const std::string& written, const std::string& list, const std::string& example,
                           const SourceLocation& where) {
    const std::size_t equals = written.find('=');
    require(equals != std::string::npos && !trimmed(written.substr(0, equals)).empty(), where,
            "{} has \"{}\"; expected a name, = and numbers, as in {}", list, written, example);
    return {.key = trimmed(written.substr(0, equals)), .value = trimmed(written.substr(equals + 1))};
}

std::vector<std::string> split(const std::string& words, char separator) {
    std::vector<std::string> parts;
    std::istringstream stream(words);
    for (std::string part; std::getline(stream, part, separator);) parts.push_back(trimmed(part));
    return parts;
}

double read_number(const std::string& word, const std::string& written, const std::string& list,
                   const std::string& example, const SourceLocation& where) {
    char* end = nullptr;
    const double value = std::strtod(word.c_str(), &end);
    require(!word.empty() && *end == '\0' && std::isfinite(value), where,
            "{} has \"{}\" in \"{}\"; expected numbers, as in {}", list, word, written, example);
    return value;
}

double between(double first, double last, double i, double n) {
    const double value = first + (last - first) * i / n;
    return std::abs(value) < 4.0 * std::numeric_limits<double>::epsilon() * std::abs(last - first) ? 0.0 : value;
}

double rounded(double value) { return std::strtod(text("{:.15g}", value).c_str(), nullptr); }

}  // namespace drover::run
