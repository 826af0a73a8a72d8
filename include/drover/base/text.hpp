// base/text.hpp: formatting with type-erased arguments, so that headers need no formatting library, and enums that have
// names.
#pragma once
#include <array>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>
#include <variant>
#include <vector>

namespace drover {

/// An enum whose values have names in scenes, results and messages.  They stand beside it, in the order of its values:
/// `constexpr auto names_of(Enum) { return std::array{"first", "second"}; }`.
template <class Enum>
concept NamedEnum = std::is_enum_v<Enum> && requires(Enum value) {
    names_of(value).size();
};

template <NamedEnum Enum>
constexpr const char* name_of(Enum value) {
    return names_of(value).at(static_cast<std::size_t>(value));
}

/// One value to be formatted.  Numbers are written so that they read back as the same number.
class TextArgument {
public:
    using Held = std::variant<bool, std::int64_t, std::uint64_t, double, std::string_view>;
    TextArgument(bool value) : held_(value) {}
    TextArgument(const char& value) : held_(std::string_view(&value, 1)) {}  ///< a character, not its code
    TextArgument(std::signed_integral auto value) : held_(static_cast<std::int64_t>(value)) {}
    TextArgument(std::unsigned_integral auto value) : held_(static_cast<std::uint64_t>(value)) {}
    TextArgument(double value) : held_(value) {}
    TextArgument(const std::string& value) : held_(std::string_view(value)) {}
    TextArgument(std::string_view value) : held_(value) {}
    TextArgument(const char* value) : held_(std::string_view(value)) {}
    TextArgument(NamedEnum auto value) : held_(std::string_view(name_of(value))) {}
    const Held& held() const { return held_; }

private:
    Held held_;
};

/// `pattern` with each {} replaced by the next argument; a field may contain a format, {:.3g}, in the syntax of Python
/// and fmt.  Throws std::runtime_error for too few arguments or a format that does not suit one.
std::string format_text(std::string_view pattern, std::span<const TextArgument> arguments);

template <class... Values>
std::string text(std::string_view pattern, const Values&... values) {
    const std::array<TextArgument, sizeof...(Values) + 1> arguments{TextArgument(values)..., TextArgument(false)};
    return format_text(pattern, std::span(arguments.data(), sizeof...(Values)));
}

/// The known name with the smallest edit distance to `name` (at most a third of its letters, case aside), or "":
/// for "did you mean".
std::string nearest_name(std::string_view name, std::span<const std::string> known);

/// What a message says after a name that is not known, "did you mean kappa?": `question` with the nearest known name in
/// place of {}, or `otherwise` where none is near.
std::string suggestion(std::string_view name, std::span<const std::string> known, std::string_view otherwise = "",
                       std::string_view question = "did you mean {}?");

/// The items joined by a separator: "a, b, c".
std::string joined(std::span<const std::string> items, std::string_view separator = ", ");

/// A name as words: with blanks for its underscores.
std::string words_of(std::string name);

/// Without blanks and tabs at both ends.
std::string trimmed(std::string words);

/// Bytes of the UTF-8 character at the start of a text that is not empty; 0 when it starts with none.
std::size_t utf8_bytes(std::string_view words);

/// A text without the control characters by which a file could command the terminal: "\\x1b[2J".  Keeps line ends,
/// tabs and UTF-8.
std::string printable(std::string_view words);

/// A word as the shell reads it back: in quotes where it needs them.
std::string shell_word(const std::string& word);

/// A measured number to the digits that its standard error supports, two of the error: 15.8912 with 0.079 is "15.891",
/// 1234.4 with 56 is "1234", with 560 "1230".  At most six digits; an error of 0, or no number, gives six.
std::string measured_text(double value, double error);

/// The same with its error: "15.891 +- 0.079".
std::string measured_text_with_error(double value, double error);

/// A number of bytes: "3.2 MB".
std::string bytes_text(double bytes);

/// A duration given in seconds: "2 h 05 min", "3.1 s".
std::string duration_text(double seconds);

}  // namespace drover
