// physics/written_model.hpp: the equations of a model of a model file.
#pragma once
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "drover/model/model.hpp"
#include "physics/compiled_model.hpp"
#include "physics/model_file.hpp"

namespace drover::physics {

/// Which equations are written.
enum class Written {
    right_sides,  ///< as if every mass were 1, and a field in balance had a rate
    solver        ///< with masses and balances
};

/// The equations of a model.  only: names of the terms that are written; nullptr: all.
struct WrittenModel {
    model::Model model;
    std::vector<std::string> terms;  ///< names of the terms of all fields, in the order of the model
};
WrittenModel write_model(const CompiledModel& model, Written as, const std::vector<std::string>* only);

/// What the terms of another model are of those of this one, by key where it is not 1: each term of the file is
/// proportional to its coefficient.  Nothing where more than constant coefficients differ.
std::optional<std::map<std::string, double>> ratios_of_terms(const CompiledModel& model, const CompiledModel& other);

}  // namespace drover::physics
