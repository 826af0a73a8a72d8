// base/formula.hpp: formulas as text, with vectors and differential operators, parsed to a tree.
#pragma once
#include <cstddef>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "drover/base/error.hpp"

namespace drover {

/// One node of a parsed formula, with its arguments.
struct Formula {
    enum class Kind {
        number,
        name,
        sum,         ///< each argument with its sign, '+' or '-'
        product,     ///< each argument with its sign, '*' or '/', left to right
        negative,    ///< minus its argument
        power,       ///< base, exponent
        dot,         ///< a.b
        double_dot,  ///< a:b
        norm,        ///< |a|
        call,        ///< name(arguments)
        operation    ///< prefix operator `name` on one argument
    };
    Kind kind = Kind::number;
    std::string name = {};
    double value = 0.0;  ///< of a number
    std::vector<Formula> arguments = {};
    std::size_t at = 0;       ///< index of its first character, or of its operator for power, dot and double_dot
    char sign = '+';          ///< as a part of a sum or product: '+', '-', '*' or '/'
    std::size_t sign_at = 0;  ///< index of that sign, or of the part where the sign is not written
};

/// The names that are not variables.
struct Notation {
    std::function<int(const std::string&)> arguments_of;  ///< number of arguments of a function; 0: no function
    std::function<bool(const std::string&)> is_operator;  ///< prefix operators
};

/// Places and excerpts of one text, for errors.
class FormulaText {
public:
    FormulaText(const std::string& written, const SourceLocation& where) : text_(written), where_(where) {}
    const std::string& text() const { return text_; }
    /// The location of a character; without a column if the text has none.
    SourceLocation location(std::size_t at) const;
    /// Throws an input Error that quotes what is at a character.
    [[noreturn]] void fail(std::size_t at, const std::string& expected) const;
    /// Throws an input Error at a character, with a message after the quoted text.
    [[noreturn]] void fail_with(std::size_t at, const std::string& message) const;
    /// pattern: as of text(), never a text of the user.
    template <class... Values>
    [[noreturn]] void fail_with(std::size_t at, std::string_view pattern, const Values&... values) const {
        fail_with(at, drover::text(pattern, values...));
    }

private:
    const std::string& text_;
    const SourceLocation& where_;
};

/// Parses
///   sum       = product { ("+" | "-") product }
///   product   = signed { ("*" | "/" | juxtaposition) signed }
///   signed    = ("-" | "+") signed | chain
///   chain     = link { ("." | ":") link }
///   link      = operation | atom [ "^" exponent ]
///   operation = operator "(" sum ")" [ "^" exponent ] | operator operation | operator chain
///   exponent  = ("-" | "+") exponent | atom [ "^" exponent ]
///   atom      = number | name | function "(" sum { "," sum } ")" | "|" sum "|" | "(" sum ")"
/// Juxtaposition, before a name, "(" or "|", is a product: "2 x", "3(x + 1)"; "a / b c" is (a / b) c.  "." and ":" bind
/// before it: "b p.p p" is b (p.p) p.  A prefix operator binds to the next chain: "lap lap p", "grad p.p" is
/// grad(p.p); after "." it binds to the next link only, and "p.grad p.q" is rejected as ambiguous, as is "d_x f^2".
/// -x^2 is -(x^2), and x^y^z is x^(y^z).  Numbers are decimal; names are [a-zA-Z_][a-zA-Z0-9_]*.
/// Throws an input Error at the column of the offending character (without a column if where.column is 0), and for more
/// than 10000 characters or 200 levels of nesting.
Formula parse_formula(const FormulaText& text, const Notation& notation);

/// A formula as LaTeX.  `name`: how a variable is written.
std::string latex_of(const Formula& formula, const std::function<std::string(const std::string&)>& name);

/// A name as LaTeX: Greek letters by their names; what follows "_", and digits at its end, as an index: "rho_0" and
/// "rho0" are \rho_{0}, "Gamma" \Gamma.
std::string latex_of_name(const std::string& name);

}  // namespace drover
