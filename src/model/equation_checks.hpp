// model/equation_checks.hpp: what the fields of a model and their right sides must be, and balances that are solved at
// every point.
#pragma once
#include <functional>
#include <set>

#include "model/summands.hpp"

namespace drover::model {

/// Throws an input Error at the place of a field or number that cannot be, whatever the equations.
void check_fields(const Model& model);

/// Throws an input Error where a field that is declared as conserved is no scalar with a rate, or where its summands
/// and their noise are not divergences together.  solenoidal: the first components of divergence-free vectors.
void check_conserved(Algebra& algebra, const Field& field, const std::vector<Summand>& parts,
                     const std::vector<int>& solenoidal);

/// Whether a right side has more than linear terms with constant coefficients and constants.
bool has_products(const Algebra& algebra, const std::vector<Component>& total);

/// The components that a right side reads.
std::set<int> components_of(const Algebra& algebra, const std::vector<Component>& total);

/// The field as an expression of the others, from 0 = total = force - drag * field at every point.  Throws an input
/// Error for a total of another form.  first: the first component of the field.
Value solved_balance(Algebra& algebra, const Field& field, int first, const std::vector<Component>& total);

/// Throws an input Error where a balance leaves a mean of its field free, and products in it have a mean themselves.
/// total: the right side.  solenoidal: as above.
void check_free_mean(Algebra& algebra, const Field& field, const std::vector<Component>& total,
                     const std::function<bool(int component)>& is_in_balance, const std::vector<int>& solenoidal);

}  // namespace drover::model
