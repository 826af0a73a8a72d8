// measure/unit_product.cpp: exponents of units add up.
#include "measure/unit_product.hpp"

#include <algorithm>
#include <cctype>
#include <sstream>
#include <utility>

namespace drover::measure {

namespace {
using Powers = std::vector<std::pair<std::string, int>>;

/// Adds those of "mm2 s-1"; returns whether the unit is a list of names and integer exponents.
bool add_powers(const std::string& unit, Powers& powers) {
    std::istringstream words(unit);
    for (std::string word; words >> word;) {
        if (word == "1") continue;
        const auto letters = static_cast<std::size_t>(
            std::ranges::find_if(word, [](unsigned char c) { return std::isalpha(c) == 0; }) - word.begin());
        const std::string name = word.substr(0, letters), exponent = word.substr(letters);
        const std::string digits = exponent.starts_with('-') ? exponent.substr(1) : exponent;
        constexpr std::size_t max_digits = 4;  // digits
        if (name.empty() || digits.size() > max_digits || (!exponent.empty() && digits.empty()) ||
            !std::ranges::all_of(digits, [](unsigned char c) { return std::isdigit(c) != 0; }))
            return false;
        auto found = std::ranges::find_if(powers, [&](const auto& one) { return one.first == name; });
        if (found == powers.end()) found = powers.insert(found, {name, 0});
        found->second += exponent.empty() ? 1 : std::stoi(exponent);
    }
    return true;
}

std::string in_brackets(const std::vector<std::string>& units) {
    std::string product;
    for (std::size_t n = 0; n < units.size(); ++n) {
        if (units[n] == "1") continue;
        const bool is_square = n + 1 < units.size() && units[n + 1] == units[n], is_last = n + 1 == units.size();
        if (!product.empty()) product += ' ';
        product += is_last && n > 1 ? units[n] : "(" + units[n] + ")" + (is_square ? "^2" : "");
        if (is_square) ++n;
    }
    return product;
}
}  // namespace

std::string unit_product(const std::vector<std::string>& units) {
    Powers powers;
    if (!std::ranges::all_of(units, [&](const std::string& unit) { return add_powers(unit, powers); }))
        return in_brackets(units);
    std::string product;
    for (const auto& [name, power] : powers)
        if (power != 0) product += (product.empty() ? "" : " ") + name + (power == 1 ? "" : std::to_string(power));
    return product.empty() ? "1" : product;
}

}  // namespace drover::measure
