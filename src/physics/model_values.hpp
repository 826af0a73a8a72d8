// physics/model_values.hpp: what a scene gives of a model file: numbers and words by key, a table, terms as text.
#pragma once
#include <array>
#include <map>
#include <string>
#include <vector>

#include "numerics/algebra/spline_table.hpp"
#include "physics/coefficient.hpp"
#include "physics/model_file.hpp"
#include "physics/text_term.hpp"

namespace drover::physics {

/// Values of one coefficient at the nodes of a table, rows by the first density; standard errors may be empty.
struct TableColumn {
    std::vector<double> values, errors;
};

/// Measured coefficients on a mesh of densities.  A column replaces the coefficient of the same key.
struct TableData {
    std::array<std::vector<double>, 2> nodes;    ///< of each density, ascending; empty: no dependence
    std::map<std::string, TableColumn> columns;  ///< by key of the coefficient, "relaxation.rate"
    numerics::Outside outside = numerics::Outside::refuse;
    /// The column of a key; empty if the table has no such column.
    const TableColumn& column(const std::string& key) const;
    bool has_values() const;
};

struct ModelValues {
    ModelValues(const ModelFile& of = shipped_model());  ///< with the defaults of the file

    const ModelFile* file;
    std::map<std::string, Value> values;  ///< of all keys that are no lists
    /// Texts of monomials "c rho^i sigma^j" that are added to a coefficient, by its key.
    std::map<std::string, std::vector<std::string>> monomials;
    TableData table;
    std::vector<TextTerm> text_terms;          ///< terms given as text in the scene
    std::map<std::string, double> parameters;  ///< parameters of the text terms, by name
};

/// Of a key, which must have a value of that type.  They throw an input Error for a key that the file does not have.
double number(const ModelValues& model, const std::string& key);
bool flag(const ModelValues& model, const std::string& key);
const std::string& word(const ModelValues& model, const std::string& key);
/// Whether a key has its default.
bool is_standard(const ModelValues& model, const std::string& key);
double& number_in(ModelValues& model, const std::string& key);  ///< to be set
/// Of the coefficient that has several.
void set_convention(ModelValues& model, const std::string& convention);
/// Those of a coefficient; empty for others.
const std::vector<std::string>& monomials_of(const ModelValues& model, const std::string& key);

/// What a field of the file is in a model.
enum class Presence {
    absent,
    balance,  ///< determined at every instant by a balance: not an independent field
    rate
};
constexpr auto names_of(Presence) { return std::array{"absent", "slaved", "dynamic"}; }
Presence presence(const ModelValues& model, const FieldRow& field);
/// By its symbol in equations; absent for a symbol that the file does not have.
Presence presence(const ModelValues& model, const std::string& symbol);
/// Whether a model has all of these fields, by symbol.
bool has_fields(const ModelValues& model, const std::vector<std::string>& symbols);

/// What the source of the file is in a model.
enum class SourceKind { none, uniform, point };
constexpr auto names_of(SourceKind) { return std::array{"none", "uniform", "point"}; }
SourceKind source_kind(const ModelValues& model);

/// The means of the densities, which the equations conserve.
Densities mean_densities(const ModelValues& model);
/// Whether some field has noise.
bool has_noise(const ModelValues& model);
void remove_noise(ModelValues& model);
/// Whether [p] is the unit of a density: the order is a density times the mean orientation.
bool order_is_density(const ModelValues& model);
/// UDUNITS text of a unit of the file that may contain [p].
std::string unit_of(const ModelValues& model, const std::string& unit);
/// Whether a coefficient is given: a number that is not 0, or monomials.
bool is_given(const ModelValues& model, const CoefficientRow& row);
/// Readable name: "two-component", "dilute", "overdamped", "rods only", "polar", or else the list of fields.
std::string form_name(const ModelValues& model);
bool is_named_form(const ModelValues& model);

}  // namespace drover::physics
