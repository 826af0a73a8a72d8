// calibrate/table.hpp: tables of coefficients over area fractions, with errors and origins, and drawn anew within
// these.
#pragma once
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "base/constants.hpp"
#include "drover/base/error.hpp"
#include "drover/measure/statistics.hpp"
#include "numerics/algebra/spline_table.hpp"

namespace drover::calibrate {

/// Origin of a number.
enum class Origin {
    missing,         ///< no value; the remark gives the reason
    measured,        ///< on particles, to the requested error
    measured_short,  ///< on particles, with a larger error than requested; the remark says how large
    closure,         ///< from measured coefficients, by the theory of independent rods
    set              ///< by the setup, or zero because nothing determines it
};
constexpr auto names_of(Origin) { return std::array{"missing", "measured", "short", "closure", "set"}; }
inline constexpr int origin_count = 5;

/// Of trials, for errors.
inline constexpr std::size_t resample_count = 400;

/// One coefficient at one point.
struct TableEntry {
    double value = 0.0;  ///< NaN if missing
    double error = 0.0;  ///< standard error; 0 if set, NaN if missing
    int trials = 0;      ///< it rests on; the smallest number if it rests on several measurements
    Origin origin = Origin::missing;
    std::string remark = {};  ///< diagnosis, unmet target or reason why it is missing; may be empty
    /// Of its result in resample_count resamples of its trials, if they are known: those at the same index are the same
    /// for all entries of one assay at one point.
    std::vector<double> ranks = {};
};

/// One without a value, why, and the trials that were made.
inline TableEntry missing(const std::string& why, int trials = 0) {
    return {.value = nan, .error = nan, .trials = trials, .origin = Origin::missing, .remark = why};
}

/// One coefficient over the table.
struct TableRow {
    std::string name, unit, formula;
    bool by_rods = false;             ///< whether it depends on the area fraction of rods
    std::vector<TableEntry> entries;  ///< [varied][bead] or [varied][bead][rod], the last index fastest
};

struct Table {
    std::string varied_key;              ///< such as "kick.strength"; "" if only area fractions vary
    std::vector<double> varied{0.0};     ///< values of that key; one value if it is ""
    std::vector<double> bead_fractions;  ///< area fractions of beads, ascending
    std::vector<double> rod_fractions;   ///< area fractions of rods, ascending; may be empty if no row needs them
    std::vector<TableRow> rows;
};

/// Number of entries of a row of this table.
std::size_t count_of(const Table& table, bool by_rods);
/// Index of an entry of a row.
std::size_t entry_index(const Table& table, const TableRow& row, std::size_t varied, std::size_t bead, std::size_t rod);
/// The point of an entry, for messages: "bead area fraction 0.3, rod area fraction 0.05".
std::string point_text(const Table& table, bool by_rods, std::size_t entry);

/// Index of a value of the varied key; 0 if the table varies no key.  Throws an input Error at `where`, in which the
/// value is called `name`: for a value that is not in the table, for no value if the table varies a key, and for a
/// value if it varies none.
std::size_t varied_index(const Table& table, const std::optional<double>& value, const std::string& name,
                         const SourceLocation& where);

inline const TableRow* find_row(const Table& table, const std::string& name) {
    return measure::find_row(table.rows, name);
}

/// Throws an input Error at `where` unless area fractions ascend between 0 and 1, rows have the right length, entries
/// that are not missing are finite, and errors are not negative.
void check(const Table& table, const SourceLocation& where = {});

/// Adds the rows that follow from the rows of the table, as far as their inputs are present: Gamma, eta, a/lambda, c,
/// g = (lambda_s alpha/Gamma + 2 c sigma)/D_r; for the current p = sigma u P, alpha, lambda and the closures of
/// field_number(), with zeros for A, F and zeta, and for E if it was not measured; and g, b, w and K3 of collisions of
/// pairs.  Densities follow from the area fractions.  An error is half of the distance from 16 to 84 % over
/// redrawn_tables().  An entry is missing if a divisor lies within 3 errors of zero.
/// Source: physics as in Kumar et al., Nat. Commun. 5, 4688 (2014), Methods.
void add_derived(Table& table);
/// The same rows with their values alone.
void add_derived_values(Table& table);

/// Whether a derived entry is missing because another row of the table has no value there.
bool lacks_input(const Table& table, const TableRow& row, std::size_t entry);

/// A number with its standard error.
struct Uncertain {
    double value = 0.0, error = 0.0;
};

/// One coefficient as a smooth function of both area fractions, at one value of the varied key.
class SmoothCoefficient {
public:
    /// Throws an input Error if the table does not have this coefficient, or has missing entries in it.
    SmoothCoefficient(const Table& table, const std::string& name, std::size_t varied = 0,
                      numerics::Outside outside = numerics::Outside::refuse);

    /// Outside the table, throws an input Error that gives the range or, with Outside::hold, returns the value at the
    /// edge.
    Uncertain at(double bead_fraction, double rod_fraction) const;

    const numerics::SplineTable& table() const { return table_; }

private:
    std::string name_;
    std::vector<double> beads_, rods_;
    bool by_rods_;
    numerics::Outside outside_;
    numerics::SplineTable table_;
};

/// Of errors of numbers: half widths are then known to a few per cent also where they are skewed.
inline constexpr int error_draws = 400;

/// Whether others follow from this row, so that what it shares with those of the same trials matters.
bool is_input(const std::string& row);

/// Deviations of an entry in all draws: normal ones, in the order of the resamples of its trials, so that entries of
/// one assay at one point vary together.  Without those, in an order that depends on the row and the entry alone, but
/// for the slopes of lines whose covariance with their constant the table has.
std::vector<double> deviations(const Table& table, const TableRow& row, std::size_t entry, std::size_t count);

/// These rows of the table, as far as it has them, with what values and draws need alone.
Table slim(Table table, const std::vector<std::string>& rows);

/// Tables with these rows, as far as the table has them, drawn anew within their errors; the drawn numbers have none.
/// c follows from the redrawn rows of its assays, which are drawn with it, and varies in addition by what its
/// measurements disagree: a table with more alignment by the flow has less by contacts, since their sum was measured.
/// A response time stays positive: its logarithm is drawn.  An entry has the same draws whatever the other rows are.
void for_redrawn_tables(const Table& table, std::vector<std::string> rows, int count,
                        const std::function<void(Table&)>& visit);
/// The same, all at once.
std::vector<Table> redrawn_tables(const Table& table, std::vector<std::string> rows, int count);

}  // namespace drover::calibrate
