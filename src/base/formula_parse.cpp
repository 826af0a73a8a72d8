// base/formula_parse.cpp: a recursive-descent parser of formulas.
#include <algorithm>
#include <cctype>
#include <charconv>
#include <utility>

#include "base/formula.hpp"

namespace drover {

namespace {
constexpr std::size_t max_characters = 10000;
constexpr int max_nesting = 200;

bool starts_name(char letter) { return std::isalpha(static_cast<unsigned char>(letter)) || letter == '_'; }
bool continues_name(char letter) { return std::isalnum(static_cast<unsigned char>(letter)) || letter == '_'; }

/// Characters [begin, end) of a text, in one line; the ends move to the ends of UTF-8 characters.
std::string part(const std::string& text, std::size_t begin, std::size_t end) {
    const auto is_inside_letter = [&](std::size_t i) {
        return i < text.size() && (static_cast<unsigned char>(text[i]) & 0xC0u) == 0x80u;
    };
    while (begin < end && is_inside_letter(begin)) ++begin;
    while (is_inside_letter(end)) ++end;
    std::string result = text.substr(begin, end - begin);
    for (char& letter : result)
        if (std::iscntrl(static_cast<unsigned char>(letter))) letter = ' ';
    return result;
}

/// The text, or its part around a character if it is long.
std::string excerpt(const std::string& text, std::size_t at) {
    constexpr std::size_t around = 40;
    const std::size_t begin = at > around ? at - around : 0, end = std::min(text.size(), at + around);
    return (begin > 0 ? "..." : "") + part(text, begin, end) + (end < text.size() ? "..." : "");
}

class Parser {
public:
    Parser(const FormulaText& the_text, const Notation& notation)
        : source_(the_text), text_(the_text.text()), notation_(notation) {}

    Formula parse() {
        require(text_.size() <= max_characters, source_.location(0),
                "the expression \"{}\" has {} characters; expected at most {}", excerpt(text_, 0), text_.size(),
                max_characters);
        Formula root = sum();
        if (next() != '\0' || at_ < text_.size()) fail("an operator, or the end");
        return root;
    }

private:
    using Kind = Formula::Kind;

    /// The next character that is not white space; '\0' at the end.
    char next() {
        while (at_ < text_.size() && std::isspace(static_cast<unsigned char>(text_[at_]))) ++at_;
        return at_ < text_.size() ? text_[at_] : '\0';
    }
    bool take(char wanted) {
        if (next() != wanted || at_ == text_.size()) return false;
        ++at_;
        return true;
    }
    [[noreturn]] void fail(const std::string& expected) {
        next();
        const bool is_nabla = text_.compare(at_, std::string_view("∇").size(), "∇") == 0;
        source_.fail(at_, is_nabla ? "a word for this operator, as in grad u, div p, curl p or lap u" : expected);
    }

    /// Parts separated by signs; a single part is returned as it is.
    template <class Part, class NextSign>
    Formula parts(Kind kind, char first, Part part, NextSign next_sign) {
        next();
        Formula result{.kind = kind, .at = at_};
        std::size_t sign_at = at_;
        for (char sign = first; sign != '\0'; sign = next_sign(sign_at)) {
            result.arguments.push_back(part());
            result.arguments.back().sign = sign;
            result.arguments.back().sign_at = sign_at;
        }
        return result.arguments.size() == 1 ? std::move(result.arguments.front()) : std::move(result);
    }
    Formula sum() {
        return parts(
            Kind::sum, '+', [this] { return product(); },
            [this](std::size_t& sign_at) {
                const char sign = next();
                sign_at = at_;
                return take('+') || take('-') ? sign : '\0';
            });
    }
    Formula product() {
        return parts(
            Kind::product, '*', [this] { return signed_chain(); },
            [this](std::size_t& sign_at) {
                const char sign = next();
                sign_at = at_;
                if (take('*') || take('/')) return sign;
                return sign == '(' || starts_name(sign) || (sign == '|' && !in_norm_) ? '*' : '\0';
            });
    }
    Formula signed_chain() {
        next();
        const std::size_t at = at_;
        const bool is_negative = take('-');
        if (!is_negative && !take('+')) return chain();
        const Nesting nesting(*this);
        return is_negative ? one(Kind::negative, at, signed_chain()) : signed_chain();
    }
    bool at_dot() { return next() == '.' || next() == ':'; }

    Formula chain() {
        Formula left = link();
        const bool starts_with_operator = left.kind == Kind::operation && !operand_in_parentheses_;
        if (starts_with_operator) return left;  // it took the whole chain
        while (at_dot()) {
            const std::size_t at = at_;
            const Kind kind = text_[at_++] == '.' ? Kind::dot : Kind::double_dot;
            in_chain_ = true;
            Formula right = link();
            in_chain_ = false;
            if (at_dot() && right.kind == Kind::operation && !operand_in_parentheses_)
                fail(text("parentheses that show what {} applies to", right.name));
            left = {.kind = kind, .arguments = {std::move(left), std::move(right)}, .at = at};
        }
        return left;
    }
    Formula link() {
        next();
        const std::size_t begin = at_;
        if (starts_name(next())) {
            const std::string name = word();
            if (notation_.is_operator(name)) return operation(begin, name);
            at_ = begin;
        }
        Formula result = power();
        operand_in_parentheses_ = true;  // of "(div Q)", which ends the operand
        return result;
    }
    Formula operation(std::size_t begin, const std::string& name) {
        const Nesting nesting(*this);
        if (next() == '(') {
            Formula result = one(Kind::operation, begin, atom());
            result.name = name;
            operand_in_parentheses_ = true;
            return raised(std::move(result));
        }
        const bool is_link = in_chain_;  // so is an operator that it applies to
        if (!starts_operand(next())) fail(text("the operand of {}", name));
        Formula operand = is_link ? link() : chain();
        if (operand.kind == Kind::power)
            source_.fail(operand.at, text("parentheses that show what the power applies to: ({} {})^...", name,
                                          operand.arguments[0].name));
        Formula result = one(Kind::operation, begin, std::move(operand));
        result.name = name;
        operand_in_parentheses_ = false;
        return result;
    }
    static bool starts_operand(char letter) {
        return starts_name(letter) || letter == '|' || std::isdigit(static_cast<unsigned char>(letter));
    }

    Formula power() { return raised(atom()); }
    Formula raised(Formula base) {
        next();
        const std::size_t at = at_;
        if (!take('^')) return base;
        const Nesting nesting(*this);
        return {.kind = Kind::power, .arguments = {std::move(base), exponent()}, .at = at};
    }
    Formula exponent() {
        next();
        const std::size_t at = at_;
        const Nesting nesting(*this);
        if (take('-')) return one(Kind::negative, at, exponent());
        return take('+') ? exponent() : power();
    }
    Formula atom() {
        const char letter = next();
        const std::size_t begin = at_;
        if (letter == '(' || (letter == '|' && !in_norm_)) {
            const Nesting nesting(*this);
            const bool outside = std::exchange(in_norm_, letter == '|');
            const bool in_chain = std::exchange(in_chain_, false);
            ++at_;
            Formula inner = sum();
            if (!take(letter == '(' ? ')' : '|')) fail(letter == '(' ? "\")\"" : "\"|\" that ends the norm");
            in_norm_ = outside;
            in_chain_ = in_chain;
            return letter == '(' ? std::move(inner) : one(Kind::norm, begin, std::move(inner));
        }
        if (std::isdigit(static_cast<unsigned char>(letter)) || letter == '.') return number();
        if (starts_name(letter)) return named();
        if (letter == '*' && at_ > 0 && text_[at_ - 1] == '*') fail("a factor; a power is written with ^, as in u^2");
        fail("a number, a name, a function or \"(\"");
    }
    Formula number() {
        Formula result{.kind = Kind::number, .at = at_};
        const auto [end, error] = std::from_chars(text_.data() + at_, text_.data() + text_.size(), result.value);
        if (error == std::errc::result_out_of_range) fail("a number between 1e-307 and 1e308 in size");
        if (error != std::errc()) fail("a number");
        at_ = static_cast<std::size_t>(end - text_.data());
        return result;
    }
    std::string word() {
        next();
        const std::size_t begin = at_;
        while (at_ < text_.size() && continues_name(text_[at_])) ++at_;
        return text_.substr(begin, at_ - begin);
    }
    Formula named() {
        Formula result{.kind = Kind::name, .at = at_};
        result.name = word();
        const int count = notation_.arguments_of(result.name);
        if (count == 0) return result;
        if (next() != '(') fail(text("\"(\" after the function {}", result.name));
        const Nesting nesting(*this);
        const bool outside = std::exchange(in_norm_, false), in_chain = std::exchange(in_chain_, false);
        result.kind = Kind::call;
        ++at_;
        for (int i = 0; i < count; ++i) {
            if (i > 0 && !take(',')) fail(text("\",\" and a second argument of {}", result.name));
            result.arguments.push_back(sum());
        }
        if (!take(')')) fail(text("\")\" after the argument{} of {}", count == 1 ? "" : "s", result.name));
        in_norm_ = outside;
        in_chain_ = in_chain;
        return result;
    }
    static Formula one(Kind kind, std::size_t at, Formula argument) {
        Formula result{.kind = kind, .at = at};
        result.arguments.push_back(std::move(argument));
        return result;
    }

    /// Limits the recursion: a text can nest deeper than the stack allows.
    struct Nesting {
        explicit Nesting(Parser& the_parser) : parser(the_parser) {
            if (++parser.depth_ > max_nesting) parser.fail(text("at most {} levels of nesting", max_nesting));
        }
        ~Nesting() { --parser.depth_; }
        Nesting(const Nesting&) = delete;
        Nesting& operator=(const Nesting&) = delete;
        Parser& parser;
    };

    const FormulaText& source_;
    const std::string& text_;
    const Notation& notation_;
    std::size_t at_ = 0;
    int depth_ = 0;
    bool in_norm_ = false, in_chain_ = false, operand_in_parentheses_ = false;
};
}  // namespace

SourceLocation FormulaText::location(std::size_t at) const {
    SourceLocation place = where_;
    if (place.column > 0) place.column += static_cast<int>(at);
    return place;
}

void FormulaText::fail(std::size_t at, const std::string& expected) const {
    std::size_t length = 1;  // a name or number is quoted to its end
    if (at < text_.size() && continues_name(text_[at]))
        while (length < 40 && at + length < text_.size() && continues_name(text_[at + length])) ++length;
    const std::string found = at >= text_.size() ? "its end" : drover::text("\"{}\"", part(text_, at, at + length));
    fail_input(location(at), "the expression \"{}\" has {} at character {}; expected {}", excerpt(text_, at), found,
               at + 1, expected);
}

void FormulaText::fail_with(std::size_t at, const std::string& message) const {
    fail_input(location(at), "the expression \"{}\" at character {}: {}", excerpt(text_, at), at + 1, message);
}

Formula parse_formula(const FormulaText& text, const Notation& notation) { return Parser(text, notation).parse(); }

}  // namespace drover
