// io/units.cpp: names of units.
#include "io/units.hpp"

#include <algorithm>
#include <array>
#include <utility>
#include <vector>

namespace drover::io {

namespace {
bool is_letter(char c) { return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '_' || c == '%'; }

/// The end of an exponent, "2", "-2" or "^-2", that begins at `at`.
std::size_t exponent_end(const std::string& unit, std::size_t at) {
    std::size_t end = at;
    if (end < unit.size() && unit[end] == '^') ++end;
    if (end < unit.size() && unit[end] == '-') ++end;
    const std::size_t digits = end;
    while (end < unit.size() && unit[end] >= '0' && unit[end] <= '9') ++end;
    return end > digits ? end : at;
}

/// The end of a word, "mm" or "[p]", that begins at `at`; `at` where there is none.
std::size_t word_end(const std::string& unit, std::size_t at) {
    if (unit[at] == '[') return std::min(unit.find(']', at), unit.size() - 1) + 1;
    std::size_t end = at;
    while (end < unit.size() && is_letter(unit[end])) ++end;
    return end;
}

/// A product of powers of words, as "(mg/mm)^2 1/s".
class Product {
public:
    explicit Product(const std::string& unit) : unit_(unit) { is_valid_ = add_all(1) && at_ == unit_.size(); }
    bool is_valid() const { return is_valid_; }
    int& power_of(const std::string& word) {
        for (auto& [base, power] : powers_)
            if (base == word) return power;
        return powers_.emplace_back(word, 0).second;
    }
    /// "mg2 mm-2 s-1"; "1" for nothing.
    std::string written() const {
        std::string result;
        for (const auto& [base, power] : powers_)
            if (power != 0) result += (result.empty() ? "" : " ") + base + (power == 1 ? "" : std::to_string(power));
        return result.empty() ? "1" : result;
    }

private:
    int take_power() {
        const std::size_t end = exponent_end(unit_, at_);
        std::string digits = unit_.substr(at_, end - at_);
        if (digits.starts_with('^')) digits.erase(0, 1);
        at_ = end;
        return digits.empty() ? 1 : std::stoi(digits);
    }
    /// Until a closing bracket or the end; outer: the power of the whole.
    bool add_all(int outer) {
        for (int sign = outer; at_ < unit_.size() && unit_[at_] != ')';) {
            const char c = unit_[at_];
            if (c == ' ' || c == '*' || c == '.') {
                ++at_;
            } else if (c == '/') {
                sign = -outer;
                ++at_;
            } else if (c == '(') {
                std::vector<std::pair<std::string, int>> before = std::exchange(powers_, {});
                ++at_;
                if (!add_all(1) || at_ == unit_.size()) return false;
                ++at_;
                const int power = sign * take_power();
                const auto inside = std::exchange(powers_, std::move(before));
                for (const auto& [base, count] : inside) power_of(base) += power * count;
                sign = outer;
            } else if (c == '1' && exponent_end(unit_, at_ + 1) == at_ + 1) {
                ++at_;
                sign = outer;
            } else if (const std::size_t end = word_end(unit_, at_); end > at_) {
                const std::string word = unit_.substr(at_, end - at_);
                at_ = end;
                power_of(word) += sign * take_power();
                sign = outer;
            } else {
                return false;
            }
        }
        return true;
    }

    const std::string& unit_;
    std::size_t at_ = 0;
    std::vector<std::pair<std::string, int>> powers_;  // as written
    bool is_valid_ = false;
};
}  // namespace

std::string renamed(const std::string& unit, const Units& units) {
    const std::array names{std::pair<std::string, const std::string&>{"mm", units.length},
                           std::pair<std::string, const std::string&>{"s", units.time},
                           std::pair<std::string, const std::string&>{"mg", units.mass}};
    if (std::ranges::all_of(names, [](const auto& name) { return name.first == name.second; })) return unit;
    std::string result;
    bool leaves_any = false;
    for (std::size_t at = 0; at < unit.size();) {
        const std::size_t end = word_end(unit, at);
        if (end == at) {
            result += unit[at++];
            continue;
        }
        const std::string word = unit.substr(at, end - at);
        const auto found = std::ranges::find_if(names, [&](const auto& name) { return name.first == word; });
        leaves_any = leaves_any || (found != names.end() && found->second == "none");
        result += found == names.end() ? word : found->second;
        at = end;
    }
    if (!leaves_any) return result;
    Product product(result);
    if (!product.is_valid()) return unit;  // no product of powers
    product.power_of("none") = 0;
    return product.written();
}

std::string in_unit(const char* format, double value, const std::string& unit, const Units& units) {
    const std::string name = renamed(unit, units);
    return text(format, value) + (name == "1" ? "" : " " + (name.starts_with("1/") ? name.substr(1) : name));
}

}  // namespace drover::io
