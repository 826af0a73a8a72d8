// model/field_checks.hpp: what the fields of a model must be, whatever their equations.
#pragma once
#include "drover/model/model.hpp"

namespace drover::model {

/// Throws an input Error at the place of a field or number that cannot be.
void check_fields(const Model& model);

}  // namespace drover::model
