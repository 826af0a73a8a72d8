// model/symbol.hpp: symbols, uniform states and summaries of the terms of a model.
#pragma once
#include <Eigen/Core>
#include <string>
#include <vector>

#include "drover/base/error.hpp"

// Matrices cross the border between the library and programs.
static_assert(EIGEN_MAX_ALIGN_BYTES == 32,
              "link drover::drover, or define EIGEN_MAX_ALIGN_BYTES=32 as the library does");

namespace drover::model {

/// d/dt of small deviations ~ exp(i q.r) from a uniform state: rates = symbol * deviations, by components.
using Symbol = Eigen::MatrixXcd;

/// Values of all components in a uniform state, in the order of the fields, fields in balance included.
using UniformState = std::vector<double>;

/// Throws an input Error for a state of another number of components, or with values that are not finite.
void check_state(const UniformState& state, std::size_t components);

/// One summand of a right-hand side.
struct TermSummary {
    std::size_t field = 0;
    std::string text;  ///< as written: "- K4 lap lap p"
    SourceLocation where = {};
    bool is_placed = false;              ///< depends on position or time
    bool is_timed = false;               ///< depends on time
    bool is_explicit = false;            ///< by demand: nothing of it is in the exact linear part
    bool is_linear = true;               ///< with constant coefficients
    bool vanishes_when_uniform = false;  ///< in every uniform state
    int degree = 1;                      ///< of its products at points; 1 if it is linear
    bool has_finite_degree = true;       ///< false: it is no polynomial, or depends on position
    std::vector<int> reads = {};         ///< components of which it depends
    std::vector<int> derives = {};       ///< those of which it has a derivative
};

/// Transforms of one evaluation of the explicit part.
struct TransformCount {
    int inverse = 0, forward = 0;  ///< to the grid, and from it
};

}  // namespace drover::model
