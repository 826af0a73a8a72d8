// physics/stability_rows.hpp: names, units and formulas of the results of a stability analysis, and remarks on them.
#pragma once
#include <functional>
#include <string>
#include <vector>

#include "drover/physics/stability.hpp"

namespace drover::physics {

/// One member of EffectiveCoefficients.
struct EffectiveCoefficientRow {
    std::string name, unit, meaning;  ///< unit as UDUNITS text
    double EffectiveCoefficients::*member;
    bool applies = true;  ///< the form has the fields that it needs
};
std::vector<EffectiveCoefficientRow> effective_coefficient_rows(const Form& form);

/// All values of Instability::name.
std::vector<std::string> instability_names();

/// The components of a form, in the order of FieldIndex.
std::vector<Component> components_in_symbol_order(const Form& form);

/// A structure factor of a form, as a function of the structure matrix.
struct StructurePart {
    std::string name, unit;
    std::function<double(const Symbol&)> value;
};
/// `direction`: of p0 [rad].
std::vector<StructurePart> structure_parts(const Form& form, double direction);

/// `count` angular frequencies [1/s], symmetric about 0, up to twice that of the fastest wave of wavenumber q; if no
/// wave propagates, up to twice the slowest rate.
std::vector<double> structure_frequencies(const Equations& equations, const UniformPoint& about, double q,
                                          const std::vector<double>& angles, int count);

/// Properties of the model that the reader of a stability analysis must know.
std::vector<std::string> stability_remarks(const Equations& equations, const EffectiveCoefficients& coefficients);

}  // namespace drover::physics
