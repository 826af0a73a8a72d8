// physics/compiled_terms.hpp: the terms of a model as they were compiled, and checks of them.
#pragma once
#include <string>
#include <vector>

#include "drover/model/equations.hpp"
#include "physics/compiled_model.hpp"

namespace drover::physics {

struct CompiledTerms {
    const CompiledModel& model;
    const model::Equations& right_sides;
    const std::vector<std::string>& names;  ///< of right_sides.terms(): keys of coefficients, terms[n]

    bool is_of(std::size_t term, const FieldRow& field) const {
        return right_sides.model().fields[right_sides.terms()[term].field].symbol == field.symbol;
    }
    /// The first component of a field, by its symbol; -1: not there.
    int component(const std::string& symbol) const;
};

/// The field whose balance is a nonlinear function of the fields; nullptr: none.
const FieldRow* pointwise_balance(const CompiledTerms& terms);

/// Throws an input Error, with its location, for a text that changes what is conserved, for a balance without drag, for
/// products beside derivatives of its field in one, and for texts that a balance cannot have.
void check_terms(const CompiledTerms& terms, const Locate& locate);

/// Throws an input Error, with its location, for invalid numbers or terms: also for a balance without drag, for
/// products beside derivatives of its field in one, and for texts of a scene that a balance cannot have.
void check(const ModelValues& model, const Locate& locate = no_location);

}  // namespace drover::physics
