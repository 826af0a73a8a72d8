// model/point_degree.hpp: the degree of a function at points, which decides the dealiasing.
#pragma once
#include <functional>
#include <optional>

#include "drover/base/expression.hpp"

namespace drover::model {

struct PointDegree {
    int degree = 1;
    bool is_finite = true;  ///< false: some part is no polynomial of the fields, or depends on the position
};

/// The degree in the atoms, by the largest summand.  The position counts as a factor.  A divisor counts as one with its
/// own degree, and a function that is no polynomial as a product of at least two.  of_result: of a result of a call,
/// nothing for other slots.
PointDegree point_degree(const Expression& expression, const std::function<std::optional<PointDegree>(int)>& of_result);

}  // namespace drover::model
