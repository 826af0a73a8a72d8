// calibrate/fill_model.hpp: the numbers that a model leaves out, from a table of measured coefficients.
#pragma once
#include <functional>
#include <string>
#include <vector>

#include "calibrate/field_model.hpp"

namespace drover::calibrate {

/// What a table gave to a model: "drag.coefficient", and in words "measured, 3.1 +- 0.2".
struct FilledNumber {
    std::string key, origin;
};

/// Which keys a table is to provide: those that it has, the form has a field for, and `is_given` denies.  With `local`
/// coefficients also "table", the values at all its nodes.
std::vector<std::string> missing_keys(const physics::ModelValues& model, bool local,
                                      const std::function<bool(const std::string& key)>& is_given);

/// Fills these keys of a model.  Throws an input Error for missing values, and for values out of the range of the key.
std::vector<FilledNumber> fill_model(const Table& table, const StatePoint& point, const std::vector<std::string>& keys,
                                     physics::ModelValues& model);

/// The model with these keys filled from tables redrawn within their errors, each with all that follows from it.  A
/// table with a number out of the range of its key is left out, so there may be fewer than `count`.
std::vector<physics::ModelValues> redrawn_models(const Table& table, const StatePoint& point,
                                                 const std::vector<std::string>& keys,
                                                 const physics::ModelValues& model, int count);

/// What the mean field of the table expects.
std::vector<std::string> expected_texts(const Table& table, const StatePoint& point);

}  // namespace drover::calibrate
