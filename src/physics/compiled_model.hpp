// physics/compiled_model.hpp: a coefficient of the equations, a constant, a polynomial in the densities, or a table; a
// validated model with its coefficients as functions of the densities.
#pragma once
#include <array>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "drover/base/error.hpp"
#include "numerics/algebra/spline_table.hpp"
#include "physics/model_values.hpp"

namespace drover::physics {

/// "bead density 0.5 to 1.5, rod density 0.01 to 0.1": the densities of a table on which it depends.
std::string range_text(const numerics::SplineTable& table);

/// factor * first^powers[0] * second^powers[1].
struct Monomial {
    double factor = 0.0;
    std::array<int, 2> powers{};
    bool operator==(const Monomial&) const = default;
};

/// "-0.5 rho sigma^2" as a Monomial.  Throws an input Error at `where` with what it expected.
Monomial read_monomial(const std::string& written, const SourceLocation& where);

/// A coefficient as a function of the densities: constant + monomials, or a table.
class Coefficient {
public:
    Coefficient(double constant = 0.0) : constant_(constant) {}
    Coefficient(double constant, std::vector<Monomial> monomials);
    explicit Coefficient(std::shared_ptr<const numerics::SplineTable> table) : table_(std::move(table)) {}

    /// NaN outside a table that does not extrapolate.
    double at(const Densities& densities) const;
    /// Whether the coefficient can be nonzero: it has a nonzero constant, a monomial or a table.
    bool is_active() const { return constant_ != 0.0 || !monomials_.empty() || table_ != nullptr; }
    bool depends_on(std::size_t density) const;
    bool varies() const { return depends_on(0) || depends_on(1); }
    /// Degree of the polynomial.  A table counts as 1, although it has no finite degree.
    int degree() const;
    /// As a formula: "0.5 - 0.1 rho sigma^2"; or "from a table of ...".
    std::string text_of() const;
    const std::shared_ptr<const numerics::SplineTable>& table() const { return table_; }
    bool operator==(const Coefficient&) const = default;  ///< tables are equal if they are shared

private:
    double constant_ = 0.0;
    std::vector<Monomial> monomials_;
    std::shared_ptr<const numerics::SplineTable> table_;
};

/// The input of every term.
struct CompiledModel {
    /// Throws an input Error, with its location, for invalid parameters: a coefficient of an absent field, a malformed
    /// polynomial, an inconsistent table.  Shares the tables of `like` where their data are equal: saves time when many
    /// models differ in few values.
    explicit CompiledModel(const ModelValues& model, const Locate& locate = no_location,
                           const CompiledModel* like = nullptr);

    const Coefficient& coefficient(const std::string& key) const { return coefficients.at(key); }

    ModelValues model;
    std::map<std::string, Coefficient> coefficients;  ///< by key
};

/// Whether the mass of a field is proportional to a density of the file.
bool is_in_mass(const FieldRow& field, const FieldRow& density);
/// The other factors of the mass of a field: coefficients, and densities that are no fields.
double mass_factor(const CompiledModel& model, const FieldRow& field);

/// Throws an input Error if these densities are outside the table of a coefficient.
void require_values(const CompiledModel& model, const Densities& densities);

}  // namespace drover::physics
