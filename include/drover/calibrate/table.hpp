// calibrate/table.hpp: coefficients over area fractions: measured, from closures or set, each with its error and where it came from.
#pragma once
#include <optional>
#include <string>
#include <vector>

#include "drover/base/error.hpp"
#include "drover/physics/coefficient_table.hpp"

namespace drover::calibrate {

/// Where a number came from.
enum class Origin {
    refused,         ///< there is none, and a remark says why
    measured,        ///< on particles, as well as was asked
    measured_short,  ///< on particles, less well than was asked: a remark says by how much
    closure,         ///< from measured ones, by a theory of independent rods
    set              ///< by the setup, or zero for want of anything better
};
inline constexpr int origin_count = 5;
/// "refused", "measured", "short", "closure", "set".
const char* origin_name(Origin origin);

/// One coefficient at one point.
struct TableEntry {
    double value = 0.0;  ///< not-a-number when refused
    double error = 0.0;  ///< standard error; 0 for what is set, not-a-number when refused
    int trials = 0;      ///< behind it; of several, the fewest
    Origin origin = Origin::refused;
    std::string remark = {};  ///< a diagnosis, a unmet_target, a refusal; may be empty
};

/// One coefficient over the table.
struct TableRow {
    std::string name, unit, formula;
    bool by_rods = false;           ///< whether it depends on the area fraction of rods
    std::vector<TableEntry> known;  ///< [varied][bead] or [varied][bead][rod], the last fastest
};

struct Table {
    std::string varied_key;              ///< "kick.strength"; "" when nothing else is varied
    std::vector<double> varied{0.0};     ///< its values; one when nothing is varied
    std::vector<double> bead_fractions;  ///< area fractions of beads, ascending
    std::vector<double> rod_fractions;   ///< of rods, ascending; may be empty when no row needs them
    std::vector<TableRow> rows;
};

/// How many numbers a row of this table has.
std::size_t count_of(const Table& table, bool by_rods);
/// Index of a point in a row.
std::size_t place_in(const Table& table, const TableRow& row, std::size_t varied, std::size_t bead, std::size_t rod);
/// "bead area fraction 0.3, rod area fraction 0.05": of one number of a row, for messages.
std::string point_text(const Table& table, bool by_rods, std::size_t place);

/// Index of a value of the varied key; 0 where the table varies none.  Throws an input Error at `where`, which calls it `name`, for a value
/// that is not one of the table's, none where the table varies a key, or one where it varies none.
std::size_t varied_place(const Table& table, const std::optional<double>& value, const std::string& name,
                         const SourceLocation& where);

const TableRow* find_row(const Table& table, const std::string& name);

/// Throws an input Error, at `where`, unless axes ascend within 0 to 1, rows are as long as they must be, numbers finite where they are not
/// refused, and errors not negative.
void check(const Table& table, const SourceLocation& where = {});

/// Adds what follows from the rows that are there, where all it needs is there: Gamma, eta, a/lambda, g = lambda_s alpha/(Gamma D_r); and, for the
/// current p = sigma u P, alpha, lambda and the closures of field_number(), with zeros for w, A, F and zeta, and for E where its assay was
/// not made.  Densities are those of the area fractions.  Errors add in squares to first order, since assays are independent of each other.  Refused where
/// what it divides by lies within 3 errors of zero.  Source: physics as in Kumar et al., Nat. Commun. 5, 4688 (2014), Methods.
void add_derived(Table& table);

/// A number with its standard error.
struct Uncertain {
    double value = 0.0, error = 0.0;
};

/// One coefficient as a smooth function of both area fractions, at one of the varied values.
class SmoothCoefficient {
public:
    /// Throws an input Error that names them when the table has not this coefficient, or has holes in it.
    SmoothCoefficient(const Table& table, const std::string& name, std::size_t varied = 0,
                      physics::Outside outside = physics::Outside::refuse);

    /// Throws an input Error that names the range when a fraction lies outside the table, unless told to hold the value of its edge.
    Uncertain at(double bead_fraction, double rod_fraction) const;

    const physics::CoefficientTable& table() const { return table_; }

private:
    std::string name_;
    std::vector<double> beads_, rods_;
    bool by_rods_;
    physics::Outside outside_;
    physics::CoefficientTable table_;
};

}  // namespace drover::calibrate
