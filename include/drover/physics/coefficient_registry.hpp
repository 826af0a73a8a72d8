// physics/coefficient_registry.hpp: one row for each coefficient of the equations: key, symbol, unit, range, meaning.
#pragma once
#include <functional>
#include <string>
#include <vector>

#include "drover/base/schema.hpp"
#include "drover/base/variant.hpp"
#include "drover/physics/coefficient.hpp"
#include "drover/physics/model.hpp"

namespace drover::physics {

/// Bit flags for the fields that a coefficient needs.
enum Needs : unsigned {
    needs_bead_density = 1,
    needs_rod_density = 2,
    needs_bead_velocity = 4  ///< dynamic or slaved
};

/// The compiled coefficients that may depend on the densities.
struct Coefficients {
    Coefficient relaxation, saturation, drag, driving, weathercock;
};

/// One coefficient.  The schema, tables, checks, `explain`, manual and bindings are generated from its row.
struct CoefficientRow {
    std::string section, name;  ///< its key is section.name
    std::string symbol;         ///< as in the equations
    std::string unit;
    Range range = any_number;
    std::string doc;           ///< its meaning and its term in the equations
    unsigned needs = 0;        ///< combination of Needs
    int order_power = 0;       ///< the coefficient is multiplied by sigma^order_power when p = P becomes p = sigma P
    double& (*value)(Model&);  ///< accesses its value in a model
    /// Monomials and compiled form; null for coefficients that cannot depend on the densities.
    std::vector<std::string>& (*monomials)(Model&) = nullptr;
    Coefficient Coefficients::*compiled = nullptr;

    std::string key() const { return section + "." + name; }
    bool varies() const { return monomials != nullptr; }
    double value_in(const Model& model) const { return value(const_cast<Model&>(model)); }
    const std::vector<std::string>& monomials_in(const Model& model) const {
        return monomials(const_cast<Model&>(model));
    }
};
using CoefficientRegistry = std::vector<CoefficientRow>;

/// All coefficients, in the order of the scene keys.  To add one, declare its value in physics/coefficients.hpp and
/// add its row here.
const CoefficientRegistry& coefficient_registry();

/// The row of a key.  Throws an input Error if no coefficient has this key.
const CoefficientRow& coefficient_row(const std::string& key);

/// Whether a form has the fields that a coefficient needs.
bool has_fields(const FieldChoice& fields, unsigned needs);

/// One scene key of a model.
struct ModelKey {
    Description description;
    std::function<Value(const Model&)> get;
    std::function<void(Model&, const Value&)> set;
    double& (*number)(Model&) = nullptr;  ///< set if the value is a single number
};
struct ModelSection {
    std::string name, doc;
    std::vector<ModelKey> keys;
};

/// All sections of a model with their keys, in the order in which a scene is written.
std::vector<ModelSection> model_sections(const CoefficientRegistry& registry = coefficient_registry());

/// What a symbol in the equations of a model stands for.
struct CoefficientValue {
    std::string key, symbol;
    Variant<double, std::string> value;
    std::string unit, doc;
};
/// Those that are not 0.
std::vector<CoefficientValue> coefficient_values(const Model& model,
                                                 const CoefficientRegistry& registry = coefficient_registry());

/// The registry as a Markdown table, for the manual.
std::string coefficient_documentation(const CoefficientRegistry& registry = coefficient_registry());

}  // namespace drover::physics
