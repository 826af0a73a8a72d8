// physics/stability_rows.hpp: names, units and formulas of the results of a stability analysis, and remarks on them.
#pragma once
#include <functional>
#include <string>
#include <vector>

#include "drover/model/theory.hpp"
#include "drover/physics/uniform_states.hpp"

namespace drover::physics {

/// One member of EffectiveCoefficients.
struct EffectiveCoefficientRow {
    std::string name, unit, meaning;  ///< unit as UDUNITS text
    double EffectiveCoefficients::*member;
    bool applies = true;  ///< the form has the fields that it needs
};
std::vector<EffectiveCoefficientRow> effective_coefficient_rows(const Form& form);

/// A structure factor as a function of the matrix of all components of Equations::forces().
struct StructurePart {
    std::string name, unit;
    std::function<double(const model::Symbol&)> value;
};
/// `direction`: of p0 [rad].
std::vector<StructurePart> structure_parts(const Equations& equations, double direction);

/// Properties of the model that the reader of a stability analysis must know.
std::vector<std::string> stability_remarks(const Equations& equations, const EffectiveCoefficients& coefficients);

}  // namespace drover::physics
