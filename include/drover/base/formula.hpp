// base/formula.hpp: formulas of a scene, such as "0.5 * tanh((x - 10) / 2)", as functions.
#pragma once
#include <memory>
#include <string>

#include "drover/base/error.hpp"

namespace drover {

/// A formula in x and y: numbers, + - * / ^, parentheses, pi, and the functions abs, cos, cosh, exp, log, max, min, sin, sinh,
/// sqrt, step (1 above 0, else 0), tan, tanh.  ^ binds to the right and before a minus: -x^2 is -(x^2).
class Formula {
public:
    /// Throws an input Error at `where` that quotes the formula and says which character it could not go on from.
    explicit Formula(const std::string& written, const SourceLocation& where = {});

    double operator()(double x, double y) const;

    struct Node;

private:
    std::shared_ptr<const Node> root_;
};

}  // namespace drover
