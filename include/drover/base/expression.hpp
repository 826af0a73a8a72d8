// base/expression.hpp: expressions written as text in a scene: parsed, differentiated, evaluated by strips.
#pragma once
#include <cstddef>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <vector>

#include "drover/base/error.hpp"

namespace drover {

/// What the names in a text mean.  Each variable has a slot, 0, 1, ...: the index of its value at evaluation.
struct Vocabulary {
    std::map<std::string, int> variables = {};     ///< "rod_density" -> slot
    std::map<std::string, double> constants = {};  ///< besides pi
};

/// A function of the values in the slots: an immutable directed acyclic graph in which each subexpression occurs once,
/// so that derivatives stay of the size of the expression.  Copies share the graph; one that was moved from can only be
/// assigned to or destroyed.
class Expression {
public:
    Expression() : Expression(0.0) {}
    explicit Expression(double constant);

    struct Graph;  // src/base/expression_graph.hpp
    explicit Expression(std::shared_ptr<const Graph> graph) : graph_(std::move(graph)) {}
    const Graph& graph() const { return *graph_; }

private:
    std::shared_ptr<const Graph> graph_;
};

/// Parses
///   sum     = product { ("+" | "-") product }
///   product = signed { ("*" | "/" | juxtaposition) signed }
///   signed  = ("-" | "+") signed | atom [ "^" signed ]
///   atom    = number | name | function "(" arguments ")" | "(" sum ")"
/// Juxtaposition, before a name or "(", is a product: "2 x", "3(x + 1)"; "a / b c" is (a / b) c.  -x^2 is -(x^2), and
/// x^y^z is x^(y^z).  Numbers are decimal; names are [a-zA-Z_][a-zA-Z0-9_]*.  The constant pi and the functions abs,
/// atan, atan2(y, x), cos, cosh, exp, log, max, min, pow, sign (-1, 0 or 1), sin, sinh, sqrt, step (1 above 0, else 0),
/// tan and tanh are built in.  A name before "(" is a call if a function has that name, else a factor.
/// Constants are folded; nothing else is rearranged: evaluate() performs the operations of the text in their order.
/// `where` is the place of the first character of the text.  Throws an input Error at the column of the offending
/// character (without a column if where.column is 0) for anything else, for constants that are infinite or undefined
/// (1/0, log(-1), 1e999), and for more than 10000 characters, 200 levels of nesting or 20000 operations.
Expression parse_expression(const std::string& text, const Vocabulary& vocabulary, const SourceLocation& where = {});

/// The exact derivative by the value in a slot, simplified.  abs has the derivative sign; step and sign have 0, also at
/// the jump; max and min have that of the argument they choose, and of the second one where both are equal.
/// Throws an input Error at `where` if a constant is infinite or the derivative has more than 20000 operations.
Expression derivative(const Expression& expression, int slot, const SourceLocation& where = {});

/// The expression with a constant in the place of a slot, simplified.  Throws an input Error at `where` if a constant
/// part becomes infinite or undefined, such as 1 / W with W = 0.
Expression bind(const Expression& expression, int slot, double value, const SourceLocation& where = {});

// Simplified.
Expression operator+(const Expression& a, const Expression& b);
Expression operator-(const Expression& a, const Expression& b);
Expression operator*(const Expression& a, const Expression& b);

/// The value; infinite or NaN where a quotient, power or function is.  `slots` must reach beyond every slot in use.
double evaluate(const Expression& expression, std::span<const double> slots);
/// Whether the value jumps at `slots`: sign and step have their argument at 0 there, and the values on both sides of it
/// differ.
bool jumps_at(const Expression& expression, std::span<const double> slots);

std::set<int> slots_of(const Expression& expression);

/// Whether the expression simplifies to 0 (0 f is taken as 0, even where f is infinite).
bool is_zero(const Expression& expression);

/// The value of an expression that simplifies to a number.
std::optional<double> constant_value(const Expression& expression);

/// Equal up to rounding, for fewer operations together: like terms of sums are joined, common factors taken out (also
/// those of several expressions, so that they share the other factor), and a divisor of several quotients is inverted
/// once.  Expressions of more than 2000 operations stay as they are.
std::vector<Expression> factored(std::span<const Expression> expressions);

/// Several expressions compiled for evaluation at many points; common subexpressions are evaluated once.  Equal to
/// evaluate() up to rounding: natural powers are products, and sums may be added up in another order; where a constant
/// factor is 0, the product is 0.  Safe to share between threads.
class StripProgram {
public:
    /// Throws an input Error if the expressions have more than 4096 operations.
    explicit StripProgram(std::span<const Expression> outputs);

    /// out[k][i] = value of expression k at point i, for i < size.  slots[s]: the values of slot s at the points, or
    /// nullptr if it is uniform[s] at every point or not used.  Both spans reach beyond every slot in use (uniform may
    /// be empty if no slot in use is uniform).  No out[k] overlaps another array.  Allocates nothing; takes 0.4 MB of
    /// stack.
    void write(std::size_t size, std::span<const double* const> slots, std::span<const double> uniform,
               std::span<double* const> out) const;

    struct Code;  // src/base/strip_program.cpp

private:
    std::shared_ptr<const Code> code_;
};

}  // namespace drover
