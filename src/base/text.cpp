// base/text.cpp: formatting by fmt, nearest names, sizes and durations.
#include "drover/base/text.hpp"

#include <fmt/args.h>
#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <cstring>

namespace drover {

std::string format_text(std::string_view pattern, std::span<const TextArgument> arguments) {
    fmt::dynamic_format_arg_store<fmt::format_context> store;
    for (const TextArgument& argument : arguments)
        std::visit([&](const auto& value) { store.push_back(value); }, argument.held());
    return fmt::vformat(fmt::string_view(pattern.data(), pattern.size()), store);
}

namespace {
/// Damerau-Levenshtein distance (restricted): insertions, deletions, substitutions and transpositions of neighbours.
std::size_t edit_distance(std::string_view a, std::string_view b) {
    std::vector<std::vector<std::size_t>> edits(a.size() + 1, std::vector<std::size_t>(b.size() + 1));
    for (std::size_t i = 0; i <= a.size(); ++i)
        for (std::size_t j = 0; j <= b.size(); ++j) {
            if (i == 0 || j == 0) {
                edits[i][j] = i + j;
                continue;
            }
            const std::size_t replaced = edits[i - 1][j - 1] + (a[i - 1] == b[j - 1] ? 0 : 1);
            edits[i][j] = std::min({edits[i - 1][j] + 1, edits[i][j - 1] + 1, replaced});
            if (i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1])
                edits[i][j] = std::min(edits[i][j], edits[i - 2][j - 2] + 1);
        }
    return edits[a.size()][b.size()];
}

bool is_same_but_case(std::string_view a, std::string_view b) {
    return std::equal(a.begin(), a.end(), b.begin(), b.end(),
                      [](unsigned char x, unsigned char y) { return std::tolower(x) == std::tolower(y); });
}

/// Bytes of the character at the start of a text; 0 when it is a control character or not UTF-8.
std::size_t printable_bytes(std::string_view words) {
    const auto byte = [&](std::size_t i) { return static_cast<unsigned char>(words[i]); };
    if (byte(0) < 0x80) return byte(0) == '\n' || byte(0) == '\t' || (byte(0) >= 0x20 && byte(0) != 0x7f) ? 1 : 0;
    const std::size_t size = utf8_bytes(words);
    return size == 2 && byte(0) == 0xc2 && byte(1) < 0xa0 ? 0 : size;  // U+0080 to U+009F control terminals, too
}
}  // namespace

std::string nearest_name(std::string_view name, std::span<const std::string> known) {
    constexpr std::size_t max_length = 200;  // no name is longer; the distance takes time and memory
    std::string nearest;
    if (name.size() > max_length) return nearest;
    std::size_t smallest = name.size() / 3 + 1;
    for (const std::string& candidate : known) {
        // Any letter is one edit from another: short names differ in case alone.
        const std::size_t distance = is_same_but_case(name, candidate) ? 0 : edit_distance(name, candidate);
        if (distance < smallest) {
            smallest = distance;
            nearest = candidate;
        }
    }
    return nearest;
}

std::string suggestion(std::string_view name, std::span<const std::string> known, std::string_view otherwise,
                       std::string_view question) {
    const std::string nearest = nearest_name(name, known);
    return nearest.empty() ? std::string(otherwise) : text(question, nearest);
}

std::string trimmed(std::string words) {
    words.erase(0, words.find_first_not_of(" \t"));
    words.erase(words.find_last_not_of(" \t") + 1);
    return words;
}

std::string joined(std::span<const std::string> items, std::string_view separator) {
    std::string result;
    for (const std::string& item : items) {
        if (!result.empty()) result += separator;
        result += item;
    }
    return result;
}

std::string words_of(std::string name) {
    std::ranges::replace(name, '_', ' ');
    return name;
}

std::size_t utf8_bytes(std::string_view words) {
    const auto byte = [&](std::size_t i) { return static_cast<unsigned char>(words[i]); };
    if (byte(0) < 0x80) return 1;
    const std::size_t size = byte(0) >= 0xf0 ? 4 : byte(0) >= 0xe0 ? 3 : 2;
    if (byte(0) < 0xc2 || byte(0) > 0xf4 || words.size() < size) return 0;
    for (std::size_t i = 1; i < size; ++i)
        if ((byte(i) & 0xc0) != 0x80) return 0;
    const bool is_overlong = (byte(0) == 0xe0 && byte(1) < 0xa0) || (byte(0) == 0xf0 && byte(1) < 0x90);
    const bool is_surrogate = byte(0) == 0xed && byte(1) >= 0xa0;
    const bool is_beyond_unicode = byte(0) == 0xf4 && byte(1) >= 0x90;
    return is_overlong || is_surrogate || is_beyond_unicode ? 0 : size;
}

std::string printable(std::string_view words) {
    std::string result;
    for (std::size_t at = 0; at < words.size();) {
        const std::size_t size = printable_bytes(words.substr(at));
        if (size == 0) result += text("\\x{:02x}", static_cast<unsigned char>(words[at]));
        else result += words.substr(at, size);
        at += std::max<std::size_t>(1, size);
    }
    return result;
}

std::string shell_word(const std::string& word) {
    const auto is_plain = [](char letter) {
        return std::isalnum(static_cast<unsigned char>(letter)) != 0 || std::strchr("%+,-./:=@_", letter) != nullptr;
    };
    if (!word.empty() && std::ranges::all_of(word, is_plain)) return word;
    std::string quoted = "'";
    for (const char letter : word) quoted += letter == '\'' ? "'\\''" : std::string(1, letter);
    return quoted + "'";
}

std::string measured_text(double value, double error) {
    constexpr int max_digits = 6;
    if (!std::isfinite(value) || !(error > 0.0) || !std::isfinite(error)) return text("{:.6g}", value);
    // The error as it is printed decides: 0.0996 is 0.1, whose second digit is that of hundredths.
    const int last_of_error = static_cast<int>(std::floor(std::log10(error * (1.0 + 1e-12)))) - 1;
    const int first = value == 0.0 ? last_of_error : static_cast<int>(std::floor(std::log10(std::abs(value))));
    const int last = std::max(last_of_error, first - max_digits + 1);
    const double unit = std::pow(10.0, last);
    const double rounded = std::round(value / unit) * unit;
    const bool is_plain = first < max_digits && first > -5;
    if (is_plain) return text("{:." + std::to_string(std::max(0, -last)) + "f}", rounded);
    return text("{:." + std::to_string(std::max(0, first - last)) + "e}", rounded);
}

std::string measured_text_with_error(double value, double error) {
    return text("{} +- {:.2g}", measured_text(value, error), error);
}

std::string bytes_text(double bytes) {
    static constexpr std::array units{"B", "kB", "MB", "GB", "TB", "PB"};
    std::size_t unit = 0;
    while (bytes >= 1000.0 && unit + 1 < units.size()) {
        bytes /= 1000.0;
        ++unit;
    }
    return unit == 0 ? text("{:.0f} B", bytes) : text("{:.3g} {}", bytes, units[unit]);
}

std::string duration_text(double seconds) {
    if (!(seconds < 60.0)) {
        if (!std::isfinite(seconds)) return "unknown time";
        const double minutes = std::floor(seconds / 60.0);
        if (minutes < 60.0) return text("{:.0f} min {:02.0f} s", minutes, std::floor(seconds - 60.0 * minutes));
        const double hours = std::floor(minutes / 60.0);
        return text("{:.0f} h {:02.0f} min", hours, minutes - 60.0 * hours);
    }
    return text("{:.3g} s", seconds);
}

}  // namespace drover
