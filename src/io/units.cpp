// io/units.cpp: names of units.
#include "io/units.hpp"

#include <algorithm>
#include <array>
#include <utility>

namespace drover::io {

namespace {
bool is_letter(char c) { return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '_'; }

/// The end of an exponent, "2", "-2" or "^-2", that begins at `at`.
std::size_t exponent_end(const std::string& unit, std::size_t at) {
    std::size_t end = at;
    if (end < unit.size() && unit[end] == '^') ++end;
    if (end < unit.size() && unit[end] == '-') ++end;
    const std::size_t digits = end;
    while (end < unit.size() && unit[end] >= '0' && unit[end] <= '9') ++end;
    return end > digits ? end : at;
}

/// Without empty brackets, blanks at the ends or twice, and a slash before nothing; "1" for nothing.
std::string tidied(std::string unit) {
    for (std::size_t at = 0; (at = unit.find("()")) != std::string::npos;)
        unit.erase(at, exponent_end(unit, at + 2) - at);
    while (unit.find("  ") != std::string::npos) unit.erase(unit.find("  "), 1);
    for (const auto& [from, to] : {std::pair{"( ", "("}, std::pair{" )", ")"}})
        while (unit.find(from) != std::string::npos) unit.replace(unit.find(from), 2, to);
    for (const auto& [from, to] : {std::pair{"(/", "(1/"}, std::pair{"/)", ")"}})
        while (unit.find(from) != std::string::npos) unit.replace(unit.find(from), 2, to);
    if (unit.starts_with('/')) unit.insert(0, "1");
    while (!unit.empty() && (unit.back() == ' ' || unit.back() == '/')) unit.pop_back();
    unit.erase(0, std::min(unit.find_first_not_of(' '), unit.size()));
    return unit.empty() ? "1" : unit;
}
}  // namespace

std::string renamed(const std::string& unit, const Units& units) {
    const std::array names{std::pair<std::string, const std::string&>{"mm", units.length},
                           std::pair<std::string, const std::string&>{"s", units.time},
                           std::pair<std::string, const std::string&>{"mg", units.mass}};
    if (std::all_of(names.begin(), names.end(), [](const auto& name) { return name.first == name.second; }))
        return unit;
    if (unit.empty()) return unit;
    std::string result;
    for (std::size_t at = 0; at < unit.size();) {
        if (!is_letter(unit[at])) {
            result += unit[at++];
            continue;
        }
        std::size_t end = at;
        while (end < unit.size() && is_letter(unit[end])) ++end;
        const std::string word = unit.substr(at, end - at);
        const auto found =
            std::find_if(names.begin(), names.end(), [&](const auto& name) { return name.first == word; });
        const std::size_t past = exponent_end(unit, end);
        if (found == names.end()) result += unit.substr(at, past - at);
        else if (found->second != "none") result += found->second + unit.substr(end, past - end);
        at = past;
    }
    return tidied(std::move(result));
}

std::string in_unit(const char* format, double value, const char* unit, const Units& units) {
    const std::string name = renamed(unit, units);
    return text(format, value) + (name == "1" ? "" : " " + (name.starts_with("1/") ? name.substr(1) : name));
}

}  // namespace drover::io
