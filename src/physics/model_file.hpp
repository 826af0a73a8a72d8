// physics/model_file.hpp: a model file: fields and equations whose numbers a scene gives by key, such as rod_bead.toml.
#pragma once
#include <string>
#include <utility>
#include <vector>

#include "drover/base/schema.hpp"
#include "drover/model/model.hpp"

namespace drover::physics {

/// Two texts, of which the first is a name.
using NamedTexts = std::vector<std::pair<std::string, std::string>>;

/// A term of an equation.
struct TermRow {
    std::string key;  ///< of its coefficient, or a name
    std::string formula;
    std::vector<std::string> needs;  ///< symbols of the fields in it
    std::vector<std::string> on;     ///< of a name: keys of which one differs from its default where it is on
};

struct FieldRow {
    std::string symbol, name;
    std::string alias;  ///< its name in [[terms]]
    std::string unit;   ///< UDUNITS text, or "[p]"
    std::string meaning;
    int spin = 0;
    std::string mass;                       ///< a product of coefficients and densities
    std::vector<std::string> mass_factors;  ///< their symbols
    bool conserved = false;
    bool perturbed = false;  ///< its first component is the default of initial.field
    std::string noise;       ///< key of its strength
    std::string present;     ///< key that tells whether it is a field; "": always
    std::string reference;   ///< key of its mean, of a density
    std::string area;        ///< key of the area of one body of a density
    model::Observed observed;
    std::vector<TermRow> terms;

    model::Field as_field() const { return {.name = name, .symbol = symbol, .spin = spin}; }
};

/// One coefficient.  The schema, tables, checks, `explain`, manual and bindings follow from its row.
struct CoefficientRow {
    std::string id;      ///< its key, "relaxation.rate"
    std::string symbol;  ///< as in the equations
    std::string unit;
    Range range = any_number;
    std::string doc;                 ///< its meaning and its term in the equations
    std::vector<std::string> needs;  ///< symbols of the fields without which it has no meaning
    int order_power = 0;     ///< the coefficient is multiplied by sigma^order_power when p = P becomes p = sigma P
    double standard = 0.0;   ///< where a scene does not give it
    bool varies = false;     ///< it may depend on the densities, by monomials or a table
    std::string noise_of;    ///< symbol of the field whose noise has this strength; "": it is none
    std::string factor_key;  ///< key whose word chooses what the number of a scene is multiplied by; "": none
    std::vector<std::pair<std::string, double>> factors = {};  ///< by that word
    std::string lowers, times;  ///< a coefficient that contains minus this one times a density; "": none

    const std::string& key() const { return id; }
    std::string section() const { return id.substr(0, id.find('.')); }
    std::string name() const { return id.substr(id.find('.') + 1); }
};

/// A key of a scene that is no coefficient.
struct KeyRow {
    std::string id;  ///< the key, "current.kind"
    Description description;
    std::string needs;        ///< symbol of the field without which only its default is allowed; "": none
    bool needs_rate = false;  ///< in a balance that field is as good as none

    const std::string& key() const { return id; }
    std::string section() const { return id.substr(0, id.find('.')); }
};

/// A name in the formulas, by the word of a key, or always the same.
struct DefinitionRow {
    std::string name, by;
    NamedTexts formulas;
};

/// The unit [p]: of a density, where a key has this value and the density is a field.
struct OrderUnit {
    std::string density, key, value, unit, otherwise;
};

/// A vector that is uniform or a source at a point: keys kind, x, y, at_x, at_y, velocity_x, velocity_y and width.
struct SourceRow {
    std::string symbol, section;
    std::string unit, point_unit;  ///< of x and y
};

struct ModelFile {
    std::vector<FieldRow> fields;
    std::vector<CoefficientRow> coefficients;
    NamedTexts sections;  ///< of a scene, with what they are about
    std::vector<KeyRow> keys;
    std::vector<DefinitionRow> definitions;
    NamedTexts numbers;                                     ///< names in the formulas, by their keys
    std::vector<std::pair<std::string, NamedTexts>> forms;  ///< names of sets of fields: "rate" or "balance" of each
    OrderUnit order;
    SourceRow source;
};

/// rod_bead.toml.
const ModelFile& shipped_model();
/// The same file, as JSON.
const char* model_file_text();

/// The row of a key.  Throws an input Error if no coefficient has this key.
const CoefficientRow& coefficient_row(const std::string& key, const ModelFile& file = shipped_model());

/// Those with a reference: what coefficients and tables may depend on, at most two.
std::vector<const FieldRow*> densities(const ModelFile& file = shipped_model());

/// The coefficient whose number has several conventions: its factor_key chooses one.  A file has one at most; nullptr:
/// none.
const CoefficientRow* with_conventions(const ModelFile& file = shipped_model());
/// The factor of the word of a key.
double factor_of(const CoefficientRow& row, const std::string& word);

}  // namespace drover::physics
