// physics/coefficient.hpp: a coefficient of the equations: a constant, a polynomial in the densities, or a table.
#pragma once
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "drover/base/error.hpp"
#include "drover/numerics/spline_table.hpp"

namespace drover::physics {

/// A value and its derivatives with respect to the bead density rho and the rod density sigma.
struct Dependence {
    double value = 0.0;
    double by_beads = 0.0;  ///< d/d rho
    double by_rods = 0.0;   ///< d/d sigma
};

/// "bead density 0.5 to 1.5, rod density 0.01 to 0.1": the densities of a table on which it depends.
std::string range_text(const numerics::SplineTable& table);

/// factor * rho^beads * sigma^rods.
struct Monomial {
    double factor = 0.0;
    int beads = 0, rods = 0;
    bool operator==(const Monomial&) const = default;
};

/// "-0.5 rho sigma^2" as a Monomial.  Throws an input Error at `where` with what it expected.
Monomial read_monomial(const std::string& written, const SourceLocation& where);

/// A coefficient as a function of the bead density rho and the rod density sigma: constant + monomials, or a table.
class Coefficient {
public:
    Coefficient(double constant = 0.0) : constant_(constant) {}
    Coefficient(double constant, std::vector<Monomial> monomials);
    explicit Coefficient(std::shared_ptr<const numerics::SplineTable> table) : table_(std::move(table)) {}

    Dependence at(double bead_density, double rod_density) const;

    /// Whether the coefficient can be nonzero: it has a nonzero constant, a monomial or a table.
    bool is_active() const { return constant_ != 0.0 || !monomials_.empty() || table_ != nullptr; }
    bool depends_on_beads() const;
    bool depends_on_rods() const;
    bool varies() const { return depends_on_beads() || depends_on_rods(); }
    /// Degree of the polynomial.  A table counts as 1, although it has no finite degree.
    int degree() const;

    /// out = value at each point minus `reference`; NaN outside a table that does not extrapolate.  A density pointer
    /// may be null if the coefficient does not depend on that density.
    void evaluate(const double* bead_density, const double* rod_density, double reference, std::span<double> out) const;

    /// Readable form: "0.5 - 0.1 rho sigma^2", or "from a table".
    std::string text_of() const;

    const std::shared_ptr<const numerics::SplineTable>& table() const { return table_; }
    bool operator==(const Coefficient&) const = default;  ///< tables are equal if they are shared

private:
    double constant_ = 0.0;
    std::vector<Monomial> monomials_;
    std::shared_ptr<const numerics::SplineTable> table_;
};

}  // namespace drover::physics
