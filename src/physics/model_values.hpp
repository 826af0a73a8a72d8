// physics/model_values.hpp: what a scene gives of a model file: numbers and words by key, a table, terms as text or by
// a function of the calling program.
#pragma once
#include <array>
#include <functional>
#include <map>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "drover/model/model.hpp"
#include "numerics/algebra/spline_table.hpp"
#include "physics/model_file.hpp"

namespace drover::physics {

using model::PointArgument;

/// Adds the two components of a term at points.  It calls the function of the program from one thread at a time, and
/// throws what that throws.
using PointFunction =
    std::function<void(std::size_t size, std::span<const PointArgument> arguments, std::span<double* const> out)>;

/// The functions of the calling program by the number of their term, from 1.
using TermFunctions = std::map<std::size_t, std::shared_ptr<const PointFunction>>;

/// An entry of [[terms]] in a scene: a term in the equation of one field.
struct TextTerm {
    /// bead_density or rod_density (d_t of it), bead_velocity (a force per area [mg/(mm s^2)]: a term of m rho d_t v)
    /// or order (d_t p).
    std::string of;
    std::vector<model::Text> value;       ///< one for a density; the x and y components for a vector
    std::vector<model::Text> flux;        ///< alternative to value, densities only: d_t = -div flux
    std::vector<std::string> parameters;  ///< names of its parameters, in Model::parameters
    bool is_explicit = false;             ///< nothing of it is in the exact linear part
    SourceLocation where;

    std::string function;                       ///< name of a function instead of texts; empty: none
    std::vector<std::string> arguments;         ///< of the function: inputs and parameters by name, in their order
    int degree = 0;                             ///< of the function as a polynomial in the fields; 0: not known
    std::string source;                         ///< of the function, for the record
    std::shared_ptr<const PointFunction> call;  ///< nullptr in a program that does not have the function
};

/// Values of the densities of the model file, in its order.
using Densities = std::array<double, 2>;

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
