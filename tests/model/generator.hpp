// tests/model/generator.hpp: random valid models, as text and as trees of components.
#pragma once
#include <optional>
#include <random>
#include <vector>

#include "drover/model/model.hpp"
#include "model/component_tree.hpp"

namespace drover::model {

/// A model with the trees of its equations: of each field its terms, and its mass.
struct RandomModel {
    Model model;
    std::vector<std::vector<Tree>> terms;
    std::vector<std::optional<Tree>> masses;
    bool is_polynomial = true;
    bool is_isotropic = true;
};

/// 1 to 6 fields of spins 0 to 3 and both parities, products up to degree 5.  Means of true scalars must be above 0.
RandomModel random_model(std::mt19937& random);

}  // namespace drover::model
