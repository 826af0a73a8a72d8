// physics/coefficient_registry.hpp: every coefficient of the equations as one row: key, symbol, unit, range, meaning.
#pragma once
#include <functional>
#include <string>
#include <vector>

#include "drover/base/schema.hpp"
#include "drover/physics/coefficient.hpp"
#include "drover/physics/model.hpp"

namespace drover::physics {

/// The fields that a coefficient needs: bits.
enum Needs : unsigned {
    needs_bead_density = 1,
    needs_rod_density = 2,
    needs_bead_velocity = 4  ///< dynamic or slaved
};

/// The coefficients that may depend on the densities, ready for use.
struct Coefficients {
    Coefficient relaxation, saturation, drag, driving, weathercock;
};

/// One coefficient.  Schema, tables, checks, explain, docs and bindings follow from its row.
struct CoefficientRow {
    std::string section, name;  ///< its key is section.name
    std::string symbol;         ///< in the equations
    std::string unit;
    Range range = any_number;
    std::string doc;           ///< meaning, with its place in the equations
    unsigned needs = 0;        ///< Needs
    int order_power = 0;       ///< of sigma: by which it is multiplied when p = P becomes p = sigma P
    double& (*value)(Model&);  ///< where a model keeps it
    /// Only of coefficients that may depend on the densities: their monomials, and their compiled form.
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

/// All coefficients, in the order of a scene.  To add one: its number in physics/coefficients.hpp and its row here.
const CoefficientRegistry& coefficient_registry();

/// The row of a key; throws an input Error where no coefficient is called so.
const CoefficientRow& coefficient_row(const std::string& key);

/// Whether a form has the fields that a coefficient needs.
bool has_fields(const FieldChoice& fields, unsigned needs);

/// One key of a model, as a scene gives it.
struct ModelKey {
    Description description;
    std::function<Value(const Model&)> get;
    std::function<void(Model&, const Value&)> set;
    double& (*number)(Model&) = nullptr;  ///< of a plain number
};
struct ModelSection {
    std::string name, doc;
    std::vector<ModelKey> keys;
};

/// All sections of a model with their keys, in the order in which a scene is written.
std::vector<ModelSection> model_sections(const CoefficientRegistry& registry = coefficient_registry());

/// A coefficient of a model that is not zero, for people.
struct CoefficientValue {
    std::string key, symbol, value, unit, doc;
};
std::vector<CoefficientValue> coefficient_values(const Model& model,
                                                 const CoefficientRegistry& registry = coefficient_registry());

/// The registry as a table in Markdown, for the manual.
std::string coefficient_documentation(const CoefficientRegistry& registry = coefficient_registry());

}  // namespace drover::physics
