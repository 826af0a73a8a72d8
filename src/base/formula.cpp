// base/formula.cpp: a parser by recursive descent.
#include "drover/base/formula.hpp"

#include <algorithm>
#include <array>
#include <cctype>
#include <charconv>
#include <cmath>
#include <functional>
#include <numbers>
#include <vector>

namespace drover {

struct Formula::Node {
    std::function<double(double x, double y)> value;
};

namespace {
using Value = std::function<double(double, double)>;

struct Function {
    const char* name;
    std::size_t arguments;
    double (*of)(double, double);
};
constexpr std::array functions{Function{"abs", 1, [](double a, double) { return std::abs(a); }},
                               Function{"cos", 1, [](double a, double) { return std::cos(a); }},
                               Function{"cosh", 1, [](double a, double) { return std::cosh(a); }},
                               Function{"exp", 1, [](double a, double) { return std::exp(a); }},
                               Function{"log", 1, [](double a, double) { return std::log(a); }},
                               Function{"max", 2, [](double a, double b) { return std::max(a, b); }},
                               Function{"min", 2, [](double a, double b) { return std::min(a, b); }},
                               Function{"sin", 1, [](double a, double) { return std::sin(a); }},
                               Function{"sinh", 1, [](double a, double) { return std::sinh(a); }},
                               Function{"sqrt", 1, [](double a, double) { return std::sqrt(a); }},
                               Function{"step", 1, [](double a, double) { return a > 0.0 ? 1.0 : 0.0; }},
                               Function{"tan", 1, [](double a, double) { return std::tan(a); }},
                               Function{"tanh", 1, [](double a, double) { return std::tanh(a); }}};

class Parser {
public:
    Parser(const std::string& written, const SourceLocation& where) : written_(written), where_(where) {}

    Value whole() {
        constexpr std::size_t most = 10000;  // every term of a long sum stands on the stack when it is taken
        require(written_.size() <= most, where_, "the formula \"{}...\" has {} characters; expected at most {}",
                written_.substr(0, 20), written_.size(), most);
        Value result = sum();
        if (skip() != '\0') refuse("an operator");
        return result;
    }

private:
    char skip() {
        while (at_ < written_.size() && std::isspace(static_cast<unsigned char>(written_[at_]))) ++at_;
        return at_ < written_.size() ? written_[at_] : '\0';
    }
    bool take(char wanted) {
        if (skip() != wanted) return false;
        ++at_;
        return true;
    }
    [[noreturn]] void refuse(const std::string& expected) {
        const std::string found = skip() == '\0' ? "its end" : text("\"{}\"", written_.substr(at_, 8));
        fail_input(where_, "the formula \"{}\" cannot be read at {} (character {}); expected {}", written_, found,
                   at_ + 1, expected);
    }
    void expect(char wanted) {
        if (!take(wanted)) refuse(text("\"{}\"", wanted));
    }

    Value sum() {
        const Nesting nesting(*this);
        Value left = product();
        for (;;) {
            if (take('+'))
                left = [a = std::move(left), b = product()](double x, double y) { return a(x, y) + b(x, y); };
            else if (take('-'))
                left = [a = std::move(left), b = product()](double x, double y) { return a(x, y) - b(x, y); };
            else return left;
        }
    }
    Value product() {
        Value left = signed_power();
        for (;;) {
            if (take('*'))
                left = [a = std::move(left), b = signed_power()](double x, double y) { return a(x, y) * b(x, y); };
            else if (take('/'))
                left = [a = std::move(left), b = signed_power()](double x, double y) { return a(x, y) / b(x, y); };
            else return left;
        }
    }
    Value signed_power() {
        const Nesting nesting(*this);
        if (take('-')) return [a = signed_power()](double x, double y) { return -a(x, y); };
        if (take('+')) return signed_power();
        Value base = atom();
        if (!take('^')) return base;
        return [a = std::move(base), b = signed_power()](double x, double y) { return std::pow(a(x, y), b(x, y)); };
    }
    Value atom() {
        if (take('(')) {
            Value inner = sum();
            expect(')');
            return inner;
        }
        const char next = skip();
        if (std::isdigit(static_cast<unsigned char>(next)) || next == '.') return number();
        if (std::isalpha(static_cast<unsigned char>(next))) return name();
        refuse("a number, x, y, pi, a function or \"(\"");
    }
    Value number() {
        double value = 0.0;
        const char* begin = written_.data() + at_;
        const auto [end, trouble] = std::from_chars(begin, written_.data() + written_.size(), value);
        if (trouble == std::errc::result_out_of_range) refuse("a number between 1e-307 and 1e308");
        if (trouble != std::errc()) refuse("a number");
        at_ += static_cast<std::size_t>(end - begin);
        return [value](double, double) { return value; };
    }
    Value name() {
        const std::size_t begin = at_;
        while (at_ < written_.size() && std::isalnum(static_cast<unsigned char>(written_[at_]))) ++at_;
        const std::string word = written_.substr(begin, at_ - begin);
        if (word == "x") return [](double x, double) { return x; };
        if (word == "y") return [](double, double y) { return y; };
        if (word == "pi") return [](double, double) { return std::numbers::pi; };
        std::vector<std::string> names{"x", "y", "pi"};
        for (const Function& function : functions) {
            names.emplace_back(function.name);
            if (word != function.name) continue;
            expect('(');
            Value first = sum();
            if (function.arguments == 1) {
                expect(')');
                return [f = function.of, a = std::move(first)](double x, double y) { return f(a(x, y), 0.0); };
            }
            expect(',');
            Value second = sum();
            expect(')');
            return [f = function.of, a = std::move(first), b = std::move(second)](double x, double y) {
                return f(a(x, y), b(x, y));
            };
        }
        at_ = begin;
        refuse("one of " + joined(names));
    }

    /// A text can nest deeper than the stack holds.
    struct Nesting {
        explicit Nesting(Parser& the_parser) : parser(the_parser) {
            constexpr int most = 200;
            if (++parser.depth_ > most) parser.refuse(text("at most {} levels of nesting", most));
        }
        ~Nesting() { --parser.depth_; }
        Nesting(const Nesting&) = delete;
        Nesting& operator=(const Nesting&) = delete;
        Parser& parser;
    };

    const std::string& written_;
    const SourceLocation& where_;
    std::size_t at_ = 0;
    int depth_ = 0;
};
}  // namespace

Formula::Formula(const std::string& written, const SourceLocation& where)
    : root_(std::make_shared<const Node>(Node{Parser(written, where).whole()})) {}

double Formula::operator()(double x, double y) const { return root_->value(x, y); }

}  // namespace drover
