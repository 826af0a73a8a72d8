// base/expression_parse.cpp: a recursive-descent parser of expressions.
#include <cctype>
#include <charconv>
#include <numbers>

#include "base/expression_graph.hpp"

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
    Parser(const std::string& written, const Vocabulary& vocabulary, const SourceLocation& where)
        : text_(written), vocabulary_(vocabulary), where_(where), graph_(Folding::exact) {}

    Expression parse() {
        require(text_.size() <= max_characters, where_, "the expression \"{}\" has {} characters; expected at most {}",
                excerpt(text_, 0), text_.size(), max_characters);
        const int root = sum();
        if (next() != '\0' || at_ < text_.size()) fail("an operator, or the end");
        return graph_.expression(root);
    }

private:
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
    void expect(char wanted) {
        if (!take(wanted)) fail(text("\"{}\"", wanted));
    }
    SourceLocation location(std::size_t at) const {
        SourceLocation place = where_;
        if (place.column > 0) place.column += static_cast<int>(at);
        return place;
    }
    /// Throws for what is found here.
    [[noreturn]] void fail(const std::string& expected) {
        next();
        std::size_t length = 1;  // a name or number is quoted to its end
        if (at_ < text_.size() && continues_name(text_[at_]))
            while (length < 40 && at_ + length < text_.size() && continues_name(text_[at_ + length])) ++length;
        const std::string found = at_ >= text_.size() ? "its end" : text("\"{}\"", part(text_, at_, at_ + length));
        fail_input(location(at_), "the expression \"{}\" has {} at character {}; expected {}", excerpt(text_, at_),
                   found, at_ + 1, expected);
    }
    int make(std::size_t at, Operation operation, int left, int right = -1) {
        graph_.where = location(at);
        return graph_.make(operation, left, right);
    }

    int sum() {
        int left = product();
        for (;;) {
            next();
            const std::size_t at = at_;
            if (take('+')) left = make(at, Operation::add, left, product());
            else if (take('-')) left = make(at, Operation::subtract, left, product());
            else return left;
        }
    }
    int product() {
        int left = signed_power();
        for (;;) {
            const char letter = next();
            const std::size_t at = at_;
            if (take('*') || letter == '(' || starts_name(letter))
                left = make(at, Operation::multiply, left, signed_power());
            else if (take('/')) left = make(at, Operation::divide, left, signed_power());
            else return left;
        }
    }
    int signed_power() {
        next();
        const std::size_t at = at_;
        if (take('-')) {
            const Nesting nesting(*this);
            return make(at, Operation::negate, signed_power());
        }
        if (take('+')) {
            const Nesting nesting(*this);
            return signed_power();
        }
        const int base = atom();
        next();
        const std::size_t power_at = at_;
        if (!take('^')) return base;
        const Nesting nesting(*this);
        return make(power_at, Operation::power, base, signed_power());
    }
    int atom() {
        const char letter = next();
        if (take('(')) {
            const Nesting nesting(*this);
            const int inner = sum();
            expect(')');
            return inner;
        }
        if (std::isdigit(static_cast<unsigned char>(letter)) || letter == '.') return number();
        if (starts_name(letter)) return named();
        fail("a number, a name, a function or \"(\"");
    }
    int number() {
        double value = 0.0;
        const auto [end, error] = std::from_chars(text_.data() + at_, text_.data() + text_.size(), value);
        if (error == std::errc::result_out_of_range) fail("a number between 1e-307 and 1e308 in size");
        if (error != std::errc()) fail("a number");
        at_ = static_cast<std::size_t>(end - text_.data());
        graph_.where = where_;
        return graph_.number(value);
    }
    std::string word() {
        next();
        const std::size_t begin = at_;
        while (at_ < text_.size() && continues_name(text_[at_])) ++at_;
        return text_.substr(begin, at_ - begin);
    }

    int named() {
        const std::size_t begin = at_;
        const std::string name = word();
        const bool is_call = next() == '(';
        for (const FunctionName& function : function_names)
            if (is_call && name == function.name) return call(begin, function);
        graph_.where = location(begin);
        if (const auto found = vocabulary_.operators.find(name); found != vocabulary_.operators.end())
            return operation_on_name(*found);
        if (const auto found = vocabulary_.variables.find(name); found != vocabulary_.variables.end())
            return graph_.slot(found->second, name);
        if (const auto found = vocabulary_.constants.find(name); found != vocabulary_.constants.end())
            return graph_.number(found->second);
        if (name == "pi") return graph_.number(std::numbers::pi);
        for (const FunctionName& function : function_names)
            if (name == function.name) fail(text("\"(\" after the function {}", name));
        at_ = begin;
        fail(name_expected(name));
    }
    int call(std::size_t begin, const FunctionName& function) {
        const Nesting nesting(*this);
        expect('(');
        const int first = sum();
        int second = -1;
        if (function.arguments == 2) {
            if (!take(',')) fail(text("\",\" and a second argument of {}", function.name));
            second = sum();
        }
        if (!take(')')) fail(text("\")\" after the {} of {}", second < 0 ? "argument" : "arguments", function.name));
        return make(begin, function.operation, first, second);
    }
    int operation_on_name(const std::pair<const std::string, Vocabulary::Slots>& operation) {
        const auto& [name, operands] = operation;
        const bool in_parentheses = take('(');
        next();
        const std::size_t begin = at_;
        const std::string operand = starts_name(next()) ? word() : "";
        const auto found = operands.find(operand);
        if (found == operands.end()) {
            at_ = begin;
            std::vector<std::string> names;
            for (const auto& [known, slot] : operands) names.push_back(known);
            const std::string near = nearest_name(operand, names);
            fail(text("the operand of {}: one of {}{}", name, joined(names),
                      near.empty() ? "" : text(" (did you mean {}?)", near)));
        }
        if (in_parentheses) expect(')');
        else if (next() == '^')
            fail(text("parentheses that show what the power applies to: ({} {})^...", name, operand));
        return graph_.slot(found->second, text("{}({})", name, operand));
    }
    std::string name_expected(const std::string& name) const {
        std::vector<std::string> names, functions;
        for (const auto& [known, slot] : vocabulary_.variables) names.push_back(known);
        for (const auto& [known, value] : vocabulary_.constants) names.push_back(known);
        names.emplace_back("pi");
        for (const auto& [known, operands] : vocabulary_.operators) names.push_back(known);
        for (const FunctionName& function : function_names) functions.emplace_back(function.name);
        std::vector<std::string> all = names;
        all.insert(all.end(), functions.begin(), functions.end());
        const std::string near = name.size() < 3 ? "" : nearest_name(name, all);  // any letter is near another
        return text("{}one of {}, or a function: {}", near.empty() ? "" : text("{} (did you mean that?), ", near),
                    joined(names), joined(functions));
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

    const std::string& text_;
    const Vocabulary& vocabulary_;
    const SourceLocation& where_;
    GraphBuilder graph_;
    std::size_t at_ = 0;
    int depth_ = 0;
};
}  // namespace

Expression parse_expression(const std::string& text, const Vocabulary& vocabulary, const SourceLocation& where) {
    return Parser(text, vocabulary, where).parse();
}

}  // namespace drover
