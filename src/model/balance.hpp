// model/balance.hpp: fields in balance with products, solved at every point.
#pragma once
#include <set>

#include "algebra.hpp"
#include "drover/model/model.hpp"

namespace drover::model {

/// Whether a right side has more than linear terms with constant coefficients and constants.
bool has_products(const Algebra& algebra, const std::vector<Component>& total);

/// The components that a right side reads.
std::set<int> components_of(const Algebra& algebra, const std::vector<Component>& total);

/// The field as an expression of the others, from 0 = total = force - drag * field at every point.  Throws an input
/// Error for a total of another form.  first: the first component of the field.
Value solved_balance(Algebra& algebra, const Field& field, int first, const std::vector<Component>& total);

}  // namespace drover::model
